// SPDX-License-Identifier: MIT
#include <slice2mesh/slice2mesh.hpp>

#include <iostream>

int main(int argc, char* argv[]) try {
  if (argc != 3) throw std::runtime_error("usage: one_call part.cli part.vtu");
  slice2mesh::Options options;                            // every field has a default
  options.supports.radius = slice2mesh::Length::mm(0.1);  // half the width of the support lines
  options.size.size = slice2mesh::Length::layers(2);      // twice the layer thickness
  const auto result = slice2mesh::slice_to_mesh(slice2mesh::read_cli(argv[1]), options);
  std::cout << result.mesh.tets.size() << " tets in " << result.mesh.slabs.size() << " slabs, "
            << (result.report.certificate.passed() ? "certified" : "NOT certified") << '\n';
  slice2mesh::write_mesh(argv[2], result.mesh);  // the format follows from the extension
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
