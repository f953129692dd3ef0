#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Compile time of every public header alone, as a table in Markdown.

    python3 benchmarks/header_cost.py [--compiler g++] [--flags "-isystem /usr/include/eigen3"] [--runs 3] [--check] [part of a name ...]

Each header is compiled in a file of its own that has nothing but its #include (-std=c++17 -O0), RUNS times; the median of the CPU
seconds of the compiler, its largest memory and the lines after preprocessing are told, the slowest header first, beside the budget:
what a header of its folder may cost. With --check ends with 1 if a header costs more than twice its budget (machines differ).
"""
import argparse
import os
import statistics
import subprocess
import sys
import tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "include", "slice2mesh")
# CPU seconds. Headers without CGAL: what the standard library and Eigen cost. The others: CGAL and the stages below them.
BUDGET = {"core": 2.5, "cli": 2.5, "io": 4, "fem": 4, "quality": 4, "arrange": 3, "plc/verify_plc.hpp": 4, "plc/plc_checks.hpp": 4,
          "tet": 5, "pipeline/options.hpp": 2.5, "version.hpp": 0.5, "regions/slabs.hpp": 3, "regions/thicken.hpp": 3,
          "harmonize/separation_report.hpp": 2.5, "harmonize/merge.hpp": 4, "harmonize/simplify.hpp": 4,
          "tet/mesh3_model.hpp": 40, "pipeline/slice_to_mesh.hpp": 20, "slice2mesh.hpp": 22}
BUDGET_WITH_CGAL = 14


def budget(header):
    return BUDGET.get(header, BUDGET.get(header.split("/")[0], BUDGET_WITH_CGAL))


def headers(parts):
    found = []
    for folder, _, names in os.walk(ROOT):
        for name in names:
            header = os.path.relpath(os.path.join(folder, name), ROOT).replace(os.sep, "/")
            if name.endswith(".hpp") and (not parts or any(part in header for part in parts)):
                found.append(header)
    return sorted(found)


def cost(compiler, flags, source):
    """CPU seconds and MiB of one run of the compiler."""
    pid = os.posix_spawnp(compiler[0], compiler + flags + ["-c", source, "-o", os.devnull], os.environ)
    _, status, usage = os.wait4(pid, 0)
    if status != 0:
        sys.exit("header_cost.py: %s does not compile" % source)
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def main():
    parser = argparse.ArgumentParser(description="Compile time of every public header.")
    parser.add_argument("--compiler", default="g++")
    parser.add_argument("--flags", default="-isystem /usr/include/eigen3")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("parts", nargs="*")
    arguments = parser.parse_args()
    compiler = arguments.compiler.split()
    flags = ["-std=c++17", "-O0", "-I", os.path.dirname(ROOT)] + arguments.flags.split()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        source = os.path.join(folder, "header.cpp")
        for header in headers(arguments.parts):
            with open(source, "w", encoding="utf-8") as file:
                file.write('#include "slice2mesh/%s"\n' % header)
            runs = [cost(compiler, flags, source) for _ in range(arguments.runs)]
            text = subprocess.run(compiler + flags + ["-E", "-P", source], check=True, capture_output=True).stdout
            rows.append((statistics.median(run[0] for run in runs), max(run[1] for run in runs), text.count(b"\n"), header))
            print("%6.2f s  %s" % (rows[-1][0], header), file=sys.stderr)
    if not rows:
        sys.exit("header_cost.py: no headers")
    rows.sort(reverse=True)
    version = subprocess.run(compiler + ["--version"], check=True, capture_output=True, text=True).stdout.splitlines()[0]
    print("CPU seconds of the compiler (median of %d), %s, `-std=c++17 -O0`.\n" % (arguments.runs, version))
    print("| header | s | budget | MiB | lines after preprocessing |\n|---|---:|---:|---:|---:|")
    for seconds, memory, lines, header in rows:
        mark = " (above)" if seconds > budget(header) else ""
        print("| `%s` | %.1f%s | %g | %.0f | %s |" % (header, seconds, mark, budget(header), memory, "{:,}".format(lines)))
    slow = [header for seconds, _, _, header in rows if seconds > 2 * budget(header)]
    for header in slow:
        print("header_cost.py: more than twice its budget: " + header, file=sys.stderr)
    return 1 if arguments.check and slow else 0


if __name__ == "__main__":
    sys.exit(main())
