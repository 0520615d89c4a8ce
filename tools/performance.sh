#!/usr/bin/env bash
# Runs the ready-made sweeps, and the particles against the ray marcher at equal distance from the truth, and writes
# docs/performance.md with its plots. Some twenty minutes on two quiet cores; what has been measured stays in
# out/performance, so a run that was cut short goes on. For new times, remove it first.
#   tools/performance.sh [--device NAME_OR_INDEX]
#   tools/performance.sh --write                    only writes, from the sweeps that are complete; says which are not
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

out=out/performance
sweep() { build/nephele sweep --config "tools/sweeps/$1.json" --out "$out/$2" "${@:3}"; }

# Particles and ray marcher on a field and on a single towering cloud of the truth set: distance of the layer from the path
# tracer's at its resolution, and what the layer costs at 640x360, ways in turn.
race_scenes=(field_side cloud_front)
race_ways=("exact --blend exact" "volume --blend volume" "march_8 --method raymarch --steps 8" "march_16 --method raymarch --steps 16"
  "march_32 --method raymarch --steps 32" "march_64 --method raymarch --steps 64")
race() {  # arguments of render
  local rounds=5 round scene way name how work
  work=$(mktemp -d)
  for round in $(seq "$rounds"); do
    for scene in "${race_scenes[@]}"; do
      for way in "${race_ways[@]}"; do
        read -r name how <<<"$way"
        # shellcheck disable=SC2086
        build/nephele render --quiet --scene "tools/truth/$scene.json" --size 640x360 --frames 2 --warmup 1 --out "$work/%04d.png" \
          --stats "$work/$scene.$name.$round.json" $how "$@"
      done
    done
  done
  for scene in "${race_scenes[@]}"; do
    for way in "${race_ways[@]}"; do
      read -r name how <<<"$way"
      # shellcheck disable=SC2086
      build/nephele render --quiet --scene "tools/truth/$scene.json" --size 80x45 --layers "$work/layers.exr" $how "$@"
      jq -s --arg scene "$scene" --arg way "$name" \
        --argjson color "$(build/nephele compare "$work/layers.exr" "tools/truth/${scene}_layers.exr" --channels R,G,B)" \
        --argjson through "$(build/nephele compare "$work/layers.exr" "tools/truth/${scene}_layers.exr" --channels T)" '
        def middle: sort | .[length / 2 | floor];
        {scene: $scene, way: $way, color: $color.relmse, transmittance: $through.relmse, frame_ms: map(.frame_ms.median) | middle,
         layer_ms: map([.passes[] | select(.name | IN("shade_blend", "screen_tiles", "march", "march_tiles")) | .ms] | add) | middle}' \
        "$work/$scene.$name".*.json
    done
  done | jq -s . >"$out/race.json"
  rm -r "$work"
}

if [[ ${1:-} != --write ]]; then
  tools/setup.sh gnuplot-nox jq
  cmake --preset release
  cmake --build --preset release --target nephele_program
  mkdir -p "$out"
  sweep pareto pareto "$@"
  sweep presets presets "$@"
  sweep quick quick "$@"
  sweep quick quick_again --compare "$out/quick/results.json" --slowdown 100 "$@" > "$out/compare.txt"
  sweep scaling scaling "$@"
  [[ -f $out/race.json ]] || race "$@"
fi

race_table() {
  if [[ ! -f $out/race.json ]]; then
    echo "*Not measured yet on this state of the program: \`tools/performance.sh\`.*"
    return
  fi
  echo "| scene | way | colour, relMSE | transmittance, relMSE | layer, ms | frame, ms | layer's time over exact's |"
  echo "|---|---|---|---|---|---|---|"
  jq -r '
    def shown: . * 10000 | round / 10000;
    map(select(.way == "exact")) as $exact | .[] | . as $row |
    ($exact[] | select(.scene == $row.scene).layer_ms) as $base |
    "| \(.scene) | \(.way | sub("_"; " ")) | \(.color | shown) | \(.transmittance | shown) | \(.layer_ms | round) | \(.frame_ms | round) | \(.layer_ms / $base * 100 | round / 100) |"' \
    "$out/race.json"
}

