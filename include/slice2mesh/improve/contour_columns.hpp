// SPDX-License-Identifier: MIT
/// @file
/// @brief Contour vertices of a filled stack as columns, and where a column may go.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/arrange/segment_index.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/harmonize/harmonize.hpp"
#include "slice2mesh/harmonize/slice_nearness.hpp"
#include "slice2mesh/lift/lift.hpp"
#include "slice2mesh/triangulate/plane_stack.hpp"

namespace slice2mesh::detail {

/// The vertices of the planes that have to move together for walls to stay vertical: a contour vertex of a slab stands
/// on both of its planes, and where contours of neighboring slabs have it in common, on those of the next slab too.
///
/// Says where a column may go: contours keep their distance from their slices, and in each plane no contour meets
/// another one that it did not meet before, nor passes over a vertex of it (exact). What lies between contours, the
/// tets, is for the caller to look at.
class ContourColumns {
public:
  /// A vertex that splits an edge between this column and another one.
  struct Split {
    std::int32_t vertex;  ///< of a plane
    std::int32_t far;     ///< vertex of that plane at the other end of the edge
    friend bool operator<(const Split& a, const Split& b) {
      return a.vertex != b.vertex ? a.vertex < b.vertex : a.far < b.far;
    }
    friend bool operator==(const Split& a, const Split& b) { return a.vertex == b.vertex && a.far == b.far; }
  };
  /// A contour vertex.
  struct Site {
    std::int32_t slab;
    std::int32_t vertex;  ///< of the outline of the slab
  };
  struct Column {
    std::vector<std::int32_t> vertices;  ///< of planes; all in one place
    std::vector<Split> splits;           ///< sorted
    std::vector<Site> sites;
    bool movable = true;
  };

  /// Vertices of all planes are counted through, those of plane k from `first[k]` on. `points` (#V) and `gone` (#V: the
  /// vertex that a vertex was merged into, or kNone) are looked at whenever a question is asked. `slices` (#S) are the
  /// regions that the contours were made from; `contours` and `stack` have to outlive this.
  ContourColumns(const Contours& contours, const std::vector<Outline>& slices, const PlaneStack& stack,
                 const std::vector<std::int32_t>& first, const std::vector<GridPoint>& points,
                 const std::vector<std::int32_t>& gone, const std::function<void()>& poll)
      : slices_(slices), stack_(stack), first_(first), points_(points), gone_(gone), listen_(poll, kPollEvery),
        eps_(contours.tolerance / contours.grid.pitch), outlines_(contours.outlines),
        touched_(contours.slabs.size(), 0), slab_(contours.slabs.size()) {
    std::vector<std::array<std::int32_t, 2>> planes;
    const auto slabs = plane_slabs(contours.slabs, planes);
    slabs_of_.assign(slabs.begin(), slabs.end());
    for (std::size_t s = 0; s < slab_.size(); ++s)
      slab_[s].most = std::max(kDeviationShare * eps_, contours.deviation[s] / contours.grid.pitch);
    find_columns();
  }

  [[nodiscard]] std::size_t size() const { return columns_.size(); }
  [[nodiscard]] const Column& operator[](std::size_t i) const { return columns_[i]; }
  /// The column that a vertex of a plane belongs to, or kNone.
  [[nodiscard]] std::int32_t of(std::int32_t v) const { return column_of_[std::size_t(v)]; }
  /// How far columns may go from where they were at first, pitches.
  [[nodiscard]] double reach() const { return kReachShare * eps_; }
  [[nodiscard]] bool in_reach(std::size_t i, const GridPoint& p) const {
    return distance(home_[i], p) <= reach() - 1;
  }
  /// Direction of the contour at a column, from one neighbor to the other: for moves along it.
  [[nodiscard]] GridPoint tangent(std::size_t i) {
    const Site& site = columns_[i].sites.front();
    data(std::size_t(site.slab));
    const Outline& outline = outlines_[std::size_t(site.slab)];
    GridPoint ends[2] = {{0, 0}, {0, 0}};
    std::size_t n = 0;
    for_each_edge(site, [&](std::size_t, std::int32_t far) {
      if (n < 2) ends[n] = outline.vertices[std::size_t(far)];
      ++n;
    });
    return n == 2 ? GridPoint{ends[1].x - ends[0].x, ends[1].y - ends[0].y} : GridPoint{0, 0};
  }

