// SPDX-License-Identifier: MIT
/// @file
/// @brief Contours of neighboring slabs that meet at a sharp angle, led on one way until they part at a wider one.
///
/// Where the contours of two slabs leave each other slowly, the plane between them has a tip as sharp as the angle
/// between the two. Both may keep the same way for a while longer: as soon as the rest of it makes a wide enough angle,
/// they part.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/harmonize/column_stack.hpp"
#include "slice2mesh/harmonize/contour_shape.hpp"
#include "slice2mesh/harmonize/corner_finder.hpp"
#include "slice2mesh/harmonize/separation_report.hpp"
#include "slice2mesh/regions/thicken.hpp"

namespace slice2mesh::detail {

/// Opens the sharp corners between contours of neighboring slabs.
class CornerOpener : protected CornerFinder {
public:
  using CornerFinder::Corner;
  using CornerFinder::CornerFinder;

  /// Opens what can be opened, merges the ends of short edges where no corner gets sharper by it, and opens again; to
  /// be called once. `changed` (#S) tells the slabs concerned. `poll` is called now and then; what it throws ends the
  /// work. Returns what is left (see all_faults).
  std::vector<Corner> run(std::vector<char>& changed, const std::function<void()>& poll) {
    std::vector<Corner> left;
    work_on_corners(changed, poll, [&] {
      open_all(kRounds);
      tidy();
      open_all(kLastRounds);
      // What is left goes on to where there is more room, even if the way there is a bit worse.
      use_all_room();
      open_all_gaining(kSmallGain, kSmallRounds);
      open_all_gaining(-kShake, 1);
      open_all_gaining(kSmallGain, kSmallRounds);
      left = all_faults();
    });
    return left;
  }

protected:
  /// As work.
  template <class F>
  void work_on_corners(std::vector<char>& changed, const std::function<void()>& poll, F&& f) {
    reach_ = kFarthest * limits_.apart;
    clearance_ = limits_.clearance;
    changed_ = &changed;
    touched_.assign(bucket_.size(), 0);
    work(changed, poll, f);
  }
  /// What is nearer to the slices, and to other vertices, is allowed from here on.
  void use_all_room() {
    limits_.deviation = std::max(limits_.deviation, limits_.most);
    limits_.apart *= kApartAtLast;
  }

  static constexpr int kRounds = 3, kLastRounds = 2, kSmallRounds = 6;
  static constexpr std::int32_t kMostSlabs = 128;  // no vertex is put into more of them for one corner
  static constexpr double kFarthest = 16;          // of `apart`: what a column moves in all
  static constexpr double kMargin = 1;             // degrees more than asked for
  static constexpr double kNear = 4;  // of `apart`: what happens farther from a corner does not matter to it
  /// What sharpness gets less by at least: a corner that is there no more makes it less by 1 or more.
  static constexpr double kLeastGain = 0.5;
  static constexpr double kSmallGain = 0.02, kShake = 1;  // at last, and what may be lost on the way
  static constexpr double kApartAtLast = 0.9;             // of `apart`
  /// Shares of a way between two edges that it has of the second one.
  static constexpr std::array<double, 9> kShares{0.5, 0.375, 0.625, 0.25, 0.75, 0.125, 0.875, 0, 1};
  static constexpr std::array<double, 4> kPushes{0.17, 0.33, 0.58, 0.83};  // of `apart`: what ends are pushed by
  static constexpr std::array<double, 3> kPushAlongs{0, -1, 1};            // of that: along the other edge
  static constexpr std::array<double, 3> kCrossings{0.5, 1.2, 2};          // of `apart`: how far off panels may cross
  static constexpr double kWidestTip = 1.7;                                // of `apart`: that is closed

  /// What is tried where a column goes in two: what they are apart, in `apart`, and in shares of that, how much farther
  /// the one that moves stands along the contours, and where before they part.
  static constexpr std::array<double, 4> kGaps{1.05, 1.3, 1.6, 2}, kAlongs{0, 0.5, 1, -0.4};
  static constexpr std::array<double, 2> kBefore{1.6, 1.2};
  static constexpr std::array<double, 5> kPartShares{0, 1, 0.5, 0.3, 0.7};  // of that: what the upper part moves
  static constexpr double kNearby = 1.06;  // of that: a vertex that is this near may stand for it

