// SPDX-License-Identifier: MIT
// A lambda is a tetrahedralizer: this one fills the slabs and then counts what it made.
#include <slice2mesh/slice2mesh.hpp>

#include <iostream>

int main(int argc, char* argv[]) try {
  if (argc != 2) throw std::runtime_error("usage: mesher_lambda part.cli");
  slice2mesh::Options options;
  options.slabs.lump = 6;
  const auto mesher = [](const slice2mesh::Plc& plc) {
    slice2mesh::Mesh mesh = slice2mesh::SlabFiller{}(plc);
    std::cout << mesh.vertices.size() << " vertices\n";
    return mesh;
  };
  const auto result = slice2mesh::slice_to_mesh(slice2mesh::read_cli(argv[1]), options, mesher);
  std::cout << result.report.tetrahedralizer << ": " << result.mesh.tets.size() << " tets, "
            << result.report.layers->crossing << " cross layers, axioms "
            << (result.report.certificate.passed() ? "hold" : "do NOT hold") << '\n';
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
