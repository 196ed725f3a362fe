#!/usr/bin/env bash
# Renders AMD's Rat Boy, with his mohawk over his body: scripts/ratboy.sh FOLDER [arguments of
# pelage-headless]. FOLDER has Ratboy_mohawk.tfx, Ratboy_mohawk.tfxbone, Ratboy_body.tfxmesh and
# Ratboy_left_hand.tfxmesh of TressFX 4.1 (MIT license). After scripts/demo.sh has built the sample.
set -euo pipefail
if [ $# -lt 1 ]; then
  echo "usage: scripts/ratboy.sh FOLDER [arguments of pelage-headless]" >&2
  exit 2
fi
folder=$(cd "$1" && pwd)
shift
cd "$(dirname "$0")/.."
settings=$(mktemp --suffix=.json)
trap 'rm -f "$settings"' EXIT
cat > "$settings" << 'END'
{
  "simulation": {"damping": 0.04, "bendLength": 0.3, "globalStiffness": 0.2, "globalRange": 0.4,
                 "vspCoefficient": 0.2},
  "material": {"rootColor": [0.05, 0.012, 0.004], "tipColor": [0.45, 0.12, 0.02],
               "colorVariation": 0.25, "fiberRadius": 1.5e-4, "tipRadiusRatio": 0.15},
  "follow": {"countPerGuide": 16, "maxRadius": 0.006, "flyaways": 0.03}
}
END
build/release/sample/pelage-headless --asset "$folder/Ratboy_mohawk.tfx" \
  --bones "$folder/Ratboy_mohawk.tfxbone" --mesh "$folder/Ratboy_body.tfxmesh" \
  --mesh "$folder/Ratboy_left_hand.tfxmesh" --settings "$settings" --quality full --frames 30 \
  --every 30 --width 512 --height 512 --out out/ratboy "$@"
