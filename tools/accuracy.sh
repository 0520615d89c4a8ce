#!/usr/bin/env bash
# Measures today's picture against the path-traced truth (tools/truth/, tools/truth.sh) and writes the figures of
# docs/accuracy.md and docs/pictures/accuracy.png. The closed cases take an hour, errors two minutes, the rest twenty.
#   tools/accuracy.sh [--no-closed-cases]     keeps the figures of the closed cases
#   tools/accuracy.sh --errors                measures particles alone, keeps the marcher's and the sun's figures too
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/marked_block.sh

tools/setup.sh jq imagemagick
cmake --preset release >/dev/null
cmake --build --preset release --target nephele_program test_cpu >/dev/null
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
size_of() { [[ $1 == inside ]] && echo 96x54 || echo 160x90; }  # as in tools/truth.sh
# The last four came after the method; choices were then made with them in view (docs/accuracy.md).
scenes=(cloud_front cloud_side cloud_back field_side field_above inside low_sun overcast congestus dense)
# Ways to draw the layer.
declare -A ways=(
  ["field, exact"]="--backend tiled --blend exact"
  ["tables, exact"]="--backend tiled --blend exact --light tables"
)
order=("field, exact" "tables, exact")
steps=(16 64 512)

render() {  # scene file, size's scene, way, more arguments of render
  # shellcheck disable=SC2086
  build/nephele render --quiet --scene "$1" --size "$(size_of "$2")" ${ways[$3]} "${@:4}"
}
error() {  # test reference channels key
  build/nephele compare "$1" "$2" --channels "$3" | jq ".$4"
}

pictures=()
errors_of_scene() {
  local name=$1 way truth=tools/truth/$1 layers=$work/$1.layers.exr picture=$work/$1.exr
  for way in "${order[@]}"; do
    render "tools/truth/$name.json" "$name" "$way" --layers "$layers" --out "$picture"
    jq -nr --arg name "$name" --arg way "$way" \
      --argjson layer "$(build/nephele compare "$layers" "${truth}_layers.exr" --noise "$truth.exr")" \
      --argjson through "$(error "$layers" "${truth}_layers.exr" T rmse)" \
      --argjson picture "$(build/nephele compare "$picture" "$truth.exr")" '
      def percent: if . == null then "" else . * 1000 | round / 10 | tostring end;
      def share: . * 10000 | round / 10000 | tostring;
      [$name, $way, ($layer.relmse | share), ($layer.noise_relmse | share), ($layer.bias | percent),
       ($layer.thin_bias | percent), ($layer.thick_bias | percent), ($layer.tile_error | percent),
       ($layer.tile_error_p95 | percent), ($through * 1000 | round / 1000), ($picture.relmse | share),
       ($picture.bias | percent)] | "| \(join(" | ")) |"'
  done
}
pictures_of_scene() {
  local name=$1 way columns=("tools/truth/$1.png")
  for way in "field, exact" "tables, exact"; do
    render "tools/truth/$name.json" "$name" "$way" --out "$work/$name.${#columns[@]}.png"
    columns+=("$work/$name.${#columns[@]}.png")
  done
  convert "${columns[@]}" -scale 320x180! +append "$work/row.$name.png"
  pictures+=("$work/row.$name.png")
}

# The ray marcher's layer, for every number of steps.
marched() {
  local name=$1 count layers row="| $1 |"
  for count in "${steps[@]}"; do
    layers=$work/$name.marched.exr
    build/nephele render --quiet --scene "tools/truth/$name.json" --size "$(size_of "$name")" \
      --method raymarch --steps "$count" --layers "$layers"
    row+=$(printf ' %.4f, %+.1f |' "$(error "$layers" "tools/truth/${name}_layers.exr" R,G,B relmse)" \
      "$(error "$layers" "tools/truth/${name}_layers.exr" R,G,B 'bias * 100')")
  done
  echo "$row"
}

# Light of one kind at a time: without air and ground the sun alone is left.
sun_only() {
  local name=$1 scene=$work/sun_$1.json
  jq '.atmosphere.enabled = false | .ground.enabled = false' "tools/truth/$name.json" >"$scene"
  build/nephele reference --quiet --scene "$scene" --size "$(size_of "$name")" --spp 384 --out "$work/sun_$name.exr" \
    --layers "$work/sun_${name}_layers.exr"
  local way row="| $name |"
  for way in "field, exact" "tables, exact"; do
    render "$scene" "$name" "$way" --layers "$work/sun_layers.exr"
    row+=$(printf ' %.4f, %+.1f |' "$(error "$work/sun_layers.exr" "$work/sun_${name}_layers.exr" R,G,B relmse)" \
      "$(error "$work/sun_layers.exr" "$work/sun_${name}_layers.exr" R,G,B 'bias * 100')")
  done
  echo "$row"
}

for name in "${scenes[@]}"; do
  errors_of_scene "$name" >>"$work/errors.txt"
  pictures_of_scene "$name"
done
if [[ ${1:-} != --errors ]]; then
  for name in "${scenes[@]}"; do marched "$name" >>"$work/marched.txt"; done
  for name in cloud_front cloud_side cloud_back; do sun_only "$name" >>"$work/sun.txt"; done
fi
convert "${pictures[@]}" -append docs/pictures/accuracy.png

table() {  # titles, file of the rows
  echo "$1"
  sed 's/[^|]//g; s/|/|---/g; s/---$//' <<<"$1"
  cat "$2"
}

document=docs/accuracy.md
if [[ $# == 0 ]]; then
  build/test_cpu --no-skip --test-case="path tracer study*" >"$work/study.txt"
  grep '^| [0-9]' "$work/study.txt" >"$work/spheres.txt"
  titles="| optical diameter | g | degrees between eye and sun | worst band | its noise | mean square / noise |"
  marked_block "$document" spheres table "$titles" "$work/spheres.txt"
fi
marked_block "$document" "truth set" table "| scene | samples a pixel | noise |" tools/truth/summary.md
titles="| scene | light, blend | layer relMSE | of it noise | bias % | thin % | thick % | tiles % | P95 % | T RMSE \
| picture relMSE | bias % |"
marked_block "$document" errors table "$titles" "$work/errors.txt"
if [[ ${1:-} != --errors ]]; then
  marked_block "$document" marcher table "| scene | 16 | 64 | 512 |" "$work/marched.txt"
  marked_block "$document" "sun alone" table "| scene | field | tables |" "$work/sun.txt"
fi
echo "$document"
