#!/usr/bin/env bash
# Runs the ready-made sweeps, and the particles against the ray marcher at equal distance from the truth, and writes the
# figures of docs/performance.md and its plots. Some twenty minutes on two quiet cores; what has been measured stays in
# out/performance, so a run that was cut short goes on. For new times, remove it first.
#   tools/performance.sh [--device NAME_OR_INDEX]
#   tools/performance.sh --race [--device ...]      the particles against the ray marcher alone
#   tools/performance.sh --write                    only writes, from the sweeps that are complete; says which are not
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/marked_block.sh

out=out/performance
sweep() { build/nephele sweep --config "tools/sweeps/$1.json" --out "$out/$2" "${@:3}"; }

# Particles and ray marcher on a field, on a single towering cloud and under an overcast of the truth set: distance of
# the layer from the path tracer's at its resolution, and what layer and frame cost at 640x360 from a camera that moves
# at 6 m/s and stays in its windows of light; ways in turn. Without the fine noise, which the truth lacks.
race_scenes=(field_side cloud_front overcast)
race_ways=("exact --blend exact" "volume --blend volume" "exact_tables --blend exact --light tables"
  "volume_tables --blend volume --light tables" "march_16_tables --method raymarch --steps 16 --light tables")
for count in 8 16 32 64; do race_ways+=("march_$count --method raymarch --steps $count"); done
distance() {  # layers, scene of the truth set, channels
  build/nephele compare "$1" "tools/truth/$2_layers.exr" --channels "$3"
}
race() {  # arguments of render
  local rounds=3 round scene way name how work
  work=$(mktemp -d)
  for scene in "${race_scenes[@]}"; do
    jq '.camera | {fps: 60, keys: [{time_s: 0, position_m, yaw_deg, pitch_deg, roll_deg: 0},
        {time_s: 1, position_m: [.position_m[0], .position_m[1] + 6, .position_m[2]],
         yaw_deg, pitch_deg, roll_deg: 0}]}' "tools/truth/$scene.json" >"$work/$scene.path.json"
  done
  for round in $(seq "$rounds"); do
    for scene in "${race_scenes[@]}"; do
      for way in "${race_ways[@]}"; do
        read -r name how <<<"$way"
        # shellcheck disable=SC2086
        build/nephele render --quiet --scene "tools/truth/$scene.json" --size 640x360 --path "$work/$scene.path.json" \
          --frames 3 --warmup 1 --reuse --detail off --out "$work/%04d.png" \
          --stats "$work/$scene.$name.$round.json" $how "$@"
      done
    done
  done
  for scene in "${race_scenes[@]}"; do
    for way in "${race_ways[@]}"; do
      read -r name how <<<"$way"
      # shellcheck disable=SC2086
      build/nephele render --quiet --scene "tools/truth/$scene.json" --size 80x45 --detail off \
        --layers "$work/layers.exr" $how "$@"
      jq -s --arg scene "$scene" --arg way "$name" \
        --argjson color "$(distance "$work/layers.exr" "$scene" R,G,B)" \
        --argjson through "$(distance "$work/layers.exr" "$scene" T)" '
        def middle: sort | .[length / 2 | floor];
        ["shade_blend", "screen_tiles", "march", "march_tiles"] as $layer |
        {scene: $scene, way: $way, color: $color.relmse, transmittance: $through.relmse,
         frame_ms: map(.frame_ms.median) | middle,
         layer_ms: map([.passes[] | select(.name | IN($layer[])) | .ms] | add) | middle}' "$work/$scene.$name".*.json
    done
  done | jq -s . >"$out/race.json"
  rm -r "$work"
}

if [[ ${1:-} != --write ]]; then
  tools/setup.sh gnuplot-nox jq
  cmake --preset release
  cmake --build --preset release --target nephele_program
  mkdir -p "$out"
fi
if [[ ${1:-} == --race ]]; then
  race "${@:2}"
