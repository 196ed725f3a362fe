#!/usr/bin/env bash
# Imports caches of a program by Blender: blender_import.sh WRITER. Exits with 77, "skipped", where no
# Blender is found, or its Python has no zstandard; PELAGE_BLENDER names another one.
set -euo pipefail
writer=$1
blender=${PELAGE_BLENDER:-blender}
if ! command -v "$blender" > /dev/null; then
  echo "skipped: no '$blender'; scripts/install_packages.sh scripts/packages_tests.txt installs it"
  exit 77
fi
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
run() { BLENDER_USER_RESOURCES="$out/user" "$blender" -b --factory-startup -noaudio \
  --python-exit-code 1 "$@"; }
if ! run --python-expr 'import zstandard' > /dev/null 2>&1; then
  echo "skipped: Blender's Python has no zstandard (Debian's package python3-zstandard)"
  exit 77
fi
"$writer" "$out"
run --python "$(dirname "$0")/import_test.py" -- "$out"
