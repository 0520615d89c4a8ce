#!/usr/bin/env bash
# Runs the ready-made sweeps and writes docs/performance.md with its plots. Some twenty minutes on two quiet cores; what
# has been measured stays in out/performance, so a run that was cut short goes on. For new times, remove it first.
#   tools/performance.sh [--device NAME_OR_INDEX]
#   tools/performance.sh --write                    only writes, from the sweeps that are complete; says which are not
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

out=out/performance
sweep() { build/nephele sweep --config "tools/sweeps/$1.json" --out "$out/$2" "${@:3}"; }
if [[ ${1:-} != --write ]]; then
  tools/setup.sh gnuplot-nox
  cmake --preset release
  cmake --build --preset release --target nephele_program
  mkdir -p "$out"
  sweep pareto pareto "$@"
  sweep presets presets "$@"
  sweep quick quick "$@"
  sweep quick quick_again --compare "$out/quick/results.json" --slowdown 100 "$@" > "$out/compare.txt"
  sweep scaling scaling "$@"
fi

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
  cat <<'TEXT'

## Two runs of one sweep

`tools/sweeps/quick.json`, run twice, one after the other; agree: the intervals of the two ratios overlap.

TEXT
  results quick_again
  if [[ -s $out/compare.txt ]]; then printf '\n```\n'; cat "$out/compare.txt"; echo '```'; fi
} > docs/performance.md.new
mv docs/performance.md.new docs/performance.md
echo "docs/performance.md"
