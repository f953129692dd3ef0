// SPDX-License-Identifier: MIT
/// @file
/// @brief Splits of long contour edges, at places that contours of neighboring slabs have in common.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/arrange/segment_index.hpp"
#include "slice2mesh/arrange/size_field.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/core/slab.hpp"
#include "slice2mesh/harmonize/attach.hpp"

namespace slice2mesh::detail {

/// Which ends of the edges (#E by 2) have another edge at a sharp angle beside them, one that is not so sharp that the
/// grid cannot tell the edges apart.
[[nodiscard]] inline std::vector<std::array<char, 2>> sharp_ends(const Outline& outline, Poll& listen) {
  constexpr double kSharp = 0.94;              // cosine of 20 degrees
  constexpr double kSharpest = 1.0 / 1048576;  // sine; the share of the extent that is kSmallestEps
  struct End {
    std::int32_t vertex;
    double angle, x, y;  // of the direction
    std::size_t edge, side;
    bool operator<(const End& o) const { return vertex != o.vertex ? vertex < o.vertex : angle < o.angle; }
  };
  std::vector<End> ends;
  ends.reserve(2 * outline.edges.size());
  for (std::size_t e = 0; e < outline.edges.size(); ++e) {
    listen(4);
    const GridPoint &a = outline.vertices[std::size_t(outline.edges[e].a)],
                    &b = outline.vertices[std::size_t(outline.edges[e].b)];
    const double x = double(b.x - a.x), y = double(b.y - a.y), length = std::hypot(x, y);
    ends.push_back({outline.edges[e].a, std::atan2(y, x), x / length, y / length, e, 0});
    ends.push_back({outline.edges[e].b, std::atan2(-y, -x), -x / length, -y / length, e, 1});
  }
  sort_listening(ends.begin(), ends.end(), listen);
  std::vector<std::array<char, 2>> sharp(outline.edges.size(), {0, 0});
  for (std::size_t i = 0; i < ends.size();) {
    std::size_t j = i + 1;
    while (j < ends.size() && ends[j].vertex == ends[i].vertex) ++j;
    listen(j - i);
    for (std::size_t k = i; j - i > 1 && k < j; ++k) {
      const End &p = ends[k], &q = ends[k + 1 < j ? k + 1 : i];
      if (p.x * q.x + p.y * q.y > kSharp && std::fabs(p.x * q.y - p.y * q.x) > kSharpest)
        sharp[p.edge][p.side] = sharp[q.edge][q.side] = 1;
    }
    i = j;
  }
  return sharp;
}

/// Splits edges longer than `longest_of(a, b)` pitches (about) where they cross lines x = k step or y = k step,
/// whichever they cross more steeply. The lines are the same for all slabs: contours that stand above each other, or
/// run side by side, are split at the same places. From a sharp corner on, both of its edges are split at the same
/// distances from it: else each split would call for one opposite to it, and in a fan of n edges each of them for n. No
/// split is so near to another edge that an overlay would take it to lie there: the tip of a region beyond it would
/// vanish.
template <class Longest, class Accept>
void subdivide_by(Outline& outline, Longest&& longest_of, Accept&& accept, const std::function<void()>& poll) {
  constexpr double kSteep = 0.95;  // cosine with an axis; less steep edges are longer between two lines
  constexpr double kStraight = 0.9, kDiagonal = 0.68;  // so their lines are nearer; of the longest edge
  constexpr double kFromEnds = 0.4;                    // of the step; no split nearer to an end
  const std::size_t old_vertices = outline.vertices.size();
  std::vector<Outline::Edge> edges;
  std::vector<GridPoint> splits, points;
  Poll listen(poll, 1 << 14);
  const std::vector<std::array<char, 2>> sharp = sharp_ends(outline, listen);
  for (std::size_t index = 0; index < outline.edges.size(); ++index) {
    const Outline::Edge& e = outline.edges[index];
    const GridPoint a = outline.vertices[static_cast<std::size_t>(e.a)],
                    b = outline.vertices[static_cast<std::size_t>(e.b)];
    const double length = distance(a, b), longest = longest_of(a, b);
    splits.clear();
    const auto [sharp_a, sharp_b] = sharp[index];
    if (length > longest && (sharp_a || sharp_b)) {
      const double step = kStraight * longest, free = kFromEnds * step;
      const double from_a = sharp_a ? (sharp_b ? (length - free) / 2 : length - free) : 0;
      const double from_b = sharp_b ? (sharp_a ? (length - free) / 2 : length - free) : 0;
      for (std::int64_t k = 1; double(k) * step <= from_a; ++k)
        splits.push_back(contour_point_between(a, b, double(k) * step / length));
      const std::size_t count = splits.size();
      for (std::int64_t k = 1; double(k) * step <= from_b; ++k)
        splits.push_back(contour_point_between(b, a, double(k) * step / length));
      std::reverse(splits.begin() + std::ptrdiff_t(count), splits.end());
    } else if (length > longest) {
      const bool along_x = std::llabs(b.x - a.x) >= std::llabs(b.y - a.y);
      const std::int64_t from = along_x ? a.x : a.y, to = along_x ? b.x : b.y;
      const double share = std::fabs(double(to - from)) / length;
      const std::int64_t step = round_to_step(std::llround(longest * (share > kSteep ? kStraight : kDiagonal)));
      const auto first = static_cast<std::int64_t>(floor_div(std::min(from, to), step)) + 1,
                 last = static_cast<std::int64_t>(floor_div(std::max(from, to), step));
      for (std::int64_t k = first; k <= last; ++k) {
        const GridPoint p = contour_point_between(a, b, double(k * step - from) / double(to - from));
        if (std::min(distance(a, p), distance(p, b)) >= kFromEnds * double(step)) splits.push_back(p);
      }
      if (from > to) std::reverse(splits.begin(), splits.end());
    }
    // Where the last line is far from an end, or there is none, the rest is halved.
    points.assign(1, a);
    splits.push_back(b);
    for (const GridPoint& p : splits) {
      const GridPoint q = points.back();
      const auto count = static_cast<std::int64_t>(std::ceil(distance(q, p) / longest));
      listen(static_cast<std::size_t>(count));
      for (std::int64_t i = 1; i < count; ++i) points.push_back(contour_point_between(q, p, double(i) / double(count)));
      points.push_back(p);
    }
    std::int32_t last_vertex = e.a;
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
      listen();
      if (!accept(points[i])) continue;
      outline.vertices.push_back(points[i]);
      const auto v = static_cast<std::int32_t>(outline.vertices.size()) - 1;
      edges.push_back({last_vertex, v, e.left, e.right});
      last_vertex = v;
    }
    edges.push_back({last_vertex, e.b, e.left, e.right});
  }
  outline.edges = std::move(edges);
  const std::vector<std::int32_t> beside = vertices_beside_edges(outline, kBeside, poll, old_vertices, EdgeEnds::With);
  if (beside.empty()) return;
  edges.clear();
  for (const Outline::Edge& e : outline.edges) {
    // Pieces of one edge follow each other.
    if (std::binary_search(beside.begin(), beside.end(), e.a))
      edges.back().b = e.b;
    else
      edges.push_back(e);
  }
  outline.edges = std::move(edges);
  normalize(outline, poll);
}

