// SPDX-License-Identifier: MIT
/// @file
/// @brief Short edges of a new outline, merged onto the outline below.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/arrange/segment_index.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/harmonize/simplify.hpp"

namespace slice2mesh::detail {

/// What binds a vertex of a new outline: nothing, an edge of the outline below, or a vertex of it.
enum class Bond : std::uint8_t { Free, OnEdge, OnVertex };

/// Collapses edges shorter than `limit` (pitches): a free vertex into its neighbor, a vertex on an edge of the outline
/// below along that edge. `old_edge[e]`: edge e is a part of the outline below. Only where nothing lies in the way, and
/// no needle that is longer than `limit` vanishes with its base.
inline void merge_short_edges(Outline& outline, const std::vector<Bond>& bond, const std::vector<char>& old_edge,
                              double limit, const std::function<void()>& poll = {}) {
  const std::size_t count = outline.vertices.size();
  Poll listen(poll, 1 << 12);
  std::vector<std::vector<std::int32_t>> edges_at(count);
  for (std::size_t e = 0; e < outline.edges.size(); ++e) {
    listen();
    edges_at[std::size_t(outline.edges[e].a)].push_back(std::int32_t(e));
    edges_at[std::size_t(outline.edges[e].b)].push_back(std::int32_t(e));
  }
  const auto length_of = [&](std::int32_t e) {
    return distance(outline.vertices[std::size_t(outline.edges[std::size_t(e)].a)],
                    outline.vertices[std::size_t(outline.edges[std::size_t(e)].b)]);
  };
  std::vector<std::int32_t> order;
  double total = 0;
  for (std::size_t e = 0; e < outline.edges.size(); ++e) {
    const double length = length_of(std::int32_t(e));
    total += length;
    if (length < limit) order.push_back(std::int32_t(e));
  }
  if (order.empty()) return;
  sort_listening(order.begin(), order.end(), listen, [&](std::int32_t e, std::int32_t f) {
    const double le = length_of(e), lf = length_of(f);
    return le != lf ? le < lf : e < f;
  });
  // Edges get longer while others go, up to about the limit.
  const VertexIndex index(outline.vertices, std::max(limit, total / double(outline.edges.size())));
  std::vector<char> alive(outline.edges.size(), 1), gone(count, 0), is_old = old_edge;
  // Vertices without edges (left over from joined pieces) do not stand in the way.
  for (std::size_t v = 0; v < count; ++v) gone[v] = edges_at[v].empty();
  const auto other_end = [&](std::int32_t e, std::int32_t v) {
    const Outline::Edge& edge = outline.edges[std::size_t(e)];
    return edge.a == v ? edge.b : edge.a;
  };
  const auto drop = [&](std::int32_t e, std::int32_t v) {
    auto& list = edges_at[std::size_t(v)];
    list.erase(std::find(list.begin(), list.end(), e));
    if (list.empty()) gone[std::size_t(v)] = 1;
  };
  const auto twin_of = [&](std::int32_t w, std::int32_t x) {
    std::int32_t twin = kNone;
    for (const std::int32_t g : edges_at[std::size_t(w)])
      if (other_end(g, w) == x) twin = g;
    return twin;
  };
  // The regions on the left and on the right of the edge w x, its twin, when the edge f from v to x lies on it.
  const auto sides_of_both = [&](std::int32_t f, std::int32_t twin, std::int32_t v, std::int32_t w, std::int32_t x) {
    const Outline::Edge &edge = outline.edges[std::size_t(f)], &stays = outline.edges[std::size_t(twin)];
    std::pair<std::int32_t, std::int32_t> sides{stays.left, stays.right};
    if (stays.a != w) std::swap(sides.first, sides.second);
    // Seen from w to x: with a left turn w, v, x the way over v lies on the right of the edge w x.
    if (orientation(outline.vertices[std::size_t(w)], outline.vertices[std::size_t(v)],
                    outline.vertices[std::size_t(x)]) > 0)
      sides.second = edge.a == v ? edge.right : edge.left;
    else
      sides.first = edge.a == v ? edge.left : edge.right;
    return sides;
  };
  for (const std::int32_t e : order) {
    listen(16);
    if (!alive[std::size_t(e)] || length_of(e) >= limit) continue;
    std::int32_t v = outline.edges[std::size_t(e)].a, w = outline.edges[std::size_t(e)].b;
    if (bond[std::size_t(v)] > bond[std::size_t(w)]) std::swap(v, w);
    // v goes into w.
    bool possible = bond[std::size_t(v)] != Bond::OnVertex;
    if (possible && bond[std::size_t(v)] == Bond::OnEdge) {
      possible = is_old[std::size_t(e)] != 0;
    }
    for (const std::int32_t f : edges_at[std::size_t(v)]) {
      if (!possible) break;
      if (f == e) continue;
      const std::int32_t x = other_end(f, v);
      possible = triangle_is_empty(index, outline.vertices, v, w, x, [&](std::int32_t y) {
        listen();
        return gone[std::size_t(y)] != 0;
      });
      const std::int32_t twin = possible ? twin_of(w, x) : kNone;
      if (twin == kNone || std::max(length_of(f), length_of(twin)) < limit) continue;
      const auto [left, right] = sides_of_both(f, twin, v, w, x);
      possible = left != right;
    }
    if (!possible) continue;
    drop(e, v);
    drop(e, w);
    alive[std::size_t(e)] = 0;
    const std::vector<std::int32_t> moved = edges_at[std::size_t(v)];
    edges_at[std::size_t(v)].clear();
    gone[std::size_t(v)] = 1;
    for (const std::int32_t f : moved) {
      Outline::Edge& edge = outline.edges[std::size_t(f)];
      const std::int32_t x = other_end(f, v);
      const std::int32_t twin = twin_of(w, x);
      if (twin == kNone) {
        (edge.a == v ? edge.a : edge.b) = w;
        edges_at[std::size_t(w)].push_back(f);
        continue;
      }
      // Two edges come to lie on each other, and the region between them vanishes.
      Outline::Edge& stays = outline.edges[std::size_t(twin)];
      const auto [left, right] = sides_of_both(f, twin, v, w, x);
      alive[std::size_t(f)] = 0;
      drop(f, x);
      if (left == right) {
        alive[std::size_t(twin)] = 0;
        drop(twin, w);
        drop(twin, x);
      } else {
        stays.left = stays.a == w ? left : right;
        stays.right = stays.a == w ? right : left;
        is_old[std::size_t(twin)] = is_old[std::size_t(twin)] || is_old[std::size_t(f)];
      }
    }
    gone[std::size_t(w)] = edges_at[std::size_t(w)].empty();  // it may have had none for a while
  }
  std::vector<Outline::Edge> edges;
  for (std::size_t e = 0; e < outline.edges.size(); ++e)
    if (alive[e]) edges.push_back(outline.edges[e]);
  outline.edges = std::move(edges);
}

/// A vertex of an outline and where it is to go.
struct VertexMove {
  double length;  ///< pitches
  std::int32_t vertex;
  GridPoint target;
};

/// Moves vertices, the shortest moves first, each only where nothing lies in its way; no two end up in one place.
/// `poll` is called now and then.
inline void move_vertices(Outline& outline, std::vector<VertexMove> moves, const std::function<void()>& poll = {}) {
  if (moves.empty()) return;
  Poll listen(poll, 1 << 14);
  sort_listening(moves.begin(), moves.end(), listen, [](const VertexMove& m, const VertexMove& n) {
    return m.length != n.length ? m.length < n.length : m.vertex < n.vertex;
  });
  EdgesAt edges_at(outline);
  double total = 0;
  for (const Outline::Edge& e : outline.edges) {
    listen();
    total += distance(outline.vertices[std::size_t(e.a)], outline.vertices[std::size_t(e.b)]);
  }
  // Targets take part as points of their own, so that the way of a vertex is judged on where things are now: a vertex
  // that has moved counts at its new place through its target, and no longer at the old one.
  std::vector<GridPoint> points = outline.vertices;
  const auto first = std::int32_t(points.size());
  for (const VertexMove& m : moves) points.push_back(m.target);
  const VertexIndex index(points, std::max(1.0, total / double(outline.edges.size())));
  std::vector<char> present(points.size(), 0);
  for (std::size_t v = 0; v < outline.vertices.size(); ++v) present[v] = !edges_at[v].empty();
  std::vector<std::int32_t> at(outline.vertices.size());  // index into points where a vertex is now
  for (std::size_t v = 0; v < at.size(); ++v) at[v] = std::int32_t(v);
  // Edges are found where they were at first, by a search that is wider by the longest move.
  const SegmentIndex edges(outline, &listen);
  const auto reach = std::int64_t(std::ceil(moves.back().length)) + 1;
  const auto crosses = [&](std::int32_t v, const GridPoint& target) {
    const GridPoint& p = points[std::size_t(at[std::size_t(v)])];
    return edges.any_near(p, target, reach, [&](std::size_t e) {
      listen();
      const Outline::Edge& edge = outline.edges[e];
      if (edge.a == v || edge.b == v) return false;
      return segments_meet(p, target, points[std::size_t(at[std::size_t(edge.a)])],
                           points[std::size_t(at[std::size_t(edge.b)])]);
    });
  };
  for (std::size_t k = 0; k < moves.size(); ++k) {
    const VertexMove& m = moves[k];
    const std::int32_t to = first + std::int32_t(k);
    const auto absent = [&](std::int32_t y) {
      listen();
      return !present[std::size_t(y)];
    };
    bool possible = !edges_at[std::size_t(m.vertex)].empty();
    for (const std::int32_t e : edges_at[std::size_t(m.vertex)]) {
      const Outline::Edge& edge = outline.edges[std::size_t(e)];
      const std::int32_t x = edge.a == m.vertex ? edge.b : edge.a;
      possible =
          possible && triangle_is_empty(index, points, at[std::size_t(m.vertex)], to, at[std::size_t(x)], absent);
    }
    // With no vertex in the triangles an edge can only come in and go out next to the target.
    if (!possible || crosses(m.vertex, m.target)) continue;
    present[std::size_t(at[std::size_t(m.vertex)])] = 0;
    present[std::size_t(to)] = 1;
    at[std::size_t(m.vertex)] = to;
  }
  for (std::size_t v = 0; v < at.size(); ++v) outline.vertices[v] = points[std::size_t(at[v])];
}

/// Moves vertices of an outline onto vertices of the outline below that are nearer than `limit` (pitches), each onto
/// the nearest, where nothing lies in the way. What both have in common then coincides exactly. `poll` is called now
/// and then.
inline void snap_vertices(Outline& outline, const Outline& below, double limit,
                          const std::function<void()>& poll = {}) {
  if (outline.vertices.empty() || below.vertices.empty()) return;
  const VertexIndex targets(below.vertices, std::max(1.0, limit * 4));
  std::vector<VertexMove> moves;
  const auto reach = std::int64_t(std::ceil(limit));
  Poll listen(poll, 1 << 14);
  for (std::size_t v = 0; v < outline.vertices.size(); ++v) {
    const GridPoint p = outline.vertices[v];
    double nearest = limit;
    std::int32_t target = kNone;
    targets.any_in_box({p.x - reach, p.y - reach}, {p.x + reach, p.y + reach}, [&](std::int32_t t) {
      listen();
      const double d = distance(p, below.vertices[std::size_t(t)]);
      if (d < nearest ||
          (d == nearest && target != kNone && below.vertices[std::size_t(t)] < below.vertices[std::size_t(target)])) {
        nearest = d;
        target = t;
      }
      return false;
    });
    if (target != kNone && nearest > 0)
      moves.push_back({nearest, std::int32_t(v), below.vertices[std::size_t(target)]});
  }
  move_vertices(outline, std::move(moves), poll);
}

}  // namespace slice2mesh::detail
