// SPDX-License-Identifier: MIT
/// @file
/// @brief Interface planes: the contour of the slab below, lifted, over the contour of the slab above.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/faces.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/arrange/snap_rounding.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/core/short_number.hpp"
#include "slice2mesh/core/slab.hpp"
#include "slice2mesh/harmonize/harmonize.hpp"

namespace slice2mesh {

/// One plane with the overlay of both contours. This is the paper's lifting data (Algorithm 1): `below_image[v]` is
/// where vertex v of the slab below comes to lie, `below_path[e]` are the splits of its edge e at the slab's top;
/// `above_*` the same for the slab above and its bottom.
struct InterfacePlane {
  double z = 0;  ///< mm, its height
  /// Index of the slab below, or kNone.
  std::int32_t slab_below = kNone;
  /// Index of the slab above, or kNone.
  std::int32_t slab_above = kNone;
  Arrangement overlay;                     ///< vertices and edges of both contours
  std::vector<std::array<Side, 2>> left;   ///< #E by 2: cell below and cell above the face on the left of edge a -> b
  std::vector<std::array<Side, 2>> right;  ///< #E by 2: the same on the right
  std::vector<std::int32_t> below_image;   ///< #V of the outline below: index of the vertex of the overlay
  /// #V of the outline above: index of the vertex of the overlay.
  std::vector<std::int32_t> above_image;
  std::vector<std::vector<std::int32_t>>
      below_path;  ///< #E of the outline below: indices of vertices of the overlay, a to b
  /// #E of the outline above: indices of vertices of the overlay, a to b.
  std::vector<std::vector<std::int32_t>> above_path;
};

/// What a face with these cells below and above is; `Wall` stands for neither (no facet).
[[nodiscard]] constexpr FacetLabel classify(const Side& below, const Side& above) noexcept {
  if (below.slab == kNone) return above.slab == kNone ? FacetLabel::Wall : FacetLabel::Down;
  return above.slab == kNone ? FacetLabel::Up : FacetLabel::Interface;
}

/// The planes of a stack of `slabs` (#S, lowest first): #P by 2, indices of the slab below and the slab above (kNone:
/// none), lowest first; #S + 1 where all slabs touch, one more for each gap. `slab_planes` becomes #S by 2: indices of
/// the bottom and the top plane of each slab. Cost: linear.
[[nodiscard]] inline std::vector<std::pair<std::int32_t, std::int32_t>> plane_slabs(
    const std::vector<Slab>& slabs, std::vector<std::array<std::int32_t, 2>>& slab_planes) {
  std::vector<std::pair<std::int32_t, std::int32_t>> planes;  // slab below, slab above
  slab_planes.assign(slabs.size(), {kNone, kNone});
  for (std::size_t s = 0; s < slabs.size(); ++s) {
    const auto i = static_cast<std::int32_t>(s);
    if (detail::lies_on_last(slabs, s))
      planes.back().second = i;
    else
      planes.emplace_back(kNone, i);
    slab_planes[s][0] = static_cast<std::int32_t>(planes.size()) - 1;
    planes.emplace_back(i, kNone);
    slab_planes[s][1] = static_cast<std::int32_t>(planes.size()) - 1;
  }
  return planes;
}

namespace detail {

/// Throws TetrahedralizationError where two edges of the outline of `slab` have a piece of their `paths` through the
/// overlay in common: something of the slice that is thinner than the overlay tells apart has vertices of the other
/// contour of the plane beside it, and both of its sides were led through them. The walls on it would stand in one
/// place.
inline void require_distinct_paths(const Contours& contours, const InterfacePlane& plane, std::int32_t slab,
                                   const std::vector<std::vector<std::int32_t>>& paths,
                                   const std::function<void()>& poll) {
  Poll listen(poll, 1 << 16);
  std::vector<std::pair<std::int32_t, std::int32_t>> pieces;
  for (const std::vector<std::int32_t>& path : paths) {
    listen(path.size());
    for (std::size_t i = 0; i + 1 < path.size(); ++i)
      pieces.emplace_back(std::min(path[i], path[i + 1]), std::max(path[i], path[i + 1]));
  }
  sort_listening(pieces.begin(), pieces.end(), listen);
  const auto twice = std::adjacent_find(pieces.begin(), pieces.end());
  if (twice == pieces.end()) return;
  const GridPoint& at = plane.overlay.vertices[static_cast<std::size_t>(twice->first)];
  throw TetrahedralizationError(slab,
                                "something thinner than the planes can tell apart touches the contour of a slab "
                                "next to it near " +
                                    place_text(contours.grid, at));
}

/// The overlay of one plane with images and paths, but without the cells on the sides of the edges.
[[nodiscard]] inline InterfacePlane lift_edges(const Contours& contours, std::int32_t slab_below,
                                               std::int32_t slab_above, const std::function<void()>& poll = {}) {
  InterfacePlane plane;
  plane.slab_below = slab_below;
  plane.slab_above = slab_above;
  plane.z = slab_below != kNone ? contours.slabs[static_cast<std::size_t>(slab_below)].z_high
                                : contours.slabs[static_cast<std::size_t>(slab_above)].z_low;
  const auto regions = static_cast<std::int32_t>(contours.regions.size());
  static const Outline nothing;
  const Outline& below = slab_below != kNone ? contours.outlines[static_cast<std::size_t>(slab_below)] : nothing;
  const Outline& above = slab_above != kNone ? contours.outlines[static_cast<std::size_t>(slab_above)] : nothing;
  std::vector<TaggedSegment> segments;
  append_segments(below, 0, segments);
  append_segments(above, regions, segments);
  Attachment attachment;
  attachment.near = kAttachSteps * double(kContourStep);
  plane.overlay = snap_round(segments, attachment, poll);
  std::size_t segment = 0;
  Poll listen(poll, 1 << 16);
  const auto follow = [&](const Outline& outline, std::vector<std::int32_t>& image,
                          std::vector<std::vector<std::int32_t>>& paths) {
    image.assign(outline.vertices.size(), kNone);
    for (const Outline::Edge& e : outline.edges) {
      // The first of the edge's segments runs from a to b where there is a region on the left, else from b to a.
      std::vector<std::int32_t> path = plane.overlay.path(segment);
      listen(path.size());
      if (e.left == kNone) std::reverse(path.begin(), path.end());
      segment += static_cast<std::size_t>((e.left != kNone) + (e.right != kNone));
      image[static_cast<std::size_t>(e.a)] = path.front();
      image[static_cast<std::size_t>(e.b)] = path.back();
      paths.push_back(std::move(path));
    }
  };
  follow(below, plane.below_image, plane.below_path);
  follow(above, plane.above_image, plane.above_path);
  return plane;
}

}  // namespace detail

/// The overlay of the plane between the slabs of index `slab_below` and `slab_above` (kNone: none on that side; not
/// both). A pure function of the two contours. Preconditions: they are those of `harmonize`, and the indices are slabs
/// of theirs (not checked). `poll` is called now and then; what it throws ends the work. Errors:
/// TetrahedralizationError where something of a slice is so thin that it vanishes in the plane; those of `poll`. Cost:
/// O(n log n).
[[nodiscard]] inline InterfacePlane lift(const Contours& contours, std::int32_t slab_below, std::int32_t slab_above,
                                         const std::function<void()>& poll = {}) {
  InterfacePlane plane = detail::lift_edges(contours, slab_below, slab_above, poll);
  detail::require_distinct_paths(contours, plane, slab_below, plane.below_path, poll);
  detail::require_distinct_paths(contours, plane, slab_above, plane.above_path, poll);
  const auto regions = static_cast<std::int32_t>(contours.regions.size());
  const ArrangementFaces faces = find_faces(plane.overlay, poll);

  std::vector<std::array<Side, 2>> cells(faces.windings.size());
  detail::Poll listen(poll, 1 << 16);
  for (std::size_t f = 0; f < cells.size(); ++f) {
    listen(faces.windings[f].size() + 1);
    for (const EdgeTag& tag : faces.windings[f]) {
      if (tag.winding <= 0) continue;
      Side& side = cells[f][tag.tag < regions ? 0 : 1];
      const std::int32_t region = tag.tag < regions ? tag.tag : tag.tag - regions;
      if (side.slab != kNone && side.region <= region) continue;
      side = {tag.tag < regions ? slab_below : slab_above, region};
    }
  }
  for (const auto& sides : faces.of_edge) {
    listen();
    plane.left.push_back(cells[static_cast<std::size_t>(sides[0])]);
    plane.right.push_back(cells[static_cast<std::size_t>(sides[1])]);
  }
  return plane;
}

}  // namespace slice2mesh
