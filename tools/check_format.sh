#!/usr/bin/env bash
# Fails on C++ and GLSL that clang-format would change, and on lines over 120 columns in any code, and names the places.
# clang-format 14 (Debian 12's) defines the format; another version differs in details, so its part is left out there.
#   tools/check_format.sh [FILE...]     default: every file that git tracks
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
export LC_ALL=C.UTF-8  # columns are characters, not bytes
columns=120

if [[ $# == 0 ]]; then
  if ! git rev-parse --git-dir >/dev/null 2>&1; then
    echo "check_format: not a git checkout, nothing checked" >&2
    exit 0
  fi
  mapfile -t tracked < <(git ls-files)
  set -- "${tracked[@]}"
fi

formatted=() code=()
for file in "$@"; do
  [[ -f $file ]] || continue  # removed, and not yet committed so
  case $file in
    *.cpp | *.h | *.comp | *.vert | *.frag | *.glsl) formatted+=("$file") code+=("$file") ;;
    *.sh | *.cmake | */CMakeLists.txt | CMakeLists.txt | CMakePresets.json | .ci/run) code+=("$file") ;;
  esac
done

status=0
if [[ ${#code[@]} -gt 0 ]] && grep -nHE "^.{$((columns + 1)),}" "${code[@]}"; then
  echo "check_format: these lines are longer than $columns columns" >&2
  status=1
fi
version=$(clang-format --version 2>/dev/null | sed 's/.*version \([0-9]*\).*/\1/') || version=
if [[ $version != 14 ]]; then
  echo "check_format: clang-format 14 is not here, only the lines' lengths were checked"
elif [[ ${#formatted[@]} -gt 0 ]] && ! clang-format --dry-run -Werror "${formatted[@]}"; then
  echo "check_format: mend these by: clang-format -i FILE" >&2
  status=1
fi
exit "$status"
