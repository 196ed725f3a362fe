#!/usr/bin/env bash
# Writes docs/parameters.md and renders its pictures:
# scripts/parameter_pictures.sh [PELAGE_PARAMETERS [arguments]].
set -euo pipefail
cd "$(dirname "$0")/.."
tool=${1:-build/release/sample/parameters/pelage-parameters}
shift || true
"$tool" --doc docs/parameters.md --pictures docs/images/parameters "$@"