# How many steps bring the marcher as near to the truth as a blend is, and how many times as long it takes then.
race_ratios() {
  [[ -f $out/race.json ]] || return 0
  echo "| scene | blend | steps of the marcher at its distance in colour, transmittance | marcher's time over the blend's, colour | transmittance |"
  echo "|---|---|---|---|---|"
  jq -r '
    # Steps at which marching is as near to the truth as `distance` (log-log), and what the layer takes then.
    def at($marches; $what; $distance): [range($marches | length - 1) as $i | $marches[$i] as $a | $marches[$i + 1] as $b
      | select($a[$what] >= $distance and $distance >= $b[$what])
      | (($a[$what] / $distance | log) / ($a[$what] / $b[$what] | log)) as $f | ($a.steps * pow($b.steps / $a.steps; $f)) as $steps
      | {$steps, ms: ($a.layer_ms + ($b.layer_ms - $a.layer_ms) * ($steps - $a.steps) / ($b.steps - $a.steps))}] | first;
    def shown: . * 10 | round / 10;
    . as $all | [.[].scene] | unique | reverse | map(. as $scene
      | ([$all[] | select(.scene == $scene and (.way | startswith("march"))) | .steps = (.way | ltrimstr("march_") | tonumber)] | sort_by(.steps)) as $marches
      | ["volume", "exact"] | map(. as $way | ($all[] | select(.scene == $scene and .way == $way)) as $row
        | ["color", "transmittance"] | map(. as $what | at($marches; $what; $row[$what])) as $at
        | "| \($scene) | \($way) | \($at | map(.steps | round | tostring) | join(", ")) | \($at[0].ms / $row.layer_ms | shown) | \($at[1].ms / $row.layer_ms | shown) |")) | flatten | .[]' "$out/race.json"
}

# What the scaling sweep says of the frame time as a function of the shaded pairs and of the particles.
scaling_reading() {
  [[ -f $out/scaling/results.json ]] || return 0
  local bare  # net nanoseconds a ray
  bare=$(awk -F ' *[|] *' '$2 == "ours: all three, optical depth packed" { print $5 }' docs/tables.md)
  [[ $bare ]] || { echo "performance: docs/tables.md has no cost of the packed look-up" >&2; exit 1; }
  jq -r --arg bare "$bare" '
    def mean: add / length;
    def pairs: .pairs_shaded;
    def line: (map(pairs) | mean) as $x | (map(.ms.median) | mean) as $y |
      (map((pairs - $x) * (.ms.median - $y)) | add) as $xy | (map((pairs - $x) | . * .) | add) as $xx | (map((.ms.median - $y) | . * .) | add) as $yy |
      {slope_ns: ($xy / $xx * 1e6), r2: ($xy * $xy / ($xx * $yy))};
    (.variants | map(select(.series == "pixels"))) as $pixels | ($pixels | line) as $line |
    (.variants | map(select(.series == "ring size"))) as $rings |
    ([$rings[] as $a | $rings[] as $b | {from: $a, to: $b, particles: ($b.particles_generated / $a.particles_generated), ms: ($b.ms.median / $a.ms.median)}]
      | min_by(.particles - 4 | fabs)) as $four |
    "Over the resolutions the frame time is linear in the shaded pairs with R² = \($line.r2 * 10000 | round / 10000), \($line.slope_ns | round) ns a pair, all that grows with the pixels included. A bare look-up in both tables, with single scattering, takes \($bare) ns with all cores (docs/tables.md, packed), and at most 1.5 times that was asked of a pair: it is far from reached, since a pair also finds its particle, meets its ellipsoid and its base, fetches four times from the noise and sums four kinds of light. " +
    "\($four.particles * 100 | round / 100) times the particles (rings of \($four.to.axes.ring_size_cells) cells for \($four.from.axes.ring_size_cells)) over the same screen take \($four.ms * 100 | round / 100) times the time."' \
    "$out/scaling/results.json"
}

# A sweep's table and plots, or a word that it is missing.
results() {  # name plots...
  local name=$1; shift
  if [[ ! -f $out/$name/results.md ]]; then
    echo "*Not measured yet on this state of the program: \`tools/performance.sh\`.*"
    return
  fi
  for plot in "$@"; do
    cp "$out/$name/$plot.svg" "docs/pictures/performance_$plot.svg"
    echo "![$plot](pictures/performance_$plot.svg)"
  done
  echo
  cat "$out/$name/results.md"
}

