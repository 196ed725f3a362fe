#!/usr/bin/env bash
# Distance fields, error against time, on Vulkan and GL: replaces OUT_DIR/sdf_<device>.csv.
#   benchmark/run_sdf.sh TOOL OUT_DIR DEVICE [DATA_DIR] [more options of the tool...]
# TOOL is pelage-sdf-benchmark; DEVICE names the file: h200, lavapipe, llvmpipe. Body and hand take
# part where DATA_DIR holds them. A software driver gets little hair and coarse grids.
set -euo pipefail
source "$(dirname "$0")/run_options.sh" sdf "$@"
shift $(($# < 4 ? $# : 4))
run() { "$tool" --csv "$csv" --commit "$commit" --data "$data" "$@"; }
software=(--frames 6 --vertices 32000 --cells 18 25 50)
case $csv in
  *lavapipe.csv) run --api vulkan "${software[@]}" "$@" ;;
  *llvmpipe.csv) run --api gl "${software[@]}" "$@" ;;
  *)
    # GL runs the same code: Vulkan has all rows.
    run --api vulkan "$@"
    run --api gl --shapes body cube --cells 50 "$@" ;;
esac