  /// May the column go from `from` to `to`? Precondition: `points` has it, and the splits of its edges, there.
  [[nodiscard]] bool may_move(std::size_t i, const GridPoint& from, const GridPoint& to) {
    const Column& column = columns_[i];
    for (const Site& site : column.sites)
      if (!way_is_clear(i, site, from, to)) return false;
    for (const Site& site : column.sites)
      if (!stays_near_slice(site, from, to)) return false;
    return true;
  }
  /// The column was moved.
  void moved(std::size_t i, const GridPoint& to) {
    for (const Site& site : columns_[i].sites) {
      outlines_[std::size_t(site.slab)].vertices[std::size_t(site.vertex)] = to;
      touched_[std::size_t(site.slab)] = 1;
    }
  }

  /// Contours with the columns where they are now.
  [[nodiscard]] const std::vector<Outline>& outlines() const { return outlines_; }
  /// #S: 1 where a contour vertex was moved.
  [[nodiscard]] const std::vector<char>& touched() const { return touched_; }

private:
  using Segment = std::pair<GridPoint, GridPoint>;

  /// What is needed of a slab where something moves; made when that is asked for the first time.
  struct SlabData {
    double most = 0;  // pitches: deviation that parts of the slice may keep
    std::unique_ptr<SegmentIndex> start;  // edges of the contour where they were at first
    std::unique_ptr<SliceNearness> slice;
    std::vector<std::int32_t> first_edge, edges;  // #V + 1 offsets; edges by vertex
  };

  [[nodiscard]] std::int32_t resolve(std::int32_t v) const {
    while (gone_[std::size_t(v)] != kNone) v = gone_[std::size_t(v)];
    return v;
  }
  [[nodiscard]] const GridPoint& point(std::int32_t v) const { return points_[std::size_t(v)]; }
  /// The vertices of an edge of a slab's contour on its bottom (0) or top (1) plane.
  [[nodiscard]] const std::vector<std::int32_t>& local_chain(std::size_t slab, std::size_t edge, std::size_t top) const {
    const PlaneMesh& mesh = stack_.meshes[plane_of(slab, top)];
    return (top != 0 ? mesh.below_chain : mesh.above_chain)[edge];
  }
  [[nodiscard]] std::size_t plane_of(std::size_t slab, std::size_t top) const {
    return std::size_t(stack_.slab_planes[slab][top]);
  }
  /// The same with the vertices that are left.
  void chain(std::size_t slab, std::size_t edge, std::size_t top, std::vector<std::int32_t>& result) const {
    result.clear();
    const std::int32_t first = first_[plane_of(slab, top)];
    for (const std::int32_t v : local_chain(slab, edge, top)) {
      const std::int32_t now = resolve(first + v);
      if (result.empty() || result.back() != now) result.push_back(now);
    }
  }

