#!/usr/bin/env bash
# Measures what volumes become as particle sets, what leaves the program again, and what scattered sets cost, and writes
# the figures of docs/sources.md and the pictures docs/pictures/sources.png and grown.png. A quarter of an hour on two
# cores.
#   tools/sources.sh [--figures | --pictures]     one of the two alone
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/marked_block.sh

what=${1:-}
tools/setup.sh jq imagemagick libopenvdb-tools netcdf-bin
cmake --preset release >/dev/null
cmake --build --preset release --target nephele_program test_cpu >/dev/null
work=$(mktemp -d)
nephele() { build/nephele "$@"; }

trap 'rm -rf "$work"' EXIT
tools/sample_volume.sh "$work/cumulus.npy" >/dev/null
cp tools/volumes/simulated.nc "$work/simulated.nc"

# file, arguments of import, camera that sees it
volumes=(
  "cumulus.npy|--voxel-m 16|[-1400,-1400,1500]|[1024,1024,1650]|32|[0,0,800]"
  "simulated.nc|--spacing 2.5|[-2500,-2500,1900]|[2048,2048,1300]|45|[0,0,0]"
)
scene_of() {  # set, camera, place, field of view, where the set stands, sun's elevation
  cat <<JSON
{"camera": {"position_m": $2, "look_at_m": $3, "vertical_fov_deg": $4},
 "sun": {"azimuth_deg": 300, "elevation_deg": ${6:-40}},
 "sources": [{"kind": "set", "file": "$1", "at_m": $5, "drifts": false}]}
JSON
}

volume_table() {
  echo "| volume | voxels | particles | s | RMSE of T | log error of depth | outline, m | mass - 1 |" \
    "RMSE of T, layer | relMSE, layer | noise in it | bias, % | traced set: relMSE | bias, % |"
  echo "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
  local volume file arguments camera place fov at set truth
  for volume in "${volumes[@]}"; do
    IFS='|' read -r file arguments camera place fov at <<<"$volume"
    set=$work/${file%.*}_set.json truth=$work/${file%.*}
    # shellcheck disable=SC2086
    nephele import --quiet "$work/$file" $arguments --out "$set" --verify --stats "$truth.stats" >"$truth.verified"
    # shellcheck disable=SC2086
    nephele import --quiet "$work/$file" $arguments --out "$truth.timed.json" --stats "$truth.timed"
    scene_of "$set" "$camera" "$place" "$fov" "$at" >"$truth.scene"
    local voxels=()
    [[ $file == *.npy ]] && voxels=(--voxel-m 16)
    nephele reference --quiet --scene "$truth.scene" --volume "$work/$file" "${voxels[@]}" --size 160x90 --spp 1024 \
      --out "$truth.exr" --layers "${truth}_layers.exr"
    nephele reference --quiet --scene "$truth.scene" --size 160x90 --spp 256 --out "${truth}_traced.exr" \
      --layers "${truth}_traced_layers.exr"
    nephele render --quiet --scene "$truth.scene" --size 160x90 --backend tiled --blend exact \
      --layers "${truth}_drawn.exr"
    jq -nr --arg name "$file" --slurpfile v "$truth.verified" --slurpfile s "$truth.stats" \
      --slurpfile t "$truth.timed" \
      --argjson layer "$(nephele compare "${truth}_drawn.exr" "${truth}_layers.exr" --noise "$truth.exr")" \
      --argjson through "$(nephele compare "${truth}_drawn.exr" "${truth}_layers.exr" --channels T)" \
      --argjson traced "$(nephele compare "${truth}_traced_layers.exr" "${truth}_layers.exr" --noise "$truth.exr")" '
      def to(n): . * pow(10; n) | round / pow(10; n);
      $v[0] as $v | [$name, $s[0].voxels, $v.particles, ($t[0].seconds | to(2)), ($v.rms_transmittance | to(4)),
       ($v.rms_log_depth | to(3)), ($v.outline_m | to(1)), ($v.mass_ratio - 1 | to(7)), ($through.rmse | to(4)),
       ($layer.relmse | to(4)), ($layer.noise_relmse | to(4)), ($layer.bias * 100 | to(1)), ($traced.relmse | to(4)),
       ($traced.bias * 100 | to(1))] | "| \(join(" | ")) |"'
  done
}

level_table() {
  echo "| volume | particles of each level | RMSE of T |"
  echo "|---|---|---|"
  for name in cumulus simulated; do
    jq -r --arg name "$name" '[., .coarser[]] | [$name, ([.[].particles] | join(", ")),
      ([.[].rms_transmittance * 1000 | round / 1000] | join(", "))] | "| \(join(" | ")) |"' "$work/$name.verified"
  done
}

