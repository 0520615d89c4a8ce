#!/usr/bin/env bash
# Measures today's picture against the path-traced truth (tools/truth/, tools/truth.sh) and writes docs/accuracy.md and
# docs/pictures/accuracy.png. The closed cases take an hour, the rest a few minutes; --no-closed-cases keeps theirs.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

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
  build/nephele render --quiet --scene "$scene" --size "$(size_of "${name#sun_}")" --layers "$work/$name.$method.layers.exr" "${how[@]}" "$@"
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
    build/nephele render --quiet --scene "tools/truth/$name.json" --size "$(size_of "$name")" --method raymarch --steps "$count" \
      --layers "$layers"
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

closed=$work/closed.txt
if [[ ${1:-} == --no-closed-cases ]]; then
  sed -n '/^| 2 | 0 | 0 |/,/^$/p' docs/accuracy.md >"$closed"
else
  build/test_cpu --no-skip --test-case="path tracer study*" >"$work/study.txt"
  grep '^| [0-9]' "$work/study.txt" >"$closed"
  echo >>"$closed"
fi

{
  cat <<'DOC'
# How far from the truth

Written by `tools/accuracy.sh`. The truth is `nephele reference`: an unbiased path tracer in doubles and floats on the CPU
(`truth/`) over the very particles that the renderer draws, read back from its frame. It shares scene, particles and
the clear atmosphere's model with the renderer, and no transport of light in clouds.

![Truth, alpha, exact](pictures/accuracy.png)

From left to right: truth, alpha, exact; from top to bottom: one cloud front-lit, side-lit and back-lit, a field
from the side and from above, inside a cloud.

## What the truth is of

- **Extinction**: the sum over all particles. A homogeneous one is constant; a reference particle is
  `reference_particle_density` in the particle's own frame and orientation, on a lattice of 97 vertices a side (its error:
  `extinction_field_test`). Where rings overlap both are there, with their weights.
- **Flat bases** are geometry: matter below a particle's base is cut away, and the 50 m above it thinned by the same ramp as
  when shading, here as a function of the point where the renderer takes a segment's middle.
- **Not in the field**, and so counted as error of the picture: what shading adds by tiling noise (ragged outlines, finer
  density, relief: functions of the view as well as of the place), thin chords that it fades out, and matter spread evenly
  over a chord.
- **Light**: albedo 1, all orders, the scene's phase function, the sun as a direction, sky and air from the atmosphere's
  tables, a diffuse ground that clouds shade and light. `--sky-radiance` replaces sky and air by a constant. No order is left out:
  paths end by leaving, or by Russian roulette on the ground.
- **Not in the truth**: the sun's disc in the picture, shadows of clouds in the haze, air between one cloud and the next.
- A pixel is the ray through its centre, as in the renderer: aliasing is no error here.

## Closed cases

`test_cpu` runs them: a white furnace is 1 in every pixel to rounding (every path ends in the same sky); without
particles every pixel is the background; particles that glow show the emission-absorption integral; transmittance agrees with
the closed form for overlapping ellipsoids and with quadrature for noisy ones; a cloud sends out the sunlight it takes from
the beam; two seeds differ as their standard errors say; sums are the same for any number of threads and after an interruption.

Homogeneous spheres against the tables' own Monte Carlo, in 16 bands from the sunlit limb to the dark one
(`test_cpu --no-skip --test-case="path tracer study*"`). Asked: 2 % in every band. Bands darker than a tenth of the sphere's mean are
related to that tenth. Errors in percent; the last column is the mean squared error over its standard error, 1 where the
two differ by noise alone.

| optical diameter | g | degrees between eye and sun | worst band | its noise | mean square / noise |
|---|---|---|---|---|---|
DOC
  cat "$closed"
  cat <<'DOC'
## The truth set

`tools/truth/`: scenes, images of 80x45 (inside: 48x27) and their cloud layers, by `tools/truth.sh`. Noise: mean over the pixels of the
standard error of the luminance over the luminance; clear sky has none, so single cloudy pixels have two to five times that.

| scene | samples a pixel | noise |
|---|---|---|
DOC
  cat tools/truth/summary.md
  cat <<'DOC'

## The picture against the truth

Quality medium, full resolution. Layer: the cloud layer alone (radiance times opacity, no air in front); relMSE and bias as
`nephele compare` defines them, bias in percent of the mean; T: RMSE of the transmittance. Picture: the whole linear image.

| scene | blend | layer relMSE | layer bias % | T RMSE | picture relMSE | picture bias % |
|---|---|---|---|---|---|---|
DOC
  cat "$work/errors.txt"
  cat <<'DOC'

The ray marcher (`--method raymarch --steps N`), layer relMSE and bias in percent:

| scene | 16 | 64 | 512 |
|---|---|---|---|
DOC
  cat "$work/marched.txt"
  cat <<'DOC'

## Which light is off

Bias of the layer (exact blend), in percent: with the sun alone (atmosphere and ground off in both), and with everything.

| scene | sun alone | all light |
|---|---|---|
DOC
  cat "$work/sun.txt"
  echo
  sed -n '/^<!-- reading -->/,$p' docs/accuracy.md 2>/dev/null || true
} >"$work/accuracy.md"
mv "$work/accuracy.md" docs/accuracy.md
