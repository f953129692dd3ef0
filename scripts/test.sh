#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The tests, from nothing: installs what is missing, builds everything with warnings as errors, runs all tests.
#
#   bash scripts/test.sh [arguments of ctest]      e.g. bash scripts/test.sh -L fast
#
# SLICE2MESH_TEST_BUILD   the build directory (default build/test)
# SLICE2MESH_SHARED_DATA  directory with slice files for the tests labelled `corpus`, which say so where it is absent
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/jobs.sh
build=${SLICE2MESH_TEST_BUILD:-build/test}
jobs=$(slice2mesh_jobs)

bash scripts/bootstrap.sh --tests
# The pipeline as it is delivered; the rest with less optimization, and sources joined, which takes half the time to compile.
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DSLICE2MESH_TEST_FLAGS=-O1 -DSLICE2MESH_UNITY=ON \
  -DSLICE2MESH_WERROR=ON -DSLICE2MESH_WITH_ZLIB=ON -DSLICE2MESH_WITH_TETGEN=ON
cmake --build "$build" --parallel "$jobs"
ctest --test-dir "$build" --output-on-failure --no-tests=error --parallel "$jobs" "$@"
