// SPDX-License-Identifier: MIT
// expect: slice2mesh: the data member progress of a Tetrahedralizer must be a slice2mesh::Progress
#include "slice2mesh/tet/tetrahedralizer.hpp"

using namespace slice2mesh;

struct Mesher {
  Mesh operator()(const Plc&) const { return {}; }
  double progress = 0;
};

void check() {
  require_tetrahedralizer<Mesher>();
}
