#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The tests under the address and undefined behavior sanitizers, and the fuzzers for a while. With Clang where it is installed:
# it compiles instrumented code in less time than GCC.
#
#   bash scripts/sanitize.sh [--parts] [--fuzz SECONDS]
#
# --parts         only the modules that are quick to compile: those that read, write and check
# --fuzz SECONDS  then run every fuzz target for so long with new inputs, one per processor at a time (where Clang is installed);
#                 0: a fixed number of inputs, the same every time
#
# What is left out is printed: tests labelled slow, external and corpus, and those that compile projects or check texts.
#
# SLICE2MESH_SANITIZE_BUILD  the build directory (default build/asan); that of the fuzzers has -fuzz at its end
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/jobs.sh
build=${SLICE2MESH_SANITIZE_BUILD:-build/asan}
jobs=$(slice2mesh_jobs)
parts=no
fuzz=none
while [ "$#" -gt 0 ]; do
  case "$1" in
    --parts) parts=yes ;;
    --fuzz)
      fuzz=$2
      shift
      ;;
    *)
      echo "sanitize.sh: unknown argument: $1" >&2
      exit 1
      ;;
  esac
  shift
done

bash scripts/bootstrap.sh --tests
compiler=()
if command -v clang++ >/dev/null; then
  compiler=(-DCMAKE_CXX_COMPILER=clang++)
elif [ "$fuzz" != none ]; then
  echo "sanitize.sh: no clang++: the fuzzers are left out" >&2
  fuzz=none
fi
if [ "$parts" = yes ]; then
  modules=(arrange cli fem io quality)
  programs=(parts_tests)
else
  # Every module that has tests: none is forgotten. `external` runs other programs, `differential` and `metamorphic` compare
  # runs of what the others run too.
  modules=()
  for source in tests/*/*_test.cpp; do
    module=$(basename "$(dirname "$source")")
    if [[ ! " external differential metamorphic ${modules[*]-} " == *" $module "* ]]; then modules+=("$module"); fi
  done
  programs=(slice2mesh_library_tests)
fi
leave_out='slow|external|corpus'
export UBSAN_OPTIONS=print_stacktrace=1
# Sources are joined: headers are instrumented once. Optimized as little as the tests allow (SLICE2MESH_TEST_FLAGS).
cmake --preset asan -B "$build" ${compiler[@]+"${compiler[@]}"} -DSLICE2MESH_TEST_FLAGS=-O1 \
  -DSLICE2MESH_UNITY=ON -DSLICE2MESH_BUILD_EXAMPLES=OFF -DSLICE2MESH_BUILD_BENCHMARKS=OFF
cmake --build "$build" --parallel "$jobs" --target "${programs[@]}"
pattern=$(IFS='|'; echo "${modules[*]}")
selection=(--tests-regex "^($pattern)\\." --label-exclude "$leave_out")
names() { ctest --test-dir "$build" -N "$@" 2>/dev/null | sed -n 's/^ *Test *#[0-9]*: //p' | sort; }
left_out=$(comm -23 <(names) <(names "${selection[@]}"))
echo "sanitize.sh: left out:" $left_out
status=0
ctest --test-dir "$build" --output-on-failure --no-tests=error --parallel "$jobs" --timeout 1800 "${selection[@]}" || status=$?

if [ "$fuzz" = none ]; then exit "$status"; fi
# In a build of their own: optimized, and without the assertions of CGAL, they try several times as many inputs.
cmake --preset fuzz -B "$build-fuzz" -DSLICE2MESH_FUZZ_SECONDS="$fuzz"
cmake --build "$build-fuzz" --parallel "$jobs" --target fuzzers
log="$build-fuzz/fuzzing.log"
if ctest --test-dir "$build-fuzz" --label-regex '^fuzzing$' --no-tests=error --parallel "$jobs" --output-on-failure \
  --output-log "$log" --verbose >/dev/null; then
  grep -E 'Test +#|number_of_executed_units|tests passed' "$log"
else
  status=1
  # What a fuzzer says last names the fault, and the input; once more in short, for those who see the last lines only.
  tail -n 200 "$log" >&2
  grep -aE 'what\(\):|ERROR:|SUMMARY:|Base64:|\(Failed\)' "$log" | cut -c 1-1500 >&2 || true
  echo "sanitize.sh: a fault; the inputs are in $build-fuzz/tests/fuzz/found" >&2
fi
exit "$status"
