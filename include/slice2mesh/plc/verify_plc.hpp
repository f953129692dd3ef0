// SPDX-License-Identifier: MIT
/// @file
/// @brief The verifier of a piecewise linear complex.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/core/short_number.hpp"
#include "slice2mesh/plc/plane_cover.hpp"
#include "slice2mesh/plc/plc_checks.hpp"

namespace slice2mesh {

/// What `verify_plc` found. The checks, in this order: `complex`, `horizontal_facets`, `walls`, `closed`,
/// `no_overlap`, `volume`, `no_orphans`; the later ones are left out where indices are not sound.
struct PlcReport {
  /// One per name above, in that order.
  std::vector<CertificateCheck> checks;
  double volume = 0;           ///< mm^3 inside of the boundary, by the divergence theorem
  double expected_volume = 0;  ///< mm^3, sum of area x height
  double largest_bend = 0;     ///< mm, how far a vertex of a wall is from the line between the wall's ends

  /// True if there are checks and all of them passed.
  [[nodiscard]] bool passed() const {
    return !checks.empty() &&
           std::all_of(checks.begin(), checks.end(), [](const CertificateCheck& c) { return c.passed; });
  }
  /// The check of that name, or nullptr.
  [[nodiscard]] const CertificateCheck* find(const std::string& name) const {
    for (const CertificateCheck& c : checks)
      if (c.name == name) return &c;
    return nullptr;
  }
};

namespace detail {

class PlcVerifier {
public:
  PlcVerifier(const Plc& plc, std::size_t named, const std::function<void()>& poll)
      : plc_(plc), poll_(poll), listen_(poll_, kPollEvery), horizontal_(named), walls_(named), closed_(named),
        overlap_(named), volume_(named), orphans_(named) {}

  [[nodiscard]] PlcReport run() {
    PlcReport report;
    CheckNotes complex(3);
    check_complex(plc_, complex, poll_);
    report.checks.push_back(complex.check("complex", "indices, labels and sides are sound", "defects"));
    if (complex.count() > 0) return report;
    check_horizontal();
    const SlabFacets facets = facets_by_slab(plc_, poll_);
    for (std::size_t s = 0; s < plc_.slabs.size(); ++s)
      check_slab(static_cast<std::int32_t>(s), facets.facets.data() + facets.start[s],
                 facets.facets.data() + facets.start[s + 1]);
    if (!plc_.has_inner_faces) check_skin();
    check_no_overlap(plc_, overlap_, listen_);
    if (plc_.has_inner_faces) {
      std::vector<char> used(plc_.vertices.size(), 0);
      for (const Facet& facet : plc_.facets)
        for (const std::int32_t v : facet.vertices) used[static_cast<std::size_t>(v)] = 1;
      for (std::size_t v = 0; v < used.size(); ++v)
        if (!used[v]) orphans_.offend([v] { return "vertex " + std::to_string(v); });
    }
    finish(report);
    return report;
  }

private:
  [[nodiscard]] std::int32_t plane(std::int32_t v) const { return plc_.vertex_plane[static_cast<std::size_t>(v)]; }
  [[nodiscard]] const GridPoint& point(std::int32_t v) const { return plc_.vertices[static_cast<std::size_t>(v)]; }

  void check_horizontal() {
    for (std::size_t f = 0; f < plc_.facets.size(); ++f) {
      listen_();
      const Facet& facet = plc_.facets[f];
      if (is_wall(facet)) continue;
      const auto offend = [&](const char* what) {
        horizontal_.offend([&] { return "facet " + std::to_string(f) + " (" + to_string(facet.label) + ") " + what; });
      };
      const std::int32_t k = plane(facet.vertices[0]);
      if (plane(facet.vertices[1]) != k || plane(facet.vertices[2]) != k) {
        offend("is not in one plane");
        continue;
      }
      const auto& back = plc_.slab_planes[static_cast<std::size_t>(facet.back.slab)];
      bool good = back[facet.label == FacetLabel::Down ? 0 : 1] == k;
      if (facet.label == FacetLabel::Interface)
        good = good && plc_.slab_planes[static_cast<std::size_t>(facet.front.slab)][0] == k;
      if (!good) offend("is not between its slabs");
      const int turn = sign(doubled_area(plc_, facet));
      if (turn != (facet.label == FacetLabel::Down ? -1 : 1))
        offend(turn == 0 ? "has no area" : "has its normal to the wrong side");
    }
  }

