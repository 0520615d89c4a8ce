#!/usr/bin/env bash
# clang-tidy (.clang-tidy) over the C++ sources, one process a core; fails where there is a finding, and goes on with
# the other files. Needs build/ configured and its generated headers built. All sources take ten minutes on two cores.
# Version 16, which Debian 12 has: older ones cannot read lambdas that capture structured bindings.
#   tools/tidy.sh [FILE...]     default: every .cpp of engine, lut, passes, tools and tests that git tracks
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

tools/setup.sh clang-tidy-16
[[ -s build/compile_commands.json ]] || cmake --preset release
cmake --build --preset release --target nephele_shaders nephele_tool_shaders nephele_test_shaders \
  nephele_program_commit generated/nephele_lut/lut_hash.h
if [[ $# == 0 ]]; then
  mapfile -t files < <(git ls-files 'engine/*.cpp' 'lut/*.cpp' 'passes/*.cpp' 'tools/*.cpp' 'tests/*.cpp' |
    grep -v '^tools/embed_example/')
else
  files=("$@")
fi
printf '%s\0' "${files[@]}" | xargs -0 -n 1 -P "$(nproc)" clang-tidy-16 -p build --quiet
echo "tidy: ${#files[@]} files are clean"
