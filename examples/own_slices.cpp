// SPDX-License-Identifier: MIT
// Slices from one's own data, and a mesh in memory: no file is read or written.
#include <slice2mesh/slice2mesh.hpp>

#include <cmath>
#include <iostream>

namespace {

// A twisted tube with three lobes, 6 mm high in layers of 1 mm. Coordinates are mm (SliceStack::unit is 1).
slice2mesh::SliceStack twisted_tube() {
  constexpr int kLayers = 6, kCorners = 48;
  constexpr double kThickness = 1, kPi = 3.14159265358979323846;
  slice2mesh::SliceStack stack;
  stack.layers.emplace_back();  // z = 0, empty: the slab of a slice reaches down to the z of the one below
  for (int k = 1; k <= kLayers; ++k) {
    slice2mesh::Layer layer;
    layer.z = k * kThickness;  // the upper surface of the layer
    slice2mesh::Polyline outer, hole;
    outer.part = hole.part = 1;
    hole.direction = slice2mesh::Direction::Inner;
    for (int i = 0; i < kCorners; ++i) {
      const double angle = 2 * kPi * i / kCorners;  // counter-clockwise; holes run clockwise
      const double radius = 5 + std::cos(3 * (angle - 0.05 * k));
      outer.points.push_back({radius * std::cos(angle), radius * std::sin(angle)});
      hole.points.push_back({2 * std::cos(-angle), 2 * std::sin(-angle)});
    }
    layer.polylines = {outer, hole};
    stack.layers.push_back(layer);
  }
  stack.labels[1] = "tube";  // names the region, and the sets in files
  return stack;
}

}  // namespace

int main() try {
  slice2mesh::Options options;
  options.size.size = slice2mesh::Length::mm(2);
  const slice2mesh::Result result = slice2mesh::slice_to_mesh(twisted_tube(), options);
  const slice2mesh::Mesh& mesh = result.mesh;

  // #V by 3 doubles and #T by 4 indices, ready for a solver; here the volume of every layer.
  std::vector<double> volume(mesh.slabs.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    std::array<std::array<double, 3>, 3> edges{};
    const std::array<double, 3>& base = mesh.vertices[static_cast<std::size_t>(mesh.tets[t][0])];
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t d = 0; d < 3; ++d)
        edges[i][d] = mesh.vertices[static_cast<std::size_t>(mesh.tets[t][i + 1])][d] - base[d];
    const auto& [a, b, c] = edges;
    volume[static_cast<std::size_t>(mesh.tet_slab[t])] +=
        (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])) /
        6;
  }
  for (std::size_t s = 0; s < volume.size(); ++s)
    std::cout << mesh.slabs[s].z_low << " to " << mesh.slabs[s].z_high << " mm: " << volume[s] << " mm^3\n";
  for (const slice2mesh::Diagnostic& finding : result.diagnostics.entries())
    std::cout << to_string(finding.severity) << ": " << finding.message << '\n';
  std::cout << mesh.tets.size() << " tets in " << mesh.slabs.size() << " slabs of " << mesh.regions[0].name << ", "
            << (result.report.certificate.passed() ? "certified" : "NOT certified") << '\n';
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