elif [[ ${1:-} != --write ]]; then
  sweep pareto pareto "$@"
  sweep presets presets "$@"
  sweep quick quick "$@"
  sweep quick quick_again --compare "$out/quick/results.json" --slowdown 100 "$@" > "$out/compare.txt"
  sweep scaling scaling "$@"
  [[ -f $out/race.json ]] || race "$@"
fi

missing() {
  echo "*Not measured yet on this state of the program: \`tools/performance.sh\`.*"
}

race_table() {
  [[ -f $out/race.json ]] || { missing; return; }
  echo "| scene | way | colour, relMSE | transmittance, relMSE | layer, ms | frame, ms | layer's time over exact's |"
  echo "|---|---|---|---|---|---|---|"
  jq -r '
    def shown: . * 10000 | round / 10000;
    map(select(.way == "exact")) as $exact | .[] | . as $row |
    ($exact[] | select(.scene == $row.scene).layer_ms) as $base |
    "| \(.scene) | \(.way | sub("_"; " ")) | \(.color | shown) | \(.transmittance | shown) | " +
    "\(.layer_ms | round) | \(.frame_ms | round) | \(.layer_ms / $base * 100 | round / 100) |"' "$out/race.json"
}

# How many steps bring the marcher as near to the truth as a blend is, and how many times as long it takes then.
race_ratios() {
  [[ -f $out/race.json ]] || { missing; return; }
  echo "| scene | blend | steps of the marcher at its distance in colour, transmittance |" \
    "marcher's time over the blend's, colour | transmittance |"
  echo "|---|---|---|---|---|"
  jq -r '
    # Steps at which marching is as near to the truth as `distance` (log-log), and what the layer takes then.
    def at($marches; $what; $distance):
      [range($marches | length - 1) as $i | $marches[$i] as $a | $marches[$i + 1] as $b
       | select($a[$what] >= $distance and $distance >= $b[$what])
       | (($a[$what] / $distance | log) / ($a[$what] / $b[$what] | log)) as $f
       | ($a.steps * pow($b.steps / $a.steps; $f)) as $steps
       | {$steps, ms: ($a.layer_ms + ($b.layer_ms - $a.layer_ms) * ($steps - $a.steps) / ($b.steps - $a.steps))}]
      | first;
    def shown: . * 10 | round / 10;
    def marches($scene):
      [.[] | select(.scene == $scene and (.way | test("^march_[0-9]+$")))
       | .steps = (.way | ltrimstr("march_") | tonumber)] | sort_by(.steps);
    . as $all | [.[].scene] | unique | reverse | .[] as $scene | ($all | marches($scene)) as $marches
    | ("volume", "exact") as $way
    | ($all[] | select(.scene == $scene and .way == $way)) as $row
    | (["color", "transmittance"] | map(. as $what | at($marches; $what; $row[$what]))) as $at
    | "| \($scene) | \($way) | " +
      "\($at | map(if . then .steps | round | tostring else "more than 64" end) | join(", ")) | " +
      "\($at | map(if . then .ms / $row.layer_ms | shown | tostring else "" end) | join(" | ")) |"' "$out/race.json"
}

# relMSE against the frame's time: blends and marcher with light from the field, and from tables.
race_plot() {
  [[ -f $out/race.json ]] || { missing; return; }
  local scene points
  points=$(mktemp -d)
  for scene in "${race_scenes[@]}"; do
    jq -r --arg scene "$scene" '.[] | select(.scene == $scene and (.way | test("^(exact|volume)$"))) |
      "\(.frame_ms) \(.color) \(.way)"' "$out/race.json" >"$points/field"
    jq -r --arg scene "$scene" '.[] | select(.scene == $scene and (.way | test("tables$"))) |
      "\(.frame_ms) \(.color) \(.way | gsub("_"; "-"))"' "$out/race.json" >"$points/tables"
    jq -r --arg scene "$scene" '.[] | select(.scene == $scene and (.way | test("^march_[0-9]+$"))) |
      "\(.frame_ms) \(.color) \(.way | ltrimstr("march_"))"' "$out/race.json" >"$points/march"
    gnuplot <<EOF
set terminal svg size 640,400 background rgb "white"
set output "docs/pictures/performance_race_$scene.svg"
set title "$scene, 640x360, medium"
set xlabel "frame, ms"
set ylabel "relMSE of the layer"
set logscale xy
set key top right
set offsets graph 0.1, graph 0.2, graph 0.1, graph 0.1
plot "$points/field" using 1:2 with points pt 7 title "field", \
  "$points/tables" using 1:2 with points pt 5 title "tables", \
  "$points/march" using 1:2 with linespoints pt 9 title "marched, by steps, field", \
  "$points/field" using 1:2:3 with labels offset 0,1 notitle, \
  "$points/tables" using 1:2:3 with labels offset 0,1 notitle, \
  "$points/march" using 1:2:3 with labels offset 0,1 notitle
EOF
    echo "![$scene](pictures/performance_race_$scene.svg)"
  done
  rm -r "$points"
}

