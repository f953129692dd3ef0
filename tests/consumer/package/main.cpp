// SPDX-License-Identifier: MIT
#include <slice2mesh/slice2mesh.hpp>

#include <cstdio>

slice2mesh::SliceStack two_layers();  // other.cpp

int main() {
  const slice2mesh::Result result = slice2mesh::slice_to_mesh(two_layers());
  if (!result.report.certificate.passed() || result.mesh.tets.empty() || result.mesh.slabs.size() != 2) {
    std::fputs("no certified mesh\n", stderr);
    return 1;
  }
  std::printf("%zu tets with slice2mesh %s\n", result.mesh.tets.size(), SLICE2MESH_VERSION);
  return 0;
}
