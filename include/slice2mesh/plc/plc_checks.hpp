// SPDX-License-Identifier: MIT
/// @file
/// @brief What the checks of complexes and meshes have in common.
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/core/compensated_sum.hpp"
#include "slice2mesh/core/grid.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/progress.hpp"

namespace slice2mesh {

/// One check: its name, for programs, and what was found, for people.
struct CertificateCheck {
  /// For programs, such as "positive".
  std::string name;
  /// Whether it holds.
  bool passed = false;
  /// For people: numbers, and the first offenders.
  std::string detail;
};

namespace detail {

/// Shortest text of a number that reads back the same.
[[nodiscard]] inline std::string number_text(double v) {
  std::array<char, 40> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), v);
  return {buffer.data(), end.ptr};
}

/// Counts offenders of a check and names the first ones.
class CheckNotes {
public:
  explicit CheckNotes(std::size_t named) : limit_(named) {}
  template <class Text>
  void offend(Text&& text) {
    if (count_++ < limit_) text_ += (text_.empty() ? "" : "; ") + text();
  }
  [[nodiscard]] std::int64_t count() const { return static_cast<std::int64_t>(count_); }
  /// The check; `good` says what holds, `bad` what the offenders are.
  [[nodiscard]] CertificateCheck check(std::string name, const std::string& good, const std::string& bad) const {
    if (count_ == 0) return {std::move(name), true, good};
    return {std::move(name), false,
            std::to_string(count_) + " " + bad + ": " + text_ + (count_ > limit_ ? "; ..." : "")};
  }

private:
  std::size_t limit_;
  std::size_t count_ = 0;
  std::string text_;
};

[[nodiscard]] inline bool in_range(std::int64_t index, std::size_t size) {
  return index >= 0 && static_cast<std::uint64_t>(index) < size;
}

/// Is the complex sound enough to be looked at: sizes, indices, labels and sides?
inline void check_complex(const Plc& plc, CheckNotes& notes, const std::function<void()>& poll = {}) {
  Poll listen(poll, 1 << 16);
  const auto text = [](const char* what) { return [what] { return std::string(what); }; };
  if (!(plc.grid.pitch > 0) || !std::isfinite(plc.grid.pitch)) notes.offend(text("pitch of the grid"));
  if (plc.vertex_plane.size() != plc.vertices.size()) notes.offend(text("#vertex_plane is not #vertices"));
  if (plc.slab_planes.size() != plc.slabs.size()) notes.offend(text("#slab_planes is not #slabs"));
  for (std::size_t k = 0; k < plc.planes.size(); ++k)
    if (!std::isfinite(plc.planes[k]) || (k > 0 && !(plc.planes[k - 1] < plc.planes[k])))
      notes.offend([k] { return "plane " + std::to_string(k) + " is not above the one before"; });
  for (std::size_t s = 0; s < std::min(plc.slabs.size(), plc.slab_planes.size()); ++s) {
    const auto [low, high] = plc.slab_planes[s];
    if (!in_range(low, plc.planes.size()) || !in_range(high, plc.planes.size()) || low >= high ||
        plc.planes[static_cast<std::size_t>(low)] != plc.slabs[s].z_low ||
        plc.planes[static_cast<std::size_t>(high)] != plc.slabs[s].z_high)
      notes.offend([s] { return "planes of slab " + std::to_string(s); });
  }
  for (std::size_t v = 0; v < plc.vertices.size(); ++v) {
    listen();
    const GridPoint& p = plc.vertices[v];
    if (!is_on_grid(p) || (v < plc.vertex_plane.size() && !in_range(plc.vertex_plane[v], plc.planes.size())))
      notes.offend([v] { return "vertex " + std::to_string(v); });
  }
  for (std::size_t f = 0; f < plc.facets.size(); ++f) {
    listen();
    const Facet& facet = plc.facets[f];
    bool good = facet.vertices[0] != facet.vertices[1] && facet.vertices[1] != facet.vertices[2] &&
                facet.vertices[2] != facet.vertices[0];
    for (const std::int32_t v : facet.vertices) good = good && in_range(v, plc.vertices.size());
    for (const Side* side : {&facet.back, &facet.front})
      good = good &&
             (side->empty() || (in_range(side->slab, plc.slabs.size()) && in_range(side->region, plc.regions.size())));
    const bool wall = facet.label == FacetLabel::Wall || facet.label == FacetLabel::InnerWall;
    const bool two = facet.label == FacetLabel::Interface || facet.label == FacetLabel::InnerWall;
    good = good && static_cast<std::uint8_t>(facet.label) <= 4 && !facet.back.empty() && facet.front.empty() != two &&
           (!wall || (facet.wall >= 0 && (!two || facet.front.slab == facet.back.slab)));
    if (!good) notes.offend([f] { return "facet " + std::to_string(f); });
  }
}

