// SPDX-License-Identifier: MIT
/// @file
/// @brief One way to open the corners in a small part of the contours that is like no other.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/harmonize/corners.hpp"
#include "slice2mesh/harmonize/outline_window.hpp"

namespace slice2mesh::detail {

/// Opens corners after something has been moved at random.
class CornerTrial : private CornerOpener {
public:
  using CornerOpener::CornerOpener;
  using Random = std::minstd_rand;  // the same numbers everywhere
  /// What corners there are.
  struct Result {
    Sharpness sharpness;          ///< of the window
    std::vector<Corner> corners;  ///< all faults in the window, the sharpest first
    /// How many of them are in a part of it.
    [[nodiscard]] std::size_t count_in(const OutlineWindow& room) const {
      return std::size_t(std::count_if(corners.begin(), corners.end(), [&](const Corner& c) { return room.has(c.v); }));
    }
  };

  /// As it is. Sharper than `enough`, it is not looked at in all respects.
  [[nodiscard]] Result look(const OutlineWindow& window, double enough = HUGE_VAL) {
    Result result;
    result.corners = all_faults();
    const auto outside = [&](const Corner& c) { return !window.has(c.v); };
    result.corners.erase(std::remove_if(result.corners.begin(), result.corners.end(), outside), result.corners.end());
    result.sharpness.all = sharpness_of(result.corners);
    if (result.sharpness.all <= enough) add_own_and_skew(window, result.sharpness);
    return result;
  }
  /// What has to get no worse for a trial to be better, but for what corners count in all.
  enum class Keep { OwnAndSkew, Own, Nothing };
  /// Where a trial moves something, and how.
  struct Place {
    OutlineWindow window;          ///< what is there counts
    OutlineWindow room;            ///< what is there may move, and all it has to do with is in the window
    GridPoint center;              ///< what moves at random is near to that
    double clearance = 1;          ///< of that in the limits: what vertices keep from edges, ...
    double apart = 1;              ///< ... and from each other
    Keep keep = Keep::OwnAndSkew;  ///< see is_better
  };
  /// One trial. The first ones (`trial` from 0) take losses of some sizes, all others move something at random. Else as
  /// CornerOpener::run; to be called once.
  Result run(const Place& place, std::size_t trial, const Sharpness& before, Random& random, std::vector<char>& changed,
             const std::function<void()>& poll) {
    Result result;
    set(place);
    work_on_corners(changed, poll, [&] {
      use_all_room();
      if (trial < kLosses.size()) {
        open_all_gaining(-kLosses[trial], 1);
      } else {
        lead_at_random(place.center, random);
        if (random() % 2 == 0) gather_at_random(place.center, random);
        if (random() % 2 == 0) move_parts_at_random(place.center, random);
        move_at_random(place.center, random);
      }
      open_all_gaining(kSmallGain, kTrialRounds);
      result = look(place.window, before.all);
      if (!is_better(result.sharpness, before, place.keep)) return;
      tidy();  // vertices that nobody needs any more make elements worse
      result = look(place.window);
    });
    return result;
  }
  /// Gives the edges in the room the vertices of the slabs next to theirs that lie on them: what two slabs have in
  /// common is found, and moves together, in the next trial. To be called once, instead of `run`.
  void share_vertices(const Place& place, std::vector<char>& changed, const std::function<void()>& poll) {
    set(place);
    work_on_corners(changed, poll, [&] {
      use_all_room();
      const std::vector<GridPoint> points = places_in_room(HUGE_VAL, {});
      std::vector<Lead> leads;
      for (const GridPoint& p : points) {
        const std::vector<Standing>& standing = place_of(p).standing;  // in ascending order
        const std::vector<std::int32_t> passing =
            find_passing(p, std::int32_t(standing.front().slab), std::int32_t(standing.back().slab), false);
        for (const std::int32_t k : passing) lead(k, p, std::size_t(panels_[std::size_t(k)].first), leads, true);
      }
    });
  }
  /// Less sharp in all, and contours do not get zigzags for it, nor in the way of those two slabs off.
  [[nodiscard]] static bool is_better(const Sharpness& now, const Sharpness& before, Keep keep) {
    return now.all <= before.all - kLeastTrialGain && (keep == Keep::Nothing || now.own <= before.own) &&
           (keep != Keep::OwnAndSkew || now.skew <= before.skew);
  }

private:
  static constexpr std::array<double, 8> kLosses{0, 0.3, 0.6, 1, 1.4, 2, 3, 4};
  static constexpr int kTrialRounds = 3;
  static constexpr double kLeastTrialGain = 0.01;  // of sharpness
  static constexpr double kNearCenter = 8;         // of `apart`: what is moved at random is nearer than this
  static constexpr std::size_t kMostLeads = 3, kMostMoves = 6, kMostParts = 4, kMostGathered = 3;
  static constexpr double kNearGathered = 3;                    // of `apart`: what is gathered is so near to the center
  static constexpr double kShortest = 0.2, kLongest = 1.4;      // of `apart`: how far columns go, ...
  static constexpr double kShortestPart = 1, kLongestPart = 2;  // ... and parts of them
  static constexpr double kPartLoss = 3;                        // what a part may lose where it goes

