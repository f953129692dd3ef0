// SPDX-License-Identifier: MIT
/// @file
/// @brief Outlines in which no vertex is so near to an edge that the overlay of a plane would put it there.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

#include "slice2mesh/arrange/faces.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/arrange/segment_index.hpp"
#include "slice2mesh/arrange/snap_rounding.hpp"
#include "slice2mesh/regions/regions.hpp"

namespace slice2mesh::detail {

/// Pitches. So near a vertex may not come to an edge: some steps more than what the overlays attach, for the rounding
/// when edges are split.
inline constexpr double kBeside = (kAttachSteps + 2) * double(kContourStep);

/// Does an edge have its ends, for `vertices_beside_edges`?
enum class EdgeEnds : std::uint8_t { Without, With };

/// The vertices from `first` on that are within `near` pitches of an edge, with or without its ends, that does not end
/// in them.
[[nodiscard]] inline std::vector<std::int32_t> vertices_beside_edges(const Outline& outline, double near,
                                                                     const std::function<void()>& poll = {},
                                                                     std::size_t first = 0,
                                                                     EdgeEnds ends = EdgeEnds::Without) {
  std::vector<std::int32_t> result;
  if (first >= outline.vertices.size()) return result;
  Poll listen(poll, 1 << 14);
  const SegmentIndex index(outline, &listen);
  const auto pad = static_cast<std::int64_t>(near) + 1;
  for (std::size_t v = first; v < outline.vertices.size(); ++v) {
    const GridPoint& p = outline.vertices[v];
    const bool found = index.any_near(p, p, pad, [&](std::size_t e) {
      listen();
      const Outline::Edge& edge = outline.edges[e];
      if (edge.a == std::int32_t(v) || edge.b == std::int32_t(v)) return false;
      const GridPoint &a = outline.vertices[std::size_t(edge.a)], &b = outline.vertices[std::size_t(edge.b)];
      return (ends == EdgeEnds::With || (dot(a, b, p) > 0 && dot(b, a, p) > 0)) && segment_distance(p, a, b) <= near;
    });
    if (found) result.push_back(std::int32_t(v));
  }
  return result;
}

/// Leads edges through the vertices that they pass more closely than the overlay of a plane can tell apart; a sliver of
/// a region between them vanishes. Otherwise it would vanish in one or both planes of the slab, and two walls would
/// stand in one place. Most outlines stay as they are. `regions`: how many there are. `poll` is called now and then.
inline void attach_vertices(Outline& outline, std::int32_t regions, const std::function<void()>& poll = {}) {
  constexpr int kRounds = 4;  // an edge that is led through a vertex may come near to the next one
  for (int round = 0; round < kRounds && !vertices_beside_edges(outline, kBeside, poll).empty(); ++round) {
    std::vector<TaggedSegment> segments;
    append_segments(outline, 0, segments);
    Attachment attachment;
    attachment.near = kBeside;
    const Arrangement arrangement = snap_round(segments, attachment, poll);
    const ArrangementFaces faces = find_faces(arrangement, poll);
    std::vector<std::int32_t> label(faces.windings.size(), kNone);
    Poll listen(poll, 1 << 14);
    for (std::size_t f = 0; f < label.size(); ++f) {
      listen(faces.windings[f].size() + 1);
      for (const EdgeTag& tag : faces.windings[f])
        if (tag.winding > 0 && tag.tag < regions && (label[f] == kNone || tag.tag < label[f])) label[f] = tag.tag;
    }
    outline = outline_of(arrangement, faces, label, poll);
  }
}

}  // namespace slice2mesh::detail
