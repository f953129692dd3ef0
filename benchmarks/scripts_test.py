#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Tests compare.py and benchmark_page.py on a JSON file of slice2mesh_benchmarks --tiny.

    python3 benchmarks/scripts_test.py TINY.json
"""
import json
import math
import os
import subprocess
import sys
import tempfile

import benchmark_page
import compare

HERE = os.path.dirname(os.path.abspath(__file__))


def run(script, *arguments):
    return subprocess.run([sys.executable, os.path.join(HERE, script), *arguments], capture_output=True, text=True)


def main():
    path = sys.argv[1]
    with open(path, encoding="utf-8") as file:
        document = json.load(file)
    seen = set()
    for one in document["benchmarks"]:
        stage, family, _ = benchmark_page.split(one["name"])
        seen.add((stage, family))
        assert one["tets"] > 100 and one["tets_per_s"] > 0, one
        # `write` forgets what it writes, and needs a buffer only; nothing needs none.
        assert one["bytes_per_tet"] > 0, one
    assert seen == {(stage, family) for stage in benchmark_page.STAGES for family in benchmark_page.FAMILIES}, seen

    with tempfile.TemporaryDirectory() as folder:
        # Twice the time and half the memory, and a repetition that the median ignores.
        for one in document["benchmarks"]:
            one["cpu_time"] *= 2
            one["bytes_per_tet"] /= 2
        outlier = dict(document["benchmarks"][0])
        outlier["cpu_time"] *= 1000
        document["benchmarks"] += [outlier, dict(document["benchmarks"][0])]
        slower = os.path.join(folder, "slower.json")
        with open(slower, "w", encoding="utf-8") as file:
            json.dump(document, file)
        rows = compare.compare(compare.medians(path), compare.medians(slower))
        assert len(rows) == len(seen), rows
        for name, time, memory in rows:
            assert math.isclose(time, 2, rel_tol=1e-9) and math.isclose(memory, 0.5, rel_tol=1e-9), (name, time, memory)
        assert run("compare.py", path, path, "--limit", "1.0").returncode == 0
        assert run("compare.py", path, slower).returncode == 0
        answer = run("compare.py", path, slower, "--limit", "1.5")
        assert answer.returncode == 1 and "above the limit" in answer.stdout, answer
        nothing = os.path.join(folder, "nothing.json")
        with open(nothing, "w", encoding="utf-8") as file:
            json.dump({"benchmarks": []}, file)
        assert run("compare.py", path, nothing).returncode == 2

        page = os.path.join(folder, "page.md")
        text = "".join("<!-- %s: begin -->\nold\n<!-- %s: end -->\n" % (mark, mark) for mark in ("stages", "meshers", "headers"))
        with open(page, "w", encoding="utf-8") as file:
            file.write("before\n" + text + "after\n")
        # With repetitions there are figures about them, whose counters are not those of a run.
        spread = dict(document["benchmarks"][0], run_type="aggregate", aggregate_name="stddev", tets=0)
        document["benchmarks"].append(spread)
        repeated = os.path.join(folder, "repeated.json")
        with open(repeated, "w", encoding="utf-8") as file:
            json.dump(document, file)
        other = os.path.join(folder, "meshers.md")
        with open(other, "w", encoding="utf-8") as file:
            file.write("a table\n")
        answer = run("benchmark_page.py", repeated, other, "-", page, folder)
        assert answer.returncode == 0, answer
        with open(page, encoding="utf-8") as file:
            made = file.read()
        assert made.startswith("before\n") and made.endswith("after\n") and made.count("old") == 1, made
        assert "a table" in made and made.count("### ") == len(benchmark_page.FAMILIES), made
        pictures = [name for name in os.listdir(folder) if name.endswith(".svg")]
        assert len(pictures) == made.count("](images/") and (pictures or "matplotlib" in answer.stderr), (pictures, answer)
    print("compare.py and benchmark_page.py: %d benchmarks" % len(seen))


if __name__ == "__main__":
    main()
