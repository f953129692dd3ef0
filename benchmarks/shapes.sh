#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Meshes that nothing was tuned to: cuts closed triangle meshes (OFF, STL, OBJ, PLY) into layers of a 35th and of a 60th of their
# largest extent, meshes all slices with the default options, and puts how many meet the goals, and which do not, into
# docs/quality.md.
#
#   bash benchmarks/shapes.sh build/test/src/slice2mesh build/test/examples/slices_from_mesh FOLDER...
#
# Files that are no closed meshes of triangles are left out, and slices that are those of another file; how many is told.
# SLICE2MESH_SHAPE_LAYERS are other numbers of layers (default "35 60"); the variables of quality.sh hold here too.
set -euo pipefail
if [ $# -lt 3 ]; then
  echo "usage: shapes.sh PROGRAM SLICER FOLDER..." >&2
  exit 1
fi
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
program=$1
slicer=$(realpath "$2")
shift 2
slices=$(mktemp -d)
trap 'rm -rf "$slices"' EXIT
mapfile -t meshes < <(find "$@" -maxdepth 1 -type f | grep -iE '\.(off|stl|obj|ply)$' | LC_ALL=C sort)
declare -A seen=()
refused=0
again=0
for mesh in ${meshes[@]+"${meshes[@]}"}; do
  name=$(basename "$mesh")
  for layers in ${SLICE2MESH_SHAPE_LAYERS:-35 60}; do
    file=$slices/${name//./_}_$layers.cli
    # A mesh that crosses itself may make the slicer give up.
    if ! timeout 60 "$slicer" "$mesh" "$file" "1/$layers" >/dev/null 2>&1; then
      refused=$((refused + 1))
      continue
    fi
    sum=$(sha256sum <"$file")
    if [ -n "${seen[$sum]-}" ]; then
      again=$((again + 1))
      rm "$file"
    fi
    seen[$sum]=1
  done
done
echo "${#meshes[@]} meshes: $(find "$slices" -name '*.cli' | wc -l) stacks of slices, $refused not to be cut, $again the same as others" >&2
SLICE2MESH_QUALITY_TABLES=summary bash "$here/quality.sh" "$program" "$slices"
