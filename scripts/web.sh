#!/usr/bin/env bash
# Builds the page (docs/webgpu.md) as static files in build/release/web/site, for any web server:
#   bash scripts/web.sh
#   python3 -m http.server --directory build/release/web/site
# Installs the Debian packages that are missing (as root).
set -euo pipefail
cd "$(dirname "$0")/.."
source scripts/steps.sh
bash scripts/install_packages.sh scripts/packages.txt scripts/packages_usd.txt scripts/packages_web.txt
cmake --preset release -DPELAGE_WGSL=ON -DPELAGE_BUILD_TESTS=OFF -DPELAGE_BUILD_BENCHMARKS=OFF \
  -DPELAGE_CODEGEN_CACHE="$codegen_cache" > /dev/null
cmake --build --preset release --parallel "$jobs" --target pelage_web