  /// The panel between two places that a slab has, or kNone.
  [[nodiscard]] std::int32_t panel_between(const GridPoint& p, const GridPoint& q, std::size_t slab) const {
    for (const std::int32_t k : place_of(p).panels) {
      const Panel& panel = panels_[std::size_t(k)];
      if ((panel.a == p ? panel.b : panel.a) == q && std::size_t(panel.first) <= slab &&
          slab <= std::size_t(panel.last))
        return k;
    }
    return kNone;
  }
  /// As find_pair. Where more than two edges of a slab meet, the column stays.
  [[nodiscard]] bool find_simple(const Candidate& c) {
    if (!room_.has(c.v) || !room_.has(c.w) || !find_pair(c) || moving_.size() > kMostPanels) return false;
    return std::all_of(steps_.begin(), steps_.end(), [&](const Step& step) {
      const Sheet& sheet = sheets_[step.slab];
      return (step.v == kNone || sheet.edges_at[std::size_t(step.v)].size() == 2) &&
             (step.w == kNone || sheet.edges_at[std::size_t(step.w)].size() == 2);
    });
  }
  /// Does a move gain what is asked for? What may be lost on the way is lost between contours: none gets a zigzag.
  [[nodiscard]] bool gains(const Sharpness& before, const Sharpness& after) const {
    return after.all <= before.all - gain_ && (gain_ > 0 || after.own <= before.own);
  }
  /// Could a contour of a slab go through a point that is in the room? Else there is no need to ask for more.
  [[nodiscard]] bool is_near_slice(std::size_t slab, const GridPoint& p) {
    return room_.has(p) && slice_of(slab)->index().is_within(p, limits_.deviation, listen_);
  }
  /// Moves the columns at c.v and c.w to one of the places, the first that may be and makes corners less sharp.
  /// `added`: a column was not there before.
  bool move_to(const Candidate& c, const std::vector<GridPoint>& targets, bool added) {
    const auto near_slice = [&](const GridPoint& t) { return is_near_slice(c.slab, t); };
    if (std::none_of(targets.begin(), targets.end(), near_slice) || !find_simple(c)) return false;
    reach_near_ = 0;
    for (const GridPoint& t : targets) reach_near_ = std::max({reach_near_, distance(t, c.v), distance(t, c.w)});
    const Sharpness before = sharpness(c, nullptr);
    if (!(before.all > std::max(gain_, 0.0))) return false;
    for (const GridPoint& t : targets) {
      if (!near_slice(t) || std::any_of(moving_.begin(), moving_.end(),
                                        [&](const Moving& m) { return distance(m.x, t) < limits_.apart; }))
        continue;
      if (added && is_crowded(t, lowest_, lowest_ + std::int32_t(steps_.size()) - 1, c, kNone)) continue;
      const Target target{t};
      if (!gains(before, sharpness(c, &target))) continue;
      if (near_.empty()) find_all_near();
      if (!added && gets_crowded(c, t)) continue;
      if (!possible(c, t)) continue;
      settle(c, t);
      return true;
    }
    return false;
  }
  /// Do corners of the contours stay where they are, and straight walls on their lines, if the pair goes there?
  [[nodiscard]] bool stays_in_shape(const GridPoint& target) const {
    const auto stays = [&](const Sheet& sheet, std::int32_t v) {
      if (v == kNone || sheet.point(v) == target) return true;
      const std::vector<std::int32_t>& edges = sheet.edges_at[std::size_t(v)];
      const GridPoint &a = sheet.point(sheet.other_end(edges[0], v)), &b = sheet.point(sheet.other_end(edges[1], v));
      const ContourShape shape = contour_shape(sheet.point(v), a, b);
      return shape == ContourShape::Curved ||
             (shape == ContourShape::Straight && line_distance(target, a, b) <= kOnLine);
    };
    return std::all_of(steps_.begin(), steps_.end(), [&](const Step& step) {
      return stays(sheets_[step.slab], step.v) && stays(sheets_[step.slab], step.w);
    });
  }
  void settle(const Candidate& c, const GridPoint& t) {
    for (const GridPoint& p : {c.v, c.w, t}) touch(p);
    for (const Moving& m : moving_) touch(m.x);
    apply(c, t);
    for (const Step& step : steps_) (*changed_)[step.slab] = 1;
  }
  /// Would a new column at t in some slabs be too near to a vertex or an edge of these or of those next to them? What
  /// moves, the panel `own` and what ends in the columns in question does not count.
  [[nodiscard]] bool is_crowded(const GridPoint& t, std::int32_t first, std::int32_t last, const Candidate& c,
                                std::int32_t own) {
    const double apart = limits_.apart;
    bool crowded = false;
    buckets_.for_each_on(t, t, std::int64_t(apart) + 1, [&](std::size_t bucket) {
      std::size_t count = 1;
      for (std::int32_t i = bucket_[bucket].first; i != kNone && !crowded; i = entries_[std::size_t(i)].next) {
        ++count;
        const Entry& entry = entries_[std::size_t(i)];
        if (entry.last < first - 1 || entry.first > last + 1 || !is_alive(entry.panel)) continue;
        const Panel& panel = panels_[std::size_t(entry.panel)];
        for (const GridPoint* u : {&panel.a, &panel.b})
          if (*u != t && *u != c.v && *u != c.w && distance(*u, t) < apart) crowded = true;
        if (entry.panel == own || panel.a == t || panel.b == t || moves(entry.panel)) continue;
        const double d = segment_distance(t, panel.a, panel.b);
        if (d > kOn && d < limits_.clearance) crowded = true;
      }
      looked(count);
    });
    return crowded;
  }
  /// The same for a column that is there.
  [[nodiscard]] bool gets_crowded(const Candidate& c, const GridPoint& t) const {
    return std::any_of(near_.begin(), near_.end(), [&](const Panel& panel) {
      for (const GridPoint* u : {&panel.a, &panel.b}) {
        if (*u == t || *u == c.v || *u == c.w) continue;
        const double now = distance(*u, t);
        if (now < limits_.apart && now < std::min(distance(*u, c.v), distance(*u, c.w))) return true;
      }
      return false;
    });
  }
  [[nodiscard]] static GridPoint rounded(double x, double y) {
    return {round_to_step(std::llround(x)), round_to_step(std::llround(y))};
  }

