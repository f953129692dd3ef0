// SPDX-License-Identifier: MIT
// Supports with two radii: the lines of one part id become thin walls, those of another one thick ones; then each line
// is asked for its own width, so that walls are thinner where they touch the part.
#include <slice2mesh/slice2mesh.hpp>

#include <iostream>
#include <string>
#include <vector>

namespace {

constexpr int kPart = 1, kFine = 2, kCoarse = 3;  // part ids
constexpr int kTop = 4;                           // the layer of the overhang; supports stand in those below

slice2mesh::Polyline line(int part, slice2mesh::Direction direction, std::vector<slice2mesh::Point2> points) {
  slice2mesh::Polyline polyline;
  polyline.part = part;
  polyline.direction = direction;
  polyline.points = std::move(points);
  return polyline;
}

// A table of 12 x 6 mm on one leg, in layers of 1 mm, with support lines of 4 mm on both sides of the leg.
slice2mesh::SliceStack table() {
  using slice2mesh::Direction;
  slice2mesh::SliceStack stack;
  stack.labels = {{kPart, "table"}, {kFine, "fine"}, {kCoarse, "coarse"}};
  stack.layers.emplace_back();  // z = 0, empty
  for (int k = 1; k <= kTop; ++k) {
    slice2mesh::Layer layer;
    layer.z = k;  // the upper surface
    const double half = k == kTop ? 6 : 2;
    layer.polylines.push_back(line(kPart, Direction::Outer, {{-half, 0}, {half, 0}, {half, 6}, {-half, 6}}));
    if (k < kTop) {
      for (const double x : {-5.0, -4.0, -3.0})
        layer.polylines.push_back(line(kFine, Direction::Open, {{x, 1}, {x, 5}}));
      for (const double x : {3.5, 5.0}) layer.polylines.push_back(line(kCoarse, Direction::Open, {{x, 1}, {x, 5}}));
    }
    stack.layers.push_back(layer);
  }
  return stack;
}

void print(const char* title, const slice2mesh::Result& result) {
  std::cout << title << ':';
  for (std::size_t r = 0; r < result.mesh.regions.size(); ++r)
    std::cout << ' ' << result.mesh.regions[r].name << ' ' << result.report.quality.region_volume[r] << " mm^3;";
  std::cout << ' ' << (result.report.certificate.passed() ? "certified" : "NOT certified") << '\n';
}

}  // namespace

int main() try {
  using slice2mesh::Length;
  const slice2mesh::SliceStack slices = table();
  slice2mesh::Options options;
  options.supports.cap = slice2mesh::LineCap::Flat;         // walls are as long as their lines
  options.supports.radius = Length::mm(0.1);                // half the width of all lines,
  options.supports.part_radius[kCoarse] = Length::mm(0.3);  // but for those of this part id
  print("by part", slice2mesh::slice_to_mesh(slices, options));

  // Or each line for itself: by its part id, its layer, its points or its process parameters.
  options.supports.line_radius = [](const slice2mesh::Polyline& support, int layer) {
    if (layer == kTop - 1) return Length::mm(0.1);  // easy to break off
    return Length::mm(support.part == kCoarse ? 0.4 : 0.3);
  };
  print("by line", slice2mesh::slice_to_mesh(slices, options));
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
