#!/usr/bin/env bash
# Draws the results of run_sdf.sh as SVG and PNG: OUT_DIR/sdf_<shape>.*. Needs gnuplot (Debian:
# gnuplot-nox).
#   benchmark/plot_sdf.sh RESULTS.csv OUT_DIR [API [SHAPE]]
set -euo pipefail
csv=$1
out=$2
api=${3:-vulkan}
shape=${4:-body}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$out"

# A file for each method or response, a line for each cell size: time, error or share inside, MiB,
# cells, share of the interior that is unset. Fields in quotes hold commas: cut at the quotes first.
awk -v api="$api" -v shape="$shape" -v dir="$work" '
  BEGIN {
    FS = "\""
    split("classic|classic, tight grid|one axis|three axes|band 4", methods, "|")
    split("classic tight one_axis three_axes band_4", files, " ")
    for (i in methods) fileOf[methods[i]] = files[i]
  }
  NR == 1 { next }
  {
    split($1, head, ","); method = $2; response = $4; split($5, tail, ",")
    # commit api shape triangles cells cell what | us min surface interior signs near near_rms
    # unset far far_rms vertices resolved nodes field_bytes bytes ratio
    if (head[2] != api || head[3] != shape || !(method in fileOf)) next
    if (head[7] == "build") {
      print tail[2], tail[8], tail[15] / 1048576, head[5], tail[9] > dir "/build." fileOf[method]
    } else if (head[7] == "collide_near") {
      name = method ~ /^classic/ ? fileOf[method] : method != "one axis" ? "" : \
        response == "trilinear" ? "trilinear" : response == "closest feature" ? "closest" : ""
      if (name != "")
        print tail[2], 100 - tail[13], tail[15] / 1048576, head[5] > dir "/collide_near." name
      vertices = tail[12]
    }
  }
  END { print vertices > dir "/vertices" }' "$csv"
device=$(awk -F'"' 'NR == 2 { print $(NF - 3) }' "$csv")
cells=$(awk '{ printf "%s%s", sep, $4; sep = ", " }' "$work/build.classic")

for format in svg png; do
  case $format in
    svg) terminal='svg size 1000,860 font "sans,14" background "white"' ;;
    png) terminal='pngcairo size 1000,860 font "sans,11" background "white"' ;;
  esac
  gnuplot -e "dir='$work'" -e "device='$device, $api'" -e "shape='$shape'" -e "cells='$cells'" \
    -e "vertices='$(cat "$work/vertices")'" -e "set terminal $terminal" \
    -e "set output '$out/sdf_$shape.$format'" "$(dirname "$0")/plots/sdf.gp"
done
