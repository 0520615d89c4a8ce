#!/usr/bin/env bash
# Measures nephele fly on this machine, on an X server without a screen, and writes the figures and pictures of
# docs/flying.md.
#   tools/flying.sh [--minutes N] [--device NAME_OR_INDEX]
# N: of random input, 10 without; 0 leaves it out
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/marked_block.sh

minutes=10
if [[ ${1:-} == --minutes ]]; then
  minutes=${2:?--minutes needs a number}
  shift 2
fi
tools/setup.sh xvfb openbox jq imagemagick
cmake --preset release
cmake --build --preset release --target nephele_program

scratch=$(mktemp -d)
Xvfb -displayfd 3 -noreset -screen 0 1600x1000x24 3>"$scratch/display" 2>/dev/null &
server=$!
manager=
finish() {
  [[ -n $manager ]] && kill "$manager" 2>/dev/null
  kill "$server" 2>/dev/null
  rm -rf "$scratch"
}
trap finish EXIT
for _ in $(seq 50); do
  [[ -s $scratch/display ]] && break
  sleep 0.1
done
DISPLAY=:$(cat "$scratch/display")
export DISPLAY
openbox --sm-disable 2>/dev/null &  # minimising needs a window manager
manager=$!

scene=tools/scenes/fair_weather.json
fly() {  # name arguments...
  local name=$1; shift
  build/nephele fly --scene "$scene" --script "$scratch/$name.json" --stats "$scratch/$name.stats.json" \
    --out "$scratch" "$@"
}

# Straight on, at 50 m/s times the 1.25 of each notch, with the panel open; then without a change, once speed and
# resolution have settled.
jq -n '{steps: [{actions: ["panel"], wheel: 6.2, move: [0, 1, 0], frames: 60}, {move: [0, 1, 0], frames: 100}]}' |
  tee "$scratch/straight.json" >"$scratch/held.json"
fly straight --size 640x360 --quality low --scale 2 --frame-ms 0 "$@"
fly held --size 640x360 --quality low --scale 2 --frame-ms 90 "$@"

# Every change that the panel makes on the next frame, flying on, each in a step of its own with time to settle.
jq -n '[{scene: {"exposure_ev": 1}}, {scene: {"sun.irradiance": [1, 0.9, 0.8]}}, {scene: {"sun.azimuth_deg": 250}},
        {scene: {"sun.elevation_deg": 15}}, {scene: {"ground.albedo": [0.2, 0.2, 0.2]}},
        {scene: {"ground.enabled": false}}, {scene: {"atmosphere.enabled": false}},
        {scene: {"clouds.extinction_per_m": 0.08}}, {scene: {"clouds.base_m": 1500}},
        {scene: {"clouds.thickness_m": 1200}}, {scene: {"clouds.coverage": 0.35}}, {scene: {"clouds.seed": 7}},
        {scene: {"clouds.wind_m_per_s": [12, 0]}}, {settings: {scale: 4}}, {settings: {light_sweeps: 8}},
        {scene: {"clouds.growth_period_s": 600}}]' >"$scratch/changes.json"
jq '{steps: ([{actions: ["panel"], move: [0, 1, 0], wheel: 6.2, frames: 20}, {move: [0, 1, 0], frames: 20}] +
    (map([. + {move: [0, 1, 0], frames: 4}, {move: [0, 1, 0], frames: 6}]) | add))}' \
  "$scratch/changes.json" >"$scratch/stalls.json"
fly stalls --size 640x360 --quality low --scale 2 --frame-ms 0 "$@"

jq -rn --slurpfile all "$scratch/straight.stats.json" --slurpfile held "$scratch/held.stats.json" '
  def row(name; value): "| \(name) | \($all[0] | value) | \($held[0] | value) |";
  def steady: .steps | map(select(.step == 1))[0].median_ms;
  "| | all pixels | held |", "|---|---|---|",
  row("window after the command, s"; .window_ms / 100 | round / 10),
  row("first picture, tables cached, s"; .first_picture_ms / 100 | round / 10),
  row("median frame, ms"; steady | round),
  row("frames a second"; 10000 / steady | round / 10),
  row("panel, median ms"; .panel_ms.median * 100 | round / 100)' >"$scratch/flying.md"
marked_block docs/flying.md flying cat "$scratch/flying.md"

