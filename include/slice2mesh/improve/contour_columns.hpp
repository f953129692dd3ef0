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
#include <tuple>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/arrange/segment_index.hpp"
#include "slice2mesh/core/all_from.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/harmonize/contour_shape.hpp"
#include "slice2mesh/harmonize/harmonize.hpp"
#include "slice2mesh/harmonize/separation_report.hpp"
#include "slice2mesh/harmonize/slice_nearness.hpp"
#include "slice2mesh/lift/lift.hpp"
#include "slice2mesh/triangulate/plane_stack.hpp"

namespace slice2mesh::detail {

/// The vertices of the planes that have to move together for walls to stay vertical. A contour vertex of a slab stands
/// on both of its planes, and where contours of neighboring slabs have it in common, on those of the next slab too:
/// these are a column. On one of its planes a column may stand on an edge of another contour, between its ends; and
/// edges of two contours may cross: then it follows when an end of such an edge moves (a follower), and may move along
/// that edge by itself. Vertices that split edges keep their share of them.
///
/// Says where all of these go with a column, and whether they may: contours keep their distance from their slices, and
/// in each plane no contour meets another one that it did not meet before, nor passes over a vertex of it (exact). What
/// lies between contours, the tets, is for the caller to look at.
class ContourColumns {
public:
  /// A vertex of a plane, and a place for it.
  struct Place {
    std::int32_t vertex;
    GridPoint point;
  };

  /// What a move has to keep: always the angles between contours of neighboring slabs where they are sharp, that
  /// contours and slices are near to each other, and what lies on which side of what.
  enum class Keep : std::uint8_t {
    Angles,      ///< no more than that
    RoughAreas,  ///< areas of slabs, roughly, and the volume of the part
    Walls,       ///< corners and straight walls of slices where harmonization left them, and the volume of the part
    Areas        ///< corners and straight walls, areas of slabs, nearly, and the volume of the part
  };

  /// Vertices of all planes are counted through, those of plane k from `first[k]` on. `points` (#V) and `gone` (#V: the
  /// vertex that a vertex was merged into, or kNone) are looked at whenever a question is asked. `slices` (#S) are the
  /// regions that the contours were made from; `slices`, `stack`, `first` and `poll` have to outlive this.
  ContourColumns(const Contours& contours, const std::vector<Outline>& slices, const PlaneStack& stack,
                 const std::vector<std::int32_t>& first, const std::vector<GridPoint>& points,
                 const std::vector<std::int32_t>& gone, const std::function<void()>& poll)
      : slices_(slices), stack_(stack), first_(first), points_(points), gone_(gone), listen_(poll, kPollEvery),
        eps_(contours.tolerance / contours.grid.pitch), outlines_(contours.outlines),
        touched_(contours.slabs.size(), 0), slab_(contours.slabs.size()) {
    std::vector<std::array<std::int32_t, 2>> planes;
    slabs_of_ = plane_slabs(contours.slabs, planes);
    for (std::size_t s = 0; s < slab_.size(); ++s)
      slab_[s].most = std::max(kDeviationShare * eps_, contours.deviation[s] / contours.grid.pitch);
    find_excess(contours.slabs);
    find_shapes();
    find_columns();
    find_groups();
    if (contours.corners_opened)
      find_corners();
    else
      corner_start_.assign(columns_.size() + 1, 0);
    old_.assign(points_.size(), {});
    stamp_of_.assign(points_.size(), 0);
  }

  [[nodiscard]] std::size_t size() const { return columns_.size(); }
  /// May a column move at all, where a move has to keep that?
  [[nodiscard]] bool movable(std::size_t i, Keep keep) const {
    return !columns_[i].group.empty() && (keep < Keep::Walls || !columns_[i].corner_moves);
  }
  /// The column that a vertex of a plane belongs to, or kNone.
  [[nodiscard]] std::int32_t of(std::int32_t v) const { return column_of_[std::size_t(v)]; }
  /// Vertices of a column, all in one place.
  [[nodiscard]] const std::vector<std::int32_t>& vertices(std::size_t i) const { return columns_[i].vertices; }
  /// In how many slabs it is.
  [[nodiscard]] std::size_t slab_count(std::size_t i) const { return columns_[i].sites.size(); }
  [[nodiscard]] const GridPoint& place(std::size_t i) const { return point(columns_[i].vertices.front()); }
  /// How far columns may go from where they were at first, pitches.
  [[nodiscard]] double reach() const { return kReachShare * eps_; }

  /// The direction in which a column that stands on an edge can move, or of the contour at a column that is no corner
  /// of more than two edges, from one neighbor to the other; (0, 0): neither.
  [[nodiscard]] GridPoint along(std::size_t i) {
    const Column& column = columns_[i];
    GridPoint ends[2] = {{0, 0}, {0, 0}};
    if (!column.lines.empty()) {
      for (std::size_t k = 0; k < 2; ++k) ends[k] = place(std::size_t(column.lines.front()[k]));
    } else {
      std::size_t n = 0;
      for_each_edge(column.sites.front(), [&](std::size_t, std::int32_t far) {
        if (n < 2) ends[n] = site_point(column.sites.front().slab, far);
        ++n;
      });
      if (n != 2) return {0, 0};
    }
    return {ends[1].x - ends[0].x, ends[1].y - ends[0].y};
  }
  /// Does the column stand on an edge, so that it moves along that or not at all?
  [[nodiscard]] bool on_edge(std::size_t i) const { return !columns_[i].lines.empty(); }

