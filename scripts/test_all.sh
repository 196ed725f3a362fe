#!/usr/bin/env bash
# Run this before a release: scripts/test.sh, and all that takes longer. Without arguments every step runs; else
# those that are named:
#   scripts/test_all.sh sanitizers fuzz
# test             scripts/test.sh
# sources          every source compiled by itself, without the unity build; the libraries as shared ones, and
#                  programs of others against them
# sanitizers       host code under the address and undefined-behavior sanitizers, with leaks: label unit
# sanitizers_gpu   runtimes, kernels' host code and pictures under them, on software drivers; the generator
# fuzz             the fuzzers of loaders, 20,000 inputs each
# analysis         clang-tidy
# stress           long runs, soak, random parameters, determinism; PELAGE_STRESS=full makes it hours
# oracle           references and comparisons with them, at full length
# tiers            the core of the suite on devices of tier base
# benchmarks       every row of the benchmarks with few strands and frames, and their baselines
# viewer           the window under random input, 2 minutes an API
# blender usd      the add-on in Blender, and the USD files by another reader
# webgpu           the kernels as WGSL in Dawn, and the page in Chromium; packages are npm's, too
# package          programs of others against installed libraries; the Debian package in an empty Debian (as root)
# Not among them: `mutants` (scripts/mutants.py, hours).
set -euo pipefail
cd "$(dirname "$0")/.."
[ $# -gt 0 ] || set -- test sources sanitizers sanitizers_gpu fuzz analysis stress oracle tiers benchmarks \
  viewer blender usd webgpu package

for name in "$@"; do
  case "$name" in
    test | sources | sanitizers | sanitizers_gpu | fuzz | analysis | stress | oracle | tiers | \
      benchmarks | viewer | blender | usd | webgpu | package | mutants) ;;
    *)
      echo "pelage: no step '$name'; scripts/test_all.sh lists them in its first lines" >&2
      exit 2
      ;;
  esac
done
source scripts/steps.sh
# A step that fails keeps no other from running.
if [ $# -gt 1 ]; then
  failed=()
  for name in "$@"; do
    names+=("$name")
    starts+=("$SECONDS")
    bash scripts/test_all.sh "$name" || failed+=("$name")
  done
  [ ${#failed[@]} -gt 0 ] || exit 0
  echo "pelage: failed: ${failed[*]}" >&2
  exit 1
fi

# The release build of scripts/test.sh, made here where that step does not run. What a step switches on is
# off in the next one's.
configure_release() {
  bash scripts/install_packages.sh scripts/packages.txt scripts/packages_viewer.txt \
    scripts/packages_tests.txt
  cmake --preset release -DPELAGE_BUILD_TESTS=ON -DPELAGE_BUILD_BENCHMARKS=ON \
    -DPELAGE_WGSL=OFF -DPELAGE_CODEGEN_CACHE="$codegen_cache" "$@" > /dev/null
}
build_release() {
  configure_release "$@"
  cmake --build --preset release --parallel "$jobs"
}
# Kernels of other builds come from the release build's generator, which is all that they need of it.
build_generator() {
  configure_release
  cmake --build --preset release --parallel "$jobs" --target pelage-codegen
}
# Packages of scripts/packages_NAME.txt.
install_more() { bash scripts/install_packages.sh "scripts/packages_$1.txt"; }
# The slow tests of a label.
slow_tests() {
  build_release
  ctest --preset release --parallel "$jobs" -L slow -L "$1"
}
# build_sanitized TARGET [OPTION...]; the generator runs under the sanitizers in its own tests.
build_sanitized() {
  local target=$1
  shift
  build_generator
  cmake --preset asan -DPELAGE_CODEGEN_CACHE="$codegen_cache" \
    -DPELAGE_CODEGEN_EXECUTABLE="$PWD/build/release/codegen/pelage-codegen" "$@" > /dev/null
  cmake --build --preset asan --parallel "$jobs" --target "$target"
}

step "$1"
case "$1" in
  test) bash scripts/test.sh ;;
  sources)
    build_generator
    # Tests need static libraries.
    cmake --preset each -B build/shared -DBUILD_SHARED_LIBS=ON -DPELAGE_BUILD_TESTS=OFF \
      -DPELAGE_BUILD_SAMPLES=OFF -DPELAGE_BUILD_BENCHMARKS=OFF -DPELAGE_BUILD_VIEWER=OFF \
      -DCMAKE_SHARED_LINKER_FLAGS=-Wl,--no-undefined -DPELAGE_CODEGEN_CACHE="$codegen_cache" \
      -DPELAGE_CODEGEN_EXECUTABLE="$PWD/build/release/codegen/pelage-codegen" > /dev/null
    cmake --build build/shared --parallel "$jobs"
    cmake -D BUILD_DIR="$PWD/build/shared" -P tests/consumer/shared_test.cmake
    python3 scripts/tidy.py --compile
    ;;
  sanitizers)
    # The drivers keep caches until the process ends, so leaks are looked for in the tests without them.
    build_sanitized pelage_unit_tests -DPELAGE_UNIT_TESTS_ONLY=ON
    ASAN_OPTIONS=detect_leaks=1 ctest --preset asan -L unit -LE slow --parallel "$jobs"
    ;;
  sanitizers_gpu)
    # GLES has the host code of GL; tests of kernels, samples and tools have the same on every API.
    # Long runs and their pictures are no other code.
    build_sanitized all -DPELAGE_UNIT_TESTS_ONLY=OFF
    ASAN_OPTIONS=detect_leaks=0 ctest --preset asan -L gpu -LE "unit|slow|gles|golden|oracle" \
      --parallel "$jobs"
    ASAN_OPTIONS=detect_leaks=1 ctest --preset asan -L codegen --parallel "$jobs"
    ;;
  fuzz)
    install_more clang
    build_release
    bash scripts/fuzz.sh
    ;;
  analysis)
    install_more clang
    build_release
    python3 scripts/tidy.py
    ;;
  stress | tiers) slow_tests "$1" ;;
  blender | usd)
    install_more "$1"
    slow_tests "$1"
    ;;
  webgpu)
    install_more usd  # Node.js and npm
    install_more web
    configure_release -DPELAGE_WGSL=ON
    cmake --build --preset release --parallel "$jobs" --target pelage_kernels_wgsl \
      pelage_lavapipe_layer pelage_record_scene pelage_web
    ctest --preset release -L webgpu
    ;;
  oracle)
    build_release
    PELAGE_STRESS=full ctest --preset release --parallel "$jobs" -L oracle
    ;;
  benchmarks)
    build_release
    ctest --preset release --parallel "$jobs" -L benchmark
    ;;
  viewer)
    build_release
    printf '%s\n' vulkan gl | PELAGE_STRESS=full xargs -P "$jobs" -I API \
      build/release/tests/viewer/viewer_tests --gtest_filter='*SurvivesRandomInput/API'
    ;;
  package)
    slow_tests package
    bash scripts/test_package.sh
    ;;
  mutants)
    build_release
    python3 scripts/mutants.py
    ;;
esac
