// SPDX-License-Identifier: MIT
// expect: slice2mesh: traits() of a Tetrahedralizer must be const and return TetrahedralizerTraits
#include "slice2mesh/tet/tetrahedralizer.hpp"

using namespace slice2mesh;

struct Mesher {
  Mesh operator()(const Plc&) const { return {}; }
  TetrahedralizerTraits traits() { return {}; }
};

void check() {
  require_tetrahedralizer<Mesher>();
}
