#!/usr/bin/env bash
# Draws the results of run_simulation.sh as SVG and PNG. Needs gnuplot (Debian: gnuplot-nox).
#   benchmark/plot_simulation.sh RESULTS.csv OUT_DIR [API]
# OUT_DIR/simulation_error.*: error against time in the scenes with a reference.
# OUT_DIR/simulation_grooms.*: time against strands, and stretch against time, of moved grooms.
set -euo pipefail
csv=$1
out=$2
api=${3:-vulkan}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$out"

# A file for each scene and solver: time, error, effort, stretch, strands. Vulkan's rows of a groom
# keep all sizes.
awk -F, -v api="$api" -v dir="$work" '
  NR > 1 && $2 == api {
    print $14, $10 == "" ? "nan" : $10, $5, $12, $7, $20 > dir "/" $3 "." $4
  }' "$csv"
# Grooms are compared at 32,640 strands, or at the largest size.
size=$(awk -F, -v api="$api" 'NR > 1 && $2 == api && $3 == "groom" { if ($7 > m) m = $7
  if ($7 == 32640) found = 1 } END { print found ? 32640 : m }' "$csv")
swing=$(awk '{ print $5; exit }' "$work/limp_swing.exact")
static=$(awk '{ print $5; exit }' "$work/helix_sag.exact")
device=$(awk -F'"' 'NR == 2 { print $2 }' "$csv")

for format in svg png; do
  case $format in
    svg) terminal='svg size 1000,760 font "sans,14" background "white"' ;;
    png) terminal='pngcairo size 1000,760 font "sans,11" background "white"' ;;
  esac
  gnuplot -e "dir='$work'" -e "device='$device, $api'" -e "groomSize=$size" -e "swing='$swing'" \
    -e "static='$static'" -e "set terminal $terminal" \
    -e "set output '$out/simulation_error.$format'" "$(dirname "$0")/plots/error.gp"
  gnuplot -e "dir='$work'" -e "device='$device, $api'" -e "groomSize=$size" \
    -e "set terminal ${terminal/760/500}" \
    -e "set output '$out/simulation_grooms.$format'" "$(dirname "$0")/plots/grooms.gp"
done
