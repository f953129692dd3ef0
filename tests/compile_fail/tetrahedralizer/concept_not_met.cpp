// SPDX-License-Identifier: MIT
// standard: c++20
// expect: constraints not satisfied
#include "slice2mesh/tet/tetrahedralizer.hpp"

using namespace slice2mesh;

#if !SLICE2MESH_HAS_CONCEPTS
#error "constraints not satisfied: there are no concepts here, so nothing can be checked"
#else
template <Tetrahedralizer Model>
void run(const Model&) {}

void check() {
  run(42);
}
#endif