{
  cat <<'TEXT'
# Performance

Written by `tools/performance.sh` from `nephele sweep` and the configurations in `tools/sweeps`. **No GPU was at hand:** all
times are lavapipe's, on two cores that other work shared. Compare ratios of one table, not milliseconds of two.

A sweep takes its variants in turn, so that a machine that drifts hurts all alike. A ratio is that of the frame times of a
variant and the first of its scene in the same repetition: its median, and the interval of order statistics that holds it.

## Error against time

How far each way is from the integral of light through the particles' own density, and what it costs. The reference is
the ray marcher with 2 048 steps; in transmittance it converges to quadrature of that density (`tests/pass/ray_march_test.cpp`).
Its light is the particles' own model, so these are errors of **integration and resolution alone**, with what the tables
and the shading's fine noise change counted in; how near the light itself is to a path tracer's they do not say. Between
marches they are distances from the march's own limit, which no blend of whole particles can reach.

relMSE: squared error over reference² + 0.01 mean reference², whole picture, linear R G B.

TEXT
  results pareto error_fair_weather error_above_deck
  cat <<'TEXT'

## At equal distance from the truth

The cloud layer against the path tracer's, on a field and on a single towering cloud of the truth set (80×45, quality medium), and its time at
640×360: shading, blending or marching with their lists. Both shade alike, so most of the distance in colour is the light's, which more steps do not mend.

TEXT
  race_table
  echo
  race_ratios
  cat <<'TEXT'

Five times as fast was asked: volume is, exact, which is as near to the truth, on the field alone. More steps get nearer than
whole particles can: the truth has none of the noise that erodes the particles' edges. Fewer than 16 step over them.

## What was made faster

Scene fair_weather, 640×360, low, scale 2, `tiled`; milliseconds by `nephele render --frames 10 --warmup 2 --stats` of the builds before and after, in turn on a quiet machine; no script repeats them. Change: largest difference of a
pixel of the linear image. All of these save work that a CPU does for lanes that have no use for it; a GPU, which skips what no thread
needs, gains by the shorter lists alone.

| step | pass | before | after | change |
|---|---|---|---|---|
| a kernel for every kind of image tile (sky, ground, clouds, anything); the layer's upscaling in it; octaves of the ground end with its footprint | composite, upscale | 48 | 22 | 1.5e-8 |
| glare's sunlight found once, the sun's disc in mixed tiles only (in a slower hour) | composite | 24.0 | 22.3 | none |
| next places of a list by words of 32 instead of one by one | shade_blend | 35 | 27 | none |
| one loop for all lists of a particle instead of a loop a list | occlusion | 31 | 24 | none |
| only cells that may get a weight look at the field; a feature is evaluated for one lattice, not three | grid_cells | 46 | 31 | none |
| rays end above the clouds and under the ground | haze_shadow | 11 | 6 | 4e-4, as near to a finer volume as before |
| only light tiles that the view can look up cast a shadow (in a slower hour) | cloud_shadow | 9.2 | 4.4 | none |
| whole frame, first and last build of these in turn | | 216 | 151 | |
| buffers that each thread reads at a place of its own are bound as texel buffers: the driver loads storage buffers lane by lane and word by word, but gathers a texel for eight lanes at once | occlusion | 27 | 18 | none |
| | grid_cells | 30 | 23 | none |
| | cloud_shadow | 4.6 | 2.9 | none |
| | the ray marcher, 32 steps | 423 | 325 | none |
| a cell asks only for the features that reach it | grid_cells | 23 | 20 | none |
| what a particle's next list needs is at hand before the walk: every round of a loop pays for the body of each loop and branch in it | occlusion | 18 | 10.5 | none |
| the same in the columns of pixels: the next place is a bit at hand; a thread's pixels lie a knight's move apart | shade_blend | 24.5 | 19.7 | none |
| no branch hangs on uniform data alone where much of a shader does: the driver puts such data into the code and compiled two shaders anew every frame (from its disk cache; without one 30 to 40 ms each) | visibility | 3.2 | 1.2 | none |
| | composite | 15.3 | 13.3 | none |
| the upscaled layer is kept only where it is read (`RenderSettings::full_layer`) | composite | 17.4 | 16.1 | none |
| the fields' weights on the ground in one pass over nine neighbours | composite | 16.5 | 15.3 | none in 8 bits |
| runs of 256 in prefix sums on a CPU, a level less (in a slower hour) | light_tiles, view_sort, screen_tiles | 21.5 | 18.1 | none |
| whole frame, builds before and after the lines from texel buffers on, in turn (in a slower hour) | | 184 | 129 | none in 8 bits, six scenes |
| particles' bounds follow their flat bases (1280×720, medium) | shade_blend | 264 | 240 | none |
| the exact blend goes by columns too: first shading alone, segments on a stack, then blending with eight slots | shade_blend, exact | 41 | 20 | 1.3e-5 |
| optical depths packed: bytes in blocks of a cache line, first matter at every other vertex, the lesser half read (`tables.glsl`) | shade_blend, 1280×720, medium | 227 | 196 | 2e-4 RMS |
| | shade_blend | 17.7 | 14.9 | 2e-4 RMS |
| | shade_blend, exact | 29.3 | 27.5 | 2e-4 RMS |
| sorts on a CPU by 64 threads instead of up to 256, in workgroups of 8: a quarter of the table of counts to sum | light_tiles, view_sort, screen_tiles | 18.2 | 15.8 | none |

The volume blend ends at opaque matter instead of at a gap behind it (`OpaqueFront`, shaders/shared/blend.h): what is hidden is no longer mixed into
what it overlaps. Pairs at 1280×720, medium, scale 1, and the relMSE against the exact blend at 640×360, medium, by `nephele compare`:

| scene | pairs before | after | relMSE to exact before | after |
|---|---|---|---|---|
| fair_weather | 2 400 000 | 1 916 000 | 5.79e-5 | 5.68e-5 |
| towering | 3 374 000 | 2 717 000 | 7.19e-5 | 6.98e-5 |
| above_deck | 2 109 000 | 1 825 000 | 2.65e-4 | 2.40e-4 |
| coast | 1 595 000 | 1 258 000 | 9.15e-5 | 8.52e-5 |
| sunset | | | 1.239e-4 | 1.224e-4 |
| inside_cloud | | | 2.361e-6 | 2.358e-6 |

Against the truth set the relMSE of the six scenes changes by less than a thousandth. An end at 1e-3 takes
8 % more of the pairs, but the sun's disc, 10⁵ times as bright as the sky, would have to fade at ten times that too (sunset: 1.1e-3 where it doesn't). A bound from the depths up to
four fixed distances ends 2 % more, which it costs.

