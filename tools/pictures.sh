#!/usr/bin/env bash
# Renders every picture in docs/ again. Arguments go on to `nephele render` (e.g. --quality low for a quick look).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

tools/setup.sh
cmake --preset release
cmake --build --preset release --target nephele_program

for scene in fair_weather broken_deck towering sunset inside_cloud above_deck empty coast \
  mountains mountains_sunset valley_fog; do
  size=960x540
  [[ $scene == fair_weather ]] && size=1280x720
  build/nephele render --scene tools/scenes/$scene.json --size $size --quality high --out docs/pictures/$scene.png "$@"
  echo "docs/pictures/$scene.png"
done
