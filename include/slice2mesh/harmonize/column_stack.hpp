// SPDX-License-Identifier: MIT
/// @file
/// @brief The contours of all slabs as columns and panels that may move while every slab keeps near to its slice.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/arrange/segment_index.hpp"
#include "slice2mesh/core/all_from.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/harmonize/slice_nearness.hpp"
#include "slice2mesh/regions/slabs.hpp"
#include "slice2mesh/regions/thicken.hpp"

namespace slice2mesh::detail {

/// Lengths in pitches.
struct ColumnLimits {
  double near = 0;            ///< columns nearer than this are merged, those of one slab when corners are opened
  double deviation = 0;       ///< no slab gets farther than this from its slice, nor its slice from it ...
  double most = 0;            ///< ... or than this where the slice is farther than that before
  double clearance = 0;       ///< no vertex gets nearer than this to an edge (by a merge: of columns farther apart)
  double longest = HUGE_VAL;  ///< no edge gets longer than this
  /// Columns nearer than this to a vertex or an edge are moved away; 0: none is. When corners are opened: no vertices
  /// get nearer to each other.
  double apart = 0;
  double walls_apart = 0;  ///< straight walls are bent for that only where a column on them is nearer than this
  double separate = 0;     ///< a vertex nearer than this to what the next slab has counts as a corner; 0: none does
};

/// The contours of a stack of slabs while they change. A column is a vertex with the same place in consecutive slabs,
/// a panel is an edge with the same place in consecutive slabs. Columns move, or two of them become one. Topology is
/// kept: nothing lies in the way of what moves, in the slab itself and in those above and below (exact).
class ColumnStack {
public:
  /// `slices`: the regions that the slabs were made from. `frozen` (#S): slabs that stay as they are. `poll` is called
  /// now and then.
  ColumnStack(std::vector<Outline>& outlines, const std::vector<Outline>& slices, const std::vector<Slab>& slabs,
              const std::vector<char>& frozen, const ColumnLimits& limits, const std::function<void()>& poll = {})
      : slices_(slices), slabs_(slabs), frozen_(frozen), limits_(limits), reach_(kLargestDrift * limits.near) {
    sheets_.reserve(outlines.size());
    Poll listen(poll, kPollEvery);
    for (Outline& outline : outlines) sheets_.emplace_back(outline, listen);
    find_places(listen);
    make_panels(listen);
  }

protected:
  /// Calls f(), which changes the contours and marks in `changed` (#S) which; `poll` is called now and then, what it
  /// throws ends the work. To be called once.
  template <class F>
  void work(std::vector<char>& changed, const std::function<void()>& poll, F&& f) {
    Poll listen(poll, kPollEvery);
    listen_ = &listen;
    changed.assign(sheets_.size(), 0);
    f();
    listen_ = nullptr;
    for (std::size_t s = 0; s < sheets_.size(); ++s)
      if (changed[s]) sheets_[s].finish(poll);
    let_go(poll);
  }

  static constexpr std::size_t kPollEvery = 1 << 14;  // edges and vertices looked at
  static constexpr double kOn =
      kAttachSteps * double(kContourStep);    // pitches: an edge of another slab is led through what is this near to it
  static constexpr double kLargestDrift = 2;  // of the distance of close columns: what an edge's end moves in all

  /// The contour of one slab while it changes.
  struct Sheet {
    Sheet(Outline& o, Poll& listen) : outline(o), edges_at(o.vertices.size()), alive(o.edges.size(), 1) {
      for (std::size_t e = 0; e < o.edges.size(); ++e) {
        listen();
        edges_at[std::size_t(o.edges[e].a)].push_back(std::int32_t(e));
        edges_at[std::size_t(o.edges[e].b)].push_back(std::int32_t(e));
      }
    }
    Outline& outline;
    std::vector<std::vector<std::int32_t>> edges_at;  // #V
    std::vector<char> alive;                          // #E
    std::vector<std::int32_t> below;                  // #V: the vertex in the same place of the slab below, at first
    std::unique_ptr<SliceNearness> slice;

    [[nodiscard]] const GridPoint& point(std::int32_t v) const { return outline.vertices[std::size_t(v)]; }
    [[nodiscard]] std::int32_t other_end(std::int32_t e, std::int32_t v) const {
      const Outline::Edge& edge = outline.edges[std::size_t(e)];
      return edge.a == v ? edge.b : edge.a;
    }
    [[nodiscard]] std::int32_t edge_between(std::int32_t v, std::int32_t w) const {
      for (const std::int32_t e : edges_at[std::size_t(v)])
        if (other_end(e, v) == w) return e;
      return kNone;
    }
    void finish(const std::function<void()>& poll) {
      std::vector<Outline::Edge> edges;
      for (std::size_t e = 0; e < outline.edges.size(); ++e)
        if (alive[e]) edges.push_back(outline.edges[e]);
      outline.edges = std::move(edges);
      normalize(outline, poll);
    }
  };

