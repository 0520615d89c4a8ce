#!/usr/bin/env bash
# Measures the frame on this machine and writes docs/figures.md: medians over 20 frames after 2 warm-up frames.
#   tools/figures.sh [--device NAME_OR_INDEX]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

tools/setup.sh
cmake --preset release
cmake --build --preset release --target nephele_program
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# number FILE KEY: the first value of a numeric key in the (pretty-printed) statistics.
number() { sed -n "s/^ *\"$2\": \([0-9.]*\),*$/\1/p" "$1" | head -n 1; }
text() { sed -n "s/^ *\"$2\": \"\(.*\)\",*$/\1/p" "$1" | head -n 1; }
passes() { sed -n 's/^ *"ms": \([0-9.]*\),*$/\1/p; s/^ *"name": "\(.*\)",*$/\1/p' "$1" | paste - - ; }

measure() {  # name arguments...
  local name=$1; shift
  build/nephele render --quiet --scene tools/scenes/fair_weather.json --stats "$work/$name.json" --frames 20 --warmup 2 \
    --out "$work/frame-%04d.png" "$@"
}
row() {  # name, what it is called
  local file=$work/$1.json shaded
  shaded=$(number "$file" fragments_shaded)
  [[ $shaded == 0 ]] && shaded=$(number "$file" pairs_shaded)
  printf '| %s | %s, %s | %s | %s | %s | %.0f | %.0f |\n' "$2" "$(text "$file" backend)" "$(text "$file" blend)" \
    "$(number "$file" particles_generated)" "$(number "$file" particles_visible)" "$shaded" "$(number "$file" median)" "$(number "$file" p95)"
}

measure small --size 640x360 --quality low --scale 2 --backend attachment "$@"
measure tiled --size 640x360 --quality low --scale 2 --backend tiled "$@"
measure exact --size 640x360 --quality low --scale 2 --backend tiled --blend exact "$@"
measure alpha --size 640x360 --quality low --scale 2 --backend alpha "$@"
measure low --size 1280x720 --quality low "$@"
measure medium --size 1280x720 --quality medium "$@"
measure high --size 1280x720 --quality high "$@"
measure raster --size 1280x720 --quality high --backend attachment "$@"
{
  echo "# Figures of the frame"
  echo
  echo "Written by \`tools/figures.sh\`: scene fair_weather, medians of 20 frames after 2 for warming up, one run, in"
  echo "milliseconds. Device: $(text "$work/small.json" device), $(text "$work/small.json" driver), $(nproc) cores."
  echo "A shared machine is noisy: compare rows of one run, not of two. Shaded: fragments, or pairs of pixel and particle."
  echo
  echo "| image | backend, blend | particles | visible | shaded | median ms | p95 ms |"
  echo "|---|---|---|---|---|---|---|"
  row small "640x360, low, scale 2"
  row tiled "640x360, low, scale 2"
  row exact "640x360, low, scale 2"
  row alpha "640x360, low, scale 2"
  row low "1280x720, low"
  row medium "1280x720, medium"
  row high "1280x720, high"
  row raster "1280x720, high"
  echo
  echo "Passes of the first row and of the high one (medians; a stamp can lag into the next pass on a software"
  echo "device):"
  echo
  echo "| pass | 640x360 low, scale 2 | 1280x720 high |"
  echo "|---|---|---|"
  join -t $'\t' -a 1 <(passes "$work/small.json" | sort) <(passes "$work/high.json" | sort) |
    awk -F'\t' '{printf "| %s | %.1f | %.1f |\n", $1, $2, $3}'
} > docs/figures.md
cat docs/figures.md