  void open_all(int rounds) {
    for (int i = 0; i < rounds; ++i) {
      std::size_t opened = 0;
      ++round_;
      for (const Corner& corner : sharp_corners()) {
        looked(16);
        if (!room_.has(corner.v) || !may_have_changed(corner)) continue;
        if (open(corner)) ++opened;
      }
      if (opened == 0) break;
    }
  }
  /// The same for corners that were tried before, with another gain.
  void open_all_gaining(double gain, int rounds) {
    gain_ = gain;
    all_in_ = round_ + 1;
    open_all(rounds);
  }
  /// Has anything moved near a corner since it was tried last?
  [[nodiscard]] bool may_have_changed(const Corner& c) const {
    if (round_ == all_in_) return true;
    const auto near = std::int64_t(kNear * limits_.apart + std::max(distance(c.v, c.a), distance(c.v, c.b)));
    return buckets_.any_on(c.v, c.v, near, [&](std::size_t bucket) {
      looked();
      return touched_[bucket] + 1 >= round_;
    });
  }
  /// Contours may have left what the buckets cover.
  void touch(const GridPoint& p) { touched_[buckets_.at(buckets_.nearest_to(p))] = round_; }
  /// Merges the ends of short edges where no corner gets sharper by it.
  void tidy() {
    struct Short {
      double length;
      std::size_t slab;
      GridPoint a, b;
      bool operator<(const Short& o) const {
        if (length != o.length) return length < o.length;
        if (slab != o.slab) return slab < o.slab;
        return a != o.a ? a < o.a : b < o.b;
      }
    };
    std::vector<Short> edges;
    for (std::size_t k = 0; k < panels_.size(); ++k) {
      looked();
      const Panel& p = panels_[k];
      const double length = distance(p.a, p.b);
      if (is_alive(std::int32_t(k)) && length < limits_.near) edges.push_back({length, std::size_t(p.first), p.a, p.b});
    }
    sort_listening(edges.begin(), edges.end(), *listen_);
    for (const Short& e : edges) {
      looked(16);
      if (panel_between(e.a, e.b, e.slab) == kNone) continue;  // something has changed meanwhile
      const Candidate c{e.length, e.slab, e.a, e.b};
      if (!find_simple(c)) continue;
      std::array<std::pair<double, GridPoint>, 3> targets{
          {{0, c.v}, {0, c.w}, {0, contour_point_between(c.v, c.w, 0.5)}}};
      for (auto& target : targets) target.first = stays_in_shape(target.second) ? change(target.second) : HUGE_VAL;
      std::stable_sort(targets.begin(), targets.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
      reach_near_ = c.distance;
      const Sharpness before = sharpness(c, nullptr);
      for (const auto& target : targets) {
        const Target there{target.second};
        if (target.first > limits_.deviation || sharpness(c, &there).all > before.all) continue;
        if (near_.empty()) find_all_near();
        if (gets_crowded(c, target.second) || !possible(c, target.second)) continue;
        settle(c, target.second);
        break;
      }
    }
  }

  /// A vertex that a panel was led through, and a slab of that.
  struct Lead {
    GridPoint at;
    std::size_t slab;
  };
  /// Leads a panel of a slab through y. `stays`: the vertex does not move afterwards.
  bool lead(std::int32_t k, const GridPoint& y, std::size_t slab, std::vector<Lead>& leads, bool stays) {
    const Panel& panel = panels_[std::size_t(k)];
    if (std::size_t(panel.first) > slab || std::size_t(panel.last) < slab) return false;  // it was parted meanwhile
    if (panel.last - panel.first >= kMostSlabs || !room_.has(y)) return false;
    moving_.clear();
    if (stays && is_crowded(y, panel.first, panel.last, {0, slab, y, y}, k)) return false;
    if (!lead_through(k, y, *changed_)) return false;
    leads.push_back({y, slab});
    return true;
  }
  void take_back_all(std::vector<Lead>& leads) {
    for (; !leads.empty(); leads.pop_back()) take_back(leads.back().at, leads.back().slab);
  }

  bool open(const Corner& c) {
    // What the plane leads through the corner gets a vertex there, in all of its slabs.
    std::vector<Lead> leads;
    const auto lead_here = [&](std::int32_t k, std::size_t slab) {
      return k == kNone || (passes(k, c.v) && lead(k, c.v, slab, leads, true));
    };
    if (lead_here(c.through_a, c.slab) && lead_here(c.through_b, c.slab + 1) && open_at_vertex(c)) return true;
    take_back_all(leads);
    if (c.through_a != kNone && c.through_b == kNone) return stand_together(c, c.through_a, c.slab, c.slab + 1);
    if (c.through_b != kNone && c.through_a == kNone) return stand_together(c, c.through_b, c.slab + 1, c.slab);
    return c.through_a != kNone && c.through_b != kNone && cross_together(c);
  }
  /// The vertex nearest to p, nearer than `apart`, that stands in some slabs or in those next to them; p if there is
  /// none. `k`: only those that this panel passes through, if any.
  [[nodiscard]] GridPoint nearest_vertex(const GridPoint& p, std::int32_t first, std::int32_t last, std::int32_t k) {
    GridPoint nearest = p;
    double least = limits_.apart;
    buckets_.for_each_on(p, p, std::int64_t(least) + 1, [&](std::size_t bucket) {
      std::size_t count = 1;
      for (std::int32_t i = bucket_[bucket].first; i != kNone; i = entries_[std::size_t(i)].next) {
        ++count;
        const Entry& entry = entries_[std::size_t(i)];
        if (entry.last < first - 1 || entry.first > last + 1 || !is_alive(entry.panel)) continue;
        for (const GridPoint& u : {panels_[std::size_t(entry.panel)].a, panels_[std::size_t(entry.panel)].b}) {
          const double d = distance(u, p);
          if (u == p || d > least || (d == least && !(u < nearest)) || (k != kNone && !passes(k, u))) continue;
          nearest = u;
          least = d;
        }
      }
      looked(count);
    });
    return nearest;
  }
  /// A vertex at the corner of `slab` that a panel of `other` passes through: moves it to where a vertex of a slab on
  /// the panel's other side stands on the panel as well, too near to it for a vertex of the panel at the corner. Then
  /// all have one there.
  bool stand_together(const Corner& c, std::int32_t k, std::size_t other, std::size_t slab) {
    if (!passes(k, c.v)) return false;
    const Panel panel = panels_[std::size_t(k)];
    const GridPoint nearest = nearest_vertex(c.v, panel.first, panel.last, k);
    const Candidate column{0, slab, c.v, c.v};
    if (nearest == c.v || !find_simple(column) || is_crowded(nearest, panel.first, panel.last, column, k)) return false;
    std::vector<Lead> leads;
    const double gain = std::exchange(gain_, -kShake);  // a corner more in the new place is of no account
    const bool moved = lead(k, nearest, other, leads, false) && move_to(column, {nearest}, false);
    gain_ = gain;
    if (!moved) take_back_all(leads);
    return moved;
  }
  /// Two panels that pass through the corner, too near to a vertex for one of their own: leads both through that, if it
  /// stands on one of them, or through a point of one of them that is farther away from it.
  bool cross_together(const Corner& c) {
    const std::array<std::int32_t, 2> panels{c.through_a, c.through_b};
    if (!passes(panels[0], c.v) || !passes(panels[1], c.v)) return false;
    const Panel below = panels_[std::size_t(panels[0])], above = panels_[std::size_t(panels[1])];
    const GridPoint u =
        nearest_vertex(c.v, std::min(below.first, above.first), std::max(below.last, above.last), kNone);
    if (u == c.v) return false;
    Sharpness before;
    std::vector<Lead> leads;
    if (lead(panels[0], c.v, c.slab, leads, false) && lead(panels[1], c.v, c.slab + 1, leads, false) &&
        find_simple({0, c.slab, c.v, c.v}))
      before = sharpness({0, c.slab, c.v, c.v}, nullptr);
    take_back_all(leads);
    for (std::size_t i = 0; i < 2; ++i)
      if (passes(panels[i], u) && cross_at(c, panels[i], panels[1 - i], u, before)) return true;
    for (const double far : kCrossings)
      for (std::size_t i = 0; i < 2; ++i) {
        const Panel panel = i == 0 ? below : above;
        for (const GridPoint& end : {panel.a, panel.b}) {
          const double length = distance(c.v, end);
          if (length < (far + 1) * limits_.apart) continue;
          if (cross_at(c, panels[i], panels[1 - i], contour_point_between(c.v, end, far * limits_.apart / length),
                       before))
            return true;
        }
      }
    return false;
  }
  /// Leads a panel through p, and the other one to there. `before`: how sharp they cross where they do.
  bool cross_at(const Corner& c, std::int32_t panel, std::int32_t other, const GridPoint& p, const Sharpness& before) {
    const auto slab_of = [&](std::int32_t k) { return k == c.through_a ? c.slab : c.slab + 1; };
    const auto [a, b, first, last] = panels_[std::size_t(other)];
    const double length = distance(a, b), t = double(dot(a, b, p)) / (length * length);
    // Not too near to a vertex; the edges are near to each other there.
    const Panel& led = panels_[std::size_t(panel)];
    if (!(t > 0 && t < 1) || nearest_vertex(p, led.first, led.last, kNone) != p) return false;
    std::vector<Lead> leads;
    bool crosses = lead(panel, p, slab_of(panel), leads, false);
    if (crosses && passes(other, p)) {
      crosses = lead(other, p, slab_of(other), leads, true);
    } else if (crosses) {
      const GridPoint foot = contour_point_between(a, b, t);
      crosses = lead(other, foot, slab_of(other), leads, false) && go_over(slab_of(other), foot, p, before);
    }
    if (!crosses) take_back_all(leads);
    return crosses;
  }
  /// Moves a column that was put in to p, where corners may be `most` sharp.
  bool go_over(std::size_t slab, const GridPoint& v, const GridPoint& p, const Sharpness& most) {
    const Candidate column{0, slab, v, v};
    const Target target{p};
    if (!is_near_slice(slab, p) || !find_simple(column) ||
        is_crowded(p, lowest_, lowest_ + std::int32_t(steps_.size()) - 1, column, kNone))
      return false;
    reach_near_ = distance(v, p);
    const Sharpness before = sharpness(column, nullptr), after = sharpness(column, &target);
    if (after.all > before.all + most.all || after.own > before.own + most.own) return false;
    find_all_near();
    if (!possible(column, p)) return false;
    settle(column, p);
    return true;
  }
  /// Is the rest of a column that is parted out of the way of what moves, and not too near to it?
  [[nodiscard]] bool parts_cleanly(const GridPoint& v, const GridPoint& target) const {
    const auto is_clear = [&](const Moving& m) { return segment_distance(v, target, m.x) >= limits_.clearance; };
    if (!std::all_of(moving_.begin(), moving_.end(), is_clear)) return false;
    return std::none_of(near_.begin(), near_.end(), [&](const Panel& other) {
      if ((other.a != v && other.b != v) || is_in_part(std::size_t(other.first))) return false;
      const GridPoint& x = other.a == v ? other.b : other.a;
      return segment_distance(target, v, x) < limits_.clearance ||
             std::any_of(moving_.begin(), moving_.end(), [&](const Moving& m) {
               return x == m.x ? orientation(x, v, target) == 0 : segments_meet(target, m.x, v, x);
             });
    });
  }
  /// The contours part where they come together: the column goes in two, below and above the plane, and one of them
  /// away from the other, or each from the other.
  bool part(const Corner& c) {
    // Along both, and from the one above to the one below.
    const double length_a = distance(c.v, c.a), length_b = distance(c.v, c.b);
    double x = double(c.a.x - c.v.x) / length_a + double(c.b.x - c.v.x) / length_b,
           y = double(c.a.y - c.v.y) / length_a + double(c.b.y - c.v.y) / length_b;
    const double length = std::hypot(x, y), turn = cross(c.v, c.a, c.b) > 0 ? 1 : -1;
    x /= length;
    y /= length;
    // The column may go in two, or what is below and above the panels in question may stay.
    const std::int32_t k = panel_between(c.v, c.a, c.slab), l = panel_between(c.v, c.b, c.slab + 1);
    const auto first = std::size_t(panels_[std::size_t(k)].first), last = std::size_t(panels_[std::size_t(l)].last);
    const bool goes_on_below = first > 0 && stacked(first) && at(first - 1, c.v) != kNone,
               goes_on_above = stacked(last + 1) && at(last + 1, c.v) != kNone;
    for (const bool alone : {false, true})
      for (const double share : kPartShares) {
        if (alone && (share == 1 || !goes_on_below) && (share == 0 || !goes_on_above)) continue;
        for (const double gap : kGaps)
          for (const double along : kAlongs) {
            const double far = gap * limits_.apart;
            const auto at_side = [&](double aside) {
              return rounded(double(c.v.x) + far * (along * x + aside * turn * y),
                             double(c.v.y) + far * (along * y - aside * turn * x));
            };
            Target target{c.v};
            const auto move = [&](const GridPoint& p, const Part& part) {
              target.place[target.parts] = p;
              target.part[target.parts++] = part;
            };
            if (share < 1) move(at_side(1 - share), {alone ? first : 0, c.slab});
            if (share > 0) move(at_side(-share), {c.slab + 1, alone ? last : SIZE_MAX});
            if (part(c.v, c.slab, target, far, along)) return true;
          }
      }
    return false;
  }
  /// Moves the parts of the column at v, which stands in `slab`, to their targets. What a part and the rest have in
  /// common stays together up to (about) a share of `far`, kBefore without `along`, from v.
  bool part(const GridPoint& v, std::size_t slab, const Target& target, double far, double along) {
    for (std::size_t i = 0; i < target.parts; ++i)
      if (!is_near_slice(slab_in(target.part[i], slab), target.place[i]) || is_near_rest(v, target, i)) return false;
    // Most are refused for what does not depend on the rest: nothing needs to be put in for that.
    if (!find_all_of(v, slab) || gets_crowded(v, slab, target)) return false;
    return std::any_of(kBefore.begin(), kBefore.end(),
                       [&](double before) { return part(v, slab, target, (before - along) * far); });
  }
  bool part(const GridPoint& v, std::size_t slab, const Target& target, double before) {
    std::vector<Lead> leads;
    if (lead_common(v, target, before, leads)) {
      const std::size_t count = panels_.size();
      for (std::size_t i = 0; i < target.parts; ++i) {
        if (target.part[i].first > 0) part_panels(v, target.part[i].first - 1);
        if (target.part[i].last < slabs_.size()) part_panels(v, target.part[i].last);
      }
      const bool parted = move_parts(v, slab, target);
      part_ = {};
      if (parted) return true;
      join_panels(count);
    }
    take_back_all(leads);
    return false;
  }
  /// Does what stays at v stand next to a part, and too near to where that goes?
  [[nodiscard]] bool is_near_rest(const GridPoint& v, const Target& target, std::size_t part) const {
    if (!(distance(target.place[part], v) < limits_.apart)) return false;
    const auto stays = [&](std::size_t s) {
      return s < slabs_.size() && target.part_of(std::int32_t(s)) == target.parts && at(s, v) != kNone;
    };
    const Part& p = target.part[part];
    return (p.first > 0 && stacked(p.first) && stays(p.first - 1)) ||
           (p.last < slabs_.size() && stacked(p.last + 1) && stays(p.last + 1));
  }
  /// Finds the steps and the panels of all of the column at v, of what may not move, too.
  [[nodiscard]] bool find_all_of(const GridPoint& v, std::size_t slab) {
    const Place& at_v = place_of(v);
    if (!find_steps(slab, at_v, nowhere_)) return false;
    find_moving(v, at_v, v, nowhere_);
    return moving_.size() <= kMostPanels;
  }
  /// Needs that.
  [[nodiscard]] bool gets_crowded(const GridPoint& v, std::size_t slab, const Target& target) {
    const std::int32_t first = lowest_, last = lowest_ + std::int32_t(steps_.size()) - 1;
    for (std::size_t i = 0; i < target.parts; ++i)
      if (is_crowded(target.place[i], std::max(first, std::int32_t(target.part[i].first)),
                     std::int32_t(std::min(std::size_t(last), target.part[i].last)), {0, slab, v, v}, kNone))
        return true;
    return false;
  }
  /// A slab of a part of a column: that one, or the one next to it.
  [[nodiscard]] static std::size_t slab_in(const Part& part, std::size_t slab) {
    return std::clamp(slab, part.first, part.last);
  }
  /// Gives a vertex to the panels at v that are to be parted.
  [[nodiscard]] bool lead_common(const GridPoint& v, const Target& target, double before, std::vector<Lead>& leads) {
    const auto goes = [&](std::int32_t s) { return target.part_of(s); };
    common_.clear();
    // Not those that go on below and above a part between: with a vertex for all of them elements got worse.
    for (const std::int32_t k : place_of(v).panels)
      if (goes(panels_[std::size_t(k)].first) != goes(panels_[std::size_t(k)].last)) common_.push_back(k);
    for (const std::int32_t k : common_) {
      const Panel& panel = panels_[std::size_t(k)];
      const GridPoint u = panel.a == v ? panel.b : panel.a;
      const double length = distance(v, u);
      if (length <= kNearby * before) continue;
      if (before < limits_.apart || length < before + limits_.apart) return false;
      if (!lead(k, contour_point_between(v, u, before / length), std::size_t(panel.first), leads, true)) return false;
    }
    return true;
  }
  bool move_parts(const GridPoint& v, std::size_t slab, const Target& target) {
    const auto candidate_of = [&](std::size_t i) { return Candidate{0, slab_in(target.part[i], slab), v, v}; };
    const Candidate c{0, slab, v, v};
    if (!find_all_of(v, slab)) return false;
    for (const Moving& m : moving_) {
      const GridPoint& t = target.of(panels_[std::size_t(m.panel)].first);
      if (t != v && distance(m.x, t) < limits_.apart) return false;
    }
    const Sharpness before = sharpness(c, nullptr);
    if (!(before.all > std::max(gain_, 0.0))) return false;
    if (!gains(before, sharpness(c, &target))) return false;
    const std::vector<Moving> all = moving_;
    for (std::size_t i = 0; i < target.parts; ++i) {
      part_ = target.part[i];
      if (!find_simple(candidate_of(i))) return false;
      reach_near_ = distance(target.place[i], v);
      find_all_near();
      if (!parts_cleanly(v, target.place[i]) || !possible(candidate_of(i), target.place[i])) return false;
    }
    if (target.parts > 1)  // ... and out of the way of each other
      for (const Moving& m : all)
        for (const Moving& n : all) {
          const std::int32_t i = panels_[std::size_t(m.panel)].first, j = panels_[std::size_t(n.panel)].first;
          const GridPoint &s = target.of(i), &t = target.of(j);
          if (s != target.place[0] || t != target.place[1]) continue;
          if (m.x == n.x ? orientation(m.x, s, t) == 0 : segments_meet(s, m.x, t, n.x)) return false;
          if (segment_distance(s, t, n.x) < limits_.clearance || segment_distance(t, s, m.x) < limits_.clearance)
            return false;
        }
    for (std::size_t i = 0; i < target.parts; ++i) {
      part_ = target.part[i];
      (void)find_simple(candidate_of(i));  // as above: what the other one does changes nothing in its slabs
      settle(candidate_of(i), target.place[i]);
    }
    return true;
  }
  bool open_at_vertex(const Corner& c) {
    const std::int32_t k = panel_between(c.v, c.a, c.slab), l = panel_between(c.v, c.b, c.slab + 1);
    if (k == kNone || l == kNone) return false;  // something has changed meanwhile
    const Panel below = panels_[std::size_t(k)], above = panels_[std::size_t(l)];
    if (std::size_t(below.last) > c.slab || std::size_t(above.first) <= c.slab) return false;
    return go_together(c, k, l) || push_apart(c) || close_tip(c, k, l) || part(c) || push_alone(c, k, l);
  }
  /// Leads both edges on one way until the rest of them makes a wide enough angle.
  bool go_together(const Corner& c, std::int32_t k, std::int32_t l) {
    const auto slabs_of = [&](std::int32_t panel) {
      return panels_[std::size_t(panel)].last - panels_[std::size_t(panel)].first + 1;
    };
    struct Way {
      double share, length;
      GridPoint to;
      std::int32_t cost;  // slabs that get a vertex more
    };
    std::vector<Way> ways;
    const double length_a = distance(c.v, c.a), length_b = distance(c.v, c.b);
    for (const double share : kShares) {
      const auto at = [&](double length) {
        const double ta = (1 - share) * length / length_a, tb = share * length / length_b;
        return rounded(double(c.v.x) + ta * double(c.a.x - c.v.x) + tb * double(c.b.x - c.v.x),
                       double(c.v.y) + ta * double(c.a.y - c.v.y) + tb * double(c.b.y - c.v.y));
      };
      double low = 0, high = std::min(length_a, length_b);  // the angle grows on the way
      for (int i = 0; i < 20; ++i) {
        const double length = (low + high) / 2;
        const GridPoint t = at(length);
        const double turn = std::fabs(std::atan2(double(cross(t, c.a, c.b)), double(dot(t, c.a, c.b))));
        (turn * (180 / kPi) > kSeparationAngle + kMargin ? high : low) = length;
      }
      const GridPoint t = at(high);
      if (std::min(distance(t, c.a), distance(t, c.b)) < limits_.apart) continue;
      ways.push_back({share, high, t, (share > 0 ? slabs_of(k) : 0) + (share < 1 ? slabs_of(l) : 0)});
    }
    // Best if the corner itself goes there: that needs no more vertices.
    std::vector<GridPoint> targets;
    targets.reserve(ways.size());
    for (const Way& way : ways) targets.push_back(way.to);
    if (move_to({0, c.slab, c.v, c.v}, targets, false)) return true;
    std::stable_sort(ways.begin(), ways.end(), [](const Way& a, const Way& b) { return a.cost < b.cost; });
    std::vector<Lead> leads;
    for (const Way& way : ways) {
      const GridPoint y = contour_point_between(c.v, c.a, way.length / length_a),
                      z = contour_point_between(c.v, c.b, way.length / length_b);
      if (y == z || way.length < limits_.apart) continue;
      const bool move_a = way.share > 0, move_b = way.share < 1;
      const Candidate pair{distance(y, z), move_a ? c.slab : c.slab + 1, move_a ? y : z, move_b ? z : y};
      if ((!move_a || lead(k, y, c.slab, leads, false)) && (!move_b || lead(l, z, c.slab + 1, leads, false)) &&
          move_to(pair, {way.to}, true))
        return true;
      take_back_all(leads);
    }
    return false;
  }
  /// The end of one of the edges, pushed away from the other one by `far`, and along that by a share of it.
  [[nodiscard]] static GridPoint pushed(const Corner& c, bool upper, double far, double along) {
    const GridPoint &x = upper ? c.b : c.a, &o = upper ? c.a : c.b;
    const double dx = double(o.x - c.v.x), dy = double(o.y - c.v.y), by = far / distance(c.v, o);
    const double side = (cross(c.v, c.a, c.b) > 0) == upper ? 1 : -1;
    return rounded(double(x.x) + by * (along * dx - side * dy), double(x.y) + by * (along * dy + side * dx));
  }
  /// Moves one of the ends away from the other edge.
  bool push_apart(const Corner& c) {
    std::vector<GridPoint> targets;
    for (const bool upper : {false, true}) {
      const GridPoint& x = upper ? c.b : c.a;
      targets.clear();
      for (const double push : kPushes)
        for (const double along : kPushAlongs) targets.push_back(pushed(c, upper, push * limits_.apart, along));
      if (move_to({0, upper ? c.slab + 1 : c.slab, x, x}, targets, false)) return true;
    }
    return false;
  }
  /// The same without what is below and above the edge, which goes another way.
  bool push_alone(const Corner& c, std::int32_t k, std::int32_t l) {
    for (const bool upper : {false, true}) {
      const Panel panel = panels_[std::size_t(upper ? l : k)];
      const GridPoint& x = upper ? c.b : c.a;
      const auto first = std::size_t(panel.first), last = std::size_t(panel.last);
      if ((first == 0 || !stacked(first) || at(first - 1, x) == kNone) &&
          (!stacked(last + 1) || at(last + 1, x) == kNone))
        continue;
      for (const double gap : kGaps)
        for (const double along : kPushAlongs) {
          const double far = gap * limits_.apart;
          Target target{x, 1};
          target.place[0] = pushed(c, upper, far, along);
          target.part[0] = {first, last};
          if (part(x, upper ? c.slab + 1 : c.slab, target, far, 0)) return true;
        }
    }
    return false;
  }
  /// Moves one of the ends onto the other edge: the tip goes, and what follows it may have a wider angle.
  bool close_tip(const Corner& c, std::int32_t k, std::int32_t l) {
    std::vector<Lead> leads;
    for (const bool upper : {false, true}) {
      const GridPoint &x = upper ? c.b : c.a, &o = upper ? c.a : c.b;
      const double length = distance(c.v, o), t = double(dot(c.v, o, x)) / (length * length);
      if (!(t * length > limits_.apart) || !((1 - t) * length > limits_.apart)) continue;
      const GridPoint y = contour_point_between(c.v, o, t);
      if (distance(y, x) > kWidestTip * limits_.apart) continue;
      if (move_to({0, upper ? c.slab + 1 : c.slab, x, x}, {y}, false)) return true;
      const Candidate pair{distance(x, y), c.slab, upper ? y : x, upper ? x : y};
      if (lead(upper ? k : l, y, upper ? c.slab : c.slab + 1, leads, false) &&
          move_to(pair, {contour_point_between(x, y, 0.5), x}, true))
        return true;
      take_back_all(leads);
    }
    return false;
  }

  OutlineWindow room_;                    // vertices outside of it stay
  std::vector<char>* changed_ = nullptr;  // see run
  int round_ = 0;
  int all_in_ = 1;                    // the round in which every corner is tried
  double gain_ = kLeastGain;          // what is asked for
  std::vector<int> touched_;          // of the buckets: the last round in which something moved there
  std::vector<std::int32_t> common_;  // panels, see lead_common
};

}  // namespace slice2mesh::detail