  /// A directed edge of a boundary, under its lower and higher vertex.
  struct Half {
    std::int32_t low, high, cell, winding;
  };
  /// Sums windings per cell and edge; offends where they do not cancel out.
  void check_closed(std::vector<Half>& halves, const std::string& where) {
    sort_listening(halves.begin(), halves.end(), listen_, [](const Half& e, const Half& f) {
      if (e.low != f.low) return e.low < f.low;
      return e.high != f.high ? e.high < f.high : e.cell < f.cell;
    });
    for (std::size_t i = 0; i < halves.size();) {
      std::int32_t sum = 0;
      std::size_t j = i;
      for (; j < halves.size() && halves[j].low == halves[i].low && halves[j].high == halves[i].high &&
             halves[j].cell == halves[i].cell;
           ++j)
        sum += halves[j].winding;
      ++edges_;
      if (j - i > 2) ++pinches_;
      if (sum != 0)
        closed_.offend([&] {
          return where + (halves[i].cell == kNone ? "" : " region " + std::to_string(halves[i].cell)) + ": edge " +
                 std::to_string(halves[i].low) + "-" + std::to_string(halves[i].high);
        });
      i = j;
    }
  }
  static void add_halves(const Facet& facet, std::int32_t cell, bool reversed, std::vector<Half>& halves) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = facet.vertices[k], b = facet.vertices[(k + 1) % 3];
      halves.push_back({std::min(a, b), std::max(a, b), cell, (a < b) != reversed ? 1 : -1});
    }
  }

  void check_skin() {
    std::vector<Half> halves;
    for (const Facet& facet : plc_.facets)
      if (facet.front.empty()) add_halves(facet, kNone, false, halves);
    check_closed(halves, "skin");
  }

  void check_slab(std::int32_t slab, const std::int32_t* begin, const std::int32_t* end) {
    const auto s = static_cast<std::size_t>(slab);
    const std::string where = "slab " + std::to_string(slab);
    const std::int32_t low = plc_.slab_planes[s][0], high = plc_.slab_planes[s][1];
    bool between = true;
    for (const std::int32_t* f = begin; f != end; ++f) {
      listen_();
      const Facet& facet = plc_.facets[static_cast<std::size_t>(*f)];
      if (!is_wall(facet)) continue;
      bool has_low = false, has_high = false, others = false;
      for (const std::int32_t v : facet.vertices) {
        has_low = has_low || plane(v) == low;
        has_high = has_high || plane(v) == high;
        others = others || (plane(v) != low && plane(v) != high);
      }
      if (!has_low || !has_high || others) {
        between = false;
        walls_.offend([&] { return "facet " + std::to_string(*f) + " does not stand between the planes of " + where; });
      }
    }
    const SlabWalls walls(plc_, begin, end, listen_);
    for (const SlabWalls::Wall& wall : walls.walls()) {
      listen_();
      ++wall_count_;
      const double length = distance(wall.a, wall.b);
      if (length > 0) bend_ = std::max(bend_, double(wall.bend) / length * plc_.grid.pitch);
      const auto offend = [&](const char* what) {
        walls_.offend([&] { return where + " wall " + std::to_string(wall.id) + " " + what; });
      };
      // A strip has the ends of its contour edge at the bottom and at the top, and a triangle for each piece.
      int ends = 0;
      for (std::size_t m = wall.first; m < wall.last; ++m) {
        const GridPoint& p = point(walls.members()[m]);
        ends += p == wall.a || p == wall.b ? 1 : 0;
      }
      if (!wall.consistent)
        offend("has facets of different sides or senses");
      else if (ends != 4 || wall.facets + 2 != static_cast<std::int64_t>(wall.last - wall.first))
        offend("is no strip between two chains");
    }
    if (!plc_.has_inner_faces) {
      add_skin_volume(slab, begin, end, walls);
      return;
    }
    std::vector<Half> halves;
    for (const std::int32_t* f = begin; f != end; ++f) {
      const Facet& facet = plc_.facets[static_cast<std::size_t>(*f)];
      listen_();
      if (facet.back.slab == slab) add_halves(facet, facet.back.region, false, halves);
      if (facet.front.slab == slab) add_halves(facet, facet.front.region, true, halves);
    }
    check_closed(halves, where);
    const CellAreas areas = cell_areas(plc_, slab, begin, end, walls);
    if (between) add_volume(slab, begin, end, areas);
  }

