#!/usr/bin/env bash
# Path-traces the truth set again: for every scene in tools/truth/ NAME.exr (the whole picture and its standard error),
# NAME_layers.exr (the cloud layer alone) and NAME.png, until the pixels' mean relative standard error is below what
# noise_of says.
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
size_of() { [[ $1 == inside ]] && echo 96x54 || echo 160x90; }  # inside, every pixel is cloud, and smooth
noise_of() {  # what an hour affords
  case $1 in
    cloud_*) echo 0.02 ;;
    inside) echo 0.03 ;;
    field_side) echo 0.04 ;;
    low_sun) echo 0.05 ;;
    congestus | dense) echo 0.08 ;;
    *) echo 0.06 ;;
  esac
}
work=out/truth
mkdir -p "$work"
for name in "${scenes[@]}"; do
  started=$SECONDS
  build/nephele reference --scene "tools/truth/$name.json" --size "$(size_of "$name")" \
    --noise "$(noise_of "$name")" --resume --out "$work/$name.exr" \
    --layers "$work/${name}_layers.exr" --picture "$work/$name.png" 2>"$work/$name.txt"
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
