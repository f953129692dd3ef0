#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Runs the program on every slice file of a folder and prints a table: exit code, seconds, peak memory, tets, R/3r, dihedral angles,
# columns, largest deviation. Fails if a run does. Further arguments go to the program.
#
#   bash benchmarks/corpus.sh build/test/src/slice2mesh ../shared/data [--lump 3 ...]
#
# Files with open lines get supports of 0.1 mm or a tenth of the layer thickness, whichever is said in SLICE2MESH_SUPPORT_RADIUS
# (default 0.1). SLICE2MESH_RUN_LIMIT is the limit of one run in seconds (default 60).
set -euo pipefail
program=$(realpath "$1")
data=$2
shift 2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0
seen=0
printf '%-48s %4s %7s %8s %10s %s\n' file exit seconds MiB tets 'R/3r; dihedral angles; columns; deviation / eps (mm)'
while IFS= read -r file; do
  seen=$((seen + 1))
  code=0
  /usr/bin/time -f '%e %M' -o "$work/time" timeout "${SLICE2MESH_RUN_LIMIT:-60}" "$program" --quiet "$file" \
    -o "$work/mesh.vtu" --support-radius "${SLICE2MESH_SUPPORT_RADIUS:-0.1}" "$@" >"$work/out" 2>"$work/err" || code=$?
  read -r seconds memory < <(tail -n 1 "$work/time")
  value() { sed -n "s|^$1  *||p" "$work/out" | head -n 1; }
  printf '%-48s %4d %7s %8d %10s %s; %s; %s; %s / %s\n' "$(basename "$file")" "$code" "$seconds" "$((memory / 1024))" \
    "$(value tets)" "$(value R/3r)" "$(value 'dihedral angles')" "$(value columns)" "$(value 'largest deviation')" "$(value eps)"
  if [ "$code" -ne 0 ]; then
    tail -n 1 "$work/err"
    failed=$((failed + 1))
  fi
done < <(find "$data" -name '*.cli' | sort)
echo "$((seen - failed)) passed, $failed failed"
[ "$seen" -gt 0 ] && [ "$failed" -eq 0 ]
