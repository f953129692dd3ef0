#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Part of the tests under the address and undefined behavior sanitizers, and the fuzzers for a while.
#
#   bash scripts/sanitize.sh [--all] [--fuzz SECONDS]
#
# --all           every test of the library but those labelled slow and external, not only those that are quick to compile
# --fuzz SECONDS  then run every fuzz target for so long with new inputs, one per processor at a time (where Clang is installed);
#                 0: for about a minute each, with the same inputs every time
#
# SLICE2MESH_SANITIZE_BUILD  the build directory (default build/asan); that of the fuzzers has -fuzz at its end
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/jobs.sh
build=${SLICE2MESH_SANITIZE_BUILD:-build/asan}
jobs=$(slice2mesh_jobs)
all=no
fuzz=none
while [ "$#" -gt 0 ]; do
  case "$1" in
    --all) all=yes ;;
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
if [ "$fuzz" != none ] && ! command -v clang++ >/dev/null; then
  echo "sanitize.sh: no clang++: the fuzzers are left out" >&2
  fuzz=none
fi
# The modules that read, write and check; without fuzzers also the inputs that they found, which go through the whole
# pipeline. Sources are joined: headers are instrumented once.
modules=(arrange cli fem io quality)
programs=(parts_tests)
if [ "$fuzz" = none ]; then
  modules+=(fuzz)
  programs+=(fuzz_tests)
fi
leave_out='slow|external|corpus'
if [ "$all" = yes ]; then
  modules+=(differential fuzz harmonize improve lift meshers metamorphic pipeline plc regions resources tet torture triangulate)
  programs=(slice2mesh_tests)
  leave_out='slow|external'
fi
export UBSAN_OPTIONS=print_stacktrace=1
cmake --preset asan -B "$build" -DSLICE2MESH_UNITY=ON -DSLICE2MESH_BUILD_EXAMPLES=OFF -DSLICE2MESH_BUILD_BENCHMARKS=OFF
cmake --build "$build" --parallel "$jobs" --target "${programs[@]}"
pattern=$(IFS='|'; echo "${modules[*]}")
ctest --test-dir "$build" --output-on-failure --no-tests=error --parallel "$jobs" --timeout 1800 \
  --tests-regex "^($pattern)\\." --label-exclude "$leave_out"

if [ "$fuzz" = none ]; then exit 0; fi
cmake --preset fuzz -B "$build-fuzz" -DSLICE2MESH_FUZZ_SECONDS="$fuzz"
cmake --build "$build-fuzz" --parallel "$jobs" --target fuzzers
log="$build-fuzz/fuzzing.log"
failed=0
ctest --test-dir "$build-fuzz" --label-regex '^fuzzing$' --no-tests=error --parallel "$jobs" --output-on-failure \
  --output-log "$log" --verbose >/dev/null || failed=1
if [ "$failed" -eq 0 ]; then
  grep -E 'Test +#|number_of_executed_units|tests passed' "$log"
else
  # What a fuzzer says last names the fault, and the input; once more in short, for those who see the last lines only.
  tail -n 200 "$log" >&2
  grep -aE 'what\(\):|ERROR:|SUMMARY:|Base64:|\(Failed\)' "$log" | cut -c 1-1500 >&2 || true
  echo "sanitize.sh: a fault; the inputs are in $build-fuzz/tests/fuzz/found" >&2
fi
exit "$failed"
