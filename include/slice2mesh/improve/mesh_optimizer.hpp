// SPDX-License-Identifier: MIT
/// @file
/// @brief Local improvement of a filled stack: flips inside of slabs, moves and collapses of vertices in their planes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/harmonize/harmonize.hpp"
#include "slice2mesh/improve/contour_columns.hpp"
#include "slice2mesh/pipeline/options.hpp"
#include "slice2mesh/quality/tet_figures.hpp"
#include "slice2mesh/triangulate/plane_stack.hpp"

namespace slice2mesh::detail {

/// Improves the tets of all slabs by local operations. All of them keep every tet in its slab and region and every wall
/// vertical; that new tets are positive is decided exactly. Free vertices move in their plane, vertices that split a
/// contour edge along that edge, contour vertices as columns, within the tolerance (contour_columns.hpp), or not at
/// all.
class MeshOptimizer {
public:
  using Tet = std::array<std::int32_t, 4>;

  /// `slices`: the regions that the contours were made from, for moves of contours; nullptr: contours stay.
  MeshOptimizer(const Contours& contours, const std::vector<Outline>* slices, PlaneStack& stack, Mesh& mesh,
                const ImproveOptions& options, const Progress& progress)
      : stack_(stack), mesh_(mesh), options_(options), progress_(progress) {
    for (std::size_t k = 0; k < stack.meshes.size(); ++k) {
      first_.push_back(std::int32_t(points_.size()));
      const PlaneMesh& plane = stack.meshes[k];
      points_.insert(points_.end(), plane.vertices.begin(), plane.vertices.end());
      plane_.resize(points_.size(), std::int32_t(k));
      for (const char fixed : plane.fixed) kind_.push_back(fixed ? Kind::Fixed : Kind::Free);
      for (const GridPoint& p : plane.vertices)
        xyz_.push_back({double(p.x), double(p.y), plane.z / contours.grid.pitch});
    }
    first_.push_back(std::int32_t(points_.size()));
    find_sliding();
    at_.resize(points_.size());
    std::vector<std::int32_t> degree(points_.size(), 0);
    for (const Tet& t : mesh.tets)
      for (const std::int32_t v : t) ++degree[std::size_t(v)];
    for (std::size_t v = 0; v < points_.size(); ++v) at_[v].reserve(std::size_t(degree[v]) + 4);
    badness_.resize(mesh.tets.size());
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      poll();
      for (const std::int32_t v : mesh.tets[t]) at_[std::size_t(v)].push_back(std::int32_t(t));
      badness_[t] = badness(mesh.tets[t]);
    }
    tried_edge_.resize(mesh.tets.size());
    tried_pair_.resize(mesh.tets.size());
    changed_.assign(points_.size(), 1);
    gone_.assign(points_.size(), kNone);
    if (slices != nullptr)
      columns_ = std::make_unique<ContourColumns>(contours, *slices, stack, first_, points_, gone_, to_listener_);
  }
  MeshOptimizer(const MeshOptimizer&) = delete;
  MeshOptimizer& operator=(const MeshOptimizer&) = delete;

  /// All rounds: first for what is bad, then for the rest.
  void run() {
    std::int32_t round = 0;
    for (const double floor : {kBad, options_.target}) {
      floor_ = std::max(floor, options_.target);
      const std::int32_t last = floor == kBad ? (options_.rounds + 1) / 2 : options_.rounds;
      std::size_t most = 0;
      for (; round < last && !exhausted(); ++round) {
        share_ = double(round) / double(options_.rounds);
        report(progress_, Stage::Improve, share_);
        const std::size_t done = flip_round() + smooth_round() + column_round(round) + collapse_round();
        most = std::max(most, done);
        if (round < kFirstColumnRound && columns_) continue;
        if (done == 0 || (columns_ && floor == kBad && double(done) < kLittle * double(most))) break;
      }
    }
    share_ = 1;
    report(progress_, Stage::Improve, share_);
    write_back();
  }

  /// The columns of the contours, nullptr where contours stay.
  [[nodiscard]] const ContourColumns* columns() const { return columns_.get(); }

private:
  enum class Kind : std::uint8_t { Fixed, Free, Sliding };
  struct Neighbors {
    std::int32_t previous, next;
  };

