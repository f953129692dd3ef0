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

/// A slice: an area around a hole.
struct Slice {
  double outer = 0;  // mm^2
  double hole = 0;   // mm^2
  double perimeter = 0;
  double area() const { return outer - hole; }
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

/// A square with corners at distance `size` on axes of this slope; coordinates are multiples of 1/64 mm.
Polygon square(double size, double slope) {
  return {{size, size * slope}, {-size * slope, size}, {-size, -size * slope}, {size * slope, -size}};
}

/// Area and perimeter of what the mesh is made from: the harmonized contours of every slab, split as the mesh has them.
std::vector<Slice> harmonized_slices(const SliceStack& stack, const Options& options) {
  Diagnostics diagnostics;
  const SlabPlan plan = make_slabs(stack, options.slabs, diagnostics);
  const LayerRegions regions = build_regions_on_plate(stack, plan, options.supports, options.plate, diagnostics);
  HarmonizeOptions harmonize_options;
  harmonize_options.eps = options.eps.in_mm(plan.thickness);
  harmonize_options.contour_size = resolve_sizes(options.size, regions).contour_size;
  const Contours contours = harmonize(regions, harmonize_options, diagnostics);
  constexpr double kWidestHole = 3.5;  // mm, half a diagonal of the holes below
  std::vector<Slice> slices;
  for (const Outline& outline : contours.outlines) {
    Slice slice;
    for (const Outline::Edge& e : outline.edges) {
      REQUIRE(((e.left == kNone) != (e.right == kNone)));
      const GridPoint &a = outline.vertices[std::size_t(e.a)], &b = outline.vertices[std::size_t(e.b)];
      const double ax = contours.grid.x_mm(a), ay = contours.grid.y_mm(a);
      const double bx = contours.grid.x_mm(b), by = contours.grid.y_mm(b);
      const double doubled = (ax * by - ay * bx) * (e.left == kNone ? -1 : 1);
      if (std::hypot(ax, ay) > kWidestHole)
        slice.outer += doubled / 2;
      else
        slice.hole -= doubled / 2;
      slice.perimeter += std::hypot(bx - ax, by - ay);
    }
    slices.push_back(slice);
  }
  return slices;
}

}  // namespace

TEST_CASE("exposed area and volume of a mesh equal their definition on the slices after every layer, to 1e-12") {
  // Slices inside of each other, so that |S_j xor S_(j+1)| is a difference of areas: the part widens and narrows, its
  // hole does the opposite. Thickness varies.
  const std::vector<double> outer = {8, 10, 12, 12, 9, 6};
  const std::vector<double> hole = {3, 2, 1.5, 1.5, 2.5, 3};
  const std::vector<double> thickness = {0.5, 0.75, 0.5, 0.25, 0.5, 1};
  // On lines of slope 1 split points are exact. On others they are rounded to the contour grid, 2^-36 of the extent,
  // and bend the contour by up to half of that: there the slices are the harmonized ones.
  for (const double slope : {0.0, 0.25}) {
    std::vector<Slice> slices;
    SliceStack stack;
    stack.layers.emplace_back();
    double z = 0;
    for (std::size_t s = 0; s < outer.size(); ++s) {
      Layer layer;
      layer.z = z += thickness[s];
      const Polygon around = square(outer[s], slope), within = square(hole[s], slope);
      layer.polylines = {contour(around, Direction::Outer), contour(within, Direction::Inner)};
      stack.layers.push_back(layer);
      slices.push_back(
          {polygon_area(around), polygon_area(within), polygon_perimeter(around) + polygon_perimeter(within)});
    }
    for (const double plate : {0.0, 2.0}) {
      INFO("slope " << slope << ", plate of " << plate << " mm");
      Options options;
      options.size.size = Length::mm(1.5);
      options.slabs.z_convention = ZConvention::Top;
      options.plate.thickness = Length::mm(plate);
      options.plate.margin = Length::mm(4);
      options.plate.slabs = 2;
      options.improve.move_contours = slope == 0;  // moves along other lines are rounded too
      const Result result = slice_to_mesh(stack, options);
      REQUIRE(result.report.certificate.passed());
      std::vector<Slice> bodies = slices;
      std::vector<double> heights = thickness;
      if (plate > 0) {
        constexpr double side = 24 + 8;
        bodies.insert(bodies.begin(), 2, {side * side, 0, 4 * side});
        heights.insert(heights.begin(), 2, plate / 2);
      }
      REQUIRE(result.mesh.slabs.size() == bodies.size());
      const std::vector<Slice> harmonized = harmonized_slices(stack, options);
      REQUIRE(harmonized.size() == bodies.size());
      constexpr double kBend = 2e-10;  // relative, of areas and lengths of each slice here
      for (std::size_t k = 0; k < bodies.size(); ++k) {
        CHECK(std::fabs(harmonized[k].area() / bodies[k].area() - 1) < kBend);
        CHECK(std::fabs(harmonized[k].perimeter / bodies[k].perimeter - 1) < kBend);
      }
      if (slope != 0) bodies = harmonized;
      const BoundarySets sets = boundary_sets(result.mesh);
      double lateral = 0;
      double volume = 0;
      double steps = 0;
      for (std::size_t k = 0; k < bodies.size(); ++k) {
        lateral += bodies[k].perimeter * heights[k];
        volume += bodies[k].area() * heights[k];
        if (k > 0)
          steps += std::fabs(bodies[k].outer - bodies[k - 1].outer) + std::fabs(bodies[k].hole - bodies[k - 1].hole);
        const double exposed = lateral + bodies[k].area() + steps + bodies[0].area();
        INFO("after slab " << k << " of " << bodies.size());
        CHECK(std::fabs(sets.exposed_area[k] / exposed - 1) < 1e-12);
        CHECK(std::fabs(sets.volume[k] / volume - 1) < 1e-12);
        CHECK(std::fabs(area_of(result.mesh, exposed_faces(sets, static_cast<std::int32_t>(k))) / exposed - 1) < 1e-12);
      }
    }
  }
}
