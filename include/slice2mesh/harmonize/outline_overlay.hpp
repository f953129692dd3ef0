// SPDX-License-Identifier: MIT
/// @file
/// @brief Two outlines laid over each other: where they differ, and how a new outline is put together of both.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numeric>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/faces.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/arrange/segment_index.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/progress.hpp"

namespace slice2mesh::detail {

/// Union-find with path halving.
class DisjointSets {
public:
  explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  [[nodiscard]] std::int32_t find(std::int32_t i) {
    while (parent_[std::size_t(i)] != i) i = parent_[std::size_t(i)] = parent_[std::size_t(parent_[std::size_t(i)])];
    return i;
  }
  void unite(std::int32_t i, std::int32_t j) {
    i = find(i);
    j = find(j);
    if (i != j) parent_[std::size_t(std::max(i, j))] = std::min(i, j);
  }

private:
  std::vector<std::int32_t> parent_;
};

/// A piece of the outline that is being put together. `parent`: an edge of the other outline (0 and up), an edge of
/// the own one (count of the former and up), or kNone for a cut across a pocket.
struct OutlinePiece {
  std::int32_t a, b, left, right, parent;
};

/// Joins pieces of the same parent with the same regions over vertices that nothing else uses, so that edges which were
/// split on the way are whole again. `keep` (#V): vertices that stay.
inline std::vector<OutlinePiece> join_pieces(const std::vector<OutlinePiece>& pieces, const std::vector<char>& keep,
                                             const std::function<void()>& poll = {}) {
  Poll listen(poll, 1 << 14);
  const std::size_t vertices = keep.size();
  std::vector<std::array<std::int32_t, 2>> at(vertices, {kNone, kNone});
  std::vector<std::int32_t> degree(vertices, 0);
  for (std::size_t p = 0; p < pieces.size(); ++p)
    for (const std::int32_t v : {pieces[p].a, pieces[p].b}) {
      listen();
      const std::int32_t d = degree[std::size_t(v)]++;
      if (d < 2) at[std::size_t(v)][std::size_t(d)] = std::int32_t(p);
    }
  const auto passes = [&](std::int32_t v) {
    if (degree[std::size_t(v)] != 2 || keep[std::size_t(v)]) return false;
    const OutlinePiece &p = pieces[std::size_t(at[std::size_t(v)][0])], &q = pieces[std::size_t(at[std::size_t(v)][1])];
    if (p.parent != q.parent || p.parent == kNone) return false;
    const bool same_way = (p.b == v) == (q.a == v);
    return same_way ? (p.left == q.left && p.right == q.right) : (p.left == q.right && p.right == q.left);
  };
  std::vector<char> done(pieces.size(), 0);
  std::vector<OutlinePiece> result;
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    if (done[p]) continue;
    done[p] = 1;
    OutlinePiece joined = pieces[p];
    const auto extend = [&](std::int32_t v) {
      std::int32_t from = std::int32_t(p);
      while (passes(v)) {
        listen();
        const auto& both = at[std::size_t(v)];
        const std::int32_t next = both[0] == from ? both[1] : both[0];
        if (done[std::size_t(next)]) break;
        done[std::size_t(next)] = 1;
        v = pieces[std::size_t(next)].a == v ? pieces[std::size_t(next)].b : pieces[std::size_t(next)].a;
        from = next;
      }
      return v;
    };
    joined.b = extend(joined.b);
    joined.a = extend(joined.a);
    result.push_back(joined);
  }
  return result;
}

/// Which of the `points` are among `others`?
[[nodiscard]] inline std::vector<char> are_among(const std::vector<GridPoint>& points, std::vector<GridPoint> others,
                                                 Poll& listen) {
  sort_listening(others.begin(), others.end(), listen);
  std::vector<char> result(points.size(), 0);
  for (std::size_t v = 0; v < result.size(); ++v) {
    listen(16);
    result[v] = std::binary_search(others.begin(), others.end(), points[v]);
  }
  return result;
}

/// The arrangement of an outline and another one, with the regions of its faces in both. Faces where these differ are
/// joined to pockets over their common edges.
struct OutlineOverlay {
  /// `regions`: how many there are. The own outline is led through vertices of the other one that are within `attach`
  /// (pitches) of it, if no edge of the other one is equal, but not from two sides: a needle or a gap of its own would
  /// vanish from there on. `own_index` is that of `own`. `poll` is called now and then.
  OutlineOverlay(const Outline& own, const SegmentIndex& own_index, const Outline& other, std::int32_t regions,
                 double attach, const std::function<void()>& poll)
      : arrangement(snap_round(segments_of(own, other, regions),
                               attachment_of(own, own_index, other, regions, attach, poll), poll)),
        faces(find_faces(arrangement, poll)), own_label(faces.windings.size(), kNone),
        other_label(faces.windings.size(), kNone), parent(arrangement.edges.size(), kNone) {
    Poll listen(poll, 1 << 14);  // items looked at
    find_labels(regions, listen);
    find_pockets(listen);
    find_parents(own, other, listen);
  }

  Arrangement arrangement;
  ArrangementFaces faces;
  std::vector<std::int32_t> own_label, other_label;  ///< of each face: its region in the outlines, or kNone
  /// Of each edge: the edge of the other outline (0 and up) that it is part of, or else of the own one (count of the
  /// former and up).
  std::vector<std::int32_t> parent;

