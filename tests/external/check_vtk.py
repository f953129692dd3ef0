# SPDX-License-Identifier: MIT
"""VTK reads VTU files (linear and quadratic), the steps of the PVD file, Exodus II, and the skin as PLY, STL and OBJ."""
import os
import xml.etree.ElementTree

from expected import Check, skip, tet_volume, triangle_area

try:
    import vtk
except ImportError:
    skip("the Python module vtk is not installed")

check = Check()
expected = check.expected
layers = len(expected["layer_volumes"])
plate = expected["plate_slabs"]


def read(path):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def corners(grid, cell, count):
    ids = grid.GetCell(cell).GetPointIds()
    return [grid.GetPoint(ids.GetId(i)) for i in range(count)]


def compare_grid(name, quadratic):
    grid = read(check.path(name))
    nodes = expected["quadratic_nodes" if quadratic else "vertices"]
    check.equal(name + ": points", grid.GetNumberOfPoints(), nodes)
    check.equal(name + ": cells", grid.GetNumberOfCells(), expected["tets"])
    data = grid.GetCellData()
    names = {data.GetArrayName(i) for i in range(data.GetNumberOfArrays())}
    wanted = ["layer", "part", "region", "material", "slice", "bundle", "activation_time"]
    check.equal(name + ": cell arrays", sorted(names), sorted(wanted))
    field = grid.GetFieldData()
    check.equal(name + ": slabs", field.GetArray("slab_z_low").GetNumberOfTuples(), layers)
    layer_volumes = [0.0] * layers
    region_volumes = [0.0] * len(expected["region_volumes"])
    times_wrong = inverted = misplaced = outside = 0
    for cell in range(grid.GetNumberOfCells()):
        points = corners(grid, cell, 10 if quadratic else 4)
        volume = tet_volume(*points[:4])
        inverted += volume <= 0
        layer = int(data.GetArray("layer").GetValue(cell))
        layer_volumes[layer] += volume
        region_volumes[int(data.GetArray("region").GetValue(cell))] += volume
        time = expected["time_per_layer"] * max(0, layer - plate)
        times_wrong += data.GetArray("activation_time").GetValue(cell) != time
        low, high = (field.GetArray("slab_z_" + end).GetValue(layer) for end in ("low", "high"))
        outside += not all(low <= p[2] <= high for p in points)
        for i, (a, b) in enumerate(((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)) if quadratic else ()):
            misplaced += tuple((p + q) / 2 for p, q in zip(points[a], points[b])) != points[4 + i]
    kind = vtk.VTK_QUADRATIC_TETRA if quadratic else vtk.VTK_TETRA
    check.equal(name + ": cell types", {grid.GetCellType(i) for i in range(grid.GetNumberOfCells())}, {kind})
    check.equal(name + ": inverted tets", inverted, 0)
    check.equal(name + ": tets outside of their layer", outside, 0)
    check.equal(name + ": nodes that are not in the middle of their edge", misplaced, 0)
    check.equal(name + ": wrong activation times", times_wrong, 0)
    for layer, volume in enumerate(layer_volumes):
        check.close(f"{name}: volume of layer {layer}", volume, expected["layer_volumes"][layer], 1e-12)
    for region, volume in enumerate(region_volumes):
        check.close(f"{name}: volume of region {region}", volume, expected["region_volumes"][region], 1e-12)


compare_grid("sample.vtu", False)
if os.path.exists(check.path("sample_compressed.vtu")):  # only where the build has zlib
    compare_grid("sample_compressed.vtu", False)
compare_grid("quadratic.vtu", True)

# The steps of the print: after layer k there are all tets up to it, and no other.
steps = xml.etree.ElementTree.parse(check.path("sample.pvd")).getroot().findall("./Collection/DataSet")
check.equal("PVD: steps", len(steps), layers - plate)
for k, step in enumerate(steps):
    grid = read(check.path(step.get("file")))
    volume = sum(tet_volume(*corners(grid, cell, 4)) for cell in range(grid.GetNumberOfCells()))
    check.equal(f"PVD: time of step {k}", float(step.get("timestep")), expected["time_per_layer"] * k)
    check.close(f"PVD: volume of step {k}", volume, sum(expected["layer_volumes"][: plate + k + 1]), 1e-12)


SINGLE = 1e-5  # this reader of VTK keeps coordinates in single precision


def compare_exodus(name, kind):
    reader = vtk.vtkExodusIIReader()
    reader.SetFileName(check.path(name))
    reader.UpdateInformation()
    sides = vtk.vtkExodusIIReader.SIDE_SET
    reader.SetAllArrayStatus(sides, 1)
    for i in range(reader.GetNumberOfObjects(sides)):
        reader.SetObjectStatus(sides, i, 1)
    reader.Update()
    volumes, counts, areas, triangles, kinds = {}, {}, {}, {}, set()
    blocks = reader.GetOutput().NewIterator()
    blocks.InitTraversal()
    while not blocks.IsDoneWithTraversal():
        grid = blocks.GetCurrentDataObject()
        block = blocks.GetCurrentMetaData().Get(vtk.vtkCompositeDataSet.NAME())
        cells = range(grid.GetNumberOfCells())
        if grid.GetCell(0).GetCellDimension() == 3:
            kinds |= {grid.GetCellType(cell) for cell in cells}
            counts[block] = len(cells)
            volumes[block] = sum(tet_volume(*corners(grid, cell, 4)) for cell in cells)
        else:
            triangles[block] = len(cells)
            areas[block] = sum(triangle_area(*corners(grid, cell, 3)) for cell in cells)
        blocks.GoToNextItem()
    check.equal(name + ": cell types", kinds, {kind})
    check.equal(name + ": tets of blocks", counts, expected["group_tets"])
    check.equal(name + ": faces of side sets", triangles, expected["surface_triangles"])
    for block, volume in sorted(volumes.items()):
        check.close(f"{name}: volume of {block}", volume, expected["group_volumes"].get(block, 0), SINGLE)
    for block, area in sorted(areas.items()):
        check.close(f"{name}: area of {block}", area, expected["surface_areas"].get(block, 0), SINGLE)


if expected["exodus"]:
    compare_exodus("sample.exo", vtk.VTK_TETRA)
    compare_exodus("quadratic.exo", vtk.VTK_QUADRATIC_TETRA)

for kind, reader in (("ply", vtk.vtkPLYReader()), ("stl", vtk.vtkSTLReader()), ("obj", vtk.vtkOBJReader())):
    reader.SetFileName(check.path("skin." + kind))
    reader.Update()
    check.equal(kind + " triangles", reader.GetOutput().GetNumberOfPolys(), expected["skin_triangles"])
    mass = vtk.vtkMassProperties()
    mass.SetInputConnection(reader.GetOutputPort())
    check.close(kind + " volume", mass.GetVolume(), sum(expected["layer_volumes"]), 1e-6)
check.finish()
