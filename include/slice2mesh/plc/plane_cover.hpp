// SPDX-License-Identifier: MIT
/// @file
/// @brief Do the facets of every plane of a complex cover no point twice?
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/core/short_number.hpp"
#include "slice2mesh/plc/plc_checks.hpp"

namespace slice2mesh::detail {

/// Is the area to the left of directed edges covered exactly once? A sweep (Shamos, Hoey, "Geometric intersection
/// problems", FOCS 1976) that stops at the first crossing, touch or doubled cover; all tests are exact.
class CoverSweep {
public:
  enum class Finding { Once, Crossing, Overlap };
  struct Edge {
    GridPoint a, b;      // lexicographically a < b
    bool left_is_above;  // the covered side
  };

  /// `at` gets the place of the finding.
  [[nodiscard]] static Finding run(const std::vector<Edge>& edges, GridPoint& at, Poll& listen) {
    struct Event {
      GridPoint p;
      std::size_t edge;
      bool start;
    };
    std::vector<Event> events;
    events.reserve(edges.size() * 2);
    for (std::size_t e = 0; e < edges.size(); ++e) {
      events.push_back({edges[e].a, e, true});
      events.push_back({edges[e].b, e, false});
    }
    sort_listening(events.begin(), events.end(), listen, [](const Event& e, const Event& f) {
      if (e.p != f.p) return e.p < f.p;
      return e.start != f.start ? !e.start : e.edge < f.edge;
    });
    const auto below = [&](std::size_t e, std::size_t f) { return is_below(edges, e, f); };
    using Line = std::set<std::size_t, decltype(below)>;
    Line line(below);
    std::vector<typename Line::iterator> place(edges.size());
    const auto meet = [&](typename Line::iterator i, typename Line::iterator j) { return touch(edges[*i], edges[*j]); };
    for (std::size_t i = 0; i < events.size();) {
      listen(4);
      at = events[i].p;
      std::size_t j = i;
      for (; j < events.size() && events[j].p == at; ++j) {
        const std::size_t e = events[j].edge;
        if (!events[j].start) {
          const auto after = line.erase(place[e]);
          if (after != line.end() && after != line.begin() && meet(std::prev(after), after)) return Finding::Crossing;
          continue;
        }
        const auto [it, inserted] = line.insert(e);
        if (!inserted) return Finding::Crossing;
        place[e] = it;
        if (it != line.begin() && meet(std::prev(it), it)) return Finding::Crossing;
        if (std::next(it) != line.end() && meet(it, std::next(it))) return Finding::Crossing;
      }
      // Covers must alternate around the edges that start here: each one has the same on its lower side as the edge
      // below it has on its upper side.
      for (std::size_t k = i; k < j; ++k) {
        if (!events[k].start) continue;
        const auto it = place[events[k].edge];
        const bool covered_below = !edges[*it].left_is_above;
        const bool wanted = it != line.begin() && edges[*std::prev(it)].left_is_above;
        if (covered_below != wanted) return Finding::Overlap;
      }
      i = j;
    }
    return Finding::Once;
  }

private:
  static bool is_below(const std::vector<Edge>& edges, std::size_t i, std::size_t j) {
    if (i == j) return false;
    const Edge &e = edges[i], &f = edges[j];
    if (e.a == f.a) return orientation(e.a, e.b, f.b) > 0;
    if (e.a < f.a) return orientation(e.a, e.b, f.a) > 0;
    return orientation(f.a, f.b, e.a) < 0;
  }
  /// Do the edges meet anywhere but in common ends?
  static bool touch(const Edge& e, const Edge& f) {
    const int o1 = orientation(e.a, e.b, f.a), o2 = orientation(e.a, e.b, f.b);
    const int o3 = orientation(f.a, f.b, e.a), o4 = orientation(f.a, f.b, e.b);
    if (o1 * o2 < 0 && o3 * o4 < 0) return true;
    const auto inside = [](int side, const GridPoint& p, const Edge& g) { return side == 0 && g.a < p && p < g.b; };
    if (inside(o1, f.a, e) || inside(o2, f.b, e) || inside(o3, e.a, f) || inside(o4, e.b, f)) return true;
    return e.a == f.a && e.b == f.b;
  }
};

[[nodiscard]] inline bool is_wall(const Facet& facet) {
  return facet.label == FacetLabel::Wall || facet.label == FacetLabel::InnerWall;
}

/// In every plane: the triangles, all seen from above, cover no point twice. Exact. Precondition: `check_complex` found
/// nothing. Cost: that of sorting the edges.
///
/// How often a point is covered changes only across edges that have a triangle on one side alone. If these do not
/// cross, and have cover 1 on the one side and 0 on the other, nothing is covered twice.
inline void check_no_overlap(const Plc& plc, CheckNotes& notes, Poll& listen) {
  struct Half {
    std::int32_t low, high;
    bool ascends;  // from low to high, with the triangle on its left
  };
  const auto point = [&](std::int32_t v) { return plc.vertices[std::size_t(v)]; };
  std::vector<std::vector<Half>> halves_of(plc.planes.size());
  for (const Facet& facet : plc.facets) {
    listen();
    if (is_wall(facet)) continue;
    std::vector<Half>& halves = halves_of[std::size_t(plc.vertex_plane[std::size_t(facet.vertices[0])])];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = facet.vertices[k], b = facet.vertices[(k + 1) % 3];
      halves.push_back({std::min(a, b), std::max(a, b), (a < b) != (facet.label == FacetLabel::Down)});
    }
  }
  std::vector<CoverSweep::Edge> edges;
  for (std::size_t k = 0; k < halves_of.size(); ++k) {
    std::vector<Half>& halves = halves_of[k];
    edges.clear();
    sort_listening(halves.begin(), halves.end(), listen, [](const Half& e, const Half& f) {
      if (e.low != f.low) return e.low < f.low;
      return e.high != f.high ? e.high < f.high : e.ascends < f.ascends;
    });
    const auto same = [](const Half& e, const Half& f) { return e.low == f.low && e.high == f.high; };
    for (std::size_t i = 0; i < halves.size();) {
      std::size_t j = i;
      while (j < halves.size() && same(halves[i], halves[j])) ++j;
      if (j - i > 2 || (j - i == 2 && halves[i].ascends == halves[i + 1].ascends))
        notes.offend([&] {
          return "plane " + std::to_string(k) + ": several facets on one side of edge " +
                 std::to_string(halves[i].low) + "-" + std::to_string(halves[i].high);
        });
      if (j - i == 1) {
        GridPoint a = point(halves[i].low), b = point(halves[i].high);
        if (!halves[i].ascends) std::swap(a, b);  // facet on the left of a -> b
        if (a != b) edges.push_back(a < b ? CoverSweep::Edge{a, b, true} : CoverSweep::Edge{b, a, false});
      }
      i = j;
    }
    GridPoint at;
    const CoverSweep::Finding finding = CoverSweep::run(edges, at, listen);
    if (finding != CoverSweep::Finding::Once)
      notes.offend([&] {
        return "plane " + std::to_string(k) + ": " +
               (finding == CoverSweep::Finding::Crossing ? "edges cross or touch" : "facets overlap") + " near " +
               place_text(plc.grid, at);
      });
  }
}

}  // namespace slice2mesh::detail
