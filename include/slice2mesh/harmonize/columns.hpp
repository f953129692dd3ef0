// SPDX-License-Identifier: MIT
/// @file
/// @brief Contour vertices that came close to each other, merged or moved apart in all slabs at once.
///
/// Slabs are harmonized from the lowest up, each against the one below: what is fixed there stays. A column is a vertex
/// with the same place in consecutive slabs; here two columns that are close on some plane become one, whichever of
/// them is the lower one, where every slab keeps its distance from its slice. Columns that cannot be merged are moved
/// away from what they are too near to, or onto it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/harmonize/column_stack.hpp"
#include "slice2mesh/harmonize/contour_shape.hpp"
#include "slice2mesh/regions/thicken.hpp"

namespace slice2mesh::detail {

/// Merges and moves columns.
class ColumnMerger : private ColumnStack {
public:
  using ColumnStack::ColumnStack;

  /// Merges until nothing more can be merged, or a number of rounds is over, then moves apart; to be called once.
  /// `changed` (#S) tells the slabs concerned. `poll` is called now and then; what it throws ends the work.
  void run(std::vector<char>& changed, const std::function<void()>& poll) {
    work(changed, poll, [&] { merge_and_spread(changed, poll); });
  }

private:
  static constexpr int kRounds = 3;
  static constexpr int kMostLeads = 4;       // edges that are led through a vertex for a pair to be merged ...
  static constexpr double kLeadReach = 1.4;  // ... that is nearer than this; of the clearance
  static constexpr int kSpreadRounds = 2;
  static constexpr int kSpreadRings = 4, kSpreadDirections = 16;  // places that are tried
  static constexpr double kSpreadGain = 0.05;                     // of `apart`: what a move has to gain
  static constexpr double kSpreadChange = 0.1;  // what a change of the contours counts against a distance
  static constexpr double kClearer = 0.6;       // of the distance of two columns: what their merge must leave free
  void merge_and_spread(std::vector<char>& changed, const std::function<void()>& poll) {
    for (int round = 0; round < kRounds; ++round) {
      std::vector<Candidate> candidates = close_pairs(poll);
      sort_listening(candidates.begin(), candidates.end(), *listen_, [](const Candidate& a, const Candidate& b) {
        if (a.distance != b.distance) return a.distance < b.distance;
        if (a.slab != b.slab) return a.slab < b.slab;
        return a.v != b.v ? a.v < b.v : a.w < b.w;
      });
      std::size_t merged = 0;
      for (const Candidate& candidate : candidates) {
        looked(16);
        if (merge(candidate, changed)) ++merged;
      }
      if (merged == 0) break;
    }
    // What can slide along straight walls goes first: walls and corners are moved only where that is not enough.
    spread(changed, true);
    for (int round = 0; round < kSpreadRounds; ++round)
      if (spread(changed, false) == 0) break;
  }

