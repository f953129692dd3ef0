# SPDX-License-Identifier: MIT
"""Tables of the figures of many meshes, for docs/quality.md.

    python3 quality_table.py WORK PAGE all|summary

WORK is what quality.sh leaves: runs.tsv (configuration, name, exit code, wall-clock, user and system seconds, KiB),
configurations.tsv (configuration, options), <configuration>/<name>.json (the program's report), .err, and for size10h
.node and .ele. PAGE is a Markdown file whose part between the two markers is replaced, or `-` for the standard output. `summary`:
how many files meet the goals with default options, and which do not; the markers are those of shapes.sh.
"""
import json
import math
import os
import re
import statistics
import sys

MARKERS = {kind: ["<!-- tables of benchmarks/%s: %s -->" % (script, end) for end in ("begin", "end")]
           for kind, script in (("all", "quality.sh"), ("summary", "shapes.sh"))}

# Goals: (must, aim).
MEAN = (1.5, 1.35)
P999 = (8, 5)
WORST = (15, 6)
ANGLES = ((4, 172), (10, 160))  # degrees
TETS = (1.3, 1.0)  # times the raw fill
SECONDS = (20, 5)
FORCED_ABOVE = WORST[0]  # what the input forces is told apart above this R/3r
GOALS = {
    "crossing": ("0", "0"),
    "mean": ("<= %g" % MEAN[0], "<= %g" % MEAN[1]),
    "99.9 %": ("<= %g" % P999[0], "<= %g" % P999[1]),
    "worst": ("<= %g" % WORST[0], "<= %g" % WORST[1]),
    "dihedral angles": ("%g to %g" % ANGLES[0], "%g to %g" % ANGLES[1]),
    "tets / raw fill": ("<= %g" % TETS[0], "<= %g" % TETS[1]),
    "deviation / eps": ("<= 1", "<= 1"),
    "seconds": ("<= %g" % SECONDS[0], "<= %g" % SECONDS[1]),
}

# Tets of an experimental fill without any removal of slivers (eps = 0.1h, l = 2h, no supports): the measure of mesh size.
RAW_FILL = {
    "T_supported": 38700,
    "pyramid_l0.03": 56700,
    "sphere_l0.03": 104000,
    "nugear_coarse": 69500,
    "anchor_0_l0.06": 31600,
    "fandisk_l0.03_cino": 295000,
    "joint_l0.02": 119000,
    "anc_101_a1_l0.01": 235000,
    "torus_coarse": 34000,
    "CAD5_Lp_l0.13": 3350000,
}

# fTetWild, tolerance 1e-3 of the diagonal: tets, mean, worst, dihedral angles, % of tets that cross, volume against the contours
# that it was given, user seconds.
FTETWILD = {
    "T_supported": ("15.8k", 1.68, 6.8, "9.9-156", 18.6, -2e-4, 11),
    "sphere_l0.03": ("80.6k", 1.46, 8.2, "10-157", 2.2, -4e-4, 65),
    "pyramid_l0.03": ("26.6k", 1.49, 6.4, "11-154", 2.0, -3e-4, 20),
    "nugear_coarse": ("78.9k", 1.41, 6.5, "10-157", 7.6, -6e-4, 47),
    "anchor_0_l0.06": ("42.2k", 1.38, 8.1, "9.6-156", 5.5, -3e-4, 34),
    "fandisk_l0.03_cino": ("153k", 1.44, 7.8, "10-159", 6.6, -2e-4, 106),
    "joint_l0.02": ("92.6k", 1.44, 7.1, "11-156", 7.5, -2e-4, 72),
}

# The paper's Table 1, over its 14 parts.
PAPER_HEADER = ["file", "tets", "mean", "worst", "crossing", "s"]
PAPER = [["*paper: TetWild*", "", "1.2 to 1.9", "6 to 345", "some", "up to hours"],
         ["*paper: TetGen*", "", "", "above 1e10", "0", ""],
         ["*paper: TetGen with quality*", "", "most parts: crash, or stopped after six days", "", "", ""]]

