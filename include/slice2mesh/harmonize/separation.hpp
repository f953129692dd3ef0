// SPDX-License-Identifier: MIT
/// @file
/// @brief How near contours come to each other and to themselves: what harmonization has left, measured.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/arrange/snap_rounding.hpp"
#include "slice2mesh/core/diagnostics.hpp"
#include "slice2mesh/core/short_number.hpp"
#include "slice2mesh/harmonize/harmonize.hpp"
#include "slice2mesh/harmonize/separation_report.hpp"
#include "slice2mesh/lift/lift.hpp"
#include "slice2mesh/regions/thicken.hpp"

namespace slice2mesh {

namespace detail {

/// The size of a place in words, "0.01 mm at 1, 2, 3".
[[nodiscard]] inline std::string separation_text(const SeparationMinimum& minimum, const char* unit) {
  std::string text = short_number(minimum.size) + unit + " at ";
  for (std::size_t i = 0; i < 3; ++i) text += (i > 0 ? ", " : "") + short_number(minimum.at[i]);
  return text;
}

/// Adds what was found elsewhere. The first of equal minima stays.
inline void add_figures(SeparationFigures& sum, const SeparationFigures& part) {
  const auto smaller = [](SeparationMinimum& a, const SeparationMinimum& b) {
    if (b.size < a.size) a = b;
  };
  smaller(sum.vertices, part.vertices);
  smaller(sum.vertex_edge, part.vertex_edge);
  smaller(sum.angle, part.angle);
  for (std::size_t i = 0; i < kSeparationShares.size(); ++i) {
    sum.close_vertices[i] += part.close_vertices[i];
    sum.close_vertex_edge[i] += part.close_vertex_edge[i];
  }
  sum.sharp += part.sharp;
}

/// A vertex or an edge of an outline; neither: not on that contour.
struct OutlineItem {
  std::int32_t vertex = kNone;
  std::int32_t edge = kNone;
  [[nodiscard]] bool on() const { return vertex != kNone || edge != kNone; }
};

/// Do two places of one contour belong to different features of it, so that it is the contour itself which is narrow
/// between them? Not so for two places on one edge, nor on edges that meet at a wide angle.
[[nodiscard]] inline bool are_apart(const Outline& outline, const OutlineItem& p, const OutlineItem& q) {
  if (p.vertex != kNone && q.vertex != kNone) return true;
  const auto ends_in = [&](std::int32_t edge, std::int32_t vertex) {
    const Outline::Edge& e = outline.edges[std::size_t(edge)];
    return e.a == vertex || e.b == vertex;
  };
  if (p.vertex != kNone) return !ends_in(q.edge, p.vertex);
  if (q.vertex != kNone) return !ends_in(p.edge, q.vertex);
  if (p.edge == q.edge) return false;
  const Outline::Edge &e = outline.edges[std::size_t(p.edge)], &f = outline.edges[std::size_t(q.edge)];
  const bool at_a = ends_in(q.edge, e.a), at_b = ends_in(q.edge, e.b);
  if (!at_a && !at_b) return true;
  const std::int32_t common = at_a ? e.a : e.b;
  const GridPoint &o = outline.vertices[std::size_t(common)], &a = outline.vertices[std::size_t(at_a ? e.b : e.a)],
                  &b = outline.vertices[std::size_t(f.a == common ? f.b : f.a)];
  return std::atan2(std::fabs(double(cross(o, a, b))), double(dot(o, a, b))) * (180 / kPi) < kSeparationAngle;
}

/// Calls pair(v, w, distance) once for all two vertices and near(v, e, distance) for a vertex and an edge that does not
/// end in it and whose nearest point is inside of it, for all that are nearer than `limit` pitches. Edges have members
/// a and b. `poll` is called now and then. Cost: linear where contours are evenly sampled.
template <class Edges, class Pair, class Near>
void for_each_close(const std::vector<GridPoint>& vertices, const Edges& edges, double limit, Pair&& pair, Near&& near,
                    const std::function<void()>& poll) {
  if (vertices.empty()) return;
  Poll listen(poll, 1 << 16);
  GridPoint low = vertices.front(), high = low;
  for (const GridPoint& p : vertices) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  // Finer than one bucket per item: contours are curves and leave most of the box empty.
  constexpr std::size_t kBucketsPerEdge = 8;
  const Buckets buckets(low, high, kBucketsPerEdge * edges.size());
  const auto pad = static_cast<std::int64_t>(std::ceil(limit));
  std::vector<std::uint32_t> start(buckets.size() + 1, 0);
  for (const GridPoint& p : vertices) {
    listen();
    ++start[buckets.of(p) + 1];
  }
  for (std::size_t c = 1; c < start.size(); ++c) start[c] += start[c - 1];
  std::vector<std::int32_t> items(vertices.size());
  {
    std::vector<std::uint32_t> next(start.begin(), start.end() - 1);
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      listen();
      items[next[buckets.of(vertices[v])]++] = std::int32_t(v);
    }
  }
  for (std::size_t v = 0; v < vertices.size(); ++v)
    buckets.for_each_on(vertices[v], vertices[v], pad, [&](std::size_t cell) {
      listen(start[cell + 1] - start[cell] + 1);
      for (std::uint32_t i = start[cell]; i < start[cell + 1]; ++i) {
        const auto w = std::size_t(items[i]);
        if (w <= v) continue;
        const double d = distance(vertices[v], vertices[w]);
        if (d < limit) pair(v, w, d);
      }
    });
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const GridPoint &a = vertices[std::size_t(edges[e].a)], &b = vertices[std::size_t(edges[e].b)];
    buckets.for_each_on(a, b, pad, [&](std::size_t cell) {
      listen(start[cell + 1] - start[cell] + 1);
      for (std::uint32_t i = start[cell]; i < start[cell + 1]; ++i) {
        const std::int32_t v = items[i];
        if (v == edges[e].a || v == edges[e].b) continue;
        const GridPoint& p = vertices[std::size_t(v)];
        const double d = segment_distance(p, a, b);
        if (d < limit && dot(a, p, b) > 0 && dot(b, p, a) > 0) near(std::size_t(v), e, d);
      }
    });
  }
}

