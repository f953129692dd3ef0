# SPDX-License-Identifier: MIT
"""FreeFEM reads the MEDIT file and integrates 1 over every region and every surface label."""
import glob
import os
import shutil
import subprocess
import tempfile

from expected import Check, skip

program = shutil.which("FreeFem++-nw") or shutil.which("FreeFem++")
if program is None:
    skip("the program FreeFem++ is not installed")
# Where packages put the plugins; the program itself may look elsewhere.
plugins = sorted(
    {os.path.dirname(p) for pattern in ("/usr/lib/freefem++/msh3.so", "/usr/lib/*/freefem++/msh3.so",
                                        "/usr/lib/ff++/*/lib/msh3.so", "/usr/local/lib/ff++/*/lib/msh3.so")
     for p in glob.glob(pattern)}
)
if not plugins:
    skip("the plugin msh3 of FreeFem++ is not installed")

check = Check()
expected = check.expected

SCRIPT = """
load "msh3"
mesh3 Th("{mesh}");
cout.precision(17);
cout << "COUNT " << Th.nt << " " << Th.nv << " " << Th.nbe << endl;
int[int] inside = regions(Th);
for (int i = 0; i < inside.n; i++) {{ real v = int3d(Th, inside[i])(1.); cout << "VOLUME " << inside[i] << " " << v << endl; }}
int[int] around = labels(Th);
for (int i = 0; i < around.n; i++) {{ real a = int2d(Th, around[i])(1.); cout << "AREA " << around[i] << " " << a << endl; }}
"""

with tempfile.TemporaryDirectory() as directory:
    script = os.path.join(directory, "check.edp")
    with open(script, "w", encoding="utf-8") as file:
        file.write(SCRIPT.format(mesh=check.path("sample.mesh")))
    environment = dict(os.environ, FF_LOADPATH=";;".join(plugins), OMP_NUM_THREADS="1")
    run = subprocess.run(
        [program, "-nw", "-v", "0", script],
        cwd=directory,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
        text=True,
    )
if run.returncode != 0:
    print(run.stdout[-3000:])
check.equal("exit code", run.returncode, 0)
counts, volumes, areas = [], {}, {}
for line in run.stdout.splitlines():
    words = line.split()
    if words[:1] == ["COUNT"]:
        counts = [int(w) for w in words[1:]]
    elif words[:1] == ["VOLUME"]:
        volumes[int(words[1])] = float(words[2])
    elif words[:1] == ["AREA"]:
        areas[expected["surface_names"][int(words[1]) - 1]] = float(words[2])
check.equal(
    "tets, vertices, triangles",
    counts,
    [expected["tets"], expected["vertices"], sum(expected["surface_triangles"].values())],
)
check.equal("regions", sorted(volumes), list(range(1, len(expected["layer_volumes"]) + 1)))
for label, volume in sorted(volumes.items()):
    check.close(f"volume of layer {label}", volume, expected["layer_volumes"][label - 1], 1e-12)
check.equal("labels", sorted(areas), sorted(expected["surface_areas"]))
for name, area in sorted(areas.items()):
    check.close("area of " + name, area, expected["surface_areas"][name], 1e-12)
check.finish()
