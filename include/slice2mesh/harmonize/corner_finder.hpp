// SPDX-License-Identifier: MIT
/// @file
/// @brief Finds the sharp corners between contours of neighboring slabs, and tells what moves would make of them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/arrange/snap_rounding.hpp"
#include "slice2mesh/harmonize/column_stack.hpp"
#include "slice2mesh/harmonize/outline_window.hpp"
#include "slice2mesh/harmonize/separation_report.hpp"
#include "slice2mesh/regions/thicken.hpp"

namespace slice2mesh::detail {

/// Sharp corners: angles below kSeparationAngle of two edges that meet in a plane and are of one of its two contours
/// each; and vertices that are too near to what the next slab has.
class CornerFinder : protected ColumnStack {
public:
  using ColumnStack::ColumnStack;

  /// Two edges of neighboring slabs that meet at v in a sharp angle: va of a slab, vb of the one above. Or a vertex v
  /// and an edge ab, or a vertex a = b, of two neighboring slabs, the lower one `slab`, that are too near to each
  /// other.
  struct Corner {
    double degrees;
    std::size_t slab;
    GridPoint v, a, b;
    std::int32_t through_a, through_b;
    bool operator<(const Corner& o) const {
      if (degrees != o.degrees) return degrees < o.degrees;
      if (slab != o.slab) return slab < o.slab;
      if (v != o.v) return v < o.v;
      return a != o.a ? a < o.a : b < o.b;
    }
  };
  /// What sharp corners count: 2 at 0 degrees, 1 at kSeparationAngle, those of one contour (0 at kOwnAngle) kOwnWeight
  /// times as much.
  struct Sharpness {
    double all = 0, own = 0;  // own: of one contour
    /// Apart from `all`: of contours two slabs apart, where the slab between has neither edge. Told of windows only.
    double skew = 0;
  };

protected:
  static constexpr std::size_t kMostPanels = 64;  // where more end in one place, nothing moves, and none is asked about
  /// Degrees: angles of one contour below this count as sharp, and for more, where contours move: they are not bent to
  /// and fro to get out of each other's way.
  static constexpr double kOwnAngle = 60, kOwnWeight = 2;

