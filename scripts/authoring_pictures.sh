#!/usr/bin/env bash
# Renders the pictures of docs/authoring.md by Blender and by the sample:
# scripts/authoring_pictures.sh [PELAGE_HEADLESS [arguments]].
set -euo pipefail
cd "$(dirname "$0")/.."
tool=${1:-build/release/sample/pelage-headless}
shift || true
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
blender -b --factory-startup -noaudio --python-exit-code 1 \
  --python scripts/authoring_pictures.py -- "$out"
"$tool" --asset "$out/bust.tfx" --bones "$out/bust.tfxbone" --mesh "$out/bust.tfxmesh" \
  --frames 40 --every 40 --quality full --width 320 --height 320 \
  --out "$out" --quiet "$@"
mv "$out/blender.png" docs/images/authoring_blender.png
mv "$out/frame_0040.png" docs/images/authoring_sample.png