  void find_columns() {
    std::vector<std::int32_t> parent(points_.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](std::int32_t v) {
      while (parent[std::size_t(v)] != v) {
        parent[std::size_t(v)] = parent[std::size_t(parent[std::size_t(v)])];
        v = parent[std::size_t(v)];
      }
      return v;
    };
    enum : char { kEnd = 1, kInterior = 2, kTwice = 4 };
    std::vector<char> role(points_.size(), 0);
    std::vector<std::array<std::int32_t, 2>> between(points_.size(), {kNone, kNone});
    const auto for_each_chain = [&](auto&& f) {
      std::vector<std::int32_t> all[2];
      for (std::size_t s = 0; s < outlines_.size(); ++s)
        for (std::size_t e = 0; e < outlines_[s].edges.size(); ++e) {
          for (std::size_t top = 0; top < 2; ++top) {
            listen_(2);
            const std::int32_t first = first_[plane_of(s, top)];
            all[top].clear();
            for (const std::int32_t v : local_chain(s, e, top)) all[top].push_back(first + v);
          }
          f(s, e, all[0], all[1]);
        }
    };
    for_each_chain([&](std::size_t, std::size_t, const auto& bottom, const auto& top) {
      parent[std::size_t(root(bottom.front()))] = root(top.front());
      parent[std::size_t(root(bottom.back()))] = root(top.back());
      for (const auto* c : {&bottom, &top}) {
        role[std::size_t(c->front())] |= kEnd;
        role[std::size_t(c->back())] |= kEnd;
        for (std::size_t i = 1; i + 1 < c->size(); ++i) {
          const auto v = std::size_t((*c)[i]);
          const std::array<std::int32_t, 2> ends{std::min((*c)[i - 1], (*c)[i + 1]), std::max((*c)[i - 1], (*c)[i + 1])};
          if ((role[v] & kInterior) != 0 && between[v] != ends) role[v] |= kTwice;
          role[v] |= kInterior;
          between[v] = ends;
        }
      }
    });
    column_of_.assign(points_.size(), kNone);
    for (std::size_t v = 0; v < points_.size(); ++v) {
      if ((role[v] & kEnd) == 0) continue;
      const std::int32_t r = root(std::int32_t(v));
      std::int32_t& column = column_of_[std::size_t(r)];
      if (column == kNone) {
        column = std::int32_t(columns_.size());
        columns_.emplace_back();
        home_.push_back(points_[v]);
      }
      column_of_[v] = column;
      Column& c = columns_[std::size_t(column)];
      c.vertices.push_back(std::int32_t(v));
      // It lies on an edge of another contour, which would have to bend.
      if ((role[v] & kInterior) != 0 || points_[v] != home_[std::size_t(column)]) c.movable = false;
    }
    std::vector<std::vector<char>> seen(outlines_.size());
    for (std::size_t s = 0; s < outlines_.size(); ++s) seen[s].assign(outlines_[s].vertices.size(), 0);
    for_each_chain([&](std::size_t s, std::size_t e, const auto& bottom, const auto& top) {
      const Outline::Edge& edge = outlines_[s].edges[e];
      const std::int32_t a = of(bottom.front()), b = of(bottom.back());
      for (const bool front : {true, false}) {
        Column& column = columns_[std::size_t(front ? a : b)];
        const std::int32_t site = front ? edge.a : edge.b;
        if (!std::exchange(seen[s][std::size_t(site)], 1)) column.sites.push_back({std::int32_t(s), site});
        if (a == b) column.movable = false;
        for (const auto* c : {&bottom, &top})
          for (std::size_t i = 1; i + 1 < c->size(); ++i) {
            const std::int32_t v = (*c)[i];
            // A vertex of another contour, or a crossing with it: it has to stay on that one too.
            if ((role[std::size_t(v)] & (kEnd | kTwice)) != 0) column.movable = false;
            column.splits.push_back({v, front ? c->back() : c->front()});
          }
      }
    });
    for (Column& c : columns_) {
      std::sort(c.splits.begin(), c.splits.end());
      c.splits.erase(std::unique(c.splits.begin(), c.splits.end()), c.splits.end());
      // A split between two different pairs of columns.
      for (std::size_t i = 1; i < c.splits.size(); ++i)
        if (c.splits[i].vertex == c.splits[i - 1].vertex) c.movable = false;
    }
  }

  /// The slab's data for questions about moves.
  SlabData& data(std::size_t s) {
    SlabData& d = slab_[s];
    if (d.start) return d;
    const Outline& outline = outlines_[s];
    std::vector<Segment> segments;
    segments.reserve(outline.edges.size());
    const auto home = [&](std::size_t e, bool front) {
      const auto& c = local_chain(s, e, 0);
      return home_[std::size_t(of(first_[plane_of(s, 0)] + (front ? c.front() : c.back())))];
    };
    for (std::size_t e = 0; e < outline.edges.size(); ++e) segments.emplace_back(home(e, true), home(e, false));
    d.start = std::make_unique<SegmentIndex>(std::move(segments));
    d.slice = std::make_unique<SliceNearness>(slices_[s]);
    d.first_edge.assign(outline.vertices.size() + 1, 0);
    for (const Outline::Edge& e : outline.edges) {
      ++d.first_edge[std::size_t(e.a) + 1];
      ++d.first_edge[std::size_t(e.b) + 1];
    }
    std::partial_sum(d.first_edge.begin(), d.first_edge.end(), d.first_edge.begin());
    d.edges.resize(std::size_t(d.first_edge.back()));
    std::vector<std::int32_t> next(d.first_edge.begin(), d.first_edge.end() - 1);
    for (std::size_t e = 0; e < outline.edges.size(); ++e)
      for (const std::int32_t v : {outline.edges[e].a, outline.edges[e].b})
        d.edges[std::size_t(next[std::size_t(v)]++)] = std::int32_t(e);
    return d;
  }
  /// Calls f(edge, vertex at its other end) for the edges at a contour vertex. Needs `data`.
  template <class F>
  void for_each_edge(const Site& site, F&& f) const {
    const SlabData& d = slab_[std::size_t(site.slab)];
    const Outline& outline = outlines_[std::size_t(site.slab)];
    for (std::int32_t k = d.first_edge[std::size_t(site.vertex)]; k < d.first_edge[std::size_t(site.vertex) + 1]; ++k) {
      const auto e = std::size_t(d.edges[std::size_t(k)]);
      const Outline::Edge& edge = outline.edges[e];
      f(e, edge.a == site.vertex ? edge.b : edge.a);
    }
  }