/// The facets around every slab.
struct SlabFacets {
  std::vector<std::int32_t> start;   // #S + 1 offsets into facets
  std::vector<std::int32_t> facets;  // in the order of the complex
};
[[nodiscard]] inline SlabFacets facets_by_slab(const Plc& plc, const std::function<void()>& poll = {}) {
  SlabFacets result;
  Poll listen(poll, 1 << 16);
  result.start.assign(plc.slabs.size() + 1, 0);
  const auto for_each = [&](auto&& f) {
    for (std::size_t i = 0; i < plc.facets.size(); ++i) {
      listen();
      const Facet& facet = plc.facets[i];
      if (!facet.back.empty()) f(static_cast<std::size_t>(facet.back.slab), i);
      if (!facet.front.empty() && facet.front.slab != facet.back.slab) f(static_cast<std::size_t>(facet.front.slab), i);
    }
  };
  for_each([&](std::size_t s, std::size_t) { ++result.start[s + 1]; });
  for (std::size_t s = 0; s < plc.slabs.size(); ++s) result.start[s + 1] += result.start[s];
  result.facets.resize(static_cast<std::size_t>(result.start.back()));
  std::vector<std::int32_t> next(result.start.begin(), result.start.end() - 1);
  for_each([&](std::size_t s, std::size_t i) {
    result.facets[static_cast<std::size_t>(next[s]++)] = static_cast<std::int32_t>(i);
  });
  return result;
}

/// The walls of one slab: what lies on them, how much they are bent.
///
/// A vertex that splits a contour edge is rounded to the grid, so the bottom and the top of a wall may bend by half a
/// pitch, each in its own way. What different triangulations of such a wall can hold between them, and what the slab
/// can miss of area x height, is at most its length x height x the width of the bends. `bend` is length x width in
/// squared pitches, exact; 0 where a wall is plane.
class SlabWalls {
public:
  struct Wall {
    std::int32_t id = kNone;
    GridPoint a, b;  // its ends, lexicographically
    Int128 bend = 0;
    Side back, front;
    int turn = 0;                     // sense of its facets in the wall, see turn_of
    std::int64_t facets = 0;          // of the complex
    std::int64_t faces = 0;           // of the mesh, counted by the certificate
    std::size_t first = 0, last = 0;  // range in members
    bool consistent = true;           // all facets have the same sides and the same sense
  };

  /// `listen` is told what is looked at, here and in on_one_wall.
  SlabWalls(const Plc& plc, const std::int32_t* begin, const std::int32_t* end, Poll& listen)
      : plc_(plc), listen_(listen) {
    std::vector<std::pair<std::int32_t, std::int32_t>> order;  // wall, facet
    for (const std::int32_t* f = begin; f != end; ++f) {
      listen_();
      const Facet& facet = plc.facets[static_cast<std::size_t>(*f)];
      if (facet.label == FacetLabel::Wall || facet.label == FacetLabel::InnerWall) order.emplace_back(facet.wall, *f);
    }
    if (!std::is_sorted(order.begin(), order.end())) sort_listening(order.begin(), order.end(), listen_);
    for (std::size_t i = 0; i < order.size();) {
      Wall wall;
      wall.id = order[i].first;
      wall.first = members_.size();
      const std::size_t first = i;
      for (; i < order.size() && order[i].first == wall.id; ++i)
        for (const std::int32_t v : plc.facets[static_cast<std::size_t>(order[i].second)].vertices)
          members_.push_back(v);
      listen_(16);
      sort_listening(members_.begin() + std::ptrdiff_t(wall.first), members_.end(), listen_);
      members_.erase(std::unique(members_.begin() + std::ptrdiff_t(wall.first), members_.end()), members_.end());
      wall.last = members_.size();
      wall.a = wall.b = point(members_[wall.first]);
      for (std::size_t m = wall.first; m < wall.last; ++m) {
        wall.a = std::min(wall.a, point(members_[m]));
        wall.b = std::max(wall.b, point(members_[m]));
      }
      Int128 low = 0, high = 0;
      for (std::size_t m = wall.first; m < wall.last; ++m) {
        const Int128 c = cross(wall.a, wall.b, point(members_[m]));
        low = std::min(low, c);
        high = std::max(high, c);
      }
      wall.bend = high - low;
      wall.facets = static_cast<std::int64_t>(i - first);
      const Facet& sample = plc.facets[static_cast<std::size_t>(order[first].second)];
      wall.back = sample.back;
      wall.front = sample.front;
      wall.turn = turn_of(wall, sample.vertices);
      for (std::size_t j = first; j < i; ++j) {
        const Facet& facet = plc.facets[static_cast<std::size_t>(order[j].second)];
        wall.consistent = wall.consistent && facet.label == sample.label && facet.back == sample.back &&
                          facet.front == sample.front && wall.turn != 0 && turn_of(wall, facet.vertices) == wall.turn;
      }
      walls_.push_back(wall);
    }
  }

