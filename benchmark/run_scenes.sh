#!/usr/bin/env bash
# The scenes that users run, on Vulkan, GL and GLES: replaces OUT_DIR/scenes_<device>.csv and,
# beside it, _passes.csv, _first_frame.csv, _drawing.csv and _drawing_passes.csv.
#   benchmark/run_scenes.sh TOOL OUT_DIR DEVICE [more options of the tool...]
# TOOL is pelage-scene-benchmark; DEVICE names the files: h200, lavapipe, llvmpipe. All rows of an
# API run in one process. Then, in a process each and without any shader cache, the first frames.
# No row and no first frame is begun after its share of SECONDS_MAX (460) is over; what is left out
# is told of. A software driver gets few strands and frames. Variables:
#   APIS        which APIs, in this order ("vulkan gl gles")
#   COLD        substrings of the rows whose first frame is measured; "none" for none of them,
#               "/" for all (the scenes with SDFs and without follow hairs that collide)
#   COLD_APIS   APIs that first frames are measured on ("vulkan gl")
set -euo pipefail
here=$(dirname "$0")
tool=$1
csv=$2/scenes_$3.csv
shift 3
commit=${PELAGE_COMMIT:-$(git -C "$here" describe --always --dirty 2>/dev/null || echo unknown)}
seconds=${SECONDS_MAX:-460}
cold=${COLD:-head_sdf/exact/guides character/exact/guides head_sdf/classic/guides character/classic/guides}
cold_apis=${COLD_APIS:-vulkan gl}

apis=${APIS:-vulkan gl gles}
size=() frames=()
case $csv in
  *lavapipe.csv) apis=${APIS:-vulkan} cold_apis=${COLD_APIS:-vulkan} ;;
  *llvmpipe.csv) apis=${APIS:-gl} cold_apis=${COLD_APIS:-gl} ;;
esac
# The heads begin to move after 12 frames.
case $csv in *lavapipe.csv | *llvmpipe.csv) size=(--small) frames=(--frames 8 --warm-up 16) ;; esac

mkdir -p "$(dirname "$csv")"
rm -f "$csv" "${csv%.csv}"_{passes,first_frame,drawing,drawing_passes}.csv
tool=("$tool" --csv "$csv" --commit "$commit" "${size[@]}")
failed=0

# The rows get three quarters of the time, each API an equal part of the time that is left.
rows_end=$((seconds * 3 / 4))
left=$(wc -w <<<"$apis")
for api in $apis; do
  share=$(((rows_end - SECONDS) / left))
  left=$((left - 1))
  if [ "$share" -le 0 ]; then
    echo "$api: skipped, the time is over"
    continue
  fi
  # A row that a device cannot do is named, and the others go on.
  "${tool[@]}" --api "$api" --seconds "$share" "${frames[@]}" "$@" || failed=1
done

if [ "$cold" = none ]; then exit "$failed"; fi
export __GL_SHADER_DISK_CACHE=0 MESA_SHADER_CACHE_DISABLE=true
printf '\n%-40s%16s\n' 'first frame, no shader cache' 'ms'
for api in $cold_apis; do
  # shellcheck disable=SC2086  # one filter a word
  for row in $("${tool[@]}" --cold --list --filter $cold); do
    if [ "$SECONDS" -ge "$seconds" ]; then
      echo "$api $row: skipped, the time is over"
      continue
    fi
    left=$((seconds - SECONDS))
    if ! ms=$(timeout "$left" "${tool[@]}" --cold --api "$api" --filter "$row"); then
      ms='failed or too slow'
      failed=1
    fi
    printf '%-40s%16s\n' "$api $row" "$ms"
  done
done
exit "$failed"
