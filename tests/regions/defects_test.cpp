// SPDX-License-Identifier: MIT
// What the union repairs is listed.
#include "slice2mesh/regions/regions.hpp"
#include "test_support.hpp"

using namespace slice2mesh;

namespace {

LayerRegions regions_of(const std::vector<std::vector<Point2>>& loops, Diagnostics& diagnostics) {
  SliceStack stack;
  for (int i = 0; i < 2; ++i) {
    Layer layer;
    layer.z = i;
    for (const auto& points : loops) {
      Polyline line;
      line.points = points;
      layer.polylines.push_back(line);
    }
    stack.layers.push_back(layer);
  }
  return build_regions(stack, make_slabs(stack, {}, diagnostics), {}, diagnostics);
}

double area(const LayerRegions& regions) {
  return static_cast<double>(detail::doubled_area(regions.outlines[0], kNone)) / 2 * regions.grid.pitch *
         regions.grid.pitch;
}

const std::vector<Point2> kSquare{{0, 0}, {2, 0}, {2, 2}, {0, 2}};

}  // namespace

TEST_CASE("a sound contour is not reported") {
  Diagnostics diagnostics;
  CHECK(area(regions_of({kSquare}, diagnostics)) == Approx(4));
  CHECK(diagnostics.count("contours_cross") == 0);
  CHECK(diagnostics.count("contours_coincide") == 0);
}

TEST_CASE("a contour that crosses itself is united and reported") {
  Diagnostics diagnostics;
  const LayerRegions regions = regions_of({{{0, 0}, {2, 2}, {2, 0}, {0, 2}}}, diagnostics);
  CHECK(area(regions) == Approx(2));
  CHECK(diagnostics.count("contours_cross") == 2);  // one crossing on each of two slices
}

TEST_CASE("overlapping contours are united and reported") {
  Diagnostics diagnostics;
  const LayerRegions regions = regions_of({kSquare, {{1, 1}, {3, 1}, {3, 3}, {1, 3}}}, diagnostics);
  CHECK(area(regions) == Approx(7));
  CHECK(diagnostics.count("contours_cross") == 4);
}

TEST_CASE("a contour that stands twice is united and reported") {
  Diagnostics diagnostics;
  const LayerRegions regions = regions_of({kSquare, kSquare}, diagnostics);
  CHECK(area(regions) == Approx(4));
  CHECK(diagnostics.count("contours_coincide") == 8);  // four edges on each of two slices
}
