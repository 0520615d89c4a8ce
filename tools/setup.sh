#!/usr/bin/env bash
# Installs the Debian packages that Nephele builds and runs with, and only those that are missing. Needs root or
# sudo when something is missing; asks nothing. Arguments are further packages that one script alone needs.
# Elsewhere than on Debian it leaves the packages to you.
set -euo pipefail

packages=(
  g++ cmake ninja-build pkg-config   # to build
  glslang-tools                      # shaders to SPIR-V
  libvulkan-dev mesa-vulkan-drivers  # Vulkan and lavapipe, which needs no GPU
  libspirv-cross-c-shared-dev        # shader reflection
  libglm-dev libeigen3-dev           # vectors; linear algebra of the bake
  libcli11-dev nlohmann-json3-dev    # command line, scene files
  libopenexr-dev libstb-dev          # EXR and PNG images
  libglfw3-dev libimgui-dev          # the window of nephele fly
  libassimp-dev                      # meshes for nephele grow mesh
  libopenvdb-dev libboost-dev        # volumes of clouds in OpenVDB, whose headers need Boost's
  libnetcdf-dev                      # and in NetCDF: nephele import and export
  doctest-dev vulkan-validationlayers  # tests
  clang-format                       # the check of the code's format
  "$@"
)

if ! command -v dpkg-query >/dev/null; then
  echo "setup: not a Debian system; these packages' contents are needed: ${packages[*]}" >&2
  exit 0
fi

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
  [[ $status == installed ]] || missing+=("$package")
done
[[ ${#missing[@]} -eq 0 ]] && exit 0

as_root=()
if [[ $(id -u) -ne 0 ]]; then
  if ! command -v sudo >/dev/null; then
    echo "setup: neither root nor sudo; install these packages first: ${missing[*]}" >&2
    exit 2
  fi
  as_root=(sudo)
fi

echo "setup: installing ${missing[*]}"
apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Acquire::Retries=3 -o Dpkg::Use-Pty=0)
"${apt[@]}" update </dev/null
"${apt[@]}" install -y --no-install-recommends "${missing[@]}" </dev/null >/dev/null  # errors still reach stderr
