#!/usr/bin/env bash
# Makes the Debian package build/package/libpelage-dev_*.deb: package.sh [OPTIONS OF CMAKE...], with
# PELAGE_CODEGEN_CACHE for one.
set -euo pipefail
cd "$(dirname "$0")/.."
bash scripts/install_packages.sh
# The time that the changelog and the files of the package have.
if [ -z "${SOURCE_DATE_EPOCH:-}" ] && time=$(git log -1 --format=%ct 2>/dev/null); then
  export SOURCE_DATE_EPOCH=$time
fi
cmake -S . -B build/package -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX=/usr \
  -DCMAKE_INSTALL_DOCDIR=share/doc/libpelage-dev -DPELAGE_CODEGEN_CACHE="$PWD/build/codegen_cache" \
  -DPELAGE_BUILD_TESTS=OFF -DPELAGE_BUILD_SAMPLES=OFF -DPELAGE_BUILD_BENCHMARKS=OFF \
  -DPELAGE_BUILD_VIEWER=OFF \
  -DPELAGE_SHARED=OFF -DPELAGE_C_SHARED=OFF "$@"
cmake --build build/package --parallel "$(nproc)"
rm -f build/package/*.deb
umask 022
cpack --config build/package/CPackConfig.cmake -B build/package
if command -v lintian >/dev/null; then
  lintian --fail-on warning --allow-root build/package/*.deb
fi
