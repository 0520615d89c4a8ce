#!/usr/bin/env bash
# Measures the tables' accuracy and cost on this machine and writes the figures of docs/tables.md: bakes with --verify
# into a scratch directory. Some ten minutes.
#   tools/tables_study.sh [PROGRAM]     PROGRAM: default build/nephele; test_gpu and test_study are expected beside it
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/marked_block.sh
tools/setup.sh jq
program=${1:-build/nephele}
[[ -x $program ]] || { echo "tables_study: $program is missing; build it first (tools/demo.sh)" >&2; exit 2; }
tests=$(dirname "$program")
for test in "$tests/test_gpu" "$tests/test_study"; do
  [[ -x $test ]] || { echo "tables_study: $test is missing; build it first (tools/test.sh)" >&2; exit 2; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

bake() {  # name arguments...
  local name=$1; shift
  "$program" bake --quiet --out "$work/$name" --stats "$work/$name.json" "$@"
}
# The rows that a filter makes of NAME's scattering (depth: optical-depth) JSON, with percentages to three digits.
jq_lib='
  def pct:
    if fabs < 0.0000005 then "0"
    else . * 100 | (if fabs >= 10 then (. * 10 | round / 10) else (. * 100 | round / 100) end) + 0 | tostring end;
  def share4: (. * 10000 | round / 10000 | tostring);
  def share: (. * 1000 | round / 1000 | tostring);'
rows() { jq -r "$jq_lib $2" "$work/$1/multiple_scattering.json"; }
depth() { jq -r "$jq_lib $2" "$work/$1/optical_depth.json"; }
paper() { jq -r "$jq_lib $2" "$work/paper/paper_$1.json"; }
seconds() { jq -r '.seconds * 10 | round / 10' "$work/$1.json"; }
kib() { echo $(($(stat -c %s "$1") / 1024)); }

tiny=(--size-optical-depth 4)
bake default --verify
bake g0 "${tiny[@]}" --g-single 0 --g-multiple 0 --verify
bake g07 "${tiny[@]}" --g-single 0.9 --g-multiple 0.7 --verify
bake g09 "${tiny[@]}" --g-single 0.9 --g-multiple 0.9 --verify
bake cs "${tiny[@]}" --phase cs --verify
bake paper --preset paper --verify
bake fast --preset fast --size-optical-depth 32
bake loose "${tiny[@]}" --residual 0.001
bake small "${tiny[@]}" --size-scattering 24x12x16
bake large "${tiny[@]}" --size-scattering 96x48x16
bake minus "${tiny[@]}" --g-single -0.9 --g-multiple -0.9
bake peaked "${tiny[@]}" --g-single 0.95 --g-multiple 0.95
for n in 16 24 40; do bake "depth$n" --preset fast --size-scattering 4x3x4 --residual 0.01 --size-optical-depth $n; done

# The functions below print the lines of a block each.
single() {  # rows|paper, name, which of the rows
  echo "| optical radius | RMSE | 99th percentile of the error / RMS value |"
  echo "|---|---|---|"
  "$1" "$2" ".verification.single_scattering.rows$3[]"' |
    "| \(.optical_radius[0]) to \(.optical_radius[1]) | \(.relative_rmse | pct) | \(.p99_over_rms | pct) |"'
}
# shellcheck disable=SC2016
all_orders_of() {  # name, what it is called
  rows "$1" '.verification.all_orders.rows[] | "| '"$2"' | \(.optical_radius) | \(.relative_rmse | pct) | " +
    "\(.relative_rmse_at_most | pct) | \(.monte_carlo_noise | pct) | " +
    "\(.relative_bias | pct) ± \(.relative_bias_noise | pct) |"'
}
all_orders() {
  echo "| g | optical radius | RMSE | at most | noise | bias |"
  echo "|---|---|---|---|---|---|"
  all_orders_of g0 0
  all_orders_of g07 0.7
  all_orders_of default 0.85
  all_orders_of g09 0.9
  all_orders_of cs "0.85, Cornette-Shanks"
}
# shellcheck disable=SC2016
identities_of() {
  rows "$1" '"| '"$2"' | " +
    ([.verification.identities.rows[] | "\(.energy | pct) / \(.furnace | pct)"] | join(" | ")) + " |"'
}
identities() {
  rows default '.verification.identities.rows |
    "| g | " + (map(.optical_radius | tostring) | join(" | ")) + " |",
    "|---|" + (map("---") | join("|")) + "|"'
  identities_of g0 0
  identities_of g07 0.7
  identities_of default 0.85
  identities_of g09 0.9
  identities_of cs "0.85, Cornette-Shanks"
}
power() {
  echo "| optical radius | direct | single | orders 2 to 18 | beyond 18 |"
  echo "|---|---|---|---|---|"
  rows g07 '.verification.power_per_order.rows[] |
    "| \(.optical_radius) | \(.direct | share) | \(.single | share) | " +
    "\(.orders_2_to_18 | share) | \(.orders_over_18 | share) |"'
}
scatterings() {
  rows default '[.verification.power_per_order.rows[] |
    "\(.scatterings_over_4_3_optical_radius | share) ± \(.scatterings_standard_error | share)"] | join(", ") + "."'
}
paper_power() {
  echo "| optical radius | table | Monte Carlo | beyond 18, lost |"
  echo "|---|---|---|---|"
  paper multiple_scattering '.verification.power_per_order.rows[] |
    "| \(.optical_radius) | \(.fetched_orders_2_to_18 | share) | " +
    "\(.orders_2_to_18 | share) | \(.orders_over_18 | share) |"'
}
energies() {  # name, what it is called
  local size time errors
  size=$(kib "$work/$1/multiple_scattering.npy")
  time=$(seconds "$1")
  errors=$(rows "$1" '[.error.energy[].relative | pct] | join(" | ")')
  echo "| $2 | $size | $time | $errors |"
}
bakes() {
  local size time errors
  echo "| bake | KiB | seconds | 0.1 | 1 | 4 | 16 | 100 |"
  echo "|---|---|---|---|---|---|---|---|"
  energies default "default"
  energies fast "fast"
  energies small "24x12x16"
  energies large "96x48x16"
  energies loose "residual 0.001"
  energies minus "g = -0.9"
  energies peaked "g = 0.95"
  size=$(kib "$work/paper/paper_multiple_scattering.npy")
  time=$(seconds paper)
  errors=$(paper multiple_scattering '[.verification.energy[].relative | pct] | join(" | ")')
  echo "| paper, g = 0.9, 0.7 | $size | $time | $errors |"
}
transmittance_rms() {  # name
  depth "$1" '.error.transmittance_rms_at_peak_optical_radius_8 | share4'
}
depth_sizes() {
  local n error
  echo "| vertices a side | MiB | RMS error |"
  echo "|---|---|---|"
  for n in 16 24; do
    error=$(transmittance_rms "depth$n")
    echo "| $n | $(awk "BEGIN { printf \"%.2f\", 4 * $n ^ 4 / 1048576 }") | $error |"
  done
  depth default '"| 32 (default) | 4.00 | \(.verification.transmittance_rms | share4) |"'
  error=$(transmittance_rms depth40)
  echo "| 40 | 9.77 | $error |"
  paper optical_depth '"| 64x32x64x32 (paper: angles, RG8) | 8.00 | \(.verification.transmittance_rms | share4) |"'
}
at_32() {
  depth default '.verification |
    "At 32: bias \(.transmittance_bias | share4), 99th percentile \(.transmittance_p99 | share4), " +
    "mean density of the chord \(.mean_density_rms | share4) RMS."'
}
billows() {
  echo "| billows per radius | RMS error |"
  echo "|---|---|"
  depth default '.verification.other_particles[] |
    "| \(.billows_per_radius * 10 | round / 10) | \(.transmittance_rms | share4) |"'
}
axes() {
  echo "| axes | vertices | RMS error of the transmittance |"
  echo "|---|---|---|"
  depth default '.verification.other_axes.maps[] |
    "| \(.axes) | \(.size | map(tostring) | join("x")) | \(.transmittance_rms | share4) |"'
}
study() {  # titles, executable, test case: the rows that it prints
  echo "$1"
  sed 's/[^|]//g; s/|/|---/g; s/---$//' <<<"$1"
  "$tests/$2" --no-skip --test-case="$3" | grep '^|'
}

document=docs/tables.md
marked_block "$document" single single rows default ""
marked_block "$document" "paper single" single paper single_scattering "[2:6]"
marked_block "$document" "all orders" all_orders
marked_block "$document" identities identities
marked_block "$document" power power
marked_block "$document" scatterings scatterings
marked_block "$document" "paper power" paper_power
marked_block "$document" bakes bakes
marked_block "$document" "optical depth" depth_sizes
marked_block "$document" "at 32" at_32
marked_block "$document" billows billows
marked_block "$document" axes axes
titles="| what is looked up | median | fastest | net median |"
marked_block "$document" look-up study "$titles" test_study "table cost study"
titles="| ray | optical radius | single | truth | multiple | truth |"
marked_block "$document" "hard cases" study "$titles" test_gpu "hard cases study"
echo "$document"
