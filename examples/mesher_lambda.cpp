// SPDX-License-Identifier: MIT
// A lambda is a tetrahedralizer: this one fills the slabs and then counts what it made. Another one says what it
// promises.
#include <slice2mesh/slice2mesh.hpp>

#include <iostream>

namespace {

// Here would be your own mesher.
slice2mesh::Mesh my_mesh_of(const slice2mesh::Plc& plc) {
  return slice2mesh::SlabFiller{}(plc);
}

// A promise that is kept shows in the axioms of the result.
bool keeps_its_promise(const slice2mesh::SliceStack& slices, const slice2mesh::Options& options) {
  const auto mesher = slice2mesh::with_traits([](const slice2mesh::Plc& plc) { return my_mesh_of(plc); },
                                              {"mine", slice2mesh::FacetKeeping::Subdivided, true, false});
  const auto result = slice2mesh::slice_to_mesh(slices, options, mesher);
  return result.report.tetrahedralizer == "mine" && result.report.certificate.passed();
}

}  // namespace

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
  return keeps_its_promise(slice2mesh::read_cli(argv[1]), options) ? 0 : 1;
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