# Conforming tools, worst R/3r / seconds: TetGen 1.5 -p, TetGen 1.5 -q, TetGen 1.6 -q, CDT, CGAL 6.1.
CONFORMING = {
    "T_supported": ("8e2 / 0.06", "6.1 / 0.3", "62 / 0.6", "2e5 / 0.1", "2e16 / 0.2"),
    "sphere_l0.03": ("8e5 / 0.1", "49 / 3.2", "109 / 7", "6e5 / 0.1", "2e32 / 1.1"),
    "pyramid_l0.03": ("crash", "", "72 / 1.2", "3e5 / 0.0", "5e18 / 0.3"),
    "nugear_coarse": ("2e5 / 0.1", "1.6e3 / 1.2", "1.3e3 / 4.7", "2e5 / 0.2", "4e32 / 0.8"),
    "anchor_0_l0.06": ("4e11 / 0.1", "2e6 / 24", "more than 9 GB", "2e11 / 0.3", "8e29 / 1.0"),
    "fandisk_l0.03_cino": ("1e7 / 0.2", "none in 300 s", "more than 9 GB", "6e7 / 0.3", "7e28 / 2.5"),
    "joint_l0.02": ("3e5 / 0.1", "9e4 / 5", "2e5 / 9", "2e9 / 0.3", "2e17 / 1.2"),
    "anc_101_a1_l0.01": ("2e7 / 0.4", "none in 300 s", "none in 600 s", "1e10 / 24", "6e20 / 17"),
    "CAD5_Lp_l0.13": ("crash", "", "none in 600 s", "7e24 / 30", "7e21 / 116"),
    "torus_coarse": ("7e3 / 0.0", "215 / 0.2", "172 / 1.2", "7e3 / 0.0", "3e30 / 0.1"),
}


def short(value, digits=4):
    """So many significant digits, without exponent where that is readable."""
    if value is None:
        return "infinite"
    if value == 0:
        return "0"
    if abs(value) >= 1e5 or abs(value) < 1e-4:
        return "%.2g" % value
    text = "%.*f" % (max(0, digits - 1 - math.floor(math.log10(abs(value)))), value)
    return text.rstrip("0").rstrip(".") if "." in text else text


def exponent(value):
    return "0" if value == 0 else ("%.1e" % value).replace("e-0", "e-")


def angles_text(angles):
    return "-".join("%.2f" % angle if angle < 10 else "%.1f" % angle for angle in angles)


def angles_of(text):
    return [float(angle) for angle in text.split("-")]


def count(value):
    return "{:,}".format(value)


def grade(value, goal):
    """0 goal missed, 1 must met, 2 aim met; for figures that should be small."""
    if value is None:
        return 0
    return 2 if value <= goal[1] else 1 if value <= goal[0] else 0


def marked(text, level):
    return ("**%s** no" if level == 0 else "%s must" if level == 1 else "%s aim") % text


class MetricFigures:
    """Of a mesh in TetGen's format after scaling by 1/l, 1/l, 1/h.

    angles: smallest and largest dihedral angle, degrees. wide: ascending R/3r of the tets that reach over more than l/2 in x and y, the
    long ones that such a mesh is made for.
    """

    def __init__(self, stem, l, h):
        with open(stem + ".node") as file:
            points = int(file.readline().split()[0])
            vertices = {}
            for _ in range(points):
                words = file.readline().split()
                vertices[int(words[0])] = (float(words[1]) / l, float(words[2]) / l, float(words[3]) / h)
        smallest, largest = 2.0, -2.0  # of the cosines between outer normals
        self.wide = []
        with open(stem + ".ele") as file:
            tets = int(file.readline().split()[0])
            for _ in range(tets):
                corners = [vertices[int(word)] for word in file.readline().split()[1:5]]
                p = corners[0]
                a, b, c = ([corner[k] - p[k] for k in range(3)] for corner in corners[1:])
                # Twice the areas of the three faces at p, and of the fourth: together they close.
                n1 = (b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0])
                n2 = (c[1] * a[2] - c[2] * a[1], c[2] * a[0] - c[0] * a[2], c[0] * a[1] - c[1] * a[0])
                n3 = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
                n4 = (-n1[0] - n2[0] - n3[0], -n1[1] - n2[1] - n3[1], -n1[2] - n2[2] - n3[2])
                normals = (n1, n2, n3, n4)
                areas = [math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) for n in normals]
                for i in range(3):
                    u = normals[i]
                    for j in range(i + 1, 4):
                        v = normals[j]
                        cosine = (u[0] * v[0] + u[1] * v[1] + u[2] * v[2]) / (areas[i] * areas[j])
                        if cosine < smallest:
                            smallest = cosine
                        if cosine > largest:
                            largest = cosine
                if any(math.hypot(q[0] - r[0], q[1] - r[1]) > 0.5 for i, q in enumerate(corners) for r in corners[:i]):
                    aa, bb, cc = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] for v in (a, b, c))
                    sixfold = abs(a[0] * n1[0] + a[1] * n1[1] + a[2] * n1[2])  # volume
                    radius = math.sqrt(sum((aa * n1[k] + bb * n2[k] + cc * n3[k])**2 for k in range(3))) / (2 * sixfold)
                    self.wide.append(radius * sum(areas) / (3 * sixfold))
        # The dihedral angle is what the angle between the outer normals leaves of 180 degrees.
        self.angles = tuple(180 - math.degrees(math.acos(max(-1.0, min(1.0, cosine)))) for cosine in (smallest, largest))
        self.wide.sort()


