#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Makes sure that what slice2mesh is built with is installed (Debian 12, Ubuntu 24.04 and newer).
#
#   bash scripts/bootstrap.sh [--tests] [--readers] [--style]
#
# --tests    also what the tests need
# --readers  also programs that read our files back in the tests labelled `external` (large: 160 MB to load with deal.II);
#            those that the distribution does not have are left out
# --style    also what checks the style, and Clang for the tests that want a second compiler; likewise
#
# Installs missing packages with apt-get when run as root, or through sudo where that works without a password;
# otherwise names them and ends with code 1. SLICE2MESH_NO_INSTALL=1 never installs anything.
set -euo pipefail

packages=(g++ cmake ninja-build libcgal-dev libeigen3-dev libcli11-dev nlohmann-json3-dev)
readers=()
for argument in "$@"; do
  case "$argument" in
    --tests) packages+=(catch2 zlib1g-dev libnetcdf-dev libtet1.5-dev doxygen python3 libbenchmark-dev) ;;
    --readers)
      readers+=(gmsh python3-vtk9 python3-meshio python3-netcdf4 calculix-ccx freefem++ libfreefem++ libdeal.ii-dev
        tetgen)
      ;;
    --style) readers+=(clang clang-format-14 clang-tidy-14) ;;
    *)
      echo "bootstrap.sh: unknown argument: $argument" >&2
      exit 1
      ;;
  esac
done

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  # Not a Debian: trust CMake to name what is missing, but check the tools.
  for tool in cmake ninja c++; do
    if ! command -v "$tool" >/dev/null; then
      echo "bootstrap.sh: '$tool' is missing. On Debian the packages are: ${packages[*]}" >&2
      exit 1
    fi
  done
  exit 0
fi

is_missing() {
  [ "$(dpkg-query -W -f '${Status}' "$1" 2>/dev/null || true)" != "install ok installed" ]
}
missing=()
for package in "${packages[@]}" ${readers[@]+"${readers[@]}"}; do
  if is_missing "$package"; then missing+=("$package"); fi
done
if [ "${#missing[@]}" -eq 0 ]; then exit 0; fi

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  if command -v sudo >/dev/null && sudo -n true 2>/dev/null; then as_root=(sudo -n); else as_root=(no); fi
fi
if [ -n "${SLICE2MESH_NO_INSTALL:-}" ] || [ "${as_root[*]:-}" = no ]; then
  echo "bootstrap.sh: these packages are missing: ${missing[*]}" >&2
  echo "bootstrap.sh: install them with: sudo apt-get install ${missing[*]}" >&2
  exit 1
fi

echo "bootstrap.sh: installing ${missing[*]}" >&2
export DEBIAN_FRONTEND=noninteractive
# The package lists may be old or absent; if they cannot be renewed, those that are there may still do.
${as_root[@]+"${as_root[@]}"} apt-get update -q </dev/null >&2 || true
available=()
for package in "${missing[@]}"; do
  if [[ " ${readers[*]-} " == *" $package "* ]] && ! apt-cache show "$package" >/dev/null 2>&1; then
    echo "bootstrap.sh: $package is not in this distribution: left out" >&2
  else
    available+=("$package")
  fi
done
if [ "${#available[@]}" -eq 0 ]; then exit 0; fi
${as_root[@]+"${as_root[@]}"} env DEBIAN_FRONTEND=noninteractive \
  apt-get install -y -q --no-install-recommends "${available[@]}" </dev/null >&2
