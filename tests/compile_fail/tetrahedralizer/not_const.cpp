// SPDX-License-Identifier: MIT
// expect: slice2mesh: the call operator of a Tetrahedralizer must be const (a lambda must not be mutable)
#include "slice2mesh/tet/tetrahedralizer.hpp"

using namespace slice2mesh;

AnyTetrahedralizer check() {
  return [calls = 0](const Plc&) mutable {
    ++calls;
    return Mesh{};
  };
}