/// Calls corner(v, e, f, degrees) for all edges e and f that follow each other around a vertex v. `poll` is called now
/// and then. Cost: O(n log n).
template <class Edges, class Corner>
void for_each_corner(const std::vector<GridPoint>& vertices, const Edges& edges, Corner&& corner,
                     const std::function<void()>& poll) {
  Poll listen(poll, 1 << 16);
  std::vector<std::uint32_t> start(vertices.size() + 1, 0);
  for (const auto& e : edges) {
    listen();
    for (const std::int32_t v : {e.a, e.b}) ++start[std::size_t(v) + 1];
  }
  for (std::size_t v = 1; v < start.size(); ++v) start[v] += start[v - 1];
  std::vector<std::size_t> at(start.back());
  {
    std::vector<std::uint32_t> next(start.begin(), start.end() - 1);
    for (std::size_t e = 0; e < edges.size(); ++e) {
      listen();
      for (const std::int32_t v : {edges[e].a, edges[e].b}) at[next[std::size_t(v)]++] = e;
    }
  }
  struct Direction {
    double angle;
    std::size_t edge;
  };
  std::vector<Direction> around;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    around.clear();
    listen(start[v + 1] - start[v] + 1);
    for (std::uint32_t i = start[v]; i < start[v + 1]; ++i) {
      const auto& e = edges[at[i]];
      const GridPoint& q = vertices[std::size_t(e.a == std::int32_t(v) ? e.b : e.a)];
      around.push_back({std::atan2(double(q.y - vertices[v].y), double(q.x - vertices[v].x)), at[i]});
    }
    if (around.size() < 2) continue;
    std::sort(around.begin(), around.end(), [](const Direction& a, const Direction& b) { return a.angle < b.angle; });
    for (std::size_t i = 0; i < around.size(); ++i) {
      const bool last = i + 1 == around.size();
      const double turn = last ? around[0].angle + 2 * kPi - around[i].angle : around[i + 1].angle - around[i].angle;
      corner(v, around[i].edge, around[last ? 0 : i + 1].edge, turn * (180 / kPi));
    }
  }
}

/// Puts pairs and angles into figures.
struct SeparationCollector {
  const Grid& grid;
  double tolerance;  // mm
  double z;
  std::int32_t plane, slab_below, slab_above;
  SeparationFigures figures;

  void smallest(SeparationMinimum& minimum, double size, const GridPoint& p) const {
    if (size < minimum.size) minimum = {size, {grid.x_mm(p), grid.y_mm(p), z}, plane, slab_below, slab_above};
  }
  void count(std::array<std::uint64_t, kSeparationShares.size()>& counts, double mm) const {
    for (std::size_t i = 0; i < kSeparationShares.size(); ++i)
      if (mm < kSeparationShares[i] * tolerance) ++counts[i];
  }
  void vertices(double pitches, const GridPoint& p) {
    smallest(figures.vertices, pitches * grid.pitch, p);
    count(figures.close_vertices, pitches * grid.pitch);
  }
  void vertex_edge(double pitches, const GridPoint& p) {
    smallest(figures.vertex_edge, pitches * grid.pitch, p);
    count(figures.close_vertex_edge, pitches * grid.pitch);
  }
  void angle(double degrees, const GridPoint& p) {
    if (degrees > 180) return;
    smallest(figures.angle, degrees, p);
    if (degrees < kSeparationAngle) ++figures.sharp;
  }
};

