#!/usr/bin/env bash
# clang-tidy over the library's sources, with the checks of .clang-tidy.
set -euo pipefail
cd "$(dirname "$0")/.."
git ls-files 'runtime/*.cpp' 'codegen/*.cpp' 'sample/*.cpp' |
  xargs -P "$(nproc)" -n 1 clang-tidy-14 -p build/release --quiet --extra-arg=-Wno-unknown-warning-option 2> >(grep -v 'warnings generated' >&2)
