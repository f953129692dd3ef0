// SPDX-License-Identifier: MIT
/// @file
/// @brief Fewer vertices on an outline, within a tolerance and without changing its topology.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <queue>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/arrange/snap_rounding.hpp"
#include "slice2mesh/core/progress.hpp"

namespace slice2mesh::detail {

/// Lengths in pitches.
struct SimplifyLimits {
  double tolerance = 0;   ///< a vertex may go if all that was dropped stays this near to the new edge
  double short_edge = 0;  ///< edges below this length are worth `short_tolerance`
  double short_tolerance = 0;
  double longest = HUGE_VAL;  ///< no new edge is longer than this
};

/// Vertices that stand in cells, for "is there a vertex in this triangle".
class VertexIndex {
public:
  /// `cell`: pitches; about the distance of vertices along the outline. Smaller cells are used where outlines lie side
  /// by side so densely that there would be many vertices in one.
  VertexIndex(const std::vector<GridPoint>& vertices, double cell) {
    GridPoint low{kGridLimit, kGridLimit}, high{-kGridLimit, -kGridLimit};
    for (const GridPoint& p : vertices) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
    const double area = vertices.empty() ? 0 : (double(high.x - low.x) + 1) * (double(high.y - low.y) + 1);
    const double dense = std::sqrt(area / double(vertices.size() + 1));
    cell_ = std::max<std::int64_t>(1, std::int64_t(std::min(cell, dense)));
    inverse_ = 1 / double(cell_);
    std::size_t buckets = 16;
    while (buckets < vertices.size()) buckets *= 2;
    mask_ = buckets - 1;
    start_.assign(buckets + 1, 0);
    const auto bucket_of = [&](const GridPoint& p) { return bucket(cell_of(p.x), cell_of(p.y)); };
    for (const GridPoint& p : vertices) ++start_[bucket_of(p) + 1];
    for (std::size_t k = 0; k < buckets; ++k) start_[k + 1] += start_[k];
    items_.resize(vertices.size());
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    for (std::size_t v = 0; v < vertices.size(); ++v) items_[next[bucket_of(vertices[v])]++] = std::int32_t(v);
  }
  /// Calls f(vertex) for the vertices in a box (and others) until it returns true; tells whether it did.
  template <class F>
  bool any_in_box(const GridPoint& low, const GridPoint& high, F&& f) const {
    const std::int64_t c0 = cell_of(low.x), c1 = cell_of(high.x), r0 = cell_of(low.y), r1 = cell_of(high.y);
    if (is_large(c0, c1, r0, r1)) return any(f);
    for (std::int64_t r = r0; r <= r1; ++r)
      if (any_in_row(r, c0, c1, f)) return true;
    return false;
  }
  /// The same for a triangle, which may be flat.
  template <class F>
  bool any_in_triangle(const std::array<GridPoint, 3>& corners, F&& f) const {
    const auto [low_x, high_x] = std::minmax({corners[0].x, corners[1].x, corners[2].x});
    const auto [low_y, high_y] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
    const std::int64_t c0 = cell_of(low_x), c1 = cell_of(high_x), r0 = cell_of(low_y), r1 = cell_of(high_y);
    if (c0 == c1 || r0 == r1 || double(r1 - r0) > double(items_.size()))
      return any_in_box({low_x, low_y}, {high_x, high_y}, f);
    double cells = 0;  // looked at; never many more than there are vertices
    for (std::int64_t r = r0; r <= r1; ++r) {
      // The stretch of x over which the edges are in this row.
      const double bottom = double(r) * double(cell_), top = bottom + double(cell_);
      double low = double(high_x), high = double(low_x);
      for (std::size_t i = 0; i < 3; ++i) {
        const GridPoint &a = corners[i], &b = corners[(i + 1) % 3];
        const double ax = double(a.x), ay = double(a.y), bx = double(b.x), by = double(b.y);
        if (std::max(ay, by) < bottom || std::min(ay, by) > top) continue;
        for (const double y : {std::max(bottom, std::min(ay, by)), std::min(top, std::max(ay, by))}) {
          const double x = ay == by ? ax : ax + (y - ay) / (by - ay) * (bx - ax);
          low = std::min({low, x, ay == by ? bx : x});
          high = std::max({high, x, ay == by ? bx : x});
        }
      }
      constexpr std::int64_t kRounding = 2;  // pitches; the products above are exact to a thousandth of one
      const std::int64_t first = std::max(c0, cell_of(std::int64_t(std::floor(low)) - kRounding)),
                         last = std::min(c1, cell_of(std::int64_t(std::ceil(high)) + kRounding));
      cells += double(last - first + 1);
      if (cells > double(items_.size()) + 16) return any(f);
      if (any_in_row(r, first, last, f)) return true;
    }
    return false;
  }

private:
  [[nodiscard]] std::int64_t cell_of(std::int64_t x) const { return floor_quotient(x, cell_, inverse_); }
  [[nodiscard]] std::size_t bucket(std::int64_t c, std::int64_t r) const { return GridHash{}({c, r}) & mask_; }
  [[nodiscard]] bool is_large(std::int64_t c0, std::int64_t c1, std::int64_t r0, std::int64_t r1) const {
    return double(c1 - c0 + 1) * double(r1 - r0 + 1) > double(items_.size()) + 16;
  }
  template <class F>
  bool any(F&& f) const {
    for (const std::int32_t v : items_)
      if (f(v)) return true;
    return false;
  }
  template <class F>
  bool any_in_row(std::int64_t r, std::int64_t c0, std::int64_t c1, F&& f) const {
    for (std::int64_t c = c0; c <= c1; ++c) {
      const std::size_t k = bucket(c, r);
      for (std::size_t i = start_[k]; i < start_[k + 1]; ++i)
        if (f(items_[i])) return true;
    }
    return false;
  }
  std::int64_t cell_ = 1;
  double inverse_ = 1;  // of cell_
  std::size_t mask_ = 0;
  std::vector<std::size_t> start_;  // by bucket of the hash of a cell
  std::vector<std::int32_t> items_;
};

/// Is there no vertex but u, v, w in the closed triangle u, v, w (or on the segment, if it is flat)? Exact. `skip(x)`
/// tells vertices that do not count.
template <class Skip>
[[nodiscard]] bool triangle_is_empty(const VertexIndex& index, const std::vector<GridPoint>& points, std::int32_t u,
                                     std::int32_t v, std::int32_t w, Skip&& skip) {
  const GridPoint pu = points[std::size_t(u)], pv = points[std::size_t(v)], pw = points[std::size_t(w)];
  const int turn = orientation(pu, pv, pw);
  const GridPoint low{std::min({pu.x, pv.x, pw.x}), std::min({pu.y, pv.y, pw.y})};
  const GridPoint high{std::max({pu.x, pv.x, pw.x}), std::max({pu.y, pv.y, pw.y})};
  return !index.any_in_triangle({pu, pv, pw}, [&](std::int32_t x) {
    if (x == u || x == v || x == w || skip(x)) return false;
    const GridPoint& p = points[std::size_t(x)];
    if (p.x < low.x || p.x > high.x || p.y < low.y || p.y > high.y) return false;
    const int a = orientation(pu, pv, p), b = orientation(pv, pw, p), c = orientation(pw, pu, p);
    if (turn == 0) return a == 0 && b == 0 && c == 0;
    return a * turn >= 0 && b * turn >= 0 && c * turn >= 0;
  });
}

/// Removes vertices of degree two, the least important first. `fixed` (#V, may be empty) vertices stay. No edge of the
/// result crosses another: a vertex goes only if the triangle it spans with its neighbors holds no other vertex
/// (exact). Source: Visvalingam, Whyatt, "Line generalisation by repeated elimination of points", Cartogr. J. 30
/// (1993), with the distance of all dropped points to the new edge as measure. `poll` is called now and then.
inline void simplify(Outline& outline, const std::vector<char>& fixed, const SimplifyLimits& limits,
                     const std::function<void()>& poll = {}) {
  const std::size_t count = outline.vertices.size();
  if (count < 4) return;
  Poll listen(poll, 1 << 14);
  EdgesAt edges_at(outline);
  double length = 0;
  for (const Outline::Edge& e : outline.edges) {
    listen();
    length +=
        distance(outline.vertices[static_cast<std::size_t>(e.a)], outline.vertices[static_cast<std::size_t>(e.b)]);
  }
  const VertexIndex index(outline.vertices, std::max(1.0, length / double(outline.edges.size())));
  std::vector<std::vector<std::int32_t>> dropped(outline.edges.size());  // vertices that an edge passes over
  std::vector<char> alive_vertex(count, 1), alive_edge(outline.edges.size(), 1);
  std::vector<std::uint32_t> version(count, 0);
  struct Candidate {
    double error;
    std::int32_t vertex;
    std::uint32_t version;
    bool operator<(const Candidate& o) const { return error != o.error ? error > o.error : vertex > o.vertex; }
  };
  std::priority_queue<Candidate> queue;
  const auto point = [&](std::int32_t v) -> const GridPoint& { return outline.vertices[static_cast<std::size_t>(v)]; };
  const auto other_end = [&](std::int32_t e, std::int32_t v) {
    const Outline::Edge& edge = outline.edges[static_cast<std::size_t>(e)];
    return edge.a == v ? edge.b : edge.a;
  };
  const auto consider = [&](std::int32_t v) {
    listen(16);
    const EdgesAt::Range at = edges_at[static_cast<std::size_t>(v)];
    if ((!fixed.empty() && fixed[static_cast<std::size_t>(v)]) || at.size() != 2) return;
    const std::int32_t u = other_end(at[0], v), w = other_end(at[1], v);
    if (u == w) return;
    // Same regions on both sides of the way u, v, w.
    const Outline::Edge &e = outline.edges[static_cast<std::size_t>(at[0])],
                        &f = outline.edges[static_cast<std::size_t>(at[1])];
    const std::int32_t e_left = e.b == v ? e.left : e.right, f_left = f.a == v ? f.left : f.right;
    const std::int32_t e_right = e.b == v ? e.right : e.left, f_right = f.a == v ? f.right : f.left;
    if (e_left != f_left || e_right != f_right) return;
    const GridPoint &pu = point(u), &pv = point(v), &pw = point(w);
    if (distance(pu, pw) > limits.longest) return;
    const double shorter = std::min(distance(pu, pv), distance(pv, pw));
    const double tolerance =
        shorter < limits.short_edge ? std::max(limits.tolerance, limits.short_tolerance) : limits.tolerance;
    double error = segment_distance(pv, pu, pw);
    for (const std::int32_t k : {at[0], at[1]})
      for (const std::int32_t d : dropped[static_cast<std::size_t>(k)]) {
        listen();
        error = std::max(error, segment_distance(point(d), pu, pw));
      }
    if (error > tolerance) return;
    queue.push({error, v, version[static_cast<std::size_t>(v)]});
  };
  for (std::size_t v = 0; v < count; ++v) consider(static_cast<std::int32_t>(v));
  while (!queue.empty()) {
    listen(16);
    const Candidate top = queue.top();
    queue.pop();
    const std::int32_t v = top.vertex;
    if (!alive_vertex[static_cast<std::size_t>(v)] || version[static_cast<std::size_t>(v)] != top.version) continue;
    const std::int32_t e = edges_at[static_cast<std::size_t>(v)][0], f = edges_at[static_cast<std::size_t>(v)][1];
    const std::int32_t u = other_end(e, v), w = other_end(f, v);
    bool connected = false;
    for (const std::int32_t k : edges_at[static_cast<std::size_t>(u)]) connected = connected || other_end(k, u) == w;
    if (connected) continue;
    const bool blocked = !triangle_is_empty(index, outline.vertices, u, v, w, [&](std::int32_t x) {
      listen();
      return !alive_vertex[static_cast<std::size_t>(x)];
    });
    if (blocked) continue;
    // Edge e takes the place of both.
    Outline::Edge& kept = outline.edges[static_cast<std::size_t>(e)];
    (kept.a == v ? kept.a : kept.b) = w;
    alive_edge[static_cast<std::size_t>(f)] = 0;
    alive_vertex[static_cast<std::size_t>(v)] = 0;
    for (std::int32_t& k : edges_at[static_cast<std::size_t>(w)])
      if (k == f) k = e;
    auto& list = dropped[static_cast<std::size_t>(e)];
    list.push_back(v);
    list.insert(list.end(), dropped[static_cast<std::size_t>(f)].begin(), dropped[static_cast<std::size_t>(f)].end());
    dropped[static_cast<std::size_t>(f)].clear();
    for (const std::int32_t x : {u, w}) {
      ++version[static_cast<std::size_t>(x)];
      consider(x);
    }
  }
  std::vector<Outline::Edge> edges;
  for (std::size_t e = 0; e < outline.edges.size(); ++e)
    if (alive_edge[e]) edges.push_back(outline.edges[e]);
  outline.edges = std::move(edges);
}

}  // namespace slice2mesh::detail
