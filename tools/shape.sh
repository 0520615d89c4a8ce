#!/usr/bin/env bash
# Measures the clouds' shape and its steadiness and writes the figures of docs/shape.md. Some seven minutes on two
# cores.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/marked_block.sh

tools/setup.sh jq
cmake --preset release >/dev/null
cmake --build --preset release --target nephele_program test_study test_pass >/dev/null
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# A table: titles, then rows from a file.
table() {
  echo "$1"
  sed 's/[^|]//g; s/|/|---/g; s/---$//' <<<"$1"
  cat "$2"
}

build/test_study --no-skip --test-case="ball index study" | grep '^| ' >"$work/balls.txt"
build/test_study --no-skip --test-case="structure study" | grep '^| ' >"$work/structure.txt"
build/test_study --no-skip --test-case="shape study" >"$work/shape.txt"
build/test_pass --success --test-case="*without a step*,structured layer*" |
  sed -n 's/.*MESSAGE: /- /p' >"$work/steps.txt"

document=docs/shape.md
marked_block "$document" balls table \
  "| scene | structure, field | structure, tables | smooth, field | smooth, tables |" "$work/balls.txt"
marked_block "$document" structure table "| scene | 1 against 16 samples, relMSE | specks |" "$work/structure.txt"
for figures in \
  "outlines:| scene | clouds | dimension | size slope |" \
  "spectrum:| scene | stretches | exponent | least | most | where most |" \
  "sides:| scene | lit over lee | traced | top over base | traced |"; do
  sed -n "s/^${figures%%:*} //p" "$work/shape.txt" >"$work/rows.txt"
  marked_block "$document" "${figures%%:*}" table "${figures#*:}" "$work/rows.txt"
done
marked_block "$document" steps cat "$work/steps.txt"
echo "$document"