  [[nodiscard]] std::vector<Wall>& walls() { return walls_; }
  [[nodiscard]] const std::vector<Wall>& walls() const { return walls_; }
  /// Vertices of the complex on the walls, see Wall::first.
  [[nodiscard]] const std::vector<std::int32_t>& members() const { return members_; }
  [[nodiscard]] Wall* find(std::int32_t id) {
    const auto it =
        std::lower_bound(walls_.begin(), walls_.end(), id, [](const Wall& w, std::int32_t i) { return w.id < i; });
    return it != walls_.end() && it->id == id ? &*it : nullptr;
  }
  /// The wall that has all three vertices (of the complex), or nullptr; sides must be these, in either order.
  [[nodiscard]] Wall* on_one_wall(const std::array<std::int32_t, 3>& vertices, const Side& back, const Side& front) {
    if (of_vertex_.empty()) {
      for (std::size_t w = 0; w < walls_.size(); ++w) {
        listen_();
        for (std::size_t m = walls_[w].first; m < walls_[w].last; ++m) of_vertex_.emplace_back(members_[m], w);
      }
      sort_listening(of_vertex_.begin(), of_vertex_.end(), listen_);
    }
    // The walls of the vertex that has the fewest: any number of walls may meet at one of the others.
    const auto walls_at = [&](std::int32_t v) {
      const auto by_vertex = [](const auto& a, const auto& b) { return a.first < b.first; };
      return std::equal_range(of_vertex_.begin(), of_vertex_.end(), std::make_pair(v, std::size_t{0}), by_vertex);
    };
    auto range = walls_at(vertices[0]);
    for (std::size_t i = 1; i < 3; ++i) {
      const auto other = walls_at(vertices[i]);
      if (other.second - other.first < range.second - range.first) range = other;
    }
    for (auto it = range.first; it != range.second; ++it) {
      Wall& wall = walls_[it->second];
      const auto has = [&](std::int32_t v) {
        return std::binary_search(members_.begin() + std::ptrdiff_t(wall.first),
                                  members_.begin() + std::ptrdiff_t(wall.last), v);
      };
      const bool sides = (wall.back == back && wall.front == front) || (wall.back == front && wall.front == back);
      if (sides && has(vertices[0]) && has(vertices[1]) && has(vertices[2])) return &wall;
    }
    return nullptr;
  }
  /// The sense in which a triangle turns, as seen from the side where a is on the left: +1, -1; 0 without area.
  [[nodiscard]] int turn_of(const Wall& wall, const std::array<std::int32_t, 3>& vertices) const {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int32_t p = vertices[i], q = vertices[(i + 1) % 3], r = vertices[(i + 2) % 3];
      const std::int32_t level = plane(p);
      if (plane(q) != level || plane(r) == level) continue;
      const int forward = sign(dot(wall.a, wall.b, point(q)) - dot(wall.a, wall.b, point(p)));
      return plane(r) > level ? forward : -forward;
    }
    return 0;
  }

private:
  [[nodiscard]] const GridPoint& point(std::int32_t v) const { return plc_.vertices[static_cast<std::size_t>(v)]; }
  [[nodiscard]] std::int32_t plane(std::int32_t v) const { return plc_.vertex_plane[static_cast<std::size_t>(v)]; }
  const Plc& plc_;
  std::vector<Wall> walls_;
  std::vector<std::int32_t> members_;
  std::vector<std::pair<std::int32_t, std::size_t>> of_vertex_;
  Poll& listen_;
};

/// Twice the area of a horizontal facet in squared pitches, signed as seen from above.
[[nodiscard]] inline Int128 doubled_area(const Plc& plc, const Facet& facet) {
  return cross(plc.vertices[static_cast<std::size_t>(facet.vertices[0])],
               plc.vertices[static_cast<std::size_t>(facet.vertices[1])],
               plc.vertices[static_cast<std::size_t>(facet.vertices[2])]);
}

/// Areas of the cells (regions) of one slab.
struct CellAreas {
  std::vector<Int128> bottom, top;  // #R, twice the area in squared pitches
  std::vector<Int128> bend;         // #R, of the walls around the cell
};
[[nodiscard]] inline CellAreas cell_areas(const Plc& plc, std::int32_t slab, const std::int32_t* begin,
                                          const std::int32_t* end, const SlabWalls& walls) {
  CellAreas areas;
  const std::size_t regions = plc.regions.size();
  areas.bottom.assign(regions, 0);
  areas.top.assign(regions, 0);
  areas.bend.assign(regions, 0);
  for (const std::int32_t* f = begin; f != end; ++f) {
    const Facet& facet = plc.facets[static_cast<std::size_t>(*f)];
    const Int128 area = doubled_area(plc, facet);
    if (facet.label == FacetLabel::Down) {
      areas.bottom[static_cast<std::size_t>(facet.back.region)] -= area;
    } else if (facet.label == FacetLabel::Up || facet.label == FacetLabel::Interface) {
      if (facet.back.slab == slab)
        areas.top[static_cast<std::size_t>(facet.back.region)] += area;
      else
        areas.bottom[static_cast<std::size_t>(facet.front.region)] += area;
    }
  }
  for (const SlabWalls::Wall& wall : walls.walls())
    for (const Side* side : {&wall.back, &wall.front})
      if (!side->empty()) areas.bend[static_cast<std::size_t>(side->region)] += wall.bend;
  return areas;
}

}  // namespace detail

}  // namespace slice2mesh
