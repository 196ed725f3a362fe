#!/usr/bin/env bash
# Draws the results of run_oit.sh as SVG and PNG: OUT_DIR/transparency_<scene>_<view>.*. Needs gnuplot
# (Debian: gnuplot-nox).
#   benchmark/plot_oit.sh RESULTS.csv OUT_DIR [SCENE [VIEW [SIZE [API]]]]
# SIZE is WIDTHxHEIGHT; that of the first row when not given.
set -euo pipefail
csv=$1
out=$2
scene=${3:-mohawk}
view=${4:-close}
size=${5:-$(awk -F, 'NR == 2 { print $5 "x" $6 }' "$csv")}
api=${6:-vulkan}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$out"

# A file for each method: time, bytes a pixel, PSNR, opacity. Exact pictures have no finite PSNR.
methods="classic8 windowed hybrid4 hybrid8 hybrid16 shortcut tiles alpha-test stochastic stochastic_x4"
for method in $methods; do echo "NaN NaN NaN NaN" > "$work/$method"; done
awk -F, -v api="$api" -v scene="$scene" -v view="$view" -v size="$size" -v dir="$work" '
  NR == 1 || $2 != api || $3 != scene || $4 != view || $5 "x" $6 != size || $13 == "" { next }
  {
    file = dir "/" $8
    if ($9 > 1) file = file "_x" $9
    bytes = $18 > 0.5 ? $18 : 0.5
    psnr = $10 == "inf" ? 120 : $10
    print $13 + $14, bytes, psnr, $7 > file
    ++rows
  }
  END { if (!rows) { print "no rows of this scene, view and size" > "/dev/stderr"; exit 1 } }' "$csv"
device=$(awk -F'"' 'NR == 2 { print $2 }' "$csv")

for format in svg png; do
  case $format in
    svg) terminal='svg size 1000,560 font "sans,14" background "white"' ;;
    png) terminal='pngcairo size 1000,560 font "sans,11" background "white"' ;;
  esac
  gnuplot -e "dir='$work'" -e "device='$device, $api'" -e "what='$scene, $view, $size'" \
    -e "set terminal $terminal" -e "set output '$out/transparency_${scene}_$view.$format'" \
    "$(dirname "$0")/plots/oit.gp"
done
