#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Part of the tests under the address and undefined behavior sanitizers, and the fuzzers for a while.
#
#   bash scripts/sanitize.sh [--all] [--fuzz SECONDS]
#
# --all           every test but those labelled slow and external, not only those that are quick to compile
# --fuzz SECONDS  then run every fuzz target for so long, all at a time (where Clang is installed; 0, the default: none)
#
# SLICE2MESH_SANITIZE_BUILD  the build directory (default build/asan); that of the fuzzers has -fuzz at its end
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/jobs.sh
build=${SLICE2MESH_SANITIZE_BUILD:-build/asan}
jobs=$(slice2mesh_jobs)
all=no
fuzz=0
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
if [ "$fuzz" -gt 0 ] && ! command -v clang++ >/dev/null; then
  echo "sanitize.sh: no clang++: the fuzzers are left out" >&2
  fuzz=0
fi
# The modules that read, write and check; without fuzzers also the inputs that they found, which go through the whole
# pipeline.
modules=(cli fem io quality arrange)
if [ "$fuzz" -eq 0 ]; then modules+=(fuzz); fi
export UBSAN_OPTIONS=print_stacktrace=1
cmake --preset asan -B "$build" -DSLICE2MESH_BUILD_EXAMPLES=OFF -DSLICE2MESH_BUILD_BENCHMARKS=OFF
if [ "$all" = yes ]; then
  cmake --build "$build" --parallel "$jobs" --target slice2mesh_tests
  ctest --test-dir "$build" --output-on-failure --no-tests=error --parallel "$jobs" --timeout 1800 \
    --tests-regex '^(arrange|cli|differential|fem|fuzz|harmonize|improve|io|lift|metamorphic|pipeline|plc|quality|regions|resources|tet|torture|triangulate)\.' \
    --label-exclude 'slow|external'
else
  cmake --build "$build" --parallel "$jobs" --target "${modules[@]/%/_tests}"
  pattern=$(IFS='|'; echo "${modules[*]}")
  ctest --test-dir "$build" --output-on-failure --no-tests=error --parallel "$jobs" \
    --tests-regex "^($pattern)\\." --label-exclude 'slow|external|corpus'
fi

if [ "$fuzz" -eq 0 ]; then exit 0; fi
cmake --preset fuzz -B "$build-fuzz"
cmake --build "$build-fuzz" --parallel "$jobs" --target fuzzers
run_target() {
  local target=$1 found="$build-fuzz/found/$1"
  mkdir -p "$found"
  if ! "$build-fuzz/tests/fuzz/${target}_fuzz" -max_total_time="$fuzz" -max_len=400 -timeout=60 -rss_limit_mb=3000 \
    -print_final_stats=1 -artifact_prefix="$found/" "$found" "tests/fuzz/corpus/$target" >"$found.log" 2>&1; then
    echo "sanitize.sh: $target: a fault; the input is in $found" >&2
    tail -n 40 "$found.log" >&2
    return 1
  fi
  echo "fuzz target $target: $(sed -n 's/^stat::number_of_executed_units: *//p' "$found.log") executions in $fuzz s"
}
# All at a time: most of the time is that of the pipeline, whatever the others take.
failed=0
running=()
for target in read_cli write_cli mesh_files read_tets pipeline; do
  run_target "$target" &
  running+=($!)
done
for process in "${running[@]}"; do wait "$process" || failed=1; done
exit "$failed"
