#!/usr/bin/env bash
# Exports a scene by Blender and judges the files: blender_export.sh CHECKER [GTEST ARGUMENTS].
# Exits with 77, "skipped", where no Blender is found; PELAGE_BLENDER names another one.
set -euo pipefail
checker=$1
shift
blender=${PELAGE_BLENDER:-blender}
if ! command -v "$blender" > /dev/null; then
  echo "skipped: no '$blender'; scripts/install_packages.sh scripts/packages_tests.txt installs it"
  exit 77
fi
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
# Neither settings nor caches of the user's, so that the result is the same everywhere.
BLENDER_USER_RESOURCES="$out/user" "$blender" -b --factory-startup -noaudio --python-exit-code 1 \
  --python "$(dirname "$0")/export_test.py" -- "$out"
PELAGE_EXPORT_DIR="$out" "$checker" "$@"
