// SPDX-License-Identifier: MIT
/// @file
/// @brief Distances to an outline, and the deviation between two outlines.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/arrange/snap_rounding.hpp"
#include "slice2mesh/core/progress.hpp"

namespace slice2mesh::detail {

/// Segments in buckets, for distances of points to the nearest of them. Distances are in pitches, rounded: they serve
/// choices and measures, never topology.
class SegmentIndex {
public:
  SegmentIndex() : SegmentIndex(std::vector<std::pair<GridPoint, GridPoint>>{}) {}
  /// `listen` is called for what is worked on.
  explicit SegmentIndex(std::vector<std::pair<GridPoint, GridPoint>> segments, Poll* listen = nullptr)
      : segments_(std::move(segments)), buckets_{low(), high(), segments_.size()}, start_(buckets_.size() + 1, 0) {
    std::vector<std::size_t> cells, cells_of(1, 0);  // of one segment after the other
    for (const auto& [a, b] : segments_) {
      buckets_.for_each_on(a, b, 0, [&](std::size_t cell) {
        ++start_[cell + 1];
        cells.push_back(cell);
      });
      if (listen != nullptr) (*listen)(cells.size() - cells_of.back() + 1);
      cells_of.push_back(cells.size());
    }
    for (std::size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
    items_.resize(start_.back());
    boxes_.resize(start_.back());
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    for (std::size_t i = 0; i < segments_.size(); ++i) {
      const Box box = box_of(segments_[i]);
      if (listen != nullptr) (*listen)(cells_of[i + 1] - cells_of[i] + 1);
      for (std::size_t c = cells_of[i]; c < cells_of[i + 1]; ++c) {
        const std::size_t k = next[cells[c]]++;
        items_[k] = i;
        boxes_[k] = box;
      }
    }
  }
  explicit SegmentIndex(const Outline& outline, Poll* listen = nullptr) : SegmentIndex(segments_of(outline), listen) {}

  /// A distance and the segment it was measured to (-1: none within the limit).
  struct Nearest {
    double distance;
    std::ptrdiff_t segment;
  };

  /// The segment nearest to p among those nearer than `limit`; if there is none, `limit` and no segment. `listen` is
  /// told the segments looked at.
  [[nodiscard]] Nearest nearest(const GridPoint& p, double limit = std::numeric_limits<double>::infinity(),
                                Poll* listen = nullptr) const {
    Nearest best{limit, -1};
    if (segments_.empty()) return best;
    const GridPoint inside{std::clamp(p.x, low_.x, high_.x), std::clamp(p.y, low_.y, high_.y)};
    if ((inside == p ? 0 : std::hypot(double(p.x - inside.x), double(p.y - inside.y))) >= limit) return best;
    const GridPoint center = buckets_.nearest_to(p);
    const double x = double(p.x), y = double(p.y);
    double beyond = (limit + 1) * (limit + 1);  // see is_beyond
    const auto look = [&](std::size_t cell) {
      if (listen != nullptr) (*listen)(start_[cell + 1] - start_[cell] + 1);
      for (std::size_t i = start_[cell]; i < start_[cell + 1]; ++i) {
        if (is_beyond(boxes_[i], x, y, beyond)) continue;
        const double d = distance_to(items_[i], p);
        if (!(d < best.distance)) continue;
        best = {d, static_cast<std::ptrdiff_t>(items_[i])};
        beyond = (d + 1) * (d + 1);
      }
    };
    look(buckets_.at(center));
    for (std::int64_t ring = 1;; ++ring) {
      if (buckets_.distance_of_ring(p, center, ring) > best.distance) break;
      if (!buckets_.for_each_on_ring(p, center, ring, best.distance, look)) break;
    }
    return best;
  }
  [[nodiscard]] double distance(const GridPoint& p, double limit = std::numeric_limits<double>::infinity(),
                                Poll* listen = nullptr) const {
    return nearest(p, limit, listen).distance;
  }
  /// Is a segment nearer to p than `limit`? As `distance` tells it, which has to look further. `listen` is told the
  /// segments looked at.
  [[nodiscard]] bool is_within(const GridPoint& p, double limit, Poll* listen = nullptr) const {
    if (segments_.empty() || !(limit < double(kGridLimit))) return distance(p, limit, listen) < limit;
    const double x = double(p.x), y = double(p.y), beyond = (limit + 1) * (limit + 1);
    return buckets_.any_on(p, p, static_cast<std::int64_t>(std::ceil(limit)), [&](std::size_t cell) {
      if (listen != nullptr) (*listen)(start_[cell + 1] - start_[cell] + 1);
      for (std::size_t i = start_[cell]; i < start_[cell + 1]; ++i)
        if (!is_beyond(boxes_[i], x, y, beyond) && distance_to(items_[i], p) < limit) return true;
      return false;
    });
  }
  /// Calls f(segment) for the segments that are nearer than `pad` pitches to the segment ab, for some of them more than
  /// once, and perhaps for others near by.
  template <class F>
  void for_each_near(const GridPoint& a, const GridPoint& b, std::int64_t pad, F&& f) const {
    any_near(a, b, pad, [&](std::size_t segment) {
      f(segment);
      return false;
    });
  }
  /// The same until f returns true; tells whether it did.
  template <class F>
  bool any_near(const GridPoint& a, const GridPoint& b, std::int64_t pad, F&& f) const {
    if (segments_.empty()) return false;
    return buckets_.any_on(a, b, pad, [&](std::size_t cell) {
      for (std::size_t i = start_[cell]; i < start_[cell + 1]; ++i)
        if (f(items_[i])) return true;
      return false;
    });
  }
  [[nodiscard]] const std::pair<GridPoint, GridPoint>& segment(std::size_t i) const { return segments_[i]; }
  [[nodiscard]] double distance_to(std::size_t segment, const GridPoint& p) const {
    return segment_distance(p, segments_[segment].first, segments_[segment].second);
  }

  /// The point of a segment that is nearest to p, rounded.
  [[nodiscard]] GridPoint closest_point(std::size_t segment, const GridPoint& p) const {
    const GridPoint &a = segments_[segment].first, &b = segments_[segment].second;
    const double dx = double(b.x - a.x), dy = double(b.y - a.y), length2 = dx * dx + dy * dy;
    const double t =
        length2 > 0 ? std::clamp((double(p.x - a.x) * dx + double(p.y - a.y) * dy) / length2, 0.0, 1.0) : 0;
    return {a.x + std::llround(t * dx), a.y + std::llround(t * dy)};
  }

  static std::vector<std::pair<GridPoint, GridPoint>> segments_of(const Outline& outline) {
    std::vector<std::pair<GridPoint, GridPoint>> result;
    result.reserve(outline.edges.size());
    for (const Outline::Edge& e : outline.edges)
      result.emplace_back(outline.vertices[static_cast<std::size_t>(e.a)],
                          outline.vertices[static_cast<std::size_t>(e.b)]);
    return result;
  }

private:
  struct Box {
    double low_x, high_x, low_y, high_y;
  };
  [[nodiscard]] static Box box_of(const std::pair<GridPoint, GridPoint>& segment) {
    const auto& [a, b] = segment;
    return {double(std::min(a.x, b.x)), double(std::max(a.x, b.x)), double(std::min(a.y, b.y)),
            double(std::max(a.y, b.y))};
  }
  /// Is the box around a segment farther than some limit from the point x, y, and so the distance as rounded? `beyond`:
  /// the square of the limit and one pitch. The rounding of the distance is far below that pitch: coordinates are below
  /// 2^40, and its terms within 2^-50 of their values.
  [[nodiscard]] static bool is_beyond(const Box& box, double x, double y, double beyond) {
    const double u = std::max(box.low_x - x, x - box.high_x), v = std::max(box.low_y - y, y - box.high_y);
    return (u > 0 ? u * u : 0) + (v > 0 ? v * v : 0) > beyond;
  }
  GridPoint low() {
    low_ = segments_.empty() ? GridPoint{} : segments_.front().first;
    high_ = low_;
    for (const auto& [a, b] : segments_)
      for (const GridPoint& p : {a, b}) {
        low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y)};
        high_ = {std::max(high_.x, p.x), std::max(high_.y, p.y)};
      }
    return low_;
  }
  GridPoint high() const { return high_; }
  GridPoint low_, high_;
  std::vector<std::pair<GridPoint, GridPoint>> segments_;
  Buckets buckets_;
  std::vector<std::size_t> start_;
  std::vector<std::size_t> items_;
  std::vector<Box> boxes_;  // of the items
};