  /// Two vertices that are close: v of a slab, w of the same one (an edge joins them) or of the one above.
  struct Candidate {
    double distance;
    std::size_t slab;
    GridPoint v, w;
  };

  /// What happens in one slab: the vertices that move (kNone: not there), and how far the ends of edges there have
  /// come.
  struct Step {
    std::size_t slab;
    std::int32_t v, w;
    double drift_v, drift_w;
  };

  [[nodiscard]] bool stacked(std::size_t s) const {  // on the slab below
    return lies_on_last(slabs_, s);
  }

  /// A vertex of one slab, and how far the ends of edges there have come.
  struct Standing {
    std::size_t slab;
    std::int32_t vertex;
    double drift;
  };
  /// What stands in one place: vertices, by slab, and the panels that end there.
  struct Place {
    std::vector<Standing> standing;
    std::vector<std::int32_t> panels;
  };
  /// An edge with the same place in consecutive slabs. What it is asked about is the same in all of them, and their
  /// columns move as a whole: so does the panel.
  struct Panel {
    GridPoint a, b;
    std::int32_t first, last;  // slabs
  };
  /// A panel that ends in the column in question, from there to x. `alone`: in one of its slabs the pair of columns
  /// that is to be merged is not there as a whole.
  struct Moving {
    std::int32_t panel;
    GridPoint p, x;
    bool alone;
  };
  /// Does another panel stand in slabs of a panel, or in slabs next to one of them? Both may be.
  struct Beneath {
    bool same_slab, next_slab;
  };

  /// Gives the many small lists back while it listens; nothing is asked about them any more.
  void let_go(const std::function<void()>& poll) {
    Poll listen(poll, kPollEvery);
    for (auto it = places_.begin(); it != places_.end(); it = places_.erase(it)) listen();
    for (Sheet& sheet : sheets_)
      for (std::vector<std::int32_t>& edges : sheet.edges_at) {
        listen();
        std::vector<std::int32_t>().swap(edges);
      }
  }

