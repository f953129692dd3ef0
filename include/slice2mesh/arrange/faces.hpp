// SPDX-License-Identifier: MIT
/// @file
/// @brief The faces of an arrangement and how often each loop winds around them.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <set>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/arrange/snap_rounding.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/core/slab.hpp"

namespace slice2mesh {

/// Winding numbers that are not zero: one per tag, sorted by tag.
using WindingState = std::vector<EdgeTag>;

/// The faces of an arrangement: the connected parts of the plane without its edges.
struct ArrangementFaces {
  std::vector<WindingState> windings;  ///< #F; face 0 is the outer one, with no winding
  std::vector<std::array<std::int32_t, 2>>
      of_edge;  ///< #E by 2: indices of the faces on the left and on the right of a -> b
};

namespace detail {

/// Finds the faces of an arrangement: the walks around them, and by a sweep which walks bound the same face.
class FaceSweep {
public:
  explicit FaceSweep(const Arrangement& arrangement, const std::function<void()>& poll)
      : vertices_(arrangement.vertices), edges_(arrangement.edges), listen_(poll, 1 << 12) {}

  /// Fills `of_edge` (see ArrangementFaces), and returns the number of faces.
  std::size_t run(std::vector<std::array<std::int32_t, 2>>& of_edge) {
    find_edges_at();
    find_walks();
    // A walk that turns left in all is the outer border of a face of its own. Others go around a component from
    // outside, one around each: they bound the face that the component lies in.
    std::int32_t count = 1;
    for (Walk& walk : walks_)
      if (walk.doubled_area > 0) walk.face = count++;
    place_components();
    of_edge.resize(edges_.size());
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      listen_();
      for (std::size_t side = 0; side < 2; ++side) of_edge[e][side] = walks_[std::size_t(walk_of_[2 * e + side])].face;
    }
    return std::size_t(count);
  }

private:
  /// Half-edges: 2 e runs from a to b of edge e, with its left side on the left; 2 e + 1 back.
  struct Walk {
    Int128 doubled_area = 0;
    std::int32_t first_vertex;  // the smallest
    std::int32_t face = kNone;
  };
  [[nodiscard]] std::int32_t origin(std::int32_t h) const {
    const Arrangement::Edge& e = edges_[std::size_t(h) / 2];
    return h % 2 == 0 ? e.a : e.b;
  }
  [[nodiscard]] const GridPoint& point(std::int32_t v) const { return vertices_[std::size_t(v)]; }
  /// Half-edges by the vertex where they begin, counter-clockwise.
  void find_edges_at() {
    start_.assign(vertices_.size() + 1, 0);
    for (const Arrangement::Edge& e : edges_) {
      listen_();
      ++start_[std::size_t(e.a) + 1];
      ++start_[std::size_t(e.b) + 1];
    }
    for (std::size_t v = 0; v < vertices_.size(); ++v) start_[v + 1] += start_[v];
    around_.resize(2 * edges_.size());
    place_of_.resize(around_.size());
    std::vector<std::int32_t> next(start_.begin(), start_.end() - 1);
    for (std::int32_t h = 0; h < std::int32_t(around_.size()); ++h) {
      listen_();
      around_[std::size_t(next[std::size_t(origin(h))]++)] = h;
    }
    for (std::size_t v = 0; v < vertices_.size(); ++v) {
      listen_();
      if (start_[v + 1] - start_[v] > 2) {  // two are in order whichever is first
        const GridPoint& p = vertices_[v];
        const auto is_right = [&](const GridPoint& q) { return p < q; };
        const auto is_before = [&](std::int32_t g, std::int32_t h) {
          const GridPoint &q = point(origin(g ^ 1)), &r = point(origin(h ^ 1));
          return is_right(q) != is_right(r) ? is_right(q) : orientation(p, q, r) > 0;
        };
        sort_listening(around_.begin() + start_[v], around_.begin() + start_[v + 1], listen_, is_before);
      }
      for (std::int32_t i = start_[v]; i < start_[v + 1]; ++i) place_of_[std::size_t(around_[std::size_t(i)])] = i;
    }
  }
  /// The half-edge that goes on along the face on the left: at the end of h, the next one clockwise from its way back.
  [[nodiscard]] std::int32_t after(std::int32_t h) const {
    const auto v = std::size_t(origin(h ^ 1));
    const std::int32_t i = place_of_[std::size_t(h ^ 1)];
    return around_[std::size_t(i == start_[v] ? start_[v + 1] - 1 : i - 1)];
  }
  void find_walks() {
    walk_of_.assign(around_.size(), kNone);
    for (std::int32_t first = 0; first < std::int32_t(walk_of_.size()); ++first) {
      if (walk_of_[std::size_t(first)] != kNone) continue;
      Walk walk;
      walk.first_vertex = origin(first);
      const GridPoint& center = point(walk.first_vertex);
      for (std::int32_t h = first; walk_of_[std::size_t(h)] == kNone; h = after(h)) {
        listen_();
        walk_of_[std::size_t(h)] = std::int32_t(walks_.size());
        walk.doubled_area += cross(center, point(origin(h)), point(origin(h ^ 1)));
        walk.first_vertex = std::min(walk.first_vertex, origin(h));
      }
      walks_.push_back(walk);
    }
  }
  /// Is edge e below edge f where the sweep is? Both are there, they do not cross, and no vertex lies on one: exact.
  [[nodiscard]] bool is_below(std::int32_t e, std::int32_t f) const {
    const Arrangement::Edge &s = edges_[std::size_t(e)], &t = edges_[std::size_t(f)];
    if (s.a == t.a) return orientation(point(s.a), point(s.b), point(t.b)) > 0;
    if (s.a < t.a) return orientation(point(s.a), point(s.b), point(t.a)) > 0;
    return orientation(point(t.a), point(t.b), point(s.a)) < 0;
  }
  /// From each component's first vertex straight down: the edge that is met there bounds the face.
  void place_components() {
    std::vector<std::int32_t> outer(vertices_.size(), kNone);  // the walk around the component that begins there
    for (std::size_t w = 0; w < walks_.size(); ++w)
      if (walks_[w].doubled_area <= 0) outer[std::size_t(walks_[w].first_vertex)] = std::int32_t(w);
    struct Vertex {
      std::int32_t index;
    };
    // The order is one of places that edges take: where one edge ends at a vertex and another begins, it takes over the
    // place.
    std::vector<std::int32_t> edge_at, place_of_edge(edges_.size(), kNone);
    struct Order {
      using is_transparent = void;  // NOLINT(readability-identifier-naming): a name of the standard
      const FaceSweep* sweep;
      const std::vector<std::int32_t>* edge_at;
      bool operator()(std::int32_t i, std::int32_t j) const {
        return sweep->is_below((*edge_at)[std::size_t(i)], (*edge_at)[std::size_t(j)]);
      }
      bool operator()(std::int32_t i, Vertex v) const {
        const Arrangement::Edge& s = sweep->edges_[std::size_t((*edge_at)[std::size_t(i)])];
        return orientation(sweep->point(s.a), sweep->point(s.b), sweep->point(v.index)) > 0;
      }
    };
    using Places = std::set<std::int32_t, Order>;  // from the lowest up
    Places there(Order{this, &edge_at});
    std::vector<Places::iterator> entry;
    for (std::int32_t v = 0; v < std::int32_t(vertices_.size()); ++v) {
      listen_();
      const std::int32_t begin = start_[std::size_t(v)], end = start_[std::size_t(v) + 1];
      const auto ends_here = [&](std::int32_t i) { return around_[std::size_t(i)] % 2 != 0; };
      const auto edge = [&](std::int32_t i) { return std::size_t(around_[std::size_t(i)]) / 2; };
      if (end - begin == 2 && ends_here(begin) != ends_here(begin + 1)) {
        const std::int32_t last = ends_here(begin) ? begin : begin + 1, first = ends_here(begin) ? begin + 1 : begin;
        place_of_edge[edge(first)] = place_of_edge[edge(last)];
        edge_at[std::size_t(place_of_edge[edge(first)])] = std::int32_t(edge(first));
        continue;
      }
      for (std::int32_t i = begin; i < end; ++i)
        if (ends_here(i)) there.erase(entry[std::size_t(place_of_edge[edge(i)])]);
      if (outer[std::size_t(v)] != kNone) {
        const auto above = there.lower_bound(Vertex{v});
        // Edges run to the right: what is above them is on the left of the half-edge 2 e. Its walk has its face: if it
        // goes around a component, one that began before.
        std::int32_t& face = walks_[std::size_t(outer[std::size_t(v)])].face;
        if (above == there.begin()) {
          face = 0;
        } else {
          const std::int32_t below = edge_at[std::size_t(*std::prev(above))];
          face = walks_[std::size_t(walk_of_[2 * std::size_t(below)])].face;
        }
      }
      for (std::int32_t i = begin; i < end; ++i) {
        if (ends_here(i)) continue;
        place_of_edge[edge(i)] = std::int32_t(edge_at.size());
        edge_at.push_back(std::int32_t(edge(i)));
        entry.push_back(there.insert(place_of_edge[edge(i)]).first);
      }
    }
  }