/// Largest distance of a point of the edges of `from` to the edges behind `to` (one-sided Hausdorff distance, in
/// pitches), as an upper bound that is exact up to `resolution` pitches. Cost: O(n log(length / resolution)) for near
/// outlines.
[[nodiscard]] inline double one_sided_deviation(const Outline& from, const SegmentIndex& to, double resolution,
                                                const std::function<void()>& poll = {}) {
  using Nearest = SegmentIndex::Nearest;
  struct Piece {
    GridPoint a, b;
    Nearest na, nb;
  };
  // What some point has, and what no point exceeds. Pieces are judged by the first: errors do not add up.
  double worst = 0, bounded = 0;
  std::vector<Piece> stack;
  constexpr double kAny = std::numeric_limits<double>::infinity();
  std::vector<Nearest> at(from.vertices.size(), {kAny, -1});
  Poll listen(poll, 1 << 14);  // segments looked at
  // Of what is not beyond the worst so far any segment will do, and that of a neighbor often does.
  const auto look = [&](const GridPoint& p, std::ptrdiff_t hint) {
    if (hint >= 0) {
      const double d = to.distance_to(static_cast<std::size_t>(hint), p);
      if (d <= worst) return Nearest{d, hint};
    }
    const Nearest n = to.nearest(p, kAny, &listen);
    worst = std::max(worst, n.distance);
    return n;
  };
  for (const Outline::Edge& e : from.edges) {
    listen();
    const auto a = static_cast<std::size_t>(e.a), b = static_cast<std::size_t>(e.b);
    if (at[a].segment < 0) at[a] = look(from.vertices[a], at[b].segment);
    if (at[b].segment < 0) at[b] = look(from.vertices[b], at[a].segment);
  }
  for (const Outline::Edge& e : from.edges) {
    stack.push_back({from.vertices[static_cast<std::size_t>(e.a)], from.vertices[static_cast<std::size_t>(e.b)],
                     at[static_cast<std::size_t>(e.a)], at[static_cast<std::size_t>(e.b)]});
    while (!stack.empty()) {
      listen(16);
      const Piece p = stack.back();
      stack.pop_back();
      // Along the piece the distance has slope at most one, and the distance to one segment is convex.
      const double length = detail::distance(p.a, p.b);
      double bound = (p.na.distance + p.nb.distance + length) / 2;
      if (p.na.segment >= 0 && p.nb.segment >= 0) {
        bound = std::min(bound, std::max(p.na.distance, to.distance_to(static_cast<std::size_t>(p.na.segment), p.b)));
        if (p.na.segment != p.nb.segment)
          bound = std::min(bound, std::max(p.nb.distance, to.distance_to(static_cast<std::size_t>(p.nb.segment), p.a)));
      }
      if (bound <= worst) continue;
      if (bound <= worst + resolution || length <= 2) {
        bounded = std::max(bounded, bound);
        continue;
      }
      const GridPoint m{p.a.x + (p.b.x - p.a.x) / 2, p.a.y + (p.b.y - p.a.y) / 2};
      const Nearest nm = look(m, p.na.distance < p.nb.distance ? p.na.segment : p.nb.segment);
      stack.push_back({p.a, m, p.na, nm});
      stack.push_back({m, p.b, nm, p.nb});
    }
  }
  return std::max(worst, bounded);
}

/// Hausdorff distance of two outlines in pitches, both ways; `b_index` is that of `b`. `poll` is called now and then.
[[nodiscard]] inline double deviation(const Outline& a, const Outline& b, const SegmentIndex& b_index,
                                      double resolution, const std::function<void()>& poll = {}) {
  if (a.empty() || b.empty()) return a.empty() && b.empty() ? 0 : std::numeric_limits<double>::infinity();
  Poll listen(poll, 1 << 14);
  return std::max(one_sided_deviation(a, b_index, resolution, poll),
                  one_sided_deviation(b, SegmentIndex(a, &listen), resolution, poll));
}
[[nodiscard]] inline double deviation(const Outline& a, const Outline& b, double resolution,
                                      const std::function<void()>& poll = {}) {
  Poll listen(poll, 1 << 14);
  return deviation(a, b, SegmentIndex(b, &listen), resolution, poll);
}

}  // namespace slice2mesh::detail
