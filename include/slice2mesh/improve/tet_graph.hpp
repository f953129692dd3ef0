// SPDX-License-Identifier: MIT
/// @file
/// @brief The tets of a stack while they are improved: neighbors, stars, ratings, and changes of all these.
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
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/improve/short_lists.hpp"
#include "slice2mesh/triangulate/plane_stack.hpp"

namespace slice2mesh::detail {

inline constexpr double kLookAtAngles = 2.5;  ///< R/3r; angles of better tets are not small
inline constexpr double kAngleWeight = 0.7;   ///< over the sine of a dihedral angle: 4 degrees are as bad as R/3r of 10

/// Tets of all slabs with their neighbors, and vertices with the tets around. Vertices of all planes are counted
/// through. A stamp says of every vertex when a tet around it changed last.
class TetGraph {
public:
  using Tet = std::array<std::int32_t, 4>;
  /// A tet; `v[0]` is kNone where there is none any more.
  struct Element {
    Tet v{kNone, kNone, kNone, kNone};
    std::array<std::int32_t, 4> across{kNone, kNone, kNone, kNone};  ///< the tet opposite to v[i], or kNone
    std::int32_t slab = kNone, region = kNone;
    std::uint32_t tried_flip = 0, tried_collapse = 0;  ///< stamps
  };
  struct Cell {
    std::int32_t slab, region;
    friend bool operator==(const Cell& a, const Cell& b) { return a.slab == b.slab && a.region == b.region; }
  };
  using Vector = std::array<double, 3>;

  /// Takes the tets out of the mesh. `pitch`: of the grid, mm. `listen` is told what is looked at, here and below.
  TetGraph(const PlaneStack& stack, Mesh& mesh, double pitch, Poll listen) {
    for (std::size_t k = 0; k < stack.meshes.size(); ++k) {
      listen(stack.meshes[k].vertices.size());
      first_.push_back(std::int32_t(points_.size()));
      const PlaneMesh& plane = stack.meshes[k];
      points_.insert(points_.end(), plane.vertices.begin(), plane.vertices.end());
      plane_.resize(points_.size(), std::int32_t(k));
      for (const GridPoint& p : plane.vertices) xyz_.push_back({double(p.x), double(p.y), plane.z / pitch});
    }
    first_.push_back(std::int32_t(points_.size()));
    elements_.reserve(mesh.tets.size());  // and filled below: memory that is touched all at once takes its time
    const std::vector<std::int32_t> order = spatial_order(mesh, listen);
    for (std::size_t t = 0; t < order.size(); ++t) {
      listen();
      elements_.emplace_back();
      elements_[t].v = mesh.tets[std::size_t(order[t])];
      elements_[t].slab = mesh.tet_slab[std::size_t(order[t])];
      elements_[t].region = mesh.tet_region[std::size_t(order[t])];
    }
    // Lists that are given {} keep their memory.
    mesh.tets = std::vector<Tet>();
    mesh.tet_slab = std::vector<std::int32_t>();
    mesh.tet_region = std::vector<std::int32_t>();
    std::vector<std::int32_t> degree(points_.size(), 0);
    for (const Element& e : elements_) {
      listen();
      for (const std::int32_t v : e.v) ++degree[std::size_t(v)];
    }
    listen(points_.size());
    stars_.reset(degree);
    badness_.reserve(elements_.size());
    for (std::size_t t = 0; t < elements_.size(); ++t) {
      listen();
      for (const std::int32_t v : elements_[t].v) stars_.add(std::size_t(v), std::int32_t(t));
      badness_.push_back(rate(elements_[t].v));
    }
    find_neighbors(listen);
    changed_.assign(points_.size(), 1);
  }

