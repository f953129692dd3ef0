#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Makes the tables and plots of docs/benchmarks.md: builds the benchmarks and the program optimized, runs every stage on all families of
# generated slices, all tetrahedralizers that are there on some of them, and the compiler on every header. An idle machine is
# needed, and about 25 minutes; with --full an hour and a half.
#
#   bash benchmarks/benchmarks.sh [--full] [build directory, default build/benchmarks]
#
# --full                      the largest members of the families too, and every header three times instead of once
# SLICE2MESH_BENCHMARK_PARTS  what is measured: "stages meshers headers" (default: all three)
# SLICE2MESH_BENCHMARK_ARGS   for Google Benchmark, e.g. --benchmark_filter=whole (default: 3 repetitions of 0.1 s)
# SLICE2MESH_RUN_LIMIT        seconds of wall-clock time, of one run of a tetrahedralizer (default 60, with --full 600)
# SLICE2MESH_BENCHMARK_NOTE   a sentence about the circumstances, for the page
# The measured times stay in the build directory: benchmarks.json, for compare.py; meshers.md, headers.md.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/jobs.sh
full=
if [ "${1:-}" = --full ]; then
  full=1
  shift
fi
build=${1:-build/benchmarks}
parts=${SLICE2MESH_BENCHMARK_PARTS:-stages meshers headers}
# A filter that begins with a minus says what is left out.
usual='--benchmark_repetitions=3 --benchmark_min_time=0.1'
if [ -z "$full" ]; then usual+=' --benchmark_filter=-points:1024|layers:32'; fi
read -ra arguments <<<"${SLICE2MESH_BENCHMARK_ARGS:-$usual}"
export SLICE2MESH_RUN_LIMIT=${SLICE2MESH_RUN_LIMIT:-$([ -n "$full" ] && echo 600 || echo 60)}

cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DSLICE2MESH_BUILD_TESTS=OFF -DSLICE2MESH_WERROR=OFF \
  -DSLICE2MESH_TEST_FLAGS= -DSLICE2MESH_UNITY=ON -DSLICE2MESH_WITH_TETGEN="${SLICE2MESH_WITH_TETGEN:-OFF}"
cmake --build "$build" --parallel "$(slice2mesh_jobs)" --target slice2mesh_benchmarks slice2mesh_program
stages=- meshers=- headers=-
if [[ " $parts " == *" stages "* ]]; then
  stages=$build/benchmarks.json
  "$build/benchmarks/slice2mesh_benchmarks" "${arguments[@]}" "--benchmark_out=$stages" --benchmark_out_format=json
fi
if [[ " $parts " == *" meshers "* ]]; then
  meshers=$build/meshers.md
  "$build/benchmarks/slice2mesh_benchmarks" --write "$build/slices"
  bash benchmarks/meshers.sh "$build/src/slice2mesh" "$build/slices" points_64 slope_50 noise_5 | tee "$meshers"
fi
if [[ " $parts " == *" headers "* ]]; then
  headers=$build/headers.md
  python3 benchmarks/header_cost.py --runs "$([ -n "$full" ] && echo 3 || echo 1)" >"$headers"
fi
# The plots need matplotlib, which the python of the distribution may have when another one comes first.
python=python3
if ! "$python" -c 'import matplotlib' 2>/dev/null && [ -x /usr/bin/python3 ]; then python=/usr/bin/python3; fi
"$python" benchmarks/benchmark_page.py "$stages" "$meshers" "$headers" docs/benchmarks.md docs/images
