// SPDX-License-Identifier: MIT
/// @file
/// @brief Arrangement of segments with vertices on the grid: snap rounding.
///
/// Crossings are found and rounded in exact integer arithmetic. A grid cell that holds an end point or a crossing is
/// *hot*, and every segment that passes through a hot cell is led through its center. The result has no crossings and
/// no vertex on an edge, whatever the input; no point moves by more than half a cell in x and in y.
/// Source: Hobby, "Practical segment intersection with finite precision output", Comput. Geom. 13 (1999) 199-214;
/// Guibas, Marimont, "Rounding arrangements dynamically", SCG 1995.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/arrange/numbers.hpp"
#include "slice2mesh/core/grid.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/progress.hpp"

namespace slice2mesh {

/// A directed segment with a mark that it hands on to all of its pieces.
struct TaggedSegment {
  /// First end.
  GridPoint from;
  /// Second end.
  GridPoint to;
  /// The mark: any number.
  std::int32_t tag = 0;
};

/// How often and in which direction (+1: from the lower to the higher vertex index, -1: back) pieces of a tag run over
/// an edge.
struct EdgeTag {
  /// The mark of the segments: any number.
  std::int32_t tag = 0;
  /// Number of pieces in the one direction less that in the other.
  std::int32_t winding = 0;
};

/// A planar straight-line graph: edges meet in common vertices only.
struct Arrangement {
  /// An edge with the marks of the segments that run over it.
  struct Edge {
    std::int32_t a = 0;  ///< index of the lexicographically smaller vertex
    /// Index of the other vertex.
    std::int32_t b = 0;
    std::int32_t first_tag = 0;  ///< index in `tags`: its marks are those of [first_tag, last_tag)
    /// Index of the end of the range, see `first_tag`.
    std::int32_t last_tag = 0;
  };
  std::vector<GridPoint> vertices;  ///< #V, lexicographically sorted, all different
  std::vector<Edge> edges;          ///< #E, sorted by (a, b), all different
  std::vector<EdgeTag> tags;  ///< entries per edge, sorted by tag; pieces that cancel out keep an entry with winding 0
  std::size_t crossings = 0;  ///< number of pairs of input segments that cross in their interiors

  /// The vertices along the input segment of index `segment`, ends included, in its direction: one index per vertex;
  /// none for a segment of zero length. Precondition: there is such a segment (not checked).
  [[nodiscard]] std::vector<std::int32_t> path(std::size_t segment) const {
    const std::int32_t k = segment_chain[segment];
    if (k == -1) return {};
    const auto c = static_cast<std::size_t>(k >= 0 ? k : -2 - k);
    std::vector<std::int32_t> result(chains.begin() + chain_start[c], chains.begin() + chain_start[c + 1]);
    if (k < 0) std::reverse(result.begin(), result.end());
    return result;
  }

