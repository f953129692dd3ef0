// SPDX-License-Identifier: MIT
// expect: slice2mesh: a Tetrahedralizer must be copyable
#include "slice2mesh/tet/tetrahedralizer.hpp"

using namespace slice2mesh;

#include <memory>

struct Mesher {
  std::unique_ptr<int> state;
  Mesh operator()(const Plc&) const { return {}; }
};

void check() {
  require_tetrahedralizer<Mesher>();
}
