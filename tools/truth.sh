#!/usr/bin/env bash
# Path-traces the truth set again: for every scene in tools/truth/ NAME.exr (the whole picture and its standard error),
# NAME_layers.exr (the cloud layer alone) and NAME.png, until the pixels' mean relative standard error is below 1 %.
# Minutes to an hour each on two quiet cores; interrupted, it goes on where it was.
#   tools/truth.sh [NAME...]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

tools/setup.sh
cmake --preset release >/dev/null
cmake --build --preset release --target nephele_program >/dev/null

scenes=("$@")
[[ ${#scenes[@]} -gt 0 ]] ||
  scenes=(cloud_front cloud_side cloud_back field_side field_above inside low_sun overcast congestus dense)
size_of() { [[ $1 == inside ]] && echo 48x27 || echo 80x45; }  # inside, every pixel is cloud, and smooth
work=out/truth
mkdir -p "$work"
for name in "${scenes[@]}"; do
  started=$SECONDS
  build/nephele reference --scene "tools/truth/$name.json" --size "$(size_of "$name")" --noise 0.01 --resume \
    --out "$work/$name.exr" --layers "$work/${name}_layers.exr" --picture "$work/$name.png" 2>"$work/$name.txt"
  mv "$work/$name.exr" "$work/${name}_layers.exr" "$work/$name.png" tools/truth/
  rm -f "$work/$name.exr.state"
  # | name | samples a pixel | mean relative standard error |
  touch tools/truth/summary.md
  sed -i "/^| $name |/d" tools/truth/summary.md
  sed -n "s/.*: \\([0-9]*\\) samples a pixel, mean relative standard error \\(.*\\)/| $name | \\1 | \\2 |/p" \
    "$work/$name.txt" >>tools/truth/summary.md
  sort -o tools/truth/summary.md tools/truth/summary.md
  echo "$name: $((SECONDS - started)) s"
done