# What the scaling sweep says of the frame time as a function of the shaded pairs and of the particles.
scaling_line() {
  [[ -f $out/scaling/results.json ]] || { missing; return; }
  local bare  # net nanoseconds a ray
  bare=$(awk -F ' *[|] *' '$2 == "ours: all three, optical depth packed" { print $5 }' docs/tables.md)
  [[ $bare ]] || { echo "performance: docs/tables.md has no cost of the packed look-up" >&2; exit 1; }
  echo "| R² of the line | ns a pair, with all that grows with the pixels | bare look-up, ns |" \
    "rings of | particles, ratio | time, ratio |"
  echo "|---|---|---|---|---|---|"
  jq -r --arg bare "$bare" '
    def mean: add / length;
    def pairs: .pairs_shaded;
    def line:
      (map(pairs) | mean) as $x | (map(.ms.median) | mean) as $y
      | (map((pairs - $x) * (.ms.median - $y)) | add) as $xy
      | (map((pairs - $x) | . * .) | add) as $xx
      | (map((.ms.median - $y) | . * .) | add) as $yy
      | {slope_ns: ($xy / $xx * 1e6), r2: ($xy * $xy / ($xx * $yy))};
    (.variants | map(select(.series == "pixels")) | line) as $line |
    (.variants | map(select(.series == "ring size"))) as $rings |
    ([$rings[] as $a | $rings[] as $b
      | {from: $a, to: $b, particles: ($b.particles_generated / $a.particles_generated),
         ms: ($b.ms.median / $a.ms.median)}]
     | min_by(.particles - 4 | fabs)) as $four |
    "| \($line.r2 * 10000 | round / 10000) | \($line.slope_ns | round) | \($bare) | " +
    "\($four.to.axes.ring_size_cells) cells for \($four.from.axes.ring_size_cells) | " +
    "\($four.particles * 100 | round / 100) | \($four.ms * 100 | round / 100) |"' "$out/scaling/results.json"
}

# A sweep's table and plots, or a word that it is missing.
results() {  # name plots...
  local name=$1 plot; shift
  [[ -f $out/$name/results.md ]] || { missing; return; }
  for plot in "$@"; do
    cp "$out/$name/$plot.svg" "docs/pictures/performance_$plot.svg"
    echo "![$plot](pictures/performance_$plot.svg)"
  done
  [[ $# == 0 ]] || echo
  cat "$out/$name/results.md"
}
two_runs() {
  results quick_again
  [[ -s $out/compare.txt ]] || return 0
  printf '\n```\n'
  cat "$out/compare.txt"
  echo '```'
}

document=docs/performance.md
marked_block "$document" race race_table
marked_block "$document" "race plot" race_plot
marked_block "$document" "race ratios" race_ratios
echo "$document"
[[ ${1:-} != --race ]] || exit 0
marked_block "$document" pareto results pareto error_fair_weather error_above_deck
marked_block "$document" presets results presets passes_fair_weather
marked_block "$document" scaling results scaling cost_particles cost_pixels cost_distance
marked_block "$document" "scaling line" scaling_line
marked_block "$document" "two runs" two_runs
