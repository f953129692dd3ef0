// SPDX-License-Identifier: MIT
// expect: slice2mesh: the call operator of a Tetrahedralizer must return a Mesh
#include "slice2mesh/tet/tetrahedralizer.hpp"

using namespace slice2mesh;

AnyTetrahedralizer check() {
  return [](const Plc&) { return 1; };
}
