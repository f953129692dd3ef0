// SPDX-License-Identifier: MIT
// What a change of the input must do to the mesh: nothing to the last bit where that is promised, else nothing to areas
// and volumes beyond what is promised.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "slice2mesh/core/slice_stack.hpp"
#include "test_support.hpp"
#include "torture/generators.hpp"
#include "torture/pipeline_runner.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;
using torture::box;
using torture::stack_of;
using torture::star;

namespace {

/// Coordinates on a lattice of 2^-16 mm: sums and differences with others are exact.
void round_to_lattice(SliceStack& stack) {
  for (Layer& layer : stack.layers)
    for (Polyline& line : layer.polylines)
      for (Point2& p : line.points) p = {std::round(p.x * 65536) / 65536, std::round(p.y * 65536) / 65536};
}

struct Sample {
  std::string name;
  SliceStack stack;
  Options options;
};

std::vector<Sample> samples() {
  std::vector<Sample> result;
  std::vector<torture::Slice> slices;
  for (int i = 0; i < 4; ++i)
    slices.push_back({box(0.25 * i, 0, 8, 5), box(2, 1, 4, 3, Direction::Inner), box(10, 1, 12, 3 + 0.125 * i)});
  result.push_back({"boxes", stack_of(slices), {}});
  slices.clear();
  for (int i = 0; i < 4; ++i)
    slices.push_back({star({0.1 * i, 3}, 4, 14, 0.3, 0.05 * i), star({2, 3}, 1, 9, 0, 0, Direction::Inner),
                      star({5, 4}, 2, 11, 0, 0, Direction::Outer, 1)});
  result.push_back({"stars of two parts", stack_of(slices), {}});
  for (std::uint32_t seed = 11; seed < 11 + times(2); ++seed) {
    const auto inputs = torture::random_stacks(seed);
    result.push_back({"random stack " + std::to_string(seed), inputs[0].stack, {}});
  }
  for (Sample& sample : result) {
    round_to_lattice(sample.stack);
    sample.options.size.size = Length::mm(1);
    sample.options.eps = Length::mm(0.0625);
  }
  return result;
}

SliceStack changed(SliceStack stack, const std::function<void(Point2&)>& change) {
  for (Layer& layer : stack.layers)
    for (Polyline& line : layer.polylines)
      for (Point2& p : line.points) change(p);
  return stack;
}

Outcome run(const SliceStack& stack, const Options& options) {
  Outcome outcome = run_pipeline(stack, options);
  INFO(outcome.message);
  REQUIRE(outcome.certified());
  return outcome;
}

/// Perimeter of all loops of a layer, mm: a bound of how much area an offset of the contour can add per length.
double perimeter(const Layer& layer) {
  double sum = 0;
  for (const Polyline& line : layer.polylines)
    for (std::size_t i = 0; i < line.points.size(); ++i) {
      const Point2 &a = line.points[i], &b = line.points[(i + 1) % line.points.size()];
      sum += std::hypot(b.x - a.x, b.y - a.y);
    }
  return sum;
}

/// Both meshes have contours within eps of the same slices.
void check_volumes_alike(const Outcome& a, const Outcome& b, const SliceStack& stack) {
  const std::vector<double> first = slab_volumes(a.mesh), second = slab_volumes(b.mesh);
  REQUIRE(first.size() == second.size());
  for (std::size_t s = 0; s < first.size(); ++s) {
    CAPTURE(s);
    const Slab& slab = a.mesh.slabs[s];
    const double height = slab.z_high - slab.z_low;
    const double allowed = (a.eps + b.eps) *
                           (perimeter(stack.layers[static_cast<std::size_t>(slab.slice)]) + 10 * (a.eps + b.eps)) *
                           height;
    CHECK(std::fabs(first[s] - second[s]) <= allowed);
  }
}

}  // namespace