  // --- vertices
  [[nodiscard]] const std::vector<std::int32_t>& first() const { return first_; }  ///< #P + 1, vertex of each plane
  [[nodiscard]] const std::vector<GridPoint>& points() const { return points_; }   ///< #V
  [[nodiscard]] const GridPoint& point(std::int32_t v) const { return points_[std::size_t(v)]; }
  /// In pitches; exact but for the height.
  [[nodiscard]] const Vector& xyz(std::int32_t v) const { return xyz_[std::size_t(v)]; }
  [[nodiscard]] std::int32_t plane(std::int32_t v) const { return plane_[std::size_t(v)]; }
  /// Tets around a vertex, in no order.
  [[nodiscard]] ShortLists::View star(std::int32_t v) const { return stars_[std::size_t(v)]; }
  /// Ratings and stamps are for the caller to bring up to date (rated()).
  void set_point(std::int32_t v, const GridPoint& p) {
    points_[std::size_t(v)] = p;
    xyz_[std::size_t(v)][0] = double(p.x);
    xyz_[std::size_t(v)][1] = double(p.y);
  }

  /// A new vertex without tets and, for now, without a place.
  std::int32_t add_vertex() {
    points_.push_back({});
    xyz_.push_back({});
    plane_.push_back(kNone);
    stars_.add_list();
    changed_.push_back(stamp_);
    return std::int32_t(points_.size()) - 1;
  }
  /// Puts a vertex without tets on the plane of another one.
  void put_on_plane_of(std::int32_t v, std::int32_t other) {
    plane_[std::size_t(v)] = plane(other);
    xyz_[std::size_t(v)][2] = xyz(other)[2];
  }

  /// Is there a vertical edge at a vertex?
  [[nodiscard]] bool is_in_column(std::int32_t v) const {
    const ShortLists::View tets = star(v);
    return std::any_of(tets.begin(), tets.end(), [&](std::int32_t t) {
      const Tet& tet = (*this)[t].v;
      return std::any_of(tet.begin(), tet.end(), [&](std::int32_t u) { return u != v && point(u) == point(v); });
    });
  }

  // --- tets
  [[nodiscard]] std::size_t size() const { return elements_.size(); }
  [[nodiscard]] const Element& operator[](std::int32_t t) const { return elements_[std::size_t(t)]; }
  [[nodiscard]] Element& operator[](std::int32_t t) { return elements_[std::size_t(t)]; }
  [[nodiscard]] bool alive(std::int32_t t) const { return elements_[std::size_t(t)].v[0] != kNone; }
  [[nodiscard]] Cell cell(std::int32_t t) const { return {(*this)[t].slab, (*this)[t].region}; }
  /// The rating of a tet; 0 where there is none any more.
  [[nodiscard]] double badness(std::int32_t t) const { return badness_[std::size_t(t)]; }
  [[nodiscard]] static bool has(const Tet& t, std::int32_t v) {
    return t[0] == v || t[1] == v || t[2] == v || t[3] == v;
  }
  /// Index of a vertex in a tet that has it.
  [[nodiscard]] static std::size_t index_of(const Tet& t, std::int32_t v) {
    return t[0] == v ? 0 : t[1] == v ? 1 : t[2] == v ? 2 : 3;
  }

  // --- stamps
  [[nodiscard]] std::uint32_t stamp() const { return stamp_; }
  [[nodiscard]] std::uint32_t changed(std::int32_t v) const { return changed_[std::size_t(v)]; }
  [[nodiscard]] std::uint32_t changed(const Tet& t) const {
    return std::max({changed(t[0]), changed(t[1]), changed(t[2]), changed(t[3])});
  }
  /// Begins a change: what is changed from here on is younger than what was tried before.
  void new_stamp() { ++stamp_; }
  /// A vertex of a tet was moved; this is its rating now.
  void rated(std::int32_t t, double badness) {
    badness_[std::size_t(t)] = badness;
    for (const std::int32_t v : elements_[std::size_t(t)].v) changed_[std::size_t(v)] = stamp_;
  }