  [[nodiscard]] std::vector<Candidate> close_pairs(const std::function<void()>& poll) const {
    std::vector<Candidate> result;
    Poll listen(poll, kPollEvery);
    const auto reach = std::int64_t(std::ceil(limits_.near));
    std::vector<std::pair<GridPoint, std::int32_t>> below, above, gone, come;  // vertices in use, sorted
    const auto fill = [&](std::size_t s, auto& list) {
      list.clear();
      const Sheet& sheet = sheets_[s];
      for (std::size_t v = 0; v < sheet.edges_at.size(); ++v)
        if (!sheet.edges_at[v].empty()) list.emplace_back(sheet.outline.vertices[v], std::int32_t(v));
      sort_listening(list.begin(), list.end(), listen, [](const auto& a, const auto& b) { return a.first < b.first; });
    };
    for (std::size_t s = 0; s < sheets_.size(); ++s) {
      poll();
      const Sheet& sheet = sheets_[s];
      for (std::size_t e = 0; e < sheet.outline.edges.size(); ++e) {
        listen();
        if (!sheet.alive[e]) continue;
        GridPoint p = sheet.point(sheet.outline.edges[e].a), q = sheet.point(sheet.outline.edges[e].b);
        const double d = distance(p, q);
        if (d >= limits_.near) continue;
        if (q < p) std::swap(p, q);
        if (stacked(s)) {  // once for the lowest slab that has both
          const std::int32_t v = at(s - 1, p), w = at(s - 1, q);
          if (v != kNone && w != kNone && sheets_[s - 1].edge_between(v, w) != kNone) continue;
        }
        result.push_back({d, s, p, q});
      }
      fill(s, above);
      if (stacked(s)) {
        // Those that the other slab does not have.
        const auto is_before = [](const auto& a, const auto& b) { return a.first < b.first; };
        gone.clear();
        come.clear();
        std::set_difference(below.begin(), below.end(), above.begin(), above.end(), std::back_inserter(gone),
                            is_before);
        std::set_difference(above.begin(), above.end(), below.begin(), below.end(), std::back_inserter(come),
                            is_before);
        for (const auto& item : come) {
          const GridPoint& w = item.first;
          for (auto it = std::lower_bound(gone.begin(), gone.end(), GridPoint{w.x - reach, INT64_MIN},
                                          [](const auto&a, const GridPoint&b) { return a.first < b; });
               it != gone.end() && it->first.x <= w.x + reach; ++it) {
            looked();
            const double d = distance(it->first, w);
            if (d < limits_.near) result.push_back({d, s - 1, it->first, w});
          }
        }
      }
      std::swap(below, above);
    }
    return result;
  }

  bool merge(const Candidate& c, std::vector<char>& changed) {
    // What keeps a pair apart may be a vertex that would no longer lie on an edge of the next slab. Where the edge is
    // led through it, the two stay together.
    for (int lead = 0; lead <= kMostLeads; ++lead) {
      left_ = {};
      if (try_merge(c, changed)) return true;
      if (left_.panel == kNone || c.distance >= kLeadReach * limits_.clearance ||
          !lead_through(left_.panel, left_.y, changed))
        break;
    }
    return false;
  }
  bool try_merge(const Candidate& c, std::vector<char>& changed) {
    if (!find_pair(c)) return false;
    if (between_.empty()) {
      // A pair of neighboring slabs that something else has changed meanwhile.
      bool v_there = false, w_there = false;
      for (const Step& step : steps_) {
        v_there = v_there || step.v != kNone;
        w_there = w_there || step.w != kNone;
      }
      if (!v_there || !w_there) return false;
    }
    clearance_ = std::min(limits_.clearance, kClearer * c.distance);
    reach_near_ = c.distance;
    std::array<std::pair<double, GridPoint>, 3> targets{
        {{0, c.v}, {0, c.w}, {0, contour_point_between(c.v, c.w, 0.5)}}};
    for (auto& target : targets) target.first = change(target.second);
    std::stable_sort(targets.begin(), targets.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& target : targets) {
      if (target.first > limits_.deviation || !possible(c, target.second)) continue;
      apply(c, target.second);
      for (const Step& step : steps_) changed[step.slab] = 1;
      return true;
    }
    return false;
  }

  struct Close {
    double gap;
    std::size_t slab;
    GridPoint p;
    bool operator<(const Close& o) const {
      if (gap != o.gap) return gap < o.gap;
      return slab != o.slab ? slab < o.slab : p < o.p;
    }
  };
  /// Columns that are nearer than `apart` to another vertex or an edge, the nearest first.
  [[nodiscard]] std::vector<Close> close_columns() {
    std::vector<Close> result;
    for (const auto& [p, place] : places_) {  // in any order
      for (std::size_t i = 0; i < place.standing.size(); ++i) {
        looked();
        const std::size_t s = place.standing[i].slab;
        if (i > 0 && place.standing[i - 1].slab + 1 == s && stacked(s)) continue;  // once, for the lowest slab
        if (!find_column(s, place)) continue;
        find_moving(p, place, p, nowhere_);
        find_near(limits_.apart);
        find_beside(p, 0);
        const double gap = gap_at(p, 0);
        if (gap < limits_.apart) result.push_back({gap, s, p});
      }
    }
    std::sort(result.begin(), result.end());
    return result;
  }

