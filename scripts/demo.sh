#!/usr/bin/env bash
# The main job: installs what is missing, builds, and renders a character that walks, shakes its
# head and jumps.
# Arguments go to the sample: scripts/demo.sh --api gles --asset hair.tfx
set -euo pipefail
cd "$(dirname "$0")/.."
bash scripts/install_packages.sh
cmake --preset release -DPELAGE_BUILD_TESTS=OFF -DPELAGE_BUILD_BENCHMARKS=OFF
cmake --build --preset release --parallel "$(nproc)" --target pelage_headless
exec build/release/sample/pelage-headless "$@"
