#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Puts the tables and plots of a benchmark run into docs/benchmarks.md.

    python3 benchmarks/benchmark_page.py STAGES.json MESHERS.md HEADERS.md PAGE [FOLDER of the plots]

STAGES.json is of slice2mesh_benchmarks, MESHERS.md the table of meshers.sh, HEADERS.md that of header_cost.py; `-` leaves the
tables between the marks of the page as they are. Plots are SVG files; without matplotlib they are left out, and that is said.
SLICE2MESH_BENCHMARK_NOTE of the environment, a sentence about the circumstances, is put above every table.
"""
import os
import platform
import re
import sys

import compare

STAGES = ["read", "regions", "harmonize", "triangulate", "plc", "fill", "improve", "certify", "quality", "write", "whole"]
FAMILIES = {
    "points": "points of the outer contour (8 layers)",
    "layers": "layers (256 points)",
    "slope": "shift from layer to layer, hundredths of a layer thickness",
    "noise": "noise of the points, hundredths of a layer thickness",
}


def split(name):
    """"fill/points:64" -> ("fill", "points", 64)."""
    stage, rest = name.split("/")[:2]
    family, value = rest.split(":")
    return stage, family, int(value)


def runs_of(path):
    """(family, value) -> stage -> (seconds, bytes per tet), and (family, value) -> tets."""
    import json

    figures, tets = {}, {}
    for name, (seconds, memory) in compare.medians(path).items():
        stage, family, value = split(name)
        figures.setdefault((family, value), {})[stage] = (seconds, memory)
    with open(path, encoding="utf-8") as file:
        for run in json.load(file)["benchmarks"]:
            if run.get("run_type", "iteration") != "iteration":  # mean, standard deviation and so on
                continue
            _, family, value = split(run.get("run_name", run["name"]))
            tets[family, value] = int(run["tets"])
    return figures, tets


def table(figures, tets, family):
    """Microseconds of CPU time per tet of the finished mesh, stage by stage."""
    stages = [stage for stage in STAGES if any(stage in row for row in figures.values())]
    lines = [
        "| " + family + " | tets | " + " | ".join(stages) + " | tets/s | bytes/tet |",
        "|" + "---:|" * (len(stages) + 4),
    ]
    for (name, value), row in sorted(figures.items()):
        if name != family:
            continue
        count = tets[name, value]
        cells = ["%.2f" % (1e6 * row[stage][0] / count) if stage in row else "" for stage in stages]
        whole = row.get("whole")
        last = ["{:,.0f}".format(count / whole[0]), "{:,.0f}".format(whole[1])] if whole else ["", ""]
        lines.append("| %d | %s | %s |" % (value, "{:,}".format(count), " | ".join(cells + last)))
    return "\n".join(lines)


def shares(figures):
    """What each stage takes of the time of all between reading and writing, and its memory, over all rows."""
    from statistics import median

    lines = [
        "| stage | share of the time: median | least | largest | bytes/tet: median | largest |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    rows = [row for row in figures.values() if set(STAGES) <= set(row)]
    if not rows:
        return None
    for stage in STAGES:
        memory = [row[stage][1] for row in rows]
        cells = ["", "", ""]
        if stage != "whole":
            sums = [sum(row[other][0] for other in STAGES if other not in ("read", "write", "whole")) for row in rows]
            parts = [100 * row[stage][0] / total for row, total in zip(rows, sums)]
            cells = ["%.2g %%" % value for value in (median(parts), min(parts), max(parts))]
        cells += ["{:,.0f}".format(median(memory)), "{:,.0f}".format(max(memory))]
        lines.append("| %s | %s |" % (stage, " | ".join(cells)))
    return "\n".join(lines)


def growth(figures, tets, family):
    """The exponent b of time = a * tets^b of the whole pipeline, by least squares in logarithms."""
    import math

    rows = [(tets[key], row["whole"][0]) for key, row in figures.items() if key[0] == family and "whole" in row]
    if len(rows) < 3:
        return None
    xs, ys = [math.log(t) for t, _ in rows], [math.log(s) for _, s in rows]
    x, y = sum(xs) / len(xs), sum(ys) / len(ys)
    spread = sum((a - x) ** 2 for a in xs)
    return sum((a - x) * (b - y) for a, b in zip(xs, ys)) / spread if spread > 0 else None


def plot(figures, tets, family, path):
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "slice2mesh"  # the same picture for the same figures
    matplotlib.rcParams["svg.fonttype"] = "none"
    import matplotlib.pyplot as pyplot

    keys = sorted(key for key in figures if key[0] == family)
    figure, axes = pyplot.subplots(figsize=(7.2, 4.2))
    grows = family in ("points", "layers")
    for stage in STAGES:
        known = [key for key in keys if stage in figures[key]]
        xs = [key[1] for key in known]
        ys = [figures[key][stage][0] * (1 if grows else 1e6 / tets[key]) for key in known]
        style = {"linewidth": 2.4, "color": "black"} if stage == "whole" else {"linewidth": 1.2}
        axes.plot(xs, ys, marker="o", markersize=3, label=stage, **style)
    axes.set_yscale("log")
    if grows:
        axes.set_xscale("log", base=2)
        axes.set_ylabel("CPU seconds")
        # A line of slope 1, to compare with.
        known = [key for key in keys if "whole" in figures[key]]
        if known:
            first = figures[known[0]]["whole"][0] * 2
            axes.plot([key[1] for key in known], [first * key[1] / known[0][1] for key in known], linestyle=":", color="gray",
                      label="linear")
    else:
        axes.set_ylabel("CPU microseconds per tet")
    axes.set_xlabel(FAMILIES[family])
    axes.grid(True, which="major", color="#dddddd", linewidth=0.6)
    axes.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})
    pyplot.close(figure)


def replaced(page, mark, text):
    """The page with what stands between the comments `mark` replaced."""
    pattern = re.compile(r"(<!-- %s: begin[^\n]*-->\n).*?(<!-- %s: end -->)" % (mark, mark), re.S)
    if not pattern.search(page):
        raise SystemExit("benchmark_page.py: the page has no marks for " + mark)
    return pattern.sub(lambda found: found.group(1) + "\n" + text.strip() + "\n\n" + found.group(2), page)


def processor():
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            return re.search(r"^model name\s*: (.*)$", file.read(), re.M).group(1)
    except (OSError, AttributeError):
        return platform.processor() or platform.machine()


def stages_text(path, folder):
    figures, tets = runs_of(path)
    parts = ["Measured on one core of: %s." % processor()]
    table_of_shares = shares(figures)
    if table_of_shares:
        parts.append("Over all rows below, from %s to %s tets:" % tuple("{:,}".format(f(tets.values())) for f in (min, max)))
        parts.append(table_of_shares)
    for family, words in FAMILIES.items():
        if not any(key[0] == family for key in figures):
            continue
        parts.append("### " + family.capitalize() + "\n\nCPU microseconds per tet; varied: " + words + ".")
        parts.append(table(figures, tets, family))
        exponent = growth(figures, tets, family)
        if family in ("points", "layers") and exponent is not None:
            parts.append("Time of the whole pipeline grows as tets^%.2f (least squares over the rows)." % exponent)
        if folder is not None:
            picture = os.path.join(folder, "benchmark_%s.svg" % family)
            try:
                plot(figures, tets, family, picture)
            except ImportError:
                print("benchmark_page.py: no plots, as matplotlib was not found", file=sys.stderr)
                folder = None
                continue
            parts.append("![Time of every stage: %s](images/%s)" % (words, os.path.basename(picture)))
    return "\n\n".join(parts)


def main():
    if len(sys.argv) not in (5, 6):
        sys.exit(__doc__)
    stages, meshers, headers, path = sys.argv[1:5]
    folder = sys.argv[5] if len(sys.argv) == 6 else None
    with open(path, encoding="utf-8") as file:
        page = file.read()
    note = os.environ.get("SLICE2MESH_BENCHMARK_NOTE", "").strip()
    note = note + "\n\n" if note else ""
    if stages != "-":
        page = replaced(page, "stages", note + stages_text(stages, folder))
    for mark, source in (("meshers", meshers), ("headers", headers)):
        if source != "-":
            with open(source, encoding="utf-8") as file:
                page = replaced(page, mark, note + file.read())
    with open(path + ".new", "w", encoding="utf-8") as file:
        file.write(page)
    os.replace(path + ".new", path)


if __name__ == "__main__":
    main()