  /// Moves columns that are too near to something, where merging was not possible, to the best of some places around
  /// them. `walls_stay`: corners stay, and what is on a straight wall stays on its line. Returns how many.
  std::size_t spread(std::vector<char>& changed, bool walls_stay) {
    const double apart = limits_.apart;
    std::size_t moved = 0;
    if (!(apart > 0)) return moved;
    std::vector<std::pair<double, GridPoint>> places;
    std::vector<Close> stuck;
    std::array<std::array<double, 2>, kSpreadDirections> directions{};
    for (int d = 0; d < kSpreadDirections; ++d) {
      const double angle = 2 * kPi * d / kSpreadDirections;
      directions[std::size_t(d)] = {std::cos(angle), std::sin(angle)};
    }
    for (const Close& c : close_columns()) {
      looked(16);
      // As near as when no place was found for it: most likely nothing has moved there since.
      if (std::binary_search(stuck_.begin(), stuck_.end(), c)) continue;
      const Place& place_c = place_of(c.p);
      if (!find_column(c.slab, place_c)) continue;
      const bool corner = find_walls();
      if (walls_stay && corner) continue;
      if (!walls_stay && !walls_.empty() && c.gap >= limits_.walls_apart) continue;
      find_moving(c.p, place_c, c.p, nowhere_);
      reach_near_ = apart + double(kContourStep);  // places are rounded to steps
      find_all_near();
      find_beside(c.p, reach_near_);
      const double gap = gap_at(c.p, 0), least = gap + kSpreadGain * apart;
      if (gap >= apart) continue;
      places.clear();
      const auto offer = [&](const GridPoint& q) {
        if (q == c.p || (walls_stay && !on_walls(q))) return;
        const double reached = gap_at(q, least);
        // Of places that are as good the one where contours change least.
        if (reached >= least) places.emplace_back(kSpreadChange * change(q) - reached, q);
      };
      for (int r = 1; r <= kSpreadRings; ++r) {
        const double radius = apart * r / kSpreadRings;
        const auto offer_at = [&](double x, double y) {
          offer({round_to_step(c.p.x + std::llround(radius * x)), round_to_step(c.p.y + std::llround(radius * y))});
        };
        if (!walls_.empty()) {
          const auto& [a, b] = walls_.front();
          const double length = distance(a, b), x = double(b.x - a.x) / length, y = double(b.y - a.y) / length;
          offer_at(x, y);
          offer_at(-x, -y);
        }
        for (int d = 0; d < kSpreadDirections && (walls_.empty() || !walls_stay); ++d) {
          const auto& [x, y] = directions[std::size_t(d)];
          offer_at(x, y);
        }
      }
      for (const GridPoint& q : feet(c.p)) offer(q);
      std::sort(places.begin(), places.end());
      clearance_ = gap;
      const Candidate column{gap, c.slab, c.p, c.p};
      bool stays = true;
      for (const auto& place : places) {
        const GridPoint& q = place.second;
        if (change(q) > limits_.deviation || !possible(column, q)) continue;
        apply(column, q);
        for (const Step& step : steps_) changed[step.slab] = 1;
        ++moved;
        stays = false;
        break;
      }
      if (stays) stuck.push_back({gap, c.slab, c.p});
    }
    std::sort(stuck.begin(), stuck.end());
    if (!walls_stay) stuck_ = std::move(stuck);
    return moved;
  }
  /// Finds the straight walls that the column in question stands on. Returns whether it is a corner of a slab.
  bool find_walls() {
    walls_.clear();
    for (const Step& step : steps_) {
      const Sheet& sheet = sheets_[step.slab];
      const std::vector<std::int32_t>& edges = sheet.edges_at[std::size_t(step.v)];
      if (edges.size() != 2) return true;
      const GridPoint &a = sheet.point(sheet.other_end(edges[0], step.v)),
                      &b = sheet.point(sheet.other_end(edges[1], step.v));
      if (!walls_.empty() && walls_.back()[0] == a && walls_.back()[1] == b) continue;  // as in the slab before
      const ContourShape shape = contour_shape(sheet.point(step.v), a, b);
      if (shape == ContourShape::Corner) return true;
      if (shape == ContourShape::Straight) walls_.push_back({a, b});
    }
    return false;
  }
  [[nodiscard]] bool on_walls(const GridPoint& q) const {
    return std::all_of(walls_.begin(), walls_.end(),
                       [&](const auto& wall) { return line_distance(q, wall[0], wall[1]) <= kOnLine; });
  }
  /// An edge uw that is near an edge of the column in question, from its vertex to x.
  struct Beside {
    GridPoint x, u, w;
    Beneath beneath;
  };
  /// Finds what may be nearer than `apart` to the column at p, or to its edges, while it is within `radius` of p: edges
  /// of its slabs and of those next to them that do not end in p. Needs `find_near`.
  void find_beside(const GridPoint& p, double radius) {
    beside_.clear();
    const auto near = std::int64_t(std::ceil(limits_.apart + radius));
    for (const Moving& m : moving_) {
      const GridPoint low{std::min(p.x, m.x.x) - near, std::min(p.y, m.x.y) - near};
      const GridPoint high{std::max(p.x, m.x.x) + near, std::max(p.y, m.x.y) + near};
      looked(near_.size());
      for (const Panel& other : near_) {
        const GridPoint &u = other.a, &w = other.b;
        if (u == p || w == p) continue;
        if (std::max(u.x, w.x) < low.x || std::min(u.x, w.x) > high.x) continue;
        if (std::max(u.y, w.y) < low.y || std::min(u.y, w.y) > high.y) continue;
        const Beneath slabs = beneath(panels_[std::size_t(m.panel)], other);
        if (slabs.same_slab || slabs.next_slab) beside_.push_back({m.x, u, w, slabs});
      }
    }
  }
  /// How near the column that `find_beside` was called for would be to other vertices and edges, or its edges to other
  /// vertices, if it were at q; `apart` if nothing is nearer. What is below `floor` is not told exactly. A vertex on an
  /// edge of another slab is not near to it: the overlay of the plane leads the edge through it.
  [[nodiscard]] double gap_at(const GridPoint& q, double floor) {
    double gap = limits_.apart;
    looked(beside_.size());
    for (const Moving& m : moving_) gap = std::min(gap, distance(q, m.x));
    for (std::size_t i = 0; i < beside_.size(); ++i) {
      if (gap < floor) break;
      const Beside b = beside_[i];
      const auto apart = [&](double d) {
        if (d < gap && (b.beneath.same_slab || d > kOn)) gap = d;
      };
      const auto near = std::int64_t(gap) + 1;
      if (std::max(b.u.x, b.w.x) < std::min(q.x, b.x.x) - near || std::min(b.u.x, b.w.x) > std::max(q.x, b.x.x) + near)
        continue;
      if (std::max(b.u.y, b.w.y) < std::min(q.y, b.x.y) - near || std::min(b.u.y, b.w.y) > std::max(q.y, b.x.y) + near)
        continue;
      apart(segment_distance(q, b.u, b.w));
      if (b.beneath.next_slab) gap = std::min({gap, distance(q, b.u), distance(q, b.w)});
      if (b.u != b.x) apart(segment_distance(b.u, q, b.x));
      if (b.w != b.x) apart(segment_distance(b.w, q, b.x));
      // What is in the way of this place is in the way of the next one, most likely.
      if (gap < floor) std::swap(beside_[i], beside_.front());
    }
    return gap;
  }
  /// The points of edges of other slabs near p that are nearest to it. Needs `find_beside`.
  [[nodiscard]] std::vector<GridPoint> feet(const GridPoint& p) const {
    std::vector<GridPoint> result;
    for (const Beside& b : beside_) {
      if (!b.beneath.next_slab || segment_distance(p, b.u, b.w) >= limits_.apart) continue;
      const double length = distance(b.u, b.w), t = double(dot(b.u, b.w, p)) / (length * length);
      if (t > 0 && t < 1) result.push_back(contour_point_between(b.u, b.w, t));
    }
    std::sort(result.begin(), result.end());
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
  }

  std::vector<Beside> beside_;                   // see find_beside
  std::vector<std::array<GridPoint, 2>> walls_;  // see find_walls: points on both sides of the column
  std::vector<Close> stuck_;                     // sorted: columns that no place was found for
};

}  // namespace slice2mesh::detail
