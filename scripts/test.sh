#!/usr/bin/env bash
# Run this before a commit. It installs missing packages, checks the format, builds once, and runs every
# unit test, every kernel on every API, golden pictures, samples and tools. scripts/test_all.sh has the
# rest: sanitizers, fuzzers, static analysis, stress, benchmarks and other programs. Arguments go to ctest:
#   scripts/test.sh -R contact
set -euo pipefail
cd "$(dirname "$0")/.."
source scripts/steps.sh

step "packages"
bash scripts/install_packages.sh scripts/packages.txt scripts/packages_viewer.txt \
  scripts/packages_tests.txt

step "format"
git ls-files '*.h' '*.cpp' 2>/dev/null | xargs -r clang-format-14 --dry-run --Werror
bash scripts/format_kernels.sh --check

step "build"
cmake --preset release -DPELAGE_BUILD_TESTS=ON -DPELAGE_BUILD_BENCHMARKS=OFF -DPELAGE_WGSL=OFF \
  -DPELAGE_CODEGEN_CACHE="$codegen_cache"
cmake --build --preset release --parallel "$jobs"

step "tests"
ctest --preset release --parallel "$jobs" -LE slow "$@"
