// SPDX-License-Identifier: MIT
/// @file
/// @brief The difference of two outlines, opened: pockets that are wide enough, cut square at their ends.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/faces.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/arrange/segment_index.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/harmonize/merge.hpp"
#include "slice2mesh/harmonize/outline_overlay.hpp"
#include "slice2mesh/harmonize/simplify.hpp"
#include "slice2mesh/triangulate/planar.hpp"

namespace slice2mesh::detail {

/// What a vertex of a pocket's triangulation is to the two outlines.
struct PocketVertex {
  bool on_own = false;
  bool on_below = false;
  bool far = false;  ///< on one outline, and at least a width from the other
};

/// Decides which triangles of wide pockets stay. A triangle that spans from one outline to the other with no far corner
/// lies in a band narrower than the width and goes, and so does one between points that both have in common. Triangles
/// between two stretches of the same outline (a spike, a wall, a gap of the part's own) stay wherever they lead to
/// something far; so do corners and short necks.
class PocketSelection {
public:
  /// `triangles`: #T by 3; `neighbor`: #T by 3, kNone outside of the pocket.
  PocketSelection(const std::vector<GridPoint>& points, const std::vector<PocketVertex>& vertices,
                  const std::vector<std::array<std::int32_t, 3>>& triangles,
                  const std::vector<std::array<std::int32_t, 3>>& neighbor, const std::function<void()>& poll = {})
      : points_(points), triangles_(triangles), neighbor_(neighbor), kept_(triangles.size(), 0),
        listen_(poll, 1 << 14) {
    std::vector<char> far(triangles.size(), 0);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      listen_();
      bool own_only = false, below_only = false;
      for (const std::int32_t v : triangles[t]) {
        const PocketVertex& vertex = vertices[std::size_t(v)];
        far[t] = far[t] || vertex.far;
        own_only = own_only || (vertex.on_own && !vertex.on_below);
        below_only = below_only || (vertex.on_below && !vertex.on_own);
      }
      kept_[t] = far[t] || own_only != below_only;
    }
    drop_parts_without(far);
    thin_parts();
  }
  [[nodiscard]] const std::vector<char>& kept() const { return kept_; }

private:
  [[nodiscard]] const GridPoint& corner(std::size_t t, std::size_t i) const {
    return points_[std::size_t(triangles_[t][i % 3])];
  }
  void drop_parts_without(const std::vector<char>& far) {
    DisjointSets parts(triangles_.size());
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      listen_();
      for (const std::int32_t n : neighbor_[t])
        if (n != kNone && kept_[t] && kept_[std::size_t(n)]) parts.unite(std::int32_t(t), n);
    }
    std::vector<char> has(triangles_.size(), 0);
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      if (kept_[t] && far[t]) has[std::size_t(parts.find(std::int32_t(t)))] = 1;
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      kept_[t] = kept_[t] && has[std::size_t(parts.find(std::int32_t(t)))];
  }
  void thin_parts() {
    std::vector<std::int32_t> stack, part;
    std::vector<char> seen(triangles_.size(), 0);
    std::vector<std::pair<std::size_t, bool>> decisions;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      if (kept_[t] || seen[t]) continue;
      part.clear();
      stack.assign(1, std::int32_t(t));
      seen[t] = 1;
      struct Cut {
        GridPoint a, b;
        double length;
      };
      std::vector<Cut> cuts;
      while (!stack.empty()) {
        listen_();
        const auto u = std::size_t(stack.back());
        stack.pop_back();
        part.push_back(std::int32_t(u));
        for (std::size_t i = 0; i < 3; ++i) {
          const std::int32_t n = neighbor_[u][i];
          if (n == kNone) continue;
          if (kept_[std::size_t(n)])
            cuts.push_back({corner(u, i + 1), corner(u, i + 2), distance(corner(u, i + 1), corner(u, i + 2))});
          else if (!seen[std::size_t(n)]) {
            seen[std::size_t(n)] = 1;
            stack.push_back(n);
          }
        }
      }
      if (cuts.empty()) continue;
      // Stays if it does not reach further from its cuts than they are long: corners of more than about 50 degrees and
      // short necks.
      constexpr double kReach = 1.1;
      bool stays = true;
      for (const std::int32_t u : part) {
        listen_(cuts.size());
        for (std::size_t i = 0; i < 3 && stays; ++i) {
          bool near = false;
          for (const Cut& c : cuts)
            near = near || segment_distance(corner(std::size_t(u), i), c.a, c.b) <= kReach * c.length;
          stays = near;
        }
        if (!stays) break;
      }
      if (stays)
        for (const std::int32_t u : part) decisions.emplace_back(std::size_t(u), true);
    }
    for (const auto& [t, keep] : decisions) kept_[t] = keep;
  }
  const std::vector<GridPoint>& points_;
  const std::vector<std::array<std::int32_t, 3>>& triangles_;
  const std::vector<std::array<std::int32_t, 3>>& neighbor_;
  std::vector<char> kept_;
  Poll listen_;  // triangles and cuts looked at
};