  void find_places(Poll& listen) {
    std::size_t most = 0;
    for (const Sheet& sheet : sheets_) most = std::max(most, sheet.outline.vertices.size());
    places_.reserve(8 * most);
    for (std::size_t s = 0; s < sheets_.size(); ++s) {
      Sheet& sheet = sheets_[s];
      sheet.below.assign(sheet.outline.vertices.size(), kNone);
      for (std::size_t v = 0; v < sheet.below.size(); ++v) {
        listen();
        std::vector<Standing>& standing = places_[sheet.outline.vertices[v]].standing;
        if (stacked(s) && !standing.empty() && standing.back().slab == s - 1) sheet.below[v] = standing.back().vertex;
        standing.push_back({s, std::int32_t(v), 0});
      }
    }
  }
  void make_panels(Poll& listen) {
    std::vector<std::int32_t> below, here;  // the panel of each edge
    for (std::size_t s = 0; s < sheets_.size(); ++s) {
      const Sheet& sheet = sheets_[s];
      std::swap(below, here);
      here.assign(sheet.outline.edges.size(), kNone);
      for (std::size_t e = 0; e < sheet.outline.edges.size(); ++e) {
        listen();
        const GridPoint &a = sheet.point(sheet.outline.edges[e].a), &b = sheet.point(sheet.outline.edges[e].b);
        std::int32_t& panel = here[e];
        if (stacked(s)) {  // goes on from below, with the same direction
          const std::int32_t v = sheet.below[std::size_t(sheet.outline.edges[e].a)],
                             w = v != kNone ? sheet.below[std::size_t(sheet.outline.edges[e].b)] : kNone;
          const std::int32_t f = w != kNone ? sheets_[s - 1].edge_between(v, w) : kNone;
          if (f != kNone && sheets_[s - 1].outline.edges[std::size_t(f)].a == v) panel = below[std::size_t(f)];
        }
        if (panel != kNone) {
          panels_[std::size_t(panel)].last = std::int32_t(s);
          continue;
        }
        panel = std::int32_t(panels_.size());
        panels_.push_back({a, b, std::int32_t(s), std::int32_t(s)});
      }
    }
    GridPoint low, high;
    if (!panels_.empty()) low = high = panels_.front().a;
    for (const Panel& panel : panels_)
      for (const GridPoint& p : {panel.a, panel.b}) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y)};
      }
    // Contours are lines in an area, so most cells are empty: they can be small.
    constexpr std::size_t kCells = 4;  // per panel
    buckets_ = Buckets(low, high, kCells * panels_.size());
    bucket_.assign(buckets_.size(), {kNone, 0});
    found_.assign(panels_.size(), 0);
    // What stands together is looked at together.
    std::stable_sort(panels_.begin(), panels_.end(), listening(listen, [&](const Panel& p, const Panel& q) {
                       return buckets_.of(p.a) < buckets_.of(q.a);
                     }));
    for (std::size_t k = 0; k < panels_.size(); ++k) {
      listen();
      for (const GridPoint& p : {panels_[k].a, panels_[k].b}) places_[p].panels.push_back(std::int32_t(k));
      put_panel(std::int32_t(k));
    }
    // Entries of a bucket one after the other.
    std::vector<Entry> sorted;
    sorted.reserve(entries_.size());
    for (Bucket& bucket : bucket_) {
      std::int32_t i = bucket.first;
      if (i != kNone) bucket.first = std::int32_t(sorted.size());
      for (; i != kNone; i = entries_[std::size_t(i)].next) {
        listen();
        sorted.push_back(entries_[std::size_t(i)]);
        if (sorted.back().next != kNone) sorted.back().next = std::int32_t(sorted.size());
      }
    }
    entries_ = std::move(sorted);
  }
  /// Puts a panel where it stands now. Where it stood before it is still found, and looked at in vain.
  void put_panel(std::int32_t k) {
    const Panel& panel = panels_[std::size_t(k)];
    buckets_.for_each_on(panel.a, panel.b, 0, [&](std::size_t bucket) {
      looked();
      std::int32_t& first = bucket_[bucket].first;
      for (std::int32_t i = first; i != kNone; i = entries_[std::size_t(i)].next)
        if (entries_[std::size_t(i)].panel == k) return;
      entries_.push_back({k, first, panel.first, panel.last});
      first = std::int32_t(entries_.size()) - 1;
    });
  }
  /// The vertex of a slab at a place, or kNone.
  [[nodiscard]] std::int32_t at(std::size_t slab, const GridPoint& p) const {
    const auto it = places_.find(p);
    return it == places_.end() ? kNone : at(slab, it->second.standing);
  }
  [[nodiscard]] static std::int32_t at(std::size_t slab, const std::vector<Standing>& standing) {
    const auto it = first_from(slab, standing);
    return it != standing.end() && it->slab == slab ? it->vertex : kNone;
  }
  [[nodiscard]] const Place& place_of(const GridPoint& p) const {
    const auto it = places_.find(p);
    return it == places_.end() ? nowhere_ : it->second;
  }
  [[nodiscard]] static std::vector<Standing>::const_iterator first_from(std::size_t slab,
                                                                        const std::vector<Standing>& standing) {
    return std::lower_bound(standing.begin(), standing.end(), slab,
                            [](const Standing& one, std::size_t s) { return one.slab < s; });
  }

  /// Tells the listener.
  void looked(std::size_t count = 1) const {
    if (listen_ != nullptr) (*listen_)(count);
  }

  /// Slabs of a column that is to be parted.
  struct Part {
    std::size_t first = 0, last = SIZE_MAX;
  };
  [[nodiscard]] bool is_in_part(std::size_t slab) const { return part_.first <= slab && slab <= part_.last; }

  /// Finds the slabs that have v, or w, or both: from `slab` up and down, within `part_`. False if `slab` has neither.
  bool find_steps(std::size_t slab, const Place& v, const Place& w) {
    steps_.clear();
    const std::vector<Standing>&at_v = v.standing, &at_w = w.standing;
    const auto from_v = first_from(slab, at_v), from_w = first_from(slab, at_w);
    const auto add = [&](std::size_t s, const Standing* here_v, const Standing* here_w) {
      if ((here_v == nullptr && here_w == nullptr) || !is_in_part(s)) return false;
      steps_.push_back({s, here_v != nullptr ? here_v->vertex : kNone, here_w != nullptr ? here_w->vertex : kNone,
                        here_v != nullptr ? here_v->drift : 0, here_w != nullptr ? here_w->drift : 0});
      return true;
    };
    const auto up = [&](std::size_t s, auto& i, auto& j) {
      const bool has_v = i != at_v.end() && i->slab == s, has_w = j != at_w.end() && j->slab == s;
      const bool added = add(s, has_v ? &*i : nullptr, has_w ? &*j : nullptr);
      if (has_v) ++i;
      if (has_w) ++j;
      return added;
    };
    auto i = from_v, j = from_w;
    if (!up(slab, i, j)) return false;
    auto k = from_v, l = from_w;  // those above are next
    for (std::size_t s = slab; stacked(s); --s) {
      const bool has_v = k != at_v.begin() && std::prev(k)->slab == s - 1,
                 has_w = l != at_w.begin() && std::prev(l)->slab == s - 1;
      if (has_v) --k;
      if (has_w) --l;
      if (!add(s - 1, has_v ? &*k : nullptr, has_w ? &*l : nullptr)) break;
    }
    for (std::size_t s = slab + 1; stacked(s) && up(s, i, j); ++s) {
    }
    return true;
  }
  /// Finds the steps of the column in a place, which stands in `slab` and others. False if there is none, or it may not
  /// move.
  bool find_column(std::size_t slab, const Place& place) {
    if (!find_steps(slab, place, nowhere_)) return false;
    const bool may_be_crowded = place.panels.size() > kMostEdges;
    return std::none_of(steps_.begin(), steps_.end(), [&](const Step& step) {
      return frozen_[step.slab] != 0 ||
             (may_be_crowded && sheets_[step.slab].edges_at[std::size_t(step.v)].size() > kMostEdges);
    });
  }
  /// Finds the panels at the column, or pair of columns, that `find_steps` was called for, and the ones between them.
  void find_moving(const GridPoint& v, const Place& at_v, const GridPoint& w, const Place& at_w) {
    moving_.clear();
    between_.clear();
    near_.clear();
    doubtful_ = 0;
    std::size_t lowest = steps_.front().slab;  // of the slabs, which follow each other
    for (const Step& step : steps_) lowest = std::min(lowest, step.slab);
    lone_.assign(steps_.size() + 1, 0);
    for (const Step& step : steps_) lone_[step.slab - lowest + 1] = step.v == kNone || step.w == kNone ? 1 : 0;
    for (std::size_t i = 1; i < lone_.size(); ++i) lone_[i] += lone_[i - 1];
    lowest_ = std::int32_t(lowest);
    const std::int32_t first = lowest_, last = first + std::int32_t(steps_.size()) - 1;
    const auto add = [&](const GridPoint& p, const Place& place, const GridPoint& other) {
      for (const std::int32_t k : place.panels) {
        looked();
        const Panel& panel = panels_[std::size_t(k)];
        if (panel.last < first || panel.first > last) continue;
        const GridPoint& x = panel.a == p ? panel.b : panel.a;
        if (x != other) {
          moving_.push_back(
              {k, p, x, lone_[std::size_t(panel.last - first) + 1] > lone_[std::size_t(panel.first - first)]});
        } else if (p == v) {
          between_.push_back(k);
        }
      }
    };
    add(v, at_v, w);
    add(w, at_w, v);
  }
  /// Finds the steps and the panels of a pair of columns, or of one (v = w). False if there is none, or they may not
  /// become one.
  [[nodiscard]] bool find_pair(const Candidate& c) {
    const Place &at_v = place_of(c.v), &at_w = c.v != c.w ? place_of(c.w) : nowhere_;
    if (!find_steps(c.slab, at_v, at_w)) return false;
    std::int32_t both = 0;
    for (const Step& step : steps_) {
      if (frozen_[step.slab]) return false;
      if (step.v != kNone && step.w != kNone) ++both;
    }
    find_moving(c.v, at_v, c.w, at_w);
    // Where both are there, an edge joins them.
    for (const std::int32_t k : between_) both -= panels_[std::size_t(k)].last - panels_[std::size_t(k)].first + 1;
    if (both != 0) return false;
    if (c.v == c.w) return true;
    // What they have as a common neighbor would lose its triangle.
    for (const Moving& m : moving_)
      for (const Moving& n : moving_)
        if (m.p != n.p && m.x == n.x && beneath(panels_[std::size_t(m.panel)], panels_[std::size_t(n.panel)]).same_slab)
          return false;
    return true;
  }
  /// Finds the panels that may matter where the column moves by up to `reach_near_`: for the
  /// distances that `apart` and `clearance` limit, and for what the slice is near to.
  void find_all_near() {
    // Parts of a slice count that are up to half a piece farther from the old edges than `most`, and the edges within
    // `most` of them.
    find_near(std::max(std::max(limits_.apart, clearance_) + reach_near_, (2 + kResolution) * limits_.most));
  }
  /// Finds the panels that are nearer than `reach` to an edge of the column (and others).
  void find_near(double reach) {
    near_.clear();
    ++search_;
    const auto pad = std::int64_t(std::ceil(reach)) + kContourStep;  // places are rounded to steps
    const std::int32_t first = lowest_ - 1, last = lowest_ + std::int32_t(steps_.size());  // and the slabs next to them
    const auto box_of = [&](const GridPoint& p, const GridPoint& x) {
      return std::array<GridPoint, 2>{GridPoint{std::min(p.x, x.x) - pad, std::min(p.y, x.y) - pad},
                                      GridPoint{std::max(p.x, x.x) + pad, std::max(p.y, x.y) + pad}};
    };
    boxes_.clear();
    for (const Moving& m : moving_) boxes_.push_back(box_of(m.p, m.x));
    for (const std::int32_t k : between_)
      boxes_.push_back(box_of(panels_[std::size_t(k)].a, panels_[std::size_t(k)].b));
    const auto search = [&](const GridPoint& p, const GridPoint& x) {
      buckets_.for_each_on(p, x, pad, [&](std::size_t bucket) {
        if (bucket_[bucket].found == search_) return;
        bucket_[bucket].found = search_;
        std::size_t count = 1;
        for (std::int32_t i = bucket_[bucket].first; i != kNone; i = entries_[std::size_t(i)].next) {
          ++count;
          const Entry& entry = entries_[std::size_t(i)];
          if (entry.last < first || entry.first > last) continue;
          if (found_[std::size_t(entry.panel)] >= search_) continue;
          found_[std::size_t(entry.panel)] = search_;
          const Panel& panel = panels_[std::size_t(entry.panel)];
          const auto [low_x, high_x] = std::minmax(panel.a.x, panel.b.x);
          const auto [low_y, high_y] = std::minmax(panel.a.y, panel.b.y);
          for (const auto& [low, high] : boxes_) {
            if (high_x < low.x || low_x > high.x || high_y < low.y || low_y > high.y) continue;
            near_.push_back(panel);
            break;
          }
        }
        looked(count);
      });
    };
    for (const Moving& m : moving_) search(m.p, m.x);
    for (const std::int32_t k : between_) search(panels_[std::size_t(k)].a, panels_[std::size_t(k)].b);
  }
  [[nodiscard]] Beneath beneath(const Panel& panel, const Panel& other) const {
    const auto meets = [&](std::int32_t first, std::int32_t last) {
      return std::max(first, other.first) <= std::min(last, other.last);
    };
    const bool below = stacked(std::size_t(panel.first)), above = stacked(std::size_t(panel.last) + 1);
    return {meets(panel.first, panel.last), meets(panel.first - (below ? 1 : 0), panel.last - 1) ||
                                                meets(panel.first + 1, panel.last + (above ? 1 : 0))};
  }

  /// The largest distance by which a contour moves away from itself, about.
  [[nodiscard]] double change(const GridPoint& target) const {
    double worst = 0;
    for (const Moving& m : moving_) {
      worst = std::max(worst, segment_distance(m.p, m.x, target));
      // Where both are there, the target lies on the edge between them.
      if (m.alone) worst = std::max(worst, segment_distance(target, m.x, m.p));
    }
    return worst;
  }

  /// The index of a panel that a copy was made of.
  [[nodiscard]] std::int32_t panel_of(const Panel& copy) const {
    for (const std::int32_t k : place_of(copy.a).panels) {
      const Panel& panel = panels_[std::size_t(k)];
      if (panel.a == copy.a && panel.b == copy.b && panel.first == copy.first) return k;
    }
    return kNone;
  }
  /// Gives a panel a vertex at y, which lies on it, in all of its slabs. False if one of them has a vertex there, or
  /// may not change.
  bool lead_through(std::int32_t k, const GridPoint& y, std::vector<char>& changed) {
    const Panel old = panels_[std::size_t(k)];
    Place& there = places_[y];  // the references stay valid: none is taken out here
    for (std::int32_t s = old.first; s <= old.last; ++s)
      if (frozen_[std::size_t(s)] || at(std::size_t(s), there.standing) != kNone) return false;
    Place& at_b = places_[old.b];
    const auto added = std::int32_t(panels_.size());
    for (std::int32_t s = old.first; s <= old.last; ++s) {
      looked();
      const auto slab = std::size_t(s);
      Sheet& sheet = sheets_[slab];
      const std::int32_t a = at(slab, old.a), b = at(slab, at_b.standing), e = sheet.edge_between(a, b);
      const auto v = std::int32_t(sheet.edges_at.size()), f = std::int32_t(sheet.alive.size());
      sheet.outline.vertices.push_back(y);
      sheet.outline.edges.push_back(sheet.outline.edges[std::size_t(e)]);
      sheet.alive.push_back(1);
      for (const auto& [edge, end] : {std::pair{e, b}, std::pair{f, a}}) {
        Outline::Edge& part = sheet.outline.edges[std::size_t(edge)];
        (part.a == end ? part.a : part.b) = v;
      }
      sheet.edges_at.push_back({e, f});
      std::vector<std::int32_t>& at_end = sheet.edges_at[std::size_t(b)];
      *std::find(at_end.begin(), at_end.end(), e) = f;
      there.standing.insert(first_from(slab, there.standing), {slab, v, 0});
      changed[slab] = 1;
    }
    panels_[std::size_t(k)].b = y;
    panels_.push_back({y, old.b, old.first, old.last});
    found_.push_back(0);
    *std::find(at_b.panels.begin(), at_b.panels.end(), k) = added;
    there.panels.push_back(k);
    there.panels.push_back(added);
    put_panel(added);
    return true;
  }

  /// Parts the panels that end in p and stand in `slab` and in the one above: what was added are the upper parts.
  void part_panels(const GridPoint& p, std::size_t slab) {
    const std::size_t count = panels_.size();
    for (const std::int32_t k : places_[p].panels) {
      looked();
      Panel& panel = panels_[std::size_t(k)];
      if (std::size_t(panel.first) > slab || std::size_t(panel.last) <= slab) continue;
      Panel upper = panel;
      upper.first = std::int32_t(slab) + 1;
      panel.last = std::int32_t(slab);
      panels_.push_back(upper);
      found_.push_back(0);
    }
    for (std::size_t k = count; k < panels_.size(); ++k) {
      for (const GridPoint& end : {panels_[k].a, panels_[k].b}) places_[end].panels.push_back(std::int32_t(k));
      put_panel(std::int32_t(k));
    }
  }
  /// Takes that back; `count`: how many panels there were before. What was done since has been taken back already.
  void join_panels(std::size_t count) {
    while (panels_.size() > count) {
      looked();
      const Panel& upper = panels_.back();
      for (const std::int32_t below : place_of(upper.a).panels) {
        Panel& panel = panels_[std::size_t(below)];
        if (panel.a == upper.a && panel.b == upper.b && panel.last == upper.first - 1) panel.last = upper.last;
      }
      for (const GridPoint& end : {upper.a, upper.b}) {
        std::vector<std::int32_t>& panels = places_[end].panels;
        panels.erase(std::find(panels.begin(), panels.end(), std::int32_t(panels_.size()) - 1));
      }
      remove_last_panel();
    }
  }
  /// Takes the panel that was added last, and has not moved since, out of all but its places.
  void remove_last_panel() {
    const auto k = std::int32_t(panels_.size()) - 1;
    const Panel& panel = panels_.back();
    std::size_t count = 0;
    buckets_.for_each_on(panel.a, panel.b, 0, [&](std::size_t bucket) {
      looked();
      std::int32_t& first = bucket_[bucket].first;
      if (first == kNone || entries_[std::size_t(first)].panel != k) return;
      first = entries_[std::size_t(first)].next;
      ++count;
    });
    entries_.resize(entries_.size() - count);
    panels_.pop_back();
    found_.pop_back();
  }

  /// Takes out the vertex y that a panel was led through last, in `slab` among others. What was done since has been
  /// taken back already.
  void take_back(const GridPoint& y, std::size_t slab) {
    Place& there = places_[y];
    std::int32_t first = kNone;  // the panel that was there before; the one that was added is the last one
    for (const std::int32_t k : there.panels) {
      const Panel& panel = panels_[std::size_t(k)];
      if (panel.b == y && std::size_t(panel.first) <= slab && slab <= std::size_t(panel.last)) first = k;
    }
    Panel& panel = panels_[std::size_t(first)];
    const GridPoint end = panels_.back().b;
    Place& at_end = places_[end];
    for (std::int32_t s = panel.last; s >= panel.first; --s) {  // what is taken out last is at the end of its list
      looked();
      const auto of_slab = std::size_t(s);
      Sheet& sheet = sheets_[of_slab];
      const std::int32_t v = at(of_slab, there.standing), w = at(of_slab, at_end.standing);
      const std::int32_t gone = sheet.edge_between(v, w);
      const std::vector<std::int32_t>& at_v = sheet.edges_at[std::size_t(v)];
      const std::int32_t stays = at_v.front() == gone ? at_v.back() : at_v.front();
      Outline::Edge& edge = sheet.outline.edges[std::size_t(stays)];
      (edge.a == v ? edge.a : edge.b) = w;
      std::vector<std::int32_t>& at_w = sheet.edges_at[std::size_t(w)];
      *std::find(at_w.begin(), at_w.end(), gone) = stays;
      there.standing.erase(first_from(of_slab, there.standing));
      // Both were added last.
      sheet.outline.vertices.pop_back();
      sheet.outline.edges.pop_back();
      sheet.edges_at.pop_back();
      sheet.alive.pop_back();
    }
    const auto second = std::int32_t(panels_.size()) - 1;
    panel.b = end;
    *std::find(at_end.panels.begin(), at_end.panels.end(), second) = first;
    for (const std::int32_t k : {first, second})
      there.panels.erase(std::find(there.panels.begin(), there.panels.end(), k));
    remove_last_panel();
    if (there.standing.empty() && there.panels.empty()) places_.erase(y);
  }

  [[nodiscard]] bool possible(const Candidate& c, const GridPoint& target) {
    // Where the tolerance is wider than the part, places may be off the grid.
    if (!is_on_grid(target)) return false;
    const double from_v = distance(c.v, target), from_w = distance(c.w, target);
    for (const Step& step : steps_) {
      if (step.v != kNone && step.drift_v + from_v > reach_) return false;
      if (step.w != kNone && step.drift_w + from_w > reach_) return false;
    }
    if (std::any_of(moving_.begin(), moving_.end(), [&](const Moving& m) { return folds(m, target); })) return false;
    const Place& there = place_of(target);
    if (!there.standing.empty())
      for (const Step& step : steps_) {
        const std::int32_t u = at(step.slab, there.standing);
        if (u != kNone && u != step.v && u != step.w) return false;
      }
    if (near_.empty()) find_all_near();
    for (const Moving& m : moving_)
      if (!way_is_clear(c, m, target)) return false;
    return all_from(doubtful_, steps_.size(), [&](std::size_t k) { return stays_near_slice(c, steps_[k], target); });
  }

  /// Does a vertex get too near to an edge, or leave one of another slab that it lies on? On: the overlay of the plane
  /// leads the edge through the vertex.
  [[nodiscard]] bool gets_close(double before, double now, const Beneath& slabs) const {
    if (!(now < clearance_)) return false;
    return (slabs.same_slab && now < before) || (slabs.next_slab && now > kOn && (now < before || before <= kOn));
  }

  /// Does a panel get too long, or fold?
  [[nodiscard]] bool folds(const Moving& m, const GridPoint& target) const {
    const GridPoint &p = m.p, &q = m.x;
    if (p == target) return false;
    return distance(target, q) > std::max(limits_.longest, distance(p, q)) ||
           (orientation(p, target, q) == 0 && dot(q, p, target) <= 0);
  }
  /// Is nothing in the way of a panel, and no vertex too near to an edge afterwards? Needs `find_all_near`.
  [[nodiscard]] bool way_is_clear(const Candidate& c, const Moving& m, const GridPoint& target) {
    const GridPoint &p = m.p, &q = m.x;
    if (p == target) return true;
    const int turn = orientation(p, target, q);
    const auto clear = std::int64_t(std::ceil(clearance_)) + 1;
    const GridPoint low{std::min({p.x, target.x, q.x}) - clear, std::min({p.y, target.y, q.y}) - clear};
    const GridPoint high{std::max({p.x, target.x, q.x}) + clear, std::max({p.y, target.y, q.y}) + clear};
    looked(near_.size());
    return std::none_of(near_.begin(), near_.end(), [&](const Panel& other) {
      const GridPoint &a = other.a, &b = other.b;
      if (std::max(a.x, b.x) < low.x || std::min(a.x, b.x) > high.x) return false;
      if (std::max(a.y, b.y) < low.y || std::min(a.y, b.y) > high.y) return false;
      const Beneath slabs = beneath(panels_[std::size_t(m.panel)], other);
      if (!slabs.same_slab && !slabs.next_slab) return false;
      const auto blocks = [&](const GridPoint& y) {
        if (y.x < low.x || y.x > high.x || y.y < low.y || y.y > high.y) return false;
        if (y == p || y == q || y == target || y == c.v || y == c.w) return false;
        const int i = orientation(p, target, y), j = orientation(target, q, y), k = orientation(q, p, y);
        const double before = segment_distance(y, p, q);
        // Along its own line an edge only gains or loses the way.
        const bool swept = turn == 0 ? segments_meet(p, target, y, y) : i * turn >= 0 && j * turn >= 0 && k * turn >= 0;
        if (!swept && !gets_close(before, segment_distance(y, target, q), slabs)) return false;
        if (before <= kOn && !slabs.same_slab && left_.panel == kNone) left_ = {m.panel, y};
        return true;
      };
      if (blocks(a) || blocks(b)) return true;
      if (a == p || b == p || a == target || b == target) return false;
      if (a == c.v || a == c.w || b == c.v || b == c.w) return false;
      const double now = segment_distance(target, a, b);
      const double before = segment_distance(p, a, b);
      if (gets_close(before, now, slabs)) {
        if (before <= kOn && !slabs.same_slab && left_.panel == kNone) left_ = {panel_of(other), p};
        return true;
      }
      // An edge of another slab that is led through the target ends the way there.
      if (!slabs.same_slab && now <= kOn) return false;
      return segments_meet(p, target, a, b) && (orientation(p, target, a) != 0 || orientation(p, target, b) != 0);
    });
  }

  const std::unique_ptr<SliceNearness>& slice_of(std::size_t slab) {
    std::unique_ptr<SliceNearness>& slice = sheets_[slab].slice;
    if (!slice) slice = std::make_unique<SliceNearness>(slices_[slab], listen_);
    return slice;
  }
  /// Is the slab still near to its slice, and its slice to the slab?
  [[nodiscard]] bool stays_near_slice(const Candidate& c, const Step& step, const GridPoint& target) {
    const std::unique_ptr<SliceNearness>& slice = slice_of(step.slab);
    const NearnessLimits limits{limits_.deviation, limits_.most, kResolution};
    old_.clear();
    now_.clear();
    const auto slab = std::int32_t(step.slab);
    const auto is_there = [&](const Panel& panel) { return panel.first <= slab && slab <= panel.last; };
    for (const Moving& m : moving_) {
      if (!is_there(panels_[std::size_t(m.panel)])) continue;
      old_.emplace_back(m.p, m.x);
      now_.emplace_back(target, m.x);
    }
    for (const std::int32_t k : between_) {
      if (!is_there(panels_[std::size_t(k)])) continue;
      old_.emplace_back(c.v, c.w);
      old_.emplace_back(c.w, c.v);
    }
    for (const auto& edge : now_)
      if (!slice->is_near(edge, limits, listen_)) return false;
    // Other edges of the contour that may be nearest to a part of the slice.
    for (const Panel& other : near_)
      if (is_there(other) && other.a != c.v && other.b != c.v && other.a != c.w && other.b != c.w)
        now_.emplace_back(other.a, other.b);
    return slice->stays_covered(old_, now_, limits, listen_);
  }

  void apply(const Candidate& c, const GridPoint& target) {
    const double from_v = distance(c.v, target), from_w = distance(c.w, target);
    const auto erase = [](const Step& step, Place& place) {
      place.standing.erase(first_from(step.slab, place.standing));
    };
    const auto erase_panel = [](std::int32_t k, Place& place) {
      place.panels.erase(std::find(place.panels.begin(), place.panels.end(), k));
    };
    Place& there = places_[target];  // the references stay valid: none is taken out here
    Place &at_v = places_[c.v], &at_w = places_[c.w];
    for (const Step& step : steps_) {
      Sheet& sheet = sheets_[step.slab];
      double drift = 0;
      if (step.v != kNone) {
        drift = std::max(drift, step.drift_v + from_v);
        erase(step, at_v);
      }
      if (step.w != kNone) {
        drift = std::max(drift, step.drift_w + from_w);
        erase(step, at_w);
      }
      const std::int32_t stays = step.w != kNone ? step.w : step.v;
      if (step.v != kNone && step.w != kNone) {
        const std::int32_t gone = sheet.edge_between(step.v, step.w);
        sheet.alive[std::size_t(gone)] = 0;
        auto& list = sheet.edges_at[std::size_t(step.w)];
        list.erase(std::find(list.begin(), list.end(), gone));
        for (const std::int32_t e : sheet.edges_at[std::size_t(step.v)]) {
          if (e == gone) continue;
          Outline::Edge& edge = sheet.outline.edges[std::size_t(e)];
          (edge.a == step.v ? edge.a : edge.b) = step.w;
          list.push_back(e);
        }
        sheet.edges_at[std::size_t(step.v)].clear();
      }
      sheet.outline.vertices[std::size_t(stays)] = target;
      there.standing.insert(first_from(step.slab, there.standing), {step.slab, stays, drift});
    }
    for (const std::int32_t pair : between_) {
      found_[std::size_t(pair)] = UINT32_MAX;  // never found again
      erase_panel(pair, at_v);
      erase_panel(pair, at_w);
    }
    for (const Moving& m : moving_) {
      if (m.p == target) continue;
      erase_panel(m.panel, m.p == c.v ? at_v : at_w);
      there.panels.push_back(m.panel);
      Panel& panel = panels_[std::size_t(m.panel)];
      (panel.a == m.p ? panel.a : panel.b) = target;
      put_panel(m.panel);
    }
  }

  static constexpr std::size_t kMostEdges = 8;    // where more contours meet in a point, it stays
  static constexpr double kResolution = 0.03125;  // of the limit: pieces of contours that are not split further

  const std::vector<Outline>& slices_;
  const std::vector<Slab>& slabs_;
  const std::vector<char>& frozen_;
  ColumnLimits limits_;
  double reach_;
  double clearance_ = 0;  // of the merge in question
  std::vector<Sheet> sheets_;
  std::unordered_map<GridPoint, Place, GridHash> places_;
  const Place nowhere_{};
  std::vector<Panel> panels_;
  std::vector<std::uint32_t> found_;  // of the panels: by which search
  struct Entry {
    std::int32_t panel, next, first, last;  // slabs of the panel
  };
  Buckets buckets_{GridPoint{}, GridPoint{}, 1};  // of panels
  struct Bucket {
    std::int32_t first;   // its first entry, or kNone
    std::uint32_t found;  // by which search
  };
  std::vector<Bucket> bucket_;
  std::vector<Entry> entries_;
  std::vector<std::array<GridPoint, 2>> boxes_;  // around the edges in question
  std::uint32_t search_ = 0;                     // the last one
  std::vector<Moving> moving_;                   // see find_moving
  std::vector<std::int32_t> between_;            // panels between the two columns in question
  std::int32_t lowest_ = 0;                      // slab of the column, or pair of columns
  std::vector<std::int32_t> lone_;               // how many steps below have one of both columns only
  std::vector<Panel> near_;                      // see find_near
  double reach_near_ = 0;                        // how far the column in question may move
  std::size_t doubtful_ = 0;                     // the step that failed last
  /// A panel and what lies on it: the last way was blocked as it would not any more. None: by something else.
  struct Left {
    std::int32_t panel = kNone;
    GridPoint y;
  };
  Left left_;
  std::vector<Step> steps_;
  Part part_;
  std::vector<std::pair<GridPoint, GridPoint>> old_, now_;
  Poll* listen_ = nullptr;  // while it runs
};

}  // namespace slice2mesh::detail
