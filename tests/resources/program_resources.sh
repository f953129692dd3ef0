#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# program_resources.sh memory|disk|file_size|interrupt PROGRAM MAKE_SAMPLE DIRECTORY
# The program where memory or disk are too small, and where it is told to stop. Ends with 77 where the system does not
# allow the test.
set -euo pipefail
case=$1 program=$2 make_sample=$3 directory=$4
rm -rf "$directory"
mkdir -p "$directory"
cd "$directory"
"$make_sample" sample.cli >/dev/null

fail() {
  echo "not so: $*" >&2
  cat err.txt >&2 || true
  ls -la >&2
  exit 1
}

# After a failure nothing is left but what was there: no output, no temporary file.
check_nothing_left() {
  local left
  left=$(find "$1" -mindepth 1 ! -name sample.cli ! -name '*.txt' ! -name old.vtu)
  [ -z "$left" ] || fail "nothing is left behind: $left"
}

one_message() {
  [ "$(grep -c '^slice2mesh: ' err.txt)" = 1 ] || fail "one message"
}

case "$case" in
  memory)
    # From too little to start to enough. What the program cannot even be loaded with is not its fault (127, 126 and
    # signals of the loader); between, it must report, and in the end succeed.
    reported=0 succeeded=0
    for megabytes in 60 80 100 120 160 200 240 280 320 400 500 700 1000 2000 4000; do
      code=0
      (ulimit -v $((megabytes * 1024)) && exec "$program" sample.cli --quiet -o out.vtu >out.txt 2>err.txt) || code=$?
      case "$code" in
        0)
          succeeded=1
          [ -s out.vtu ] || fail "the mesh is there"
          rm out.vtu
          break
          ;;
        3 | 2)
          one_message
          grep -q 'memory' err.txt || fail "the message names the memory ($megabytes MB)"
          reported=$((reported + 1))
          ;;
        127) grep -q 'error while loading\|cannot allocate\|failed to map' err.txt || fail "the loader gave up ($megabytes MB)" ;;
        *) fail "code $code with $megabytes MB" ;;
      esac
      check_nothing_left .
    done
    [ "$succeeded" = 1 ] || fail "enough memory is enough"
    [ "$reported" -gt 0 ] || fail "some amount is too little"
    ;;
  disk)
    # A file system of its own with less room than the mesh takes; in a name space where we are not root.
    small_disk() {
      mkdir -p small && mount -t tmpfs -o size=200k none small || exit 77
      :
      for output in a.vtu a.msh a.mesh a.inp a.mfem a.node a.pvd; do
        local code=0
        "$program" sample.cli --quiet -o "small/$output" >out.txt 2>err.txt || code=$?
        [ "$code" = 2 ] || { umount small; fail "code 2 for $output, is $code"; }
        one_message
        grep -q "No space left" err.txt || { umount small; fail "the message says why ($output)"; }
        check_nothing_left small
      done
      # A file that was there keeps its content.
      head -c 1000 sample.cli >small/old.vtu
      "$program" sample.cli --quiet -o small/old.vtu >out.txt 2>err.txt && { umount small; fail "no success"; }
      cmp -s <(head -c 1000 sample.cli) small/old.vtu || { umount small; fail "the old file is as it was"; }
      # Where there is room for a smaller file, that one appears.
      "$program" sample.cli --quiet --report small/report.json >out.txt 2>err.txt || { umount small; fail "the report fits"; }
      umount small
    }
    if [ "${SLICE2MESH_IN_NAMESPACE:-}" = 1 ] || { mkdir -p probe && mount -t tmpfs none probe 2>/dev/null; }; then
      [ -d probe ] && umount probe 2>/dev/null && rmdir probe
      small_disk
    elif unshare -rm true 2>/dev/null; then
      rmdir probe 2>/dev/null || true
      SLICE2MESH_IN_NAMESPACE=1 exec unshare -rm "$BASH" "$0" "$@"
    else
      echo "no file system can be mounted here: left out (a limit of the file size stands in, see file_size)"
      exit 77
    fi
    ;;
  file_size)
    for blocks in 1 10 100; do
      for output in a.vtu a.msh a.node; do
        code=0
        (ulimit -f "$blocks" && exec "$program" sample.cli --quiet -o "$output" >/dev/null 2>err.txt) || code=$?
        [ "$code" = 2 ] || fail "code 2 for $output with $blocks blocks, is $code"
        one_message
        check_nothing_left .
      done
    done
    # A device that is always full.
    if [ -c /dev/full ]; then
      code=0
      "$program" sample.cli --quiet --report /dev/full >out.txt 2>err.txt || code=$?
      [ "$code" = 2 ] || fail "code 2 for a full device, is $code"
    fi
    ;;
  interrupt)
    # Told to stop at any time, it ends with a message and leaves nothing half-written.
    stopped=0
    for delay in 0.02 0.05 0.1 0.2 0.3 0.5 0.8; do
      for signal in INT TERM; do
        # A shell starts background jobs with SIGINT ignored; a new session begins with the default.
        "$program" sample.cli --quiet --size 0.3 --support-radius 0.1 -o out.vtu -o out.msh >out.txt 2>err.txt &
        process=$!
        sleep "$delay"
        kill "-$signal" "$process" 2>/dev/null || true
        code=0
        wait "$process" || code=$?
        case "$code" in
          0) ;;
          3)
            one_message
            grep -q 'cancelled' err.txt || fail "the message says that it was cancelled"
            stopped=$((stopped + 1))
            ;;
          130 | 143) ;; # before the program had begun to listen
          *) fail "code $code after $signal" ;;
        esac
        # What is there is whole.
        for output in out.vtu out.msh; do
          [ ! -e "$output" ] || tail -n 1 "$output" | grep -q '</VTKFile>\|EndElements' || fail "$output is whole"
          rm -f "$output"
        done
        check_nothing_left .
      done
    done
    [ "$stopped" -gt 0 ] || fail "some run was stopped"
    ;;
  *)
    echo "no such case: $case" >&2
    exit 1
    ;;
esac
