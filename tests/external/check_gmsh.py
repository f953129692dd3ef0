# SPDX-License-Identifier: MIT
"""Gmsh reads MSH (text, binary) and MEDIT files and saves them as MSH 2.2, from which groups and figures are taken."""
import os
import shutil
import subprocess
import tempfile

from expected import Check, skip, tet_volume, triangle_area

program = shutil.which("gmsh")
if program is None:
    skip("the program gmsh is not installed")

check = Check()
expected = check.expected
layer_volumes = {layer + 1: volume for layer, volume in enumerate(expected["layer_volumes"])}


def convert(name, save_all):
    """Names of physical groups, and volumes and areas by physical tag, of what Gmsh made of the file."""
    with tempfile.TemporaryDirectory() as directory:
        output = os.path.join(directory, "converted.msh")
        command = [program, check.path(name), "-save", "-format", "msh22", "-o", output]
        if save_all:
            command.append("-save_all")
        run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False, text=True)
        if run.returncode != 0 or "Error" in run.stdout or "Warning" in run.stdout:
            print(run.stdout)
        check.equal(name + ": exit code", run.returncode, 0)
        check.equal(name + ": errors and warnings", run.stdout.count("Error") + run.stdout.count("Warning"), 0)
        with open(output, encoding="utf-8") as file:
            lines = iter(file.read().splitlines())
    names, nodes, sums, tets = {}, {}, {}, 0
    for line in lines:
        if line == "$PhysicalNames":
            for _ in range(int(next(lines))):
                dimension, tag, group = next(lines).split(maxsplit=2)
                names[int(dimension), int(tag)] = group.strip('"')
        elif line == "$Nodes":
            for _ in range(int(next(lines))):
                tag, *point = next(lines).split()
                nodes[int(tag)] = [float(x) for x in point]
        elif line == "$Elements":
            for _ in range(int(next(lines))):
                fields = [int(x) for x in next(lines).split()]
                kind, label, corners = fields[1], fields[3 if not save_all else 4], fields[3 + fields[2] :]
                points = [nodes[v] for v in corners]
                dimension = {2: 2, 4: 3}[kind]
                tets += kind == 4
                size = tet_volume(*points) if kind == 4 else triangle_area(*points)
                sums[dimension, label] = sums.get((dimension, label), 0) + size
    check.equal(name + ": tets", tets, expected["tets"])
    return names, sums


def compare(what, found, wanted):
    check.equal(what + ": sets", sorted(found), sorted(wanted))
    for key in sorted(set(found) & set(wanted)):
        check.close(f"{what}: {key}", found[key], wanted[key], 1e-12)


for name in ("sample.msh", "sample_binary.msh"):
    names, sums = convert(name, False)
    compare(name + ": volume of group", {names[k]: x for k, x in sums.items() if k[0] == 3}, expected["group_volumes"])
    compare(name + ": area of surface", {names[k]: x for k, x in sums.items() if k[0] == 2}, expected["surface_areas"])

names, sums = convert("sample.mesh", True)
compare("MEDIT: volume of layer", {k[1]: x for k, x in sums.items() if k[0] == 3}, layer_volumes)
surfaces = {expected["surface_names"][k[1] - 1]: x for k, x in sums.items() if k[0] == 2}
compare("MEDIT: area of surface", surfaces, expected["surface_areas"])
check.finish()
