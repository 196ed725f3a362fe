#!/usr/bin/env bash
# All tests: installs what is missing, then format, release and sanitizer builds with their tests,
# and static analysis. The times of the steps come at the end.
set -euo pipefail
cd "$(dirname "$0")/.."

names=() starts=()
step() {
  printf '\n=== %s (%d s)\n' "$1" "$SECONDS"
  names+=("$1")
  starts+=("$SECONDS")
}
times() {
  local i
  for ((i = 0; i + 1 < ${#names[@]}; ++i)); do
    printf '%6d s  %s\n' $((starts[i + 1] - starts[i])) "${names[i]}"
  done
  printf '%6d s  in all\n' "$SECONDS"
}

# A driver or validation layer that is missing is a failure here, and no reason to skip.
export PELAGE_REQUIRE_DEVICES=1

step "packages"
bash scripts/install_packages.sh scripts/packages.txt scripts/packages_viewer.txt \
  scripts/packages_tests.txt

step "format"
git ls-files '*.h' '*.cpp' 2>/dev/null | xargs -r clang-format-14 --dry-run --Werror

step "release build"
cache="$PWD/build/codegen_cache"
cmake --preset release -DPELAGE_BUILD_TESTS=ON -DPELAGE_BUILD_BENCHMARKS=ON \
  -DPELAGE_CODEGEN_CACHE="$cache"
cmake --build --preset release --parallel "$(nproc)"
step "release tests"
ctest --preset release --parallel "$(nproc)"

step "sanitizer build"
# The kernels are the same; the tool itself runs under the sanitizers in its own tests.
cmake --preset asan -DPELAGE_CODEGEN_CACHE="$cache" \
  -DPELAGE_CODEGEN_EXECUTABLE="$PWD/build/release/codegen/pelage-codegen"
cmake --build --preset asan --parallel "$(nproc)"
step "sanitizer tests"
# The drivers keep caches until the process ends, so leaks are looked for in the tests without them.
ASAN_OPTIONS=detect_leaks=1 ctest --preset asan -L unit --parallel "$(nproc)"
# What the sanitizers look at is host code. GLES has that of GL, and tests of kernels, samples and
# tools have the same on every API: of their parameters they take Vulkan, the others GL as well. Long
# runs and their pictures are no other code. The window's program draws for minutes there.
ASAN_OPTIONS=detect_leaks=0 GTEST_FILTER='-*/gl*' ctest --preset asan -L "kernel|golden" \
  -LE "unit|oracle|stress" -E "^(golden|viewer)_test" --parallel "$(nproc)"
ASAN_OPTIONS=detect_leaks=0 GTEST_FILTER='-*/gles*' ctest --preset asan \
  -LE "unit|oracle|kernel|golden" \
  -E "^(stress_(determinism|long_run|sdf)_test|(scene|drawing)_benchmark_gl)" --parallel "$(nproc)"

step "fuzzers"
bash scripts/fuzz.sh

step "static analysis"
python3 scripts/tidy.py

step "done"
times
