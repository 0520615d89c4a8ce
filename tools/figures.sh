#!/usr/bin/env bash
# Measures the frame on this machine and writes the figures of docs/figures.md and docs/light.md: variants in turn,
# medians of three rounds of four frames.
#   tools/figures.sh [--device NAME_OR_INDEX]
#   tools/figures.sh --write DIR     only writes, from statistics in DIR that an earlier run with KEEP=DIR has left
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/marked_block.sh

tools/setup.sh jq
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
work=${KEEP:-$scratch}
scene=tools/scenes/fair_weather.json
rounds=3

# All variants in turn, so that a machine that drifts hurts all alike; a figure is the median of the rounds'.
measure() {  # name arguments...
  local name=$1; shift
  build/nephele render --quiet --scene "$scene" --stats "$work/$name.$round.json" --frames 4 --warmup 1 \
    --out "$scratch/frame-%04d.png" "$@"
}
motion() {  # name arguments...
  measure "$1" --size 640x360 --quality low --scale 2 --frames 10 "${@:2}"
}
measure_all() {
  cmake --preset release
  cmake --build --preset release --target nephele_program
  mkdir -p "$work"
  # The same without wind; and a straight flight to the north, 200 m/s at 60 frames a second.
  jq '.clouds.wind_m_per_s = [0, 0]' "$scene" >"$scratch/still.json"
  jq '.camera | {fps: 60, keys: [
        {time_s: 0, position_m, yaw_deg, pitch_deg, roll_deg: 0},
        {time_s: 1, position_m: [.position_m[0], .position_m[1] + 200, .position_m[2]],
         yaw_deg, pitch_deg, roll_deg: 0}]}' "$scene" >"$scratch/flight.json"
  for round in $(seq "$rounds"); do
    measure small --size 640x360 --quality low --scale 2 --backend attachment "$@"
    measure tiled --size 640x360 --quality low --scale 2 --backend tiled "$@"
    measure exact --size 640x360 --quality low --scale 2 --backend tiled --blend exact "$@"
    measure alpha --size 640x360 --quality low --scale 2 --backend alpha "$@"
    motion flying_anew --path "$scratch/flight.json" "$@"
    motion flying --path "$scratch/flight.json" --reuse "$@"
    motion windy --reuse "$@"
    motion still --scene "$scratch/still.json" --reuse "$@"
    measure low --size 1280x720 --quality low "$@"
    measure medium --size 1280x720 --quality medium "$@"
    measure high --size 1280x720 --quality high "$@"
    measure raster --size 1280x720 --quality high --backend attachment "$@"
    measure half --size 1280x720 --quality medium --scale 2 "$@"
    motion flying_tables --path "$scratch/flight.json" --reuse --light tables "$@"
    motion windy_tables --reuse --light tables "$@"
    for light in field tables; do
      measure "medium_flying_$light" --size 1280x720 --quality medium --frames 10 --path "$scratch/flight.json" \
        --reuse --light "$light" "$@"
      measure "medium_windy_$light" --size 1280x720 --quality medium --frames 10 --reuse --light "$light" "$@"
    done
    for quality in low medium high; do
      measure "solve_$quality" --size 320x180 --quality "$quality" "$@"
      measure "solve_tables_$quality" --size 320x180 --quality "$quality" --light tables "$@"
    done
  done
}
if [[ ${1:-} == --write ]]; then
  work=${2:?--write needs the directory of the statistics}
  [[ -s $work/half.$rounds.json ]] || { echo "figures: $work/half.$rounds.json is missing" >&2; exit 2; }
else
  measure_all "$@"
fi

middle='sort | .[length / 2 | floor]'  # of a jq array
median() {  # name
  jq -s "map(.frame_ms.median) | $middle" "$work/$1".*.json
}
row() {  # name, what it is called
  jq -r --arg what "$2" --argjson ms "$(median "$1")" '
    (if .fragments_shaded > 0 then .fragments_shaded else .pairs_shaded end) as $shaded |
    "| \($what) | \(.backend), \(.blend) | \(.particles_generated) | \(.particles_visible) | " +
    "\($shaded) | \($ms | round) |"' "$work/$1.1.json"
}
layer_ms() {  # name: shading, blending and their lists
  jq -s "map([.passes[] | select(.name | IN(\"shade_blend\", \"screen_tiles\", \"resolve\")).ms] | add) | $middle" \
    "$work/$1".*.json
}
other_share() {  # name: percent of the frame that all other passes take
  awk -v a="$(layer_ms "$1")" -v b="$(median "$1")" 'BEGIN {printf "%.0f", 100 * (1 - a / b)}'
}
layer_ratio() {  # name
  awk -v a="$(layer_ms "$1")" -v b="$(layer_ms small)" 'BEGIN {printf "%.2f", a / b}'
}
motion_row() {  # name, what it is called
  awk -v what="$2" -v ms="$(median "$1")" -v all="$(median flying_anew)" \
    'BEGIN {printf "| %s | %.1f | %.2f |\n", what, ms, ms / all}'
}
passes() {  # name: a line "pass <tab> median ms" for each pass, by name
  jq -rs "[.[].passes[]] | group_by(.name)[] | \"\(.[0].name)\t\(map(.ms) | $middle)\"" "$work/$1".*.json | sort
}

