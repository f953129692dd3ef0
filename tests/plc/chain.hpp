// SPDX-License-Identifier: MIT
/// @file
/// @brief The stages from slices to the complex, one after the other, and slices to run them on.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "slice2mesh/cli/read_cli.hpp"
#include "slice2mesh/harmonize/harmonize.hpp"
#include "slice2mesh/lift/lift.hpp"
#include "slice2mesh/plc/build_plc.hpp"
#include "slice2mesh/regions/regions.hpp"
#include "slice2mesh/triangulate/interior.hpp"
#include "slice2mesh/triangulate/plane_mesh.hpp"
#include "test_support.hpp"

namespace slice2mesh_test {

struct ChainOptions {
  double eps = 0.1;             ///< in layer thicknesses
  double size = 2;              ///< in layer thicknesses
  double contour_size = 1;      ///< in layer thicknesses
  double support_radius = 0.1;  ///< mm
  double radius_edge_ratio = 1.3;
  bool interior = true;
};

/// The results of all stages up to the complex.
struct Chain {
  slice2mesh::Diagnostics diagnostics;
  slice2mesh::LayerRegions regions;
  slice2mesh::Contours contours;
  std::vector<std::array<std::int32_t, 2>> slab_planes;
  std::vector<slice2mesh::InterfacePlane> lifted;
  std::vector<slice2mesh::PlaneMesh> planes;

