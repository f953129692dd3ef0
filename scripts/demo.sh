#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# From nothing to a mesh: installs what is missing, builds the program, makes a sample part with a hole, an overhang, a
# sloped wall and line supports, writes it as a CLI file, meshes it, and prints the quality report.
#
#   bash scripts/demo.sh [build directory, default build/demo]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/jobs.sh
build=${1:-build/demo}

bash scripts/bootstrap.sh
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DSLICE2MESH_BUILD_TESTS=OFF \
  -DSLICE2MESH_BUILD_BENCHMARKS=OFF -DSLICE2MESH_PROGRAM_MESH3=OFF -DSLICE2MESH_UNITY=ON -DSLICE2MESH_WERROR=OFF
cmake --build "$build" --parallel "$(slice2mesh_jobs)" --target slice2mesh_program make_sample

sample="$build/sample"
mkdir -p "$sample"
"$build/examples/make_sample" "$sample/sample.cli"
"$build/src/slice2mesh" info "$sample/sample.cli"
echo
"$build/src/slice2mesh" "$sample/sample.cli" --support-radius 0.1 -o "$sample/sample.vtu" -o "$sample/sample.msh" \
  --plc "$sample/sample.off" --report "$sample/sample.json"
echo
echo "Written to $sample:"
for file in sample.cli sample.vtu sample.msh sample.off sample.json; do
  printf '  %-12s %10d bytes\n' "$file" "$(wc -c <"$sample/$file")"
done
