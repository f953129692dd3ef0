// SPDX-License-Identifier: MIT
#include <slice2mesh/slice2mesh.hpp>

#include <cstdio>

#ifdef CGAL_VERSION_NR
#error "CGAL is compiled in more than one translation unit"
#endif
#if __cplusplus < 202002L
#error "not C++20"
#endif

// With C++20 the concept of a tetrahedralizer is one of the language.
static_assert(slice2mesh::Tetrahedralizer<slice2mesh::SlabFiller>);
static_assert(!slice2mesh::Tetrahedralizer<int>);

int main() {
  slice2mesh::Polyline square;
  square.points = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
  slice2mesh::SliceStack stack;
  stack.layers.resize(2);
  for (int k = 0; k < 2; ++k) {
    stack.layers[static_cast<std::size_t>(k)].z = k + 1;
    stack.layers[static_cast<std::size_t>(k)].polylines = {square};
  }
  const slice2mesh::Result result = slice2mesh::slice_to_mesh(stack);
  if (!result.report.certificate.passed() || result.mesh.tets.empty() || result.mesh.slabs.size() != 2) {
    std::fputs("no certified mesh\n", stderr);
    return 1;
  }
  std::printf("%zu tets\n", result.mesh.tets.size());
  return 0;
}