  // --- geometry
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
  template <class Tets>
  [[nodiscard]] bool all_positive(const Tets& tets) const {
    return std::all_of(tets.begin(), tets.end(), [&](std::int32_t t) { return volume((*this)[t].v) > 0; });
  }
  /// How bad a tet is: R/3r, or what its sharpest dihedral angle (or that of its flattest edge) amounts to, if that is
  /// more; infinity unless it is positive. In plain floating point: it ranks, and decides nothing else.
  [[nodiscard]] double rate(const Tet& t) const {
    const Vector &o = xyz(t[0]), &a = xyz(t[1]), &b = xyz(t[2]), &c = xyz(t[3]);
    return rate({{{a[0] - o[0], a[1] - o[1], a[2] - o[2]},
                  {b[0] - o[0], b[1] - o[1], b[2] - o[2]},
                  {c[0] - o[0], c[1] - o[1], c[2] - o[2]}}});
  }
  /// The same by the edges from one vertex to the others.
  [[nodiscard]] double rate(const std::array<Vector, 3>& e) const {
    ++work_;
    double square[3];
    for (std::size_t i = 0; i < 3; ++i) square[i] = e[i][0] * e[i][0] + e[i][1] * e[i][1] + e[i][2] * e[i][2];
    Vector n[3], sum{}, center{};
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
      const Vector opposite{e[k][0] - e[j][0], e[k][1] - e[j][1], e[k][2] - e[j][2]};
      least = std::min({least, std::sqrt(square[i]) / (area[j] * area[k]), norm(opposite) / (base * area[i])});
    }
    return std::max(r, kAngleWeight / (least * det));
  }
  /// Ratings so far: a measure of time that is the same on every machine.
  [[nodiscard]] std::int64_t work() const { return work_; }
  /// Counts ratings that were made elsewhere.
  void count(std::int64_t ratings) const { work_ += ratings; }