/// Cuts across pockets are as short as the pockets are wide, and the elements on them are as bad. So their ends on the
/// new contour go on along it, by this share of their length: a cut then leaves the contour below at about 40 degrees.
inline void slant_cuts(Outline& outline, const std::vector<Bond>& bond, const std::vector<char>& cut_edge,
                       const std::function<void()>& poll = {}) {
  constexpr double kSlant = 1.2;
  std::vector<std::array<std::int32_t, 2>> at(outline.vertices.size(), {kNone, kNone});
  std::vector<std::int32_t> degree(outline.vertices.size(), 0);
  for (std::size_t e = 0; e < outline.edges.size(); ++e)
    for (const std::int32_t v : {outline.edges[e].a, outline.edges[e].b}) {
      const std::int32_t d = degree[std::size_t(v)]++;
      if (d < 2) at[std::size_t(v)][std::size_t(d)] = std::int32_t(e);
    }
  const auto other_end = [&](std::int32_t e, std::int32_t v) {
    const Outline::Edge& edge = outline.edges[std::size_t(e)];
    return edge.a == v ? edge.b : edge.a;
  };
  std::vector<VertexMove> moves;
  for (std::size_t e = 0; e < outline.edges.size(); ++e) {
    if (!cut_edge[e]) continue;
    for (const std::int32_t b : {outline.edges[e].a, outline.edges[e].b}) {
      const std::int32_t a = other_end(std::int32_t(e), b);
      if (bond[std::size_t(b)] != Bond::Free || bond[std::size_t(a)] == Bond::Free || degree[std::size_t(b)] != 2)
        continue;
      const auto& both = at[std::size_t(b)];
      const std::int32_t next = both[0] == std::int32_t(e) ? both[1] : both[0];
      if (cut_edge[std::size_t(next)]) continue;
      const GridPoint &pb = outline.vertices[std::size_t(b)], &pc = outline.vertices[std::size_t(other_end(next, b))];
      const double cut = distance(outline.vertices[std::size_t(a)], pb), room = distance(pb, pc);
      // As much as is left of the edge stays.
      if (!(room > 2 * kSlant * cut)) continue;
      moves.push_back({kSlant * cut, b, contour_point_between(pb, pc, kSlant * cut / room)});
    }
  }
  move_vertices(outline, std::move(moves), poll);
}

/// Edges of the result below this share of the width are merged.
inline constexpr double kMergeShare = 0.7;
/// The own outline is led through vertices of the one below that are within this share of the width.
inline constexpr double kAttachShare = 0.4;

/// How finely the edges of a pocket are split along a narrow band.
enum class BandSplits : std::uint8_t {
  All,    ///< as the band is wide, all along it: the best elements
  AtCuts  ///< only where cuts may be: for widths so small that the former would be millions
};

