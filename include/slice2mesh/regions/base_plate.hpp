// SPDX-License-Identifier: MIT
/// @file
/// @brief A base plate under the part: slabs of their own below the first slice, in a region of their own.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/core/diagnostics.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/core/slice_stack.hpp"
#include "slice2mesh/pipeline/options.hpp"
#include "slice2mesh/regions/regions.hpp"
#include "slice2mesh/regions/slabs.hpp"
#include "slice2mesh/regions/thicken.hpp"

namespace slice2mesh {

namespace detail {

/// Slabs of a plate are at most this many layer thicknesses high, unless there would be more than kPlateSlabs of them:
/// its elements are about as wide as those of the part, and should not be much higher than that.
inline constexpr double kPlateSlabHeight = 8;
inline constexpr double kPlateSlabs = 100;
/// Round corners of a plate are this share of the margin inside of true arcs at most.
inline constexpr double kPlateArcTolerance = 0.01;

/// The planes of a plate from its bottom (top - thickness) to its top, mm. `count` slabs of equal height; 0: from one
/// layer thickness at the top, doubled from slab to slab downwards, all scaled to fit.
[[nodiscard]] inline std::vector<double> plate_planes(double top, double thickness, double layer, std::int32_t count) {
  std::vector<double> heights;  // from the top
  if (count > 0) {
    heights.assign(static_cast<std::size_t>(count), thickness / count);
  } else {
    const double highest = std::max(kPlateSlabHeight * layer, thickness / kPlateSlabs);
    double sum = 0;
    for (double height = std::min(layer, thickness); sum < thickness * (1 - 1e-9);) {
      heights.push_back(height);
      sum += height;
      height = std::min(2 * height, highest);
    }
    for (double& height : heights) height *= thickness / sum;
  }
  std::vector<double> planes = {top - thickness};
  for (std::size_t i = heights.size(); i-- > 1;) planes.push_back(planes.back() + heights[i]);
  planes.push_back(top);
  return planes;
}

/// The first slab that has something to stand on a plate: a contour, or a line that becomes a support.
[[nodiscard]] inline std::size_t first_standing_slab(const SliceStack& stack, const SlabPlan& plan,
                                                     const ThickenOptions& supports) {
  for (std::size_t s = 0; s < plan.slabs.size(); ++s) {
    const std::int32_t slice = plan.slabs[s].slice;
    for (const Polyline& line : stack.layers[static_cast<std::size_t>(slice)].polylines)
      if (line.direction == Direction::Open
              ? !line.points.empty() && support_radius(supports, line, slice, plan.thickness) > 0
              : line.direction != Direction::Inner && line.points.size() >= 3)  // a hole by itself is nothing
        return s;
  }
  throw GeometryError(Stage::Regions, -1, -1, "there is nothing to stand on the base plate");
}

/// The loops of a plate in mm; their union (non-zero winding) is the plate.
[[nodiscard]] inline std::vector<std::vector<Point2>> plate_loops(const SliceStack& stack, const SlabPlan& plan,
                                                                  std::size_t first, const ThickenOptions& supports,
                                                                  BasePlateShape shape, double margin) {
  // How far a thickened line may reach from its points, in radii.
  const double reach_in_radii =
      supports.join == LineJoin::Miter ? std::max(supports.miter_limit, std::sqrt(2.0)) : std::sqrt(2.0);
  ThickenOptions round;
  round.cap = LineCap::Round;
  round.join = LineJoin::Round;
  round.arc_tolerance = kPlateArcTolerance;
  Point2 low{HUGE_VAL, HUGE_VAL};
  Point2 high{-HUGE_VAL, -HUGE_VAL};
  std::vector<std::vector<Point2>> loops;
  for (std::size_t s = 0; s < plan.slabs.size(); ++s) {
    if (shape == BasePlateShape::Offset && s != first) continue;
    const std::int32_t slice = plan.slabs[s].slice;
    const std::vector<Polyline>& lines = stack.layers[static_cast<std::size_t>(slice)].polylines;
    for (std::size_t k = 0; k < lines.size(); ++k) {
      const bool open = lines[k].direction == Direction::Open;
      const double reach = open ? reach_in_radii * support_radius(supports, lines[k], slice, plan.thickness) : 0;
      if (lines[k].points.empty() || (open && !(reach > 0))) continue;
      if (shape == BasePlateShape::Offset && lines[k].direction == Direction::Inner) continue;  // holes are filled
      std::vector<Point2> points;
      for (const Point2& p : lines[k].points) {
        points.push_back({p.x * stack.unit, p.y * stack.unit});
        if (!std::isfinite(points.back().x) || !std::isfinite(points.back().y))
          throw GeometryError(Stage::Regions, slice, static_cast<std::int64_t>(k), "a coordinate is not finite");
      }
      if (shape == BasePlateShape::Box) {
        for (const Point2& p : points) {
          low = {std::min(low.x, p.x - reach), std::min(low.y, p.y - reach)};
          high = {std::max(high.x, p.x + reach), std::max(high.y, p.y + reach)};
        }
        continue;
      }
      std::vector<Point2> boundary = points;
      if (!open) {
        boundary.push_back(points.front());
        loops.push_back(std::move(points));
      }
      for (std::vector<Point2>& piece : thicken(boundary, reach + margin, round)) loops.push_back(std::move(piece));
    }
  }
  if (shape == BasePlateShape::Box && low.x <= high.x) {
    low = {low.x - margin, low.y - margin};
    high = {high.x + margin, high.y + margin};
    loops.push_back({low, {high.x, low.y}, high, {low.x, high.y}});
  }
  return loops;
}

}  // namespace detail

/// The regions of all slabs, on a base plate: `build_regions` with the slabs of the plate below the others.
///
/// The plate is the bounding box of the part (as its slices and thickened lines reach), or the first slice without its
/// holes, widened by the margin; it ends where the first slab with a contour or a support begins. Its slabs have kNone
/// as slices (Slab::is_plate), its region is the last one: part id kNone, kind Plate, named "base_plate". The other
/// regions and slabs are those that there are without a plate. With `thickness` 0 there is none. Errors: OptionError
/// for options out of range; those of `build_regions`. Cost: that of `build_regions`, and a copy of the polylines.
[[nodiscard]] inline LayerRegions build_regions_on_plate(const SliceStack& stack, const SlabPlan& plan,
                                                         const ThickenOptions& supports,
                                                         const BasePlateOptions& options, Diagnostics& diagnostics,
                                                         const Progress& progress = {}) {
  const double thickness = options.thickness.in_mm(plan.thickness);
  if (!(thickness >= 0) || !std::isfinite(thickness))
    throw OptionError("plate.thickness", "must be a finite length, 0 or more");
  if (thickness == 0) return build_regions(stack, plan, supports, diagnostics, progress);
  const double margin = options.margin.in_mm(plan.thickness);
  if (!(margin > 0) || !std::isfinite(margin)) throw OptionError("plate.margin", "must be a finite length above 0");
  if (options.slabs < 0) throw OptionError("plate.slabs", "must be 0 or more");
  const std::size_t first = detail::first_standing_slab(stack, plan, supports);

  // The plate is a slice of its own behind those of the file, with a part id that nothing else has.
  SliceStack plated;
  plated.unit = stack.unit;
  plated.z_unit = stack.z_unit;
  plated.labels = stack.labels;
  std::set<std::int32_t> used;
  for (const Layer& layer : stack.layers) {
    plated.layers.emplace_back();
    plated.layers.back().polylines = layer.polylines;
    for (const Polyline& line : layer.polylines) used.insert(line.part);
  }
  std::int32_t id = std::numeric_limits<std::int32_t>::max();
  while (used.count(id) > 0) --id;
  plated.labels.erase(id);
  Layer slice;
  for (const std::vector<Point2>& loop : detail::plate_loops(stack, plan, first, supports, options.shape, margin)) {
    Polyline line;
    line.part = id;
    for (const Point2& p : loop) line.points.push_back({p.x / stack.unit, p.y / stack.unit});
    slice.polylines.push_back(std::move(line));
  }
  const auto plate_slice = static_cast<std::int32_t>(plated.layers.size());
  plated.layers.push_back(std::move(slice));
  SlabPlan plated_plan = plan;
  const std::vector<double> planes =
      detail::plate_planes(plan.slabs[first].z_low, thickness, plan.thickness, options.slabs);
  std::vector<Slab> slabs;
  for (std::size_t i = 0; i + 1 < planes.size(); ++i) {
    if (!(planes[i] < planes[i + 1]))
      throw OptionError("plate.thickness", "its slabs are too thin for double precision");
    slabs.push_back({planes[i], planes[i + 1], plate_slice, plate_slice, plate_slice});
  }
  plated_plan.slabs.insert(plated_plan.slabs.begin(), slabs.begin(), slabs.end());

  Diagnostics found;
  LayerRegions result = build_regions(plated, plated_plan, supports, found, progress);
  for (const Diagnostic& entry : found.entries())
    if (entry.layer != plate_slice) diagnostics.add(entry);  // the pieces of a plate overlap, as they should

  for (Slab& slab : result.slabs)
    if (slab.slice == plate_slice) slab.first_layer = slab.last_layer = slab.slice = kNone;
  // The region of the plate becomes the last one.
  const auto found_plate = std::find_if(result.regions.begin(), result.regions.end(),
                                        [id](const Region& region) { return region.part == id; });
  if (found_plate == result.regions.end())
    throw OptionError("plate.margin", "the plate has no area on the grid of the slices");
  const auto plate = static_cast<std::int32_t>(found_plate - result.regions.begin());
  const auto last = static_cast<std::int32_t>(result.regions.size()) - 1;
  const auto moved = [plate, last](std::int32_t region) {
    if (region == plate) return last;
    return region > plate ? region - 1 : region;
  };
  std::rotate(result.regions.begin() + plate, result.regions.begin() + plate + 1, result.regions.end());
  result.regions.back() = {kNone, RegionKind::Plate, "base_plate"};
  for (Outline& outline : result.outlines)
    for (Outline::Edge& edge : outline.edges) {
      edge.left = moved(edge.left);
      edge.right = moved(edge.right);
    }
  return result;
}

}  // namespace slice2mesh