/// The figures of one outline by itself. `plane`: that of the bottom of the slab.
[[nodiscard]] inline SeparationFigures separation_within(const Contours& contours, std::int32_t slab,
                                                         std::int32_t plane, const std::function<void()>& poll) {
  const Outline& outline = contours.outlines[std::size_t(slab)];
  SeparationCollector collector{
      contours.grid, contours.tolerance, contours.slabs[std::size_t(slab)].z_low, plane, slab, slab, {}};
  for_each_close(
      outline.vertices, outline.edges, contours.tolerance / contours.grid.pitch,
      [&](std::size_t v, std::size_t, double d) { collector.vertices(d, outline.vertices[v]); },
      [&](std::size_t v, std::size_t, double d) { collector.vertex_edge(d, outline.vertices[v]); }, poll);
  for_each_corner(
      outline.vertices, outline.edges,
      [&](std::size_t v, std::size_t, std::size_t, double degrees) { collector.angle(degrees, outline.vertices[v]); },
      poll);
  return collector.figures;
}

[[nodiscard]] inline bool same_lines(const Outline& a, const Outline& b) {
  if (a.vertices != b.vertices || a.edges.size() != b.edges.size()) return false;
  for (std::size_t e = 0; e < a.edges.size(); ++e)
    if (a.edges[e].a != b.edges[e].a || a.edges[e].b != b.edges[e].b) return false;
  return true;
}

}  // namespace detail

/// The figures between the two contours of one plane: of the pairs in its overlay, crossings and splits included, that
/// neither contour makes by itself. A pair is a contour's own if both are vertices of that contour, or lie on parts of
/// it that are not next to each other; two edges that meet at a vertex, if both are of that contour.
/// `plane_index`, the index of the plane from the lowest one, is for the places found. Needs overlay, images and paths
/// of the plane alone. Cost: O(n log n).
[[nodiscard]] inline SeparationFigures separation_between(const Contours& contours, const InterfacePlane& plane,
                                                          std::int32_t plane_index,
                                                          const std::function<void()>& poll = {}) {
  using detail::OutlineItem;
  const Arrangement& overlay = plane.overlay;
  detail::SeparationCollector collector{contours.grid,    contours.tolerance, plane.z, plane_index,
                                        plane.slab_below, plane.slab_above,   {}};
  if (plane.slab_below == kNone || plane.slab_above == kNone) return collector.figures;
  const std::array<const Outline*, 2> outlines{&contours.outlines[std::size_t(plane.slab_below)],
                                               &contours.outlines[std::size_t(plane.slab_above)]};
  detail::Poll listen(poll, 1 << 16);
  // Where vertices and edges of the overlay are on the two contours.
  std::vector<std::array<OutlineItem, 2>> of_vertex(overlay.vertices.size());
  std::vector<std::array<std::int32_t, 2>> of_edge(overlay.edges.size(), {kNone, kNone});
  const auto edge_of = [&](std::int32_t a, std::int32_t b) {
    if (a > b) std::swap(a, b);
    const auto at = std::lower_bound(overlay.edges.begin(), overlay.edges.end(), std::pair(a, b),
                                     [](const Arrangement::Edge& e, const auto& key) {
                                       return e.a != key.first ? e.a < key.first : e.b < key.second;
                                     });
    return std::size_t(at - overlay.edges.begin());
  };
  for (std::size_t c = 0; c < 2; ++c) {
    const auto& paths = c == 0 ? plane.below_path : plane.above_path;
    const auto& images = c == 0 ? plane.below_image : plane.above_image;
    for (std::size_t e = 0; e < paths.size(); ++e)
      for (std::size_t i = 0; i < paths[e].size(); ++i) {
        listen();
        of_vertex[std::size_t(paths[e][i])][c].edge = std::int32_t(e);
        if (i > 0) of_edge[edge_of(paths[e][i - 1], paths[e][i])][c] = std::int32_t(e);
      }
    for (std::size_t v = 0; v < images.size(); ++v)
      if (images[v] != kNone) of_vertex[std::size_t(images[v])][c].vertex = std::int32_t(v);
  }
  const auto own = [&](const std::array<OutlineItem, 2>& p, const std::array<OutlineItem, 2>& q) {
    for (std::size_t c = 0; c < 2; ++c)
      if (p[c].on() && q[c].on() && detail::are_apart(*outlines[c], p[c], q[c])) return true;
    return false;
  };
  detail::for_each_close(
      overlay.vertices, overlay.edges, contours.tolerance / contours.grid.pitch,
      [&](std::size_t v, std::size_t w, double d) {
        if (!own(of_vertex[v], of_vertex[w])) collector.vertices(d, overlay.vertices[v]);
      },
      [&](std::size_t v, std::size_t e, double d) {
        const std::array<OutlineItem, 2> item{OutlineItem{kNone, of_edge[e][0]}, OutlineItem{kNone, of_edge[e][1]}};
        if (!own(of_vertex[v], item)) collector.vertex_edge(d, overlay.vertices[v]);
      },
      poll);
  detail::for_each_corner(
      overlay.vertices, overlay.edges,
      [&](std::size_t v, std::size_t e, std::size_t f, double degrees) {
        for (std::size_t c = 0; c < 2; ++c)
          if (of_edge[e][c] != kNone && of_edge[f][c] != kNone) return;
        collector.angle(degrees, overlay.vertices[v]);
      },
      poll);
  return collector.figures;
}

