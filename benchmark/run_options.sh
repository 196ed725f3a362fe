#!/usr/bin/env bash
# Sourced by run_*.sh as: run_options.sh NAME TOOL OUT_DIR DEVICE [DATA_DIR] ...
# Sets tool, csv, data and commit, and removes the file that the run replaces.
here=$(dirname "${BASH_SOURCE[0]}")
tool=$2
csv=$3/$1_$4.csv
data=${5:-$here/../../shared/data}
commit=${PELAGE_COMMIT:-$(git -C "$here" describe --always --dirty 2>/dev/null || echo unknown)}

mkdir -p "$(dirname "$csv")"
rm -f "$csv"
