#!/usr/bin/env bash
# Renders the pictures of docs/gallery.md: scripts/gallery.sh [PELAGE_HEADLESS [arguments]].
set -euo pipefail
cd "$(dirname "$0")/.."
tool=${1:-build/release/sample/pelage-headless}
shift || true
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
for groom in parted straight curly fur mohawk; do
  "$tool" --groom "$groom" --frames 30 --every 30 --quality full --width 512 --height 512 \
    --out "$out" --quiet "$@"
  mv "$out/frame_0030.png" "docs/images/gallery_$groom.png"
done
