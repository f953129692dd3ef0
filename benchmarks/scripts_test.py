#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Tests compare.py and benchmark_page.py on a JSON file of slice2mesh_benchmarks --tiny, and the summary of quality_table.py.

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
import quality_table

HERE = os.path.dirname(os.path.abspath(__file__))


def run(script, *arguments):
    return subprocess.run([sys.executable, os.path.join(HERE, script), *arguments], capture_output=True, text=True)


def report(mean, worst, angle):
    """What quality_table.py reads of the report of a run."""
    return {
        "version": "1.2.3", "mesh": {"tets": 1000, "vertices": 300, "slabs": [{}]}, "thickness": 0.1, "size": 0.2, "eps": 0.01,
        "deviation": {"max": 0.009}, "certificate": {"passed": True, "volume": 1, "expected_volume": 1},
        "volume_error": {"error": -1e-4}, "seconds": {"improve": 1}, "separation": {},
        "quality": {"crossing": 0, "column_share": 0.5, "ratio": {"mean": mean, "p999": 4, "worst": worst}, "min_dihedral": angle,
                    "max_dihedral": 150, "worst": [], "forced": {"worst_other": worst}},
    }


def test_summary(folder):
    """Files that miss a goal are named, those without a mesh among them; the rest of the page stays."""
    work = os.path.join(folder, "work")
    os.makedirs(os.path.join(work, "default"))
    files = {"good": report(1.3, 4, 12), "long": report(1.6, 5, 9), "sharp": report(1.4, 16, 3)}
    with open(os.path.join(work, "runs.tsv"), "w", encoding="utf-8") as file:
        for name in [*files, "none"]:
            file.write("default\t%s\t%d\t2\t1.5\t0.5\t1024\n" % (name, name == "none"))
    with open(os.path.join(work, "configurations.tsv"), "w", encoding="utf-8") as file:
        file.write("default\t--support-radius 0.1\n")
    for name, content in files.items():
        with open(os.path.join(work, "default", name + ".json"), "w", encoding="utf-8") as file:
            json.dump(content, file)
    with open(os.path.join(work, "default", "none.err"), "w", encoding="utf-8") as file:
        file.write("error: no slices\n")
    page = os.path.join(folder, "shapes.md")
    with open(page, "w", encoding="utf-8") as file:
        file.write("before\n" + "\nold\n".join(quality_table.MARKERS["summary"]) + "\nafter\n")
    answer = run("quality_table.py", work, page, "summary")
    assert answer.returncode == 0, answer
    with open(page, encoding="utf-8") as file:
        made = file.read()
    assert made.startswith("before\n") and made.endswith("after\n") and "old" not in made, made
    assert "3 of 4 meshes made, every one certified" in made, made
    for row in ("| mean | <= 1.5 | 2 of 4 | long (1.6), none (no mesh) | <= 1.35 | 1 of 4 |",
                "| worst | <= 15 | 2 of 4 | sharp (16), none (no mesh) | <= 6 | 2 of 4 |",
                "| dihedral angles | 4 to 172 | 2 of 4 | sharp (3.00-150.0), none (no mesh) | 10 to 160 | 1 of 4 |",
                "| smallest angle | 3 | 9 | 12 |", "| seconds | 2 | 2 | 2 |"):
        assert row in made, (row, made)
    assert run("quality_table.py", work, page, "all").returncode != 0  # no such markers


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
        test_summary(folder)
        pictures = [name for name in os.listdir(folder) if name.endswith(".svg")]
        assert len(pictures) == made.count("](images/") and (pictures or "matplotlib" in answer.stderr), (pictures, answer)
    print("compare.py, benchmark_page.py and the summary of quality_table.py: %d benchmarks" % len(seen))


if __name__ == "__main__":
    main()
