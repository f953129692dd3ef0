// SPDX-License-Identifier: MIT
// expect: slice2mesh: a Tetrahedralizer is an object type without const (not a reference, not void)
#include "slice2mesh/tet/tetrahedralizer.hpp"

using namespace slice2mesh;

struct Mesher {
  Mesh operator()(const Plc&) const { return {}; }
};

void check() {
  require_tetrahedralizer<const Mesher&>();
}
