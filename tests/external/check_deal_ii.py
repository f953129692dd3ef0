# SPDX-License-Identifier: MIT
"""deal.II (through deal_ii_reader.cpp) reads an MSH file without inner faces: material and boundary ids are counted."""
import json
import os
import subprocess

from expected import Check, skip

program = os.environ.get("SLICE2MESH_DEAL_II_READER", "")
if not os.path.exists(program):
    skip("the reader with deal.II was not built")

check = Check()
expected = check.expected
run = subprocess.run(
    [program, check.path("sample_skin.msh")], stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False, text=True
)
if run.returncode != 0:
    print(run.stderr[-3000:])
check.equal("exit code", run.returncode, 0)
found = json.loads(run.stdout)
check.equal("vertices", found["vertices"], expected["vertices"])

# Physical tags of volumes are 1, 2, ... by layer, then region; names sort the same way but for the regions.
with open(check.path("sample_skin.msh"), encoding="utf-8") as file:
    lines = iter(file.read().splitlines())
names = {2: {}, 3: {}}
for line in lines:
    if line == "$PhysicalNames":
        for _ in range(int(next(lines))):
            dimension, tag, name = next(lines).split(maxsplit=2)
            names[int(dimension)][tag] = name.strip('"')

groups = {names[3].get(tag, tag): figures for tag, figures in found["materials"].items()}
check.equal("material ids", sorted(groups), sorted(expected["group_volumes"]))
for name, (count, volume) in sorted(groups.items()):
    check.equal("cells of " + name, count, expected["group_tets"][name])
    check.close("volume of " + name, volume, expected["group_volumes"][name], 1e-12)

inner = ("support_interface", "plate_interface")
surfaces = {names[2].get(tag, tag): figures for tag, figures in found["boundaries"].items()}
check.equal("boundary ids", sorted(surfaces), sorted(set(expected["surface_areas"]) - set(inner)))
for name, (count, area) in sorted(surfaces.items()):
    check.equal("faces of " + name, count, expected["surface_triangles"][name])
    check.close("area of " + name, area, expected["surface_areas"][name], 1e-12)
check.finish()
