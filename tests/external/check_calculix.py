# SPDX-License-Identifier: MIT
"""CalculiX solves jobs of two layers that cool by convection, and jobs of ten layers run to their end; linear and quadratic.

The conductivity is so high that the temperature is uniform (lumped cooling): in a step of length t it falls as
exp(-h A t / (rho c V)) towards that of the surroundings, A and V being exposed area and volume in that step. When the
second layer comes to life its lower nodes, which it shares, are at the temperature of the first layer, and all others at
the initial one. In linear elements the profile is linear from one to the other, and the share of the lower nodes in the
heat of the layer is 1/2; in quadratic ones it is the parabola that is 1 at the bottom and 0 half way up and at the top,
with the share 1/6.
"""
import math
import os
import shutil
import subprocess
import tempfile

from expected import Check, skip

program = shutil.which("ccx")
if program is None:
    skip("the program ccx (CalculiX) is not installed")

check = Check()


def solve(job):
    """Nodal temperatures (by node) of all increments, and the steps with their last increments."""
    with tempfile.TemporaryDirectory() as directory:
        for suffix in ("", "_steps"):
            shutil.copy(check.path(job + suffix + ".inp"), directory)
        environment = dict(os.environ, OMP_NUM_THREADS="1")
        run = subprocess.run(
            [program, job + "_steps"],
            cwd=directory,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            check=False,
            text=True,
        )
        finished = "Job finished" in run.stdout and "*ERROR" not in run.stdout
        if not finished:
            print(run.stdout[-3000:])
        check.equal(job + ": finished", finished, True)
        with open(os.path.join(directory, job + "_steps.frd"), encoding="latin-1") as file:
            lines = file.read().splitlines()
    increments, current, time, active = [], None, 0.0, False
    for line in lines:
        if line.startswith("  100CL"):
            time = float(line[12:24])
        elif line.startswith(" -4  NDTEMP"):
            current, active = {}, True
            increments.append((time, current))
        elif line.startswith(" -3"):
            active = False
        elif line.startswith(" -1") and active:
            current[int(line[3:13])] = float(line[13:25])
    return increments


def at_time(increments, time):
    found = [values for t, values in increments if abs(t - time) < 1e-6 * time]
    check.equal(f"increments that end at {time}", len(found), 1)
    return found[0] if found else {0: math.nan}


def drop(values, job):
    """Mean of the temperature above the surroundings; checks that it is uniform."""
    low, high = min(values.values()), max(values.values())
    check.equal("uniform temperature", high - low < 1e-3 * (job["initial"] - job["sink"]), True)
    return (low + high) / 2 - job["sink"]


job = check.expected["calculix"]
step = job["time_per_layer"]
capacity = job["density"] * job["specific_heat"]
start = job["initial"] - job["sink"]


def rate(k):
    return job["film"] * job["exposed_area"][k] / (capacity * job["volume"][k])


# Increments are not infinitely small: the rate is found to about 1 %. One face more or less would change it by 10 %.
for kind, share in (("linear", 1 / 2), ("quadratic", 1 / 6)):
    increments = solve("two_" + kind)
    first = drop(at_time(increments, step), job)
    check.close(kind + ": rate of cooling in step 1", -math.log(first / start) / step, rate(0), 0.02)
    joined = (first + share * first + (1 - share) * start) / 2
    second = drop(at_time(increments, 2 * step), job)
    check.close(kind + ": rate of cooling in step 2", -math.log(second / joined) / step, rate(1), 0.02)

    increments = solve("ten_" + kind)
    last = increments[-1]
    check.close(kind + ": end of the job of ten layers", last[0], 10 * step, 1e-6)
    check.equal(kind + ": nodes alive at its end", len(last[1]), check.expected[f"ten_{kind}_nodes"])

# The sample itself, with hole, overhang, supports and two parts: nothing is hotter than a new layer or colder than the
# surroundings, and at the end everything is alive. Quadratic elements may overshoot where a hot layer meets a cold one.
layers = len(check.expected["layer_volumes"]) - check.expected["plate_slabs"]
for name, nodes, slack in (("print", "vertices", 1), ("print_quadratic", "quadratic_nodes", 200)):
    increments = solve(name)
    last = increments[-1]
    check.close(name + ": end of the job", last[0], 10 * layers, 1e-6)
    check.equal(name + ": nodes alive at its end", len(last[1]), check.expected[nodes])
    low = min(min(values.values()) for _, values in increments)
    high = max(max(values.values()) for _, values in increments)
    check.equal(f"{name}: temperatures from {low} to {high} in bounds", 300 - slack <= low and high <= 1500 + slack, True)
check.finish()
