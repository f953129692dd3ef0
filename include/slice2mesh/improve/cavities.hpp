// SPDX-License-Identifier: MIT
/// @file
/// @brief Cavities that are filled from one vertex: a new one on an edge of a plane, or one that is there.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/improve/flips.hpp"
#include "slice2mesh/improve/tet_graph.hpp"
#include "slice2mesh/improve/wall_vertices.hpp"

namespace slice2mesh::detail {

/// Takes tets around a bad one out and joins the faces of the cavity to one vertex, which is there or new. The cavity
/// grows over the face of its worst new tet, as long as that is another tet of the same slab and region. The new tets
/// are positive, which is decided exactly, and so the faces of the cavity see the vertex: the tets fill it once.
///
/// The plane of the vertex and the walls that it is on get new triangles, where a face of the cavity is on them: with a
/// tet that has such a face, the one on the other side is in the cavity, and the new triangles are the same from both
/// sides. No vertex is lost, and of the edges of contours none but the one that a new vertex splits. A wall is bent by
/// the rounding of its vertices: what was between its old and its new triangles is lost or gained.
class Cavities {
public:
  using Tet = TetGraph::Tet;
  using Cell = TetGraph::Cell;

  /// A cavity and the tets that fill it.
  struct Filling {
    double gain = 0;                                  ///< of the cost
    std::vector<std::int32_t> old;                    ///< tets
    std::vector<Tet> tets;                            ///< those that fill it ...
    std::vector<Cell> cells;                          ///< ... and where each is
    std::vector<double> badnesses;                    ///< ... and their ratings
    std::int32_t a = kNone, b = kNone;                ///< edge that a new vertex is on
    std::array<std::int32_t, 2> walls{kNone, kNone};  ///< that this edge is on, by WallVertices::Side
    GridPoint point;                                  ///< place of the new vertex
  };

  Cavities(TetGraph& graph, WallVertices& walls) : graph_(graph), walls_(walls) {}

  /// Cost of which the worst tet is nearly all.
  [[nodiscard]] static double sharp_cost(double badness) {
    const double c = improvement_cost(badness);
    return c * c * c;
  }
  /// Whether that is what has to gain; at first it is the cost of flips.
  void sharpen(bool sharp) { sharp_ = sharp; }

  /// Joins the tets around t to a vertex of t or of a tet next to it, where that gains.
  bool reconnect(std::int32_t t) {
    Filling best;
    const Tet tet = graph_[t].v;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::int32_t n = graph_[t].across[i];
      if (n == kNone || !(graph_.cell(n) == graph_.cell(t))) continue;
      const Tet& x = graph_[n].v;
      const std::int32_t opposite = x[0] ^ x[1] ^ x[2] ^ x[3] ^ tet[0] ^ tet[1] ^ tet[2] ^ tet[3] ^ tet[i];
      for (const std::int32_t apex : {opposite, tet[i]}) {
        coming_.assign({t, n});
        grow(apex, kLeastGain, best);
      }
    }
    if (best.old.empty()) return false;
    graph_.replace(best.old, best.tets, best.cells, best.badnesses);
    return true;
  }