TEST_CASE("a translation by steps of the grid moves the mesh and changes nothing else, to the last bit") {
  for (const Sample& sample : samples()) {
    CAPTURE(sample.name);
    const Outcome before = run(sample.stack, sample.options);
    // Multiples of 2^-10 mm, far from where the grid would become coarser.
    for (const Point2 by : {Point2{1024, -512}, Point2{-0.0009765625, 3.5}}) {
      CAPTURE(by.x, by.y);
      const SliceStack moved = changed(sample.stack, [&](Point2& p) { p = {p.x + by.x, p.y + by.y}; });
      Outcome after = run(moved, sample.options);
      for (auto& v : after.mesh.vertices) {
        v[0] -= by.x;
        v[1] -= by.y;
      }
      CHECK(same_mesh(before.mesh, after.mesh));
    }
  }
}

TEST_CASE("scaling everything by a power of two scales the mesh and changes nothing else, to the last bit") {
  for (const Sample& sample : samples()) {
    CAPTURE(sample.name);
    const Outcome before = run(sample.stack, sample.options);
    for (const double scale : {2.0, 0.03125}) {
      CAPTURE(scale);
      SliceStack scaled = changed(sample.stack, [&](Point2& p) { p = {p.x * scale, p.y * scale}; });
      for (Layer& layer : scaled.layers) layer.z *= scale;
      Options options = sample.options;
      options.size.size.value *= scale;
      options.eps.value *= scale;
      Outcome after = run(scaled, options);
      SliceStack units = sample.stack;  // the same by the unit of the stack
      units.unit = units.z_unit = scale;
      CHECK(same_mesh(after.mesh, run(units, options).mesh));
      for (auto& v : after.mesh.vertices)
        for (double& x : v) x /= scale;
      CHECK(same_mesh(before.mesh, after.mesh));
    }
  }
}

TEST_CASE("order, start and direction of loops change nothing, to the last bit") {
  for (const Sample& sample : samples()) {
    CAPTURE(sample.name);
    const Outcome before = run(sample.stack, sample.options);
    SliceStack permuted = sample.stack;
    for (Layer& layer : permuted.layers) std::reverse(layer.polylines.begin(), layer.polylines.end());
    CHECK(same_mesh(before.mesh, run(permuted, sample.options).mesh));
    SliceStack rotated = sample.stack;
    for (Layer& layer : rotated.layers)
      for (Polyline& line : layer.polylines)
        std::rotate(line.points.begin(), line.points.begin() + 1, line.points.end());
    CHECK(same_mesh(before.mesh, run(rotated, sample.options).mesh));
    SliceStack reversed = sample.stack;
    for (Layer& layer : reversed.layers)
      for (Polyline& line : layer.polylines) std::reverse(line.points.begin(), line.points.end());
    CHECK(same_mesh(before.mesh, run(reversed, sample.options).mesh));
    SliceStack twice = sample.stack;  // with a repeated point in each loop
    for (Layer& layer : twice.layers)
      for (Polyline& line : layer.polylines) line.points.push_back(line.points.back());
    CHECK(same_mesh(before.mesh, run(twice, sample.options).mesh));
  }
}

TEST_CASE("mirroring and quarter turns keep the united areas, and volumes within eps of the contours") {
  const std::vector<std::pair<std::string, std::function<void(Point2&)>>> changes = {
      {"mirrored in x", [](Point2& p) { p.x = -p.x; }},
      {"mirrored in the diagonal", [](Point2& p) { std::swap(p.x, p.y); }},
      {"a quarter turn",
       [](Point2& p) {
         p = {-p.y, p.x};
       }},
      {"half a turn", [](Point2& p) {
         p = {-p.x, -p.y};
       }}};
  for (const Sample& sample : samples()) {
    const Outcome outcome = run(sample.stack, sample.options);
    for (const auto& [name, change] : changes) {
      CAPTURE(sample.name, name);
      const SliceStack turned = changed(sample.stack, change);
      const std::vector<double> before = united_areas(sample.stack), after = united_areas(turned);
      REQUIRE(before.size() == after.size());
      // Contour vertices are rounded once, to 2^-36 of the part or finer.
      for (std::size_t s = 0; s < before.size(); ++s) CHECK(after[s] == Approx(before[s]).epsilon(1e-9));
      check_volumes_alike(outcome, run(turned, sample.options), sample.stack);
    }
  }
}

