# SPDX-License-Identifier: MIT
# Sourced by the other scripts: number of compilations at a time, at most one per processor and one per 1.5 GB of memory
# (the translation units with CGAL need that much).
slice2mesh_jobs() {
  local processors memory_kb jobs
  processors=$(nproc 2>/dev/null || echo 2)
  memory_kb=$(awk '/^MemAvailable:/ { print $2 }' /proc/meminfo 2>/dev/null || echo 4000000)
  jobs=$((${memory_kb:-4000000} / 1500000))
  if [ "$jobs" -gt "$processors" ]; then jobs=$processors; fi
  if [ "$jobs" -lt 1 ]; then jobs=1; fi
  echo "${SLICE2MESH_JOBS:-$jobs}"
}
