// SPDX-License-Identifier: MIT
/// @file
/// @brief From slices to regions: thickened lines and contours of each slab, united exactly.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/faces.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/core/diagnostics.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/grid.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/core/slice_stack.hpp"
#include "slice2mesh/pipeline/options.hpp"
#include "slice2mesh/regions/slabs.hpp"
#include "slice2mesh/regions/thicken.hpp"

namespace slice2mesh {

/// The regions of every slab, on the grid.
struct LayerRegions {
  /// The grid of the outlines.
  Grid grid;
  std::vector<Slab> slabs;                         ///< #S, lowest first; each has some area
  std::vector<Outline> outlines;                   ///< #S
  std::vector<Region> regions;                     ///< #R
  ZConvention z_convention = ZConvention::Bottom;  ///< as chosen
  double thickness = 0;                            ///< median of the slabs, mm
};

/// A grid for everything between the corners `low` and `high` (mm): 2^40 pitches across the larger side, or as fine as
/// coordinates of this distance from the origin allow in double (2^-52 of it). Precondition: finite corners. Errors:
/// GeometryError where the extent is not between 1e-100 and 1e100 mm, or the part is farther from the origin than 2^28
/// times its extent.
[[nodiscard]] inline Grid make_grid(Point2 low, Point2 high) {
  const double extent = std::max(high.x - low.x, high.y - low.y);
  const double reach = std::max({std::fabs(low.x), std::fabs(low.y), std::fabs(high.x), std::fabs(high.y)});
  // mm; volumes of larger parts would not be finite, those of smaller ones not normal numbers.
  constexpr double kLargest = 1e100, kSmallest = 1e-100;
  if (!(extent > kSmallest) || !(reach < kLargest))
    throw GeometryError(Stage::Regions, -1, -1, "the slices have no extent in the plane, or no finite one");
  int extent_exponent = 0, reach_exponent = 0;
  std::frexp(extent, &extent_exponent);
  std::frexp(reach, &reach_exponent);
  // What is left of the 53 bits of a coordinate for the part itself must be enough for a mesh.
  constexpr int kFewestBits = 24;
  if (reach_exponent - extent_exponent > 52 - kFewestBits)
    throw GeometryError(Stage::Regions, -1, -1,
                        "the part is too far from the origin for its size: its coordinates have no digits left");
  Grid grid;
  grid.pitch = std::ldexp(1.0, std::max(extent_exponent - 40, reach_exponent - 52));
  grid.origin_x = round_to_step(static_cast<std::int64_t>(std::floor((low.x + high.x) / 2 / grid.pitch)));
  grid.origin_y = round_to_step(static_cast<std::int64_t>(std::floor((low.y + high.y) / 2 / grid.pitch)));
  return grid;
}

/// The place of a contour vertex `p` (mm) on the grid: the nearest multiple of kContourStep. Precondition: a finite
/// place within the extent for which the grid was made (not checked; `build_regions` checks its input).
[[nodiscard]] inline GridPoint to_grid(const Grid& grid, const Point2& p) {
  return {round_to_step(static_cast<std::int64_t>(std::floor(p.x / grid.pitch + 0.5)) - grid.origin_x),
          round_to_step(static_cast<std::int64_t>(std::floor(p.y / grid.pitch + 0.5)) - grid.origin_y)};
}

namespace detail {

/// What a closed loop means for the union of a slab.
struct Loop {
  std::int32_t region = 0;
  bool inner = false;
  bool support = false;  ///< a piece of a thickened line: crosses its neighbors by construction
};

/// The region of a face: the first one whose outer loops outnumber its inner ones there. Each loop counts once, however
/// often it winds: a loop that crosses itself bounds all that it surrounds.
inline std::int32_t region_of(const WindingState& state, const std::vector<Loop>& loops,
                              std::vector<std::int32_t>& balance, bool& overlap) {
  std::int32_t best = kNone;
  for (const EdgeTag& tag : state) {
    const Loop& loop = loops[static_cast<std::size_t>(tag.tag)];
    balance[static_cast<std::size_t>(loop.region)] += loop.inner ? -1 : 1;
  }
  for (const EdgeTag& tag : state) {
    const std::int32_t region = loops[static_cast<std::size_t>(tag.tag)].region;
    if (balance[static_cast<std::size_t>(region)] <= 0) continue;
    if (best != kNone && best != region) overlap = true;
    if (best == kNone || region < best) best = region;
  }
  for (const EdgeTag& tag : state)
    balance[static_cast<std::size_t>(loops[static_cast<std::size_t>(tag.tag)].region)] = 0;
  return best;
}

/// The outline between faces that have different labels. `poll` is called now and then.
inline Outline outline_of(const Arrangement& arrangement, const ArrangementFaces& faces,
                          const std::vector<std::int32_t>& label, const std::function<void()>& poll = {}) {
  Outline outline;
  outline.vertices = arrangement.vertices;
  Poll listen(poll, 1 << 16);
  for (std::size_t e = 0; e < arrangement.edges.size(); ++e) {
    listen();
    const std::int32_t left = label[static_cast<std::size_t>(faces.of_edge[e][0])];
    const std::int32_t right = label[static_cast<std::size_t>(faces.of_edge[e][1])];
    if (left != right) outline.edges.push_back({arrangement.edges[e].a, arrangement.edges[e].b, left, right});
  }
  normalize(outline, poll);
  return outline;
}

/// Reports contours that cross or run along each other; the union repairs them.
inline void report_defects(const std::vector<TaggedSegment>& segments, const std::vector<Loop>& loops,
                           std::int64_t layer, Diagnostics& diagnostics, const std::function<void()>& poll = {}) {
  std::vector<TaggedSegment> contours;
  Poll listen(poll, 1 << 16);
  for (const TaggedSegment& segment : segments) {
    listen();
    if (!loops[static_cast<std::size_t>(segment.tag)].support) contours.push_back(segment);
  }
  const Arrangement arrangement = snap_round(contours, {}, poll);
  if (arrangement.crossings > 0)
    diagnostics.add(Severity::Repair, Stage::Regions, "contours_cross",
                    "contours cross themselves or each other; united", layer, -1, arrangement.crossings);
  std::uint64_t coincident = 0;
  for (const Arrangement::Edge& edge : arrangement.edges) {
    listen();
    bool twice = edge.last_tag - edge.first_tag > 1;
    for (std::int32_t t = edge.first_tag; t < edge.last_tag; ++t) {
      const std::int32_t winding = arrangement.tags[static_cast<std::size_t>(t)].winding;
      twice = twice || (winding != 1 && winding != -1);
    }
    coincident += twice ? 1 : 0;
  }
  if (coincident > 0)
    diagnostics.add(Severity::Repair, Stage::Regions, "contours_coincide",
                    "edges of contours lie on each other; united", layer, -1, coincident);
}

/// Unites the loops of one slab. `poll` is called now and then.
inline Outline unite(const std::vector<TaggedSegment>& segments, const std::vector<Loop>& loops, std::size_t regions,
                     std::int64_t layer, Diagnostics& diagnostics, const std::function<void()>& poll = {}) {
  // What is nearer than the overlays of planes can tell apart is one here already: no sliver of a region may vanish
  // later.
  Attachment attachment;
  attachment.near = kAttachSteps * double(kContourStep);
  const Arrangement arrangement = snap_round(segments, attachment, poll);
  const ArrangementFaces faces = find_faces(arrangement, poll);
  std::vector<std::int32_t> label(faces.windings.size(), kNone), balance(regions, 0);
  bool overlap = false;
  Poll listen(poll, 1 << 14);
  for (std::size_t f = 0; f < label.size(); ++f) {
    listen(faces.windings[f].size() + 1);
    label[f] = region_of(faces.windings[f], loops, balance, overlap);
  }
  if (overlap)
    diagnostics.add(Severity::Repair, Stage::Regions, "regions_overlap",
                    "regions overlap; the object goes before supports, lower part ids before higher ones", layer);
  return outline_of(arrangement, faces, label, poll);
}

}  // namespace detail

/// The regions of all slabs: open lines thickened, all loops united.
///
/// The union is taken in exact integer arithmetic by snap rounding, after each input point has been rounded once to the
/// grid; loops may cross themselves and each other, coincide, or have no area. An inner loop cuts from the outer loops
/// of its own part id. Where regions overlap, the object goes before supports and lower part ids before higher ones.
/// Slabs without any area are dropped (diagnostic `empty_slab`).
/// Errors: GeometryError where nothing is left. Cost: O(n log n) per slab.
[[nodiscard]] inline LayerRegions build_regions(const SliceStack& stack, const SlabPlan& plan,
                                                const ThickenOptions& thicken_options, Diagnostics& diagnostics,
                                                const Progress& progress = {}) {
  LayerRegions result;
  result.z_convention = plan.convention;
  result.thickness = plan.thickness;
  detail::check_support_radii(thicken_options, plan.thickness);

  // Regions: objects by part id, then supports by part id.
  std::map<std::pair<int, std::int32_t>, std::int32_t> region_index;
  std::uint64_t left_out = 0;
  for (const Slab& slab : plan.slabs)
    for (const Polyline& line : stack.layers[static_cast<std::size_t>(slab.slice)].polylines) {
      const bool open = line.direction == Direction::Open;
      if (open && support_radius(thicken_options, line, slab.slice, plan.thickness) == 0) {
        ++left_out;
        continue;
      }
      region_index[{open ? 1 : 0, line.part}] = 0;
    }
  if (left_out > 0)
    diagnostics.add(Severity::Note, Stage::Regions, "supports_left_out",
                    "open lines are left out, since they are given no support radius", -1, -1, left_out);
  for (auto& [key, index] : region_index) {
    index = static_cast<std::int32_t>(result.regions.size());
    Region region;
    region.part = key.second;
    region.kind = key.first == 0 ? RegionKind::Part : RegionKind::Support;
    const auto label = stack.labels.find(key.second);
    const bool has_label = label != stack.labels.end() && !label->second.empty();
    region.name = has_label ? label->second + (key.first == 0 ? "" : "_support")
                            : (key.first == 0 ? "part_" : "support_") + std::to_string(key.second);
    result.regions.push_back(region);
  }

  // All loops in mm, then one grid for them.
  struct SlabLoops {
    std::vector<std::vector<Point2>> points;
    std::vector<detail::Loop> loops;
  };
  std::vector<SlabLoops> all(plan.slabs.size());
  Point2 low{HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL};
  for (std::size_t s = 0; s < plan.slabs.size(); ++s) {
    const std::int32_t slice = plan.slabs[s].slice;
    const std::vector<Polyline>& polylines = stack.layers[static_cast<std::size_t>(slice)].polylines;
    for (std::size_t k = 0; k < polylines.size(); ++k) {
      const Polyline& line = polylines[k];
      const bool open = line.direction == Direction::Open;
      const double radius = open ? support_radius(thicken_options, line, slice, plan.thickness) : 0;
      if (open && radius == 0) continue;
      std::vector<Point2> points;
      points.reserve(line.points.size());
      for (const Point2& p : line.points) {
        points.push_back({p.x * stack.unit, p.y * stack.unit});
        if (!std::isfinite(points.back().x) || !std::isfinite(points.back().y))
          throw GeometryError(Stage::Regions, slice, static_cast<std::int64_t>(k), "a coordinate is not finite");
      }
      if (points.empty()) continue;
      const detail::Loop loop{region_index[{open ? 1 : 0, line.part}], line.direction == Direction::Inner, open};
      std::vector<std::vector<Point2>> loops;
      if (open)
        loops = thicken(points, radius, thicken_options);
      else
        loops.push_back(std::move(points));
      for (std::vector<Point2>& l : loops) {
        for (const Point2& p : l) {
          low = {std::min(low.x, p.x), std::min(low.y, p.y)};
          high = {std::max(high.x, p.x), std::max(high.y, p.y)};
        }
        all[s].points.push_back(std::move(l));
        all[s].loops.push_back(loop);
      }
    }
  }
  if (!(low.x <= high.x))
    throw GeometryError(Stage::Regions, -1, -1, "no contour, and no open line with a support radius");
  result.grid = make_grid(low, high);

  for (std::size_t s = 0; s < plan.slabs.size(); ++s) {
    const std::function<void()> poll = [&] { report(progress, Stage::Regions, double(s) / double(plan.slabs.size())); };
    poll();
    std::vector<TaggedSegment> segments;
    std::vector<GridPoint> loop;
    detail::Poll listen(poll, 1 << 16);
    for (std::size_t l = 0; l < all[s].points.size(); ++l) {
      listen(all[s].points[l].size() + 1);
      loop.clear();
      for (const Point2& p : all[s].points[l]) loop.push_back(to_grid(result.grid, p));
      for (std::size_t i = 0; i < loop.size(); ++i)
        segments.push_back({loop[i], loop[(i + 1) % loop.size()], static_cast<std::int32_t>(l)});
    }
    detail::report_defects(segments, all[s].loops, plan.slabs[s].slice, diagnostics, poll);
    Outline outline =
        detail::unite(segments, all[s].loops, result.regions.size(), plan.slabs[s].slice, diagnostics, poll);
    all[s] = {};
    if (outline.empty()) {
      diagnostics.add(Severity::Warning, Stage::Regions, "empty_slab", "the slice has no area; its slab is left out",
                      plan.slabs[s].slice);
      continue;
    }
    result.slabs.push_back(plan.slabs[s]);
    result.outlines.push_back(std::move(outline));
  }
  report(progress, Stage::Regions, 1);
  if (result.slabs.empty()) throw GeometryError(Stage::Regions, -1, -1, "no slice has any area");
  return result;
}

}  // namespace slice2mesh