TEST_CASE("one part split into two ids has the same area, and volumes within eps of the contours") {
  for (const Sample& sample : samples()) {
    CAPTURE(sample.name);
    SliceStack split = sample.stack;
    bool any = false;
    for (Layer& layer : split.layers) {
      // Outer loops alternate between two ids; a hole cuts from both.
      std::vector<Polyline> lines;
      std::int32_t next = 0;
      for (Polyline line : layer.polylines) {
        if (line.direction == Direction::Inner) {
          line.part = 20;
          lines.push_back(line);
          line.part = 21;
        } else {
          line.part = 20 + next;
          any = any || next == 1;
          next = 1 - next;
        }
        lines.push_back(line);
      }
      layer.polylines = lines;
    }
    SliceStack whole = split;
    for (Layer& layer : whole.layers) {
      for (Polyline& line : layer.polylines) line.part = 20;
    }
    // Winding numbers: a hole that stands twice cuts twice, so the whole has each hole once.
    for (Layer& layer : whole.layers) {
      std::vector<Polyline> lines;
      for (const Polyline& line : layer.polylines)
        if (line.direction != Direction::Inner || std::find(lines.begin(), lines.end(), line) == lines.end())
          lines.push_back(line);
      layer.polylines = lines;
    }
    if (!any) continue;
    bool overlapping_holes = false;  // what a hole cuts from two overlapping loops depends on their ids
    for (const Layer& layer : whole.layers)
      for (const Polyline& line : layer.polylines)
        overlapping_holes = overlapping_holes || line.direction == Direction::Inner;
    const std::vector<double> one = united_areas(whole), two = united_areas(split);
    REQUIRE(one.size() == two.size());
    if (!overlapping_holes || sample.name == "boxes") {
      for (std::size_t s = 0; s < one.size(); ++s) CHECK(two[s] == Approx(one[s]).epsilon(1e-9));
      const Outcome a = run(whole, sample.options), b = run(split, sample.options);
      check_volumes_alike(a, b, whole);
      CHECK(b.mesh.regions.size() == 2);
    }
  }
}

TEST_CASE("a layer split into two of half its thickness fills the same space") {
  for (Sample sample : samples()) {
    CAPTURE(sample.name);
    sample.options.slabs.z_convention = ZConvention::Bottom;
    SliceStack halves;
    for (const Layer& layer : sample.stack.layers) {
      halves.layers.push_back(layer);
      halves.layers.push_back(layer);
      halves.layers.back().z += 0.5 * torture::kHeight;
    }
    const Outcome whole = run(sample.stack, sample.options), split = run(halves, sample.options);
    const std::vector<double> one = slab_volumes(whole.mesh), two = slab_volumes(split.mesh);
    REQUIRE(two.size() == 2 * one.size());
    for (std::size_t s = 0; s < one.size(); ++s) {
      CAPTURE(s);
      CHECK(split.mesh.slabs[2 * s].z_low == whole.mesh.slabs[s].z_low);
      CHECK(split.mesh.slabs[2 * s].z_high == split.mesh.slabs[2 * s + 1].z_low);
      CHECK(split.mesh.slabs[2 * s + 1].z_high == whole.mesh.slabs[s].z_high);
      const double height = whole.mesh.slabs[s].z_high - whole.mesh.slabs[s].z_low;
      const double allowed = 2 * whole.eps * (perimeter(sample.stack.layers[s]) + 20 * whole.eps) * height;
      CHECK(std::fabs(two[2 * s] + two[2 * s + 1] - one[s]) <= allowed);
    }
  }
  // Where no layer differs from the next one, there is nothing to harmonize.
  std::vector<torture::Slice> slices(3, torture::Slice{star({0, 0}, 3, 12, 0.3)});
  const Outcome whole = run(stack_of(slices), {});
  slices.resize(6, slices[0]);
  const Outcome split = run(stack_of(slices, 0.5 * torture::kHeight), {});
  double one = 0, two = 0;
  for (const double v : slab_volumes(whole.mesh)) one += v;
  for (const double v : slab_volumes(split.mesh)) two += v;
  CHECK(two == Approx(one).epsilon(1e-9));
}
