#!/usr/bin/env bash
# Formats all HLSL with kernels/.clang-format; with --check, fails at the first file that differs.
# clang-format reads C++: attributes pass as comments, and semantics as parts of names, of the same length.
set -euo pipefail
cd "$(dirname "$0")/.."
text=$(mktemp)
trap 'rm -f "$text"' EXIT

# The generator's fixtures are wrong on purpose, and tests name their lines.
git ls-files '*.hlsl' '*.hlsli' ':!tests/codegen/fixtures' | while read -r file; do
  sed -E 's,^( *)\[(.*)\]$,\1//[\2],; s/([a-z0-9]) : ([A-Z])/\1___\2/g' "$file" |
    clang-format-14 --style=file --assume-filename=kernels/hlsl.cpp |
    sed -E 's,^( *)//\[(.*)\]$,\1[\2],; s/([a-z0-9])___([A-Z])/\1 : \2/g' > "$text"
  if cmp -s "$text" "$file"; then continue; fi
  if [ "${1:-}" = --check ]; then
    diff -u "$file" "$text"
  fi
  cp "$text" "$file"
done