  /// Ways to put a vertex on an edge of t or of a tet next to it, so that t is in the cavity: those that gain most, or
  /// lose least, first. `vertex`: the last one, without tets.
  const std::vector<Filling>& insertions(std::int32_t t, std::int32_t vertex) {
    offers_.clear();
    find_edges(t);
    double shortest = std::numeric_limits<double>::infinity();
    for (const auto& e : kTetEdgeVertices) {
      const std::int32_t a = graph_[t].v[e[0]], b = graph_[t].v[e[1]];
      if (graph_.plane(a) == graph_.plane(b)) shortest = std::min(shortest, distance(graph_.point(a), graph_.point(b)));
    }
    for (const auto& [a, b] : pairs_) {
      // One of them may be the hub of any number of tets.
      const std::int32_t from = graph_.star(a).size() < graph_.star(b).size() ? a : b;
      if (graph_.star(from).size() > kLargestStar) continue;
      find_shares(graph_[t].v, a, b);
      for (const double share : shares_) {
        const GridPoint &p = graph_.point(a), &q = graph_.point(b);
        const GridPoint m{p.x + std::llround(share * double(q.x - p.x)), p.y + std::llround(share * double(q.y - p.y))};
        if (!(std::min(distance(m, p), distance(m, q)) > kShortestShare * shortest)) continue;
        Filling filling;
        filling.gain = -std::numeric_limits<double>::infinity();
        filling.point = m;
        filling.a = a;
        filling.b = b;
        filling.walls = {walls_.wall_of(a, b, WallVertices::Below), walls_.wall_of(a, b, WallVertices::Above)};
        graph_.set_point(vertex, m);
        graph_.put_on_plane_of(vertex, a);
        walls_.put_last(filling.walls);
        coming_.assign(1, t);
        for (const std::int32_t s : graph_.star(from))
          if (TetGraph::has(graph_[s].v, a ^ b ^ from)) coming_.push_back(s);
        grow(vertex, 0, filling);
        if (filling.old.empty()) continue;
        offers_.push_back(std::move(filling));
      }
    }
    std::stable_sort(offers_.begin(), offers_.end(),
                     [](const Filling& x, const Filling& y) { return x.gain > y.gain; });
    return offers_;
  }

private:
  using Face = std::array<std::int32_t, 3>;  // ascending
  /// A face of the cavity with the new tet at it.
  struct Joined {
    Face face;
    Tet tet;
    Cell cell;
    double badness;
    std::int32_t beyond;  // the tet on the other side of the face, or kNone where the cavity has to end
  };
  /// A face of the cavity, or of its new tets.
  struct CavityFace {
    Face face;
    int count;   // of new tets at it
    bool old;    // of the cavity
    bool joins;  // with a tet that stays
    Cell cell;   // of the first new tet
  };
  /// An edge of a face of the skin that is on a surface.
  struct SkinEdge {
    std::int32_t p, q;
    Cell cell;
  };

