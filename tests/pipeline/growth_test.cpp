// SPDX-License-Identifier: MIT
// Exposed area and volume after every layer of meshes of the whole pipeline, against their definition on the contours.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "slice2mesh/slice2mesh.hpp"
#include "test_support.hpp"

using namespace slice2mesh;

namespace {

using Polygon = std::vector<Point2>;

Polyline contour(const Polygon& points, Direction direction) {
  Polyline line;
  line.direction = direction;
  line.points = points;
  if (direction == Direction::Inner) line.points.assign(points.rbegin(), points.rend());
  return line;
}

/// A slice: a polygon around a hole, both convex.
struct Slice {
  Polygon outer;
  Polygon hole;
  double area = 0;
  double perimeter = 0;
};

double polygon_area(const Polygon& p) {
  double sum = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Point2& a = p[i];
    const Point2& b = p[(i + 1) % p.size()];
    sum += a.x * b.y - a.y * b.x;
  }
  return sum / 2;
}
double polygon_perimeter(const Polygon& p) {
  double sum = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Point2& a = p[i];
    const Point2& b = p[(i + 1) % p.size()];
    sum += std::hypot(b.x - a.x, b.y - a.y);
  }
  return sum;
}

/// A quadrilateral with corners at distance `size` on slanted axes; coordinates are multiples of 1/64 mm.
Polygon quadrilateral(double size) {
  return {{size, size / 4}, {-size / 4, size}, {-size, -size / 4}, {size / 4, -size}};
}

}  // namespace

TEST_CASE("exposed area and volume of a mesh equal their definition on the slices after every layer, to 1e-12") {
  // Slices inside of each other, so that |S_j xor S_(j+1)| is a difference of areas: the part widens and narrows, its
  // hole does the opposite. Thickness varies.
  const std::vector<double> outer = {8, 10, 12, 12, 9, 6};
  const std::vector<double> hole = {3, 2, 1.5, 1.5, 2.5, 3};
  const std::vector<double> thickness = {0.5, 0.75, 0.5, 0.25, 0.5, 1};
  std::vector<Slice> slices;
  SliceStack stack;
  stack.layers.emplace_back();
  double z = 0;
  for (std::size_t s = 0; s < outer.size(); ++s) {
    Slice slice;
    slice.outer = quadrilateral(outer[s]);
    slice.hole = quadrilateral(hole[s]);
    slice.area = polygon_area(slice.outer) - polygon_area(slice.hole);
    slice.perimeter = polygon_perimeter(slice.outer) + polygon_perimeter(slice.hole);
    slices.push_back(slice);
    Layer layer;
    layer.z = z += thickness[s];
    layer.polylines = {contour(slice.outer, Direction::Outer), contour(slice.hole, Direction::Inner)};
    stack.layers.push_back(layer);
  }
  // Slanted edges are split at points of the contour grid, 2^-36 of the extent: they bend by up to half of that.
  constexpr double kRounding = 3e-11;
  for (const double plate : {0.0, 2.0}) {
    Options options;
    options.size.size = Length::mm(1.5);
    options.slabs.z_convention = ZConvention::Top;
    options.plate.thickness = Length::mm(plate);
    options.plate.margin = Length::mm(4);
    options.plate.slabs = 2;
    const Result result = slice_to_mesh(stack, options);
    REQUIRE(result.report.certificate.passed());
    REQUIRE(result.mesh.slabs.size() == outer.size() + (plate > 0 ? 2 : 0));
    const BoundarySets sets = boundary_sets(result.mesh);
    std::vector<Slice> bodies = slices;
    std::vector<double> heights = thickness;
    if (plate > 0) {
      Slice body;
      const double side = 24 + 8;
      body.area = side * side;
      body.perimeter = 4 * side;
      bodies.insert(bodies.begin(), 2, body);
      heights.insert(heights.begin(), 2, plate / 2);
    }
    double lateral = 0;
    double volume = 0;
    double steps = 0;
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      lateral += bodies[k].perimeter * heights[k];
      volume += bodies[k].area * heights[k];
      if (k > 0) {
        // Nested either way: the outer contour and the hole each contribute a difference.
        const bool on_plate = bodies[k - 1].outer.empty();
        steps += on_plate ? bodies[k - 1].area - bodies[k].area
                          : std::fabs(polygon_area(bodies[k].outer) - polygon_area(bodies[k - 1].outer)) +
                                std::fabs(polygon_area(bodies[k].hole) - polygon_area(bodies[k - 1].hole));
      }
      const double exposed = lateral + bodies[k].area + steps + bodies[0].area;
      INFO("after slab " << k << " of " << bodies.size() << ", plate of " << plate << " mm");
      CHECK(std::fabs(sets.exposed_area[k] / exposed - 1) < kRounding);
      CHECK(std::fabs(sets.volume[k] / volume - 1) < kRounding);
      CHECK(std::fabs(area_of(result.mesh, exposed_faces(sets, static_cast<std::int32_t>(k))) / exposed - 1) <
            kRounding);
    }
  }
}