  /// Begins questions about moves of a movable column: `before` gets all that moves with it and where that is now.
  void take(std::size_t i, std::vector<Place>& before) {
    taken_ = i;
    changing_.clear();
    way_doubt_ = slice_doubt_ = 0;
    before.clear();
    splits_.clear();
    ++stamp_;
    const auto add = [&](std::int32_t v) {
      if (stamp_of_[std::size_t(v)] == stamp_) return false;
      stamp_of_[std::size_t(v)] = stamp_;
      old_[std::size_t(v)] = point(v);
      before.push_back({v, point(v)});
      return true;
    };
    for (const std::int32_t c : columns_[i].group)
      for (const std::int32_t v : columns_[std::size_t(c)].vertices) add(v);
    for (const std::int32_t c : columns_[i].group)
      for (const Split& split : columns_[std::size_t(c)].splits) {
        if (gone_[std::size_t(split.vertex)] != kNone || !add(split.vertex)) continue;
        const GridPoint &a = point(split.from), &b = point(split.to);
        splits_.push_back({split, double(dot(a, b, point(split.vertex))) / double(squared_distance(a, b))});
      }
    // Shares of followers of their lines.
    shares_.clear();
    for (const std::int32_t c : columns_[i].group) {
      const Column& column = columns_[std::size_t(c)];
      double share = 0;
      if (column.lines.size() == 1) {
        const GridPoint &a = place(std::size_t(column.lines[0][0])), &b = place(std::size_t(column.lines[0][1]));
        share = double(dot(a, b, place(std::size_t(c)))) / double(squared_distance(a, b));
      }
      shares_.push_back(share);
    }
  }
  /// Where all goes when the column that was taken goes to `to`, or on its edge as near to `to` as may be; in the order
  /// of `before`. False if that is nowhere.
  [[nodiscard]] bool places(const GridPoint& to, std::vector<Place>& after) {
    after.clear();
    targets_.clear();
    const std::vector<std::int32_t>& group = columns_[taken_].group;
    for (std::size_t k = 0; k < group.size(); ++k) {
      const auto c = std::size_t(group[k]);
      GridPoint target = to;
      if (k > 0 || on_edge(c)) {
        if (!follow(k, to, target)) return false;
      } else {
        target = {round_to_step(to.x), round_to_step(to.y)};
      }
      if (distance(home_[c], target) > reach() - 1) return false;
      // A tolerance may be wider than the grid.
      if (!is_on_grid(target)) return false;
      targets_.push_back(target);
      for (const std::int32_t v : columns_[c].vertices) after.push_back({v, target});
    }
    if (targets_.front() == place(taken_)) return false;
    for (const auto& [split, share] : splits_) {
      const GridPoint a = target_of(split.from), b = target_of(split.to);
      after.push_back({split.vertex,
                       {a.x + std::llround(share * double(b.x - a.x)), a.y + std::llround(share * double(b.y - a.y))}});
    }
    return true;
  }
  /// May the column that was taken go to the last places given? Precondition: `points` has all of it there.
  [[nodiscard]] bool may_move(Keep keep) {
    return corners_stay() && (keep < Keep::Walls || walls_stay()) && keeps_slices(keep) && way_is_clear();
  }
  /// It was moved there.
  void moved() {
    const std::vector<std::int32_t>& group = columns_[taken_].group;
    for (std::size_t k = 0; k < group.size(); ++k)
      for (const Site& site : columns_[std::size_t(group[k])].sites) {
        outlines_[std::size_t(site.slab)].vertices[std::size_t(site.vertex)] = targets_[k];
        touched_[std::size_t(site.slab)] = 1;
      }
    for (const auto& [slab, gain] : gains_) slab_[std::size_t(slab)].excess += gain;
    excess_ += gain_;
  }

  /// There is one vertex more, the last one, which splits no edge yet.
  void add_vertex() {
    column_of_.push_back(kNone);
    old_.emplace_back();
    stamp_of_.push_back(0);
  }
  /// The last vertex splits an edge between these two, which are those of columns next to it.
  void add_split(std::int32_t from, std::int32_t to) {
    const auto v = std::int32_t(points_.size()) - 1;
    columns_[std::size_t(of(from))].splits.push_back({v, from, to});
    columns_[std::size_t(of(to))].splits.push_back({v, to, from});
  }

  /// #S, contours with the columns where they are now.
  [[nodiscard]] const std::vector<Outline>& outlines() const { return outlines_; }
  /// #S: 1 where a contour vertex was moved.
  [[nodiscard]] const std::vector<char>& touched() const { return touched_; }

private:
  using Segment = std::pair<GridPoint, GridPoint>;

  /// A contour vertex.
  struct Site {
    std::int32_t slab;
    std::int32_t vertex;  // of the outline of the slab
  };
  /// An edge of a contour on the bottom (0) or the top (1) plane of its slab.
  struct Chain {
    std::int32_t slab, edge, top;
    friend bool operator<(const Chain& a, const Chain& b) {
      return std::tie(a.slab, a.top, a.edge) < std::tie(b.slab, b.top, b.edge);
    }
    friend bool operator==(const Chain& a, const Chain& b) {
      return a.slab == b.slab && a.edge == b.edge && a.top == b.top;
    }
  };
  /// A vertex between two vertices of columns, on an edge.
  struct Split {
    std::int32_t vertex, from, to;
  };
  /// Edges to two columns that follow each other around a third one.
  struct Corner {
    std::int32_t at, a, b;
    friend bool operator<(const Corner& p, const Corner& q) {
      return std::tie(p.at, p.a, p.b) < std::tie(q.at, q.a, q.b);
    }
    friend bool operator==(const Corner& p, const Corner& q) { return p.at == q.at && p.a == q.a && p.b == q.b; }
  };
  struct Column {
    std::vector<std::int32_t> vertices;              // of planes
    std::vector<Split> splits;                       // on its edges, next to it
    std::vector<Site> sites;                         // none: a crossing
    std::vector<Chain> through;                      // edges that it stands on, not at their ends
    std::vector<std::array<std::int32_t, 2>> lines;  // columns at the ends of those
    std::vector<std::int32_t> followers;             // columns on edges that end here
    std::vector<std::int32_t> group;                 // it and all that follow, ends before what stands between them
    bool sound = true;
    bool corner = false;        // of a slice
    bool corner_moves = false;  // with it
  };
  /// What is needed of a slab where something moves; made when that is asked for the first time.
  struct SlabData {
    double most = 0;                      // pitches: deviation that parts of the slice may keep
    Int128 excess = 0;                    // squared pitches: twice the area, less that of the slice ...
    Int128 most_excess = 0;               // ... which a move may not bring above this, either way, ...
    Int128 rough_excess = 0;              // ... or above this, where areas are kept roughly
    std::unique_ptr<SegmentIndex> start;  // edges of the contour where they were at first
    std::unique_ptr<SliceNearness> slice;
    std::unique_ptr<EdgesAt> edges_at;
    std::vector<std::uint32_t> found;  // #E: by which search
    std::uint32_t search = 0;          // the last one
  };

