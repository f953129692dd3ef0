# SPDX-License-Identifier: MIT
"""Gmsh reads MSH (text, binary, quadratic) and MEDIT files and saves them as MSH 2.2, from which groups and figures are
taken. It has no reader of INP and VTU files: meshio passes these on.
"""
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


# Corners of the edge that the nodes behind the corners lie on, as Gmsh orders them.
EDGES = {9: ((0, 1), (1, 2), (2, 0)), 11: ((0, 1), (1, 2), (2, 0), (3, 0), (2, 3), (1, 3))}


def convert(name, save_all, directory_of_file=None):
    """Names of physical groups, and volumes and areas by physical tag, of what Gmsh made of the file."""
    with tempfile.TemporaryDirectory() as directory:
        output = os.path.join(directory, "converted.msh")
        path = os.path.join(directory_of_file, name) if directory_of_file else check.path(name)
        command = [program, path, "-save", "-format", "msh22", "-o", output]
        if save_all:
            command.append("-save_all")
        run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False, text=True)
        if run.returncode != 0 or "Error" in run.stdout or "Warning" in run.stdout:
            print(run.stdout)
        check.equal(name + ": exit code", run.returncode, 0)
        check.equal(name + ": errors and warnings", run.stdout.count("Error") + run.stdout.count("Warning"), 0)
        with open(output, encoding="utf-8") as file:
            lines = iter(file.read().splitlines())
    names, nodes, sums, tets, misplaced = {}, {}, {}, 0, 0
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
                dimension = {2: 2, 9: 2, 4: 3, 11: 3}[kind]  # triangles and tets, linear and quadratic
                tets += dimension == 3
                size = tet_volume(*points[:4]) if dimension == 3 else triangle_area(*points[:3])
                for i, (a, b) in enumerate(EDGES.get(kind, ())):
                    node = points[{9: 3, 11: 4}[kind] + i]
                    # Gmsh writes 16 digits.
                    misplaced += any(abs((p + q) / 2 - x) > 1e-12 for p, q, x in zip(points[a], points[b], node))
                sums[dimension, label] = sums.get((dimension, label), 0) + size
    check.equal(name + ": tets", tets, expected["tets"])
    check.equal(name + ": nodes that are not in the middle of their edge", misplaced, 0)
    return names, sums


def compare(what, found, wanted):
    check.equal(what + ": sets", sorted(found), sorted(wanted))
    for key in sorted(set(found) & set(wanted)):
        check.close(f"{what}: {key}", found[key], wanted[key], 1e-12)


for name in ("sample.msh", "sample_binary.msh", "quadratic.msh"):
    names, sums = convert(name, False)
    compare(name + ": volume of group", {names[k]: x for k, x in sums.items() if k[0] == 3}, expected["group_volumes"])
    compare(name + ": area of surface", {names[k]: x for k, x in sums.items() if k[0] == 2}, expected["surface_areas"])

names, sums = convert("sample.mesh", True)
compare("MEDIT: volume of layer", {k[1]: x for k, x in sums.items() if k[0] == 3}, layer_volumes)
surfaces = {expected["surface_names"][k[1] - 1]: x for k, x in sums.items() if k[0] == 2}
compare("MEDIT: area of surface", surfaces, expected["surface_areas"])

try:
    import meshio
    import numpy
except ImportError:
    print("INP and VTU left out: the Python module meshio is not installed")
    check.finish()

for name in ("sample.inp", "sample.vtu"):
    mesh = meshio.read(check.path(name))
    tets = [block for block in mesh.cells if block.type == "tetra"]
    if name.endswith("vtu"):
        labels = [x + 1 for x in mesh.cell_data["layer"]]
    else:  # a block of elements per layer
        labels = [numpy.full(len(block.data), number) for number, block in enumerate(tets, 1)]
    labels = [numpy.asarray(x, dtype=numpy.int32) for x in labels]
    tagged = meshio.Mesh(mesh.points, tets, cell_data={"gmsh:physical": labels, "gmsh:geometrical": labels})
    with tempfile.TemporaryDirectory() as directory:
        meshio.write(os.path.join(directory, "through_meshio.msh"), tagged, file_format="gmsh22")
        names, sums = convert("through_meshio.msh", True, directory)
    compare(name + " through meshio: volume of layer", {k[1]: x for k, x in sums.items()}, layer_volumes)
check.finish()
