#!/usr/bin/env bash
# Reads the .usda files of a program by npm's tinyusdz: usd.sh PROGRAM. Exits with 77, "skipped",
# where Node.js, npm or the package is missing.
set -euo pipefail
writer=$1
here=$(cd "$(dirname "$0")" && pwd)
for program in node npm; do
  if ! command -v "$program" > /dev/null; then
    echo "skipped: no '$program'; scripts/install_packages.sh scripts/packages_tests.txt installs it"
    exit 77
  fi
done
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
cp "$here"/package.json "$here"/package-lock.json "$here"/read_usd.mjs "$out"
if ! (cd "$out" && npm ci --ignore-scripts --no-audit --no-fund --silent); then
  echo "skipped: npm cannot install tinyusdz; is there a network?"
  exit 77
fi
"$writer" "$out"
node "$out/read_usd.mjs" "$out"
