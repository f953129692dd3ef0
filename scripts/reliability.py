#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The tables of docs/reliability.md from the last runs.

    scripts/reliability.py --torture FILE... --fuzz FILE...

--torture  what torture_driver printed (one file per run; runs are added up)
--fuzz     logs of the fuzzers, named <target>*.log
Replaces what is between the markers <!-- begin: NAME --> and <!-- end: NAME --> of the page.
"""
import argparse
import pathlib
import re

PAGE = pathlib.Path(__file__).resolve().parent.parent / "docs" / "reliability.md"


def replace(text, name, block):
    pattern = re.compile(rf"(<!-- begin: {name} -->\n).*?(<!-- end: {name} -->)", re.S)
    if not pattern.search(text):
        raise SystemExit(f"no block {name} in {PAGE}")
    return pattern.sub(lambda m: m.group(1) + block + m.group(2), text)


def torture_table(files):
    rows = {}
    what = {}
    for file in files:
        for line in pathlib.Path(file).read_text(errors="replace").splitlines():
            cells = [c.strip() for c in line.strip().strip("|").split("|")]
            if line.startswith("| ") and len(cells) == 9 and cells[1].isdigit() and cells[0] != "all":
                name, numbers = cells[0], [float(c) for c in cells[1:8]]
                what[name] = cells[8]
                old = rows.setdefault(name, [0.0] * 7)
                rows[name] = [a + b for a, b in zip(old[:5], numbers[:5])]
                rows[name] += [max(a, b) for a, b in zip(old[5:], numbers[5:])]
    lines = ["| class | inputs | certified | typed errors | failures | slowest, s | silence, s |",
             "|---|---|---|---|---|---|---|"]

    def line(name, r):
        return f"| {name} | {r[0]:.0f} | {r[1]:.0f} | {r[2]:.0f} | {r[3]:.0f} | {r[5]:.1f} | {r[6]:.1f} |"

    lines += [line(what[name], row) for name, row in rows.items()]
    columns = list(zip(*rows.values()))
    lines.append(line("**all**", [sum(c) for c in columns[:5]] + [max(c) for c in columns[5:]]))
    return "\n".join(lines) + "\n"


def fuzz_table(files):
    runs = {}
    for file in map(pathlib.Path, files):
        target = re.match(r"[a-z_]*[a-z]", file.name).group(0)
        text = file.read_text(errors="replace")
        # In fork mode: "#12345: cov: ... time: 60s"; in one process: "stat::number_of_executed_units: 12345".
        executed = [int(n) for n in re.findall(r"^#(\d+): cov", text, re.M)]
        seconds = [int(n) for n in re.findall(r"time: (\d+)s", text)]
        if not executed:
            executed = [int(n) for n in re.findall(r"number_of_executed_units: *(\d+)", text)]
            seconds = [int(n) for n in re.findall(r"Done \d+ runs in (\d+) second", text)]
        if not executed or not seconds:
            continue
        run = runs.setdefault(target, [0, 0])
        run[0] += executed[-1]
        run[1] += seconds[-1]
    lines = ["| target | executions | minutes |", "|---|---|---|"]
    for target, (executed, seconds) in sorted(runs.items()):
        lines.append(f"| `{target}` | {executed} | {seconds / 60:.0f} |")
    lines.append(f"| **all** | {sum(r[0] for r in runs.values())} | {sum(r[1] for r in runs.values()) / 60:.0f} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--torture", nargs="*", default=[])
    parser.add_argument("--fuzz", nargs="*", default=[])
    arguments = parser.parse_args()
    text = PAGE.read_text()
    if arguments.torture:
        text = replace(text, "torture", torture_table(arguments.torture))
    if arguments.fuzz:
        text = replace(text, "fuzz", fuzz_table(arguments.fuzz))
    PAGE.write_text(text)


if __name__ == "__main__":
    main()
