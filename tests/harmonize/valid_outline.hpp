// SPDX-License-Identifier: MIT
/// @file
/// @brief Is an outline one of regions that do not overlap?
#pragma once

#include <vector>

#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/arrange/snap_rounding.hpp"
#include "test_support.hpp"
#include "triangulate/flooded_faces.hpp"

namespace slice2mesh_test {

/// No crossings, no vertex on an edge, edges that separate something, and the regions of every vertex close up.
inline void check_valid(const slice2mesh::Outline& outline) {
  using namespace slice2mesh;
  std::vector<TaggedSegment> segments;
  detail::append_segments(outline, 0, segments);
  const Arrangement again = snap_round(segments);
  REQUIRE(again.crossings == 0);
  REQUIRE(again.vertices == outline.vertices);
  REQUIRE(again.edges.size() == outline.edges.size());
  const ArrangementFaces faces = flooded_faces(again);
  for (const WindingState& state : faces.windings) {
    REQUIRE(state.size() <= 1);
    for (const EdgeTag& tag : state) REQUIRE(tag.winding == 1);
  }
  for (const Outline::Edge& e : outline.edges) REQUIRE(e.left != e.right);
}

}  // namespace slice2mesh_test
