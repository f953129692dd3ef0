// SPDX-License-Identifier: MIT
/// @file
/// @brief Contours take the way of a neighboring slab wherever their slices allow it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/arrange/segment_index.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/harmonize/outline_overlay.hpp"
#include "slice2mesh/harmonize/simplify.hpp"
#include "slice2mesh/harmonize/slice_nearness.hpp"

namespace slice2mesh::detail {

/// Shares of `reach`.
inline constexpr double kAdoptAttach = 0.05;  // the contour is led through vertices of the other one this near to it
inline constexpr double kAdoptResolution = 0.03;  // pieces of contours that are not split further
inline constexpr double kAdoptFar = 2;            // contours are within eps of their slices: 1.25 of the reach in use
/// Points of an edge, without its last one, that are asked for the nearest points of the slice.
inline constexpr int kAdoptPoints = 4;

/// `own` with the way of `other`, the contour of a slab next to it, in every pocket between the two where all of that
/// way is within `reach` of the slice, and the slice near the own way is within `reach` of it, as far as a few points
/// of every edge tell (the caller measures the result). The other pockets stay as they are. Lengths in pitches;
/// `regions`: how many there are. `slice` and `other_index` are those of the slice and of `other`. `poll` is called now
/// and then.
[[nodiscard]] inline Outline adopt_ways(const Outline& own, const Outline& other, const SegmentIndex& other_index,
                                        SliceNearness& slice, std::int32_t regions, double reach, double longest,
                                        const std::function<void()>& poll = {}) {
  Poll listen(poll, 1 << 14);  // items looked at
  const OutlineOverlay overlay(own, SegmentIndex(own, &listen), other, regions, kAdoptAttach * reach, poll);
  const Arrangement& arrangement = overlay.arrangement;
  const NearnessLimits limits{reach, reach, kAdoptResolution};
  const auto reaches = [&](const GridPoint& p) {
    const SegmentIndex& index = slice.index();
    const SegmentIndex::Nearest nearest = index.nearest(p, kAdoptFar * reach, &listen);
    return nearest.segment >= 0 &&
           other_index.is_within(index.closest_point(std::size_t(nearest.segment), p), reach, &listen);
  };
  std::vector<char> stays(overlay.faces.windings.size(), 0);  // of pockets
  for (std::size_t e = 0; e < arrangement.edges.size(); ++e) {
    listen();
    const bool own_edge = overlay.is_own_edge(e);
    if (own_edge == overlay.is_other_edge(e)) continue;
    const GridPoint &a = arrangement.vertices[std::size_t(arrangement.edges[e].a)],
                    &b = arrangement.vertices[std::size_t(arrangement.edges[e].b)];
    for (const std::int32_t f : overlay.faces.of_edge[e]) {
      if (!overlay.differs(f)) continue;
      char& flag = stays[std::size_t(overlay.pocket(f))];
      if (flag != 0) continue;
      bool good = own_edge ? reaches(b) : slice.is_near({a, b}, limits, &listen);
      for (int i = 0; own_edge && good && i < kAdoptPoints; ++i)
        good = reaches({a.x + (b.x - a.x) * i / kAdoptPoints, a.y + (b.y - a.y) * i / kAdoptPoints});
      flag = good ? 0 : 1;
    }
  }
  const auto is_adopted = [&](std::int32_t f) {
    return overlay.differs(f) && stays[std::size_t(overlay.pocket(f))] == 0;
  };
  if (std::none_of(overlay.faces.of_edge.begin(), overlay.faces.of_edge.end(),
                   [&](const auto& sides) { return is_adopted(sides[0]) || is_adopted(sides[1]); }))
    return own;
  const auto label_of = [&](std::int32_t f) {
    return (is_adopted(f) ? overlay.other_label : overlay.own_label)[std::size_t(f)];
  };
  std::vector<OutlinePiece> pieces;
  for (std::size_t e = 0; e < arrangement.edges.size(); ++e) {
    listen();
    const std::int32_t left = label_of(overlay.faces.of_edge[e][0]), right = label_of(overlay.faces.of_edge[e][1]);
    if (left != right)
      pieces.push_back({arrangement.edges[e].a, arrangement.edges[e].b, left, right, overlay.parent[e]});
  }
  Outline result;
  result.vertices = arrangement.vertices;
  for (const OutlinePiece& p : join_pieces(pieces, are_among(result.vertices, other.vertices, listen), poll))
    result.edges.push_back({p.a, p.b, p.left, p.right});
  simplify(result, {}, {double(kContourStep), 0, 0, longest}, poll);
  normalize(result, poll);
  return result;
}

}  // namespace slice2mesh::detail
