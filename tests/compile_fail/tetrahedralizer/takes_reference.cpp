// SPDX-License-Identifier: MIT
// expect: slice2mesh: a Tetrahedralizer must be callable with a complex: Mesh operator()(const Plc&) const
#include "slice2mesh/tet/tetrahedralizer.hpp"

using namespace slice2mesh;

AnyTetrahedralizer check() {
  return [](Plc& plc) {
    plc.facets.clear();
    return Mesh{};
  };
}