  /// Do two pieces of contours have nothing in common but ends that are one vertex?
  [[nodiscard]] bool pieces_agree(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) const {
    if (a == d || b == c) std::swap(c, d);
    if (a == c && b == d) return true;
    if (a == c || b == d) {
      const std::int32_t shared = a == c ? a : b, p = a == c ? b : a, q = a == c ? d : c;
      // They overlap if the other two ends lie in one direction.
      return orientation(point(shared), point(p), point(q)) != 0 || dot(point(shared), point(p), point(q)) < 0;
    }
    return !segments_meet(point(a), point(b), point(c), point(d));
  }

  /// Does nothing get in the way of the edges at a contour vertex, on both planes of its slab?
  [[nodiscard]] bool way_is_clear(std::size_t column, const Site& site, const GridPoint& from, const GridPoint& to) {
    const auto s = std::size_t(site.slab);
    data(s);
    bool clear = true;
    for_each_edge(site, [&](std::size_t e, std::int32_t far) {
      for (std::size_t top = 0; clear && top < 2; ++top) clear = edge_is_clear(column, s, e, far, top, from, to);
    });
    return clear;
  }
  [[nodiscard]] bool edge_is_clear(std::size_t column, std::size_t s, std::size_t e, std::int32_t far, std::size_t top,
                                   const GridPoint& from, const GridPoint& to) {
    const GridPoint end = outlines_[s].vertices[std::size_t(far)];
    const std::size_t plane = plane_of(s, top);
    chain(s, e, top, own_);
    const std::int32_t end_vertex = of(own_.front()) == std::int32_t(column) ? own_.back() : own_.front();
    const double clearance = kClearShare * eps_;
    const auto pad = std::int64_t(std::ceil(distance(from, to) + reach() + clearance)) + 1;
    const int turn = orientation(from, to, end);
    const auto swept = [&](const GridPoint& y) {
      const int a = orientation(from, to, y), b = orientation(to, end, y), c = orientation(end, from, y);
      if (turn != 0) return a * turn >= 0 && b * turn >= 0 && c * turn >= 0;
      // The way lies on the line of the edge.
      return c == 0 && a == 0 && y.x >= std::min({from.x, to.x, end.x}) && y.x <= std::max({from.x, to.x, end.x}) &&
             y.y >= std::min({from.y, to.y, end.y}) && y.y <= std::max({from.y, to.y, end.y});
    };
    const auto gets_close = [&](double before, double now) { return now < clearance && now < before; };
    for (const std::int32_t t : {slabs_of_[plane].first, slabs_of_[plane].second}) {
      if (t == kNone) continue;
      const std::size_t other_top = t == slabs_of_[plane].first ? 1 : 0;
      const SlabData& other = data(std::size_t(t));
      const Outline& outline = outlines_[std::size_t(t)];
      const bool blocked = other.start->any_near(from, end, pad, [&](std::size_t f) {
        listen_();
        if (std::size_t(t) == s && f == e) return false;
        chain(std::size_t(t), f, other_top, other_);
        const bool at_front = of(other_.front()) == std::int32_t(column);
        const bool adjacent = at_front || of(other_.back()) == std::int32_t(column);
        const GridPoint u = outline.vertices[std::size_t(outline.edges[f].a)],
                        w = outline.vertices[std::size_t(outline.edges[f].b)];
        if (adjacent) {
          // Two edges at the column: the angle between them, as distances of their other ends.
          const GridPoint x = at_front ? w : u;
          if (x != end && (gets_close(segment_distance(x, from, end), segment_distance(x, to, end)) ||
                           gets_close(segment_distance(end, from, x), segment_distance(end, to, x))))
            return true;
        } else {
          if (gets_close(segment_distance(from, u, w), segment_distance(to, u, w))) return true;
          for (const GridPoint& y : {u, w})
            if (y != end && gets_close(segment_distance(y, from, end), segment_distance(y, to, end))) return true;
          for (const std::int32_t y : other_)
            if (y != end_vertex && swept(point(y))) return true;
          for (std::size_t k = 1; k < other_.size(); ++k)
            if (segments_meet(from, to, point(other_[k - 1]), point(other_[k]))) return true;
        }
        for (std::size_t i = 1; i < own_.size(); ++i)
          for (std::size_t k = 1; k < other_.size(); ++k)
            if (!pieces_agree(own_[i - 1], own_[i], other_[k - 1], other_[k])) return true;
        return false;
      });
      if (blocked) return false;
    }
    return true;
  }

