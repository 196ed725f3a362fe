#!/usr/bin/env bash
# The main job: installs what is missing, builds the sample, and renders a character that walks, shakes
# its head and jumps.
# Arguments go to the sample: scripts/demo.sh --api gles --asset hair.tfx
set -euo pipefail
cd "$(dirname "$0")/.."
source scripts/steps.sh

build() { cmake --build --preset release --parallel "$jobs" --target pelage_headless; }
# Ninja changes one line on a terminal; elsewhere every 10 s one of its lines is enough.
thin_out() {
  local line next=0
  while IFS= read -r line; do
    if [[ $line != '['* ]]; then
      echo "$line"
    elif ((SECONDS >= next)); then
      printf '%4d s  %s\n' "$SECONDS" "$line"
      next=$((SECONDS + 10))
    fi
  done
}

step "packages"
bash scripts/install_packages.sh
step "configure"
cmake --preset release -DPELAGE_BUILD_TESTS=OFF -DPELAGE_BUILD_BENCHMARKS=OFF \
  -DPELAGE_CODEGEN_CACHE="$codegen_cache" > /dev/null
step "build"
if [ -t 1 ]; then build; else build | thin_out; fi
step "render"
build/release/sample/pelage-headless "$@"