round_trips() {
  local out whole mass
  whole=$(jq .mass_m2 "$work/cumulus.stats")
  echo "| way | mass - 1, % |"
  echo "|---|---|"
  for out in back.npy back.vdb back.nc back_slices; do
    nephele export --quiet --set "$work/cumulus_set.json" --voxel-m 16 --out "$work/$out"
    local arguments=()
    [[ $out == back.npy ]] && arguments=(--voxel-m 16)
    if [[ $out == back_slices ]]; then
      arguments=(--voxel-m 16 --extinction-per-m-per-unit "$(jq -r '.extinction_per_m_per_unit' "$work/$out"/*.json)")
    fi
    nephele import --quiet "$work/$out" "${arguments[@]}" --out "$work/again.json" --stats "$work/again.stats"
    mass=$(jq .mass_m2 "$work/again.stats")
    echo "| set to ${out#back} and back | $(jq -n "($mass / $whole - 1) * 100 | . * 1000 | round / 1000") |"
  done
  # Files that this program did not write: the simulation's, by ncgen, and by OpenVDB's own tool a pyramid of grids.
  vdb_lod "$work/back.vdb" "$work/pyramid.vdb" -name density -range 0-2 >/dev/null 2>&1
  for grid in density_level_0 density_level_1; do
    nephele import --quiet "$work/pyramid.vdb" --grid "$grid" --out "$work/again.json" --stats "$work/again.stats"
    mass=$(jq .mass_m2 "$work/again.stats")
    echo "| $grid of a pyramid by vdb_lod | $(jq -n "($mass / $whole - 1) * 100 | . * 1000 | round / 1000") |"
  done
  nccopy -k cdf5 "$work/back.nc" "$work/copied.nc"
  nephele import --quiet "$work/copied.nc" --out "$work/again.json" --stats "$work/again.stats"
  mass=$(jq .mass_m2 "$work/again.stats")
  echo "| .nc copied to another kind by nccopy | $(jq -n "($mass / $whole - 1) * 100 | . * 1000 | round / 1000") |"
}

motion() {
  echo "Second difference in time of T, RMS over 1600 rays and 40 frames:"
  build/test_cpu --no-skip --test-case="*forty frames*" | sed -n 's/.*MESSAGE: jerk \(.*\)/\1./p'
}

# A file larger than the memory that reads it: 1024^3 numbers, all but a few planes nothing.
large_file() {
  local side=1024 header
  header="{'descr': '<f4', 'fortran_order': False, 'shape': ($side, $side, $side), }"
  printf '\x93NUMPY\x01\x00\x76\x00%-117s\n' "$header" >"$work/large.npy"
  truncate -s $((128 + 4 * side * side * side)) "$work/large.npy"
  for plane in 300 301 302 303; do  # 0.01 /m
    head -c $((4 * side * side)) <(yes $'\x0a\xd7\x23\x3c' | tr -d '\n') |
      dd of="$work/large.npy" bs=1M seek=$((128 + 4 * plane * side * side)) oflag=seek_bytes conv=notrunc status=none
  done
  nephele import --quiet "$work/large.npy" --voxel-m 8 --spacing 16 --out "$work/large_set.json" \
    --stats "$work/large.stats"
  jq -r '"A .npy of \(.voxels) voxels, 4.3 GB: \(.seconds | round) s, \(.peak_memory_bytes / 1048576 | round) MiB of " +
    "memory at most."' "$work/large.stats"
}

# 2000 clouds of 20 sets within 60 km against the procedural sky, of about as many visible particles.
instances() {
  local seed sets="" scene
  for seed in $(seq 20); do
    nephele grow gaussian --seed "$seed" --out "$work/g$seed.json"
    sets+="${sets:+,}{\"file\": \"g$seed.json\"}"
  done
  local eye='"position_m": [0,0,2600], "yaw_deg": 30, "pitch_deg": -5'
  local view='"camera": {'$eye'}, "sun": {"azimuth_deg": 250, "elevation_deg": 40}'
  cat >"$work/scattered.scene" <<JSON
{$view, "sources": [{"kind": "scatter", "sets": [$sets], "clouds_per_km2": 0.18, "altitude_m": 1000,
                     "view_distance_m": 60000}]}
JSON
  cat >"$work/field.scene" <<JSON
{$view, "clouds": {"coverage": 0.44, "base_m": 1000, "thickness_m": 900, "view_distance_m": 60000}}
JSON
  cat >"$work/path.json" <<JSON
{"fps": 10, "keys": [{"time_s": 0, $eye}, 
  {"time_s": 10, "position_m": [1000,1700,2600], "yaw_deg": 30, "pitch_deg": -5}]}
JSON
  echo "| sky | particles | visible | shaded pairs | ms a frame | of them source | light | shading |"
  echo "|---|---|---|---|---|---|---|---|"
  for scene in scattered field; do
    local more=()
    [[ $scene == field ]] && more=(--ring-size-cells 184 --layer-count 7)
    nephele render --quiet --scene "$work/$scene.scene" --size 640x360 --quality low "${more[@]}" \
      --path "$work/path.json" --frames 6 --warmup 2 --out "$work/frame%d.png" --stats "$work/$scene.stats.json"
    jq -r --arg name "$scene" 'def pass(n): [.passes[] | select(.name == n) | .ms] | add // 0 | round;
      [$name, .particles_generated, .particles_visible, .pairs_shaded, (.frame_ms.median | round),
       pass("scatter") + pass("field"), pass("light_field"), pass("shade_blend")] | "| \(join(" | ")) |"' \
      "$work/$scene.stats.json"
  done
}

