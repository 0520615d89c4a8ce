#!/usr/bin/env bash
# Makes tools/scenes/landscape.png again, the heights of tools/scenes/mountains.json and its kin: 512 x 512 texels of
# 78 m, two ranges with a great valley between them, by uplift and rivers (tools/landscape/landscape.cpp).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
tools/setup.sh imagemagick

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
${CXX:-c++} -std=c++20 -O2 -ffp-contract=off -o "$work/landscape" tools/landscape/landscape.cpp
"$work/landscape" | convert pgm:- -strip -define png:exclude-chunks=all -define png:compression-level=9 \
  tools/scenes/landscape.png
echo tools/scenes/landscape.png