device_line() {
  jq -r --arg cores "$(nproc)" '"Device: \(.device), \(.driver), \($cores) cores."' "$work/small.1.json"
}
image_rows() {
  echo "| image | backend, blend | particles | visible | shaded | median ms |"
  echo "|---|---|---|---|---|---|"
  row small "640x360, low, scale 2"
  row tiled "640x360, low, scale 2"
  row exact "640x360, low, scale 2"
  row alpha "640x360, low, scale 2"
  row low "1280x720, low"
  row medium "1280x720, medium"
  row high "1280x720, high"
  row raster "1280x720, high"
  row half "1280x720, medium, scale 2"
}
layer_rows() {
  local tiled exact medium half
  tiled=$(layer_ratio tiled)
  exact=$(layer_ratio exact)
  medium=$(other_share medium)
  half=$(other_share half)
  echo "| tiled, volume | tiled, exact | other passes at 1280x720, medium | the same at scale 2 |"
  echo "|---|---|---|---|"
  echo "| $tiled | $exact | $medium % | $half % |"
}
reuse_rows() {
  echo "| camera | median ms | of the first row |"
  echo "|---|---|---|"
  motion_row flying_anew "flying at 200 m/s, 60 frames/s, everything anew"
  motion_row flying "flying, with reuse"
  motion_row windy "standing, clouds drifting with the wind, with reuse"
  motion_row still "standing, no wind, with reuse"
}
pass_rows() {
  passes small >"$scratch/small"
  passes high >"$scratch/high"
  echo "| pass | 640x360 low, scale 2 | 1280x720 high |"
  echo "|---|---|---|"
  join -t $'\t' -a 1 "$scratch/small" "$scratch/high" | awk -F'\t' '{printf "| %s | %.1f | %.1f |\n", $1, $2, $3}'
}

frame_of() {  # name: median and 95th percentile
  jq -rs "[(map(.frame_ms.median) | $middle), (map(.frame_ms.p95) | $middle)] | map(round | tostring) | join(\", \")" \
    "$work/$1".*.json
}
light_rows() {
  echo "| image | light | flying | standing in wind |"
  echo "|---|---|---|---|"
  echo "| 640x360, low, scale 2 | field | $(frame_of flying) | $(frame_of windy) |"
  echo "| 640x360, low, scale 2 | tables | $(frame_of flying_tables) | $(frame_of windy_tables) |"
  for light in field tables; do
    echo "| 1280x720, medium | $light | $(frame_of "medium_flying_$light") | $(frame_of "medium_windy_$light") |"
  done
}
memory_mb() { jq '.gpu_memory_bytes / 1e6 | round' "$work/$1.1.json"; }
solve_rows() {
  echo "| quality | all windows from zero, ms | for the way to the camera, ms | memory, MB | the same by tables, MB |"
  echo "|---|---|---|---|---|"
  for quality in low medium high; do
    local solve project
    solve=$(passes "solve_$quality" | awk -F'\t' '$1 == "light_field" {printf "%.0f", $2}')
    project=$(passes "solve_$quality" | awk -F'\t' '$1 == "light_project" {printf "%.1f", $2}')
    echo "| $quality | $solve | $project | $(memory_mb "solve_$quality") | $(memory_mb "solve_tables_$quality") |"
  done
}

document=docs/figures.md
marked_block "$document" device device_line
marked_block "$document" images image_rows
marked_block "$document" layer layer_rows
marked_block "$document" reuse reuse_rows
marked_block "$document" passes pass_rows
marked_block docs/light.md frames light_rows
marked_block docs/light.md solve solve_rows
cat "$document" docs/light.md
