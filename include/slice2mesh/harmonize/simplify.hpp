// SPDX-License-Identifier: MIT
/// @file
/// @brief Fewer vertices on an outline, within a tolerance and without changing its topology.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <queue>
#include <unordered_map>
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
  VertexIndex(const std::vector<GridPoint>& vertices, double cell)
      : vertices_(vertices), cell_(std::max<std::int64_t>(1, std::int64_t(cell))) {
    map_.reserve(vertices.size());
    for (std::size_t v = 0; v < vertices.size(); ++v)
      map_.emplace(key(column(vertices[v].x), column(vertices[v].y)), std::int32_t(v));
  }
  /// Calls f(vertex) for the vertices in a box (and a few around) until it returns true; tells whether it did.
  template <class F>
  bool any_in_box(GridPoint low, GridPoint high, F&& f) const {
    const std::int64_t c0 = column(low.x), c1 = column(high.x), r0 = column(low.y), r1 = column(high.y);
    if (double(c1 - c0 + 1) * double(r1 - r0 + 1) > double(vertices_.size()) + 16) {
      for (std::size_t v = 0; v < vertices_.size(); ++v)
        if (f(static_cast<std::int32_t>(v))) return true;
      return false;
    }
    for (std::int64_t c = c0; c <= c1; ++c)
      for (std::int64_t r = r0; r <= r1; ++r) {
        const auto range = map_.equal_range(key(c, r));
        for (auto it = range.first; it != range.second; ++it)
          if (f(it->second)) return true;
      }
    return false;
  }

private:
  [[nodiscard]] std::int64_t column(std::int64_t x) const { return x / cell_ - (x % cell_ < 0 ? 1 : 0); }
  [[nodiscard]] static std::uint64_t key(std::int64_t c, std::int64_t r) { return GridHash{}({c, r}); }
  const std::vector<GridPoint>& vertices_;
  std::int64_t cell_;
  std::unordered_multimap<std::uint64_t, std::int32_t> map_;
};

/// Removes vertices of degree two, the least important first. `fixed` (#V, may be empty) vertices stay. No edge of the
/// result crosses another: a vertex goes only if the triangle it spans with its neighbors holds no other vertex
/// (exact). Source: Visvalingam, Whyatt, "Line generalisation by repeated elimination of points", Cartogr. J. 30
/// (1993), with the distance of all dropped points to the new edge as measure. `poll` is called now and then.
inline void simplify(Outline& outline, const std::vector<char>& fixed, const SimplifyLimits& limits,
                     const std::function<void()>& poll = {}) {
  const std::size_t count = outline.vertices.size();
  if (count < 4) return;
  std::vector<std::vector<std::int32_t>> edges_at(count);
  for (std::size_t e = 0; e < outline.edges.size(); ++e) {
    edges_at[static_cast<std::size_t>(outline.edges[e].a)].push_back(std::int32_t(e));
    edges_at[static_cast<std::size_t>(outline.edges[e].b)].push_back(std::int32_t(e));
  }
  double length = 0;
  for (const Outline::Edge& e : outline.edges)
    length +=
        distance(outline.vertices[static_cast<std::size_t>(e.a)], outline.vertices[static_cast<std::size_t>(e.b)]);
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
  Poll listen(poll, 1 << 14);
  const auto consider = [&](std::int32_t v) {
    listen(16);
    const auto& at = edges_at[static_cast<std::size_t>(v)];
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
    const GridPoint pu = point(u), pv = point(v), pw = point(w);
    const int turn = orientation(pu, pv, pw);
    const GridPoint low{std::min({pu.x, pv.x, pw.x}), std::min({pu.y, pv.y, pw.y})};
    const GridPoint high{std::max({pu.x, pv.x, pw.x}), std::max({pu.y, pv.y, pw.y})};
    const bool blocked = index.any_in_box(low, high, [&](std::int32_t x) {
      listen();
      if (x == u || x == v || x == w || !alive_vertex[static_cast<std::size_t>(x)]) return false;
      const GridPoint& p = point(x);
      if (p.x < low.x || p.x > high.x || p.y < low.y || p.y > high.y) return false;
      if (turn == 0) return orientation(pu, pw, p) == 0;
      return orientation(pu, pv, p) * turn >= 0 && orientation(pv, pw, p) * turn >= 0 &&
             orientation(pw, pu, p) * turn >= 0;
    });
    if (blocked) continue;
    // Edge e takes the place of both.
    Outline::Edge& kept = outline.edges[static_cast<std::size_t>(e)];
    (kept.a == v ? kept.a : kept.b) = w;
    alive_edge[static_cast<std::size_t>(f)] = 0;
    alive_vertex[static_cast<std::size_t>(v)] = 0;
    edges_at[static_cast<std::size_t>(v)].clear();
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
