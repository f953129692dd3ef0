// SPDX-License-Identifier: MIT
/// @file
/// @brief Contours that are led half the way to where the next slices go, so that they can stay for longer.
#pragma once

#include <cmath>
#include <cstdint>
#include <deque>
#include <functional>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/arrange/segment_index.hpp"
#include "slice2mesh/core/slab.hpp"
#include "slice2mesh/harmonize/merge.hpp"
#include "slice2mesh/regions/regions.hpp"

namespace slice2mesh::detail {

/// The input outlines of the next slabs, with their indices; made once each, as long as they are needed.
class SlabsAhead {
public:
  explicit SlabsAhead(const LayerRegions& input) : input_(input) {}
  /// How many slabs above s are looked at.
  static constexpr std::size_t kMost = 16;

  struct Ahead {
    const Outline& outline;
    const SegmentIndex& index;
  };
  /// The m-th slab above s (1 and up); nothing if there is none or a gap is in between. `listen` is told the work.
  [[nodiscard]] const SegmentIndex* index(std::size_t s, std::size_t m, Poll& listen) {
    while (first_ <= s && !indices_.empty()) {
      indices_.pop_front();
      ++first_;
    }
    if (indices_.empty()) first_ = s + 1;
    while (first_ + indices_.size() <= s + m) {
      const std::size_t next = first_ + indices_.size();
      if (next >= input_.slabs.size()) return nullptr;
      indices_.emplace_back(input_.outlines[next], &listen);
    }
    for (std::size_t t = s; t < s + m; ++t)
      if (!lies_on_last(input_.slabs, t + 1)) return nullptr;
    return &indices_[s + m - first_];
  }
  [[nodiscard]] const Outline& outline(std::size_t s, std::size_t m) const { return input_.outlines[s + m]; }

private:
  const LayerRegions& input_;
  std::deque<SegmentIndex> indices_;
  std::size_t first_ = 0;
};

/// Where a contour has to leave the one below, it may as well go further: to the middle between its slice and the last
/// of the next slices that is not more than twice `reach` away. All of the slices in between are then within `reach`,
/// and the contours of their slabs can be this one: differences between contours become fewer and wider.
/// Vertices nearer than `width` to the contour below stay. Lengths in pitches. `s`: the slab of `outline`. `poll` is
/// called now and then.
inline void anticipate(Outline& outline, const SegmentIndex* below, SlabsAhead& ahead, std::size_t s, double width,
                       double reach, const std::function<void()>& poll = {}) {
  EdgesAt edges_at(outline);
  // Does the segment run the same way as one of the edges at v, with the same regions?
  const auto matches = [&](std::size_t v, const Outline& other, std::size_t segment) {
    const Outline::Edge& f = other.edges[segment];
    const GridPoint &c = other.vertices[std::size_t(f.a)], &d = other.vertices[std::size_t(f.b)];
    const double fx = double(d.x - c.x), fy = double(d.y - c.y);
    for (const std::int32_t k : edges_at[v]) {
      const Outline::Edge& e = outline.edges[std::size_t(k)];
      const GridPoint &a = outline.vertices[std::size_t(e.a)], &b = outline.vertices[std::size_t(e.b)];
      const double ex = double(b.x - a.x), ey = double(b.y - a.y);
      const double along = (ex * fx + ey * fy) / (std::hypot(ex, ey) * std::hypot(fx, fy));
      constexpr double kSameWay = 0.7;  // cosine
      if (along > kSameWay && e.left == f.left && e.right == f.right) return true;
      if (along < -kSameWay && e.left == f.right && e.right == f.left) return true;
    }
    return false;
  };
  std::vector<VertexMove> moves;
  Poll listen(poll, 256);
  for (std::size_t v = 0; v < outline.vertices.size(); ++v) {
    listen();
    const GridPoint p = outline.vertices[v];
    const double from_below = below ? below->distance(p, 4 * width) : HUGE_VAL;
    if (edges_at[v].empty() || from_below < width) continue;
    GridPoint target = p;
    for (std::size_t m = 1; m <= SlabsAhead::kMost; ++m) {
      listen();
      const SegmentIndex* index = ahead.index(s, m, listen);
      if (index == nullptr) break;
      const SegmentIndex::Nearest nearest = index->nearest(p, 2 * reach);
      if (nearest.segment < 0 || !matches(v, ahead.outline(s, m), std::size_t(nearest.segment))) break;
      target = contour_point_between(p, index->closest_point(std::size_t(nearest.segment), p), 0.5);
    }
    if (target == p) continue;
    // Not back to where the contour below is.
    if (below && below->distance(target, 4 * width) < from_below) continue;
    moves.push_back({distance(p, target), std::int32_t(v), target});
  }
  move_vertices(outline, std::move(moves), poll);
}

}  // namespace slice2mesh::detail
