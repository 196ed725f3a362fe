#!/usr/bin/env bash
# Renders the pictures of docs/viewer.md on a display of its own (Xvfb):
# scripts/viewer_pictures.sh [PELAGE_VIEWER [arguments]].
set -euo pipefail
cd "$(dirname "$0")/.."
tool=$(realpath "${1:-build/release/viewer/pelage-viewer}")
shift || true
out=$(mktemp -d)
Xvfb -displayfd 1 -screen 0 1280x1024x24 > "$out/display" 2> "$out/errors" &
xvfb=$!
trap 'kill "$xvfb" 2> /dev/null || true; rm -rf "$out"' EXIT
until [ -s "$out/display" ]; do
  kill -0 "$xvfb" 2> /dev/null || { cat "$out/errors" >&2; exit 1; }
  sleep 0.1
done
DISPLAY=:$(cat "$out/display")
export DISPLAY
look=(--coarse 1 --strands 1 --shadow deep --transparency windowed)
picture() {  # NAME FRAMES [arguments]: what is on stdin, then a picture at a frame
  local name=$1 frame=$2
  shift 2
  { cat; echo "$frame screenshot $out/$name.png"; } > "$out/$name.txt"
  timeout 200 "$tool" --size 960x640 "${look[@]}" --script "$out/$name.txt" "$@"
  mv "$out/$name.png" "docs/images/$name.png"
}
picture viewer 3 "$@" <<< "0 key ="
picture viewer_settings 3 "$@" <<< "0 key s"
picture viewer_stretch 6 "$@" <<'SCRIPT'
0 key tab
0 key v
SCRIPT
picture viewer_overdraw 5 "$@" <<'SCRIPT'
0 key tab
0 key v
0 key v
0 key v
SCRIPT
picture viewer_slice 5 "$@" <<'SCRIPT'
0 key tab
0 keydown shift
0 key v
0 key v
0 key v
0 keyup shift
SCRIPT
# Half of the guides are simulated, a fifth of the strands is drawn.
echo '{"object": {"simulatedShare": 0.5, "drawnShare": 0.2}}' > "$out/detail.json"
picture viewer_detail 6 --groom straight --settings "$out/detail.json" "$@" <<'SCRIPT'
0 key tab
0 keydown shift
0 key v
0 keyup shift
SCRIPT
picture viewer_statistics 6 "$@" <<< "0 key i"
# A ball is dragged through long hair.
picture viewer_ball 7 --groom straight "$@" <<'SCRIPT'
0 key tab
0 keydown control
0 move 410 300
0 press left
2 move 420 305
3 move 430 310
4 move 440 312
SCRIPT
look=(--coarse 1 --strands 0.5 --shadow none --transparency tiles)
picture viewer_tiles 2 "$@" <<'SCRIPT'
0 key tab
0 key v
0 key v
0 key v
0 key v
SCRIPT
# Without shadows and lists: some frames of long hair, and hair that is drawn twice.
look=(--coarse 1 --strands 0.5 --shadow none --transparency shortcut)
# Time stands still, so that hair does not leave the ball; figures come every 15 frames.
picture viewer_penetration 18 --groom straight "$@" <<'SCRIPT'
0 key tab
0 key v
0 key v
1 key space
1 keydown control
1 move 570 330
1 press left
1 release left
1 keyup control
SCRIPT
picture viewer_sides 6 --groom mohawk --compare classic "$@" <<'SCRIPT'
0 key tab
0 key =
0 key =
SCRIPT
