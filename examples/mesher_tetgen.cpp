// SPDX-License-Identifier: MIT
// The library TetGen (AGPL), with quality, in a child process. Links to slice2mesh::tetgen.
#include <slice2mesh/slice2mesh.hpp>
#include <slice2mesh/tet/tetgen_model.hpp>

#include <iostream>

int main(int argc, char* argv[]) try {
  if (argc != 2) throw std::runtime_error("usage: mesher_tetgen part.cli");
  slice2mesh::Options options;
  options.slabs.lump = 6;
  slice2mesh::TetGenMesher mesher;
  mesher.radius_edge = 1.6;
  mesher.limits.time = 60;  // seconds
  const auto result = slice2mesh::slice_to_mesh(slice2mesh::read_cli(argv[1]), options, mesher);
  std::cout << result.report.tetrahedralizer << ": " << result.mesh.tets.size() << " tets, "
            << result.report.layers->crossing << " cross layers, axioms "
            << (result.report.certificate.passed() ? "hold" : "do NOT hold") << '\n';
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