  /// Is a face in different regions?
  [[nodiscard]] bool differs(std::int32_t f) const { return own_label[std::size_t(f)] != other_label[std::size_t(f)]; }
  /// The pocket of a face that differs: one of its faces, the same one for all of them.
  [[nodiscard]] std::int32_t pocket(std::int32_t f) const { return pocket_[std::size_t(f)]; }
  [[nodiscard]] bool is_own_edge(std::size_t e) const { return separates(own_label, e); }
  [[nodiscard]] bool is_other_edge(std::size_t e) const { return separates(other_label, e); }

private:
  [[nodiscard]] bool separates(const std::vector<std::int32_t>& label, std::size_t e) const {
    return label[std::size_t(faces.of_edge[e][0])] != label[std::size_t(faces.of_edge[e][1])];
  }
  [[nodiscard]] static std::vector<TaggedSegment> segments_of(const Outline& own, const Outline& other,
                                                              std::int32_t regions) {
    std::vector<TaggedSegment> segments;
    append_segments(own, 0, segments);
    append_segments(other, regions, segments);
    return segments;
  }
  [[nodiscard]] static Attachment attachment_of(const Outline& own, const SegmentIndex& own_index, const Outline& other,
                                                std::int32_t regions, double attach,
                                                const std::function<void()>& poll) {
    Attachment attachment;
    attachment.near = kAttachSteps * double(kContourStep);
    Poll listen(poll, 1 << 14);
    std::vector<std::size_t> beside;
    for (const GridPoint& p : other.vertices) {
      listen();
      if (!is_between(own, own_index, p, attach, beside, listen)) attachment.strong.push_back(p);
    }
    attachment.strong_near = attach;
    attachment.strong_tags = regions;
    return attachment;
  }
  /// Is a point within `attach` of two edges that are not connected beside it? `beside` is working space.
  [[nodiscard]] static bool is_between(const Outline& own, const SegmentIndex& index, const GridPoint& p, double attach,
                                       std::vector<std::size_t>& beside, Poll& listen) {
    constexpr double kConnected = 2.5;  // times the distance: with that of open_difference, the width that it opens
    beside.clear();
    const double around = kConnected * attach;
    index.for_each_near(p, p, std::int64_t(std::ceil(around)), [&](std::size_t e) {
      listen();
      if (index.distance_to(e, p) <= around) beside.push_back(e);
    });
    std::sort(beside.begin(), beside.end());
    beside.erase(std::unique(beside.begin(), beside.end()), beside.end());
    if (beside.size() < 2) return false;
    listen(4 * beside.size());
    std::vector<std::pair<std::int32_t, std::int32_t>> ends;  // vertex beside the point, which of the edges
    for (std::size_t i = 0; i < beside.size(); ++i)
      for (const std::int32_t v : {own.edges[beside[i]].a, own.edges[beside[i]].b})
        if (distance(own.vertices[std::size_t(v)], p) <= around) ends.emplace_back(v, std::int32_t(i));
    std::sort(ends.begin(), ends.end());
    DisjointSets sets(beside.size());
    for (std::size_t i = 1; i < ends.size(); ++i)
      if (ends[i].first == ends[i - 1].first) sets.unite(ends[i].second, ends[i - 1].second);
    std::int32_t first = kNone;
    for (std::size_t i = 0; i < beside.size(); ++i) {
      if (index.distance_to(beside[i], p) > attach) continue;
      if (first == kNone) first = std::int32_t(i);
      if (sets.find(std::int32_t(i)) != sets.find(first)) return true;
    }
    return false;
  }
  void find_labels(std::int32_t regions, Poll& listen) {
    for (std::size_t f = 0; f < faces.windings.size(); ++f) {
      listen(faces.windings[f].size() + 1);
      for (const EdgeTag& tag : faces.windings[f]) {
        if (tag.winding <= 0) continue;
        std::int32_t& label = tag.tag < regions ? own_label[f] : other_label[f];
        const std::int32_t region = tag.tag < regions ? tag.tag : tag.tag - regions;
        if (label == kNone || region < label) label = region;
      }
    }
  }
  void find_pockets(Poll& listen) {
    DisjointSets sets(faces.windings.size());
    for (const auto& sides : faces.of_edge) {
      listen();
      if (differs(sides[0]) && differs(sides[1])) sets.unite(sides[0], sides[1]);
    }
    pocket_.resize(faces.windings.size());
    for (std::size_t f = 0; f < pocket_.size(); ++f) pocket_[f] = sets.find(std::int32_t(f));
  }
  void find_parents(const Outline& own, const Outline& other, Poll& listen) {
    std::vector<std::size_t> first_edge(arrangement.vertices.size() + 1, 0);  // by the smaller end; edges are sorted
    for (const Arrangement::Edge& e : arrangement.edges) ++first_edge[std::size_t(e.a) + 1];
    for (std::size_t v = 1; v < first_edge.size(); ++v) first_edge[v] += first_edge[v - 1];
    const auto edge_between = [&](std::int32_t a, std::int32_t b) {
      std::size_t e = first_edge[std::size_t(std::min(a, b))];
      while (arrangement.edges[e].b != std::max(a, b)) ++e;
      return e;
    };
    std::size_t segment = 0;
    const auto walk = [&](const Outline& outline, std::int32_t first, bool override_parent) {
      for (std::size_t e = 0; e < outline.edges.size(); ++e) {
        const int count = (outline.edges[e].left != kNone) + (outline.edges[e].right != kNone);
        const std::vector<std::int32_t> path = arrangement.path(segment);
        listen(4 * path.size());
        for (std::size_t i = 0; i + 1 < path.size(); ++i) {
          std::int32_t& slot = parent[edge_between(path[i], path[i + 1])];
          if (override_parent || slot == kNone) slot = first + std::int32_t(e);
        }
        segment += std::size_t(count);
      }
    };
    walk(own, std::int32_t(other.edges.size()), false);
    walk(other, 0, true);
  }
  std::vector<std::int32_t> pocket_;  // of each face
};

}  // namespace slice2mesh::detail