  [[nodiscard]] std::int32_t resolve(std::int32_t v) const {
    while (gone_[std::size_t(v)] != kNone) v = gone_[std::size_t(v)];
    return v;
  }
  [[nodiscard]] const GridPoint& point(std::int32_t v) const { return points_[std::size_t(v)]; }
  [[nodiscard]] const GridPoint& site_point(std::int32_t slab, std::int32_t v) const {
    return outlines_[std::size_t(slab)].vertices[std::size_t(v)];
  }
  [[nodiscard]] bool moves(std::int32_t v) const { return stamp_of_[std::size_t(v)] == stamp_; }
  /// Where a vertex was when the column was taken.
  [[nodiscard]] const GridPoint& old_point(std::int32_t v) const { return moves(v) ? old_[std::size_t(v)] : point(v); }
  [[nodiscard]] std::size_t plane_of(std::int32_t slab, std::int32_t top) const {
    return std::size_t(stack_.slab_planes[std::size_t(slab)][std::size_t(top)]);
  }
  /// The vertices of an edge, in the numbers of their plane.
  [[nodiscard]] const std::vector<std::int32_t>& local_chain(const Chain& c) const {
    const PlaneMesh& mesh = stack_.meshes[plane_of(c.slab, c.top)];
    return (c.top != 0 ? mesh.below_chain : mesh.above_chain)[std::size_t(c.edge)];
  }
  /// Those that are left, in the numbers of all planes.
  void vertices_of(const Chain& c, std::vector<std::int32_t>& result) const {
    result.clear();
    const std::int32_t first = first_[plane_of(c.slab, c.top)];
    for (const std::int32_t v : local_chain(c)) {
      const std::int32_t now = resolve(first + v);
      if (result.empty() || result.back() != now) result.push_back(now);
    }
  }

  // --- what belongs together

  /// How much the volume between contours differs from that of the slices.
  void find_excess(const std::vector<Slab>& slabs) {
    double volume = 0;
    for (std::size_t s = 0; s < outlines_.size(); ++s) {
      listen_(outlines_[s].edges.size() + slices_[s].edges.size());
      heights_.push_back(slabs[s].z_high - slabs[s].z_low);
      const Int128 area = doubled_area(slices_[s], kNone);
      volume += heights_[s] * double(area);
      excess_ += heights_[s] * double(doubled_area(outlines_[s], kNone) - area);
    }
    most_excess_ = kVolumeShare * volume;
  }
  /// Tells corners that are those of the slices and straight walls from what may move more freely.
  void find_shapes() {
    shape_.resize(outlines_.size());
    line_.resize(outlines_.size());
    std::vector<GridPoint> slice;
    for (std::size_t s = 0; s < outlines_.size(); ++s) {
      const Outline& outline = outlines_[s];
      shape_[s].assign(outline.vertices.size(), ContourShape::Corner);
      line_[s].assign(outline.vertices.size(), {});
      slice.clear();
      for (const GridPoint& p : slices_[s].vertices) slice.push_back({round_to_step(p.x), round_to_step(p.y)});
      sort_listening(slice.begin(), slice.end(), listen_);
      std::vector<std::uint32_t> degree(outline.vertices.size(), 0);
      listen_(outline.edges.size());
      for (const Outline::Edge& e : outline.edges)
        for (const auto& [v, far] : {std::pair{e.a, e.b}, std::pair{e.b, e.a}}) {
          const std::uint32_t n = degree[std::size_t(v)]++;
          if (n < 2) line_[s][std::size_t(v)][n] = outline.vertices[std::size_t(far)];
        }
      for (std::size_t v = 0; v < outline.vertices.size(); ++v) {
        listen_();
        const GridPoint& p = outline.vertices[v];
        if (degree[v] == 2) shape_[s][v] = contour_shape(p, line_[s][v][0], line_[s][v][1]);
        if (shape_[s][v] == ContourShape::Corner && !std::binary_search(slice.begin(), slice.end(), p))
          shape_[s][v] = ContourShape::Curved;
      }
    }
  }