  const std::vector<GridPoint>& vertices_;
  const std::vector<Arrangement::Edge>& edges_;
  std::vector<std::int32_t> start_, around_;  // half-edges at each vertex
  std::vector<std::int32_t> place_of_;        // of each half-edge: where it is in around_
  std::vector<std::int32_t> walk_of_;         // of each half-edge
  std::vector<Walk> walks_;
  Poll listen_;
};

/// Winding states over the graph of faces, from the outer one on.
inline void find_windings(const Arrangement& arrangement, std::size_t face_count, ArrangementFaces& faces,
                          const std::function<void()>& poll) {
  std::vector<std::vector<std::int32_t>> edges_of_face(face_count);
  detail::Poll listen(poll, 1 << 14);
  for (std::size_t e = 0; e < faces.of_edge.size(); ++e) {
    listen();
    if (faces.of_edge[e][0] == faces.of_edge[e][1]) continue;
    for (const std::int32_t f : faces.of_edge[e]) edges_of_face[static_cast<std::size_t>(f)].push_back(int(e));
  }
  faces.windings.resize(face_count);
  std::vector<char> known(face_count, 0);
  known[0] = 1;
  std::vector<std::int32_t> stack(1, 0);
  while (!stack.empty()) {
    const std::int32_t face = stack.back();
    stack.pop_back();
    for (const std::int32_t e : edges_of_face[static_cast<std::size_t>(face)]) {
      const auto& sides = faces.of_edge[static_cast<std::size_t>(e)];
      const bool to_left = sides[1] == face;
      const std::int32_t other = to_left ? sides[0] : sides[1];
      if (known[static_cast<std::size_t>(other)]) continue;
      known[static_cast<std::size_t>(other)] = 1;
      stack.push_back(other);
      const WindingState& from = faces.windings[static_cast<std::size_t>(face)];
      listen(from.size() + 1);
      WindingState to;
      std::size_t i = 0;
      auto j = arrangement.edges[static_cast<std::size_t>(e)].first_tag;
      const auto end = arrangement.edges[static_cast<std::size_t>(e)].last_tag;
      while (i < from.size() || j < end) {
        const EdgeTag* step = j < end ? &arrangement.tags[static_cast<std::size_t>(j)] : nullptr;
        if (step == nullptr || (i < from.size() && from[i].tag < step->tag)) {
          to.push_back(from[i++]);
          continue;
        }
        EdgeTag sum{step->tag, to_left ? step->winding : -step->winding};
        if (i < from.size() && from[i].tag == step->tag) sum.winding += from[i++].winding;
        if (sum.winding != 0) to.push_back(sum);
        ++j;
      }
      faces.windings[static_cast<std::size_t>(other)] = std::move(to);
    }
  }
}

}  // namespace detail

/// Faces and winding numbers: crossing an edge from right to left adds its winding. Precondition: no edges cross, no
/// vertex lies on an edge, and vertices are sorted and edges run from the smaller to the larger, as in what
/// `snap_round` gives. `poll` is called now and then; what it throws ends the work. Cost: O(n log n) plus the sizes of
/// the winding states.
[[nodiscard]] inline ArrangementFaces find_faces(const Arrangement& arrangement,
                                                 const std::function<void()>& poll = {}) {
  ArrangementFaces faces;
  detail::FaceSweep sweep(arrangement, poll);
  const std::size_t count = sweep.run(faces.of_edge);
  detail::find_windings(arrangement, count, faces, poll);
  return faces;
}

}  // namespace slice2mesh
