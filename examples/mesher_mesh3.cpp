// SPDX-License-Identifier: MIT
// CGAL::Mesh_3, in a child process.
#include <slice2mesh/slice2mesh.hpp>
#include <slice2mesh/tet/mesh3_model.hpp>

#include <iostream>

int main(int argc, char* argv[]) try {
  if (argc != 2) throw std::runtime_error("usage: mesher_mesh3 part.cli");
  slice2mesh::Options options;
  options.slabs.lump = 6;
  slice2mesh::Mesh3Mesher mesher;
  mesher.options.size = slice2mesh::Length::mm(6);
  mesher.options.perturb = false;  // faster
  mesher.limits.time = 300;        // seconds
  const auto result = slice2mesh::slice_to_mesh(slice2mesh::read_cli(argv[1]), options, mesher);
  std::cout << result.report.tetrahedralizer << ": " << result.mesh.tets.size() << " tets, "
            << result.report.layers->crossing << " cross layers, axioms "
            << (result.report.certificate.passed() ? "hold" : "do NOT hold") << '\n';
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
