// SPDX-License-Identifier: MIT
// The default tetrahedralizer, the slab filler, by its name.
#include <slice2mesh/slice2mesh.hpp>

#include <iostream>

int main(int argc, char* argv[]) try {
  if (argc != 2) throw std::runtime_error("usage: mesher_slab part.cli");
  slice2mesh::Options options;
  options.slabs.lump = 6;
  const slice2mesh::SlabFiller mesher;
  const auto result = slice2mesh::slice_to_mesh(slice2mesh::read_cli(argv[1]), options, mesher);
  std::cout << result.report.tetrahedralizer << ": " << result.mesh.tets.size() << " tets, "
            << (result.report.certificate.passed() ? "certified" : "NOT certified") << '\n';
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
