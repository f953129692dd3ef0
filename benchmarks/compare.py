#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Compares two JSON files of slice2mesh_benchmarks: the median time of each benchmark, and of the memory per tet.

    python3 benchmarks/compare.py BEFORE.json AFTER.json [--limit RATIO]

Prints, for each benchmark that both files have, the ratio after/before of the median CPU time over its repetitions
(--benchmark_repetitions=N) and of bytes_per_tet; then the median, least and largest ratio per stage. With --limit, ends with 1 if
the median of a stage is above it. Ends with 2 if the files have no benchmark in common.
"""
import argparse
import json
import statistics
import sys

UNITS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}


def medians(path):
    """name -> (median CPU seconds, bytes per tet) over the runs of a file."""
    with open(path, encoding="utf-8") as file:
        document = json.load(file)
    times, memory = {}, {}
    for run in document["benchmarks"]:
        if run.get("run_type", "iteration") != "iteration" or run.get("error_occurred"):
            continue
        name = run.get("run_name", run["name"])
        times.setdefault(name, []).append(run["cpu_time"] * UNITS[run["time_unit"]])
        memory.setdefault(name, []).append(run["bytes_per_tet"])
    return {name: (statistics.median(times[name]), statistics.median(memory[name])) for name in times}


def compare(before, after):
    """[(name, ratio of times, ratio of memory)] of what both have, in the order of `before`."""
    rows = []
    for name, (time, memory) in before.items():
        if name in after and time > 0:
            rows.append((name, after[name][0] / time, after[name][1] / memory if memory > 0 else float("nan")))
    return rows


def by_stage(rows):
    """[(stage, ratios of times)], in order of appearance."""
    stages = {}
    for name, ratio, _ in rows:
        stages.setdefault(name.split("/")[0], []).append(ratio)
    return list(stages.items())


def main():
    parser = argparse.ArgumentParser(description="Median ratios of two benchmark files.")
    parser.add_argument("before")
    parser.add_argument("after")
    parser.add_argument("--limit", type=float, help="largest median ratio of a stage that is accepted")
    arguments = parser.parse_args()
    rows = compare(medians(arguments.before), medians(arguments.after))
    if not rows:
        print("compare.py: no benchmark is in both files", file=sys.stderr)
        return 2
    print(f"{'benchmark':<32} {'time':>8} {'memory':>8}   (after / before)")
    for name, time, memory in rows:
        print(f"{name:<32} {time:8.3f} {memory:8.3f}")
    print(f"\n{'stage':<32} {'median':>8} {'least':>8} {'largest':>8}")
    code = 0
    for stage, ratios in by_stage(rows):
        median = statistics.median(ratios)
        slower = arguments.limit is not None and median > arguments.limit
        code = 1 if slower else code
        print(f"{stage:<32} {median:8.3f} {min(ratios):8.3f} {max(ratios):8.3f}{'   above the limit' if slower else ''}")
    return code


if __name__ == "__main__":
    sys.exit(main())