jq -r --slurpfile changes "$scratch/changes.json" '
  (.steps | map(select(.step == 1))[0].median_ms) as $median |
  "| change | slowest frame / median |\n|---|---|\n" +
  ([range($changes[0] | length) as $i | (.steps | map(select(.step == 2 + 2 * $i))[0].max_ms) as $max |
    ($changes[0][$i] | (.scene // .settings) | to_entries[0]) as $change |
    "| `\($change.key)` to \($change.value | tostring) | \(100 * $max / $median | round / 100) |"] | join("\n"))' \
  "$scratch/stalls.stats.json" >"$scratch/stalls.md"
marked_block docs/flying.md stalls cat "$scratch/stalls.md"

# Pictures of the window in three states: a script saves a file once it is there, and rests.
window_picture() {  # name seconds first-step arguments...
  jq -n --argjson first "$3" --arg mark "$scratch/$1.mark.json" \
    '{frame_s: 0.033, steps: [$first, {frames: 1, save: $mark}, {frames: 1000000}]}' >"$scratch/$1.json"
  build/nephele fly --scene "$scene" --script "$scratch/$1.json" --out "$scratch" --size 1280x720 --quality medium \
    --frame-ms 0 "${@:4}" &
  local program=$!
  while [[ ! -e $scratch/$1.mark.json ]]; do
    kill -0 "$program" || return 1
    sleep 0.2
  done
  sleep "$2"
  import -window Nephele "$scratch/$1.png"
  convert "$scratch/$1.png" -strip "docs/pictures/$1.png"
  kill "$program"
  wait "$program" || true
}
window_picture fly_panel 1 '{"actions": ["panel"], "frames": 3}' "$@"
window_picture fly_mountains 1 '{"actions": ["help"], "frames": 3}' --scene tools/scenes/mountains.json "$@"
window_picture fly_truth 150 '{"actions": ["truth"], "frames": 10}' --scene tools/scenes/towering.json "$@"

# Random input, seeded: by awk, because jq has no random numbers.
soak_script() {  # minutes, at some six frames a second
  awk -v frames="$(($1 * 60 * 6))" -v last="$scratch/soak.exr" -v save="$scratch/soak_scene.json" '
    function unit() { return 2 * rand() - 1 }
    function pick(n) { return int(rand() * n) }
    BEGIN {
      srand(17)
      printf "{\"frame_s\": 0.0833, \"steps\": [{\"actions\": [\"pause\", \"panel\"]}"
      for (done = 0; done < frames; done += n) {
        n = 1 + pick(12)
        printf ",\n{\"frames\": %d, \"move\": [%.3f, %.3f, %.3f], \"look_px\": [%.1f, %.1f], \"roll\": %.2f, " \
               "\"wheel\": %d",
               n, unit(), unit(), unit(), 4 * unit(), 2 * unit(), unit(), pick(3) - 1
        kind = pick(14)
        if (kind == 0) printf ", \"size\": [%d, %d]", 200 + 8 * pick(60), 120 + 8 * pick(40)
        if (kind == 1) printf ", \"settings\": {\"quality\": \"%s\", \"ring_size_cells\": %d}",
                              pick(2) ? "low" : "medium", 40 + 8 * pick(4)
        if (kind == 2) printf ", \"settings\": {\"scale\": %d, \"detail\": %s}", 2 ^ pick(3), pick(2) ? "true" : "false"
        if (kind == 3) printf ", \"settings\": {\"backend\": \"tiled\", \"blend\": \"%s\"}",
                              pick(2) ? "exact" : "volume"
        if (kind == 4) printf ", \"scene\": {\"clouds.coverage\": %.3f, \"clouds.seed\": %d}", rand(), pick(100)
        if (kind == 5) printf ", \"scene\": {\"sun.elevation_deg\": %.2f, \"atmosphere.enabled\": %s}",
                              45 * unit(), pick(4) ? "true" : "false"
        if (kind == 6) printf ", \"scene\": {\"clouds.base_m\": %.0f, \"clouds.thickness_m\": %.0f}",
                              500 + 2000 * rand(), 200 + 2500 * rand()
        if (kind == 7) printf ", \"window\": \"minimise\""
        if (kind == 8 || kind == 9) printf ", \"window\": \"restore\""
        if (kind == 10) printf ", \"actions\": [\"%s\"]", pick(2) ? "help" : "panel"
        if (kind == 11) printf ", \"sun_px\": [%.0f, %.0f]", 10 * unit(), 4 * unit()
        if (kind == 12) printf ", \"scene\": {\"ground.enabled\": %s, \"exposure_ev\": %.2f}",
                               pick(2) ? "true" : "false", 2 * unit()
        if (kind == 13) printf ", \"settings\": {\"light\": \"%s\"}", pick(2) ? "field" : "tables"
        printf "}"
      }
      printf ",\n{\"window\": \"restore\", \"size\": [320, 180], \"frames\": 4, "
      printf "\"settings\": {\"quality\": \"low\", \"scale\": 1, \"ring_size_cells\": 0, \"detail\": true, "
      printf "\"blend\": \"volume\", \"backend\": \"auto\", \"light\": \"field\"}},\n"
      printf "{\"frames\": 60},\n{\"picture\": \"%s\", \"save\": \"%s\"}]}\n", last, save
    }'
}
[[ $minutes == 0 ]] && exit
soak_script "$minutes" >"$scratch/soak.json"
status=0
NEPHELE_VALIDATION=1 fly soak --size 320x180 --quality low "$@" 2>"$scratch/soak.err" || status=$?
build/nephele render --quiet --scene "$scratch/soak_scene.json" --size 320x180 --quality low --time 0 \
  --out "$scratch/fresh.exr" "$@"
same=no
cmp -s "$scratch/soak.exr" "$scratch/fresh.exr" && same=yes
jq -r --arg same "$same" --arg status "$status" --arg lines "$(wc -l <"$scratch/soak.err")" '
  (.memory | length / 2 | floor) as $half |
  def most(key): "\(.memory[:$half] | map(.[key]) | max | round), \(.memory[$half:] | map(.[key]) | max | round) MiB";
  "| | |\n|---|---|\n| minutes, frames | \(.memory[-1].s / 60 | round), \(.frames) |\n" +
  "| status, lines of warnings and validation | \($status), \($lines) |\n" +
  "| most memory of the process in the first and in the second half | \(most("resident_mib")) |\n" +
  "| the same of the device | \(most("device_mib")) |\n" +
  "| the last picture is the one that `render` draws of the saved scene, bit for bit | \($same) |"' \
  "$scratch/soak.stats.json" >"$scratch/soak.md"
marked_block docs/flying.md soak cat "$scratch/soak.md"
