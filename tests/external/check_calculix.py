# SPDX-License-Identifier: MIT
"""CalculiX solves a job of two layers that cool by convection, and one of ten layers runs to its end.

The conductivity is so high that the temperature is uniform (lumped cooling): in a step of length t it falls as
exp(-h A t / (rho c V)) towards that of the surroundings, A and V being exposed area and volume in that step. When the
second layer comes to life its upper nodes are at the initial temperature and the lower ones, which it shares, at that of
the first layer; the share of the upper ones in its heat is one half.
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
increments = solve("two_layers")
step = job["time_per_layer"]
capacity = job["density"] * job["specific_heat"]
start = job["initial"] - job["sink"]


def rate(k):
    return job["film"] * job["exposed_area"][k] / (capacity * job["volume"][k])


# Increments are not infinitely small: the rate is found to about 1 %. One face more or less would change it by 10 %.
first = drop(at_time(increments, step), job)
check.close("rate of cooling in step 1", -math.log(first / start) / step, rate(0), 0.02)
joined = (3 * first + start) / 4
second = drop(at_time(increments, 2 * step), job)
check.close("rate of cooling in step 2", -math.log(second / joined) / step, rate(1), 0.02)

increments = solve("ten_layers")
last = increments[-1]
check.close("end of the job of ten layers", last[0], 10 * step, 1e-6)
check.equal("nodes alive at its end", len(last[1]), check.expected["ten_layers_nodes"])
check.finish()