  // --- changes
  /// Takes tets out and puts others into the same place, which they fill.
  void replace(const std::vector<std::int32_t>& old, const std::vector<Tet>& tets, const std::vector<Cell>& cells,
               const std::vector<double>& badnesses) {
    new_stamp();
    open_.clear();
    for (const std::int32_t t : old) {
      if (trial_) log_removal(t);
      remove(t);
    }
    for (const std::int32_t t : old) open_faces_at(t);
    for (std::size_t i = 0; i < tets.size(); ++i) {
      const std::int32_t t = add(tets[i], cells[i], badnesses[i]);
      if (trial_) put_.push_back(t);
      for (std::size_t k = 0; k < 4; ++k) join(face_of(t, k));
    }
    for (const Face& face : open_) across(face) = kNone;
  }
  /// What follows is on trial: all that replace() does can be taken back. Ratings may change, of new tets.
  void begin_trial() {
    trial_ = true;
    taken_.clear();
    put_.clear();
    stamps_.clear();
  }
  /// Tets that are new since the trial began.
  [[nodiscard]] const std::vector<std::int32_t>& put() const { return put_; }
  /// The sum of a function of the ratings of the tets that are gone since.
  template <class F>
  [[nodiscard]] double sum_of_taken(F&& f) const {
    double sum = 0;
    for (const Taken& t : taken_) sum += f(t.badness);
    return sum;
  }
  /// Ends the trial, and leaves all as it is, or as it was.
  void end_trial(bool keep) {
    trial_ = false;
    if (keep) return;
    open_.clear();
    for (const std::int32_t t : put_) remove(t);
    for (const std::int32_t t : put_) open_faces_at(t);
    for (const Taken& t : taken_) {
      unused_.erase(std::find(unused_.rbegin(), unused_.rend(), t.index).base() - 1);
      badness_[std::size_t(t.index)] = t.badness;
      Element& e = (*this)[t.index];
      e = t.element;
      e.across.fill(kNone);
      for (const std::int32_t v : e.v) stars_.add(std::size_t(v), t.index);
      for (std::size_t k = 0; k < 4; ++k) join(face_of(t.index, k));
    }
    for (const Face& face : open_) across(face) = kNone;
    // All is as it was: what was tried there need not be tried again.
    for (auto s = stamps_.rbegin(); s != stamps_.rend(); ++s) changed_[std::size_t(s->first)] = s->second;
  }
  /// Moves a vertex into another one: the tets that have both are gone.
  void collapse(std::int32_t v, std::int32_t u) {
    new_stamp();
    const std::vector<std::int32_t> star(stars_[std::size_t(v)].begin(), stars_[std::size_t(v)].end());
    for (const std::int32_t t : star) {
      Element& e = (*this)[t];
      if (!has(e.v, u)) continue;
      // Its two other faces with v and u become one.
      const std::int32_t a = e.across[index_of(e.v, u)], b = e.across[index_of(e.v, v)];
      for (const auto& [one, other] : {std::pair{a, b}, std::pair{b, a}}) {
        if (one == kNone) continue;
        auto& links = (*this)[one].across;
        *std::find(links.begin(), links.end(), t) = other;
      }
      remove(t);
    }
    for (const std::int32_t t : star) {
      if (!alive(t)) continue;
      Element& e = (*this)[t];
      e.v[index_of(e.v, v)] = u;
      stars_.add(std::size_t(u), t);
      rated(t, rate(e.v));
    }
    stars_.clear(std::size_t(v));
    changed_[std::size_t(v)] = stamp_;
  }
  /// Puts the tets back, with other numbers for their vertices.
  void give_back(Mesh& mesh, const std::vector<std::int32_t>& index, Poll& listen) {
    stars_ = {};
    mesh.tets.reserve(elements_.size() - unused_.size());
    mesh.tet_slab.reserve(elements_.size() - unused_.size());
    mesh.tet_region.reserve(elements_.size() - unused_.size());
    for (const Element& e : elements_) {
      listen();
      if (e.v[0] == kNone) continue;
      mesh.tets.push_back(e.v);
      for (std::int32_t& v : mesh.tets.back()) v = index[std::size_t(v)];
      mesh.tet_slab.push_back(e.slab);
      mesh.tet_region.push_back(e.region);
    }
    elements_ = std::vector<Element>();
  }

private:
  /// Tets by slabs, and in a slab along a Morton curve: what is near in space is near in memory.
  [[nodiscard]] std::vector<std::int32_t> spatial_order(const Mesh& mesh, Poll& listen) const {
    GridPoint low{kGridLimit, kGridLimit}, high{-kGridLimit, -kGridLimit};
    for (const GridPoint& p : points_) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
    int shift = 2;  // sums of four coordinates, to 16 bits
    while ((std::max(high.x - low.x, high.y - low.y) >> (shift - 2)) >= (1 << 16)) ++shift;
    const auto spread = [](std::int64_t n) {
      auto x = std::uint64_t(n);
      x = (x | x << 8) & 0x00ff00ffU;
      x = (x | x << 4) & 0x0f0f0f0fU;
      x = (x | x << 2) & 0x33333333U;
      return (x | x << 1) & 0x55555555U;
    };
    std::vector<std::size_t> start(mesh.slabs.size() + 1, 0);
    for (const std::int32_t slab : mesh.tet_slab) ++start[std::size_t(slab) + 1];
    for (std::size_t s = 1; s < start.size(); ++s) start[s] += start[s - 1];
    std::vector<std::size_t> next(start.begin(), start.end() - 1);
    std::vector<std::uint64_t> keys(mesh.tets.size());  // of the place, then the tet: 32 bits each
    for (std::size_t t = 0; t < keys.size(); ++t) {
      listen();
      std::int64_t x = -4 * low.x, y = -4 * low.y;
      for (const std::int32_t v : mesh.tets[t]) {
        x += point(v).x;
        y += point(v).y;
      }
      keys[next[std::size_t(mesh.tet_slab[t])]++] = (spread(x >> shift) | spread(y >> shift) << 1) << 32 | t;
    }
    for (std::size_t s = 0; s + 1 < start.size(); ++s)
      sort_listening(keys.begin() + std::ptrdiff_t(start[s]), keys.begin() + std::ptrdiff_t(start[s + 1]), listen);
    std::vector<std::int32_t> order(keys.size());
    for (std::size_t t = 0; t < keys.size(); ++t) order[t] = std::int32_t(keys[t] & 0xffffffffU);
    return order;
  }
  /// A tet that a trial has taken out.
  struct Taken {
    std::int32_t index;
    Element element;
    double badness;
  };
  /// A face that waits for the other tet at it.
  struct Face {
    std::int32_t a, b, c;  // vertices, ascending
    std::int32_t tet;
    std::size_t opposite;
  };
  [[nodiscard]] static double norm(const Vector& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }
  [[nodiscard]] Face face_of(std::int32_t t, std::size_t opposite) const {
    const Tet& v = (*this)[t].v;
    std::int32_t a = v[(opposite + 1) % 4], b = v[(opposite + 2) % 4], c = v[(opposite + 3) % 4];
    if (a > b) std::swap(a, b);
    if (b > c) std::swap(b, c);
    if (a > b) std::swap(a, b);
    return {a, b, c, t, opposite};
  }
  [[nodiscard]] std::int32_t& across(const Face& face) { return (*this)[face.tet].across[face.opposite]; }
  /// Joins a face with the one that waits for it, or lets it wait.
  void join(const Face& face) {
    for (Face& other : open_) {
      if (other.a != face.a || other.b != face.b || other.c != face.c) continue;
      across(face) = other.tet;
      across(other) = face.tet;
      other = open_.back();
      open_.pop_back();
      return;
    }
    open_.push_back(face);
  }
  /// Every face at its lowest vertex.
  void find_neighbors(Poll& listen) {
    for (std::int32_t v = 0; v < std::int32_t(stars_.size()); ++v) {
      listen();
      open_.clear();
      for (const std::int32_t t : stars_[std::size_t(v)]) {
        // The lowest vertex of a tet is that of three faces, the next one of the face without the lowest.
        const Tet& tet = (*this)[t].v;
        std::size_t lower = 0, last = 0;
        for (std::size_t i = 0; i < 4; ++i)
          if (tet[i] < v) {
            ++lower;
            last = i;
          }
        if (lower == 1) join(face_of(t, last));
        if (lower != 0) continue;
        for (std::size_t i = 0; i < 4; ++i)
          if (tet[i] != v) join(face_of(t, i));
      }
    }
  }
  /// The faces of a tet that is gone wait for others, those that a tet is left at.
  void open_faces_at(std::int32_t t) {
    for (const std::int32_t n : (*this)[t].across) {
      if (n == kNone || !alive(n)) continue;
      const Element& e = (*this)[n];
      std::size_t k = 0;
      while (e.across[k] != t) ++k;
      open_.push_back(face_of(n, k));
    }
  }
  void log_removal(std::int32_t t) {
    const Element& e = (*this)[t];
    const auto own = std::find(put_.begin(), put_.end(), t);
    if (own != put_.end())
      put_.erase(own);
    else
      taken_.push_back({t, e, badness(t)});
    for (const std::int32_t v : e.v) stamps_.emplace_back(v, changed(v));
  }
  void remove(std::int32_t t) {
    for (const std::int32_t v : (*this)[t].v) {
      stars_.remove(std::size_t(v), t);
      changed_[std::size_t(v)] = stamp_;
    }
    (*this)[t].v[0] = kNone;
    badness_[std::size_t(t)] = 0;
    unused_.push_back(t);
  }
  std::int32_t add(const Tet& tet, const Cell& cell, double badness) {
    std::int32_t t = 0;
    if (unused_.empty()) {
      t = std::int32_t(elements_.size());
      elements_.emplace_back();
      badness_.push_back(badness);
    } else {
      t = unused_.back();
      unused_.pop_back();
      badness_[std::size_t(t)] = badness;
    }
    Element& e = (*this)[t];
    e = {};
    e.v = tet;
    e.slab = cell.slab;
    e.region = cell.region;
    for (const std::int32_t v : tet) {
      stars_.add(std::size_t(v), t);
      changed_[std::size_t(v)] = stamp_;
    }
    return t;
  }

  std::vector<std::int32_t> first_;
  std::vector<GridPoint> points_;
  std::vector<Vector> xyz_;  // the same with heights
  std::vector<std::int32_t> plane_;
  ShortLists stars_;
  std::vector<std::uint32_t> changed_;  // #V, stamps
  std::vector<Element> elements_;
  std::vector<double> badness_;  // #T; apart, as it is looked through in every round
  std::vector<std::int32_t> unused_;
  std::vector<Face> open_;
  bool trial_ = false;
  std::vector<Taken> taken_;                                    // since the trial began ...
  std::vector<std::int32_t> put_;                               // ... and what is there instead ...
  std::vector<std::pair<std::int32_t, std::uint32_t>> stamps_;  // ... and the stamps of vertices before
  std::uint32_t stamp_ = 1;
  mutable std::int64_t work_ = 0;
};

}  // namespace slice2mesh::detail
