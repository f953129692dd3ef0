// SPDX-License-Identifier: MIT
/// @file
/// @brief The triangulations of all planes of a stack of slabs.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "slice2mesh/core/diagnostics.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/harmonize/harmonize.hpp"
#include "slice2mesh/lift/lift.hpp"
#include "slice2mesh/pipeline/options.hpp"
#include "slice2mesh/triangulate/interior.hpp"
#include "slice2mesh/triangulate/plane_mesh.hpp"

namespace slice2mesh {

/// Sizes of a run in mm.
struct PlaneSizes {
  double size = 0;          ///< edge length in the interior
  double contour_size = 0;  ///< longest edge of a contour
};

/// The sizes in mm that the options mean for a layer thickness (mm).
/// Errors: OptionError for sizes that are not positive and finite.
[[nodiscard]] inline PlaneSizes resolve_sizes(const SizeOptions& options, double thickness) {
  PlaneSizes sizes;
  sizes.size = options.size.in_mm(thickness);
  if (!(sizes.size > 0) || !std::isfinite(sizes.size))
    throw OptionError("size.size", "must be a finite length above 0");
  sizes.contour_size = options.contour_size.in_mm(thickness);
  if (!(sizes.contour_size >= 0) || !std::isfinite(sizes.contour_size))
    throw OptionError("size.contour_size", "must be a finite length, 0 or more");
  if (!(options.grading > 0 && options.grading <= 2))
    throw OptionError("size.grading", "must be above 0 and at most 2");
  // Half of the interior size: contours of neighboring layers are nearer to each other than anything in the interior.
  if (sizes.contour_size == 0) sizes.contour_size = sizes.size / 2;
  return sizes;
}

/// The triangulations of all planes, lowest first, and which planes bound each slab.
struct PlaneStack {
  std::vector<PlaneMesh> meshes;                         ///< #P
  std::vector<std::array<std::int32_t, 2>> slab_planes;  ///< #S by 2
};

/// Conforming, graded triangulations of all planes. Each is a pure function of the contours of at most four slabs.
/// Errors: OptionError, BudgetError. Cost: O(n log n) per plane.
[[nodiscard]] inline PlaneStack triangulate_planes(const Contours& contours, const SizeOptions& options,
                                                   const Budget& budget = {}, const Progress& progress = {}) {
  const PlaneSizes sizes = resolve_sizes(options, contours.thickness);
  const double pitch = contours.grid.pitch;
  PlaneStack stack;
  const auto planes = plane_slabs(contours.slabs, stack.slab_planes);
  std::int64_t vertices = 0;
  for (std::size_t k = 0; k < planes.size(); ++k) {
    report(progress, Stage::Triangulate, double(k) / double(planes.size()));
    const InterfacePlane plane = lift(contours, planes[k].first, planes[k].second);
    PlaneRefinement refinement;
    refinement.interior =
        interior_points(contours, planes[k].first, planes[k].second, {sizes.size / pitch, sizes.contour_size / pitch});
    refinement.radius_edge_ratio = 1.3;
    refinement.shortest = 0.05 * contours.thickness / pitch;
    if (budget.max_vertices > 0)
      refinement.max_vertices = static_cast<std::size_t>(std::max<std::int64_t>(1, budget.max_vertices - vertices));
    stack.meshes.push_back(triangulate_plane(plane, refinement));
    vertices += static_cast<std::int64_t>(stack.meshes.back().vertices.size());
  }
  report(progress, Stage::Triangulate, 1);
  return stack;
}

}  // namespace slice2mesh