  std::vector<std::int32_t>
      segment_chain;  ///< one per input segment: index k of its chain as k, backward as -2 - k; -1: none
  std::vector<std::int32_t> chain_start;  ///< #C + 1 offsets into `chains`
  std::vector<std::int32_t>
      chains;  ///< indices of vertices along the different input segments, as many as `chain_start` ends with
};

namespace detail {

/// x / cell, rounded down, without the slow division of integers. Coordinates are far below 2^52, so that the product
/// with `inverse`, 1 / cell, is less than one away from the quotient, and its rest says on which side.
[[nodiscard]] inline std::int64_t floor_quotient(std::int64_t x, std::int64_t cell, double inverse) {
  const auto quotient = static_cast<std::int64_t>(double(x) * inverse);
  const std::int64_t rest = x - quotient * cell;
  return rest < 0 ? quotient - 1 : (rest >= cell ? quotient + 1 : quotient);
}

/// A uniform grid of buckets over a bounding box, for segments and points.
class Buckets {
public:
  Buckets(GridPoint low, GridPoint high, std::size_t expected) : low_(low) {
    const double width = double(high.x - low.x) + 1, height = double(high.y - low.y) + 1;
    const double count = std::max<double>(1, double(expected));
    // Square cells, about one per item; long thin boxes get a single row or column of them.
    double cell = std::max(std::sqrt(width * height / count), std::max(width, height) / (4 * count));
    cell_ = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(cell)));
    inverse_ = 1 / double(cell_);
    columns_ = (high.x - low.x) / cell_ + 1;
    rows_ = (high.y - low.y) / cell_ + 1;
  }
  /// How many buckets to ask for, for `count` segments that are `length` pitches long in all: contours are lines in an
  /// area, and leave most buckets empty. So they may be as small as segments are long, with up to kMost per segment.
  [[nodiscard]] static std::size_t for_segments(const GridPoint& low, const GridPoint& high, std::size_t count,
                                                double length) {
    constexpr double kMost = 4;
    const double mean = std::max(1.0, length / std::max<double>(1, double(count)));
    const double fitting = (double(high.x - low.x) + 1) / mean * ((double(high.y - low.y) + 1) / mean);
    return static_cast<std::size_t>(std::clamp(fitting, double(count), kMost * double(count)));
  }
  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(columns_ * rows_); }
  [[nodiscard]] std::size_t of(const GridPoint& p) const { return index(cell_of(p.x - low_.x), cell_of(p.y - low_.y)); }
  /// Calls f(bucket) for all buckets that the segment, widened by `pad` pitches, touches (and perhaps a few more).
  template <class F>
  void for_each_on(const GridPoint& a, const GridPoint& b, std::int64_t pad, F&& f) const {
    any_on(a, b, pad, [&](std::size_t bucket) {
      f(bucket);
      return false;
    });
  }
  /// The same until f returns true; tells whether it did.
  template <class F>
  bool any_on(const GridPoint& a, const GridPoint& b, std::int64_t pad, F&& f) const {
    const GridPoint& bottom = a.y <= b.y ? a : b;
    const GridPoint& top = a.y <= b.y ? b : a;
    const std::int64_t row0 = clamp((bottom.y - pad - low_.y), rows_), row1 = clamp((top.y + pad - low_.y), rows_);
    const double slope =
        top.y > bottom.y ? double(top.x - bottom.x) / double(top.y - bottom.y) : 0;  // change of x per unit of y
    const std::int64_t xmin = std::min(a.x, b.x), xmax = std::max(a.x, b.x);
    for (std::int64_t row = row0; row <= row1; ++row) {
      std::int64_t x0 = xmin, x1 = xmax;
      if (row1 > row0 && top.y > bottom.y) {
        // The part of the segment between the lines y0 and y1; one more pitch covers the rounding of the products. A
        // nearly horizontal segment has a slope whose products leave the range of integers: they are clamped first.
        const double y0 = double(low_.y + row * cell_ - bottom.y) - double(pad) - 1;
        const double y1 = y0 + double(cell_) + 2 * double(pad) + 2;
        const auto clamped = [&](double x) { return std::clamp(x, double(xmin) - 2, double(xmax) + 2); };
        const double u = clamped(double(bottom.x) + slope * y0), v = clamped(double(bottom.x) + slope * y1);
        x0 = std::max(xmin, static_cast<std::int64_t>(std::floor(std::min(u, v))) - 1);
        x1 = std::min(xmax, static_cast<std::int64_t>(std::ceil(std::max(u, v))) + 1);
        if (x0 > x1) x0 = x1 = std::clamp(x0, xmin, xmax);
      }
      const std::int64_t column0 = clamp(x0 - pad - low_.x, columns_), column1 = clamp(x1 + pad - low_.x, columns_);
      for (std::int64_t column = column0; column <= column1; ++column)
        if (f(index(column, row))) return true;
    }
    return false;
  }

  [[nodiscard]] std::int64_t cell() const { return cell_; }
  /// Column and row of the bucket nearest to p.
  [[nodiscard]] GridPoint nearest_to(const GridPoint& p) const {
    return {clamp(p.x - low_.x, columns_), clamp(p.y - low_.y, rows_)};
  }
  /// The bucket in a column (x) and a row (y).
  [[nodiscard]] std::size_t at(const GridPoint& bucket) const { return index(bucket.x, bucket.y); }
  /// No bucket of the ring around `nearest` (see `nearest_to`), or of a wider one, is nearer to p than this.
  [[nodiscard]] double distance_of_ring(const GridPoint& p, const GridPoint& nearest, std::int64_t ring) const {
    const std::int64_t x = p.x - low_.x - nearest.x * cell_, y = p.y - low_.y - nearest.y * cell_;
    // From a point outside of all buckets: at least from its nearest one.
    if (x < 0 || y < 0 || x > cell_ || y > cell_) return double(ring - 1) * double(cell_);
    return double(ring - 1) * double(cell_) + double(std::min({x, y, cell_ - x, cell_ - y}));
  }
  /// Calls f(bucket) for the buckets at distance `ring` (in buckets, Chebyshev) from the one nearest to p (see
  /// `nearest_to`) that are not farther than `limit` pitches from p, which f may change; false if there are none in
  /// that ring.
  template <class F>
  bool for_each_on_ring(const GridPoint& p, const GridPoint& nearest, std::int64_t ring, const double& limit,
                        F&& f) const {
    const std::int64_t column = nearest.x, row = nearest.y;
    const std::int64_t c0 = std::max<std::int64_t>(0, column - ring), c1 = std::min(columns_ - 1, column + ring);
    const auto distance_along = [&](std::int64_t offset, std::int64_t k) {  // to the stretch of column or row k
      return double(std::max({std::int64_t(0), k * cell_ - offset, offset - (k + 1) * cell_}));
    };
    bool any = false;
    for (std::int64_t r = std::max<std::int64_t>(0, row - ring); r <= std::min(rows_ - 1, row + ring); ++r) {
      const double dy = distance_along(p.y - low_.y, r);
      const auto offer = [&](std::int64_t c) {
        any = true;
        const double dx = distance_along(p.x - low_.x, c);
        if (dx * dx + dy * dy <= limit * limit) f(index(c, r));
      };
      if (r == row - ring || r == row + ring) {
        for (std::int64_t c = c0; c <= c1; ++c) offer(c);
      } else {
        if (column - ring >= 0) offer(column - ring);
        if (column + ring < columns_ && ring > 0) offer(column + ring);
      }
    }
    return any;
  }