  /// An edge from a place, in some slabs. `through`: the panel that passes through the place and has no vertex there.
  struct Ray {
    GridPoint far;
    std::int32_t first, last;
    std::int32_t through;
  };
  [[nodiscard]] bool is_alive(std::int32_t k) const { return found_[std::size_t(k)] != UINT32_MAX; }
  [[nodiscard]] bool moves(std::int32_t k) const {
    return std::any_of(moving_.begin(), moving_.end(), [&](const Moving& m) { return m.panel == k; });
  }
  /// Does the plane lead a panel through p, where it does not end?
  [[nodiscard]] bool passes(std::int32_t k, const GridPoint& p) const {
    const GridPoint &a = panels_[std::size_t(k)].a, &b = panels_[std::size_t(k)].b;
    const auto on = std::int64_t(kOn) + 1;
    if (!is_alive(k) || a == p || b == p || std::max(a.x, b.x) + on < p.x || std::min(a.x, b.x) - on > p.x)
      return false;
    return dot(a, b, p) > 0 && dot(b, a, p) > 0 && segment_distance(p, a, b) <= kOn;
  }
  /// Adds the edges that end in p.
  void add_ends(const GridPoint& p) {
    for (const std::int32_t k : place_of(p).panels) {
      const Panel& panel = panels_[std::size_t(k)];
      rays_.push_back({panel.a == p ? panel.b : panel.a, panel.first, panel.last, kNone});
    }
  }
  /// The panels of some slabs, and of those next to them, that pass through p, in ascending order. `after`: without
  /// those that move. Until it is called again.
  [[nodiscard]] const std::vector<std::int32_t>& find_passing(const GridPoint& p, std::int32_t first, std::int32_t last,
                                                              bool after) {
    passing_.clear();
    buckets_.for_each_on(p, p, std::int64_t(kOn) + 1, [&](std::size_t bucket) {
      std::size_t count = 1;
      for (std::int32_t i = bucket_[bucket].first; i != kNone; i = entries_[std::size_t(i)].next) {
        ++count;
        const Entry& entry = entries_[std::size_t(i)];
        if (entry.last < first - 1 || entry.first > last + 1 || !is_alive(entry.panel)) continue;
        if (!passes(entry.panel, p) || (after && moves(entry.panel))) continue;
        passing_.push_back(entry.panel);
      }
      looked(count);
    });
    std::sort(passing_.begin(), passing_.end());
    passing_.erase(std::unique(passing_.begin(), passing_.end()), passing_.end());
    return passing_;
  }
  /// Adds those of the slabs next to those of the rays that pass through p: the plane leads them through it.
  void add_through(const GridPoint& p, bool after) {
    if (rays_.empty()) return;
    std::int32_t first = rays_.front().first, last = rays_.front().last;
    for (const Ray& r : rays_) {
      first = std::min(first, r.first);
      last = std::max(last, r.last);
    }
    for (const std::int32_t k : find_passing(p, first, last, after)) {
      const Panel& panel = panels_[std::size_t(k)];
      rays_.push_back({panel.a, panel.first, panel.last, k});
      rays_.push_back({panel.b, panel.first, panel.last, k});
    }
  }
  /// Which pairs of contours are looked at.
  enum class Pairs {
    Neighbors,     ///< of neighboring slabs, of no common one of the two
    NeighborsOwn,  ///< and those of one as well, below kOwnAngle
    TwoApart       ///< of slabs with one between, which has neither
  };
  /// Calls corner(slab, below, above, degrees, of_one) for rays of two slabs, the lower one `slab`, that follow each
  /// other around p at a sharp angle.
  template <class F>
  void for_each_sharp(const GridPoint& p, Pairs pairs, F&& corner) {
    if (rays_.size() < 2) return;
    planes_.clear();
    for (const Ray& r : rays_) {
      planes_.push_back(r.last);
      planes_.push_back(r.first - 1);
    }
    std::sort(planes_.begin(), planes_.end());
    planes_.erase(std::unique(planes_.begin(), planes_.end()), planes_.end());
    order_.clear();
    for (std::size_t i = 0; i < rays_.size(); ++i)
      order_.push_back({std::atan2(double(rays_[i].far.y - p.y), double(rays_[i].far.x - p.x)), i});
    std::sort(order_.begin(), order_.end());
    const auto on_one_way = [&](const Ray& q, const Ray& r) {  // the plane leads the longer one through the other's end
      return segment_distance(q.far, p, r.far) <= kOn || segment_distance(r.far, p, q.far) <= kOn;
    };
    const bool two = pairs == Pairs::TwoApart, own = pairs == Pairs::NeighborsOwn;
    for (const std::int32_t s : planes_) {
      const std::int32_t upper = s + (two ? 2 : 1);
      if (s < 0 || !stacked(std::size_t(s) + 1) || !stacked(std::size_t(upper))) continue;
      looked(rays_.size());
      around_.clear();
      for (const auto& [angle, i] : order_) {
        const Ray& r = rays_[i];
        const auto stands_in = [&](std::int32_t slab) { return r.first <= slab && slab <= r.last; };
        const int sides = two && stands_in(s + 1) ? 3 : (stands_in(s) ? 1 : 0) + (stands_in(upper) ? 2 : 0);
        if (sides == 0) continue;
        if (!around_.empty() && on_one_way(rays_[around_.back().ray], r))
          around_.back().sides |= sides;
        else
          around_.push_back({angle, i, sides});
      }
      if (around_.size() > 1 && on_one_way(rays_[around_.back().ray], rays_[around_.front().ray])) {
        around_.front().sides |= around_.back().sides;
        around_.pop_back();
      }
      if (around_.size() < 2) continue;
      for (std::size_t i = 0; i < around_.size(); ++i) {
        const bool end = i + 1 == around_.size();
        const Direction &q = around_[i], &r = around_[end ? 0 : i + 1];
        const double degrees = (r.angle - q.angle + (end ? 2 * kPi : 0)) * (180 / kPi);
        const bool of_one = (q.sides & r.sides) != 0;
        if (of_one ? !own || degrees >= kOwnAngle : degrees >= kSeparationAngle) continue;
        corner(std::size_t(s), rays_[(q.sides & 1) != 0 ? q.ray : r.ray], rays_[(q.sides & 1) != 0 ? r.ray : q.ray],
               degrees, of_one);
      }
    }
  }
  /// All of them, the sharpest first.
  [[nodiscard]] std::vector<Corner> sharp_corners() {
    std::vector<Corner> result;
    for (const auto& [p, place] : places_) {  // in any order
      looked();
      if (place.panels.size() > kMostPanels) continue;
      rays_.clear();
      add_ends(p);
      add_through(p, false);
      const GridPoint v = p;
      for_each_sharp(v, Pairs::Neighbors, [&](std::size_t s, const Ray& below, const Ray& above, double degrees, bool) {
        result.push_back({degrees, s, v, below.far, above.far, below.through, above.through});
      });
    }
    add_crossings(result);
    sort_and_unite(result);
    return result;
  }
  /// Sharp corners, and vertices of contours that are too near to what the next slab has.
  [[nodiscard]] std::vector<Corner> all_faults() {
    std::vector<Corner> result = sharp_corners();
    if (!(limits_.separate > 0)) return result;
    const std::size_t corners = result.size();
    for (const auto& [p, place] : places_) {  // in any order
      looked();
      if (!place.standing.empty() && place.panels.size() <= kMostPanels) add_near(p, place.standing, result);
    }
    if (result.size() > corners) sort_and_unite(result);
    return result;
  }
  /// Adds what is nearer to a vertex than `separate` and is of a slab next to one of its own, but of neither contour
  /// alone: an edge, as a corner of as many degrees as it is near, or another vertex.
  void add_near(const GridPoint& p, const std::vector<Standing>& standing, std::vector<Corner>& corners) {
    const auto first = std::int32_t(standing.front().slab), last = std::int32_t(standing.back().slab);
    const double limit = limits_.separate;
    buckets_.for_each_on(p, p, std::int64_t(limit) + 1, [&](std::size_t bucket) {
      std::size_t count = 1;
      for (std::int32_t i = bucket_[bucket].first; i != kNone; i = entries_[std::size_t(i)].next) {
        ++count;
        const Entry& entry = entries_[std::size_t(i)];
        if (entry.last < first - 1 || entry.first > last + 1 || !is_alive(entry.panel)) continue;
        const Panel& panel = panels_[std::size_t(entry.panel)];
        const double d = segment_distance(p, panel.a, panel.b);
        if (!(d < limit) || panel.a == p || panel.b == p) continue;
        if (d > kOn && dot(panel.a, panel.b, p) > 0 && dot(panel.b, panel.a, p) > 0)
          add_pairs(p, panel, panel.a, panel.b, d, corners);
        for (const GridPoint& end : {panel.a, panel.b})
          if (p < end && distance(p, end) < limit) add_pairs(p, panel, end, end, distance(p, end), corners);
      }
      looked(count);
    });
  }
  /// Adds what is that near to a vertex: a panel from a to b, or its end a = b.
  void add_pairs(const GridPoint& p, const Panel& panel, const GridPoint& a, const GridPoint& b, double near,
                 std::vector<Corner>& corners) {
    // Within its slabs a panel is near to a contour of its own: it counts where it begins and ends.
    for (const bool below : {true, false}) {  // is the vertex below the panel?
      const std::size_t other = std::size_t(below ? panel.first : panel.last), here = below ? other - 1 : other + 1;
      const std::size_t lower = std::min(here, other);
      if ((below && other == 0) || !stacked(lower + 1) || at(here, p) == kNone || at(other, p) != kNone) continue;
      if (a == b && at(here, a) != kNone) continue;
      if (goes_through(other, p, a, a == b) || (a == b && goes_through(here, a, p, true))) continue;
      corners.push_back({kSeparationAngle * near / limits_.separate, lower, p, a, b, kNone, kNone});
    }
  }
  /// Does a slab have an edge that passes through p, other than (`but`) one that ends in q?
  [[nodiscard]] bool goes_through(std::size_t slab, const GridPoint& p, const GridPoint& q, bool but) {
    const std::vector<std::int32_t>& passing = find_passing(p, std::int32_t(slab), std::int32_t(slab), false);
    return std::any_of(passing.begin(), passing.end(), [&](std::int32_t k) {
      const Panel& panel = panels_[std::size_t(k)];
      return std::size_t(panel.first) <= slab && slab <= std::size_t(panel.last) &&
             !(but && (panel.a == q || panel.b == q));
    });
  }
  /// Faults are found in every bucket that is looked at.
  static void sort_and_unite(std::vector<Corner>& corners) {
    std::sort(corners.begin(), corners.end());
    const auto same = [](const Corner& p, const Corner& q) { return !(p < q); };
    corners.erase(std::unique(corners.begin(), corners.end(), same), corners.end());
  }
  /// That of corners between contours.
  [[nodiscard]] static double sharpness_of(const std::vector<Corner>& corners) {
    double sum = 0;
    for (const Corner& corner : corners) sum += 2 - corner.degrees / kSeparationAngle;
    return sum;
  }
  /// Adds that of the contours in a window by themselves, and of those two slabs apart.
  void add_own_and_skew(const OutlineWindow& window, Sharpness& sum) {
    ends_.clear();
    for (const auto& [p, place] : places_)  // in any order
      if (window.has(p) && place.panels.size() <= kMostPanels) ends_.push_back(p);
    std::sort(ends_.begin(), ends_.end());
    for (const GridPoint& p : ends_) {
      looked();
      rays_.clear();
      add_ends(p);
      add_through(p, false);
      for_each_sharp(p, Pairs::NeighborsOwn, [&](std::size_t, const Ray&, const Ray&, double degrees, bool of_one) {
        if (of_one) sum.own += kOwnWeight * (2 - degrees / kSeparationAngle);
      });
      for_each_sharp(p, Pairs::TwoApart, [&](std::size_t, const Ray&, const Ray&, double degrees, bool) {
        sum.skew += 2 - degrees / kSeparationAngle;
      });
    }
    sum.all += sum.own;
  }
  /// Adds the sharp corners of edges that cross where neither has a vertex: both go through there.
  void add_crossings(std::vector<Corner>& corners) {
    const auto cross_sharply = [](const Panel& p, const Panel& q) {
      if (p.a == q.a || p.a == q.b || p.b == q.a || p.b == q.b || !segments_meet(p.a, p.b, q.a, q.b)) return false;
      return std::min({segment_distance(p.a, q.a, q.b), segment_distance(p.b, q.a, q.b),
                       segment_distance(q.a, p.a, p.b), segment_distance(q.b, p.a, p.b)}) > kOn;
    };
    const auto boxes_meet = [](const Panel& p, const Panel& q) {  // of edges that cross, they do
      return std::max(p.a.x, p.b.x) >= std::min(q.a.x, q.b.x) && std::max(q.a.x, q.b.x) >= std::min(p.a.x, p.b.x) &&
             std::max(p.a.y, p.b.y) >= std::min(q.a.y, q.b.y) && std::max(q.a.y, q.b.y) >= std::min(p.a.y, p.b.y);
    };
    for (std::size_t bucket = 0; bucket < bucket_.size(); ++bucket) {
      looked();
      passing_.clear();
      for (std::int32_t i = bucket_[bucket].first; i != kNone; i = entries_[std::size_t(i)].next)
        if (is_alive(entries_[std::size_t(i)].panel)) passing_.push_back(entries_[std::size_t(i)].panel);
      if (passing_.size() < 2) continue;
      looked(passing_.size());
      const auto first_of = [&](std::int32_t k) { return panels_[std::size_t(k)].first; };
      std::sort(passing_.begin(), passing_.end(), [&](std::int32_t k, std::int32_t l) {
        return first_of(k) != first_of(l) ? first_of(k) < first_of(l) : k < l;
      });
      for (const std::int32_t k : passing_) {
        const Panel& below = panels_[std::size_t(k)];
        const std::int32_t slab = below.last;
        if (!stacked(std::size_t(slab) + 1)) continue;
        auto l = std::lower_bound(passing_.begin(), passing_.end(), slab + 1,
                                  [&](std::int32_t m, std::int32_t first) { return first_of(m) < first; });
        for (; l != passing_.end() && first_of(*l) == slab + 1; ++l) {
          looked();
          const Panel& above = panels_[std::size_t(*l)];
          if (!boxes_meet(below, above)) continue;
          const double x = double(below.b.x - below.a.x), y = double(below.b.y - below.a.y),
                       u = double(above.b.x - above.a.x), v = double(above.b.y - above.a.y);
          const double degrees = std::atan2(std::fabs(x * v - y * u), std::fabs(x * u + y * v)) * (180 / kPi);
          if (degrees >= kSeparationAngle || !cross_sharply(below, above)) continue;
          const GridPoint at = rounded_crossing(below.a, below.b, above.a, above.b);
          const bool alike = x * u + y * v > 0;
          corners.push_back({degrees,
                             std::size_t(slab),
                             {round_to_step(at.x), round_to_step(at.y)},
                             below.b,
                             alike ? above.b : above.a,
                             k,
                             *l});
        }
      }
    }
  }