class Run:
    """All figures of one file with one configuration."""

    def __init__(self, work, configuration, name, rows):
        self.name = name
        self.code = max(int(row[2]) for row in rows)
        self.seconds = statistics.median(float(row[4]) + float(row[5]) for row in rows)
        self.wall = statistics.median(float(row[3]) for row in rows)
        self.mib = max(int(row[6]) for row in rows) / 1024
        self.runs = len(rows)
        stem = os.path.join(work, configuration, name)
        if self.code != 0:
            with open(stem + ".err", errors="replace") as file:
                lines = file.read().split("\n")
            message = next((line for line in reversed(lines) if line.strip()), "stopped" if self.code == 124 else "no message")
            self.error = re.sub(r"\S*/(?=\S+\.cli)", "", message).replace("|", "/")  # without folders of this machine
            return
        with open(stem + ".json") as file:
            self.report = json.load(file)
        quality = self.report["quality"]
        self.tets = self.report["mesh"]["tets"]
        self.vertices = self.report["mesh"]["vertices"]
        self.slabs = len(self.report["mesh"]["slabs"])
        self.h = self.report["thickness"]
        self.l = self.report["size"]
        self.eps = self.report["eps"]
        self.deviation = self.report["deviation"]["max"] / self.eps if self.eps else None
        certificate = self.report["certificate"]
        self.contour_error = certificate["volume"] / certificate["expected_volume"] - 1 if certificate["expected_volume"] else 0
        self.volume = self.report["volume_error"]
        self.crossing = quality["crossing"]
        self.columns = quality["column_share"]
        self.ratio = quality["ratio"]
        self.metric = quality.get("metric_ratio")
        self.angles = (quality["min_dihedral"], quality["max_dihedral"])
        self.worst = quality["worst"]
        self.raw = self.tets / RAW_FILL[name] if name in RAW_FILL else None
        self.certified = certificate["passed"]
        self.stages = self.report["seconds"]
        self.forced = quality["forced"]
        self.separation = self.report["separation"]
        self.scaled = MetricFigures(stem, self.l, self.h) if os.path.exists(stem + ".node") else None

    def angle_grade(self, angles):
        for level, (low, high) in ((2, ANGLES[1]), (1, ANGLES[0])):
            if angles[0] >= low and angles[1] <= high:
                return level
        return 0

    def grades(self, metric=False):
        """Name of the figure: (text, grade). Grade None: there is nothing to compare with."""
        ratio = self.metric if metric else self.ratio
        angles = self.scaled.angles if metric else self.angles
        worst = ratio["worst"] if metric else self.forced["worst_other"]
        cells = {
            "crossing": (count(self.crossing), 2 if self.crossing == 0 else 0),
            "mean": (short(ratio["mean"]), grade(ratio["mean"], MEAN)),
            "99.9 %": (short(ratio["p999"]), grade(ratio["p999"], P999)),
            "worst": (short(worst), grade(worst, WORST)),
            "dihedral angles": (angles_text(angles), self.angle_grade(angles)),
            "tets / raw fill": ("-", None) if self.raw is None else (short(self.raw, 3), grade(self.raw, TETS)),
            "deviation / eps": (short(self.deviation, 3), grade(self.deviation, (1, 1))),
            "seconds": ("%.1f" % self.seconds, grade(self.seconds, SECONDS)),
        }
        return cells


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def goals_table(runs, metric=False):
    figures = list(GOALS)
    rows = []
    for run in runs:
        if run.code != 0:
            rows.append([run.name, "no mesh: " + run.error] + [""] * (len(figures) - 1))
            continue
        cells = run.grades(metric)
        rows.append([run.name] + [cells[f][0] if cells[f][1] is None else marked(*cells[f]) for f in figures])
    return table(["file"] + figures, rows)


