#!/usr/bin/env bash
# From a fresh Debian machine to a picture of a cumulus sky. Arguments go on to `nephele render`, after the demo's own.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

picture=out/demo.png
previous=
for argument in "$@"; do
  [[ $previous == --out ]] && picture=$argument
  [[ $argument == --out=* ]] && picture=${argument#--out=}
  previous=$argument
done

tools/setup.sh
cmake --preset release
cmake --build --preset release --target nephele_program
mkdir -p out
build/nephele render --scene tools/scenes/fair_weather.json --size 1280x720 --out out/demo.png "$@"
echo "The picture is $(realpath "$picture" 2>/dev/null || echo "$picture")"
