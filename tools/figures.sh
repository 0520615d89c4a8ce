#!/usr/bin/env bash
# Measures the frame on this machine and writes docs/figures.md: variants in turn, medians of three rounds of four frames.
#   tools/figures.sh [--device NAME_OR_INDEX]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

tools/setup.sh jq
cmake --preset release
cmake --build --preset release --target nephele_program
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# All variants in turn, so that a machine that drifts hurts all alike; a figure is the median of the rounds'.
rounds=3
measure() {  # name arguments...
  local name=$1; shift
  build/nephele render --quiet --scene tools/scenes/fair_weather.json --stats "$work/$name.$round.json" --frames 4 --warmup 1 \
    --out "$work/frame-%04d.png" "$@"
}
middle='sort | .[length / 2 | floor]'  # of a jq array
median() { jq -s "map(.frame_ms.median) | $middle" "$work/$1".*.json; }  # name
passes() { jq -rs "[.[].passes[]] | group_by(.name)[] | \"\(.[0].name)\t\(map(.ms) | $middle)\"" "$work/$1".*.json; }  # name
row() {  # name, what it is called
  jq -r --arg what "$2" --argjson ms "$(median "$1")" '"| \($what) | \(.backend), \(.blend) | \(.particles_generated) | \(.particles_visible) | " +
    "\(if .fragments_shaded > 0 then .fragments_shaded else .pairs_shaded end) | \($ms | round) |"' "$work/$1.1.json"
}
layer_ms() {  # name: shading, blending and their lists
  jq -s "map([.passes[] | select(.name | IN(\"shade_blend\", \"screen_tiles\", \"resolve\")).ms] | add) | $middle" "$work/$1".*.json
}
layer_share() { awk -v a="$(layer_ms "$1")" -v b="$(median "$1")" 'BEGIN {printf "%.0f", 100 * (1 - a / b)}'; }  # name: of all else in the frame
layer_ratio() { awk -v a="$(layer_ms "$1")" -v b="$(layer_ms small)" 'BEGIN {printf "%.2f", a / b}'; }  # name
motion_row() {  # name, what it is called
  awk -v what="$2" -v ms="$(median "$1")" -v all="$(median flying_anew)" 'BEGIN {printf "| %s | %.1f | %.2f |\n", what, ms, ms / all}'
}

# The same without wind; and a straight flight to the north, 200 m/s at 60 frames a second.
jq '.clouds.wind_m_per_s = [0, 0]' tools/scenes/fair_weather.json >"$work/still.json"
jq '.camera | {fps: 60, keys: [{time_s: 0, position_m, yaw_deg, pitch_deg, roll_deg: 0},
      {time_s: 1, position_m: [.position_m[0], .position_m[1] + 200, .position_m[2]], yaw_deg, pitch_deg, roll_deg: 0}]}' \
  tools/scenes/fair_weather.json >"$work/flight.json"
motion() { measure "$1" --size 640x360 --quality low --scale 2 --frames 10 "${@:2}"; }

for round in $(seq "$rounds"); do
  measure small --size 640x360 --quality low --scale 2 --backend attachment "$@"
  measure tiled --size 640x360 --quality low --scale 2 --backend tiled "$@"
  measure exact --size 640x360 --quality low --scale 2 --backend tiled --blend exact "$@"
  measure alpha --size 640x360 --quality low --scale 2 --backend alpha "$@"
  motion flying_anew --path "$work/flight.json" "$@"
  motion flying --path "$work/flight.json" --reuse "$@"
  motion windy --reuse "$@"
  motion still --scene "$work/still.json" --reuse "$@"
  measure low --size 1280x720 --quality low "$@"
  measure medium --size 1280x720 --quality medium "$@"
  measure high --size 1280x720 --quality high "$@"
  measure raster --size 1280x720 --quality high --backend attachment "$@"
  measure half --size 1280x720 --quality medium --scale 2 "$@"
done
{
  echo "# Figures of the frame"
  echo
  echo "Written by \`tools/figures.sh\`: scene fair_weather, variants in turn, medians of three rounds of four frames, in"
  echo "milliseconds. Device: $(jq -r '"\(.device), \(.driver)"' "$work/small.1.json"), $(nproc) cores."
  echo "A shared machine is noisy: compare rows of one run, not of two. Shaded: fragments, or pairs of pixel and particle."
  echo
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
  echo
  echo "Shading and blending with their lists, 640x360, low, scale 2: attachment 1, tiled $(layer_ratio tiled) with volume, $(layer_ratio exact) with exact."
  echo "All other passes take $(layer_share medium) % of the frame at 1280x720, medium, and $(layer_share half) % at scale 2 (asked: at most 25): composing, light"
  echo "and the grid do not shrink with the pairs."
  echo
  echo "What a frame does not do again (\`RenderSettings::reuse\`, \`render --reuse\`; bit for bit the same image), 640x360, low,"
  echo "scale 2, the device's own backend, ten frames a round:"
  echo
  echo "| camera | median ms | of the first row |"
  echo "|---|---|---|"
  motion_row flying_anew "flying at 200 m/s, 60 frames/s, everything anew"
  motion_row flying "flying, with reuse"
  motion_row windy "standing, clouds drifting with the wind, with reuse"
  motion_row still "standing, no wind, with reuse"
  echo
  echo "Asked of a quiet machine with two cores: 100 ms at 640x360, 400 ms at 1280x720 medium, and 0.70 of a moving camera's frame for one"
  echo "that stands. In wind every place moves against the camera, so light and order are found anew."
  echo
  echo "Passes of the first row and of the high one (medians; a stamp can lag into the next pass on a software"
  echo "device):"
  echo
  echo "| pass | 640x360 low, scale 2 | 1280x720 high |"
  echo "|---|---|---|"
  join -t $'\t' -a 1 <(passes small | sort) <(passes high | sort) |
    awk -F'\t' '{printf "| %s | %.1f | %.1f |\n", $1, $2, $3}'
} > docs/figures.md
cat docs/figures.md
