# SPDX-License-Identifier: MIT
"""What the checks have in common: the expected figures, comparing, and the exit codes (0 good, 1 bad, 77 skipped)."""
import json
import os
import sys

SKIPPED = 77


def skip(reason):
    print("skipped: " + reason)
    sys.exit(SKIPPED)


class Check:
    """Compares what another program found with `expected.json` of the directory given on the command line."""

    def __init__(self):
        if len(sys.argv) != 2:
            sys.exit("usage: " + sys.argv[0] + " <directory with the sample files and expected.json>")
        self.directory = sys.argv[1]
        with open(self.path("expected.json"), encoding="utf-8") as file:
            self.expected = json.load(file)
        self.compared = 0
        self.failed = 0

    def path(self, name):
        return os.path.join(self.directory, name)

    def equal(self, what, found, wanted):
        self._compare(what, found, wanted, found == wanted)

    def close(self, what, found, wanted, relative):
        self._compare(what, found, wanted, abs(found - wanted) <= relative * abs(wanted))

    def _compare(self, what, found, wanted, good):
        self.compared += 1
        print(f"{'ok    ' if good else 'FAILED'} {what}: {found}" + ("" if good else f", expected {wanted}"))
        if not good:
            self.failed += 1

    def finish(self):
        print(f"{self.compared} comparisons, {self.failed} failed")
        sys.exit(0 if self.compared > 0 and self.failed == 0 else 1)


def tet_volume(a, b, c, d):
    u, v, w = ([q[i] - a[i] for i in range(3)] for q in (b, c, d))
    return (
        (u[1] * v[2] - u[2] * v[1]) * w[0] + (u[2] * v[0] - u[0] * v[2]) * w[1] + (u[0] * v[1] - u[1] * v[0]) * w[2]
    ) / 6


def triangle_area(a, b, c):
    u, v = ([q[i] - a[i] for i in range(3)] for q in (b, c))
    n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
    return (n[0] ** 2 + n[1] ** 2 + n[2] ** 2) ** 0.5 / 2