/// Measures what harmonization aims at: how near contours of different layers come to each other in the planes where
/// they meet, and each contour to itself. Distances and angles are rounded doubles. Errors: Cancelled, by the listener.
/// Cost: O(n log n).
[[nodiscard]] inline SeparationReport measure_separation(const Contours& contours, const Progress& progress = {}) {
  SeparationReport report;
  report.tolerance = contours.tolerance;
  std::vector<std::array<std::int32_t, 2>> slab_planes;
  const auto planes = plane_slabs(contours.slabs, slab_planes);
  // Reported as the end of the stage whose result is measured.
  const std::function<void()> poll = [&] { slice2mesh::report(progress, Stage::Harmonize, 1); };
  for (std::size_t k = 0; k < planes.size(); ++k) {
    poll();
    const auto [below, above] = planes[k];
    SeparationFigures figures;
    // Nothing is between two contours that are the same.
    if (below != kNone && above != kNone &&
        !detail::same_lines(contours.outlines[std::size_t(below)], contours.outlines[std::size_t(above)]))
      figures = separation_between(contours, detail::lift_edges(contours, below, above, poll), std::int32_t(k), poll);
    detail::add_figures(report.between, figures);
    report.planes.push_back(figures);
  }
  for (std::size_t s = 0; s < contours.outlines.size(); ++s) {
    poll();
    report.slabs.push_back(detail::separation_within(contours, std::int32_t(s), slab_planes[s][0], poll));
    detail::add_figures(report.within, report.slabs.back());
  }
  return report;
}

/// Puts what is below the aims into the diagnostics, as notes: one `thin_feature` per slice whose own contour has
/// something thin, one `contours_close` per plane. `count` is the number of pairs and angles. `slabs`: #S, those of the
/// contours that were measured (not checked).
inline void note_separation(const SeparationReport& report, const std::vector<Slab>& slabs, Diagnostics& diagnostics) {
  const auto note = [&](const SeparationFigures& figures, const char* code, const char* what, std::int32_t slice) {
    if (figures.below_aim() == 0) return;
    std::string text = what;
    const bool by_vertices = figures.vertices.size <= figures.vertex_edge.size;
    const SeparationMinimum& nearest = by_vertices ? figures.vertices : figures.vertex_edge;
    if (nearest.size < kSeparationShare * report.tolerance)
      text += "; the nearest are " + detail::separation_text(nearest, " mm");
    if (figures.angle.size < kSeparationAngle)
      text += "; the sharpest angle is " + detail::separation_text(figures.angle, " degrees");
    diagnostics.add(Severity::Note, Stage::Harmonize, code, text, slice, -1, figures.below_aim());
  };
  for (std::size_t s = 0; s < report.slabs.size(); ++s)
    note(report.slabs[s], "thin_feature", "the contour of the slice has features that are thin against eps, or sharp",
         slabs[s].slice);
  for (std::size_t k = 0; k < report.planes.size(); ++k) {
    const SeparationFigures& figures = report.planes[k];
    std::int32_t above = kNone;
    for (const SeparationMinimum* m : {&figures.vertices, &figures.vertex_edge, &figures.angle})
      if (m->found()) above = m->slab_above;
    note(figures, "contours_close",
         "the contours of a slice and the one below come near each other, or meet at a "
         "small angle",
         above == kNone ? kNone : slabs[std::size_t(above)].slice);
  }
}

}  // namespace slice2mesh
