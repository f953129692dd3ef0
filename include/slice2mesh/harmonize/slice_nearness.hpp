// SPDX-License-Identifier: MIT
/// @file
/// @brief Does a contour that changes in one place keep its distance from its slice?
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/arrange/segment_index.hpp"
#include "slice2mesh/core/progress.hpp"

namespace slice2mesh::detail {

/// How near is near enough.
struct NearnessLimits {
  double deviation = 0;  ///< pitches: no contour gets farther than this from its slice, nor its slice from it ...
  double most = 0;       ///< pitches: ... or than this where the slice is farther than that before
  double resolution =
      0;  ///< share of the limit: pieces of contours that are not split further; half of it is the error
};

/// The slice of a slab, asked about changes of the contour of that slab.
class SliceNearness {
public:
  using Edge = std::pair<GridPoint, GridPoint>;

  /// `listen` is called for what is worked on.
  explicit SliceNearness(const Outline& slice, Poll* listen = nullptr) : slice_(slice, listen) {}

  [[nodiscard]] const SegmentIndex& index() const { return slice_; }

  /// Is every point of an edge of the contour near to the slice?
  [[nodiscard]] bool is_near(const Edge& edge, const NearnessLimits& limits, Poll* listen) {
    const double limit = limits.deviation;
    pieces_.clear();
    pieces_.push_back({edge.first, edge.second, slice_.nearest(edge.first, limit, listen),
                       slice_.nearest(edge.second, limit, listen)});
    if (pieces_[0].na.segment < 0 || pieces_[0].nb.segment < 0) return false;
    while (!pieces_.empty()) {
      const Piece p = pieces_.back();
      pieces_.pop_back();
      // The distance to one segment is convex along the piece.
      if (slice_.distance_to(std::size_t(p.na.segment), p.b) <= limit) continue;
      if (slice_.distance_to(std::size_t(p.nb.segment), p.a) <= limit) continue;
      if (distance(p.a, p.b) <= limits.resolution * limit) continue;
      const GridPoint m = middle(p.a, p.b);
      const SegmentIndex::Nearest nm = slice_.nearest(m, limit, listen);
      if (nm.segment < 0) return false;
      pieces_.push_back({p.a, m, p.na, nm});
      pieces_.push_back({m, p.b, nm, p.nb});
    }
    return true;
  }

  /// Is all of the slice that the edges `old` were near to, near to the edges `now`? `now` has the edges in the place
  /// of the old ones, and all others of the contour that may be near to the same parts of the slice.
  [[nodiscard]] bool stays_covered(const std::vector<Edge>& old, const std::vector<Edge>& now,
                                   const NearnessLimits& limits, Poll* listen) {
    const auto wide = std::int64_t(std::ceil(limits.most)) + 1;
    // No part of what is farther than this is asked about: parts that are not split further reach half of their length
    // beyond `most`.
    const auto beyond = std::int64_t(std::ceil((1 + limits.resolution) * limits.most)) + 2;
    seen_.clear();
    for (const Edge& edge : old)
      slice_.for_each_near(edge.first, edge.second, wide, [&](std::size_t f) {
        const auto& [a, b] = slice_.segment(f);
        if (apart(a.x, b.x, edge.first.x, edge.second.x) > beyond) return;
        if (apart(a.y, b.y, edge.first.y, edge.second.y) > beyond) return;
        seen_.push_back(f);
      });
    std::sort(seen_.begin(), seen_.end());
    seen_.erase(std::unique(seen_.begin(), seen_.end()), seen_.end());
    return std::all_of(seen_.begin(), seen_.end(), [&](std::size_t f) {
      if (listen != nullptr) (*listen)(old.size() + now.size());
      return is_covered(slice_.segment(f), old, now, limits);
    });
  }

private:
  struct Piece {
    GridPoint a, b;
    SegmentIndex::Nearest na, nb;
  };
  /// Distance between the stretches from a to b and from c to d; negative where they overlap.
  [[nodiscard]] static std::int64_t apart(std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t d) {
    return std::max(std::min(a, b), std::min(c, d)) - std::min(std::max(a, b), std::max(c, d));
  }
  [[nodiscard]] static GridPoint middle(const GridPoint& a, const GridPoint& b) {
    return {a.x + (b.x - a.x) / 2, a.y + (b.y - a.y) / 2};
  }
  [[nodiscard]] bool is_covered(const Edge& segment, const std::vector<Edge>& old, const std::vector<Edge>& now,
                                const NearnessLimits& limits) {
    parts_.assign(1, segment);
    while (!parts_.empty()) {
      const GridPoint a = parts_.back().first, b = parts_.back().second;
      parts_.pop_back();
      const double length = distance(a, b);
      const GridPoint m = middle(a, b);
      double before = HUGE_VAL;
      for (const Edge& e : old) before = std::min(before, segment_distance(m, e.first, e.second));
      if (before - length / 2 > limits.most) continue;
      const double limit = before > limits.deviation ? limits.most : limits.deviation;
      const auto far = std::int64_t(limit) + 2;  // the distance is not rounded by as much as a pitch
      const auto covers = [&](const Edge& e) {
        if (apart(e.first.x, e.second.x, a.x, a.x) > far || apart(e.first.y, e.second.y, a.y, a.y) > far) return false;
        return segment_distance(a, e.first, e.second) <= limit && segment_distance(b, e.first, e.second) <= limit;
      };
      // What covers one part covers the next one, most likely.
      if (last_ < now.size() && covers(now[last_])) continue;
      const auto found = std::find_if(now.begin(), now.end(), covers);
      last_ = std::size_t(found - now.begin());
      if (found != now.end()) continue;
      if (length <= limits.resolution * limit) return false;
      parts_.emplace_back(a, m);
      parts_.emplace_back(m, b);
    }
    return true;
  }

  SegmentIndex slice_;
  std::vector<Piece> pieces_;
  std::vector<Edge> parts_;
  std::vector<std::size_t> seen_;
  std::size_t last_ = 0;  // the edge that covered a part last
};

}  // namespace slice2mesh::detail
