#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Fills the slice files of a folder with every tetrahedralizer and prints the table of docs/tetrahedralizers.md: tets, R/3r,
# tets that cross layers, largest error of a layer's volume, user seconds and peak memory of the whole run, or how it failed.
#
#   bash benchmarks/meshers.sh build/test/src/slice2mesh ../shared/data/reference [part of a file name ...]
#
# Without names: T_supported, pyramid, torus_coarse, joint, nugear_coarse. SLICE2MESH_RUN_LIMIT is the limit of one run in
# seconds of wall-clock time (default 120), SLICE2MESH_SUPPORT_RADIUS half the width of open lines (default 0.1). What the program was built
# without, or the machine does not have, is left out and named at the end.
set -euo pipefail
program=$(realpath "$1")
data=$2
shift 2
names=("$@")
if [ "${#names[@]}" -eq 0 ]; then names=(T_supported pyramid torus_coarse joint nugear_coarse); fi
limit=${SLICE2MESH_RUN_LIMIT:-120}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
missing=()
rows=0

# run <title> <mesher> <arguments> <further options of the program>...
run() {
  local title=$1 mesher=$2 arguments=$3
  shift 3
  local code=0 options=(--mesher "$mesher")
  if [ -n "$arguments" ]; then options+=(--mesher-args "$arguments"); fi
  /usr/bin/time -f '%U %M' -o "$work/time" timeout $((limit + 60)) "$program" "$file" --time-limit "$limit" \
    --support-radius "${SLICE2MESH_SUPPORT_RADIUS:-0.1}" "${options[@]}" "$@" >"$work/out" 2>"$work/err" || code=$?
  local whole memory
  read -r whole memory < <(tail -n 1 "$work/time")
  if [ "$code" -ne 0 ] && [ "$code" -ne 4 ]; then
    local why
    why=$(sed -n 's/^slice2mesh: //p' "$work/err" | tail -n 1)
    case "$why" in
      *"was built without"* | *"was built with a CGAL before"*)
        missing+=("$title")
        return
        ;;
    esac
    printf '| %s | %s | failed: %s | | | | %s | %d |\n' "$name" "$title" "${why:-code $code}" "$whole" $((memory / 1024))
    rows=$((rows + 1))
    return
  fi
  value() { sed -n "s|^$1  *||p" "$work/out" | head -n 1; }
  local ratio slab_error crossing note=''
  ratio=$(value R/3r)
  crossing=$(value 'tets that cross' | sed 's/ lie in .*//')
  # What is left of rounding is not told.
  slab_error=$(value 'volume error' | sed 's/.*largest of a layer \(.*\) % (layer.*/\1/' |
    awk '{ if ($1 < 1e-6) print "< 1e-6 %"; else printf "%.3g %%\n", $1 }')
  if [ "$code" -eq 4 ]; then note=' (a promise does not hold)'; fi
  printf '| %s | %s%s | %s | %s | %s | %s | %s | %d |\n' "$name" "$title" "$note" "$(value tets)" \
    "$(sed 's/mean \([^,]*\),.*worst \(.*\)/\1 \/ \2/' <<<"$ratio")" "${crossing:-0 (0 %)}" "${slab_error:-< 1e-6 %}" "$whole" \
    $((memory / 1024))
  rows=$((rows + 1))
}

has() {
  command -v "$1" >/dev/null && return 0
  missing+=("the program $1")
  return 1
}
gmsh_command='printf "Merge \"skin.stl\";\nSurface Loop(1) = {1};\nVolume(1) = {1};\n" >part.geo; : {skin:stl}; gmsh -3 part.geo -o {out}'

echo '| file | tetrahedralizer | tets | R/3r mean / worst | tets that cross | volume error of a layer | s | MiB |'
echo '|---|---|---|---|---|---|---|---|'
for pattern in "${names[@]}"; do
  while IFS= read -r file; do
    name=$(basename "$file" .cli)
    run 'slab' slab ''
    run 'slab, slivers left' slab '' --improve-rounds 0
    run 'tetgen' tetgen ''
    run 'tetgen, -q1.6' tetgen pq1.6T1e-13
    run 'mesh3' mesh3 ''
    run 'mesh3, slivers left' mesh3 'perturb=no exude=no'
    run 'cdt3' cdt3 ''
    if has tetgen; then run 'command: tetgen -p' 'tetgen -p179.99999T1e-13Q {in:poly}' ''; fi
    if has gmsh; then run 'command: gmsh -3 (skin)' "$gmsh_command" ''; fi
  done < <(find "$data" -name "*$pattern*.cli" | sort)
done
printf '\nA run may take %d s of wall-clock time.' "$limit"
if [ "${#missing[@]}" -gt 0 ]; then
  printf ' Left out, as it is not here: '
  printf '%s\n' "${missing[@]}" | sort -u | paste -sd ';' -
else
  echo
fi
[ "$rows" -gt 0 ]