class Summary:
    """On how many files the goals of each figure are met, and which miss the must. A file without a mesh misses all of them."""

    def __init__(self, runs, metric=False):
        none = [(run.name, "no mesh") for run in runs if run.code != 0]
        graded = {run.name: run.grades(metric) for run in runs if run.code == 0}
        self.rows = []  # figure, goals, files compared, [(file, figure) that misses the must], files that meet the aim
        for figure, goals in GOALS.items():
            cells = {name: cells[figure] for name, cells in graded.items() if cells[figure][1] is not None}
            missed = [(name, text) for name, (text, level) in cells.items() if level == 0] + none
            best = sum(level == 2 for _, level in cells.values())
            self.rows.append((figure, goals, len(cells) + len(none), missed, best))

    def table(self):
        rows = []
        for figure, (must, aim), of, missed, best in self.rows:
            if of == 0:
                continue
            names = ", ".join("%s (%s)" % pair for pair in missed) or "-"
            rows.append([figure, must, "%d of %d" % (of - len(missed), of), names, aim, "%d of %d" % (best, of)])
        return table(["figure", "must", "met by", "missed by", "aim", "met by"], rows)

    def sentence(self):
        met = [figure for figure, _, _, missed, _ in self.rows if not missed]
        missed = ["%s on %d of %d files" % (figure, len(missed), of) for figure, _, of, missed, _ in self.rows if missed]
        return "musts met on all files: %s; missed: %s." % (", ".join(met) or "none", ", ".join(missed) or "none")


def largest_slab(run):
    """The largest error of a slab, and how far its contours are outside of its slice for that, in eps."""
    worst = run.volume["worst_slab"]
    if worst is None or not run.eps:
        return "-"
    return "%s (%s eps)" % (exponent(run.volume["per_slab"][worst]), short(run.volume["shift_per_slab"][worst] / run.eps, 2))


def details_table(runs):
    header = ["file", "slabs", "h (mm)", "l (mm)", "tets", "vertices", "median", "99 %", "columns", "volume error", "of a slab", "worst of all", "cause",
              "forced above %g" % FORCED_ABOVE, "MiB", "longest stage"]
    rows = []
    for run in runs:
        if run.code != 0:
            continue
        stage = max(run.stages, key=run.stages.get) if run.stages else "-"
        total = sum(run.stages.values()) or 1
        rows.append([
            run.name, count(run.slabs), short(run.h), short(run.l), count(run.tets), count(run.vertices), short(run.ratio["median"]),
            short(run.ratio["p99"]), "%.0f %%" % (100 * run.columns),
            exponent(run.volume["error"]), largest_slab(run), short(run.ratio["worst"]),
            run.worst[0]["cause"].replace("_", " ") if run.worst else "-",
            "%d of %d" % (run.forced["forced"], run.forced["elements"]),
            "%.0f" % run.mib, "%s, %.0f %%" % (stage, 100 * run.stages.get(stage, 0) / total)
        ])
    return table(header, rows)


def separation_table(runs):
    """How near contours come, in shares of eps and degrees, and how many are nearer than harmonization aims at."""
    header = ["file", "between layers: vertices", "vertex and edge", "angle", "nearer", "sharper", "within one contour: vertices",
              "vertex and edge", "angle", "nearer", "sharper"]
    rows = []
    for run in runs:
        if run.code != 0:
            continue
        row = [run.name]
        for kind in ("between", "within"):
            figures = run.separation[kind]
            eps = run.separation["tolerance"]
            for name in ("vertices", "vertex_edge"):
                row.append("-" if figures[name] is None or not eps else short(figures[name]["size"] / eps, 3))
            row.append("-" if figures["angle"] is None else short(figures["angle"]["size"], 3))
            row += [count(figures["close_vertices"][-1] + figures["close_vertex_edge"][-1]), count(figures["sharp"])]
        rows.append(row)
    return table(header, rows)