/// The same with one length for all edges.
inline void subdivide(Outline& outline, double longest, const std::function<void()>& poll = {}) {
  if (!(longest >= 4 * kBeside) || !(longest < double(kGridLimit))) return;
  const auto longest_of = [&](const GridPoint&, const GridPoint&) { return longest; };
  subdivide_by(
      outline, longest_of, [](const GridPoint&) { return true; }, poll);
}

/// Where a vertex may be put beside the contour of a neighboring slab.
class Neighborhood {
public:
  Neighborhood(const Outline& outline, double clearance, Poll& listen)
      : clearance_(clearance), edges_(outline, &listen), vertices_(points_of(outline), &listen) {}
  /// Is it a vertex there, or on an edge and away from the vertices, or away from both?
  [[nodiscard]] bool is_clear(const GridPoint& p, Poll& listen) const {
    const double from_vertex = vertices_.distance(p, clearance_, &listen);
    if (from_vertex == 0) return true;
    if (from_vertex < clearance_) return false;
    const double from_edge = edges_.distance(p, clearance_, &listen);
    return from_edge >= clearance_ || from_edge <= kAttachSteps * double(kContourStep);
  }

private:
  static std::vector<std::pair<GridPoint, GridPoint>> points_of(const Outline& outline) {
    std::vector<std::pair<GridPoint, GridPoint>> points;
    points.reserve(outline.vertices.size());
    for (const GridPoint& p : outline.vertices) points.emplace_back(p, p);
    return points;
  }
  double clearance_;
  SegmentIndex edges_, vertices_;
};

/// Splits the edges of all contours where sizes are below `longest`, as `subdivide` does, with that or a half, a
/// quarter, and so on of it: the lines of some are lines of the others. No new vertex comes nearer to a vertex or an
/// edge of the next slab than `clearance`. All in pitches.
inline void subdivide_by_field(std::vector<Outline>& outlines, const std::vector<Slab>& slabs, double longest,
                               double clearance, const SizeField& field, const std::function<void()>& poll) {
  if (!(longest >= 4 * kBeside) || !(longest < double(kGridLimit))) return;
  Poll listen(poll, 1 << 14);
  for (std::size_t s = 0; s < outlines.size(); ++s) {
    poll();
    std::vector<Neighborhood> next;
    if (lies_on_last(slabs, s)) next.emplace_back(outlines[s - 1], clearance, listen);
    if (s + 1 < outlines.size() && lies_on_last(slabs, s + 1)) next.emplace_back(outlines[s + 1], clearance, listen);
    const double z = (slabs[s].z_low + slabs[s].z_high) / 2;
    const auto longest_of = [&](const GridPoint& a, const GridPoint& b) {
      const double wanted = std::min({field.wanted_at(a, z), field.wanted_at(b, z),
                                      field.wanted_at(double(a.x + b.x) / 2, double(a.y + b.y) / 2, z)});
      double size = longest;
      while (size > wanted && size >= 8 * kBeside) size /= 2;
      return size;
    };
    const auto accept = [&](const GridPoint& p) {
      return std::all_of(next.begin(), next.end(), [&](const Neighborhood& n) { return n.is_clear(p, listen); });
    };
    subdivide_by(outlines[s], longest_of, accept, poll);
    normalize(outlines[s], poll);
  }
}

}  // namespace slice2mesh::detail
