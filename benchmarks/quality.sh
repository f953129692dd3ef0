#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Meshes every slice file of a folder with the default options, with long elements (--size 10h), with bundles of three slices
# (--lump 3) and with columns kept (--keep-columns), and puts the tables of all figures, each beside what it must and should be,
# into docs/quality.md.
#
#   bash benchmarks/quality.sh build/test/src/slice2mesh ../shared/data
#
# The files are those of DATA/reference, or of DATA where there is no such folder. Open lines become supports of 0.1 mm or of a
# tenth of the layer thickness, whichever is said in SLICE2MESH_SUPPORT_RADIUS (default 0.1). SLICE2MESH_QUALITY_RUNS is the number
# of runs of which the median time is taken (default 1), SLICE2MESH_RUN_LIMIT the limit of one run in seconds of wall-clock time
# (default 600), SLICE2MESH_QUALITY_PAGE the page (`-`: print the tables), SLICE2MESH_QUALITY_TABLES `summary` for the table of the
# goals with default options alone (see shapes.sh). Fails if a run does; a figure that misses its goal is told, not an error.
set -euo pipefail
if [ $# -ne 2 ]; then
  echo "usage: quality.sh PROGRAM DATA" >&2
  exit 1
fi
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
program=$(realpath "$1")
data=$2
if [ -d "$data/reference" ]; then data=$data/reference; fi
radius=${SLICE2MESH_SUPPORT_RADIUS:-0.1}
runs=${SLICE2MESH_QUALITY_RUNS:-1}
tables=${SLICE2MESH_QUALITY_TABLES:-all}
page=${SLICE2MESH_QUALITY_PAGE:-$here/../docs/quality.md}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
seen=0
failed=0

# mesh <configuration> <options>...
mesh() {
  local configuration=$1 file name code run output=()
  shift
  mkdir -p "$work/$configuration"
  printf '%s\t%s\n' "$configuration" "--support-radius $radius${*:+ $*}" >>"$work/configurations.tsv"
  for file in "${files[@]}"; do
    name=$(basename "$file" .cli)
    # Dihedral angles in the metric are measured on the mesh itself: TetGen's files are plain text.
    if [ "$configuration" = size10h ]; then output=(-o "$work/$configuration/$name.node"); fi
    for ((run = 1; run <= runs; ++run)); do
      code=0
      /usr/bin/time -f '%e\t%U\t%S\t%M' -o "$work/time" timeout "${SLICE2MESH_RUN_LIMIT:-600}" "$program" --quiet "$file" \
        -o "$work/mesh.vtu" ${output[@]+"${output[@]}"} --report "$work/$configuration/$name.json" --support-radius "$radius" "$@" \
        >/dev/null 2>"$work/$configuration/$name.err" || code=$?
      seen=$((seen + 1))
      printf '%s\t%s\t%d\t%s\n' "$configuration" "$name" "$code" "$(tail -n 1 "$work/time")" >>"$work/runs.tsv"
      printf '%-10s %-28s exit %d, %s\n' "$configuration" "$name" "$code" "$(tail -n 1 "$work/time" | tr '\t' ' ')" >&2
      if [ "$code" -ne 0 ]; then
        failed=$((failed + 1))
        tail -n 1 "$work/$configuration/$name.err" >&2
        break
      fi
    done
  done
}

mapfile -t files < <(find "$data" -maxdepth 1 -name '*.cli' | LC_ALL=C sort)
if [ "${#files[@]}" -eq 0 ]; then
  echo "quality.sh: no slice files in $data" >&2
  exit 1
fi
mesh default
if [ "$tables" = all ]; then
  mesh size10h --size 10h
  mesh lump3 --lump 3
  mesh columns --keep-columns
fi
python3 "$here/quality_table.py" "$work" "$page" "$tables"
echo "$((seen - failed)) runs passed, $failed failed" >&2
[ "$failed" -eq 0 ]