def both_table(runs):
    """Euclidean figures beside those in the metric."""
    header = ["file", "l (mm)", "tets", "columns", "metric: mean", "99.9 %", "worst", "dihedral", "wide tets", "mean", "99.9 %",
              "Euclidean: mean", "99.9 %", "worst", "dihedral"]
    rows = []
    for run in runs:
        if run.code != 0:
            continue
        figures = [[short(ratio["mean"]), short(ratio["p999"]), short(ratio["worst"]), angles_text(angles)]
                   for ratio, angles in ((run.metric, run.scaled.angles), (run.ratio, run.angles))]
        wide = run.scaled.wide
        long_ones = ["%.0f %%" % (100 * len(wide) / run.tets)]
        long_ones += [short(sum(wide) / len(wide)), short(wide[math.ceil(0.999 * len(wide)) - 1])] if wide else ["-", "-"]
        rows.append([run.name, short(run.l), count(run.tets), "%.0f %%" % (100 * run.columns)] + figures[0] + long_ones + figures[1])
    return table(header, rows)


def comparison(runs):
    done = [run for run in runs if run.code == 0]
    text = ""
    if done:
        mean = [run.ratio["mean"] for run in done]
        worst = [run.ratio["worst"] if run.ratio["worst"] is not None else math.inf for run in done]
        text = ("Over %d files: mean R/3r %s to %s (TetWild in the paper's Table 1: 1.2 to 1.9), worst %s to %s (6 to 345), "
                "tets that cross layers %s, at most %.1f s (hours).\n\n") % (
                    len(done), short(min(mean), 3), short(max(mean), 3), short(min(worst), 3), short(max(worst), 3),
                    count(sum(run.crossing for run in done)), max(run.seconds for run in done))
        text += table(PAPER_HEADER, [[
            run.name, count(run.tets), short(run.ratio["mean"]), short(run.ratio["worst"]), count(run.crossing), "%.1f" % run.seconds
        ] for run in done] + PAPER) + "\n"
    both = [run for run in runs if run.code == 0 and run.name in FTETWILD]
    rows = []
    for run in both:
        tets, mean, worst, angles, crossing, volume, seconds = FTETWILD[run.name]
        rows.append([
            run.name, count(run.tets), short(run.ratio["mean"]), short(run.ratio["worst"]),
            angles_text(run.angles), count(run.crossing), exponent(run.contour_error), exponent(run.volume["error"]),
            "%.1f" % run.seconds, tets, short(mean), short(worst), angles, "%g %%" % crossing, exponent(volume), "%g" % seconds
        ])
    if rows:
        names = ["tets", "mean", "worst", "dihedral", "crossing", "volume error", "against slices", "s"]
        text += table(["file"] + names + ["fTetWild: " + names[0]] + [name for name in names[1:] if name != "against slices"], rows)
        better = (sum(run.ratio["mean"] < FTETWILD[run.name][1] for run in both),
                  sum((run.ratio["worst"] or math.inf) < FTETWILD[run.name][2] for run in both),
                  sum(run.angles[0] > angles_of(FTETWILD[run.name][3])[0] for run in both),
                  sum(run.angles[1] < angles_of(FTETWILD[run.name][3])[1] for run in both),
                  sum(run.crossing == 0 for run in both),
                  sum(abs(run.contour_error) < abs(FTETWILD[run.name][5]) for run in both),
                  sum(abs(run.volume["error"]) < abs(FTETWILD[run.name][5]) for run in both),
                  sum(run.seconds < FTETWILD[run.name][6] for run in both))
        text += ("\nBetter than fTetWild: the mean on %d of these %d files, the worst element on %d, the smallest dihedral angle on "
                 "%d, the largest on %d, crossing tets on %d, the volume error on %d (that against the slices on %d), the time on "
                 "%d.\n\n") % (better[0], len(both), *better[1:])
    rows = [[run.name, "%s / %.1f" % (short(run.ratio["worst"]), run.seconds)] + [cell or "-" for cell in CONFORMING[run.name]]
            for run in runs if run.code == 0 and run.name in CONFORMING]
    if rows:
        text += table(["file", "slice2mesh", "TetGen 1.5 `-p`", "TetGen 1.5 `-q`", "TetGen 1.6 `-q`", "CDT (Diazzi et al. 2023)",
                       "CGAL 6.1 `CDT_3`"], rows)
    return text


