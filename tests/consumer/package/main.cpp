// SPDX-License-Identifier: MIT
#include <slice2mesh/slice2mesh.hpp>

#include <cstdio>

slice2mesh::SliceStack two_layers();  // other.cpp

int main() {
  const slice2mesh::Result result = slice2mesh::slice_to_mesh(two_layers());
  std::printf("%zu tets in %zu slabs with slice2mesh %s\n", result.mesh.tets.size(), result.mesh.slabs.size(),
              SLICE2MESH_VERSION);
  return result.mesh.slabs.size() == 2 && result.report.certificate.passed() ? 0 : 1;
}
