# SPDX-License-Identifier: MIT
"""VTK reads sample.vtu, and the skin as PLY and STL, and finds the expected cells, labels and volumes."""
import os

from expected import Check, skip, tet_volume

try:
    import vtk
except ImportError:
    skip("the Python module vtk is not installed")

check = Check()
expected = check.expected


def compare_grid(name):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(check.path(name))
    reader.Update()
    grid = reader.GetOutput()
    check.equal(name + ": points", grid.GetNumberOfPoints(), expected["vertices"])
    check.equal(name + ": cells", grid.GetNumberOfCells(), expected["tets"])
    data = grid.GetCellData()
    names = {data.GetArrayName(i) for i in range(data.GetNumberOfArrays())}
    check.equal(name + ": cell arrays", sorted(names), sorted(["layer", "part", "region", "material", "slice", "bundle", "activation_time"]))
    field = grid.GetFieldData()
    check.equal(name + ": slabs", field.GetArray("slab_z_low").GetNumberOfTuples(), len(expected["layer_volumes"]))
    layer_volumes = [0.0] * len(expected["layer_volumes"])
    region_volumes = [0.0] * len(expected["region_volumes"])
    times_wrong = 0
    inverted = 0
    for cell in range(grid.GetNumberOfCells()):
        volume = tet_volume(*(grid.GetPoint(grid.GetCell(cell).GetPointId(i)) for i in range(4)))
        inverted += volume <= 0
        layer = int(data.GetArray("layer").GetValue(cell))
        layer_volumes[layer] += volume
        region_volumes[int(data.GetArray("region").GetValue(cell))] += volume
        times_wrong += data.GetArray("activation_time").GetValue(cell) != expected["time_per_layer"] * layer
    check.equal(name + ": cell type", {grid.GetCellType(i) for i in range(grid.GetNumberOfCells())}, {vtk.VTK_TETRA})
    check.equal(name + ": inverted tets", inverted, 0)
    check.equal(name + ": wrong activation times", times_wrong, 0)
    for layer, volume in enumerate(layer_volumes):
        check.close(f"{name}: volume of layer {layer}", volume, expected["layer_volumes"][layer], 1e-12)
    for region, volume in enumerate(region_volumes):
        check.close(f"{name}: volume of region {region}", volume, expected["region_volumes"][region], 1e-12)


compare_grid("sample.vtu")
if os.path.exists(check.path("sample_compressed.vtu")):  # only where the build has zlib
    compare_grid("sample_compressed.vtu")

for kind, reader in (("ply", vtk.vtkPLYReader()), ("stl", vtk.vtkSTLReader())):
    reader.SetFileName(check.path("skin." + kind))
    reader.Update()
    check.equal(kind + " triangles", reader.GetOutput().GetNumberOfPolys(), expected["skin_triangles"])
    mass = vtk.vtkMassProperties()
    mass.SetInputConnection(reader.GetOutputPort())
    check.close(kind + " volume", mass.GetVolume(), sum(expected["layer_volumes"]), 1e-6)
check.finish()
