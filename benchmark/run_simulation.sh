#!/usr/bin/env bash
# Error against time of both solvers and the baselines, on Vulkan and GL: replaces
# OUT_DIR/simulation_<device>.csv. Software drivers get few strands.
#   benchmark/run_simulation.sh TOOL OUT_DIR DEVICE [DATA_DIR] [more options of the tool...]
# TOOL is pelage-simulation-benchmark; DEVICE names the file: h200, lavapipe. The mohawk takes part
# where DATA_DIR holds it, but not on a software driver.
set -euo pipefail
source "$(dirname "$0")/run_options.sh" simulation "$@"
shift $(($# < 4 ? $# : 4))
run() { "$tool" --csv "$csv" --commit "$commit" "$@"; }
case $csv in
  *lavapipe.csv | *llvmpipe.csv)
    run --strands 128 --static-strands 8 --grooms 128 256 "$@" ;;
  *)
    # GL runs the same code: the largest grooms are Vulkan's.
    run --api vulkan --data "$data" "$@"
    run --api gl --data "$data" --grooms 2176 32640 --mohawks 1 "$@" ;;
esac
