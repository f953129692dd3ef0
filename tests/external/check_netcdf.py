# SPDX-License-Identifier: MIT
"""The netCDF library reads Exodus II files: blocks with their names and volumes, side sets with their areas."""
from expected import Check, skip, tet_volume, triangle_area

try:
    import netCDF4
except ImportError:
    skip("the Python module netCDF4 is not installed")

check = Check()
expected = check.expected
if not expected["exodus"]:
    skip("this build writes no Exodus files")

SIDES = ((0, 1, 3), (1, 2, 3), (0, 3, 2), (0, 2, 1))  # corners of the sides 1 to 4


def names_of(file, variable):
    return ["".join(c.decode() for c in row if c).rstrip("\0") for row in file.variables[variable][:].filled(b"")]


for name, per_tet in (("sample.exo", 4), ("quadratic.exo", 10)):
    file = netCDF4.Dataset(check.path(name))
    points = list(zip(*(file.variables["coord" + axis][:].tolist() for axis in "xyz")))
    check.equal(name + ": nodes", len(points), expected["vertices" if per_tet == 4 else "quadratic_nodes"])
    tets, volumes, counts, wrong_times = [], {}, {}, 0
    for number, block in enumerate(names_of(file, "eb_names"), 1):
        connect = (file.variables[f"connect{number}"][:] - 1).tolist()
        tets += connect
        counts[block] = len(connect)
        volumes[block] = sum(tet_volume(*(points[v] for v in tet[:4])) for tet in connect)
        layer = max(0, int(block[6:10]) - 1 - expected["plate_slabs"])
        times = file.variables[f"vals_elem_var1eb{number}"][0].tolist()
        wrong_times += sum(t != expected["time_per_layer"] * layer for t in times)
    check.equal(name + ": tets", len(tets), expected["tets"])
    check.equal(name + ": nodes per tet", {len(tet) for tet in tets}, {per_tet})
    check.equal(name + ": numbers of tets", sorted(file.variables["elem_num_map"][:].tolist()), list(range(1, len(tets) + 1)))
    check.equal(name + ": tets of blocks", counts, expected["group_tets"])
    check.equal(name + ": wrong activation times", wrong_times, 0)
    for block in sorted(volumes):
        check.close(f"{name}: volume of {block}", volumes[block], expected["group_volumes"].get(block, 0), 1e-12)
    if per_tet == 10:
        # TETRA10: nodes between corners 1-2, 2-3, 1-3, 1-4, 2-4, 3-4.
        edges = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
        wrong = sum(
            tuple((p + q) / 2 for p, q in zip(points[tet[a]], points[tet[b]])) != points[tet[4 + i]]
            for tet in tets
            for i, (a, b) in enumerate(edges)
        )
        check.equal(name + ": nodes that are not in the middle of their edge", wrong, 0)
    areas, triangles = {}, {}
    for number, side_set in enumerate(names_of(file, "ss_names"), 1):
        elements = file.variables[f"elem_ss{number}"][:].tolist()
        sides = file.variables[f"side_ss{number}"][:].tolist()
        triangles[side_set] = len(elements)
        areas[side_set] = sum(
            triangle_area(*(points[tets[e - 1][c]] for c in SIDES[s - 1])) for e, s in zip(elements, sides)
        )
    check.equal(name + ": faces of side sets", triangles, expected["surface_triangles"])
    for side_set in sorted(areas):
        check.close(f"{name}: area of {side_set}", areas[side_set], expected["surface_areas"].get(side_set, 0), 1e-12)
    file.close()
check.finish()
