// SPDX-License-Identifier: MIT
/// @file
/// @brief Flips inside of slabs: edges and faces that are taken out in favor of others.
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
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/improve/tet_graph.hpp"
#include "slice2mesh/improve/wall_vertices.hpp"
#include "slice2mesh/quality/tet_figures.hpp"
#include "slice2mesh/triangulate/plane_stack.hpp"

namespace slice2mesh::detail {

/// What a tet adds to the cost that operations make smaller.
[[nodiscard]] inline double improvement_cost(double badness) {
  return badness < 1e8 ? badness * badness * badness : 1e24;
}

/// Share of the cost that a flip or a move has to gain.
inline constexpr double kLeastGain = 3e-3;

/// Edges and faces that are gone by two vertices, with a stamp: what was tried without gain. Others that fall into the
/// same place replace them: they are tried once more, with the same result.
class TriedEdges {
public:
  explicit TriedEdges(std::size_t vertices) : entries_(vertices * kPlaces) {}
  void add_vertex() { entries_.resize(entries_.size() + kPlaces); }
  [[nodiscard]] std::uint32_t stamp(std::int32_t a, std::int32_t b) const {
    const Entry& entry = entries_[place(a, b)];
    return entry.other == b ? entry.stamp : 0;
  }
  void set(std::int32_t a, std::int32_t b, std::uint32_t stamp) { entries_[place(a, b)] = {b, stamp}; }

private:
  struct Entry {
    std::int32_t other = kNone;
    std::uint32_t stamp = 0;
  };
  static constexpr std::size_t kPlaces = 8;  // of one vertex: neighbors in memory
  [[nodiscard]] static std::size_t place(std::int32_t a, std::int32_t b) {
    return std::size_t(a) * kPlaces + (std::uint32_t(b) * 2654435769U >> 29);
  }
  std::vector<Entry> entries_;
};

/// Finds and makes the best flip at a tet. Tets stay in their slabs and regions; that new ones are positive and fill
/// the place of the old ones (on a bent wall, up to the bend between its two diagonals) is decided exactly.
class Flips {
public:
  using Tet = TetGraph::Tet;
  using Cell = TetGraph::Cell;

  Flips(TetGraph& graph, const WallVertices& walls)
      : graph_(graph), walls_(walls), tried_edge_(graph.points().size()) {}

  /// The graph has one vertex more.
  void add_vertex() { tried_edge_.add_vertex(); }

  /// Whether edges of walls are flipped too; at first they are not.
  void turn_walls(bool turn) { turn_walls_ = turn; }

  /// Makes the flip at tet t that gains most; false if none gains. Edges and faces that nothing has changed at since
  /// they were tried are left out.
  bool flip(std::int32_t t) {
    best_.gain = 0;
    best_.old.clear();
    const Tet tet = graph_[t].v;
    for (const auto& e : kTetEdgeVertices) {
      const auto [a, b] = std::minmax(tet[e[0]], tet[e[1]]);
      // A change of a tet at the edge changes both of its ends.
      const std::uint32_t tried = tried_edge_.stamp(a, b);
      if (graph_.changed(a) <= tried || graph_.changed(b) <= tried) continue;
      gainful_ = false;
      if (graph_.plane(a) == graph_.plane(b))
        offer_plane_flip(t, a, b);
      else
        offer_edge_removal(t, a, b);
      if (!gainful_) tried_edge_.set(a, b, graph_.stamp());
    }
    const std::uint32_t changed = graph_.changed(tet);
    for (std::size_t i = 0; i < 4; ++i) offer_face_removal(t, i, changed);
    if (best_.old.empty()) return false;
    graph_.replace(best_.old, best_.tets, best_.cells, best_.badnesses);
    return true;
  }

private:
  struct Flip {
    double gain = 0;
    std::vector<std::int32_t> old;
    std::vector<Tet> tets;
    std::vector<Cell> cells;
    std::vector<double> badnesses;
  };