  /// Where columns go: all to one place, or the slabs of two parts to one place each while the others stay.
  struct Target {
    GridPoint one;  // or where those are that stay
    std::size_t parts = 0;
    std::array<GridPoint, 2> place{};
    std::array<Part, 2> part{};
    /// The number of the part that a slab is in; that of parts if in none.
    [[nodiscard]] std::size_t part_of(std::int32_t slab) const {
      std::size_t i = 0;
      while (i < parts && (part[i].first > std::size_t(slab) || std::size_t(slab) > part[i].last)) ++i;
      return i;
    }
    [[nodiscard]] const GridPoint& of(std::int32_t slab) const {
      const std::size_t i = part_of(slab);
      return i < parts ? place[i] : one;
    }
  };
  /// That of the corners around the columns in question; `target`: if the columns were there.
  [[nodiscard]] Sharpness sharpness(const Candidate& c, const Target* target) {
    Sharpness sum;
    const std::int32_t first = lowest_, last = lowest_ + std::int32_t(steps_.size()) - 1;
    const auto add = [&](const GridPoint& p) {
      // What stands in slabs farther off does not change.
      rays_.erase(std::remove_if(rays_.begin(), rays_.end(),
                                 [&](const Ray& r) { return r.last < first - 1 || r.first > last + 1; }),
                  rays_.end());
      if (rays_.size() > kMostPanels) return;
      if (target != nullptr)
        for (Ray& r : rays_)
          if ((r.far == c.v || r.far == c.w) && r.last >= first && r.first <= last) r.far = target->of(r.first);
      rays_.erase(std::remove_if(rays_.begin(), rays_.end(), [&](const Ray& r) { return r.far == p; }), rays_.end());
      add_through(p, target != nullptr);
      for_each_sharp(p, Pairs::NeighborsOwn, [&](std::size_t, const Ray&, const Ray&, double degrees, bool of_one) {
        const double counts = (of_one ? kOwnWeight : 1) * (2 - degrees / kSeparationAngle);
        sum.all += counts;
        if (of_one) sum.own += counts;
      });
    };
    ends_.clear();
    for (const Moving& m : moving_) ends_.push_back(m.x);
    std::sort(ends_.begin(), ends_.end());
    ends_.erase(std::unique(ends_.begin(), ends_.end()), ends_.end());
    for (const GridPoint& p : ends_) {
      rays_.clear();
      add_ends(p);
      add(p);
    }
    rays_.clear();
    add_ends(c.v);
    if (target != nullptr && target->parts > 0) {
      std::array<GridPoint, 3> places{c.v};
      std::copy_n(target->place.begin(), target->parts, places.begin() + 1);
      for (std::size_t i = 0; i <= target->parts; ++i) {
        rays_.clear();
        add_ends(c.v);
        rays_.erase(
            std::remove_if(rays_.begin(), rays_.end(), [&](const Ray& r) { return target->of(r.first) != places[i]; }),
            rays_.end());
        add(places[i]);
      }
      return sum;
    }
    if (target == nullptr) {
      add(c.v);
      rays_.clear();
    }
    if (c.w != c.v) add_ends(c.w);
    add(target != nullptr ? target->one : c.w);
    return sum;
  }

private:
  std::vector<Ray> rays_;                              // around the place in question
  std::vector<std::int32_t> passing_;                  // see find_passing
  std::vector<std::int32_t> planes_;                   // where the rays may differ, by the slab below
  std::vector<std::pair<double, std::size_t>> order_;  // rays by direction
  /// One or more rays of a plane; sides: 1 of the contour below, 2 of the one above.
  struct Direction {
    double angle;
    std::size_t ray;
    int sides;
  };
  std::vector<Direction> around_;
  std::vector<GridPoint> ends_;  // of the edges in question
};

}  // namespace slice2mesh::detail