  [[nodiscard]] double cost(double badness) const { return sharp_ ? sharp_cost(badness) : improvement_cost(badness); }
  void find_edges(std::int32_t t) {
    pairs_.clear();
    const auto add = [&](const Tet& x) {
      for (const auto& e : kTetEdgeVertices) {
        const std::pair<std::int32_t, std::int32_t> ab = std::minmax(x[e[0]], x[e[1]]);
        if (graph_.plane(ab.first) == graph_.plane(ab.second) &&
            std::find(pairs_.begin(), pairs_.end(), ab) == pairs_.end())
          pairs_.push_back(ab);
      }
    };
    add(graph_[t].v);
    for (const std::int32_t n : graph_[t].across)
      if (n != kNone && graph_.cell(n) == graph_.cell(t)) add(graph_[n].v);
  }
  /// Where on ab a vertex may be of use: in the middle, and where vertices of a tet are nearest.
  void find_shares(const Tet& tet, std::int32_t a, std::int32_t b) {
    shares_.assign(1, 0.5);
    const GridPoint &p = graph_.point(a), &q = graph_.point(b);
    const double x = double(q.x - p.x), y = double(q.y - p.y), square = x * x + y * y;
    for (const std::int32_t v : tet) {
      if (v == a || v == b) continue;
      const GridPoint& r = graph_.point(v);
      const double share = (double(r.x - p.x) * x + double(r.y - p.y) * y) / square;
      if (!(share > kLeastShare && share < 1 - kLeastShare)) continue;
      if (std::none_of(shares_.begin(), shares_.end(), [&](double s) { return std::fabs(s - share) < kSameShare; }))
        shares_.push_back(share);
    }
  }
  [[nodiscard]] bool in_cavity(std::int32_t t) const {
    return std::find(cavity_.begin(), cavity_.end(), t) != cavity_.end();
  }
  /// Grows the cavity from these tets, and keeps the filling with the largest gain, if that is more than this share of
  /// the cost and more than that of `best`, which says what edge a new vertex is on.
  void grow(std::int32_t apex, double least, Filling& best) {
    const bool is_new = best.a != kNone;
    cavity_.clear();
    joined_.clear();
    skin_edges_.clear();
    double before = 0, worst_before = kTolerable;
    while (true) {
      // What has to be in the cavity, with what that brings with it.
      for (std::size_t i = 0; i < coming_.size(); ++i) {
        if (in_cavity(coming_[i])) continue;
        if (cavity_.size() == kLargestCavity || !take_in(coming_[i], apex)) return;
        before += cost(graph_.badness(coming_[i]));
        worst_before = std::max(worst_before, graph_.badness(coming_[i]));
      }
      coming_.clear();
      double after = 0, worst = 0;
      std::int32_t next = kNone;
      for (const Joined& f : joined_) {
        after += cost(f.badness);
        if (f.badness > worst) {
          worst = f.badness;
          next = f.beyond;
        }
      }
      const double gain = before - after;
      const bool may = is_new ? worst < kHopeless : worst <= worst_before && gain > least * before;
      if (may && gain > best.gain && is_filled(apex, best)) {
        best.gain = gain;
        best.old = cavity_;
        best.tets.clear();
        best.cells.clear();
        best.badnesses.clear();
        for (const Joined& f : joined_) {
          best.tets.push_back(f.tet);
          best.cells.push_back(f.cell);
          best.badnesses.push_back(f.badness);
        }
      }
      if (next == kNone) return;
      coming_.assign(1, next);
    }
  }
  /// Takes a tet into the cavity and joins the faces that it adds to the vertex. False if one of those can be part of
  /// no filling.
  bool take_in(std::int32_t t, std::int32_t apex) {
    cavity_.push_back(t);
    graph_.count(kWork);
    const TetGraph::Element& e = graph_[t];
    const bool above = is_above(e.v, apex);
    for (std::size_t i = 0; i < 4; ++i) {
      const std::int32_t n = e.across[i];
      const bool at_apex = e.v[i] != apex && TetGraph::has(e.v, apex);
      Tet tet = e.v;
      tet[i] = apex;
      if (n != kNone && in_cavity(n)) {
        if (!(graph_.cell(n) == graph_.cell(t)) && !at_apex && !on_surface(tet, above, apex)) return false;
        const Face face = face_of(e.v, i);
        const auto found =
            std::find_if(joined_.begin(), joined_.end(), [&](const Joined& f) { return f.face == face; });
        if (found != joined_.end()) {
          *found = joined_.back();
          joined_.pop_back();
        }
        continue;
      }
      if (at_apex) continue;
      if (on_surface(tet, above, apex)) {
        if (n != kNone)
          coming_.push_back(n);
        else
          for (std::size_t k = 1; k < 4; ++k) {
            const auto [p, q] = std::minmax(e.v[(i + k) % 4], e.v[(i + k % 3 + 1) % 4]);
            skin_edges_.push_back({p, q, graph_.cell(t)});
          }
        continue;
      }
      const double badness = graph_.rate(tet);
      const std::int32_t beyond = n != kNone && graph_.cell(n) == graph_.cell(t) ? n : kNone;
      if (beyond == kNone && !(badness < kHopeless)) return false;
      joined_.push_back({face_of(e.v, i), tet, graph_.cell(t), badness, beyond});
    }
    return true;
  }
  /// Are these vertices, the apex among them, on its plane, or on one of its walls? `above`: in the slab above it.
  [[nodiscard]] bool on_surface(const Tet& vertices, bool above, std::int32_t apex) const {
    const std::int32_t level = graph_.plane(apex);
    const auto on_level = [&](std::int32_t v) { return graph_.plane(v) == level; };
    if (std::all_of(vertices.begin(), vertices.end(), on_level)) return true;
    return walls_.on_one_wall(vertices, [&](std::int32_t v) { return on_level(v) == above; });
  }
  [[nodiscard]] bool is_above(const Tet& tet, std::int32_t apex) const {
    return std::any_of(tet.begin(), tet.end(), [&](std::int32_t v) { return graph_.plane(v) > graph_.plane(apex); });
  }
  /// Are the new tets positive, no vertices and no edges of contours lost, and are all faces those of two tets, or of
  /// the skin on a surface?
  [[nodiscard]] bool is_filled(std::int32_t apex, const Filling& at) {
    return std::all_of(joined_.begin(), joined_.end(), [&](const Joined& f) { return graph_.volume(f.tet) > 0; }) &&
           nothing_is_lost(at) && faces_fit(apex);
  }
  [[nodiscard]] bool nothing_is_lost(const Filling& at) const {
    for (const std::int32_t t : cavity_) {
      const Tet& old = graph_[t].v;
      for (const std::int32_t v : old)
        if (std::none_of(joined_.begin(), joined_.end(), [&](const Joined& f) { return TetGraph::has(f.tet, v); }))
          return false;
      for (const auto& e : kTetEdgeVertices) {
        const std::int32_t p = std::min(old[e[0]], old[e[1]]), q = std::max(old[e[0]], old[e[1]]);
        if (graph_.plane(p) != graph_.plane(q) || (p == at.a && q == at.b)) continue;
        if (walls_.wall_of(p, q, WallVertices::Below) == kNone && walls_.wall_of(p, q, WallVertices::Above) == kNone)
          continue;
        if (std::none_of(joined_.begin(), joined_.end(),
                         [&](const Joined& f) { return TetGraph::has(f.tet, p) && TetGraph::has(f.tet, q); }))
          return false;
      }
    }
    return true;
  }
  [[nodiscard]] bool faces_fit(std::int32_t apex) {
    faces_.clear();
    for (const std::int32_t t : cavity_) {
      const TetGraph::Element& e = graph_[t];
      for (std::size_t i = 0; i < 4; ++i)
        if (e.across[i] == kNone || !in_cavity(e.across[i]))
          faces_.push_back({face_of(e.v, i), 0, true, e.across[i] != kNone, graph_.cell(t)});
    }
    for (const Joined& j : joined_)
      for (std::size_t i = 0; i < 4; ++i) {
        const Face face = face_of(j.tet, i);
        const auto found =
            std::find_if(faces_.begin(), faces_.end(), [&](const CavityFace& f) { return f.face == face; });
        if (found == faces_.end()) {
          faces_.push_back({face, 1, false, false, j.cell});
        } else {
          ++found->count;
          if (!found->old && !(found->cell == j.cell) &&
              !on_surface({face[0], face[1], face[2], apex}, is_above(j.tet, apex), apex))
            return false;
        }
      }
    return std::all_of(faces_.begin(), faces_.end(), [&](const CavityFace& f) {
      if (f.old) return f.joins ? f.count == 1 : f.count <= 1;
      if (f.count == 2) return true;
      // New on the skin: at an edge of what was the skin there.
      return f.count == 1 && std::count_if(skin_edges_.begin(), skin_edges_.end(), [&](const SkinEdge& e) {
                               return e.cell == f.cell && e.p != apex && e.q != apex &&
                                      std::binary_search(f.face.begin(), f.face.end(), e.p) &&
                                      std::binary_search(f.face.begin(), f.face.end(), e.q);
                             }) == 1;
    });
  }
  [[nodiscard]] static Face face_of(const Tet& t, std::size_t opposite) {
    Face face{t[(opposite + 1) % 4], t[(opposite + 2) % 4], t[(opposite + 3) % 4]};
    std::sort(face.begin(), face.end());
    return face;
  }

  static constexpr std::size_t kLargestCavity = 24;  // tets
  static constexpr std::int64_t kWork = 4;           // of a tet that is taken in, besides ratings, in those
  static constexpr std::size_t kLargestStar = 500;   // tets around the ends of an edge that is split
  static constexpr double kLeastShare = 0.1;         // of the edge, from its ends to a new vertex
  static constexpr double kShortestShare = 0.75;  // of the shortest edge of the tet in a plane: edges to a new vertex
  static constexpr double kSameShare = 0.03;      // nearer ones are tried once
  static constexpr double kTolerable = 3;  // R/3r; no tet gets worse than the worst around, if that is more than this
  static constexpr double kHopeless = 50;  // R/3r, of a filling

  TetGraph& graph_;
  WallVertices& walls_;
  bool sharp_ = false;
  std::vector<Filling> offers_;
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs_;
  std::vector<double> shares_;
  std::vector<std::int32_t> cavity_, coming_;
  std::vector<Joined> joined_;
  std::vector<SkinEdge> skin_edges_;
  std::vector<CavityFace> faces_;
};

}  // namespace slice2mesh::detail