def summary_text(runs):
    """The goals over all files, and how the figures are spread."""
    done = [run for run in runs if run.code == 0]
    text = "%s\n%s" % (heading({"default": runs}), Summary(runs).table())
    if done:
        rows = []
        for name, values in (("tets", [run.tets for run in done]), ("mean", [run.ratio["mean"] for run in done]),
                             ("99.9 %", [run.ratio["p999"] for run in done]), ("worst", [run.forced["worst_other"] for run in done]),
                             ("smallest angle", [run.angles[0] for run in done]), ("largest angle", [run.angles[1] for run in done]),
                             ("deviation / eps", [run.deviation for run in done]),
                             ("abs. volume error", [abs(run.volume["error"]) for run in done]), ("seconds", [run.seconds for run in done])):
            values = sorted(math.inf if value is None else value for value in values)
            form = count if name == "tets" else short
            rows.append([name, form(values[0]), form(values[(len(values) - 1) // 2]), form(values[-1])])
        text += "\n" + table(["figure", "smallest", "median", "largest"], rows)
    return text


def heading(runs):
    """Version, and how many meshes there are."""
    group = [run for runs_of_one in runs.values() for run in runs_of_one]
    done = [run for run in group if run.code == 0]
    repeated = max(run.runs for run in group)
    return "Version %s; %d of %d meshes made, %s; times are %s.\n" % (
        done[0].report["version"] if done else "?", len(done), len(group),
        "every one certified" if all(run.certified for run in done) else "NOT all certified",
        "of a single run" if repeated == 1 else "medians of %d runs" % repeated)


def write(page, markers, text):
    """Puts the text between the markers of a page, or prints it."""
    if page == "-":
        print(text)
        return
    begin, end = markers
    with open(page) as file:
        old = file.read()
    if old.count(begin) != 1 or old.count(end) != 1:
        sys.exit("quality_table.py: %s needs the two markers once" % page)
    head, rest = old.split(begin)
    tail = rest.split(end)[1]
    temporary = page + ".new"
    with open(temporary, "w") as file:
        file.write(head + begin + "\n\n" + text + "\n" + end + tail)
    os.replace(temporary, page)


def main():
    if len(sys.argv) != 4 or sys.argv[3] not in MARKERS:
        sys.exit("usage: quality_table.py WORK PAGE all|summary")
    work, page, kind = sys.argv[1:]
    rows = {}
    with open(os.path.join(work, "runs.tsv")) as file:
        for line in file:
            row = line.rstrip("\n").split("\t")
            rows.setdefault(row[0], {}).setdefault(row[1], []).append(row)
    with open(os.path.join(work, "configurations.tsv")) as file:
        options = dict(line.rstrip("\n").split("\t") for line in file)
    runs = {configuration: [Run(work, configuration, name, found) for name, found in files.items()]
            for configuration, files in rows.items()}
    first = runs["default"]
    if kind == "summary":
        write(page, MARKERS[kind], summary_text(first))
        return
    text = heading(runs)
    sections = [("default", "Default options", False), ("size10h", "Long elements", True),
                ("lump3", "Bundles of three slices", False), ("columns", "Columns kept", False)]
    summaries = {key: Summary(runs[key], metric) for key, _, metric in sections if key in runs}
    text += "\n" + "".join("* %s: %s\n" % (title, summaries[key].sentence()) for key, title, _ in sections if key in runs)
    done = [run for run in first if run.code == 0]
    bad = [run for run in done if run.ratio["worst"] is None or run.ratio["worst"] > WORST[1]]
    causes = sorted(run.worst[0]["cause"].replace("_", " ") for run in bad)
    text += "* Default options, the worst element of the %d files where it is above %g: cause %s" % (
        len(bad), WORST[1], ", ".join("%s (%d)" % (cause, causes.count(cause)) for cause in sorted(set(causes))) or "-")
    edges = sorted(run.worst[0]["shortest_edge"] / run.eps for run in bad if run.eps)
    text += "; shortest edge %s to %s eps.\n" % (short(edges[0], 2), short(edges[-1], 2)) if edges else ".\n"
    text += "* Default options, forced by the input: %s of %s elements above %g.\n" % (
        count(sum(run.forced["forced"] for run in done)), count(sum(run.forced["elements"] for run in done)), FORCED_ABOVE)
    for key, title, metric in sections:
        if key not in runs:
            continue
        text += "\n### %s\n\n`%s`" % (title, options[key])
        if metric:
            text += ": figures in the metric diag(1/l^2, 1/l^2, 1/h^2) against the same goals."
        text += "\n\n" + summaries[key].table() + "\n" + goals_table(runs[key], metric) + "\n"
        text += both_table(runs[key]) if metric else details_table(runs[key])
        if key == "default":
            text += "\n" + separation_table(first) + "\n### Beside other tools\n\n" + comparison(first)
    write(page, MARKERS[kind], text)


if __name__ == "__main__":
    main()
