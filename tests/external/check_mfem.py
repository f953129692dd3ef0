# SPDX-License-Identifier: MIT
"""MFEM (its Python module, PyMFEM) reads files of v1.0 and v1.3: volumes of attributes, areas of boundary attributes."""
from expected import Check, skip, triangle_area

try:
    import mfem.ser as mfem
except ImportError:
    skip("the Python module mfem is not installed")

check = Check()
expected = check.expected
layers = len(expected["layer_volumes"])
SURFACES = ("bottom", "top", "wall", "upskin", "downskin", "support_interface", "plate_interface")

for name in ("sample.mfem", "sample_names.mfem"):
    mesh = mfem.Mesh(check.path(name), 1, 0, False)  # with edges, not refined, elements turned as in the file
    check.equal(name + ": dimension", mesh.Dimension(), 3)
    check.equal(name + ": vertices", mesh.GetNV(), expected["vertices"])
    check.equal(name + ": tets", mesh.GetNE(), expected["tets"])
    check.equal(name + ": tets that are turned", mesh.CheckElementOrientation(False), 0)
    # attribute = region * layers + layer + 1
    by_layer = [0.0] * layers
    by_region = [0.0] * len(expected["region_volumes"])
    for element in range(mesh.GetNE()):
        attribute = mesh.GetAttribute(element) - 1
        volume = mesh.GetElementVolume(element)
        by_layer[attribute % layers] += volume
        by_region[attribute // layers] += volume
    for layer, volume in enumerate(by_layer):
        check.close(f"{name}: volume of layer {layer}", volume, expected["layer_volumes"][layer], 1e-12)
    for region, volume in enumerate(by_region):
        check.close(f"{name}: volume of region {region}", volume, expected["region_volumes"][region], 1e-12)
    areas = {}
    for element in range(mesh.GetNBE()):
        corners = [mesh.GetVertexArray(v) for v in mesh.GetBdrElementVertices(element)]
        surface = SURFACES[mesh.GetBdrAttribute(element) - 1]
        areas[surface] = areas.get(surface, 0) + triangle_area(*corners)
    check.equal(name + ": surfaces", sorted(areas), sorted(expected["surface_areas"]))
    for surface, area in sorted(areas.items()):
        check.close(f"{name}: area of {surface}", area, expected["surface_areas"].get(surface, 0), 1e-12)
check.finish()
