# SPDX-License-Identifier: MIT
"""meshio reads VTU, MSH (text, binary), MEDIT, INP, Exodus, TetGen, OFF and OBJ files; quadratic ones of VTU, MSH and INP."""
from expected import Check, skip, tet_volume, triangle_area

try:
    import meshio
except ImportError:
    skip("the Python module meshio is not installed")

check = Check()
expected = check.expected
layers = len(expected["layer_volumes"])


def cells(mesh, kind):
    """All cells of a kind with the number of their block."""
    return [(block, cell) for block, found in enumerate(mesh.cells) if found.type == kind for cell in found.data]


def volumes_by(mesh, labels, kind="tetra"):
    sums = {}
    for (_, cell), label in zip(cells(mesh, kind), labels):
        sums[label] = sums.get(label, 0) + tet_volume(*(mesh.points[v] for v in cell[:4]))
    return sums


def areas_by(mesh, labels):
    sums = {}
    for (_, cell), label in zip(cells(mesh, "triangle"), labels):
        sums[label] = sums.get(label, 0) + triangle_area(*(mesh.points[v] for v in cell))
    return sums


def labels_of(mesh, name, kind):
    return [int(x) for found, values in zip(mesh.cells, mesh.cell_data[name]) if found.type == kind for x in values]


def compare(what, found, wanted):
    check.equal(what + ": sets", sorted(found), sorted(wanted))
    for key in sorted(set(found) & set(wanted)):
        check.close(f"{what}: {key}", found[key], wanted[key], 1e-12)


layer_volumes = dict(enumerate(expected["layer_volumes"]))

for name in ("sample.msh", "sample_binary.msh"):
    mesh = meshio.read(check.path(name))
    check.equal(name + ": points", len(mesh.points), expected["vertices"])
    check.equal(name + ": tets", len(cells(mesh, "tetra")), expected["tets"])
    groups = {3: {}, 2: {}}
    for group, (tag, dimension) in mesh.field_data.items():
        groups[int(dimension)][int(tag)] = group
    tets = [groups[3][tag] for tag in labels_of(mesh, "gmsh:physical", "tetra")]
    triangles = [groups[2][tag] for tag in labels_of(mesh, "gmsh:physical", "triangle")]
    compare(name + ": volume of group", volumes_by(mesh, tets), expected["group_volumes"])
    compare(name + ": area of surface", areas_by(mesh, triangles), expected["surface_areas"])

mesh = meshio.read(check.path("sample.mesh"))
check.equal("MEDIT: points", len(mesh.points), expected["vertices"])
references = labels_of(mesh, "medit:ref", "tetra")
compare("MEDIT: volume of layer", volumes_by(mesh, [r - 1 for r in references]), layer_volumes)
surfaces = [expected["surface_names"][r - 1] for r in labels_of(mesh, "medit:ref", "triangle")]
compare("MEDIT: area of surface", areas_by(mesh, surfaces), expected["surface_areas"])

mesh = meshio.read(check.path("sample.vtu"))
check.equal("VTU: points", len(mesh.points), expected["vertices"])
compare("VTU: volume of layer", volumes_by(mesh, labels_of(mesh, "layer", "tetra")), layer_volumes)

mesh = meshio.read(check.path("sample.inp"))
check.equal("INP: points", len(mesh.points), expected["vertices"])
check.equal("INP: tets", len(cells(mesh, "tetra")), expected["tets"])
# One block of elements per layer, in their order.
compare("INP: volume of layer", volumes_by(mesh, [block for block, _ in cells(mesh, "tetra")]), layer_volumes)

# meshio keeps the nodes of quadratic tets in the order of VTK: 4 + i lies between the corners of edge i.
EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
for name in ("quadratic.vtu", "quadratic.msh", "quadratic.inp"):
    mesh = meshio.read(check.path(name))
    tets = cells(mesh, "tetra10")
    check.equal(name + ": points", len(mesh.points), expected["quadratic_nodes"])
    check.equal(name + ": tets", len(tets), expected["tets"])
    tolerance = 1e-11 if name.endswith("inp") else 0  # INP: numbers of 20 characters
    wrong = 0
    for _, cell in tets:
        p = mesh.points[cell]
        wrong += sum(abs((p[a] + p[b]) / 2 - p[4 + i]).max() > tolerance for i, (a, b) in enumerate(EDGES))
    check.equal(name + ": nodes that are not in the middle of their edge", wrong, 0)
    if name.endswith("inp"):
        compare(name + ": volume of layer", volumes_by(mesh, [block for block, _ in tets], "tetra10"), layer_volumes)

if expected["exodus"]:
    mesh = meshio.read(check.path("sample.exo"))
    check.equal("Exodus: points", len(mesh.points), expected["vertices"])
    by_block = sorted(expected["group_volumes"].values())
    found = volumes_by(mesh, [block for block, _ in cells(mesh, "tetra")])
    check.equal("Exodus: blocks", len(found), len(by_block))
    for volume, wanted in zip(sorted(found.values()), by_block):
        check.close("Exodus: volume of a block", volume, wanted, 1e-12)

mesh = meshio.read(check.path("sample.ele"))
check.equal("TetGen: points", len(mesh.points), expected["vertices"])
check.equal("TetGen: tets", len(cells(mesh, "tetra")), expected["tets"])
check.close(
    "TetGen: volume", sum(volumes_by(mesh, [0] * expected["tets"]).values()), sum(expected["layer_volumes"]), 1e-12
)

for name in ("complex.off", "complex.obj"):
    mesh = meshio.read(check.path(name))
    check.equal(name + ": triangles", len(cells(mesh, "triangle")), expected["complex_triangles"])
    area = sum(triangle_area(*(mesh.points[v] for v in cell)) for _, cell in cells(mesh, "triangle"))
    check.close(name + ": area", area, expected["complex_area"], 1e-12)
check.finish()
