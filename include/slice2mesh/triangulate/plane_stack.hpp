// SPDX-License-Identifier: MIT
/// @file
/// @brief The triangulations of all planes of a stack of slabs.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "slice2mesh/arrange/size_field.hpp"
#include "slice2mesh/core/diagnostics.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/harmonize/harmonize.hpp"
#include "slice2mesh/lift/lift.hpp"
#include "slice2mesh/pipeline/options.hpp"
#include "slice2mesh/triangulate/interior.hpp"
#include "slice2mesh/triangulate/plane_mesh.hpp"

namespace slice2mesh {

/// Sizes of a run.
struct PlaneSizes {
  double size = 0;          ///< mm, > 0: edge length in the interior
  double contour_size = 0;  ///< mm, > 0: longest edge of a contour
  double growth = 0.5;      ///< > 0, ratio of the growth of sizes to the distance from what they grow from
  /// The edge length wanted at a place, all in mm, from `SizeOptions::refined` and `size_at`; empty: everywhere the
  /// same.
  SizeFunction size_at;
};

namespace detail {

/// One function for all that says where elements are smaller. Errors: OptionError.
[[nodiscard]] inline SizeFunction combined_sizes(const SizeOptions& options, const LayerRegions& regions) {
  if (options.refined.empty()) return options.size_at;
  const double smallest = smallest_size(regions.outlines) * regions.grid.pitch;
  struct Ball {
    double x, y, z, radius, size;
  };
  std::vector<Ball> balls;
  for (const RefinedBall& ball : options.refined) {
    const double size = ball.size.in_mm(regions.thickness);
    if (!(size > 0) || !std::isfinite(size))
      throw OptionError("size.refined", "a size must be a finite length above 0");
    if (!(size >= smallest)) throw OptionError("size.refined", "a size is below 2^-20 of the extent of the part");
    if (!(ball.radius >= 0) || !std::isfinite(ball.radius) || !std::isfinite(ball.x) || !std::isfinite(ball.y) ||
        !std::isfinite(ball.z))
      throw OptionError("size.refined", "a ball must have a finite center and a finite radius, 0 or more");
    balls.push_back({ball.x, ball.y, ball.z, ball.radius, size});
  }
  return [balls, growth = options.growth, more = options.size_at](double x, double y, double z) {
    double size = more ? more(x, y, z) : HUGE_VAL;
    for (const Ball& b : balls) {
      const double d = std::hypot(x - b.x, y - b.y, z - b.z) - b.radius;
      const double here = b.size + growth * std::max(0.0, d);
      if (!(size <= here)) size = std::isnan(size) ? size : here;
    }
    return size;
  };
}

}  // namespace detail

/// The sizes in mm that the options mean for regions.
/// Errors: OptionError for sizes that are not finite or below 0. Cost: linear.
[[nodiscard]] inline PlaneSizes resolve_sizes(const SizeOptions& options, const LayerRegions& regions) {
  const double thickness = regions.thickness;
  PlaneSizes sizes;
  sizes.size = options.size.in_mm(thickness);
  if (!(sizes.size >= 0) || !std::isfinite(sizes.size))
    throw OptionError("size.size", "must be a finite length, 0 or more");
  sizes.contour_size = options.contour_size.in_mm(thickness);
  if (!(sizes.contour_size >= 0) || !std::isfinite(sizes.contour_size))
    throw OptionError("size.contour_size", "must be a finite length, 0 or more");
  if (!(options.growth >= 0.05 && options.growth <= 10)) throw OptionError("size.growth", "must be from 0.05 to 10");
  sizes.growth = options.growth;
  sizes.size_at = detail::combined_sizes(options, regions);
  if (sizes.size == 0) {
    const double coarsest = options.coarsest.in_mm(thickness);
    if (!(coarsest > 0) || !std::isfinite(coarsest))
      throw OptionError("size.coarsest", "must be a finite length above 0");
    if (!(options.automatic_tets > 0)) throw OptionError("size.automatic_tets", "must be above 0");
    double area = 0;  // mm^2, of all slabs
    for (const Outline& outline : regions.outlines)
      area += static_cast<double>(detail::doubled_area(outline, kNone)) / 2 * regions.grid.pitch * regions.grid.pitch;
    // An equilateral triangle has sqrt(3)/4 l^2, and a column over it is cut in three tets.
    const double needed = std::sqrt(3 * area / (std::sqrt(3.0) / 4 * options.automatic_tets));
    sizes.size = std::max(2 * thickness, std::min(needed, coarsest));
  }
  // Half of the interior size: contours of neighboring layers are nearer to each other than anything in the interior.
  if (sizes.contour_size == 0) sizes.contour_size = sizes.size / 2;
  return sizes;
}

/// Triangles with a larger ratio of circumradius to shortest edge get a vertex (an angle of about 23 degrees).
inline constexpr double kRadiusEdgeRatio = 1.3;
/// No such vertex is nearer to another one than this share of the layer thickness.
inline constexpr double kShortestShare = 0.05;

/// The triangulations of all planes, lowest first, and which planes bound each slab.
struct PlaneStack {
  std::vector<PlaneMesh> meshes;                         ///< #P, one per plane
  std::vector<std::array<std::int32_t, 2>> slab_planes;  ///< #S by 2: indices of the bottom and the top plane
  double size = 0;  ///< mm, edge length in the interior that they were made for; 0: not known
};

/// Conforming, graded triangulations of all planes. Each is a pure function of the contours of at most four slabs.
/// Precondition: `sizes` above 0 and finite, as `resolve_sizes` gives them (not checked). Errors:
/// TetrahedralizationError where something of a slice is so thin that it vanishes in a plane, BudgetError, Cancelled,
/// OptionError where `size_at` gives no size.
/// Cost: O(n log n) per plane.
[[nodiscard]] inline PlaneStack triangulate_planes(const Contours& contours, const PlaneSizes& sizes,
                                                   const Budget& budget = {}, const Progress& progress = {}) {
  const double pitch = contours.grid.pitch;
  PlaneStack stack;
  stack.size = sizes.size;
  const auto planes = plane_slabs(contours.slabs, stack.slab_planes);
  std::int64_t vertices = 0;
  std::optional<detail::SizeField> field;
  if (sizes.size_at) field.emplace(sizes.size_at, contours.grid, detail::smallest_size(contours.outlines));
  for (std::size_t k = 0; k < planes.size(); ++k) {
    const std::function<void()> poll = [&] { report(progress, Stage::Triangulate, double(k) / double(planes.size())); };
    poll();
    InterfacePlane plane = lift(contours, planes[k].first, planes[k].second, poll);
    PlaneRefinement refinement;
    if (budget.max_vertices > 0)
      refinement.max_vertices = static_cast<std::size_t>(std::max<std::int64_t>(1, budget.max_vertices - vertices));
    refinement.interior = interior_points(contours, planes[k].first, planes[k].second,
                                          {sizes.size / pitch, sizes.contour_size / pitch, sizes.growth,
                                           field ? &*field : nullptr, refinement.max_vertices},
                                          poll);
    refinement.poll = poll;
    // In exact mode contours have angles and distances of any smallness: there is no shape to refine for.
    refinement.radius_edge_ratio = contours.eps > 0 ? kRadiusEdgeRatio : 0;
    refinement.shortest = kShortestShare * contours.thickness / pitch;
    {
      detail::PlaneMesher mesher(std::move(plane), std::move(refinement));
      mesher.run();
      stack.meshes.push_back(mesher.extract());
      poll();  // what the mesher has takes its time to go
    }
    poll();
    vertices += static_cast<std::int64_t>(stack.meshes.back().vertices.size());
  }
  report(progress, Stage::Triangulate, 1);
  return stack;
}

}  // namespace slice2mesh
