// SPDX-License-Identifier: MIT
// Any program is a tetrahedralizer: here the one of TetGen.
#include <slice2mesh/slice2mesh.hpp>

#include <iostream>

int main(int argc, char* argv[]) try {
  if (argc != 2) throw std::runtime_error("usage: mesher_external part.cli");
  slice2mesh::Options options;
  options.slabs.lump = 6;
  slice2mesh::ExternalMesher mesher;
  mesher.command = "tetgen -pQ {in:poly}";  // leaves in.1.node and in.1.ele beside its input
  mesher.name = "tetgen program";
  mesher.limits.time = 60;  // seconds
  const auto result = slice2mesh::slice_to_mesh(slice2mesh::read_cli(argv[1]), options, mesher);
  std::cout << result.report.tetrahedralizer << ": " << result.mesh.tets.size() << " tets, "
            << result.report.layers->crossing << " cross layers, axioms "
            << (result.report.certificate.passed() ? "hold" : "do NOT hold") << '\n';
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