private:
  [[nodiscard]] std::size_t index(std::int64_t column, std::int64_t row) const {
    return static_cast<std::size_t>(row * columns_ + column);
  }
  [[nodiscard]] std::int64_t clamp(std::int64_t offset, std::int64_t cells) const {
    return offset < 0 ? 0 : std::min(cell_of(offset), cells - 1);
  }
  [[nodiscard]] std::int64_t cell_of(std::int64_t offset) const { return floor_quotient(offset, cell_, inverse_); }
  GridPoint low_;
  std::int64_t cell_ = 1;
  double inverse_ = 1;  // of cell_
  std::int64_t columns_ = 1;
  std::int64_t rows_ = 1;
};

/// Does the closed segment ab meet the half-open cell [-1/2, 1/2)^2 around c? Exact.
[[nodiscard]] inline bool meets_cell(const GridPoint& a, const GridPoint& b, const GridPoint& c) noexcept {
  if (std::min(a.x, b.x) > c.x || std::max(a.x, b.x) < c.x) return false;
  if (std::min(a.y, b.y) > c.y || std::max(a.y, b.y) < c.y) return false;
  const std::int64_t dx = b.x - a.x, dy = b.y - a.y;
  const Int128 center = 2 * (Int128(dx) * (c.y - a.y) - Int128(dy) * (c.x - a.x));
  bool left = false, right = false;
  for (int sx = -1; sx <= 1; sx += 2) {
    for (int sy = -1; sy <= 1; sy += 2) {
      const Int128 value = center + Int128(dx) * sy - Int128(dy) * sx;
      int side = sign(value);
      // The upper and right borders do not belong to the cell: these corners stand infinitesimally inside.
      if (side == 0) side = sign(Int128(sx > 0 ? dy : 0) - (sy > 0 ? dx : 0));
      if (side == 0) return true;
      (side > 0 ? left : right) = true;
    }
  }
  return left && right;
}