  /// Do the slab and its slice stay near to each other?
  [[nodiscard]] bool stays_near_slice(const Site& site, const GridPoint& from, const GridPoint& to) {
    SlabData& d = data(std::size_t(site.slab));
    const Outline& outline = outlines_[std::size_t(site.slab)];
    const NearnessLimits limits{kDeviationShare * eps_, d.most, kResolution};
    old_.clear();
    now_.clear();
    for_each_edge(site, [&](std::size_t, std::int32_t far) {
      old_.emplace_back(from, outline.vertices[std::size_t(far)]);
      now_.emplace_back(to, outline.vertices[std::size_t(far)]);
    });
    for (const Segment& edge : now_)
      if (!d.slice->is_near(edge, limits, &listen_)) return false;
    // Other edges of the contour that may be nearest to a part of the slice.
    const auto pad = std::int64_t(std::ceil(2 * d.most + reach())) + 1;
    const std::size_t own = now_.size();
    for (const Segment& edge : old_)
      d.start->for_each_near(edge.first, edge.second, pad, [&](std::size_t f) {
        const Outline::Edge& other = outline.edges[f];
        if (other.a == site.vertex || other.b == site.vertex) return;
        now_.emplace_back(outline.vertices[std::size_t(other.a)], outline.vertices[std::size_t(other.b)]);
      });
    std::sort(now_.begin() + std::ptrdiff_t(own), now_.end());
    now_.erase(std::unique(now_.begin() + std::ptrdiff_t(own), now_.end()), now_.end());
    return d.slice->stays_covered(old_, now_, limits, &listen_);
  }

  static constexpr std::size_t kPollEvery = 1 << 14;         // edges looked at
  static constexpr double kReachShare = 1;                   // of eps
  static constexpr double kClearShare = 0.45;                // of eps: contours nearer than this do not get nearer
  static constexpr double kDeviationShare = 0.985;           // of eps ...
  static constexpr double kResolution = 1.0 / 64;            // ... with half of this share more, still below eps

  const std::vector<Outline>& slices_;
  const PlaneStack& stack_;
  const std::vector<std::int32_t>& first_;
  const std::vector<GridPoint>& points_;
  const std::vector<std::int32_t>& gone_;
  Poll listen_;
  double eps_;                                                  // pitches
  std::vector<Outline> outlines_;                               // #S
  std::vector<char> touched_;                                   // #S
  std::vector<SlabData> slab_;                                  // #S
  std::vector<std::pair<std::int32_t, std::int32_t>> slabs_of_;  // #P: slab below, slab above
  std::vector<Column> columns_;
  std::vector<GridPoint> home_;           // of columns: where they were at first
  std::vector<std::int32_t> column_of_;   // #V
  std::vector<std::int32_t> own_, other_;  // chains in question
  std::vector<Segment> old_, now_;
};

}  // namespace slice2mesh::detail