  [[nodiscard]] slice2mesh::Plc plc(bool inner_faces = true) const {
    return slice2mesh::build_plc(contours, planes, slab_planes, inner_faces);
  }
};

[[nodiscard]] inline Chain run_chain(const slice2mesh::SliceStack& stack, const ChainOptions& options = {}) {
  using namespace slice2mesh;
  Chain chain;
  const SlabPlan plan = make_slabs(stack, {}, chain.diagnostics);
  ThickenOptions thicken_options;
  thicken_options.radius = Length::mm(options.support_radius);
  chain.regions = build_regions(stack, plan, thicken_options, chain.diagnostics);
  HarmonizeOptions harmonize_options;
  harmonize_options.eps = options.eps * plan.thickness;
  harmonize_options.contour_size = options.contour_size * plan.thickness;
  chain.contours = harmonize(chain.regions, harmonize_options, chain.diagnostics);
  const double pitch = chain.contours.grid.pitch;
  for (const auto& [below, above] : plane_slabs(chain.contours.slabs, chain.slab_planes)) {
    chain.lifted.push_back(lift(chain.contours, below, above));
    PlaneRefinement refinement;
    if (options.interior) {
      InteriorSizes sizes;
      sizes.size = options.size * plan.thickness / pitch;
      sizes.contour_size = options.contour_size * plan.thickness / pitch;
      refinement.interior = interior_points(chain.contours, below, above, sizes);
    }
    refinement.radius_edge_ratio = options.radius_edge_ratio;
    refinement.shortest = 0.05 * plan.thickness / pitch;
    chain.planes.push_back(triangulate_plane(chain.lifted.back(), refinement));
  }
  return chain;
}

[[nodiscard]] inline slice2mesh::Polyline loop(std::vector<slice2mesh::Point2> points,
                                               slice2mesh::Direction direction = slice2mesh::Direction::Outer,
                                               std::int32_t part = 0) {
  slice2mesh::Polyline line;
  line.part = part;
  line.direction = direction;
  line.points = std::move(points);
  return line;
}

[[nodiscard]] inline slice2mesh::Polyline rectangle(double x0, double y0, double x1, double y1,
                                                    slice2mesh::Direction direction = slice2mesh::Direction::Outer,
                                                    std::int32_t part = 0) {
  std::vector<slice2mesh::Point2> points{{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
  if (direction == slice2mesh::Direction::Inner) std::reverse(points.begin(), points.end());
  return loop(std::move(points), direction, part);
}

/// A regular polygon, or a star where `depth` is not 0.
[[nodiscard]] inline slice2mesh::Polyline star(double x, double y, double radius, int corners, double depth = 0,
                                               double turn = 0,
                                               slice2mesh::Direction direction = slice2mesh::Direction::Outer) {
  std::vector<slice2mesh::Point2> points;
  for (int i = 0; i < corners; ++i) {
    const double angle = turn + 2 * 3.14159265358979323846 * i / corners;
    const double r = radius * (i % 2 == 0 ? 1 : 1 - depth);
    points.push_back({x + r * std::cos(angle), y + r * std::sin(angle)});
  }
  if (direction == slice2mesh::Direction::Inner) std::reverse(points.begin(), points.end());
  return loop(std::move(points), direction);
}

[[nodiscard]] inline slice2mesh::SliceStack stack_of(std::vector<std::vector<slice2mesh::Polyline>> slices,
                                                     double thickness = 0.5) {
  slice2mesh::SliceStack stack;
  for (std::size_t i = 0; i < slices.size(); ++i) {
    slice2mesh::Layer layer;
    layer.z = thickness * double(i);
    layer.polylines = std::move(slices[i]);
    stack.layers.push_back(std::move(layer));
  }
  return stack;
}

struct NamedStack {
  std::string name;
  slice2mesh::SliceStack stack;
};

/// Stacks of two parts, one in the way of the other, so that walls stand between regions.
[[nodiscard]] inline std::vector<NamedStack> two_part_stacks() {
  std::vector<NamedStack> result;
  for (const double slope : {0.0, 0.13, 0.4}) {
    std::vector<std::vector<slice2mesh::Polyline>> layers;
    for (int i = 0; i < 6; ++i) {
      slice2mesh::Polyline other = rectangle(2 + slope * i, 1, 6, 4 + slope * i);
      other.part = 1;
      layers.push_back({rectangle(0, 0, 4, 3), other});
    }
    result.push_back({"two parts", stack_of(layers)});
  }
  return result;
}

/// Small stacks that have one of everything: holes, overhangs, islands, cones, supports, gaps, two parts.
[[nodiscard]] inline std::vector<NamedStack> generated_stacks() {
  using slice2mesh::Direction;
  std::vector<NamedStack> result;
  result.push_back({"box", stack_of({{rectangle(0, 0, 4, 3)}, {rectangle(0, 0, 4, 3)}, {rectangle(0, 0, 4, 3)}})});
  result.push_back(
      {"overhang", stack_of({{rectangle(0, 0, 4, 3)}, {rectangle(0, 0, 6, 3)}, {rectangle(-1, 1, 3, 2)}})});
  result.push_back({"hole that moves", stack_of({{rectangle(0, 0, 6, 6), rectangle(2, 2, 4, 4, Direction::Inner)},
                                                 {rectangle(0, 0, 6, 6), rectangle(2.3, 2, 4.3, 4, Direction::Inner)},
                                                 {rectangle(0, 0, 6, 6), rectangle(1, 1, 3, 3, Direction::Inner)}})});
  result.push_back({"island in a hole",
                    stack_of({{rectangle(0, 0, 8, 8), rectangle(1, 1, 7, 7, Direction::Inner), rectangle(3, 3, 5, 5)},
                              {rectangle(0, 0, 8, 8), rectangle(1, 1, 7, 7, Direction::Inner), star(4, 4, 1.5, 6)}})});
  std::vector<std::vector<slice2mesh::Polyline>> cone, screw;
  for (int i = 0; i < 6; ++i) {
    cone.push_back({star(0.1, 0.2, 5 - 0.6 * i, 32)});
    screw.push_back({star(0, 0, 4, 10, 0.4, 0.07 * i)});
  }
  result.push_back({"cone", stack_of(cone)});
  result.push_back({"turning star", stack_of(screw)});
  slice2mesh::Polyline line;
  line.direction = Direction::Open;
  line.points = {{-1, 1}, {5, 1.5}, {5, 4}};
  result.push_back(
      {"supports", stack_of({{rectangle(0, 0, 2, 3), line}, {rectangle(0, 0, 2, 3), line}, {rectangle(0, 0, 6, 5)}})});
  result.push_back({"two parts", stack_of({{rectangle(0, 0, 2, 2), rectangle(2, 0, 4, 2, Direction::Outer, 1)},
                                           {rectangle(0, 0, 2.5, 2), rectangle(2.5, 0, 4, 2, Direction::Outer, 1)}})});
  slice2mesh::SliceStack gap =
      stack_of({{rectangle(0, 0, 3, 3)}, {}, {}, {rectangle(0, 0, 3, 3)}, {rectangle(1, 1, 3, 3)}});
  result.push_back({"gap", gap});
  return result;
}

/// A stack of random overlapping stars and rectangles that drift from slice to slice.
[[nodiscard]] inline slice2mesh::SliceStack random_stack(std::uint32_t seed, int slices = 4) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; };
  struct Shape {
    double x, y, r, dx, dy, dr, depth, turn;
    int corners;
  };
  std::vector<Shape> shapes(1 + random() % 4);
  for (Shape& s : shapes)
    s = {uniform(0, 8),      uniform(0, 8),   uniform(1, 3),   uniform(-0.4, 0.4),    uniform(-0.4, 0.4),
         uniform(-0.3, 0.3), uniform(0, 0.5), uniform(0, 0.2), 3 + int(random() % 14)};
  std::vector<std::vector<slice2mesh::Polyline>> all;
  for (int i = 0; i < slices; ++i) {
    std::vector<slice2mesh::Polyline> slice;
    for (const Shape& s : shapes)
      slice.push_back(
          star(s.x + s.dx * i, s.y + s.dy * i, std::max(0.6, s.r + s.dr * i), s.corners, s.depth, s.turn * i));
    all.push_back(slice);
  }
  return stack_of(std::move(all));
}

/// The files of the shared data with contours or open lines, or none, which is said.
[[nodiscard]] inline std::vector<std::filesystem::path> corpus_files() {
  std::vector<std::filesystem::path> result;
  const auto data = shared_data();
  if (!data) {
    WARN("no shared data: set SLICE2MESH_SHARED_DATA");
    return result;
  }
  for (const auto& entry : std::filesystem::recursive_directory_iterator(*data))
    if (entry.path().extension() == ".cli") result.push_back(entry.path());
  std::sort(result.begin(), result.end());
  REQUIRE(!result.empty());
  return result;
}

/// Those of them that are fast to mesh.
[[nodiscard]] inline std::vector<std::filesystem::path> small_corpus_files() {
  std::vector<std::filesystem::path> result;
  const auto all = corpus_files();
  for (const auto& path : all)
    for (const char* name : {"T_supported", "pyramid", "torus_coarse", "joint", "sphere"})
      if (path.filename().string().rfind(name, 0) == 0) result.push_back(path);
  if (!all.empty()) REQUIRE(!result.empty());
  return result;
}

}  // namespace slice2mesh_test