[[nodiscard]] constexpr Int128 floor_div(Int128 n, Int128 d) noexcept {
  const Int128 q = n / d;
  return (n % d != 0 && ((n < 0) != (d < 0))) ? q - 1 : q;
}

/// The center of the cell that holds the proper crossing of ab and cd.
[[nodiscard]] inline GridPoint rounded_crossing(const GridPoint& a, const GridPoint& b, const GridPoint& c,
                                                const GridPoint& d) noexcept {
  const std::int64_t dx = b.x - a.x, dy = b.y - a.y, ex = d.x - c.x, ey = d.y - c.y;
  Int128 den = Int128(dx) * ey - Int128(dy) * ex;
  Int128 num = Int128(c.x - a.x) * ey - Int128(c.y - a.y) * ex;
  if (den < 0) {
    den = -den;
    num = -num;
  }
  const auto round_half_up = [&](std::int64_t delta) {
    return static_cast<std::int64_t>(floor_div(2 * (num * delta) + den, 2 * den));
  };
  return {a.x + round_half_up(dx), a.y + round_half_up(dy)};
}

}  // namespace detail

namespace detail {

/// Snap rounding in cells of one unit. `poll` is called now and then.
[[nodiscard]] inline Arrangement snap_round_unit(const std::vector<TaggedSegment>& segments,
                                                 const std::function<void()>& poll = {}) {
  using detail::Buckets;
  Poll listen(poll, 1 << 16);  // items looked at
  Arrangement result;
  std::vector<GridPoint>& hot = result.vertices;
  result.segment_chain.assign(segments.size(), -1);
  std::vector<std::array<std::int32_t, 2>> ends_of(segments.size(), {-1, -1});  // by the index in `hot`
  {
    Numbers<GridPoint> numbers(2 * segments.size());
    for (std::size_t i = 0; i < segments.size(); ++i) {
      listen();
      if (segments[i].from != segments[i].to) ends_of[i] = {numbers.of(segments[i].from), numbers.of(segments[i].to)};
    }
    const std::vector<GridPoint>& points = numbers.keys();
    std::vector<std::int32_t> order(points.size()), rank(points.size());
    std::iota(order.begin(), order.end(), 0);
    sort_listening(order.begin(), order.end(), listen, [&](std::int32_t u, std::int32_t v) {
      return points[static_cast<std::size_t>(u)] < points[static_cast<std::size_t>(v)];
    });
    hot.reserve(points.size());
    for (const std::int32_t v : order) {
      listen();
      rank[static_cast<std::size_t>(v)] = static_cast<std::int32_t>(hot.size());
      hot.push_back(points[static_cast<std::size_t>(v)]);
    }
    for (auto& ends : ends_of) {
      listen();
      for (std::int32_t& v : ends) v = v < 0 ? v : rank[static_cast<std::size_t>(v)];
    }
  }
  if (hot.empty()) return result;
  GridPoint low = hot.front(), high = hot.front();
  for (const GridPoint& p : hot) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }

  // Different segments by their ends (direction aside): a segment that stands twice has the same pieces.
  struct Key {
    GridPoint a, b;
  };
  std::vector<Key> keys;
  std::vector<std::int32_t> key_of(segments.size(), -1);
  {
    std::vector<std::pair<std::uint64_t, std::int32_t>> sorted;
    sorted.reserve(segments.size());
    for (std::size_t i = 0; i < segments.size(); ++i) {
      listen();
      const auto [a, b] = ends_of[i];
      if (a >= 0) sorted.emplace_back(packed(std::min(a, b), std::max(a, b)), static_cast<std::int32_t>(i));
    }
    sort_listening(sorted.begin(), sorted.end(), listen);
    for (std::size_t i = 0; i < sorted.size(); ++i) {
      listen();
      const auto& [ends, segment] = sorted[i];
      if (i == 0 || ends != sorted[i - 1].first)
        keys.push_back({hot[static_cast<std::size_t>(ends >> 32)], hot[static_cast<std::size_t>(ends & 0xFFFFFFFFU)]});
      key_of[static_cast<std::size_t>(segment)] = static_cast<std::int32_t>(keys.size()) - 1;
    }
  }

