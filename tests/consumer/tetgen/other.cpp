// SPDX-License-Identifier: MIT
// A second translation unit: nothing in the headers may be defined twice.
#include <slice2mesh/tet/axioms.hpp>
#include <slice2mesh/tet/external_model.hpp>
#include <slice2mesh/tet/tetgen_model.hpp>

slice2mesh::AnyTetrahedralizer make_mesher() {
  slice2mesh::TetGenMesher mesher;
  mesher.radius_edge = 1.5;
  mesher.max_volume = 0.05;
  return mesher;
}
