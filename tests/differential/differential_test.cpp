// SPDX-License-Identifier: MIT
// Areas, volumes and complexes against other ways to get them: counting, sampling, and TetGen's own check.
// (The exact boolean operations of CGAL are compared with in tests/regions, its Delaunay tetrahedralization in
// tests/tet.)
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "slice2mesh/io/write_mesh.hpp"
#include "test_support.hpp"
#include "torture/generators.hpp"
#include "torture/pipeline_runner.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;
using torture::box;
using torture::stack_of;

namespace {

/// How often a loop winds around a point that is on none of its edges.
int winding(const Polyline& line, double x, double y) {
  int result = 0;
  const std::size_t n = line.points.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Point2 &a = line.points[i], &b = line.points[(i + 1) % n];
    if ((a.y <= y) == (b.y <= y)) continue;
    const double side = (b.x - a.x) * (y - a.y) - (x - a.x) * (b.y - a.y);
    if (a.y <= y && side > 0) ++result;
    if (a.y > y && side < 0) --result;
  }
  return result;
}

/// The definition of a region: outer loops around the point outnumber inner ones, in some part.
bool is_inside(const Layer& layer, double x, double y) {
  std::array<int, 8> balance{};
  for (const Polyline& line : layer.polylines)
    if (line.direction != Direction::Open && winding(line, x, y) != 0)
      balance.at(static_cast<std::size_t>(line.part)) += line.direction == Direction::Inner ? -1 : 1;
  for (const int b : balance)
    if (b > 0) return true;
  return false;
}

}  // namespace

TEST_CASE("unions of lattice boxes have the area that counting their squares gives, and their meshes that volume") {
  int with_holes = 0;
  for (std::uint32_t seed = 1; seed <= 25; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    std::vector<torture::Slice> slices(3);
    for (torture::Slice& slice : slices) {
      slice.push_back(box(0, 0, 1, 1));  // the same grid for all layers
      for (int n = dice.whole(2, 9); n > 0; --n) {
        const int x = dice.whole(0, 10), y = dice.whole(0, 10);
        const bool hole = dice.one_in(4);
        with_holes += hole ? 1 : 0;
        const int part = dice.whole(0, 1), height = dice.whole(1, 5), width = dice.whole(1, 5);
        slice.push_back(box(x, y, x + width, y + height, hole ? Direction::Inner : Direction::Outer, part));
      }
    }
    const SliceStack stack = stack_of(slices);
    const std::vector<double> areas = united_areas(stack);
    REQUIRE(areas.size() == 3);
    Options options;
    options.eps = Length::mm(0.01);  // below every difference of layers: contours stay
    options.size.size = Length::mm(2);
    const Outcome outcome = run_pipeline(stack, options);
    INFO(outcome.message);
    REQUIRE(outcome.certified());
    const std::vector<double> volumes = slab_volumes(outcome.mesh);
    REQUIRE(volumes.size() == 3);
    for (std::size_t s = 0; s < 3; ++s) {
      int count = 0;
      for (int i = 0; i < 16; ++i)
        for (int j = 0; j < 16; ++j) count += is_inside(stack.layers[s], i + 0.5, j + 0.5) ? 1 : 0;
      REQUIRE(count > 0);
      CHECK(areas[s] == Approx(count).epsilon(1e-12));
      CHECK(volumes[s] == Approx(count * torture::kHeight).epsilon(1e-6));
    }
  }
  CHECK(with_holes > 10);
}