  double length = 0;
  for (const Key& s : keys) {
    listen();
    length += detail::distance(s.a, s.b);
  }
  const Buckets buckets(low, high, Buckets::for_segments(low, high, keys.size(), length));
  std::vector<std::int32_t> start(buckets.size() + 1, 0), items;
  std::vector<std::pair<std::size_t, std::int32_t>> cells;
  const auto fill = [&](std::size_t count, auto&& visit) {
    std::fill(start.begin(), start.end(), 0);
    cells.clear();
    for (std::size_t i = 0; i < count; ++i)
      visit(i, [&](std::size_t cell) {
        ++start[cell + 1];
        cells.emplace_back(cell, static_cast<std::int32_t>(i));
        listen();
      });
    for (std::size_t c = 1; c < start.size(); ++c) start[c] += start[c - 1];
    items.assign(static_cast<std::size_t>(start.back()), 0);
    std::vector<std::int32_t> next(start.begin(), start.end() - 1);
    for (const auto& [cell, i] : cells) {
      items[static_cast<std::size_t>(next[cell]++)] = i;
      listen();
    }
  };
  fill(keys.size(), [&](std::size_t i, auto&& put) { buckets.for_each_on(keys[i].a, keys[i].b, 0, put); });

  // Proper crossings; all other contacts are at end points, whose cells are hot already.
  struct Pair {
    std::int32_t i, j;
    bool operator<(const Pair& o) const { return i != o.i ? i < o.i : j < o.j; }
    bool operator==(const Pair& o) const { return i == o.i && j == o.j; }
  };
  std::vector<Pair> pairs;
  for (std::size_t cell = 0; cell + 1 < start.size(); ++cell) {
    for (auto i = start[cell]; i < start[cell + 1]; ++i) {
      const Key& s = keys[static_cast<std::size_t>(items[static_cast<std::size_t>(i)])];
      const std::int64_t s_low = std::min(s.a.y, s.b.y), s_high = std::max(s.a.y, s.b.y);
      listen(static_cast<std::size_t>(start[cell + 1] - i));
      for (auto j = i + 1; j < start[cell + 1]; ++j) {
        const Key& t = keys[static_cast<std::size_t>(items[static_cast<std::size_t>(j)])];
        if (t.a.x > s.b.x || s.a.x > t.b.x) continue;
        if (std::min(t.a.y, t.b.y) > s_high || std::max(t.a.y, t.b.y) < s_low) continue;
        const int o1 = detail::orientation(s.a, s.b, t.a), o2 = detail::orientation(s.a, s.b, t.b);
        if (o1 * o2 >= 0) continue;
        const int o3 = detail::orientation(t.a, t.b, s.a), o4 = detail::orientation(t.a, t.b, s.b);
        if (o3 * o4 >= 0) continue;
        pairs.push_back({items[static_cast<std::size_t>(i)], items[static_cast<std::size_t>(j)]});
      }
    }
  }
  sort_listening(pairs.begin(), pairs.end(), listen);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  result.crossings = pairs.size();
  for (const Pair& p : pairs) {
    listen();
    const Key &s = keys[static_cast<std::size_t>(p.i)], &t = keys[static_cast<std::size_t>(p.j)];
    hot.push_back(detail::rounded_crossing(s.a, s.b, t.a, t.b));
  }
  if (!pairs.empty()) {
    sort_listening(hot.begin(), hot.end(), listen);
    hot.erase(std::unique(hot.begin(), hot.end()), hot.end());
  }

