// SPDX-License-Identifier: MIT
/// @file
/// @brief Corners between contours that are left when they have been opened one by one: a search around each of them.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/harmonize/column_stack.hpp"
#include "slice2mesh/harmonize/corner_trial.hpp"
#include "slice2mesh/harmonize/corners.hpp"
#include "slice2mesh/harmonize/outline_window.hpp"
#include "slice2mesh/regions/slabs.hpp"

namespace slice2mesh::detail {

/// Opens the sharp corners between contours of neighboring slabs (see CornerOpener). What is left has columns in the
/// way that would have to go first, to where nothing gets better by itself. So the surroundings of each such corner are
/// cut out, vertices are added and columns moved there at random, and corners are opened again; what gains is kept, all
/// else forgotten, for some trials. The same input gives the same result.
class CornerSearch {
public:
  using Corner = CornerFinder::Corner;

  /// As ColumnStack.
  CornerSearch(std::vector<Outline>& outlines, const std::vector<Outline>& slices, const std::vector<Slab>& slabs,
               const std::vector<char>& frozen, const ColumnLimits& limits)
      : outlines_(outlines), slices_(slices), slabs_(slabs), frozen_(frozen), limits_(limits) {}

  /// To be called once; as CornerOpener::run. Cost: that, some times where corners are left, and kWork times as many
  /// edges looked at as there are, in windows, and once kWorkForFew.
  std::vector<Corner> run(std::vector<char>& changed, const std::function<void()>& poll) {
    std::vector<Corner> left = open_one_by_one(changed, poll);
    std::size_t edges = 0;
    for (const Outline& outline : outlines_) edges += outline.edges.size();
    work_left_ += kWork * edges;
    bool few = false;
    for (int round = 0, idle = 0; !left.empty(); ++round) {
      if (left.size() <= kFew && !std::exchange(few, true)) work_left_ += kWorkForFew;
      if (work_left_ == 0) break;
      const std::size_t before = left.size();
      found_ = false;
      for (std::size_t pass = 0; pass < kPasses.size() && !left.empty(); ++pass) {
        std::vector<Corner> still;
        for (const Corner& corner : left) {
          poll();
          const std::vector<Corner> there = search_around(corner, pass, round, few ? idle : 0, changed, poll);
          still.insert(still.end(), there.begin(), there.end());
        }
        std::sort(still.begin(), still.end());
        const auto same = [](const Corner& p, const Corner& q) { return !(p < q) && !(q < p); };
        still.erase(std::unique(still.begin(), still.end(), same), still.end());
        left = std::move(still);
      }
      idle = left.size() < before ? 0 : idle + 1;
      if (left.empty() || idle == (few ? kIdleForFew : kIdleRounds) || (!few && round == kRounds)) break;
      // What was found has changed what is in the way, and what contours have in common.
      if (!found_) continue;
      if (few && !spend(edges)) break;
      std::vector<char> changed_now;
      left = open_one_by_one(changed_now, poll);
      for (std::size_t s = 0; s < changed.size(); ++s)
        if (changed_now[s]) changed[s] = 1;
    }
    return left;
  }

private:
  std::vector<Corner> open_one_by_one(std::vector<char>& changed, const std::function<void()>& poll) {
    return CornerOpener(outlines_, slices_, slabs_, frozen_, limits_, poll).run(changed, poll);
  }
  /// Trials for each corner that is left, in a part of the stack around it. Columns that go on above or below it stay,
  /// so that most trials are about what is near.
  struct Pass {
    std::size_t slabs;  // below a corner and above it
    double around;      // of `apart`: how far from a corner columns move
    double clearance;   // of that in the limits: what is crowded makes bad elements; less only at last
    double apart;       // the same of vertices
    std::size_t trials;
  };
  static constexpr std::array<Pass, 6> kPasses{{{8, 2, 1.3, 1, 60},
                                                {8, 3, 1.3, 1, 60},
                                                {16, 2, 1.3, 1, 60},
                                                {128, 2, 1, 1, 120},
                                                {128, 3, 1, 1, 120},
                                                {128, 3, 0.95, 0.7, 360}}};
  static constexpr int kRounds = 8;                   // after the first one
  static constexpr int kIdleRounds = 2;               // in a row that leave as many, and no more follow
  static constexpr std::size_t kFew = 4;              // that are left get more rounds, and more work
  static constexpr int kIdleForFew = 6;               // as kIdleRounds
  static constexpr std::size_t kWorkForFew = 500000;  // as kLeastWork
  static constexpr double kMargin = 3;                // of `apart` and `most`: what is as near to that is seen
  static constexpr std::size_t kWork = 20;  // trials, by the edges in their windows: so many times all edges, ...
  static constexpr std::size_t kLeastWork = 50000;  // ... and so many where there are few
  static constexpr std::size_t kCut = 16;           // edges that are cut out or left for the work of one in a trial

  /// Some slabs of the stack, and what of them is in the window.
  struct Scene {
    std::vector<Outline> outlines, slices;
    std::vector<Slab> slabs;
    std::vector<char> frozen;
  };