torus() {  # an OBJ file
  awk 'BEGIN {
    n = 48; m = 24; pi = 3.14159265358979
    for (i = 0; i < n; ++i) for (j = 0; j < m; ++j) {
      a = 2 * pi * i / n; b = 2 * pi * j / m; r = 1 + 0.42 * cos(b)
      printf "v %f %f %f\n", r * cos(a), 0.42 * sin(b), r * sin(a)
    }
    for (i = 0; i < n; ++i) for (j = 0; j < m; ++j) {
      p = i * m + j; q = ((i + 1) % n) * m + j; r = ((i + 1) % n) * m + (j + 1) % m; s = i * m + (j + 1) % m
      printf "f %d %d %d\nf %d %d %d\n", p + 1, q + 1, r + 1, p + 1, r + 1, s + 1
    }
  }'
}

picture() {
  torus >"$work/torus.obj"
  nephele grow gaussian --seed 4 --out "$work/p_gaussian.json"
  nephele grow l_system --seed 3 --out "$work/p_l_system.json"
  nephele grow metaballs --seed 1 --out "$work/p_metaballs.json"
  nephele grow mesh --mesh "$work/torus.obj" --out "$work/p_mesh.json"
  nephele import --quiet "$work/cumulus.npy" --voxel-m 16 --spacing 3 --out "$work/p_cumulus.json"
  nephele import --quiet "$work/simulated.nc" --spacing 2 --out "$work/p_simulated.json"
  local rows=() name at far near fov
  for name in gaussian l_system metaballs mesh cumulus simulated; do
    at="[0,0,1000]" far="[-4200,-4200,1300]" near="[-1300,-1500,1500]" place="[0,0,1500]" fov=34
    [[ $name == cumulus ]] && at="[-1024,-1024,900]" place="[0,0,1750]"
    [[ $name == simulated ]] &&
      at="[-2048,-2048,0]" far="[-4200,-4200,1500]" near="[-1800,-1800,1700]" place="[0,0,1250]"
    local frames=() elevation from
    for elevation in 60 8; do
      for from in "$far" "$near"; do
        scene_of "$work/p_$name.json" "$from" "$place" "$fov" "$at" "$elevation" >"$work/p.scene"
        [[ $from == "$near" ]] && sed -i "s/\"vertical_fov_deg\": $fov/\"vertical_fov_deg\": 55/" "$work/p.scene"
        frames+=("$work/p_$name.${#frames[@]}.png")
        nephele render --quiet --scene "$work/p.scene" --size 640x360 --out "${frames[-1]}"
      done
    done
    convert "${frames[@]}" -scale 400x225! +append "$work/row_$name.png"
    rows+=("$work/row_$name.png")
  done
  convert "${rows[@]}" -append "$work/sources.png"
  mv "$work/sources.png" docs/pictures/sources.png
  cat >"$work/grown.scene" <<JSON
{"camera": {"position_m": [-1700,-1700,1400], "look_at_m": [0,0,1500], "vertical_fov_deg": 50},
 "sun": {"azimuth_deg": 300, "elevation_deg": 30},
 "sources": [{"kind": "set", "file": "p_gaussian.json", "at_m": [0,0,1000], "drifts": false},
             {"kind": "set", "file": "p_metaballs.json", "at_m": [2500,200,1000], "drifts": false},
             {"kind": "set", "file": "p_l_system.json", "at_m": [200,2500,1000], "drifts": false}]}
JSON
  nephele render --quiet --scene "$work/grown.scene" --size 1280x720 --out docs/pictures/grown.png
}

if [[ $what != --pictures ]]; then
  marked_block docs/sources.md volumes volume_table
  marked_block docs/sources.md levels level_table
  marked_block docs/sources.md trips round_trips
  marked_block docs/sources.md motion motion
  marked_block docs/sources.md large large_file
  marked_block docs/sources.md instances instances
fi
[[ $what == --figures ]] || picture