  // Lead each segment through the hot cells on its way.
  fill(hot.size(), [&](std::size_t i, auto&& put) { put(buckets.of(hot[i])); });
  struct Piece {
    std::uint64_t ends;  // the smaller index first
    std::int32_t tag, winding;
    bool operator<(const Piece& o) const { return ends != o.ends ? ends < o.ends : tag < o.tag; }
  };
  std::vector<std::int32_t>&chain_start = result.chain_start, &chain = result.chains;
  chain_start.assign(keys.size() + 1, 0);
  {
    std::vector<std::int32_t> on;
    for (std::size_t k = 0; k < keys.size(); ++k) {
      const Key& s = keys[k];
      on.clear();
      buckets.for_each_on(s.a, s.b, 1, [&](std::size_t cell) {
        listen(static_cast<std::size_t>(start[cell + 1] - start[cell]) + 1);
        for (auto i = start[cell]; i < start[cell + 1]; ++i) {
          const std::int32_t v = items[static_cast<std::size_t>(i)];
          if (detail::meets_cell(s.a, s.b, hot[static_cast<std::size_t>(v)])) on.push_back(v);
        }
      });
      sort_listening(on.begin(), on.end(), listen);
      on.erase(std::unique(on.begin(), on.end()), on.end());
      // Two are the ends, in order. By the projection on the segment; the index settles ties, which can only be between
      // cells that touch.
      if (on.size() > 2)
        sort_listening(on.begin(), on.end(), listen, [&](std::int32_t u, std::int32_t v) {
          const detail::Int128 du = detail::dot(s.a, s.b, hot[static_cast<std::size_t>(u)]);
          const detail::Int128 dv = detail::dot(s.a, s.b, hot[static_cast<std::size_t>(v)]);
          return du != dv ? du < dv : u < v;
        });
      chain.insert(chain.end(), on.begin(), on.end());
      chain_start[k + 1] = static_cast<std::int32_t>(chain.size());
    }
  }
  std::vector<Piece> pieces;
  pieces.reserve(chain.size() + segments.size());
  for (std::size_t index = 0; index < segments.size(); ++index) {
    const TaggedSegment& segment = segments[index];
    listen();
    if (segment.from == segment.to) continue;
    const bool forward = segment.from < segment.to;
    const auto k = static_cast<std::size_t>(key_of[index]);
    result.segment_chain[index] = forward ? static_cast<std::int32_t>(k) : -2 - static_cast<std::int32_t>(k);
    for (auto i = chain_start[k]; i + 1 < chain_start[k + 1]; ++i) {
      std::int32_t a = chain[static_cast<std::size_t>(i)], b = chain[static_cast<std::size_t>(i + 1)];
      std::int32_t winding = forward ? 1 : -1;
      if (a > b) {
        std::swap(a, b);
        winding = -winding;
      }
      pieces.push_back({packed(a, b), segment.tag, winding});
    }
  }
  sort_listening(pieces.begin(), pieces.end(), listen);
  for (std::size_t i = 0; i < pieces.size();) {
    listen();
    const std::uint64_t ends = pieces[i].ends;
    Arrangement::Edge edge{static_cast<std::int32_t>(ends >> 32), static_cast<std::int32_t>(ends & 0xFFFFFFFFU),
                           static_cast<std::int32_t>(result.tags.size()), 0};
    std::size_t j = i;
    while (j < pieces.size() && pieces[j].ends == ends) {
      EdgeTag tag{pieces[j].tag, 0};
      for (; j < pieces.size() && pieces[j].ends == ends && pieces[j].tag == tag.tag; ++j)
        tag.winding += pieces[j].winding;
      result.tags.push_back(tag);
    }
    edge.last_tag = static_cast<std::int32_t>(result.tags.size());
    result.edges.push_back(edge);
    i = j;
  }
  return result;
}

}  // namespace detail

/// End points within so many steps (of kContourStep pitches) of another segment are taken to lie on it.
inline constexpr double kAttachSteps = 64;

