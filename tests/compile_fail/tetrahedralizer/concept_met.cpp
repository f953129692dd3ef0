// SPDX-License-Identifier: MIT
// standard: c++20
#include "slice2mesh/tet/tetrahedralizer.hpp"

using namespace slice2mesh;

#if SLICE2MESH_HAS_CONCEPTS
template <Tetrahedralizer Model>
void run(const Model&) {}

void check() {
  run([](const Plc&) { return Mesh{}; });
}
#endif