  /// Keeps the flip of `old` into tets_ with cells_ if it is valid and better than the best one so far. The old tets
  /// are those of one slab, or of two slabs in this order. `bend`: what the tets gain in volume (in the first slab).
  void offer(const std::vector<std::int32_t>& old, double before, Int128 bend = 0) {
    double after = 0;
    badnesses_.clear();
    for (const Tet& t : tets_) {
      badnesses_.push_back(graph_.rate(t));
      after += improvement_cost(badnesses_.back());
      if (!(before - after > kLeastGain * before)) return;
    }
    gainful_ = true;
    if (!(before - after > kLeastGain * before + best_.gain)) return;
    // Positive tets that add up to the same volume in each slab fill the same space once.
    const std::int32_t first = graph_[old.front()].slab;
    std::array<Int128, 2> sum{-bend, 0};
    for (std::size_t i = 0; i < tets_.size(); ++i) {
      const Int128 v = graph_.volume(tets_[i]);
      if (v <= 0) return;
      sum[cells_[i].slab == first ? 0 : 1] += v;
    }
    for (const std::int32_t t : old) sum[graph_[t].slab == first ? 0 : 1] -= graph_.volume(graph_[t].v);
    if (sum[0] != 0 || sum[1] != 0) return;
    best_.gain = before - after;
    best_.old = old;
    best_.tets = tets_;
    best_.cells = cells_;
    best_.badnesses = badnesses_;
  }

