#!/usr/bin/env bash
# Transparency, time and memory against error: replaces OUT_DIR/transparency_<device>.csv.
#   benchmark/run_oit.sh TOOL OUT_DIR DEVICE [DATA_DIR] [more options of the tool...]
# TOOL is pelage-oit-benchmark; DEVICE names the file: h200, lavapipe, llvmpipe. The mohawk takes
# part where DATA_DIR holds it. What takes little time and memory comes first, because the clocks of a
# GPU that is loaded fall; no more than 8 minutes. A software driver gets small pictures.
set -euo pipefail
source "$(dirname "$0")/run_options.sh" transparency "$@"
shift $(($# < 4 ? $# : 4))
run() { "$tool" --csv "$csv" --commit "$commit" --data "$data" "$@"; }
software=(--sizes 480x270 --guides 200 --frames 2 --together 1 --seconds 240)
case $csv in
  *lavapipe.csv) run --api vulkan "${software[@]}" "$@" ;;
  *llvmpipe.csv) run --api gl "${software[@]}" "$@" ;;
  *)
    run --api vulkan --sizes 1920x1080 --seconds 90 "$@"
    # GL runs the same code: Vulkan has all rows.
    run --api gl --sizes 1920x1080 --scenes mohawk --views close --opacities 0.33 "$@"
    run --api vulkan --sizes 3840x2160 --frames 6 --seconds 110 "$@" ;;
esac