  // --- geometry
  // -------------------------------------------------------------------------------------------------------
  [[nodiscard]] const GridPoint& point(std::int32_t v) const { return points_[std::size_t(v)]; }
  void set_point(std::int32_t v, const GridPoint& p) {
    points_[std::size_t(v)] = p;
    xyz_[std::size_t(v)][0] = double(p.x);
    xyz_[std::size_t(v)][1] = double(p.y);
  }
  [[nodiscard]] std::int32_t plane(std::int32_t v) const { return plane_[std::size_t(v)]; }
  /// Six times the volume over the slab's height, exact, in squared pitches.
  [[nodiscard]] Int128 volume(const Tet& t) const {
    std::int64_t x[3], y[3];
    int z[3];
    const std::int32_t base = plane(t[0]);
    for (std::size_t i = 0; i < 3; ++i) {
      x[i] = point(t[i + 1]).x - point(t[0]).x;
      y[i] = point(t[i + 1]).y - point(t[0]).y;
      z[i] = plane(t[i + 1]) - base;
    }
    const auto minor = [&](int i, int j) { return Int128(x[i]) * y[j] - Int128(x[j]) * y[i]; };
    return z[2] * minor(0, 1) + z[0] * minor(1, 2) - z[1] * minor(0, 2);
  }
  [[nodiscard]] static double norm(const std::array<double, 3>& v) {
    return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  }
  /// How bad a tet is: R/3r, or what its sharpest dihedral angle (or that of its flattest edge) amounts to, if that is
  /// more. In plain floating point: it ranks, and decides nothing else.
  [[nodiscard]] double badness(const Tet& t) const {
    ++work_;
    const std::array<double, 3>& o = xyz_[std::size_t(t[0])];
    std::array<double, 3> e[3];
    double square[3];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::array<double, 3>& p = xyz_[std::size_t(t[i + 1])];
      e[i] = {p[0] - o[0], p[1] - o[1], p[2] - o[2]};
      square[i] = e[i][0] * e[i][0] + e[i][1] * e[i][1] + e[i][2] * e[i][2];
    }
    std::array<double, 3> n[3], sum{}, center{};
    double area[3], areas = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto &u = e[(i + 1) % 3], &v = e[(i + 2) % 3];
      n[i] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
      for (std::size_t k = 0; k < 3; ++k) {
        sum[k] += n[i][k];
        center[k] += square[i] * n[i][k];
      }
      area[i] = norm(n[i]);
      areas += area[i];
    }
    const double det = e[0][0] * n[0][0] + e[0][1] * n[0][1] + e[0][2] * n[0][2];
    if (!(det > 0)) return std::numeric_limits<double>::infinity();
    const double base = norm(sum);
    areas += base;
    const double r = norm(center) * areas / (6 * det * det);
    if (r < kLookAtAngles) return r;
    // The sine of the angle at an edge: volume and length of the edge over the areas of the two faces.
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
      const std::array<double, 3> opposite{e[k][0] - e[j][0], e[k][1] - e[j][1], e[k][2] - e[j][2]};
      least = std::min({least, std::sqrt(square[i]) / (area[j] * area[k]), norm(opposite) / (base * area[i])});
    }
    return std::max(r, kAngleWeight / (least * det));
  }
  [[nodiscard]] static double cost(double badness) { return badness < 1e8 ? badness * badness * badness : 1e24; }

  /// The work is bounded by a count, not by time: the result does not depend on the machine.
  [[nodiscard]] bool exhausted() const { return double(work_) > options_.most_work; }
  /// Listens to the caller every so many ratings.
  void poll() {
    constexpr std::int64_t kPollEvery = 1 << 16;
    if (work_ < next_poll_) return;
    next_poll_ = work_ + kPollEvery;
    report(progress_, Stage::Improve, share_);
  }

  // --- topology
  // -------------------------------------------------------------------------------------------------------
  [[nodiscard]] bool alive(std::int32_t t) const { return mesh_.tets[std::size_t(t)][0] != kNone; }
  [[nodiscard]] static bool has(const Tet& t, std::int32_t v) {
    return t[0] == v || t[1] == v || t[2] == v || t[3] == v;
  }
  void remove(std::int32_t t) {
    for (const std::int32_t v : mesh_.tets[std::size_t(t)]) {
      auto& list = at_[std::size_t(v)];
      list.erase(std::find(list.begin(), list.end(), t));
      changed_[std::size_t(v)] = stamp_;
    }
    mesh_.tets[std::size_t(t)][0] = kNone;
    unused_.push_back(t);
  }
  std::int32_t add(const Tet& tet, std::int32_t slab, std::int32_t region, double r) {
    std::int32_t t = 0;
    if (unused_.empty()) {
      t = std::int32_t(mesh_.tets.size());
      mesh_.tets.push_back(tet);
      mesh_.tet_slab.push_back(slab);
      mesh_.tet_region.push_back(region);
      badness_.push_back(r);
    } else {
      t = unused_.back();
      unused_.pop_back();
      mesh_.tets[std::size_t(t)] = tet;
      mesh_.tet_slab[std::size_t(t)] = slab;
      mesh_.tet_region[std::size_t(t)] = region;
      badness_[std::size_t(t)] = r;
    }
    for (const std::int32_t v : tet) {
      at_[std::size_t(v)].push_back(t);
      changed_[std::size_t(v)] = stamp_;
    }
    return t;
  }

  // --- flips
  // ----------------------------------------------------------------------------------------------------------
  struct Cell {
    std::int32_t slab, region;
  };
  struct Flip {
    double gain = 0;
    std::vector<std::int32_t> old;
    std::vector<Tet> tets;
    std::vector<Cell> cells;
    std::vector<double> badnesses;
  };
  [[nodiscard]] Cell cell(std::int32_t t) const {
    return {mesh_.tet_slab[std::size_t(t)], mesh_.tet_region[std::size_t(t)]};
  }
  /// Keeps the flip of `old` into tets_ with cells_ if it is valid and better than the best one so far. The old tets
  /// are those of one slab, or of two slabs in this order.
  void offer(const std::vector<std::int32_t>& old, double before) {
    double after = 0;
    badnesses_.clear();
    for (const Tet& t : tets_) {
      badnesses_.push_back(badness(t));
      after += cost(badnesses_.back());
      if (!(before - after > kLeastGain * before)) return;
    }
    gainful_ = true;
    if (!(before - after > kLeastGain * before + best_.gain)) return;
    // Positive tets that add up to the same volume in each slab fill the same space once.
    const std::int32_t first = mesh_.tet_slab[std::size_t(old.front())];
    std::array<Int128, 2> sum{};
    for (std::size_t i = 0; i < tets_.size(); ++i) {
      const Int128 v = volume(tets_[i]);
      if (v <= 0) return;
      sum[cells_[i].slab == first ? 0 : 1] += v;
    }
    for (const std::int32_t t : old)
      sum[mesh_.tet_slab[std::size_t(t)] == first ? 0 : 1] -= volume(mesh_.tets[std::size_t(t)]);
    if (sum[0] != 0 || sum[1] != 0) return;
    best_.gain = before - after;
    best_.old = old;
    best_.tets = tets_;
    best_.cells = cells_;
    best_.badnesses = badnesses_;
  }
  /// Flips and collapses that were tried without gain, by two vertices, with the stamp of that time. Others that fall
  /// into the same place of the table replace them: they are tried once more, with the same result.
  class Memory {
  public:
    /// `pairs`: about how many are of use.
    void resize(std::size_t pairs) {
      constexpr std::size_t kLeast = std::size_t(1) << 12, kMost = std::size_t(1) << 22;
      std::size_t size = kLeast;
      while (size < pairs && size < kMost) size *= 2;
      entries_.assign(size, {});
    }
    [[nodiscard]] std::uint32_t stamp(std::int32_t a, std::int32_t b) const {
      const Entry& entry = entries_[place(a, b)];
      return entry.a == a && entry.b == b ? entry.stamp : 0;
    }
    void set(std::int32_t a, std::int32_t b, std::uint32_t stamp) { entries_[place(a, b)] = {a, b, stamp}; }

  private:
    struct Entry {
      std::int32_t a = kNone, b = kNone;
      std::uint32_t stamp = 0;
    };
    [[nodiscard]] std::size_t place(std::int32_t a, std::int32_t b) const {
      return GridHash{}({a, b}) & (entries_.size() - 1);
    }
    std::vector<Entry> entries_;
  };
  /// The tets around edge ab in order, if they are a closed ring of one region. `ring_` gets the vertices around it,
  /// counter-clockwise seen from b.
  bool find_ring(std::int32_t a, std::int32_t b) {
    around_.clear();
    ring_.clear();
    links_.clear();
    const bool by_a = at_[std::size_t(a)].size() < at_[std::size_t(b)].size();
    for (const std::int32_t t : at_[std::size_t(by_a ? a : b)]) {
      const Tet& tet = mesh_.tets[std::size_t(t)];
      if (!has(tet, by_a ? b : a)) continue;
      if (!around_.empty() && mesh_.tet_region[std::size_t(t)] != mesh_.tet_region[std::size_t(around_.front())])
        return false;
      links_.push_back(link(tet, a, b));
      around_.push_back(t);
      if (around_.size() > kLongestRing) return false;
    }
    if (links_.size() < 3) return false;
    std::int32_t v = links_.front().first;
    for (std::size_t i = 0; i < links_.size(); ++i) {
      ring_.push_back(v);
      const auto it = std::find_if(links_.begin(), links_.end(), [&](const auto& l) { return l.first == v; });
      if (it == links_.end()) return false;
      v = it->second;
      if (v == ring_.front() && i + 1 < links_.size()) return false;
    }
    return v == ring_.front();
  }
  /// The other two vertices u, w of a tet such that (a, b, u, w) is positive.
  static std::pair<std::int32_t, std::int32_t> link(const Tet& tet, std::int32_t a, std::int32_t b) {
    std::size_t ia = 0, ib = 0, rest[2] = {0, 0}, n = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      if (tet[i] == a)
        ia = i;
      else if (tet[i] == b)
        ib = i;
      else
        rest[n++] = i;
    }
    const bool odd = is_odd(ia, ib, rest[0], rest[1]);
    return {tet[rest[odd ? 1 : 0]], tet[rest[odd ? 0 : 1]]};
  }
  static bool is_odd(std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
    return ((a > b) + (a > c) + (a > d) + (b > c) + (b > d) + (c > d)) % 2 != 0;
  }
  /// Triangulates a polygon around edge ab, its vertices counter-clockwise seen from b, and joins it to both ends: the
  /// cheapest way (Klincsek's dynamic program). Adds the tets to tets_; false if none is cheaper than `limit`.
  bool triangulate_ring(const std::vector<std::int32_t>& ring, std::int32_t a, std::int32_t b, Cell cell,
                        double limit) {
    const std::size_t n = ring.size();
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
          const double ru = badness(up);
          if (!std::isfinite(ru)) continue;
          sum += cost(ru);
          if (!(sum < best[i][k]) || !(sum < limit)) continue;
          const double rd = badness(down);
          if (!std::isfinite(rd)) continue;
          sum += cost(rd);
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
  /// Takes an edge between the two planes of a slab out.
  void offer_edge_removal(std::int32_t a, std::int32_t b) {
    if (!find_ring(a, b)) return;
    double before = 0;
    for (const std::int32_t t : around_) before += cost(badness_[std::size_t(t)]);
    tets_.clear();
    cells_.clear();
    if (triangulate_ring(ring_, a, b, cell(around_.front()), before)) offer(around_, before);
  }
  /// Takes an edge of a plane out, in favor of the other diagonal of its two triangles: in both slabs, where both have
  /// material there.
  void offer_plane_flip(std::int32_t a, std::int32_t b) {
    const std::int32_t level = plane(a);
    old_.clear();
    double before = 0;
    std::int32_t first_slab = kNone;
    std::array<Cell, 2> cells{Cell{kNone, kNone}, Cell{kNone, kNone}};
    std::array<std::vector<std::pair<std::int32_t, std::int32_t>>, 2>& links = slab_links_;
    links[0].clear();
    links[1].clear();
    for (const std::int32_t t : at_[std::size_t(a)]) {
      const Tet& tet = mesh_.tets[std::size_t(t)];
      if (!has(tet, b)) continue;
      const Cell c = cell(t);
      if (first_slab == kNone) first_slab = c.slab;
      const std::size_t side = c.slab == first_slab ? 0 : 1;
      if (cells[side].slab == kNone) cells[side] = c;
      if (cells[side].region != c.region) return;
      links[side].push_back(link(tet, a, b));
      if (links[side].size() + 2 > kLongestRing) return;
      old_.push_back(t);
      before += cost(badness_[std::size_t(t)]);
    }
    std::array<std::int32_t, 2> ends{kNone, kNone};  // where the path of the first slab starts and ends
    tets_.clear();
    cells_.clear();
    for (std::size_t side = 0; side < 2; ++side) {
      if (links[side].empty()) continue;
      // The path starts at the vertex that no link leads to.
      std::int32_t v = kNone;
      for (const auto& l : links[side])
        if (std::none_of(links[side].begin(), links[side].end(), [&](const auto& m) { return m.second == l.first; }))
          v = l.first;
      if (v == kNone) return;
      ring_.assign(1, v);
      for (std::size_t i = 0; i < links[side].size(); ++i) {
        const auto it =
            std::find_if(links[side].begin(), links[side].end(), [&](const auto& l) { return l.first == v; });
        if (it == links[side].end()) return;
        v = it->second;
        ring_.push_back(v);
      }
      if (plane(ring_.front()) != level || plane(ring_.back()) != level) return;
      if (side == 0)
        ends = {ring_.front(), ring_.back()};
      else if (ring_.front() != ends[1] || ring_.back() != ends[0])
        return;
      if (!triangulate_ring(ring_, a, b, cells[side], before)) return;
    }
    std::stable_partition(old_.begin(), old_.end(), [&](std::int32_t t) { return cell(t).slab == first_slab; });
    offer(old_, before);
  }
  /// Puts an edge through the face opposite to vertex i of t.
  void offer_face_removal(std::int32_t t, std::size_t i) {
    const Tet tet = mesh_.tets[std::size_t(t)];
    const std::int32_t d = tet[i], a = tet[(i + 1) % 4];
    std::int32_t b = tet[(i + 2) % 4], c = tet[(i + 3) % 4];
    std::int32_t other = kNone, e = kNone;
    for (const std::int32_t u : at_[std::size_t(a)]) {
      const Tet& x = mesh_.tets[std::size_t(u)];
      if (u == t || !has(x, b) || !has(x, c)) continue;
      for (const std::int32_t v : x)
        if (v != a && v != b && v != c) e = v;
      if (mesh_.tet_slab[std::size_t(u)] == mesh_.tet_slab[std::size_t(t)]) other = u;
    }
    if (other == kNone || mesh_.tet_region[std::size_t(other)] != mesh_.tet_region[std::size_t(t)]) return;
    for (const std::int32_t v : mesh_.tets[std::size_t(other)])
      if (v != a && v != b && v != c) e = v;
    if (plane(d) == plane(e)) return;
    if (is_odd((i + 1) % 4, (i + 2) % 4, (i + 3) % 4, i)) std::swap(b, c);  // the tet is positive
    tets_.clear();
    tets_.push_back({e, d, a, b});
    tets_.push_back({e, d, b, c});
    tets_.push_back({e, d, c, a});
    old_.assign({t, other});
    cells_.assign(3, cell(t));
    offer(old_, cost(badness_[std::size_t(t)]) + cost(badness_[std::size_t(other)]));
  }
  bool apply_best() {
    if (best_.old.empty()) return false;
    ++stamp_;
    for (const std::int32_t t : best_.old) remove(t);
    for (std::size_t i = 0; i < best_.tets.size(); ++i)
      add(best_.tets[i], best_.cells[i].slab, best_.cells[i].region, best_.badnesses[i]);
    return true;
  }
  bool flip(std::int32_t t) {
    best_.gain = 0;
    best_.old.clear();
    const Tet tet = mesh_.tets[std::size_t(t)];
    for (const auto& e : kTetEdgeVertices) {
      const auto [a, b] = std::minmax(tet[e[0]], tet[e[1]]);
      // A change of a tet at the edge changes both of its ends.
      const std::uint32_t tried = tried_edge_.stamp(a, b);
      if (changed_[std::size_t(a)] <= tried || changed_[std::size_t(b)] <= tried) continue;
      gainful_ = false;
      if (plane(a) == plane(b))
        offer_plane_flip(a, b);
      else
        offer_edge_removal(a, b);
      if (!gainful_) tried_edge_.set(a, b, stamp_);
    }
    for (std::size_t i = 0; i < 4; ++i) offer_face_removal(t, i);
    return apply_best();
  }
  /// What is worse comes first, but by classes only: within a class neighbors in memory stay together.
  [[nodiscard]] static int rank(double badness) { return badness > kVeryBad ? 0 : (badness > kBad ? 1 : 2); }
  /// Tets above the target that something has changed at since they were tried, the worst class first.
  template <class Try>
  std::size_t for_bad(double target, std::vector<std::uint32_t>& tried, Try&& attempt) {
    tried.resize(mesh_.tets.size(), 0);
    std::vector<std::pair<int, std::int32_t>> bad;
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      if (!alive(std::int32_t(t)) || !(badness_[t] > target)) continue;
      std::uint32_t last = 0;
      for (const std::int32_t v : mesh_.tets[t]) last = std::max(last, changed_[std::size_t(v)]);
      if (last > tried[t]) bad.emplace_back(rank(badness_[t]), std::int32_t(t));
    }
    std::sort(bad.begin(), bad.end());
    std::size_t done = 0;
    for (const auto& [r, t] : bad) {
      poll();
      if (exhausted()) break;
      if (!alive(t) || !(badness_[std::size_t(t)] > target)) continue;
      if (attempt(t)) ++done;
      tried.resize(mesh_.tets.size(), 0);
      if (alive(t)) tried[std::size_t(t)] = stamp_;
    }
    return done;
  }
  std::size_t flip_round() {
    return for_bad(floor_, tried_flip_, [&](std::int32_t t) { return flip(t); });
  }

  // --- moves
  // ----------------------------------------------------------------------------------------------------------
  /// Vertices in the interior of contour edges, with the vertices they slide between.
  void find_sliding() {
    for (std::size_t k = 0; k < stack_.meshes.size(); ++k) {
      const PlaneMesh& mesh = stack_.meshes[k];
      std::vector<char> state(mesh.vertices.size(), 0);  // 1: seen inside of one chain, 2: fixed
      std::vector<Neighbors> between(mesh.vertices.size(), {kNone, kNone});
      for (const auto* all : {&mesh.below_chain, &mesh.above_chain})
        for (const auto& chain : *all)
          for (std::size_t i = 0; i < chain.size(); ++i) {
            const auto v = std::size_t(chain[i]);
            if (i == 0 || i + 1 == chain.size()) {
              state[v] = 2;
              continue;
            }
            const Neighbors n{std::min(chain[i - 1], chain[i + 1]), std::max(chain[i - 1], chain[i + 1])};
            if (state[v] == 0) {
              state[v] = 1;
              between[v] = n;
            } else if (state[v] == 1 && (between[v].previous != n.previous || between[v].next != n.next)) {
              state[v] = 2;
            }
          }
      for (std::size_t v = 0; v < state.size(); ++v) {
        if (state[v] != 1) continue;
        kind_[std::size_t(first_[k]) + v] = Kind::Sliding;
        slide_[first_[k] + std::int32_t(v)] = {first_[k] + between[v].previous, first_[k] + between[v].next};
      }
    }
  }
  /// The cost of tets; infinite if one is not positive, or as soon as it reaches `limit`.
  double cost_of(const std::vector<std::int32_t>& tets, double limit) {
    double sum = 0;
    for (const std::int32_t t : tets) {
      const double r = badness(mesh_.tets[std::size_t(t)]);
      sum += cost(r);
      if (!std::isfinite(r) || !(sum < limit)) return std::numeric_limits<double>::infinity();
    }
    return sum;
  }
  /// Vertices of these tets were moved.
  void rate_again(const std::vector<std::int32_t>& tets) {
    ++stamp_;
    for (const std::int32_t t : tets) {
      badness_[std::size_t(t)] = badness(mesh_.tets[std::size_t(t)]);
      for (const std::int32_t u : mesh_.tets[std::size_t(t)]) changed_[std::size_t(u)] = stamp_;
    }
  }
  /// The cost of the tets around v if v were at p; infinite if one is not positive, or as soon as it reaches `limit`.
  double cost_at(std::int32_t v, const GridPoint& p, double limit) {
    const GridPoint before = point(v);
    set_point(v, p);
    const double sum = cost_of(at_[std::size_t(v)], limit);
    set_point(v, before);
    return sum;
  }
  [[nodiscard]] bool all_positive(const std::vector<std::int32_t>& tets) const {
    return std::all_of(tets.begin(), tets.end(),
                       [&](std::int32_t t) { return volume(mesh_.tets[std::size_t(t)]) > 0; });
  }
  bool move_to(std::int32_t v, const GridPoint& p) {
    const GridPoint before = point(v);
    set_point(v, p);
    if (!all_positive(at_[std::size_t(v)])) {
      set_point(v, before);
      return false;
    }
    rate_again(at_[std::size_t(v)]);
    return true;
  }
  /// Looks for a better place: along the contour by pattern search, else down the gradient.
  bool smooth(std::int32_t v) {
    const Kind kind = kind_[std::size_t(v)];
    if (kind == Kind::Fixed || at_[std::size_t(v)].empty()) return false;
    const GridPoint start = point(v);
    double current = 0;
    double shortest = std::numeric_limits<double>::infinity();
    for (const std::int32_t t : at_[std::size_t(v)]) {
      current += cost(badness_[std::size_t(t)]);
      for (const std::int32_t u : mesh_.tets[std::size_t(t)])
        if (u != v && plane(u) == plane(v)) shortest = std::min(shortest, distance(start, point(u)));
    }
    const double initial = current;
    GridPoint best = start;
    double step = 0.3 * shortest;
    if (kind == Kind::Sliding) {
      const Neighbors n = slide_.at(v);
      const GridPoint a = point(resolve(n.previous)), b = point(resolve(n.next));
      const double length = distance(a, b);
      if (!(length > 4)) return false;
      const double dx = double(b.x - a.x) / length, dy = double(b.y - a.y) / length;
      double at = (double(start.x - a.x) * dx + double(start.y - a.y) * dy);
      step = 0.4 * std::min(at, length - at);
      for (int i = 0; i < 8; ++i) {
        bool better = false;
        for (const double s : {step, -step}) {
          const double next = at + s;
          if (!(next > 1) || !(next < length - 1)) continue;
          const GridPoint p{a.x + std::llround(next * dx), a.y + std::llround(next * dy)};
          const double c = cost_at(v, p, current);
          if (c < current) {
            current = c;
            best = p;
            at = next;
            better = true;
            break;
          }
        }
        if (!better) step /= 2;
      }
    } else {
      // One step down the gradient (forward differences), at first a third of the way to the nearest neighbor. More of
      // them before the neighbors, flips and collapses have their turn take longer and gain less.
      const double delta = std::max(1.0, 1e-5 * shortest);
      const double limit = std::numeric_limits<double>::infinity();
      const double gx = cost_at(v, {start.x + std::llround(delta), start.y}, limit) - current,
                   gy = cost_at(v, {start.x, start.y + std::llround(delta)}, limit) - current;
      const double g = std::hypot(gx, gy);
      if (!std::isfinite(g) || g == 0) return false;
      for (int k = 0; k < kStepSizes; ++k, step *= 0.4) {
        const GridPoint p{start.x - std::llround(step * gx / g), start.y - std::llround(step * gy / g)};
        const double c = cost_at(v, p, current);
        if (!(c < current)) continue;
        current = c;
        best = p;
        break;
      }
    }
    if (!(current < (1 - kLeastGain) * initial)) return false;
    return move_to(v, best);
  }
  /// Tries moves by class, the worst first, and marks when.
  template <class Try>
  std::size_t try_all(std::vector<std::pair<int, std::int32_t>>& order, std::vector<std::uint32_t>& tried,
                      Try&& attempt) {
    std::sort(order.begin(), order.end());
    std::size_t done = 0;
    for (const auto& [r, i] : order) {
      poll();
      if (exhausted()) break;
      if (attempt(i)) ++done;
      tried[std::size_t(i)] = stamp_;
    }
    return done;
  }
  std::size_t smooth_round() {
    // Movable vertices of bad tets.
    std::vector<double> worst(points_.size(), 0);
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t)
      if (alive(std::int32_t(t)) && badness_[t] > floor_)
        for (const std::int32_t v : mesh_.tets[t]) worst[std::size_t(v)] = std::max(worst[std::size_t(v)], badness_[t]);
    std::vector<std::pair<int, std::int32_t>> order;
    tried_smooth_.resize(points_.size(), 0);
    for (std::size_t v = 0; v < points_.size(); ++v)
      if (worst[v] > 0 && kind_[v] != Kind::Fixed && changed_[v] > tried_smooth_[v])
        order.emplace_back(rank(worst[v]), std::int32_t(v));
    return try_all(order, tried_smooth_, [&](std::int32_t v) { return smooth(v); });
  }

  // --- moves of contours
  // -------------------------------------------------------------------------------------------------
  /// Finds all that moves with a column, and the tets around it.
  void take_column(std::size_t index) {
    columns_->take(index, before_);
    star_.clear();
    for (const auto& [v, p] : before_)
      star_.insert(star_.end(), at_[std::size_t(v)].begin(), at_[std::size_t(v)].end());
    std::sort(star_.begin(), star_.end());
    star_.erase(std::unique(star_.begin(), star_.end()), star_.end());
  }
  void put(const std::vector<ContourColumns::Place>& places) {
    for (const auto& [v, p] : places) set_point(v, p);
  }
  /// The cost of the tets around the column if it were at p; infinite if it cannot be there, one is not positive, or it
  /// reaches `limit`. All stays at its new place.
  double column_cost_at(const GridPoint& p, double limit) {
    if (!columns_->places(p, after_)) return std::numeric_limits<double>::infinity();
    put(after_);
    return cost_of(star_, limit);
  }
  /// Moves a column down the gradient of the cost, or else along its contour.
  bool smooth_column(std::size_t index, ContourColumns::Keep keep) {
    take_column(index);
    const GridPoint from = columns_->place(index);
    double current = 0, shortest = std::numeric_limits<double>::infinity();
    for (const std::int32_t t : star_) current += cost(badness_[std::size_t(t)]);
    for (const std::int32_t v : columns_->vertices(index))
      for (const std::int32_t t : at_[std::size_t(v)])
        for (const std::int32_t u : mesh_.tets[std::size_t(t)])
          if (u != v && plane(u) == plane(v)) shortest = std::min(shortest, distance(from, point(u)));
    const double limit = std::numeric_limits<double>::infinity();
    const double delta = std::max(4 * double(kContourStep), 1e-5 * shortest);
    const GridPoint along = columns_->along(index);
    double tx = double(along.x), ty = double(along.y);
    const double t = std::hypot(tx, ty);
    if (t > 0) tx /= t, ty /= t;
    double slope = 0;
    if (columns_->on_edge(index)) {
      slope = column_cost_at({from.x + std::llround(delta * tx), from.y + std::llround(delta * ty)}, limit) - current;
      put(before_);
      if (!std::isfinite(slope) || slope == 0) return false;
    } else {
      const double gx = column_cost_at({from.x + std::llround(delta), from.y}, limit) - current,
                   gy = column_cost_at({from.x, from.y + std::llround(delta)}, limit) - current;
      const double g = std::hypot(gx, gy);
      put(before_);
      if (!std::isfinite(g) || g == 0) return false;
      if (column_descends(index, -gx / g, -gy / g, shortest, current, keep)) return true;
      slope = (gx * tx + gy * ty) / g;
      if (!(std::fabs(slope) > kLeastSlope)) return false;
    }
    return column_descends(index, -std::copysign(tx, slope), -std::copysign(ty, slope), shortest, current, keep);
  }
  /// Tries steps in one direction, the longest first.
  bool column_descends(std::size_t index, double dx, double dy, double shortest, double current,
                       ContourColumns::Keep keep) {
    const GridPoint from = columns_->place(index);
    const double least = (1 - kLeastGain) * current;
    double step = std::min(0.3 * shortest, columns_->reach());
    for (int k = 0; k < kStepSizes; ++k, step *= 0.4) {
      if (column_cost_at({from.x + std::llround(step * dx), from.y + std::llround(step * dy)}, least) < least &&
          all_positive(star_) && columns_->may_move(keep)) {
        columns_->moved();
        rate_again(star_);
        return true;
      }
      put(before_);
    }
    return false;
  }
  /// Contours move only where elements are bad after other means had their turn: elsewhere they stay what they are.
  std::size_t column_round(std::int32_t round) {
    if (!columns_ || round < kFirstColumnRound) return 0;
    std::vector<double> worst(columns_->size(), 0);
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t)
      if (alive(std::int32_t(t)) && badness_[t] > floor_)
        for (const std::int32_t v : mesh_.tets[t])
          if (columns_->of(v) != kNone) {
            double& w = worst[std::size_t(columns_->of(v))];
            w = std::max(w, badness_[t]);
          }
    const auto keep = [](double badness) {
      using Keep = ContourColumns::Keep;
      return badness > kVeryBad ? Keep::Nearness : badness > kBad ? Keep::Walls : Keep::Areas;
    };
    tried_column_.resize(columns_->size(), 0);
    std::vector<std::pair<int, std::int32_t>> order;
    for (std::size_t i = 0; i < worst.size(); ++i) {
      if (!(worst[i] > 0) || !columns_->movable(i, keep(worst[i]))) continue;
      std::uint32_t last = 0;
      for (const std::int32_t v : columns_->vertices(i)) last = std::max(last, changed_[std::size_t(v)]);
      if (last > tried_column_[i]) order.emplace_back(rank(worst[i]), std::int32_t(i));
    }
    return try_all(order, tried_column_,
                   [&](std::int32_t i) { return smooth_column(std::size_t(i), keep(worst[std::size_t(i)])); });
  }

  // --- collapses
  // ------------------------------------------------------------------------------------------------------
  [[nodiscard]] std::int32_t resolve(std::int32_t v) const {
    while (gone_[std::size_t(v)] != kNone) v = gone_[std::size_t(v)];
    return v;
  }
  /// Moves v into its neighbor u in the plane if that makes the worst tet around better.
  bool collapse(std::int32_t v, std::int32_t u) {
    double worst = 0, sum_before = 0, sum_after = 0;
    for (const std::int32_t t : at_[std::size_t(v)]) {
      worst = std::max(worst, badness_[std::size_t(t)]);
      sum_before += badness_[std::size_t(t)] - kGoodRatio;
    }
    const double limit = std::max(worst, kTolerable);
    for (const std::int32_t t : at_[std::size_t(v)]) {
      Tet tet = mesh_.tets[std::size_t(t)];
      if (has(tet, u)) continue;
      std::replace(tet.begin(), tet.end(), v, u);
      if (volume(tet) <= 0) return false;
      const double r = badness(tet);
      sum_after += r - kGoodRatio;
      if (!(r <= limit)) return false;
    }
    if (!(sum_after < sum_before - kCollapseGain)) return false;
    // Volumes balance: nothing is left out or covered twice.
    std::unordered_map<std::int32_t, Int128> balance;
    for (const std::int32_t t : at_[std::size_t(v)]) {
      Tet tet = mesh_.tets[std::size_t(t)];
      Int128& sum = balance[mesh_.tet_slab[std::size_t(t)]];
      sum -= volume(tet);
      if (has(tet, u)) continue;
      std::replace(tet.begin(), tet.end(), v, u);
      sum += volume(tet);
    }
    if (kind_[std::size_t(v)] == Kind::Free)
      for (const auto& [slab, sum] : balance)
        if (sum != 0) return false;
    ++stamp_;
    const std::vector<std::int32_t> star = at_[std::size_t(v)];
    for (const std::int32_t t : star) {
      Tet tet = mesh_.tets[std::size_t(t)];
      const std::int32_t slab = mesh_.tet_slab[std::size_t(t)], region = mesh_.tet_region[std::size_t(t)];
      remove(t);
      if (has(tet, u)) continue;
      std::replace(tet.begin(), tet.end(), v, u);
      add(tet, slab, region, badness(tet));
    }
    gone_[std::size_t(v)] = u;
    return true;
  }
  bool collapse_any(std::int32_t t) {
    const Tet tet = mesh_.tets[std::size_t(t)];
    std::vector<std::pair<double, std::pair<std::int32_t, std::int32_t>>> pairs;
    for (const std::int32_t v : tet) {
      if (kind_[std::size_t(v)] == Kind::Fixed) continue;
      std::vector<std::int32_t> neighbors;
      if (kind_[std::size_t(v)] == Kind::Sliding) {
        const Neighbors n = slide_.at(v);
        neighbors = {resolve(n.previous), resolve(n.next)};
      } else {
        for (const std::int32_t s : at_[std::size_t(v)])
          for (const std::int32_t u : mesh_.tets[std::size_t(s)])
            if (u != v && plane(u) == plane(v)) neighbors.push_back(u);
        std::sort(neighbors.begin(), neighbors.end());
        neighbors.erase(std::unique(neighbors.begin(), neighbors.end()), neighbors.end());
      }
      for (const std::int32_t u : neighbors)
        if (u != v) pairs.push_back({distance(point(v), point(u)), {v, u}});
    }
    std::sort(pairs.begin(), pairs.end());
    for (const auto& [d, vu] : pairs) {
      const auto [v, u] = vu;
      if (changed_[std::size_t(v)] <= tried_pair_.stamp(v, u)) continue;
      if (collapse(v, u)) return true;
      tried_pair_.set(v, u, stamp_);
    }
    return false;
  }
  std::size_t collapse_round() {
    return for_bad(std::max(floor_, options_.collapse_above), tried_collapse_,
                   [&](std::int32_t t) { return collapse_any(t); });
  }

  // --- result
  // ---------------------------------------------------------------------------------------------------------
  void write_back() {
    std::size_t kept = 0;
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      if (!alive(std::int32_t(t))) continue;
      mesh_.tets[kept] = mesh_.tets[t];
      mesh_.tet_slab[kept] = mesh_.tet_slab[t];
      mesh_.tet_region[kept] = mesh_.tet_region[t];
      ++kept;
    }
    mesh_.tets.resize(kept);
    mesh_.tet_slab.resize(kept);
    mesh_.tet_region.resize(kept);
    std::vector<std::int32_t> index(points_.size(), kNone);
    std::int32_t next = 0;
    for (std::size_t k = 0; k < stack_.meshes.size(); ++k) {
      report(progress_, Stage::Improve, 1);
      PlaneMesh& mesh = stack_.meshes[k];
      const std::int32_t first = first_[k], new_first = next;
      std::vector<GridPoint> vertices;
      std::vector<char> fixed;
      for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        const std::size_t global = std::size_t(first) + v;
        if (gone_[global] != kNone) continue;
        index[global] = next++;
        vertices.push_back(points_[global]);
        fixed.push_back(mesh.fixed[v]);
      }
      mesh.vertices = std::move(vertices);
      mesh.fixed = std::move(fixed);
      const auto local = [&](std::int32_t v) { return index[std::size_t(resolve(first + v))] - new_first; };
      mesh.triangles.clear();
      mesh.sides.clear();
      for (auto* all : {&mesh.below_chain, &mesh.above_chain})
        for (auto& chain : *all) {
          for (std::int32_t& v : chain) v = local(v);
          chain.erase(std::unique(chain.begin(), chain.end()), chain.end());
        }
    }
    collect_triangles(index);
    for (Tet& t : mesh_.tets)
      for (std::int32_t& v : t) v = index[std::size_t(v)];
  }
  /// The triangles of the planes are the horizontal faces of tets.
  void collect_triangles(const std::vector<std::int32_t>& index) {
    std::vector<std::int32_t> start(stack_.meshes.size(), 0);
    for (std::size_t k = 1; k < start.size(); ++k)
      start[k] = start[k - 1] + std::int32_t(stack_.meshes[k - 1].vertices.size());
    struct Face {
      std::array<std::int32_t, 3> sorted, vertices;
      std::size_t side;  // 0: the tet is below
      Side cell;
      bool operator<(const Face& o) const { return sorted != o.sorted ? sorted < o.sorted : side < o.side; }
    };
    std::vector<std::vector<Face>> faces_of(stack_.meshes.size());
    Poll listen(to_listener_, 1 << 16);
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      listen();
      const Tet& tet = mesh_.tets[t];
      for (std::size_t i = 0; i < 4; ++i) {
        const std::int32_t a = tet[(i + 1) % 4], b = tet[(i + 2) % 4], c = tet[(i + 3) % 4];
        if (plane(a) != plane(b) || plane(a) != plane(c)) continue;
        Face face;
        const auto level = std::size_t(plane(a));
        face.vertices = {index[std::size_t(a)], index[std::size_t(b)], index[std::size_t(c)]};
        for (std::int32_t& v : face.vertices) v -= start[level];
        if (orientation(point(a), point(b), point(c)) < 0) std::swap(face.vertices[1], face.vertices[2]);
        std::rotate(face.vertices.begin(), std::min_element(face.vertices.begin(), face.vertices.end()),
                    face.vertices.end());
        face.sorted = face.vertices;
        std::sort(face.sorted.begin(), face.sorted.end());
        face.side = plane(tet[i]) < plane(a) ? 0 : 1;
        face.cell = {mesh_.tet_slab[t], mesh_.tet_region[t]};
        faces_of[level].push_back(face);
      }
    }
    for (std::size_t k = 0; k < faces_of.size(); ++k) {
      to_listener_();
      std::vector<Face>& faces = faces_of[k];
      std::sort(faces.begin(), faces.end());
      PlaneMesh& mesh = stack_.meshes[k];
      for (std::size_t f = 0; f < faces.size(); ++f) {
        if (f == 0 || faces[f - 1].sorted != faces[f].sorted) {
          mesh.triangles.push_back(faces[f].vertices);
          mesh.sides.emplace_back();
        }
        mesh.sides.back()[faces[f].side] = faces[f].cell;
      }
    }
  }

  static constexpr double kLookAtAngles = 3.5;  ///< R/3r; angles of better tets are not small
  static constexpr double kAngleWeight = 0.6;   ///< over the sine of a dihedral angle: 4 degrees are as bad as 8.6
  static constexpr double kVeryBad = 8;         ///< R/3r
  static constexpr double kBad = 3;             ///< R/3r; what is above is worked on first
  static constexpr std::int32_t kFirstColumnRound = 2;  ///< from 0; flips and free vertices have their turn before
  static constexpr double kLittle = 0.4;          ///< of the operations of the best round: what is bad has had its turn
  static constexpr double kLeastGain = 3e-3;      ///< share of the cost that a flip or a move has to gain
  static constexpr int kStepSizes = 4;            ///< of a move, each 0.4 of the one before
  static constexpr std::size_t kLongestRing = 9;  ///< edges with more tets around are not taken out
  static constexpr double kLeastSlope = 0.1;      ///< share of the gradient that a move along a contour has to have
  static constexpr double kCollapseGain = 0.1;    ///< what a collapse has to gain in the sum of R/3r ...
  static constexpr double kGoodRatio = 1.3;       ///< ... above this: that of a column
  static constexpr double kTolerable = 6;         ///< R/3r; a collapse may make a tet worse than the worst up to this

  PlaneStack& stack_;
  Mesh& mesh_;
  const ImproveOptions& options_;
  const Progress& progress_;
  const std::function<void()> to_listener_ = [this] { report(progress_, Stage::Improve, share_); };
  std::vector<std::int32_t> first_;         // #P + 1, first vertex of each plane
  std::vector<GridPoint> points_;           // #V
  std::vector<std::int32_t> plane_;         // #V
  std::vector<Kind> kind_;                  // #V
  std::vector<std::array<double, 3>> xyz_;  // #V, the same with heights, in pitches; exact but for the heights
  std::unordered_map<std::int32_t, Neighbors> slide_;
  std::vector<std::vector<std::int32_t>> at_;  // #V, tets
  std::vector<double> badness_;                // #T
  std::vector<std::int32_t> unused_;
  std::vector<std::uint32_t> changed_;  // #V, stamp of the last change around
  std::vector<std::int32_t> gone_;      // #V, the vertex it went into
  std::uint32_t stamp_ = 1;
  std::unique_ptr<ContourColumns> columns_;
  double floor_ = kBad;
  mutable std::int64_t work_ = 0;  // tets rated
  std::int64_t next_poll_ = 0;
  double share_ = 0;  // of the rounds
  std::vector<std::uint32_t> tried_flip_, tried_smooth_, tried_column_, tried_collapse_;
  Memory tried_edge_, tried_pair_;
  Flip best_;
  bool gainful_ = false;  // the edge that is tried, perhaps
  std::vector<std::int32_t> around_, ring_, old_;
  std::vector<std::pair<std::int32_t, std::int32_t>> links_;
  std::vector<std::pair<std::size_t, std::size_t>> spans_;
  std::vector<Tet> tets_;
  std::vector<Cell> cells_;
  std::array<std::vector<std::pair<std::int32_t, std::int32_t>>, 2> slab_links_;
  std::vector<double> badnesses_;
  std::vector<std::int32_t> star_;                     // tets around the column in question
  std::vector<ContourColumns::Place> before_, after_;  // where what moves with it was, and where it would go
};

}  // namespace slice2mesh::detail
