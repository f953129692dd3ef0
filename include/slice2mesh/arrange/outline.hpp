// SPDX-License-Identifier: MIT
/// @file
/// @brief Outline: the contours of one slab, a plane divided into regions.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/arrange/snap_rounding.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/core/slab.hpp"

namespace slice2mesh {

/// The boundaries between the regions of one slab. Edges have no crossings and meet in vertices only; every edge
/// separates two different regions, or a region and the outside.
struct Outline {
  /// An edge with what lies on its two sides.
  struct Edge {
    std::int32_t a = 0;          ///< index of the vertex where it begins
    std::int32_t b = 0;          ///< index of the vertex where it ends
    std::int32_t left = kNone;   ///< index of the region on the left of a -> b, or kNone
    std::int32_t right = kNone;  ///< index of the region on the right, or kNone
    /// The same ends in the same order, and the same regions.
    [[nodiscard]] bool operator==(const Edge& o) const {
      return a == o.a && b == o.b && left == o.left && right == o.right;
    }
  };
  std::vector<GridPoint> vertices;  ///< #V, all different, each on an edge
  std::vector<Edge> edges;          ///< #E, in no order; none where the slab is empty

  /// True if there is nothing in the slab.
  [[nodiscard]] bool empty() const { return edges.empty(); }
  /// The same numbers; normalized outlines are the same if and only if they are equal.
  [[nodiscard]] bool operator==(const Outline& o) const { return vertices == o.vertices && edges == o.edges; }
};

namespace detail {

/// The edges at each vertex of an outline, as it is when this is made.
class EdgesAt {
public:
  explicit EdgesAt(const Outline& outline) : start_(outline.vertices.size() + 1, 0), edges_(2 * outline.edges.size()) {
    for (const Outline::Edge& e : outline.edges) {
      ++start_[static_cast<std::size_t>(e.a) + 1];
      ++start_[static_cast<std::size_t>(e.b) + 1];
    }
    for (std::size_t v = 1; v < start_.size(); ++v) start_[v] += start_[v - 1];
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    for (std::size_t e = 0; e < outline.edges.size(); ++e)
      for (const std::int32_t v : {outline.edges[e].a, outline.edges[e].b})
        edges_[next[static_cast<std::size_t>(v)]++] = static_cast<std::int32_t>(e);
  }
  /// A range of indices of edges, which may be changed.
  struct Range {
    std::int32_t *first, *last;
    [[nodiscard]] std::int32_t* begin() const { return first; }
    [[nodiscard]] std::int32_t* end() const { return last; }
    [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(last - first); }
    [[nodiscard]] bool empty() const { return first == last; }
    [[nodiscard]] std::int32_t operator[](std::size_t i) const { return first[i]; }
  };
  [[nodiscard]] Range operator[](std::size_t v) { return {edges_.data() + start_[v], edges_.data() + start_[v + 1]}; }

private:
  std::vector<std::size_t> start_;
  std::vector<std::int32_t> edges_;
};

/// Twice the area of a region (kNone: of all regions) in squared pitches; exact.
[[nodiscard]] inline Int128 doubled_area(const Outline& outline, std::int32_t region) {
  Int128 sum = 0;
  for (const Outline::Edge& e : outline.edges) {
    const GridPoint &p = outline.vertices[static_cast<std::size_t>(e.a)],
                    &q = outline.vertices[static_cast<std::size_t>(e.b)];
    const Int128 term = Int128(p.x) * q.y - Int128(p.y) * q.x;
    if (region == kNone ? (e.left != kNone) : (e.left == region)) sum += term;
    if (region == kNone ? (e.right != kNone) : (e.right == region)) sum -= term;
  }
  return sum;
}

/// Each region's boundary as closed walks: a directed segment with the region on its left, tag `first_tag + region`.
inline void append_segments(const Outline& outline, std::int32_t first_tag, std::vector<TaggedSegment>& segments) {
  for (const Outline::Edge& e : outline.edges) {
    const GridPoint &p = outline.vertices[static_cast<std::size_t>(e.a)],
                    &q = outline.vertices[static_cast<std::size_t>(e.b)];
    if (e.left != kNone) segments.push_back({p, q, first_tag + e.left});
    if (e.right != kNone) segments.push_back({q, p, first_tag + e.right});
  }
}

/// Drops vertices without edges and numbers the others in lexicographic order; sorts the edges. One outline, one form.
/// `poll` is called now and then; what it throws leaves the outline useless.
inline void normalize(Outline& outline, const std::function<void()>& poll = {}) {
  Poll listen(poll, 1 << 16);
  std::vector<char> used(outline.vertices.size(), 0);
  for (const Outline::Edge& e : outline.edges)
    used[static_cast<std::size_t>(e.a)] = used[static_cast<std::size_t>(e.b)] = 1;
  std::vector<std::int32_t> order;
  for (std::size_t v = 0; v < used.size(); ++v)
    if (used[v]) order.push_back(static_cast<std::int32_t>(v));
  sort_listening(order.begin(), order.end(), listen, [&](std::int32_t u, std::int32_t v) {
    return outline.vertices[static_cast<std::size_t>(u)] < outline.vertices[static_cast<std::size_t>(v)];
  });
  std::vector<std::int32_t> index(used.size(), kNone);
  std::vector<GridPoint> vertices;
  vertices.reserve(order.size());
  for (const std::int32_t v : order) {
    listen();
    index[static_cast<std::size_t>(v)] = static_cast<std::int32_t>(vertices.size());
    vertices.push_back(outline.vertices[static_cast<std::size_t>(v)]);
  }
  outline.vertices = std::move(vertices);
  for (Outline::Edge& e : outline.edges) {
    listen();
    e.a = index[static_cast<std::size_t>(e.a)];
    e.b = index[static_cast<std::size_t>(e.b)];
    if (e.a > e.b) {
      std::swap(e.a, e.b);
      std::swap(e.left, e.right);
    }
  }
  sort_listening(outline.edges.begin(), outline.edges.end(), listen,
                 [](const Outline::Edge& e, const Outline::Edge& f) { return e.a != f.a ? e.a < f.a : e.b < f.b; });
}

}  // namespace detail

}  // namespace slice2mesh
