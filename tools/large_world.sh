#!/usr/bin/env bash
# Measures what distance, ring size and layers cost on this machine and writes docs/large_world.md with its plot. Some
# five minutes.
#   tools/large_world.sh [DIR]     DIR: of a finished sweep of tools/sweeps/large_world.json, to write from instead
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
tools/setup.sh jq gnuplot-nox
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
results=${1:-$work/sweep}
if [[ $# == 0 ]]; then
  cmake --preset release
  cmake --build --preset release --target nephele_program
  build/nephele sweep --config tools/sweeps/large_world.json --out "$results"
fi
[[ -s $results/results.json ]] || { echo "large_world: $results/results.json is missing; run without arguments" >&2; exit 2; }

# rows SERIES AXIS: a table of the variants of a series.
rows() {
  echo
  echo "| $3 | particles | field | light_tiles, occlusion | view_sort | shade_blend | frame, ms |"
  echo "|---|---|---|---|---|---|---|"
  jq -r --arg series "$1" --arg axis "$2" '
    def ms($names): [.passes[] | select(.name | IN($names[])) | .ms] | add // 0 | . * 10 | round / 10;
    .variants[] | select(.series == $series) |
    "| \(.axes[$axis] // .settings.quality // "medium") | \(.particles_generated) | \(ms(["field"])) | " +
    "\(ms(["light_tiles", "occlusion"])) | \(ms(["view_sort"])) | \(ms(["shade_blend"])) | \(.frame_ms.median | . * 10 | round / 10) |"' \
    "$results/results.json"
}
share=$(jq -r '.variants[] | select(.series == "medium") |
  (.passes | map(select(.name | IN("field", "light_tiles", "occlusion", "view_sort")) | .ms) | add) / .frame_ms.median * 100 | round' \
  "$results/results.json")
cp "$results/cost_distance.svg" docs/pictures/cost_distance.svg
{
  cat <<'DOC'
# The large world

Written by `tools/large_world.sh`, figures and plot included.

## Clouds belong to places

A cloud is a function of its place in the air, of time and of the seed ([rendering.md](rendering.md), "Spaces"). Neither the camera's path,
nor rings, nor history enter: tests compare frames at x = 0 and at 10 000 km, flown and fresh, culled and unculled.

The wind carries clouds along with the lattices they stand on, so a drifting cloud keeps its shape. With `"growth_period_s"` in a scene's
`"clouds"` each cloud centre grows and shrinks once in that time by 60 % of its area about the mean, and its height with it, at
a phase of its own: coverage stays. 1800 is natural; the default, 0, keeps every cloud as it is.

## Weather maps

Without a map one coverage holds everywhere. `"weather_map"` in a scene's `"clouds"` steers coverage and type of the clouds by an
image that lies over the ground:

```json
"weather_map": {"file": "coast.png", "origin_m": [-80000, -80000], "extent_m": [160000, 160000]}
```

| key | meaning |
|---|---|
| `file` | PNG, at most 4096 texels a side, path relative to the scene file; its first row is the northernmost |
| `origin_m` | the image's south-west corner in the world: east, north |
| `extent_m` | width and height from there, 1 m to 40 000 km each |

| channel | meaning, of value / 255; data, so no sRGB curve and no gamma |
|---|---|
| red | coverage: the fraction of the area under clouds, as the key `coverage` has it |
| green | type: 0 humilis, as many clouds in all but small and flat ones; 1 the clouds that there are without a map, with towers up to `thickness_m` |
| blue, alpha | not read |

A grey image is coverage alone, with type 1. Values are interpolated between the middles of texels. Outside the map the scene's own
`coverage` and type 1 hold; over the first 2 km beyond its border it fades into them.

The map stays where it is, the clouds drift through it with the wind. One that comes into clearer air shrinks and fades, it does not vanish at
once; one that comes under another type grows or flattens. So what stands at a place still depends on place, time and seed
alone, and the map costs four texels a cloud and a sample. A program fills `CloudSettings::weather_map` itself.

![A coast, from 10 km](pictures/coast.png)

`tools/scenes/coast.json` with the map of `tools/coast_map.sh`: small flat clouds over the sea, a clear lane along the coast, a line of
congestus at the sea-breeze front, fair-weather clouds inland.

## Rings

Cells double in size from ring to ring, starting at 184 m. There are as few rings as reach the view distance, 8 at most:
their number grows with the logarithm of the distance. A cell looks at the field in four places, which are nested from ring to ring,
and its particles get two gains in density that restore the matter and the centre of mass of its columns of cloud.
`tests/cpu/cell_particles_test.cpp` holds five rings to it, averaged over four regions of 29 km:

| between adjacent rings | bound |
|---|---|
| mean optical depth, straight up | 3 % |
| mean transmittance, straight up and at 45 degrees | 3 % |
| altitude of the centre of mass | 2 % of the layer's thickness |

`tests/pass/flight_test.cpp` flies at 200 m/s and 60 frames/s through places where rings snap: the 99.9th percentile of
the change a pixel sees between two frames, in the cloud layer, may exceed that of a sky of finest cells by 2/255 at most.

What a frame looks at, with 104 cells along a ring:

| view distance, km | rings | places in cells | cloud centres | their share of the time |
|---|---|---|---|---|
| 40 | 4 | 90 000 | 44 000 | 4 % |
| 80 | 5 | 117 000 | 167 000 | 9 % |
| 160 | 6 | 144 000 | 651 000 | 27 % |
| 320 | 7 | 171 000 | 2 560 000 | 49 % |

Places grow with the logarithm of the distance. Cloud centres, evaluated once each before the cells look them up, grow with its square: that
is why the field costs more at the far end than the number of rings says. (Their share of finding cells is from the shared code as C++, one
run on one core.) At 200 km they are a third of it; to ask for them anew wherever a cell of the last ring looks would spare a tenth of them.

DOC
  echo "## What distance costs"
  echo
  echo "Scene above_deck, 320x180, low quality but for what varies; milliseconds, medians of $(jq .repetitions "$results/results.json") frames; device:"
  echo "$(jq -r '.identity.device' "$results/results.json"), $(jq -r '.identity.processors' "$results/results.json") cores. Compare rows of one run: a shared machine is noisy."
  rows distance scene.clouds.view_distance_m "view distance, m"
  echo
  echo "![Cost against view distance](pictures/cost_distance.svg)"
  rows "ring size" ring_size_cells "cells along a ring"
  rows layers layers "layers"
  echo
  echo "At 1280x720 and medium quality the passes before shading (grid, particles, light, sort) take $share % of the frame (asked: at most 25; their"
  echo "share grows as shading gets faster, their time does not):"
  rows medium none "quality"
} > "$work/large_world.md"
mv "$work/large_world.md" docs/large_world.md
echo docs/large_world.md
