#!/usr/bin/env bash
# Measures what distance, ring size and layers cost on this machine and writes the figures of docs/large_world.md and
# its plot. Some five minutes.
#   tools/large_world.sh [DIR]     DIR: of a finished sweep of tools/sweeps/large_world.json, to write from instead
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/marked_block.sh
tools/setup.sh jq gnuplot-nox
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
results=${1:-$work/sweep}
if [[ $# == 0 ]]; then
  cmake --preset release
  cmake --build --preset release --target nephele_program
  build/nephele sweep --config tools/sweeps/large_world.json --out "$results"
fi
json=$results/results.json
[[ -s $json ]] || { echo "large_world: $json is missing; run without arguments" >&2; exit 2; }

device_line() {
  jq -r '"Medians of \(.repetitions) frames; device: \(.identity.device), \(.identity.processors) cores."' "$json"
}
# rows SERIES AXIS TITLE [SHARE]: a table of the variants of a series; SHARE adds a column that has it in each row.
rows() {
  local titles="| $3 | particles | field | light_tiles, occlusion | view_sort | shade_blend |"
  titles+=" frame, ms |"
  local rule="|---|---|---|---|---|---|---|"
  if [[ ${4:-} ]]; then
    titles+=" before shading |"
    rule+="---|"
  fi
  echo "$titles"
  echo "$rule"
  jq -r --arg series "$1" --arg axis "$2" --arg share "${4:+ $4 % |}" '
    def shown: . * 10 | round / 10;
    def ms($names): [.passes[] | select(.name | IN($names[])) | .ms] | add // 0 | shown;
    .variants[] | select(.series == $series) |
    "| \(.axes[$axis] // .settings.quality // "medium") | \(.particles_generated) | \(ms(["field"])) | " +
    "\(ms(["light_tiles", "occlusion"])) | \(ms(["view_sort"])) | " +
    "\(ms(["shade_blend"])) | \(.frame_ms.median | shown) |\($share)"' "$json"
}
share=$(jq -r '
  ["field", "light_tiles", "occlusion", "view_sort"] as $before |
  .variants[] | select(.series == "medium") |
  (.passes | map(select(.name | IN($before[])) | .ms) | add) / .frame_ms.median * 100 | round' "$json")

cp "$results/cost_distance.svg" docs/pictures/cost_distance.svg
document=docs/large_world.md
marked_block "$document" device device_line
marked_block "$document" distance rows distance scene.clouds.view_distance_m "view distance, m"
marked_block "$document" "ring size" rows "ring size" ring_size_cells "cells along a ring"
marked_block "$document" layers rows layers layers "layers"
marked_block "$document" medium rows medium none "quality" "$share"
echo "$document"