/// Which vertices segments are led through although they do not meet their cells.
struct Attachment {
  double near = 0;  ///< every segment goes through every end point this near to it; in pitches
  std::vector<GridPoint>
      strong;              ///< any number of points: segments with a tag below `strong_tags` go through these too ...
  double strong_near = 0;  ///< ... where they are this near, in pitches, if no other segment is equal to them
  /// Limit of the tags, see `strong`.
  std::int32_t strong_tags = 0;
};

/// The snap-rounded arrangement of any number of `segments`, in cells of kContourStep; zero-length ones are dropped.
///
/// An end point that lies just beside another segment makes a crossing that is rounded to a cell beside the end point's
/// own. To keep such twins out, segments are first led through the points that `attachment` names. Precondition:
/// coordinates are multiples of kContourStep within kGridLimit (not checked here; `to_grid` sees to it). `poll` is
/// called now and then; what it throws ends the work. Cost: O(n log n + k) for evenly spread segments with k crossings.
[[nodiscard]] inline Arrangement snap_round(const std::vector<TaggedSegment>& segments,
                                            const Attachment& attachment = {}, const std::function<void()>& poll = {}) {
  using detail::Buckets;
  detail::Poll listen(poll, 1 << 16);  // items looked at
  std::vector<TaggedSegment> pieces;
  std::vector<std::size_t> first_piece;
  pieces.reserve(segments.size());
  std::vector<GridPoint> ends;
  std::vector<std::array<std::int32_t, 2>> segment_ends;
  const double reach = std::max(attachment.near, attachment.strong_near);
  std::vector<std::uint32_t> start, items;
  std::size_t weak = 0;
  GridPoint low, high;
  double length = 0;
  if (reach > 0 && !segments.empty()) {
    detail::Numbers<GridPoint> numbers(2 * segments.size());
    for (const TaggedSegment& s : segments) {
      listen();
      length += detail::distance(s.from, s.to);
      segment_ends.push_back({numbers.of(s.from), numbers.of(s.to)});
    }
    ends = numbers.keys();
    weak = ends.size();
    ends.insert(ends.end(), attachment.strong.begin(), attachment.strong.end());
    low = high = ends.front();
    for (const GridPoint& p : ends) {
      listen();
      low = {std::min(low.x, p.x), std::min(low.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
  }
  const Buckets buckets(low, high, Buckets::for_segments(low, high, ends.size(), length));
  if (!ends.empty()) {
    start.assign(buckets.size() + 1, 0);
    for (const GridPoint& p : ends) {
      listen();
      ++start[buckets.of(p) + 1];
    }
    for (std::size_t c = 1; c < start.size(); ++c) start[c] += start[c - 1];
    items.resize(ends.size());
    std::vector<std::uint32_t> next(start.begin(), start.end() - 1);
    for (std::size_t i = 0; i < ends.size(); ++i) {
      listen();
      items[next[buckets.of(ends[i])]++] = static_cast<std::uint32_t>(i);
    }
  }
  // Segments with the same ends take the same way, which is looked for once. What is a segment of the others already
  // keeps to itself: near it are other parts of theirs.
  struct Way {
    std::size_t first = SIZE_MAX, last = 0;  // in `ways`
    bool is_other = false;
  };
  std::vector<Way> way_of;
  std::vector<std::int32_t> number_of(segments.size(), 0);
  std::vector<std::size_t> ways, on;
  if (!ends.empty()) {
    detail::Numbers<std::uint64_t> numbers(segments.size());
    for (std::size_t s = 0; s < segments.size(); ++s) {
      listen();
      const auto [u, v] = segment_ends[s];
      number_of[s] = numbers.of(detail::packed(std::min(u, v), std::max(u, v)));
      if (static_cast<std::size_t>(number_of[s]) == way_of.size()) way_of.emplace_back();
      if (segments[s].tag >= attachment.strong_tags) way_of[static_cast<std::size_t>(number_of[s])].is_other = true;
    }
  }
  const auto scaled = [](const GridPoint& p) { return GridPoint{p.x / kContourStep, p.y / kContourStep}; };
  for (std::size_t index = 0; index < segments.size(); ++index) {
    const TaggedSegment& s = segments[index];
    first_piece.push_back(pieces.size());
    GridPoint last = s.from;
    const auto go_to = [&](const GridPoint& p) {
      if (p != last) pieces.push_back({scaled(last), scaled(p), s.tag});
      last = p;
    };
    if (!ends.empty() && s.from != s.to) {
      Way& way = way_of[static_cast<std::size_t>(number_of[index])];
      const GridPoint& origin = std::min(s.from, s.to);
      const GridPoint& far = std::max(s.from, s.to);
      if (way.first == SIZE_MAX) {
        on.clear();
        const auto pad = static_cast<std::int64_t>(reach) + 1;
        const GridPoint box_low{origin.x - pad, std::min(s.from.y, s.to.y) - pad};
        const GridPoint box_high{far.x + pad, std::max(s.from.y, s.to.y) + pad};
        buckets.for_each_on(origin, far, pad, [&](std::size_t cell) {
          listen(start[cell + 1] - start[cell] + 1);
          for (std::size_t i = start[cell]; i < start[cell + 1]; ++i) {
            const GridPoint& p = ends[items[i]];
            if (p.x < box_low.x || p.x > box_high.x || p.y < box_low.y || p.y > box_high.y) continue;
            if (p == origin || p == far) continue;
            const bool is_strong = items[i] >= weak;
            if (is_strong && way.is_other) continue;
            if (detail::dot(origin, far, p) <= 0 || detail::dot(far, origin, p) <= 0) continue;
            if (detail::segment_distance(p, origin, far) <= (is_strong ? attachment.strong_near : attachment.near))
              on.push_back(items[i]);
          }
        });
        detail::sort_listening(on.begin(), on.end(), listen, [&](std::size_t i, std::size_t j) {
          const detail::Int128 di = detail::dot(origin, far, ends[i]), dj = detail::dot(origin, far, ends[j]);
          return di != dj ? di < dj : ends[i] < ends[j];
        });
        way.first = ways.size();
        ways.insert(ways.end(), on.begin(), on.end());
        way.last = ways.size();
      }
      listen(way.last - way.first);
      // In the order of the canonical direction, so that a segment and its reverse take the same way.
      if (origin == s.from)
        for (std::size_t i = way.first; i < way.last; ++i) go_to(ends[ways[i]]);
      else
        for (std::size_t i = way.last; i-- > way.first;) go_to(ends[ways[i]]);
    }
    pieces.push_back({scaled(last), scaled(s.to), s.tag});
  }
  first_piece.push_back(pieces.size());
  Arrangement result = detail::snap_round_unit(pieces, poll);
  for (GridPoint& p : result.vertices) p = {p.x * kContourStep, p.y * kContourStep};
  // Chains of the segments from those of their pieces.
  Arrangement chained;
  chained.chain_start.push_back(0);
  for (std::size_t s = 0; s < segments.size(); ++s) {
    bool any = false;
    for (std::size_t p = first_piece[s]; p < first_piece[s + 1]; ++p) {
      const std::int32_t k = result.segment_chain[p];
      if (k == -1) continue;
      const auto c = static_cast<std::size_t>(k >= 0 ? k : -2 - k);
      const std::int32_t begin = result.chain_start[c], end = result.chain_start[c + 1];
      listen(static_cast<std::size_t>(end - begin) + 1);
      for (std::int32_t i = any ? 1 : 0; i < end - begin; ++i)  // from its first vertex, or the one after it
        chained.chains.push_back(result.chains[static_cast<std::size_t>(k >= 0 ? begin + i : end - 1 - i)]);
      any = true;
    }
    chained.segment_chain.push_back(any ? static_cast<std::int32_t>(chained.chain_start.size()) - 1 : -1);
    if (any) chained.chain_start.push_back(static_cast<std::int32_t>(chained.chains.size()));
  }
  result.chains = std::move(chained.chains);
  result.chain_start = std::move(chained.chain_start);
  result.segment_chain = std::move(chained.segment_chain);
  return result;
}

}  // namespace slice2mesh
