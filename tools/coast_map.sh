#!/usr/bin/env bash
# Draws tools/scenes/coast.png again, the weather map of tools/scenes/coast.json: 128 x 128 texels of 1.25 km, red the
# coverage, green the type. From west to east: small flat clouds over the sea, a clear lane along the coast, a line of
# towers where the sea breeze meets the land's air, and middling clouds over the land.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
tools/setup.sh imagemagick

# x: kilometres east of the coast line, which winds about the map's middle.
awk 'BEGIN {
  print "P3 128 128 255"
  for (row = 0; row < 128; ++row)
    for (column = 0; column < 128; ++column) {
      north = (63.5 - row) * 1.25
      x = (column - 63.5) * 1.25 - 5 * sin(north / 12) - 2 * sin(north / 5 + 1)
      if (x < 0) { coverage = 0.35; type = 0 }
      else if (x < 9) { coverage = 0; type = 0 }
      else if (x < 16) { coverage = 0.8; type = 1 }
      else if (x < 22) { coverage = 0.04; type = 0.3 }
      else { coverage = 0.3; type = 0.4 }
      printf "%d %d 0\n", coverage * 255 + 0.5, type * 255 + 0.5
    }
}' | convert ppm:- -strip -define png:exclude-chunks=all PNG24:tools/scenes/coast.png
echo tools/scenes/coast.png
