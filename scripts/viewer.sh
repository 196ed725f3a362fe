#!/usr/bin/env bash
# A window in which hair moves: installs what is missing, builds pelage-viewer and starts it.
# Arguments go to it: scripts/viewer.sh --api gl hair.tfx
set -euo pipefail
cd "$(dirname "$0")/.."
bash scripts/install_packages.sh scripts/packages.txt scripts/packages_viewer.txt
cmake --preset release -DPELAGE_BUILD_TESTS=OFF -DPELAGE_BUILD_BENCHMARKS=OFF -DPELAGE_BUILD_VIEWER=ON
cmake --build --preset release --parallel "$(nproc)" --target pelage_viewer
exec build/release/viewer/pelage-viewer "$@"