TEST_CASE("unions of random loops have the area that a raster of points finds") {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    torture::Slice slice;
    double perimeter = 0;
    for (int k = dice.whole(1, 5); k > 0; --k) {
      std::vector<Point2> points;
      for (int n = dice.whole(3, 14); n > 0; --n) points.push_back({dice.real(0, 8), dice.real(0, 8)});
      slice.push_back(torture::loop(points, dice.one_in(4) && !slice.empty() ? Direction::Inner : Direction::Outer,
                                    dice.whole(0, 1)));
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Point2 &a = points[i], &b = points[(i + 1) % points.size()];
        perimeter += std::hypot(b.x - a.x, b.y - a.y);
      }
    }
    const SliceStack stack = stack_of({slice, slice});
    const int n = 400;
    const double cell = 8.0 / n;
    int count = 0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) count += is_inside(stack.layers[0], (i + 0.5) * cell, (j + 0.5) * cell) ? 1 : 0;
    if (count == 0) continue;  // the holes left nothing
    const double area = united_areas(stack).at(0);
    // Errors of cells that the boundary crosses have no preferred sign: five standard deviations.
    const double crossed = 1.5 * perimeter / cell;
    CHECK(std::fabs(area - count * cell * cell) < 5 * 0.5 * std::sqrt(crossed) * cell * cell);
  }
}

TEST_CASE("volumes of meshes are those of their contours, layer by layer, by sampling the complex") {
  for (std::uint32_t seed = 21; seed <= 24; ++seed) {
    CAPTURE(seed);
    const TortureCase input = torture::random_stacks(seed)[0];
    const Outcome outcome = run_pipeline(input.stack, input.options);
    INFO(outcome.message);
    REQUIRE(outcome.certified());
    // By the divergence theorem over the horizontal facets of the complex: area from vertices, without the tets.
    std::vector<double> area(outcome.plc.slabs.size(), 0);
    for (const Facet& f : outcome.plc.facets) {
      if (f.label == FacetLabel::Wall || f.label == FacetLabel::InnerWall) continue;
      double twice = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto p = outcome.plc.position(static_cast<std::size_t>(f.vertices[k])),
                   q = outcome.plc.position(static_cast<std::size_t>(f.vertices[(k + 1) % 3]));
        twice += p[0] * q[1] - q[0] * p[1];
      }
      const Side above = f.label == FacetLabel::Interface ? f.front : f.label == FacetLabel::Down ? f.back : Side{};
      if (!above.empty()) area[static_cast<std::size_t>(above.slab)] += std::fabs(twice) / 2;
    }
    const std::vector<double> volumes = slab_volumes(outcome.mesh);
    REQUIRE(volumes.size() == area.size());
    for (std::size_t s = 0; s < area.size(); ++s) {
      const double height = outcome.mesh.slabs[s].z_high - outcome.mesh.slabs[s].z_low;
      CHECK(volumes[s] == Approx(area[s] * height).epsilon(1e-8));
    }
  }
}

TEST_CASE("TetGen finds no two facets of a complex that intersect", "[external]") {
  if (std::system("tetgen -h > /dev/null 2>&1") == 127 * 256) {
    WARN("no program tetgen: its check of the complex is left out");
    return;
  }
  const TemporaryDirectory directory;
  int checked = 0;
  for (const TortureClass& kind : torture_classes()) {
    if (kind.name != "touching_edges" && kind.name != "touching_points" && kind.name != "vanishing_layers") continue;
    int of_class = 0;
    for (const TortureCase& input : kind.make(2)) {
      if (of_class == 2 || !input.allowed.certified) break;
      const Outcome outcome = run_pipeline(input.stack, input.options);
      if (!outcome.certified() || outcome.plc.facets.size() > 3000) continue;
      CAPTURE(kind.name, input.name, outcome.plc.facets.size());
      write_plc(directory.file("a.poly"), outcome.plc);
      const std::string command = "cd " + directory.path().string() +
                                  " && timeout 120 tetgen -d a.poly > out.txt 2>&1; tail -n 40 out.txt > end.txt";
      REQUIRE(std::system(command.c_str()) == 0);
      std::string text(1 << 16, '\0');
      std::FILE* file = std::fopen(directory.file("end.txt").c_str(), "rb");
      REQUIRE(file != nullptr);
      text.resize(std::fread(text.data(), 1, text.size(), file));
      std::fclose(file);
      INFO(text);
      CHECK(text.find("No faces are intersecting") != std::string::npos);
      ++checked;
      ++of_class;
    }
  }
  CHECK(checked >= 4);
}