  enum class Around { Closed, Open, TooMany };
  /// Turns around edge ab from tet t on: `old_` gets the tets, `ring_` the vertices around it, counter-clockwise seen
  /// from b, one more than tets if it is open.
  Around turn_around(std::int32_t t, std::int32_t a, std::int32_t b) {
    old_.clear();
    ring_.clear();
    const auto [u, w] = link(graph_[t].v, a, b);
    const std::int32_t sum = a ^ b;
    ring_.push_back(u);
    std::int32_t v = u, next = w, at = t;
    while (true) {
      old_.push_back(at);
      if (old_.size() > kLargestFan) return Around::TooMany;
      const TetGraph::Element& e = graph_[at];
      const std::int32_t n = e.across[TetGraph::index_of(e.v, v)];
      if (n == t) return Around::Closed;
      ring_.push_back(next);
      if (n == kNone) break;
      const Tet& x = graph_[n].v;
      v = next;
      next = x[0] ^ x[1] ^ x[2] ^ x[3] ^ sum ^ v;
      at = n;
    }
    // Open: the other way from the start.
    back_.clear();
    back_ring_.clear();
    v = w, next = u, at = t;
    while (true) {
      const TetGraph::Element& e = graph_[at];
      const std::int32_t n = e.across[TetGraph::index_of(e.v, v)];
      if (n == kNone) break;
      const Tet& x = graph_[n].v;
      v = next;
      next = x[0] ^ x[1] ^ x[2] ^ x[3] ^ sum ^ v;
      at = n;
      back_.push_back(at);
      back_ring_.push_back(next);
      if (old_.size() + back_.size() > kLargestFan) return Around::TooMany;
    }
    old_.insert(old_.begin(), back_.rbegin(), back_.rend());
    ring_.insert(ring_.begin(), back_ring_.rbegin(), back_ring_.rend());
    return Around::Open;
  }
  /// The other two vertices u, w of a tet such that (a, b, u, w) is positive.
  static std::pair<std::int32_t, std::int32_t> link(const Tet& tet, std::int32_t a, std::int32_t b) {
    const std::size_t ia = TetGraph::index_of(tet, a), ib = TetGraph::index_of(tet, b);
    std::size_t rest[2] = {0, 0}, n = 0;
    for (std::size_t i = 0; i < 4; ++i)
      if (i != ia && i != ib) rest[n++] = i;
    const bool odd = is_odd(ia, ib, rest[0], rest[1]);
    return {tet[rest[odd ? 1 : 0]], tet[rest[odd ? 0 : 1]]};
  }
  static bool is_odd(std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
    return ((a > b) + (a > c) + (a > d) + (b > c) + (b > d) + (c > d)) % 2 != 0;
  }
  /// Triangulates the polygon ring[begin, end) around edge ab, counter-clockwise seen from b, and joins it to both
  /// ends: the cheapest way (Klincsek's dynamic program). Adds the tets to tets_; false if none is cheaper than
  /// `limit`.
  bool triangulate_ring(const std::int32_t* ring, std::size_t n, std::int32_t a, std::int32_t b, Cell cell,
                        double limit) {
    double best[kLongestRing][kLongestRing];
    std::size_t apex[kLongestRing][kLongestRing];
    for (std::size_t i = 0; i + 1 < n; ++i) best[i][i + 1] = 0;
    for (std::size_t span = 2; span < n; ++span)
      for (std::size_t i = 0; i + span < n; ++i) {
        const std::size_t k = i + span;
        best[i][k] = std::numeric_limits<double>::infinity();
        apex[i][k] = i + 1;
        for (std::size_t j = i + 1; j < k; ++j) {
          double sum = best[i][j] + best[j][k];
          if (!(sum < best[i][k]) || !(sum < limit)) continue;
          const Tet up{ring[i], ring[j], ring[k], b}, down{ring[i], ring[k], ring[j], a};
          const double ru = graph_.rate(up);
          if (!std::isfinite(ru)) continue;
          sum += improvement_cost(ru);
          if (!(sum < best[i][k]) || !(sum < limit)) continue;
          const double rd = graph_.rate(down);
          if (!std::isfinite(rd)) continue;
          sum += improvement_cost(rd);
          if (sum < best[i][k]) {
            best[i][k] = sum;
            apex[i][k] = j;
          }
        }
      }
    if (!(best[0][n - 1] < limit)) return false;
    spans_.assign(1, {0, n - 1});
    while (!spans_.empty()) {
      const auto [i, k] = spans_.back();
      spans_.pop_back();
      if (k - i < 2) continue;
      const std::size_t j = apex[i][k];
      tets_.push_back({ring[i], ring[j], ring[k], b});
      tets_.push_back({ring[i], ring[k], ring[j], a});
      cells_.insert(cells_.end(), 2, cell);
      spans_.emplace_back(i, j);
      spans_.emplace_back(j, k);
    }
    return true;
  }
  [[nodiscard]] double cost_before() const {
    double sum = 0;
    for (const std::int32_t t : old_) sum += improvement_cost(graph_.badness(t));
    return sum;
  }
  /// Takes an edge between the two planes of a slab out.
  void offer_edge_removal(std::int32_t t, std::int32_t a, std::int32_t b) {
    const Around around = turn_around(t, a, b);
    if (around == Around::TooMany) return;
    if (around == Around::Open) {
      offer_wall_flip(a, b, old_.size());
      return;
    }
    const Cell cell = graph_.cell(t);
    std::size_t start = 0;  // where the region of `cell` ends
    while (start < old_.size() && graph_[old_[start]].region == cell.region) ++start;
    if (start < old_.size()) {
      const std::size_t n = old_.size();
      std::rotate(ring_.begin(), ring_.begin() + std::ptrdiff_t(start), ring_.end());
      std::rotate(old_.begin(), old_.begin() + std::ptrdiff_t(start), old_.end());
      ring_.push_back(ring_.front());
      std::size_t second = 1;
      while (second < n && graph_[old_[second]].region != cell.region) ++second;
      offer_wall_flip(a, b, second);
      return;
    }
    if (old_.size() > kLongestRing) return;
    const double before = cost_before();
    tets_.clear();
    cells_.clear();
    if (triangulate_ring(ring_.data(), ring_.size(), a, b, cell, before)) offer(old_, before);
  }
  /// Takes an edge of a wall out, in favor of the other diagonal of its two triangles: on both sides of the wall, where
  /// there is material on both of them. `second`: the number of tets on the first side.
  void offer_wall_flip(std::int32_t a, std::int32_t b, std::size_t second) {
    const std::size_t n = old_.size();
    const std::int32_t u = ring_.front(), w = ring_[second];
    if (!on_one_wall(a, b, u, w)) return;
    if (!turn_walls_) {
      gainful_ = true;  // later, perhaps
      return;
    }
    const double before = cost_before();
    tets_.clear();
    cells_.clear();
    for (const auto& [begin, end] : {std::pair{std::size_t(0), second}, std::pair{second, n}}) {
      if (begin == end) continue;
      if (end - begin + 1 > kLongestRing) return;
      const Cell cell = graph_.cell(old_[begin]);
      for (std::size_t i = begin; i < end; ++i)
        if (!(graph_.cell(old_[i]) == cell)) return;
      if (!triangulate_ring(ring_.data() + begin, end - begin + 1, a, b, cell, before)) return;
    }
    // The two triangles of a bent wall and the other two have a flat tet between them.
    offer(old_, before, second == n ? graph_.volume({a, b, w, u}) : 0);
  }
  /// Whether triangles abu and abw are on one wall, with the two ends of its other diagonal.
  [[nodiscard]] bool on_one_wall(std::int32_t a, std::int32_t b, std::int32_t u, std::int32_t w) const {
    if (graph_.plane(a) > graph_.plane(b)) std::swap(a, b);
    if (graph_.plane(u) > graph_.plane(w)) std::swap(u, w);
    if (graph_.plane(u) != graph_.plane(a) || graph_.plane(w) != graph_.plane(b)) return false;
    const std::int32_t wall = walls_.wall_of(a, u, WallVertices::Above);
    return wall != kNone && wall == walls_.wall_of(b, w, WallVertices::Below);
  }
  /// Takes an edge of a plane out, in favor of the other diagonal of its two triangles: in both slabs, where both have
  /// material there.
  void offer_plane_flip(std::int32_t t, std::int32_t a, std::int32_t b) {
    const std::int32_t level = graph_.plane(a);
    const Around around = turn_around(t, a, b);
    if (around == Around::TooMany) return;
    const std::size_t n = old_.size();
    // From one triangle of the plane to the other, and on in the other slab to the first one.
    std::size_t second = n;
    if (around == Around::Closed) {
      std::size_t start = 0;
      while (start < n && graph_.plane(ring_[start]) != level) ++start;
      if (start == n) return;
      std::rotate(ring_.begin(), ring_.begin() + std::ptrdiff_t(start), ring_.end());
      std::rotate(old_.begin(), old_.begin() + std::ptrdiff_t(start), old_.end());
      ring_.push_back(ring_.front());
      second = 1;
      while (second < n && graph_.plane(ring_[second]) != level) ++second;
      if (second == n) return;
    }
    if (graph_.plane(ring_.front()) != level || graph_.plane(ring_.back()) != level) return;
    const double before = cost_before();
    tets_.clear();
    cells_.clear();
    for (const auto& [begin, end] : {std::pair{std::size_t(0), second}, std::pair{second, n}}) {
      if (begin == end) continue;
      if (end - begin + 1 >= kLongestRing) return;
      const Cell cell = graph_.cell(old_[begin]);
      for (std::size_t i = begin; i < end; ++i)
        if (!(graph_.cell(old_[i]) == cell)) return;
      if (!triangulate_ring(ring_.data() + begin, end - begin + 1, a, b, cell, before)) return;
    }
    offer(old_, before);
  }
  /// Puts an edge through the face opposite to vertex i of t. `changed`: the last stamp at the tet.
  void offer_face_removal(std::int32_t t, std::size_t i, std::uint32_t changed) {
    const TetGraph::Element& own = graph_[t];
    const std::int32_t other = own.across[i];
    if (other == kNone) return;
    const TetGraph::Element& x = graph_[other];
    if (x.slab != own.slab || x.region != own.region) return;
    const std::int32_t d = own.v[i], a = own.v[(i + 1) % 4];
    std::int32_t b = own.v[(i + 2) % 4], c = own.v[(i + 3) % 4];
    const std::int32_t e = x.v[0] ^ x.v[1] ^ x.v[2] ^ x.v[3] ^ a ^ b ^ c;
    if (graph_.plane(d) == graph_.plane(e)) return;
    if (x.tried_flip >= std::max(changed, graph_.changed(e))) return;       // tried from the other side
    if (is_odd((i + 1) % 4, (i + 2) % 4, (i + 3) % 4, i)) std::swap(b, c);  // the tet is positive
    tets_.clear();
    tets_.push_back({e, d, a, b});
    tets_.push_back({e, d, b, c});
    tets_.push_back({e, d, c, a});
    old_.assign({t, other});
    cells_.assign(3, graph_.cell(t));
    offer(old_, cost_before());
  }

  static constexpr std::size_t kLongestRing = 9;                    // edges with more tets around are not taken out
  static constexpr std::size_t kLargestFan = 2 * kLongestRing - 4;  // in two slabs

  TetGraph& graph_;
  const WallVertices& walls_;
  TriedEdges tried_edge_;
  Flip best_;
  bool turn_walls_ = false;
  bool gainful_ = false;  // the edge that is tried, perhaps
  std::vector<std::int32_t> ring_, old_, back_, back_ring_;
  std::vector<std::pair<std::size_t, std::size_t>> spans_;
  std::vector<Tet> tets_;
  std::vector<Cell> cells_;
  std::vector<double> badnesses_;
};

}  // namespace slice2mesh::detail
