#!/usr/bin/env bash
# Measures today's picture against the path-traced truth (tools/truth/, tools/truth.sh) and writes the figures of
# docs/accuracy.md and docs/pictures/accuracy.png. The closed cases take an hour, the rest a few minutes.
#   tools/accuracy.sh [--no-closed-cases]     keeps the figures of the closed cases
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/marked_block.sh

tools/setup.sh jq imagemagick
cmake --preset release >/dev/null
cmake --build --preset release --target nephele_program test_cpu >/dev/null
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
size_of() { [[ $1 == inside ]] && echo 48x27 || echo 80x45; }  # as in tools/truth.sh
scenes=(cloud_front cloud_side cloud_back field_side field_above inside)
methods=(alpha volume exact)
steps=(16 64 512)

render() {  # scene file, name, method, more arguments of render
  local scene=$1 name=$2 method=$3 how
  shift 3
  case $method in
    alpha) how=(--backend alpha) ;;
    *) how=(--backend tiled --blend "$method") ;;
  esac
  build/nephele render --quiet --scene "$scene" --size "$(size_of "${name#sun_}")" \
    --layers "$work/$name.$method.layers.exr" "${how[@]}" "$@"
}
error() {  # test reference channels key
  build/nephele compare "$1" "$2" --channels "$3" | jq ".$4"
}

pictures=()
errors_of_scene() {
  local name=$1 method truth=tools/truth/$1
  local columns=("$truth.png")
  for method in "${methods[@]}"; do
    render "tools/truth/$name.json" "$name" "$method" --out "$work/$name.$method.exr"
    local layers=$work/$name.$method.layers.exr picture=$work/$name.$method.exr
    printf '| %s | %s | %.4f | %+.1f | %.3f | %.4f | %+.1f |\n' "$name" "$method" \
      "$(error "$layers" "${truth}_layers.exr" R,G,B relmse)" \
      "$(error "$layers" "${truth}_layers.exr" R,G,B 'bias * 100')" \
      "$(error "$layers" "${truth}_layers.exr" T rmse)" \
      "$(error "$picture" "$truth.exr" R,G,B relmse)" "$(error "$picture" "$truth.exr" R,G,B 'bias * 100')"
  done
  for method in alpha exact; do
    render "tools/truth/$name.json" "$name" "$method" --out "$work/$name.$method.png"
    columns+=("$work/$name.$method.png")
  done
  convert "${columns[@]}" -scale 240x135! +append "$work/row.$name.png"
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
  render "$scene" "sun_$name" exact
  printf '| %s | %+.1f | %+.1f |\n' "$name" \
    "$(error "$work/sun_$name.exact.layers.exr" "$work/sun_${name}_layers.exr" R,G,B 'bias * 100')" \
    "$(error "$work/$name.exact.layers.exr" "tools/truth/${name}_layers.exr" R,G,B 'bias * 100')"
}

for name in "${scenes[@]}"; do errors_of_scene "$name" >>"$work/errors.txt"; done
for name in "${scenes[@]}"; do marched "$name" >>"$work/marched.txt"; done
for name in cloud_front cloud_side cloud_back; do sun_only "$name" >>"$work/sun.txt"; done
convert "${pictures[@]}" -append docs/pictures/accuracy.png

table() {  # titles, file of the rows
  echo "$1"
  sed 's/[^|]//g; s/|/|---/g; s/---$//' <<<"$1"
  cat "$2"
}

document=docs/accuracy.md
if [[ ${1:-} != --no-closed-cases ]]; then
  build/test_cpu --no-skip --test-case="path tracer study*" >"$work/study.txt"
  grep '^| [0-9]' "$work/study.txt" >"$work/spheres.txt"
  titles="| optical diameter | g | degrees between eye and sun | worst band | its noise | mean square / noise |"
  marked_block "$document" spheres table "$titles" "$work/spheres.txt"
fi
marked_block "$document" "truth set" table "| scene | samples a pixel | noise |" tools/truth/summary.md
titles="| scene | blend | layer relMSE | layer bias % | T RMSE | picture relMSE | picture bias % |"
marked_block "$document" errors table "$titles" "$work/errors.txt"
marked_block "$document" marcher table "| scene | 16 | 64 | 512 |" "$work/marched.txt"
marked_block "$document" "sun alone" table "| scene | sun alone | all light |" "$work/sun.txt"
echo "$document"
