#!/usr/bin/env bash
# clang-tidy over the library's sources, with the checks of .clang-tidy: scripts/tidy.sh [--analyze].
# With --analyze the static analyzer runs, too, which takes as long as all other checks. Each file is
# compiled without precompiled headers, so that one that lacks an #include is found.
set -euo pipefail
cd "$(dirname "$0")/.."
checks=(--checks=-clang-analyzer-*)
if [ "${1:-}" = --analyze ]; then checks=(); fi
mkdir -p build/tidy
sed -E 's/ -Winvalid-pch -include [^ ]*cmake_pch\.hxx//' build/release/compile_commands.json \
  > build/tidy/compile_commands.json
git ls-files 'runtime/*.cpp' 'codegen/*.cpp' 'sample/*.cpp' |
  xargs -P "$(nproc)" -n 1 clang-tidy-14 -p build/tidy --quiet "${checks[@]}" \
    --header-filter="^$PWD/(include|runtime|codegen|sample)/" --extra-arg=-Wno-unknown-warning-option 2> >(grep -v 'warnings generated' >&2)