  template <class F>
  void for_each_chain(F&& f) {
    std::vector<std::int32_t> chain;
    for (std::size_t s = 0; s < outlines_.size(); ++s)
      for (std::size_t e = 0; e < outlines_[s].edges.size(); ++e)
        for (std::int32_t top = 0; top < 2; ++top) {
          listen_();
          const Chain c{std::int32_t(s), std::int32_t(e), top};
          vertices_of(c, chain);
          f(c, chain);
        }
  }
  void find_columns() {
    enum : char { End = 1, Interior = 2, Twice = 4 };
    std::vector<char> role(points_.size(), 0);
    std::vector<std::int32_t> parent(points_.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](std::int32_t v) {
      while (parent[std::size_t(v)] != v) {
        parent[std::size_t(v)] = parent[std::size_t(parent[std::size_t(v)])];
        v = parent[std::size_t(v)];
      }
      return v;
    };
    {
      std::vector<std::array<std::int32_t, 2>> between(points_.size(), {kNone, kNone});
      std::array<std::int32_t, 2> bottom{kNone, kNone};
      for_each_chain([&](const Chain& c, const auto& chain) {
        const std::array<std::int32_t, 2> ends{chain.front(), chain.back()};
        for (std::size_t k = 0; k < 2; ++k) {
          role[std::size_t(ends[k])] |= End;
          if (c.top != 0) parent[std::size_t(root(bottom[k]))] = root(ends[k]);
        }
        bottom = ends;
        for (std::size_t i = 1; i + 1 < chain.size(); ++i) {
          const auto v = std::size_t(chain[i]);
          const std::array<std::int32_t, 2> next{std::min(chain[i - 1], chain[i + 1]),
                                                 std::max(chain[i - 1], chain[i + 1])};
          if ((role[v] & Interior) != 0 && between[v] != next) role[v] |= Twice;
          role[v] |= Interior;
          between[v] = next;
        }
      });
    }
    column_of_.assign(points_.size(), kNone);
    for (std::size_t v = 0; v < points_.size(); ++v) {
      listen_();
      if ((role[v] & (End | Twice)) == 0) continue;  // a split, or in the interior
      const std::int32_t r = root(std::int32_t(v));
      std::int32_t column = column_of_[std::size_t(r)];
      if (column == kNone) {
        column = std::int32_t(columns_.size());
        columns_.emplace_back();
        home_.push_back(points_[v]);
        column_of_[std::size_t(r)] = column;
      }
      column_of_[v] = column;
      Column& c = columns_[std::size_t(column)];
      c.vertices.push_back(std::int32_t(v));
      if (points_[v] != home_[std::size_t(column)]) c.sound = false;
    }
    std::vector<std::vector<char>> seen(outlines_.size());
    for (std::size_t s = 0; s < outlines_.size(); ++s) seen[s].assign(outlines_[s].vertices.size(), 0);
    std::vector<std::size_t> stations;
    for_each_chain([&](const Chain& c, const auto& chain) {
      const Outline::Edge& edge = outlines_[std::size_t(c.slab)].edges[std::size_t(c.edge)];
      const std::int32_t a = of(chain.front()), b = of(chain.back());
      for (const auto& [column, v] : {std::pair{a, edge.a}, std::pair{b, edge.b}}) {
        if (!std::exchange(seen[std::size_t(c.slab)][std::size_t(v)], 1)) {
          columns_[std::size_t(column)].sites.push_back({c.slab, v});
          if (shape_[std::size_t(c.slab)][std::size_t(v)] == ContourShape::Corner)
            columns_[std::size_t(column)].corner = true;
        }
        if (a == b) columns_[std::size_t(column)].sound = false;
      }
      const std::array<std::int32_t, 2> line{std::min(a, b), std::max(a, b)};
      stations.clear();
      for (std::size_t i = 0; i < chain.size(); ++i)
        if (of(chain[i]) != kNone) stations.push_back(i);
      for (std::size_t k = 0; k < stations.size(); ++k) {
        Column& column = columns_[std::size_t(of(chain[stations[k]]))];
        if (k > 0)
          for (std::size_t i = stations[k - 1] + 1; i < stations[k]; ++i)
            column.splits.push_back({chain[i], chain[stations[k]], chain[stations[k - 1]]});
        if (k + 1 < stations.size())
          for (std::size_t i = stations[k] + 1; i < stations[k + 1]; ++i)
            column.splits.push_back({chain[i], chain[stations[k]], chain[stations[k + 1]]});
        if (k == 0 || k + 1 == stations.size()) continue;
        column.through.push_back(c);
        if (std::find(column.lines.begin(), column.lines.end(), line) == column.lines.end())
          column.lines.push_back(line);
      }
    });
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      listen_();
      Column& c = columns_[i];
      std::sort(c.splits.begin(), c.splits.end(), [](const Split& a, const Split& b) {
        return std::tie(a.vertex, a.from, a.to) < std::tie(b.vertex, b.from, b.to);
      });
      c.splits.erase(std::unique(c.splits.begin(), c.splits.end(),
                                 [](const Split& a, const Split& b) { return a.vertex == b.vertex; }),
                     c.splits.end());
      // A vertex on one edge follows that; a crossing is the point that two edges have in common.
      if (c.lines.size() != (c.sites.empty() ? 2 : c.lines.empty() ? 0 : 1)) c.sound = false;
      for (const auto& line : c.lines)
        for (const std::int32_t end : line) columns_[std::size_t(end)].followers.push_back(std::int32_t(i));
    }
    for (Column& c : columns_) {
      listen_();
      std::sort(c.followers.begin(), c.followers.end());
      c.followers.erase(std::unique(c.followers.begin(), c.followers.end()), c.followers.end());
    }
  }
  /// Columns that follow a column, and those that follow them, ordered. Where there are too many, or one that cannot
  /// follow, the column stays.
  void find_groups() {
    std::vector<std::int32_t> set;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      listen_();
      if (columns_[i].sites.empty() || !columns_[i].sound) continue;  // crossings do not move by themselves
      set.assign(1, std::int32_t(i));
      bool sound = true;
      for (std::size_t k = 0; sound && k < set.size(); ++k)
        for (const std::int32_t f : columns_[std::size_t(set[k])].followers) {
          if (std::find(set.begin(), set.end(), f) != set.end()) continue;
          set.push_back(f);
          sound = columns_[std::size_t(f)].sound && set.size() <= kLargestGroup;
          if (!sound) break;
        }
      if (!sound) continue;
      std::vector<std::int32_t> group{std::int32_t(i)};
      const auto in = [](const std::vector<std::int32_t>& list, std::int32_t c) {
        return std::find(list.begin(), list.end(), c) != list.end();
      };
      // The ends of its own edge stay where they are.
      bool more = std::none_of(columns_[i].lines.begin(), columns_[i].lines.end(),
                               [&](const auto& line) { return in(set, line[0]) || in(set, line[1]); });
      if (!more) continue;
      while (more) {
        more = false;
        for (const std::int32_t c : set) {
          if (in(group, c)) continue;
          const auto& lines = columns_[std::size_t(c)].lines;
          const bool ready = std::all_of(lines.begin(), lines.end(), [&](const auto& line) {
            return std::all_of(line.begin(), line.end(),
                               [&](std::int32_t end) { return !in(set, end) || in(group, end); });
          });
          if (!ready) continue;
          group.push_back(c);
          more = true;
        }
      }
      if (group.size() != set.size()) continue;
      columns_[i].corner_moves =
          std::any_of(group.begin(), group.end(), [&](std::int32_t c) { return columns_[std::size_t(c)].corner; });
      columns_[i].group = std::move(group);
    }
  }

  /// Where contours of neighboring slabs leave each other: the edges that follow each other around a column in a plane
  /// and are of one of the two contours each.
  void find_corners() {
    struct Ray {
      std::int32_t from, to;
      std::uint8_t sides;  // 1: of the contour below, 2: of the one above
    };
    std::vector<Ray> rays;
    std::vector<std::pair<double, std::size_t>> around;
    std::vector<std::int32_t> chain;
    std::vector<Corner> corners;
    for (std::size_t k = 0; k < slabs_of_.size(); ++k) {
      const auto [below, above] = slabs_of_[k];
      if (below == kNone || above == kNone) continue;
      rays.clear();
      for (const std::int32_t top : {1, 0}) {
        const std::int32_t slab = top != 0 ? below : above;
        for (std::size_t e = 0; e < outlines_[std::size_t(slab)].edges.size(); ++e) {
          vertices_of({slab, std::int32_t(e), top}, chain);
          listen_(chain.size());
          std::int32_t last = kNone;
          for (const std::int32_t v : chain) {
            const std::int32_t c = of(v);
            if (c == kNone) continue;
            const auto side = std::uint8_t(top != 0 ? 1 : 2);
            if (last != kNone && last != c) {
              rays.push_back({last, c, side});
              rays.push_back({c, last, side});
            }
            last = c;
          }
        }
      }
      sort_listening(rays.begin(), rays.end(), listen_, [](const Ray& a, const Ray& b) {
        return std::tie(a.from, a.to, a.sides) < std::tie(b.from, b.to, b.sides);
      });
      std::size_t size = 0;
      for (const Ray& r : rays) {
        if (size > 0 && rays[size - 1].from == r.from && rays[size - 1].to == r.to)
          rays[size - 1].sides |= r.sides;
        else
          rays[size++] = r;
      }
      rays.resize(size);
      for (std::size_t i = 0, j = 0; i < rays.size(); i = j) {
        for (j = i + 1; j < rays.size() && rays[j].from == rays[i].from;) ++j;
        listen_(j - i);
        std::uint8_t common = 3;
        for (std::size_t m = i; m < j; ++m) common &= rays[m].sides;
        if (common != 0) continue;
        around.clear();
        const GridPoint& p = home_[std::size_t(rays[i].from)];
        for (std::size_t m = i; m < j; ++m) {
          const GridPoint& q = home_[std::size_t(rays[m].to)];
          around.emplace_back(std::atan2(double(q.y - p.y), double(q.x - p.x)), m);
        }
        std::sort(around.begin(), around.end());
        for (std::size_t m = 0; m < around.size(); ++m) {
          const Ray &q = rays[around[m].second], &r = rays[around[m + 1 < around.size() ? m + 1 : 0].second];
          if ((q.sides & r.sides) == 0) corners.push_back({q.from, q.to, r.to});
        }
      }
    }
    sort_listening(corners.begin(), corners.end(), listen_);
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    corners_ = std::move(corners);
    corner_start_.assign(columns_.size() + 1, 0);
    for (const Corner& c : corners_)
      for (const std::int32_t i : {c.at, c.a, c.b}) ++corner_start_[std::size_t(i) + 1];
    for (std::size_t i = 1; i < corner_start_.size(); ++i) corner_start_[i] += corner_start_[i - 1];
    corners_at_.resize(corner_start_.back());
    std::vector<std::uint32_t> next(corner_start_.begin(), corner_start_.end() - 1);
    for (std::size_t n = 0; n < corners_.size(); ++n)
      for (const std::int32_t i : {corners_[n].at, corners_[n].a, corners_[n].b})
        corners_at_[next[std::size_t(i)]++] = std::uint32_t(n);
  }

  // --- where it all goes

  [[nodiscard]] GridPoint target_of(std::int32_t v) const { return target_of_column(std::size_t(of(v))); }
  [[nodiscard]] GridPoint target_of_column(std::size_t c) const {
    const std::vector<std::int32_t>& group = columns_[taken_].group;
    for (std::size_t k = 0; k < targets_.size(); ++k)
      if (std::size_t(group[k]) == c) return targets_[k];
    return stamp_of_[std::size_t(columns_[c].vertices.front())] == stamp_
               ? old_[std::size_t(columns_[c].vertices.front())]
               : place(c);
  }
  /// Where a member of the group goes that stands on an edge or is a crossing. `to`: where the first one is to go.
  [[nodiscard]] bool follow(std::size_t k, const GridPoint& to, GridPoint& target) const {
    const Column& column = columns_[std::size_t(columns_[taken_].group[k])];
    const GridPoint a = target_of_column(std::size_t(column.lines[0][0])),
                    b = target_of_column(std::size_t(column.lines[0][1]));
    if (a == b) return false;
    if (column.lines.size() == 1) {
      const double share = k > 0 ? shares_[k] : double(dot(a, b, to)) / double(squared_distance(a, b));
      if (!(share > 0) || !(share < 1)) return false;
      target = {round_to_step(a.x + std::llround(share * double(b.x - a.x))),
                round_to_step(a.y + std::llround(share * double(b.y - a.y)))};
      return true;
    }
    const GridPoint c = target_of_column(std::size_t(column.lines[1][0])),
                    d = target_of_column(std::size_t(column.lines[1][1]));
    const double whole = double(cross(c, d, a)) - double(cross(c, d, b));
    const double share = double(cross(c, d, a)) / whole;
    if (whole == 0 || !(share > 0) || !(share < 1)) return false;
    target = {a.x + std::llround(share * double(b.x - a.x)), a.y + std::llround(share * double(b.y - a.y))};
    return true;
  }

  // --- whether it may

  SlabData& data(std::int32_t s) {
    SlabData& d = slab_[std::size_t(s)];
    if (d.start) return d;
    const Outline& outline = outlines_[std::size_t(s)];
    std::vector<Segment> segments;
    segments.reserve(outline.edges.size());
    for (std::size_t e = 0; e < outline.edges.size(); ++e) {
      listen_();
      const auto& c = local_chain({s, std::int32_t(e), 0});
      const std::int32_t first = first_[plane_of(s, 0)];
      segments.emplace_back(home_[std::size_t(of(first + c.front()))], home_[std::size_t(of(first + c.back()))]);
    }
    d.slice = std::make_unique<SliceNearness>(slices_[std::size_t(s)], &listen_);
    d.excess = doubled_area(outline, kNone) - doubled_area(slices_[std::size_t(s)], kNone);
    double length = 0, curved = 0;
    for (std::size_t e = 0; e < segments.size(); ++e) {
      length += distance(segments[e].first, segments[e].second);
      if (shape_[std::size_t(s)][std::size_t(outline.edges[e].a)] == ContourShape::Curved ||
          shape_[std::size_t(s)][std::size_t(outline.edges[e].b)] == ContourShape::Curved)
        curved += distance(segments[e].first, segments[e].second);
    }
    d.most_excess = Int128(2 * kAreaShare * eps_ * curved);
    d.rough_excess = Int128(2 * kRoughAreaShare * eps_ * length);
    d.start = std::make_unique<SegmentIndex>(std::move(segments), &listen_);
    d.found.assign(outline.edges.size(), 0);
    d.edges_at = std::make_unique<EdgesAt>(outline);
    return d;
  }
  /// Calls f(edge, vertex at its other end) for the edges at a contour vertex.
  template <class F>
  void for_each_edge(const Site& site, F&& f) {
    const SlabData& d = data(site.slab);
    for (const std::int32_t e : (*d.edges_at)[std::size_t(site.vertex)]) {
      const Outline::Edge& edge = outlines_[std::size_t(site.slab)].edges[std::size_t(e)];
      f(std::size_t(e), edge.a == site.vertex ? edge.b : edge.a);
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
  [[nodiscard]] static bool in_triangle(const GridPoint& p, const GridPoint& a, const GridPoint& b,
                                        const GridPoint& c) {
    const int turn = orientation(a, b, c);
    if (turn == 0) return segments_meet(p, p, a, b) || segments_meet(p, p, b, c) || segments_meet(p, p, c, a);
    return orientation(a, b, p) * turn >= 0 && orientation(b, c, p) * turn >= 0 && orientation(c, a, p) * turn >= 0;
  }
  /// Does the way of a vertex y meet what the piece uw sweeps over (the convex hull of its old and its new place)?
  [[nodiscard]] bool is_swept(std::int32_t y, std::int32_t u, std::int32_t w) const {
    const GridPoint corners[4] = {old_point(u), point(u), old_point(w), point(w)};
    const GridPoint &from = old_point(y), &to = point(y);
    if (std::max(from.x, to.x) < std::min({corners[0].x, corners[1].x, corners[2].x, corners[3].x})) return false;
    if (std::min(from.x, to.x) > std::max({corners[0].x, corners[1].x, corners[2].x, corners[3].x})) return false;
    if (std::max(from.y, to.y) < std::min({corners[0].y, corners[1].y, corners[2].y, corners[3].y})) return false;
    if (std::min(from.y, to.y) > std::max({corners[0].y, corners[1].y, corners[2].y, corners[3].y})) return false;
    for (std::size_t i = 0; i < 4; ++i) {
      if (in_triangle(from, corners[(i + 1) % 4], corners[(i + 2) % 4], corners[(i + 3) % 4])) return true;
      for (std::size_t k = i + 1; k < 4; ++k)
        if (segments_meet(from, to, corners[i], corners[k])) return true;
    }
    return false;
  }

  /// The edges that change in their planes, wherever the column goes.
  void find_changing() {
    if (!changing_.empty()) return;
    for (const std::int32_t c : columns_[taken_].group) {
      const Column& column = columns_[std::size_t(c)];
      for (const Site& site : column.sites)
        for_each_edge(site, [&](std::size_t e, std::int32_t) {
          for (const std::int32_t top : {0, 1}) changing_.push_back({site.slab, std::int32_t(e), top});
        });
      changing_.insert(changing_.end(), column.through.begin(), column.through.end());
    }
    std::sort(changing_.begin(), changing_.end());
    changing_.erase(std::unique(changing_.begin(), changing_.end()), changing_.end());
  }
  /// Does nothing get in the way of anything that moves, on any plane?
  [[nodiscard]] bool way_is_clear() {
    find_changing();
    return all_from(way_doubt_, changing_.size(), [&](std::size_t k) { return chain_is_clear(changing_[k]); });
  }
  [[nodiscard]] bool chain_is_clear(const Chain& own) {
    const std::size_t plane = plane_of(own.slab, own.top);
    vertices_of(own, own_);
    GridPoint low = point(own_.front()), high = low;
    std::int64_t way = 0;  // at least that of any of its vertices
    for (const std::int32_t v : own_) {
      if (moves(v)) way = std::max(way, std::int64_t(std::ceil(distance(old_point(v), point(v)))));
      for (const GridPoint& p : {old_point(v), point(v)}) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y)};
      }
    }
    // What is outside of this box neither comes near nor is in the way; chains are beside their edges.
    const auto margin = std::int64_t(std::ceil(kClearShare * eps_ + kBeside)) + 1;
    low = {low.x - margin, low.y - margin};
    high = {high.x + margin, high.y + margin};
    const auto pad = way + std::int64_t(std::ceil(reach())) + margin;
    const GridPoint from = point(own_.front()), to = point(own_.back());
    for (const std::int32_t top : {1, 0}) {
      const std::int32_t slab = top != 0 ? slabs_of_[plane].first : slabs_of_[plane].second;
      if (slab == kNone) continue;
      SlabData& other = data(slab);
      const Outline& outline = outlines_[std::size_t(slab)];
      ++other.search;
      const bool blocked = other.start->any_near(from, to, pad, [&](std::size_t f) {
        listen_();
        if (other.found[f] == other.search) return false;
        other.found[f] = other.search;
        const Chain c{slab, std::int32_t(f), top};
        if (c == own) return false;
        const GridPoint &u = outline.vertices[std::size_t(outline.edges[f].a)],
                        &w = outline.vertices[std::size_t(outline.edges[f].b)];  // before the move
        if (std::max(u.x, w.x) < low.x - way || std::min(u.x, w.x) > high.x + way) return false;
        if (std::max(u.y, w.y) < low.y - way || std::min(u.y, w.y) > high.y + way) return false;
        vertices_of(c, other_);
        return chains_collide() || chains_get_close();
      });
      if (blocked) return false;
    }
    return true;
  }
  /// Does a piece of `own_` that moves meet a piece of `other_`, or one of them pass over a vertex of the other? Exact.
  [[nodiscard]] bool chains_collide() const {
    for (std::size_t i = 1; i < own_.size(); ++i) {
      const std::int32_t u = own_[i - 1], w = own_[i];
      if (!moves(u) && !moves(w)) continue;
      for (std::size_t k = 0; k < other_.size(); ++k) {
        const std::int32_t y = other_[k];
        if (y != u && y != w && is_swept(y, u, w)) return true;
        if (k == 0) continue;
        const std::int32_t x = other_[k - 1];
        if (!pieces_agree(u, w, x, y)) return true;
        for (const std::int32_t v : {u, w})
          if (moves(v) && v != x && v != y && is_swept(v, x, y)) return true;
      }
    }
    return false;
  }
  /// Does a column of one of them get too near to an edge of the other?
  [[nodiscard]] bool chains_get_close() const { return gets_close(own_, other_) || gets_close(other_, own_); }
  [[nodiscard]] bool gets_close(const std::vector<std::int32_t>& columns,
                                const std::vector<std::int32_t>& chain) const {
    const double clearance = kClearShare * eps_;
    std::int32_t last = chain.front();
    for (std::size_t k = 1; k < chain.size(); ++k) {
      const std::int32_t v = chain[k];
      if (of(v) == kNone) continue;
      for (const std::int32_t y : columns) {
        if (of(y) == kNone || y == v || y == last || (!moves(y) && !moves(v) && !moves(last))) continue;
        const double now = segment_distance(point(y), point(last), point(v));
        if (now < clearance && now < segment_distance(old_point(y), old_point(last), old_point(v))) return true;
      }
      last = v;
    }
    return false;
  }

  /// What a sharp corner counts, 1 to 2; others nothing.
  [[nodiscard]] static double sharpness(const GridPoint& p, const GridPoint& a, const GridPoint& b) {
    const double degrees = std::fabs(std::atan2(double(cross(p, a, b)), double(dot(p, a, b)))) * (180 / kPi);
    return degrees < kSeparationAngle ? 2 - degrees / kSeparationAngle : 0;
  }
  /// Do corners between contours of neighboring slabs get no sharper in all?
  [[nodiscard]] bool corners_stay() {
    concerned_.clear();
    for (const std::int32_t c : columns_[taken_].group)
      concerned_.insert(concerned_.end(), corners_at_.begin() + std::ptrdiff_t(corner_start_[std::size_t(c)]),
                        corners_at_.begin() + std::ptrdiff_t(corner_start_[std::size_t(c) + 1]));
    std::sort(concerned_.begin(), concerned_.end());
    concerned_.erase(std::unique(concerned_.begin(), concerned_.end()), concerned_.end());
    double change = 0;
    for (const std::uint32_t i : concerned_) {
      const Corner& corner = corners_[i];
      const std::int32_t p = columns_[std::size_t(corner.at)].vertices.front(),
                         a = columns_[std::size_t(corner.a)].vertices.front(),
                         b = columns_[std::size_t(corner.b)].vertices.front();
      change += sharpness(point(p), point(a), point(b)) - sharpness(old_point(p), old_point(a), old_point(b));
    }
    return change <= 0;
  }
  /// Do vertices of straight walls stay on their lines?
  [[nodiscard]] bool walls_stay() const {
    const std::vector<std::int32_t>& group = columns_[taken_].group;
    for (std::size_t k = 0; k < group.size(); ++k)
      for (const Site& site : columns_[std::size_t(group[k])].sites) {
        const auto slab = std::size_t(site.slab), v = std::size_t(site.vertex);
        if (shape_[slab][v] != ContourShape::Straight) continue;
        const auto& [a, b] = line_[slab][v];
        if (line_distance(targets_[k], a, b) > kOnLine) return false;
      }
    return true;
  }
  /// Do slabs and slices stay near to each other, and their areas alike?
  [[nodiscard]] bool keeps_slices(Keep keep) {
    const std::vector<std::int32_t>& group = columns_[taken_].group;
    gains_.clear();
    if (group.size() == 1) {
      const std::vector<Site>& sites = columns_[taken_].sites;
      return all_from(slice_doubt_, sites.size(),
                      [&](std::size_t k) {
                        moved_sites_.assign(1, {sites[k], targets_.front()});
                        return keeps_slice(0, 1, keep);
                      }) &&
             keeps_volume(keep);
    }
    moved_sites_.clear();
    for (std::size_t k = 0; k < group.size(); ++k)
      for (const Site& site : columns_[std::size_t(group[k])].sites) moved_sites_.emplace_back(site, targets_[k]);
    std::sort(moved_sites_.begin(), moved_sites_.end(), [](const auto& a, const auto& b) {
      return std::tie(a.first.slab, a.first.vertex) < std::tie(b.first.slab, b.first.vertex);
    });
    for (std::size_t i = 0, k = 0; i < moved_sites_.size(); i = k) {
      for (k = i + 1; k < moved_sites_.size() && moved_sites_[k].first.slab == moved_sites_[i].first.slab;) ++k;
      if (!keeps_slice(i, k, keep)) return false;
    }
    return keeps_volume(keep);
  }
  /// Does the volume stay that of the slices, nearly, or come nearer to it? Needs `gains_`.
  [[nodiscard]] bool keeps_volume(Keep keep) {
    gain_ = 0;
    for (const auto& [slab, gain] : gains_) gain_ += heights_[std::size_t(slab)] * double(gain);
    const double now = std::fabs(excess_ + gain_);
    return keep == Keep::Angles || now <= std::max(std::fabs(excess_), most_excess_);
  }
  /// The same for moved_sites_[begin, end), which are of one slab.
  [[nodiscard]] bool keeps_slice(std::size_t begin, std::size_t end, Keep keep) {
    const std::int32_t slab = moved_sites_[begin].first.slab;
    SlabData& d = data(slab);
    const Outline& outline = outlines_[std::size_t(slab)];
    const auto moved_to = [&](std::int32_t v) -> const GridPoint* {
      for (std::size_t i = begin; i < end; ++i)
        if (moved_sites_[i].first.vertex == v) return &moved_sites_[i].second;
      return nullptr;
    };
    const NearnessLimits limits{kDeviationShare * eps_, d.most, kResolution};
    before_.clear();
    now_.clear();
    Int128 gain = 0;  // of twice the area
    for (std::size_t i = begin; i < end; ++i) {
      const auto& [site, to] = moved_sites_[i];
      const std::int32_t vertex = site.vertex;
      const GridPoint target = to;
      for_each_edge(site, [&](std::size_t e, std::int32_t far) {
        const GridPoint* far_to = moved_to(far);
        if (far_to != nullptr && far < vertex) return;  // once
        before_.emplace_back(site_point(slab, vertex), site_point(slab, far));
        now_.emplace_back(target, far_to != nullptr ? *far_to : site_point(slab, far));
        const Outline::Edge& edge = outline.edges[e];
        const int sides = (edge.left != kNone ? 1 : 0) - (edge.right != kNone ? 1 : 0);
        const auto term = [](const Segment& s) {
          return Int128(s.first.x) * s.second.y - Int128(s.first.y) * s.second.x;
        };
        gain += (edge.a == vertex ? sides : -sides) * (term(now_.back()) - term(before_.back()));
      });
    }
    const Int128 excess = d.excess + gain;
    const auto size = [](Int128 v) { return v < 0 ? -v : v; };
    if ((keep == Keep::Areas || keep == Keep::RoughAreas) && size(excess) > size(d.excess) &&
        size(excess) > (keep == Keep::Areas ? d.most_excess : d.rough_excess))
      return false;
    gains_.emplace_back(slab, gain);
    for (const Segment& edge : now_)
      if (!d.slice->is_near(edge, limits, &listen_)) return false;
    // Other edges of the contour that may be nearest to a part of the slice.
    const auto pad = std::int64_t(std::ceil(2 * d.most + reach())) + 1;
    const std::size_t own = now_.size();
    for (const Segment& edge : before_)
      d.start->for_each_near(edge.first, edge.second, pad, [&](std::size_t f) {
        const Outline::Edge& other = outline.edges[f];
        if (moved_to(other.a) != nullptr || moved_to(other.b) != nullptr) return;
        now_.emplace_back(outline.vertices[std::size_t(other.a)], outline.vertices[std::size_t(other.b)]);
      });
    std::sort(now_.begin() + std::ptrdiff_t(own), now_.end());
    now_.erase(std::unique(now_.begin() + std::ptrdiff_t(own), now_.end()), now_.end());
    if (now_.size() > kMostBeside) return false;
    return d.slice->stays_covered(before_, now_, limits, &listen_);
  }

  static constexpr std::size_t kPollEvery = 1 << 14;  // edges looked at
  static constexpr std::size_t kLargestGroup = 24;    // columns that move at once
  static constexpr std::size_t kMostBeside = 64;      // edges near a column; where there are more it stays, for time
  static constexpr double kReachShare = 1;            // of eps
  static constexpr double kClearShare = 0.45;         // of eps: what is nearer than this does not get nearer
  static constexpr double kDeviationShare = 0.985;    // of eps ...
  static constexpr double kAreaShare = 0.005;         // of eps, times the length of what is curved: of area
  static constexpr double kRoughAreaShare = 0.15;     // of eps, times the length of the contour: the same, roughly
  static constexpr double kVolumeShare = 3e-4;        // of the volume of the part: what all contours may add or take
  static constexpr double kResolution = 1.0 / 64;     // ... with half of this share more, still below eps

  const std::vector<Outline>& slices_;
  const PlaneStack& stack_;
  const std::vector<std::int32_t>& first_;
  const std::vector<GridPoint>& points_;
  const std::vector<std::int32_t>& gone_;
  Poll listen_;
  double eps_;                                                   // pitches
  std::vector<Outline> outlines_;                                // #S
  std::vector<std::vector<ContourShape>> shape_;                 // #S, by vertex
  std::vector<std::vector<std::array<GridPoint, 2>>> line_;      // #S, by vertex: its neighbors at first
  std::vector<char> touched_;                                    // #S
  std::vector<SlabData> slab_;                                   // #S
  std::vector<std::pair<std::int32_t, std::int32_t>> slabs_of_;  // #P: slab below, slab above
  std::vector<Column> columns_;
  std::vector<GridPoint> home_;          // of columns: where they were at first
  std::vector<std::int32_t> column_of_;  // #V
  std::vector<Corner> corners_;
  std::vector<std::uint32_t> corner_start_, corners_at_;  // of each column: those that it is part of

  // The column that was taken.
  std::size_t taken_ = 0;
  std::vector<GridPoint> old_;           // #V: where vertices were, of those with the stamp
  std::vector<std::uint32_t> stamp_of_;  // #V
  std::uint32_t stamp_ = 0;
  std::vector<std::pair<Split, double>> splits_;  // with their shares
  std::vector<double> shares_;                    // of its group
  std::vector<GridPoint> targets_;                // of its group
  std::vector<Chain> changing_;
  std::size_t way_doubt_ = 0, slice_doubt_ = 0;          // of changing_, of its sites: what was in the way last
  std::vector<std::int32_t> own_, other_;                // chains in question
  std::vector<std::pair<Site, GridPoint>> moved_sites_;  // and where they go
  std::vector<std::uint32_t> concerned_;                 // corners that change with it, each once
  std::vector<Segment> before_, now_;
  std::vector<std::pair<std::int32_t, Int128>> gains_;  // slabs, and twice the area that they gain
  double gain_ = 0;                                     // the same times their heights, all together

  // Of the volume, doubled, in squared pitches times mm.
  std::vector<double> heights_;  // #S, mm
  double excess_ = 0;            // between contours and slices ...
  double most_excess_ = 0;       // ... which a move may not bring above this, either way
};

}  // namespace slice2mesh::detail
