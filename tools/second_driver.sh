#!/usr/bin/env bash
# Renders the scenes of tools/scenes on a second, independent Vulkan driver (SwiftShader, which Debian's Chromium
# brings) and compares each picture with lavapipe's: fails where the relative squared error exceeds 1e-3, where a
# picture cannot be made, or where Vulkan's validation layers have something to say. Takes some minutes.
#   tools/second_driver.sh [--size WxH] [SCENE.json...]     default: 128x72, all scenes
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

largest_error=1e-3
size=128x72
if [[ ${1:-} == --size ]]; then
  size=${2:?--size needs WxH}
  shift 2
fi
scenes=("$@")
[[ ${#scenes[@]} -gt 0 ]] || scenes=(tools/scenes/*.json)

# The driver alone, unpacked from Debian's package and kept; the browser is not installed.
cache=build/second_driver
find_driver() { find "$cache" -name vk_swiftshader_icd.json -print -quit 2>/dev/null; }
fetch_driver() {
  local as_root=() package
  [[ $(id -u) -eq 0 ]] || as_root=(sudo)
  "${as_root[@]}" apt-get -qq -o Acquire::Retries=3 update
  mkdir -p "$cache"
  for package in chromium-common chromium; do
    (cd "$cache" && apt-get -qq -o APT::Sandbox::User=root download "$package")
    dpkg -x "$cache/$package"_*.deb "$cache"
    rm "$cache/$package"_*.deb
    [[ -z $(find_driver) ]] || return 0
  done
  echo "second_driver: neither chromium-common nor chromium brings vk_swiftshader_icd.json" >&2
  return 1
}

tools/setup.sh
[[ -n $(find_driver) ]] || fetch_driver
swiftshader=$(realpath "$(find_driver)")
lavapipe=$(find /usr/share/vulkan/icd.d /etc/vulkan/icd.d -name 'lvp_icd*.json' -print -quit 2>/dev/null || true)
[[ -n $lavapipe ]] || { echo "second_driver: lavapipe's lvp_icd.json was not found" >&2; exit 2; }
cmake --preset release >/dev/null
cmake --build --preset release --target nephele_program >/dev/null

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
on() {  # on DRIVER command...
  local driver=$1
  shift
  VK_DRIVER_FILES=$driver VK_ICD_FILENAMES=$driver "$@"
}

on "$swiftshader" build/nephele devices
printf '%-24s %12s %12s\n' scene relmse bias
failures=0
for scene in "${scenes[@]}"; do
  name=$(basename "$scene" .json)
  [[ $name != *_path ]] || continue  # a camera's path, not a scene
  made=1
  for driver in lavapipe swiftshader; do
    on "${!driver}" build/nephele render --quiet --scene "$scene" --size "$size" --quality low \
      --out "$work/$name.$driver.exr" || made=0
  done
  if [[ $made -eq 0 ]]; then
    printf '%-24s %12s\n' "$name" "no picture"
    failures=$((failures + 1))
    continue
  fi
  errors=$(build/nephele compare "$work/$name.swiftshader.exr" "$work/$name.lavapipe.exr")
  relmse=$(sed -n 's/.*"relmse": \([^,]*\),/\1/p' <<<"$errors")
  bias=$(sed -n 's/.*"bias": \([^,]*\),/\1/p' <<<"$errors")
  verdict=
  awk -v error="$relmse" -v most="$largest_error" 'BEGIN { exit !(error != "null" && error + 0 <= most + 0) }' ||
    { verdict="too far"; failures=$((failures + 1)); }
  printf '%-24s %12.3g %12.3g %s\n' "$name" "$relmse" "$bias" "$verdict"
done

echo "validation, one frame of ${scenes[0]}:"
NEPHELE_VALIDATION=1 on "$swiftshader" build/nephele render --quiet --scene "${scenes[0]}" --size "$size" \
  --quality low --out "$work/validated.exr" 2>"$work/messages" || failures=$((failures + 1))
if [[ -s $work/messages ]]; then
  cat "$work/messages"
  failures=$((failures + 1))
else
  echo "no message"
fi
echo "$failures failed"
[[ $failures -eq 0 ]]
