// SPDX-License-Identifier: MIT
#include <slice2mesh/slice2mesh.hpp>

#include <cstdio>

slice2mesh::SliceStack two_layers();  // other.cpp

int main() {
  slice2mesh::Diagnostics diagnostics;
  const slice2mesh::SlabPlan plan = slice2mesh::make_slabs(two_layers(), {}, diagnostics);
  std::printf("%zu slabs with slice2mesh %s\n", plan.slabs.size(), SLICE2MESH_VERSION);
  return plan.slabs.size() == 2 ? 0 : 1;
}
