// SPDX-License-Identifier: MIT
#include <cstdio>

#include <slice2mesh/cli/read_cli.hpp>
#include <slice2mesh/cli/write_cli.hpp>
#include <slice2mesh/core/mesh.hpp>
#include <slice2mesh/io/write_mesh.hpp>
#include <slice2mesh/quality/quality.hpp>

#ifdef CGAL_VERSION_NR
#error "slice2mesh::core brings in CGAL"
#endif

int main() {
  // One tetrahedron, written to a file, and one slice, written and read back.
  slice2mesh::Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.tets = {{0, 1, 2, 3}};
  mesh.tet_slab = {0};
  mesh.tet_region = {0};
  mesh.slabs.resize(1);
  mesh.slabs[0].z_high = 1;
  mesh.regions.resize(1);
  mesh.regions[0].name = "part_0";
  slice2mesh::write_mesh("one_tet.vtu", mesh);

  slice2mesh::SliceStack stack;
  stack.layers.resize(1);
  stack.layers[0].z = 1;
  slice2mesh::Polyline line;
  line.points = {{0, 0}, {1, 0}, {0, 1}};
  stack.layers[0].polylines = {line};
  slice2mesh::write_cli("triangle.cli", stack);
  if (slice2mesh::read_cli("triangle.cli").layers.size() != 1) {
    std::fputs("the slice was not read back\n", stderr);
    return 1;
  }
  return 0;
}
