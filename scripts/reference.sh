#!/usr/bin/env bash
# Writes the API reference of the public headers: scripts/reference.sh [FOLDER], build/reference
# without one. A warning is an error.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-build/reference}
mkdir -p "$out"
{ cat docs/Doxyfile; echo "OUTPUT_DIRECTORY = $out"; } | doxygen -