/// `below` where `own` differs from it by less than `width` (pitches), `own` elsewhere. `below_index` is that of
/// `below`. New vertices are simplified within `limits`; vertices and edges of `below` stay as they are. `bands` says
/// how finely bands between the two are split. `poll` is called now and then.
[[nodiscard]] inline Outline open_difference(const Outline& own, const Outline& below, const SegmentIndex& below_index,
                                             std::int32_t regions, double width, const SimplifyLimits& limits,
                                             BandSplits bands, const std::function<void()>& poll = {}) {
  Poll listen(poll, 1 << 14);  // items looked at
  const SegmentIndex own_index(own, &listen);
  const OutlineOverlay overlay(own, own_index, below, regions, kAttachShare * width, poll);
  const Arrangement& arrangement = overlay.arrangement;
  const ArrangementFaces& faces = overlay.faces;
  const std::vector<std::int32_t>&own_label = overlay.own_label, &below_label = overlay.other_label;
  // A pocket is thin if none of its vertices is far from the other outline.
  const auto differs = [&](std::int32_t f) { return overlay.differs(f); };
  const auto is_own_edge = [&](std::size_t e) { return overlay.is_own_edge(e); };
  const auto is_below_edge = [&](std::size_t e) { return overlay.is_other_edge(e); };
  std::vector<char> wide(faces.windings.size(), 0);
  std::vector<char> on_own(arrangement.vertices.size(), 0), on_below(arrangement.vertices.size(), 0);
  for (std::size_t e = 0; e < arrangement.edges.size(); ++e) {
    listen();
    for (const std::int32_t v : {arrangement.edges[e].a, arrangement.edges[e].b}) {
      if (is_own_edge(e)) on_own[std::size_t(v)] = 1;
      if (is_below_edge(e)) on_below[std::size_t(v)] = 1;
    }
  }
  // Is a vertex of the arrangement at least the width away from one of the two outlines? Asked once for each.
  std::vector<char> known_far(arrangement.vertices.size(), 0);
  const auto vertex_is_far = [&](std::int32_t v, bool from_below) {
    char& known = known_far[std::size_t(v)];
    const int shift = from_below ? 0 : 2;
    if (((known >> shift) & 1) == 0) {
      const SegmentIndex& other = from_below ? below_index : own_index;
      const bool is = !other.is_within(arrangement.vertices[std::size_t(v)], width, &listen);
      known = static_cast<char>(known | ((is ? 3 : 1) << shift));
    }
    return ((known >> shift) & 2) != 0;
  };
  {
    for (std::size_t e = 0; e < arrangement.edges.size(); ++e) {
      listen();
      for (const std::int32_t f : faces.of_edge[e]) {
        if (!differs(f)) continue;
        char& flag = wide[std::size_t(overlay.pocket(f))];
        if (flag) continue;
        const bool own_edge = is_own_edge(e);
        if (own_edge == is_below_edge(e)) continue;
        const SegmentIndex& other = own_edge ? below_index : own_index;
        const GridPoint a = arrangement.vertices[std::size_t(arrangement.edges[e].a)],
                        b = arrangement.vertices[std::size_t(arrangement.edges[e].b)];
        const GridPoint m{a.x + (b.x - a.x) / 2, a.y + (b.y - a.y) / 2};
        flag = vertex_is_far(arrangement.edges[e].a, own_edge) || vertex_is_far(arrangement.edges[e].b, own_edge) ||
               !other.is_within(m, width, &listen);
      }
    }
  }
  const auto is_wide = [&](std::int32_t f) { return differs(f) && wide[std::size_t(overlay.pocket(f))] != 0; };
  const auto label_of = [&](std::int32_t f) {
    return below_label[std::size_t(f)];
  };  // for faces that are not in wide pockets

  const std::vector<std::int32_t>& parent = overlay.parent;
  const auto below_edges = std::int32_t(below.edges.size());

  // Triangulate the wide pockets, their boundaries split where they are thin.
  std::vector<GridPoint> points = arrangement.vertices;
  struct SubEdge {
    std::int32_t a, b, edge;
    std::int32_t next = kNone;  // with the same smaller end
  };
  std::vector<SubEdge> subs;
  for (std::size_t e = 0; e < arrangement.edges.size(); ++e) {
    listen();
    if (is_wide(faces.of_edge[e][0]) || is_wide(faces.of_edge[e][1]))
      subs.push_back({arrangement.edges[e].a, arrangement.edges[e].b, std::int32_t(e)});
  }
  std::vector<OutlinePiece> pieces;
  if (!subs.empty()) {
    std::vector<std::int32_t> local(points.size(), kNone), global;
    std::vector<GridPoint> local_points;
    for (const SubEdge& s : subs)
      for (const std::int32_t v : {s.a, s.b})
        if (local[std::size_t(v)] == kNone) {
          local[std::size_t(v)] = std::int32_t(global.size());
          global.push_back(v);
          local_points.push_back(points[std::size_t(v)]);
        }
    // A frame around everything, so that no edge is on the hull: there rounded split points could not be inserted.
    for (const std::int64_t x : {-kGridLimit, kGridLimit})
      for (const std::int64_t y : {-kGridLimit, kGridLimit}) {
        local_points.push_back({x, y});
        global.push_back(kNone);
      }
    Cdt cdt;
    std::vector<Cdt::Vertex_handle> handle = insert_points(cdt, local_points, poll);
    // Pieces by their smaller end.
    std::vector<std::int32_t> first_sub(local_points.size(), kNone);
    const auto enter = [&](std::int32_t s) {
      SubEdge& sub = subs[std::size_t(s)];
      std::int32_t& first = first_sub[std::size_t(std::min(sub.a, sub.b))];
      sub.next = first;
      first = s;
    };
    const auto leave = [&](std::int32_t s) {
      const SubEdge& sub = subs[std::size_t(s)];
      std::int32_t* at = &first_sub[std::size_t(std::min(sub.a, sub.b))];
      while (*at != s) at = &subs[std::size_t(*at)].next;
      *at = sub.next;
    };
    const auto sub_between = [&](std::int32_t a, std::int32_t b) {
      std::int32_t s = first_sub[std::size_t(std::min(a, b))];
      while (s != kNone && std::max(subs[std::size_t(s)].a, subs[std::size_t(s)].b) != std::max(a, b))
        s = subs[std::size_t(s)].next;
      return s;
    };
    std::vector<std::int32_t> queue;
    for (std::size_t s = 0; s < subs.size(); ++s) {
      subs[s].a = local[std::size_t(subs[s].a)];
      subs[s].b = local[std::size_t(subs[s].b)];
      listen(64);
      insert_edge(cdt, handle[std::size_t(subs[s].a)], handle[std::size_t(subs[s].b)], Stage::Harmonize);
      enter(std::int32_t(s));
      queue.push_back(std::int32_t(s));
    }
    std::vector<PocketVertex> vertices(local_points.size());
    for (std::size_t v = 0; v < vertices.size(); ++v)
      if (global[v] != kNone) {
        vertices[v].on_own = on_own[std::size_t(global[v])];
        vertices[v].on_below = on_below[std::size_t(global[v])];
      }
    // What lies between two stretches of the same outline stays or goes as a whole: long narrow needles and walls of
    // one slice need not be cut into pieces as short as they are narrow.
    const auto needs_no_split = [&](const SubEdge& sub, std::int32_t v) {
      constexpr double kSlender = 64;  // length of the edge over the width of the needle
      const GridPoint &a = local_points[std::size_t(sub.a)], &b = local_points[std::size_t(sub.b)];
      const bool own_edge = is_own_edge(std::size_t(sub.edge)), below_edge = is_below_edge(std::size_t(sub.edge));
      const PocketVertex& vertex = vertices[std::size_t(v)];
      return own_edge != below_edge && vertex.on_own == own_edge && vertex.on_below == below_edge &&
             kSlender * segment_distance(local_points[std::size_t(v)], a, b) < distance(a, b);
    };
    // In exact mode: which triangles stay follows from which vertices are far. So a piece along which all is far from
    // the other outline, or nothing is, need not be split for a vertex of which the same holds: only at the places of
    // cuts do pieces become as short as the band is wide. Between contours that cross at a small angle they are few,
    // and not one over the angle.
    const auto other_outline = [&](bool own_edge) -> const SegmentIndex& { return own_edge ? below_index : own_index; };
    const auto is_far = [&](const PocketVertex& vertex, const GridPoint& p) {
      return vertex.on_own != vertex.on_below && !other_outline(vertex.on_own).is_within(p, width, &listen);
    };
    for (std::size_t v = 0; v < vertices.size(); ++v)
      vertices[v].far = global[v] != kNone && vertices[v].on_own != vertices[v].on_below &&
                        vertex_is_far(global[v], vertices[v].on_own);
    const auto all_far = [&](const SegmentIndex& other, const GridPoint& a, const GridPoint& b) {
      return !other.any_near(a, b, std::int64_t(std::ceil(width)), [&](std::size_t segment) {
        listen();
        const auto& [p, q] = other.segment(segment);
        return std::min({segment_distance(p, a, b), segment_distance(q, a, b), other.distance_to(segment, a),
                         other.distance_to(segment, b)}) < width;
      });
    };
    // The distance to one segment is convex: what is near at both ends is near in between.
    const auto all_near = [&](const SegmentIndex& other, const GridPoint& a, const GridPoint& b) {
      return other.any_near(a, a, std::int64_t(std::ceil(width)), [&](std::size_t segment) {
        listen();
        return std::max(other.distance_to(segment, a), other.distance_to(segment, b)) < width;
      });
    };
    const auto is_decided = [&](const SubEdge& sub, std::int32_t v) {
      const bool own_edge = is_own_edge(std::size_t(sub.edge));
      if (own_edge == is_below_edge(std::size_t(sub.edge))) return false;
      const bool far = vertices[std::size_t(v)].far;
      if (vertices[std::size_t(sub.a)].far != far || vertices[std::size_t(sub.b)].far != far) return false;
      const GridPoint &a = local_points[std::size_t(sub.a)], &b = local_points[std::size_t(sub.b)];
      return far ? all_far(other_outline(own_edge), a, b) : all_near(other_outline(own_edge), a, b);
    };
    // Split what is longer than half the width and has a vertex of the pocket in its diametral disc.
    while (!queue.empty()) {
      listen(16);
      const std::int32_t s = queue.back();
      queue.pop_back();
      const SubEdge sub = subs[std::size_t(s)];
      const GridPoint a = local_points[std::size_t(sub.a)], b = local_points[std::size_t(sub.b)];
      if (distance(a, b) <= width / 2) continue;
      Cdt::Face_handle f;
      int i = 0;
      if (!cdt.is_edge(handle[std::size_t(sub.a)], handle[std::size_t(sub.b)], f, i))
        throw GeometryError(Stage::Harmonize, -1, -1, "an edge is missing; this is a defect of slice2mesh");
      bool encroached = false;
      for (int side = 0; side < 2; ++side) {
        // f lies on the left of (ccw(i), cw(i)).
        const bool left = f->vertex(Cdt::ccw(i))->info() == sub.a;
        // Edges run from the smaller to the larger vertex, and so do their pieces.
        const std::int32_t face = faces.of_edge[std::size_t(sub.edge)][left ? 0 : 1];
        if (is_wide(face) && !cdt.is_infinite(f) && !encroached) {
          const std::int32_t v = f->vertex(i)->info();
          encroached = in_diametral_disc(a, b, local_points[std::size_t(v)]) && !needs_no_split(sub, v) &&
                       (bands == BandSplits::All || !is_decided(sub, v));
        }
        const int j = cdt.mirror_index(f, i);
        f = f->neighbor(i);
        i = j;
      }
      const GridPoint m = contour_point_between(a, b, 0.5);
      // An edge that is far from the other outline in its middle shows that by a vertex there.
      const bool own_edge = is_own_edge(std::size_t(sub.edge));
      if (!encroached && own_edge != is_below_edge(std::size_t(sub.edge))) {
        encroached = !(vertices[std::size_t(sub.a)].far && vertices[std::size_t(sub.b)].far) &&
                     !other_outline(own_edge).is_within(m, width, &listen);
      }
      if (!encroached) continue;
      if (m == a || m == b) continue;
      // The rounded middle may lie beside the edge: the four triangles around it must turn left all the same.
      bool room = true;
      for (int side = 0; side < 2; ++side) {
        const bool left = f->vertex(Cdt::ccw(i))->info() == sub.a;
        const GridPoint &u = left ? a : b, &w = left ? b : a;
        if (cdt.is_infinite(f)) {
          room = room && orientation(u, w, m) >= 0;
        } else {
          const GridPoint c = local_points[std::size_t(f->vertex(i)->info())];
          room = room && orientation(u, m, c) > 0 && orientation(m, w, c) > 0;
        }
        const int j = cdt.mirror_index(f, i);
        f = f->neighbor(i);
        i = j;
      }
      if (!room) continue;
      const Cdt::Vertex_handle v = cdt.insert(to_cdt_point(m), Cdt::EDGE, f, i);
      v->info() = std::int32_t(local_points.size());
      handle.push_back(v);
      local_points.push_back(m);
      vertices.push_back({own_edge, is_below_edge(std::size_t(sub.edge)), false});
      vertices.back().far = is_far(vertices.back(), m);
      global.push_back(std::int32_t(points.size()));
      points.push_back(m);
      first_sub.push_back(kNone);
      const auto t = std::int32_t(subs.size());
      leave(s);
      subs[std::size_t(s)].b = v->info();
      subs.push_back({v->info(), sub.b, sub.edge});
      enter(s);
      enter(t);
      queue.push_back(s);
      queue.push_back(t);
      Cdt::Face_circulator circulator = cdt.incident_faces(v), begin = circulator;
      do {
        listen();
        const int k = circulator->index(v);
        if (circulator->is_constrained(k) && !cdt.is_infinite(circulator)) {
          const std::int32_t side =
              sub_between(circulator->vertex(Cdt::ccw(k))->info(), circulator->vertex(Cdt::cw(k))->info());
          if (side != kNone) queue.push_back(side);
        }
      } while (++circulator != begin);
    }
    // Triangles inside of wide pockets.
    for (const Cdt::Face_handle f : cdt.all_face_handles()) f->info() = kNone;
    std::vector<std::array<std::int32_t, 3>> triangles, neighbor;
    std::vector<std::int32_t> triangle_face;
    std::vector<Cdt::Face_handle> stack, order;
    const auto put = [&](Cdt::Face_handle f, std::int32_t face) {
      if (f->info() != kNone || cdt.is_infinite(f)) return;
      f->info() = std::int32_t(triangles.size());
      triangles.push_back({f->vertex(0)->info(), f->vertex(1)->info(), f->vertex(2)->info()});
      triangle_face.push_back(face);
      stack.push_back(f);
      order.push_back(f);
    };
    for (const SubEdge& sub : subs) {
      listen(16);
      Cdt::Face_handle f;
      int i = 0;
      if (!cdt.is_edge(handle[std::size_t(sub.a)], handle[std::size_t(sub.b)], f, i))
        throw GeometryError(Stage::Harmonize, -1, -1, "an edge is missing; this is a defect of slice2mesh");
      for (int side = 0; side < 2; ++side) {
        const bool left = f->vertex(Cdt::ccw(i))->info() == sub.a;
        const std::int32_t face = faces.of_edge[std::size_t(sub.edge)][left ? 0 : 1];
        if (is_wide(face)) put(f, face);
        const int j = cdt.mirror_index(f, i);
        f = f->neighbor(i);
        i = j;
      }
      while (!stack.empty()) {
        listen();
        const Cdt::Face_handle g = stack.back();
        stack.pop_back();
        for (int k = 0; k < 3; ++k)
          if (!g->is_constrained(k)) put(g->neighbor(k), triangle_face[std::size_t(g->info())]);
      }
    }
    neighbor.assign(triangles.size(), {kNone, kNone, kNone});
    for (std::size_t t = 0; t < order.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        listen();
        const std::int32_t n = order[t]->neighbor(k)->info();
        // Across an edge between two differing faces of the same pocket the pocket goes on.
        if (n == kNone) continue;
        if (!order[t]->is_constrained(k) ||
            overlay.pocket(triangle_face[std::size_t(n)]) == overlay.pocket(triangle_face[t]))
          neighbor[t][std::size_t(k)] = n;
      }
    const PocketSelection selection(local_points, vertices, triangles, neighbor, poll);
    const auto triangle_label = [&](std::int32_t t) {
      const std::int32_t f = triangle_face[std::size_t(t)];
      return selection.kept()[std::size_t(t)] ? own_label[std::size_t(f)] : below_label[std::size_t(f)];
    };
    // Pieces of the new outline: along the pockets' boundaries, and cuts across them.
    for (const SubEdge& sub : subs) {
      listen(16);
      Cdt::Face_handle f;
      int i = 0;
      cdt.is_edge(handle[std::size_t(sub.a)], handle[std::size_t(sub.b)], f, i);
      std::int32_t label[2] = {kNone, kNone};
      for (int side = 0; side < 2; ++side) {
        const bool left = f->vertex(Cdt::ccw(i))->info() == sub.a;
        const std::int32_t face = faces.of_edge[std::size_t(sub.edge)][left ? 0 : 1];
        label[left ? 0 : 1] = is_wide(face) ? triangle_label(f->info()) : label_of(face);
        const int j = cdt.mirror_index(f, i);
        f = f->neighbor(i);
        i = j;
      }
      if (label[0] != label[1])
        pieces.push_back({global[std::size_t(sub.a)], global[std::size_t(sub.b)], label[0], label[1],
                          parent[std::size_t(sub.edge)]});
    }
    for (std::size_t t = 0; t < order.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        listen();
        const std::int32_t n = order[t]->neighbor(k)->info();
        if (n == kNone || std::size_t(n) < t || order[t]->is_constrained(k)) continue;
        const std::int32_t left = triangle_label(std::int32_t(t)), right = triangle_label(n);
        if (left != right)
          pieces.push_back({global[std::size_t(order[t]->vertex(Cdt::ccw(k))->info())],
                            global[std::size_t(order[t]->vertex(Cdt::cw(k))->info())], left, right, kNone});
      }
  }
  for (std::size_t e = 0; e < arrangement.edges.size(); ++e) {
    listen();
    const auto& sides = faces.of_edge[e];
    if (is_wide(sides[0]) || is_wide(sides[1])) continue;
    const std::int32_t left = label_of(sides[0]), right = label_of(sides[1]);
    if (left != right) pieces.push_back({arrangement.edges[e].a, arrangement.edges[e].b, left, right, parent[e]});
  }

  Outline outline;
  outline.vertices = std::move(points);
  std::vector<Bond> bond(outline.vertices.size(), Bond::Free);
  std::vector<char> old_edge, cut_edge;
  // Vertices of the outline below stay, also where an edge of the own one has been led through them.
  const std::vector<char> at_below = are_among(outline.vertices, below.vertices, listen);
  for (const OutlinePiece& p : join_pieces(pieces, at_below, poll)) {
    listen();
    outline.edges.push_back({p.a, p.b, p.left, p.right});
    old_edge.push_back(p.parent != kNone && p.parent < below_edges);
    cut_edge.push_back(p.parent == kNone);
    if (old_edge.back()) bond[std::size_t(p.a)] = bond[std::size_t(p.b)] = Bond::OnEdge;
  }
  for (std::size_t v = 0; v < bond.size(); ++v)
    if (at_below[v]) bond[v] = Bond::OnVertex;
  slant_cuts(outline, bond, cut_edge, poll);
  merge_short_edges(outline, bond, old_edge, kMergeShare * width, poll);
  std::vector<char> fixed(outline.vertices.size(), 0);
  for (std::size_t v = 0; v < bond.size(); ++v) fixed[v] = bond[v] != Bond::Free;
  simplify(outline, fixed, limits, poll);
  // Where slices left the contour below and have come back, vertices stay behind on its straight edges: they go. The
  // overlay of the plane leads the edge through them where the contour below has them, so that both still coincide.
  simplify(outline, {}, {double(kContourStep), 0, 0, limits.longest}, poll);
  normalize(outline, poll);
  return outline;
}

}  // namespace slice2mesh::detail