  /// True if there is as much left.
  bool spend(std::size_t work) {
    const bool enough = work <= work_left_;
    work_left_ -= std::min(work, work_left_);
    return enough;
  }
  /// Returns what is left there. `idle`: rounds in a row before this one that gained nothing; after two the sum alone
  /// counts (see CornerTrial::Keep).
  [[nodiscard]] std::vector<Corner> search_around(const Corner& corner, std::size_t pass, int round, int idle,
                                                  std::vector<char>& changed, const std::function<void()>& poll) {
    // As far as slabs lie on each other.
    std::size_t first = corner.slab, last = corner.slab + 1;
    while (lies_on_last(slabs_, first) && corner.slab - first < kPasses[pass].slabs) --first;
    while (lies_on_last(slabs_, last + 1) && last - corner.slab <= kPasses[pass].slabs) ++last;
    std::size_t edges = 0;
    for (std::size_t s = first; s <= last; ++s) edges += outlines_[s].edges.size() + slices_[s].edges.size();
    if (!spend(edges / kCut)) return {corner};
    OutlineWindow room{corner.v, corner.v};
    room.add(corner.a);
    room.add(corner.b);
    room = room.grown(kPasses[pass].around * limits_.apart);
    // What may move has all of its edges in the window.
    OutlineWindow window = room;
    Poll listen(poll, 1 << 16);
    for (std::size_t s = first; s <= last; ++s)
      for (const Outline::Edge& e : outlines_[s].edges) {
        listen();
        const GridPoint &a = outlines_[s].vertices[std::size_t(e.a)], &b = outlines_[s].vertices[std::size_t(e.b)];
        if (!room.may_meet(a, b)) continue;
        window.add(a);
        window.add(b);
      }
    const double margin = kMargin * std::max(limits_.apart, limits_.most);
    window = window.grown(margin);
    Scene scene = cut_out(first, last, window, window.grown(margin), poll);

    CornerTrial::Result best =
        CornerTrial(scene.outlines, scene.slices, scene.slabs, scene.frozen, limits_, poll).look(window);
    const auto left = [&] {
      std::vector<Corner> corners = best.corners;
      for (Corner& c : corners) c.slab += first;
      return corners;
    };
    if (best.count_in(room) == 0) return left();  // it is gone already
    using Keep = CornerTrial::Keep;
    const Keep keep = idle == 0 ? Keep::OwnAndSkew : idle == 1 ? Keep::Own : Keep::Nothing;
    edges = 0;
    for (const Outline& outline : scene.outlines) edges += outline.edges.size();
    CornerTrial::Random random(CornerTrial::Random::result_type(std::size_t(round) * kPasses.size() + pass + 1));
    std::vector<char> changed_now, changed_here(scene.outlines.size(), 0);
    // The scene with the vertices that slabs have in common, for every second trial.
    std::vector<Outline> sharing;
    std::vector<char> shared;
    const CornerTrial::Place place{window, room, corner.v, kPasses[pass].clearance, kPasses[pass].apart, keep};
    for (std::size_t trial = 0; trial < kPasses[pass].trials && best.count_in(room) > 0 && spend(edges); ++trial) {
      const bool shares = trial % 2 == 1;
      if (shares && sharing.empty()) {
        sharing = scene.outlines;
        CornerTrial(sharing, scene.slices, scene.slabs, scene.frozen, limits_, poll)
            .share_vertices(place, shared, poll);
      }
      std::vector<Outline> outlines = shares ? sharing : scene.outlines;
      CornerTrial::Result now = CornerTrial(outlines, scene.slices, scene.slabs, scene.frozen, limits_, poll)
                                    .run(place, trial, best.sharpness, random, changed_now, poll);
      if (!CornerTrial::is_better(now.sharpness, best.sharpness, keep)) continue;
      best = std::move(now);
      scene.outlines = std::move(outlines);
      sharing.clear();
      for (std::size_t i = 0; i < changed_here.size(); ++i)
        if (changed_now[i] || (shares && shared[i])) changed_here[i] = 1;
    }
    for (std::size_t i = 0; i < changed_here.size(); ++i) {
      if (!changed_here[i]) continue;
      found_ = true;
      put_back(outlines_[first + i], window, scene.outlines[i], poll);
      changed[first + i] = 1;
    }
    return left();
  }
  /// `seen`: what slices in the window are asked about.
  [[nodiscard]] Scene cut_out(std::size_t first, std::size_t last, const OutlineWindow& window,
                              const OutlineWindow& seen, const std::function<void()>& poll) const {
    Scene scene;
    for (std::size_t s = first; s <= last; ++s) {
      scene.outlines.push_back(cut(outlines_[s], window, true, poll));
      scene.slices.push_back(cut(slices_[s], seen, true, poll));
      scene.slabs.push_back(slabs_[s]);
      scene.frozen.push_back(frozen_[s]);
    }
    // What is next to these is not seen.
    if (lies_on_last(slabs_, first)) scene.frozen.front() = 1;
    if (lies_on_last(slabs_, last + 1)) scene.frozen.back() = 1;
    return scene;
  }

  std::vector<Outline>& outlines_;
  const std::vector<Outline>& slices_;
  const std::vector<Slab>& slabs_;
  const std::vector<char>& frozen_;
  ColumnLimits limits_;
  std::size_t work_left_ = kLeastWork;
  bool found_ = false;  // something to change, in this round
};

}  // namespace slice2mesh::detail