  /// Volumes of the cells by the divergence theorem, with the bottom plane at height 0: 6 V / height is the sum over
  /// the facets of the boxes of two horizontal positions for every vertex on top.
  void add_volume(std::int32_t slab, const std::int32_t* begin, const std::int32_t* end, const CellAreas& areas) {
    const auto s = static_cast<std::size_t>(slab);
    const std::int32_t high = plc_.slab_planes[s][1];
    const double height = plc_.slabs[s].z_high - plc_.slabs[s].z_low;
    const double unit = plc_.grid.pitch * plc_.grid.pitch * height / 6;
    std::vector<Int128> volume(plc_.regions.size(), 0);
    for (const std::int32_t* f = begin; f != end; ++f) {
      const Facet& facet = plc_.facets[static_cast<std::size_t>(*f)];
      listen_();
      Int128 term = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        if (plane(facet.vertices[k]) != high) continue;
        const GridPoint &p = point(facet.vertices[(k + 1) % 3]), &q = point(facet.vertices[(k + 2) % 3]);
        term += Int128(p.x) * q.y - Int128(p.y) * q.x;
      }
      if (facet.back.slab == slab) volume[static_cast<std::size_t>(facet.back.region)] += term;
      if (facet.front.slab == slab) volume[static_cast<std::size_t>(facet.front.region)] -= term;
    }
    for (std::size_t r = 0; r < volume.size(); ++r) {
      const Int128 wanted = 3 * (areas.bottom[r] + areas.top[r]);  // 12 V / height
      const Int128 difference = 2 * volume[r] - wanted, sides = areas.bottom[r] - areas.top[r];
      total_.add(double(volume[r]) * unit);
      expected_.add(double(wanted) / 2 * unit);
      allowance_ += 6 * double(areas.bend[r]) * unit;
      const auto magnitude = [](Int128 v) { return v < 0 ? -v : v; };
      const auto offend = [&](const std::string& what) {
        volume_.offend([&] { return "slab " + std::to_string(slab) + " region " + std::to_string(r) + " " + what; });
      };
      if (volume[r] < 0)
        offend("is inside out");
      else if (magnitude(difference) > 12 * areas.bend[r])
        offend("has " + number_text(double(volume[r]) * unit) + " mm^3 instead of " +
               number_text(double(wanted) / 2 * unit));
      else if (magnitude(sides) > 2 * areas.bend[r])
        offend("has different areas at its bottom and its top");
    }
  }

  /// A skin alone does not hold the areas of its slabs: these are read off the lower and upper ends of the walls.
  void add_skin_volume(std::int32_t slab, const std::int32_t* begin, const std::int32_t* end, const SlabWalls& walls) {
    const auto s = static_cast<std::size_t>(slab);
    const std::int32_t low = plc_.slab_planes[s][0];
    Int128 bottom = 0, top = 0;  // twice the areas
    for (const std::int32_t* f = begin; f != end; ++f) {
      const Facet& facet = plc_.facets[static_cast<std::size_t>(*f)];
      for (std::size_t k = 0; k < 3; ++k) {
        const GridPoint &p = point(facet.vertices[k]), &q = point(facet.vertices[(k + 1) % 3]);
        const std::int32_t level = plane(facet.vertices[k]);
        const Int128 term = Int128(p.x) * q.y - Int128(p.y) * q.x;
        if (is_wall(facet) && level == plane(facet.vertices[(k + 1) % 3]))
          (level == low ? bottom : top) += level == low ? term : -term;
        // The box of two positions in the plane and a height, above the lowest plane.
        const std::int32_t above = plane(facet.vertices[(k + 2) % 3]);
        total_.add(double(term) * (plc_.planes[static_cast<std::size_t>(above)] - plc_.planes.front()) / 6 *
                   plc_.grid.pitch * plc_.grid.pitch);
      }
    }
    const double unit = plc_.grid.pitch * plc_.grid.pitch * (plc_.slabs[s].z_high - plc_.slabs[s].z_low);
    Int128 bend = 0;
    for (const SlabWalls::Wall& wall : walls.walls()) bend += wall.bend;
    expected_.add((double(bottom) + double(top)) / 4 * unit);
    allowance_ += double(bend) * unit;
    const Int128 sides = bottom - top;
    if ((sides < 0 ? -sides : sides) > 2 * bend)
      volume_.offend([&] { return "slab " + std::to_string(slab) + " has different areas at its bottom and its top"; });
  }

  void finish(PlcReport& report) const {
    auto& checks = report.checks;
    checks.push_back(horizontal_.check(
        "horizontal_facets",
        "lie in the plane between their slabs, with positive area and their normal to the right side", "defects"));
    checks.push_back(walls_.check(
        "walls", std::to_string(wall_count_) + " walls, each a strip of triangles between two chains", "defects"));
    checks.push_back(closed_.check(
        "closed",
        std::string(plc_.has_inner_faces ? "the boundary of every slab and region" : "the skin") + " is closed (" +
            std::to_string(edges_) + " edges, " + std::to_string(pinches_) + " with more than two facets)",
        "edges are open"));
    checks.push_back(
        overlap_.check("no_overlap", "facets of one plane do not overlap or cross", "planes with overlaps"));
    report.volume = total_.value();
    report.expected_volume = expected_.value();
    report.largest_bend = bend_;
    const double difference = std::fabs(report.volume - report.expected_volume);
    CertificateCheck volume = volume_.check(
        "volume",
        "volume is area x height: relative difference " +
            number_text(report.expected_volume > 0 ? difference / report.expected_volume : difference) +
            (allowance_ > 0 && report.expected_volume > 0 ? " (bends of walls by rounded split points allow for " +
                                                                number_text(allowance_ / report.expected_volume) + ")"
                                                          : std::string()),
        "cells have a wrong volume");
    // Per cell volumes were compared as integers. Those of the sum, and of a skin, are rounded to doubles.
    constexpr double kRounding = 1e-12;  // relative
    volume.passed = volume.passed && difference <= kRounding * report.expected_volume + allowance_;
    checks.push_back(std::move(volume));
    if (plc_.has_inner_faces)
      checks.push_back(orphans_.check("no_orphans", "every vertex is on a facet", "vertices without facet"));
  }

  static constexpr std::size_t kPollEvery = 1 << 16;  // facets, edges and comparisons

  const Plc& plc_;
  const std::function<void()>& poll_;
  Poll listen_;
  CheckNotes horizontal_, walls_, closed_, overlap_, volume_, orphans_;
  CompensatedSum total_, expected_;
  double allowance_ = 0;  // mm^3
  double bend_ = 0;       // mm
  std::int64_t wall_count_ = 0, edges_ = 0, pinches_ = 0;
};

}  // namespace detail

/// Checks a complex.
///
/// Proven, in integer arithmetic: horizontal facets lie in the planes of their slabs, turn the right way and cover no
/// point of a plane twice; walls stand between the planes of their slab, are strips over one contour edge and have
/// their sides alike; the boundary of every cell (region of a slab), or of the skin where that is all there is, is
/// closed; the volume of every cell is area x height, up to the bends of its walls, and positive. Not looked at:
/// whether walls that are bent by less than the distance of two contours touch between the planes. `max_offenders`: how
/// many offenders of a check are named. `poll` is called now and then. Errors: what `poll` throws. Cost: O(n log n).
[[nodiscard]] inline PlcReport verify_plc(const Plc& plc, std::size_t max_offenders = 3,
                                          const std::function<void()>& poll = {}) {
  return detail::PlcVerifier(plc, max_offenders, poll).run();
}

}  // namespace slice2mesh