Tried and left out: a map of the blocks that features reach, so that cells elsewhere need not look (at a coverage of 0.45 hardly a block is
free); haze shadows on 64×36 rays (3 ms less; against a volume 2.5 times as fine the sunset's relMSE goes from 0.0009 to 0.0060, with the phase function
kept out of the volume 0.0056); light only for particles that some pixel shades (four fifths of the visible ones are); halving a light tile's list
to where a point's neighbours begin (occlusion 51 to 39 ms under a low sun, but the lists cost 4 ms more, and at a high sun nothing is gained); shading without
its light, which would be the most that a lower rate of it could save, is 0.8 of shade_blend; closed forms with one division an occluder instead of
twelve (occlusion as before: its loads decide); draw particles as texels in the raster backends (85 to 113 ms: there all lanes of a
quad read the same); SPIR-V through the optimiser (nothing); the optical depths as texels of sixteen 8-bit corners, two fetches instead of two filtered samples (nothing: the
table's cache misses decide, a fifth of shade_blend, and that table is four times as large; packed as above half of them are left, in the raster
backends 0 to 6 % is gained); the tables as 16-bit integers or as floats, the detail noise in four channels
(nothing); slices of the haze stored outside the loop of steps (nothing).

The marcher's reconstruction (640×360, fair_weather and towering, against 1 024 steps) takes 1 to 8 % off its relMSE at 8 to 32 steps; at 64 steps the error
is 8e-5 without it and 1e-4 with it, both far below the distance to the truth. Most of what few steps miss is bias, not noise. A wider one, that also counts
hit and miss of single steps as noise, takes up to 17 % off at 16 steps there, but adds 5 % against the truth set, whose pixels are as large as
what it blurs: left out, as the baseline shall not suffer.

## Presets, beside the paper's

[Yusov14] Table 1: ms a frame, particles at half resolution. Platform I: GeForce GTX 680, 1920×1080, without volume-aware
blending; II: Intel HD Graphics 5200, 1280×720, with it.

| platform | quality | particles | atmosphere | other | total | ratio to low |
|---|---|---|---|---|---|---|
| I | low | 3.1 | 1.6 | 0.9 | 5.6 | 1 |
| | medium | 6.3 | 1.6 | 1.6 | 9.5 | 1.70 |
| | high | 10.5 | 1.5 | 3.4 | 15.4 | 2.75 |
| II | low | 9.1 | 4.1 | 2.9 | 16.1 | 1 |
| | medium | 16.8 | 4.2 | 4.0 | 25.0 | 1.55 |
| | high | 26.2 | 4.2 | 6.1 | 36.5 | 2.27 |

Here: 1280×720, half resolution. `alpha` is what platform I did, `attachment` and `tiled` what platform II did. Layers stand on
a base particle: 3, 5 and 7 for the paper's 2, 4 and 6.

TEXT
  results presets passes_fair_weather
  cat <<'TEXT'

## Scaling

One axis at a time from low quality at 320×180.

TEXT
  results scaling cost_particles cost_pixels cost_distance
  echo
  scaling_reading
  cat <<'TEXT'

## Two runs of one sweep

`tools/sweeps/quick.json`, run twice, one after the other; agree: the intervals of the two ratios overlap.

TEXT
  results quick_again
  if [[ -s $out/compare.txt ]]; then printf '\n```\n'; cat "$out/compare.txt"; echo '```'; fi
} > docs/performance.md.new
mv docs/performance.md.new docs/performance.md
echo "docs/performance.md"
