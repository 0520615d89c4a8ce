#!/usr/bin/env bash
# Writes a volume to try nephele import with: a cumulus by formula on 128 x 128 x 128 voxels of 16 m, indexed [x][y][z].
#   tools/sample_volume.sh OUT.npy [N [X Y Z]]     N voxels a side; its matter moved by X, Y, Z metres
set -euo pipefail
out=${1:?usage: tools/sample_volume.sh OUT.npy [N [X Y Z]]}
out=$(realpath -m -- "$out")
shift
cd "$(dirname "${BASH_SOURCE[0]}")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
${CXX:-c++} -std=c++20 -O2 -ffp-contract=off -I. -o "$work/sample_volume" tools/sample_volume/sample_volume.cpp
"$work/sample_volume" "$@" >"$work/volume.npy"
mv "$work/volume.npy" "$out"
echo "$out"
