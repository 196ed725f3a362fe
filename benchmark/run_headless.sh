#!/usr/bin/env bash
# GPU milliseconds of every pass, on each API, for the mohawk (1 and 15 times its guides, 4 follow
# hairs a guide) when its file is there, else for the generated groom; then for the character as
# pelage-headless shows it. Appends rows to a CSV.
#   benchmark/run_headless.sh BUILD_DIR OUT.csv [DATA_DIR]
set -euo pipefail
build=$1
csv=$2
data=${3:-$(dirname "$0")/../../shared/data}
tool=$build/sample/pelage-headless
commit=${PELAGE_COMMIT:-$(git -C "$(dirname "$0")" describe --always --dirty 2>/dev/null || echo unknown)}

asset=(--scene head)
mohawk=$data/ratboy/Ratboy_mohawk
if [ -f "$mohawk.tfx" ]; then asset=(--asset "$mohawk.tfx" --bones "$mohawk.tfxbone"); fi
for api in vulkan gl gles; do
  for repeat in 1 15; do
    "$tool" --quality full --api "$api" "${asset[@]}" --repeat "$repeat" --follow 4 --frames 240 --quiet \
      --no-images --csv "$csv" --commit "$commit"
    "$tool" --quality full --api "$api" "${asset[@]}" --repeat "$repeat" --follow 4 --frames 60 --every 6 --quiet \
      --width 1920 --height 1080 --supersample 1 --out "$(mktemp -d)" --csv "$csv" --commit "$commit"
  done
  "$tool" --quality full --api "$api" --frames 240 --quiet --no-images --csv "$csv" --commit "$commit"
  "$tool" --quality full --api "$api" --frames 60 --every 6 --quiet --width 1920 --height 1080 --supersample 1 \
    --out "$(mktemp -d)" --csv "$csv" --commit "$commit"
done