  void set(const Place& place) {
    room_ = place.room;
    limits_.clearance *= place.clearance;
    limits_.apart *= place.apart;
  }
  /// From 0 to below 1.
  [[nodiscard]] static double share(Random& random) { return double(random() % 1024) / 1024; }
  /// A place that is so far from another one, in any direction.
  [[nodiscard]] static GridPoint anywhere(const GridPoint& v, double far, Random& random) {
    const double angle = 2 * kPi * share(random);
    return rounded(double(v.x) + far * std::cos(angle), double(v.y) + far * std::sin(angle));
  }
  /// The places of columns that are in the room, and nearer to the center than that.
  [[nodiscard]] std::vector<GridPoint> places_in_room(double near, const GridPoint& center) {
    std::vector<GridPoint> places;
    for (const auto& [p, place] : places_) {  // in any order
      looked();
      if (!place.standing.empty() && room_.has(p) && distance(p, center) < near) places.push_back(p);
    }
    std::sort(places.begin(), places.end());
    return places;
  }
  /// Calls f(v, slab) for some places of columns near the center, and a slab that each stands in.
  template <class F>
  void for_some(const GridPoint& center, std::size_t most, Random& random, F&& f) {
    const std::vector<GridPoint> places = places_in_room(kNearCenter * limits_.apart, center);
    if (places.empty()) return;
    for (std::size_t i = 0, count = 1 + random() % most; i < count; ++i) {
      const GridPoint v = places[random() % places.size()];
      const std::vector<Standing>& standing = place_of(v).standing;
      if (!standing.empty()) f(v, standing[random() % standing.size()].slab);  // else it has moved meanwhile
    }
  }
  /// Gives more vertices to panels: what is straight can turn away there.
  void lead_at_random(const GridPoint& center, Random& random) {
    for_some(center, kMostLeads, random, [&](const GridPoint& v, std::size_t) {
      const std::vector<std::int32_t>& panels = place_of(v).panels;
      if (panels.empty()) return;
      const std::int32_t k = panels[random() % panels.size()];
      const Panel& panel = panels_[std::size_t(k)];
      const double length = distance(panel.a, panel.b), space = length - 2 * limits_.apart;
      if (!(space > 0)) return;
      const GridPoint y = contour_point_between(panel.a, panel.b, (limits_.apart + space * share(random)) / length);
      std::vector<Lead> leads;
      lead(k, y, std::size_t(panel.first), leads, true);
    });
  }
  /// Leads what passes near to some places through them: where several contours cross in a small space, they get a
  /// vertex, or an edge, that all have in common.
  void gather_at_random(const GridPoint& center, Random& random) {
    // What meets at a very small angle is near to each other for long: some places are on the way to a vertex.
    const std::vector<GridPoint> ends = places_in_room(HUGE_VAL, center);
    for (std::size_t i = 0, count = 1 + random() % kMostGathered; i < count && !ends.empty(); ++i) {
      GridPoint middle = center;
      if (random() % 2 == 0) middle = contour_point_between(center, ends[random() % ends.size()], share(random));
      const GridPoint t = anywhere(middle, kNearGathered * limits_.apart * share(random), random);
      const double near = limits_.apart * kLongest;
      std::vector<std::pair<double, std::int32_t>> panels;
      buckets_.for_each_on(t, t, std::int64_t(near) + 1, [&](std::size_t bucket) {
        for (std::int32_t e = bucket_[bucket].first; e != kNone; e = entries_[std::size_t(e)].next) {
          looked();
          const std::int32_t k = entries_[std::size_t(e)].panel;
          if (!is_alive(k)) continue;
          const Panel& panel = panels_[std::size_t(k)];
          const double d = segment_distance(t, panel.a, panel.b);
          if (d < near) panels.push_back({d, k});
        }
      });
      std::sort(panels.begin(), panels.end());
      panels.erase(std::unique(panels.begin(), panels.end()), panels.end());
      for (const auto& [d, k] : panels) {
        if (!is_alive(k)) continue;
        const Panel panel = panels_[std::size_t(k)];
        if (panel.a == t || panel.b == t) continue;
        const double length = distance(panel.a, panel.b), along = double(dot(panel.a, panel.b, t)) / length;
        const GridPoint& end = along < length / 2 ? panel.a : panel.b;
        const auto slab = std::size_t(panel.first);
        if (distance(end, t) < near) {
          move_if_possible({0, slab, end, end}, t, false);
          continue;
        }
        std::vector<Lead> leads;
        // What stands too near to others where it was put in, and cannot go from there, would be there for nothing.
        const GridPoint foot = contour_point_between(panel.a, panel.b, along / length);
        if (lead(k, foot, slab, leads, false) && !move_if_possible({0, slab, foot, foot}, t, true))
          take_back_all(leads);
      }
    }
  }
  void move_at_random(const GridPoint& center, Random& random) {
    for_some(center, kMostMoves, random, [&](const GridPoint& v, std::size_t slab) {
      const double far = limits_.apart * (kShortest + (kLongest - kShortest) * share(random));
      const GridPoint t = anywhere(v, far, random);
      move_if_possible({0, slab, v, v}, t, false);
    });
  }
  /// `added`: the column was not there before.
  bool move_if_possible(const Candidate& column, const GridPoint& t, bool added) {
    if (!is_near_slice(column.slab, t) || !find_simple(column)) return false;
    if (added && is_crowded(t, lowest_, lowest_ + std::int32_t(steps_.size()) - 1, column, kNone)) return false;
    reach_near_ = distance(t, column.v);
    find_all_near();
    if ((!added && gets_crowded(column, t)) || !possible(column, t)) return false;
    settle(column, t);
    return true;
  }
  /// The same for what of a column is above a plane, or below it.
  void move_parts_at_random(const GridPoint& center, Random& random) {
    for_some(center, kMostParts, random, [&](const GridPoint& v, std::size_t slab) {
      const double far = limits_.apart * (kShortestPart + (kLongestPart - kShortestPart) * share(random));
      Target target{v, 1};
      target.place[0] = anywhere(v, far, random);
      target.part[0] = random() % 2 == 0 ? Part{0, slab} : Part{slab, SIZE_MAX};
      gain_ = -kPartLoss;
      part(v, slab, target, far, 0);
    });
  }
};

}  // namespace slice2mesh::detail
