#!/usr/bin/env bash
# Measures whole frames, for docs/performance.md: replaces OUT_DIR/frames_<device>_drawing.csv and
# _drawing_passes.csv, and prints a table of medians in us.
#   benchmark/run_frames.sh TOOL OUT_DIR DEVICE [DATA_DIR]
# TOOL is pelage-scene-benchmark; DEVICE names the files: h200, lavapipe, llvmpipe. A software driver
# gets few strands and frames. Rat Boy takes part if DATA_DIR (../shared/data) has him. Variables:
#   APIS  which APIs, in this order ("vulkan gl")
#   RUNS  of a row at most, while the copies beside it take different times (2)
set -euo pipefail
source "$(dirname "$0")/run_options.sh" frames "$@"
rm -f "${csv%.csv}"_{drawing,drawing_passes}.csv
size=(--frames 60)
case $csv in *lavapipe.csv | *llvmpipe.csv) size=(--small --frames 2 --warm-up 2) ;; esac
for api in ${APIS:-vulkan gl}; do
  "$tool" --csv "$csv" --commit "$commit" --api "$api" --method tiles --runs "${RUNS:-2}" "${size[@]}" \
    --data "$data" --filter draw/alone draw_far/ draw_10x/alone draw_4/ draw_12/ draw_rat_boy
done

printf '\n| | row | picture | simulation | SDFs | shadows | all | bytes of buffers | dB |\n|---|---|---|---|---|---|---|---|---|\n'
names='api row picture_us_median simulation_us_median sdf_us_median shadow_us_median frame_us_median bytes psnr_db'
awk -F, -v names="$names" '
  NR == 1 { for (i = 1; i <= NF; ++i) at[$i] = i; n = split(names, want, " ") }
  NR > 1 { line = "|"; for (i = 1; i <= n; ++i) line = line " " $(at[want[i]]) " |"; print line }
' "${csv%.csv}_drawing.csv"
