// SPDX-License-Identifier: MIT
/// @file
/// @brief Triangulations of interface planes: plain, or conforming and graded.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/lift/lift.hpp"
#include "slice2mesh/triangulate/planar.hpp"

namespace slice2mesh {

/// The triangulation of one plane: material below or above every triangle.
struct PlaneMesh {
  double z = 0;                                        ///< mm, its height
  std::vector<GridPoint> vertices;                     ///< #V; those of the overlay come first, with their indices
  std::vector<std::array<std::int32_t, 3>> triangles;  ///< #T by 3: indices of vertices, counter-clockwise from above
  std::vector<std::array<Side, 2>> sides;              ///< #T by 2: cell below and cell above
  std::vector<std::vector<std::int32_t>> below_chain;  ///< #E of the outline below: indices of vertices from a to b
  std::vector<std::vector<std::int32_t>> above_chain;  ///< #E of the outline above: indices of vertices from a to b
  std::vector<char> fixed;                             ///< #V: 1 on a contour, else 0
};

/// How a plane is refined.
struct PlaneRefinement {
  bool gabriel = true;  ///< split contour edges until no vertex is in their diametral discs
  double min_edge = 4;  ///< pitches: contour edges below this length are not split any more
  double radius_edge_ratio =
      0;                ///< triangles with a larger ratio of circumradius to shortest edge get a vertex; 0: off
  double shortest = 0;  ///< pitches: no new vertex nearer than this to another one (interior refinement)
  std::vector<GridPoint> interior;  ///< any number: vertices to insert where they are clear of the contours
  std::size_t max_vertices = 0;     ///< largest number of vertices of the plane; 0: no limit
  std::function<void()> poll;       ///< called now and then; what it throws ends the work
};

namespace detail {

class PlaneMesher {
public:
  PlaneMesher(InterfacePlane plane, PlaneRefinement options)
      : plane_(std::move(plane)), options_(std::move(options)), points_(plane_.overlay.vertices),
        frame_(points_.size()) {
    // A frame around everything: no contour edge is on the hull, whose vertices could not be moved off a line by
    // rounding.
    for (const std::int64_t x : {-kGridLimit, kGridLimit})
      for (const std::int64_t y : {-kGridLimit, kGridLimit}) points_.push_back({x, y});
    contour_.assign(points_.size(), 1);
    cdt_.infinite_vertex()->info() = kNone;
    handles_ = insert_points(cdt_, points_, options_.poll);
    const auto& edges = plane_.overlay.edges;
    subs_.reserve(edges.size() * 2);
    sub_of_.reserve(edges.size() * 4);
    for (std::size_t e = 0; e < edges.size(); ++e) {
      poll(4);
      insert_edge(cdt_, handles_[std::size_t(edges[e].a)], handles_[std::size_t(edges[e].b)], Stage::Triangulate);
      subs_.push_back({edges[e].a, edges[e].b, std::int32_t(e), kNone});
      sub_of_[key(edges[e].a, edges[e].b)] = std::int32_t(e);
    }
    label_faces();
  }

  /// All steps of the refinement.
  void run() {
    if (options_.gabriel) make_gabriel();
    if (!options_.interior.empty()) insert_interior();
    if (options_.radius_edge_ratio > 0) refine();
    if (options_.gabriel) make_gabriel();
  }

  /// The triangulation.
  [[nodiscard]] PlaneMesh extract() const {
    PlaneMesh mesh;
    mesh.z = plane_.z;
    for (const Cdt::Face_handle f : cdt_.finite_face_handles()) {
      poll();
      if (!material(f->info())) continue;
      mesh.triangles.push_back({f->vertex(0)->info(), f->vertex(1)->info(), f->vertex(2)->info()});
      mesh.sides.push_back(cells(f->info()));
    }
    std::vector<std::vector<std::int32_t>> pieces(plane_.overlay.edges.size());
    for (std::size_t e = 0; e < pieces.size(); ++e) {
      poll();
      for (auto s = std::int32_t(e); s != kNone; s = subs_[std::size_t(s)].next)
        pieces[e].push_back(subs_[std::size_t(s)].a);
    }
    std::unordered_map<std::uint64_t, std::int32_t> edge_of;
    edge_of.reserve(pieces.size() * 2);
    for (std::size_t e = 0; e < pieces.size(); ++e) {
      poll();
      edge_of[key(plane_.overlay.edges[e].a, plane_.overlay.edges[e].b)] = std::int32_t(e);
    }
    const auto chains = [&](const std::vector<std::vector<std::int32_t>>& paths,
                            std::vector<std::vector<std::int32_t>>& result) {
      for (const std::vector<std::int32_t>& path : paths) {
        std::vector<std::int32_t> chain;
        for (std::size_t i = 0; i + 1 < path.size(); ++i) {
          poll();
          const auto e = std::size_t(edge_of.at(key(path[i], path[i + 1])));
          if (plane_.overlay.edges[e].a == path[i])
            chain.insert(chain.end(), pieces[e].begin(), pieces[e].end());
          else {
            chain.push_back(path[i]);
            chain.insert(chain.end(), pieces[e].rbegin(), pieces[e].rend() - 1);
          }
        }
        if (!path.empty()) chain.push_back(path.back());
        result.push_back(std::move(chain));
      }
    };
    chains(plane_.below_path, mesh.below_chain);
    chains(plane_.above_path, mesh.above_chain);
    // Without the frame.
    std::vector<std::int32_t> index(points_.size(), kNone);
    for (std::size_t v = 0; v < points_.size(); ++v) {
      poll();
      if (v >= frame_ && v < frame_ + 4) continue;
      index[v] = std::int32_t(mesh.vertices.size());
      mesh.vertices.push_back(points_[v]);
      mesh.fixed.push_back(contour_[v]);
    }
    for (auto& t : mesh.triangles) {
      poll();
      for (std::int32_t& v : t) v = index[std::size_t(v)];
    }
    for (auto* all : {&mesh.below_chain, &mesh.above_chain})
      for (auto& chain : *all) {
        poll();
        for (std::int32_t& v : chain) v = index[std::size_t(v)];
      }
    return mesh;
  }

private:
  // Steps: where thousands of edges meet in a vertex, one thing done at it takes milliseconds.
  static constexpr std::uint32_t kWorkAtVertex = 256;
  struct Sub {
    std::int32_t a, b;  // same way as the edge of the overlay
    std::int32_t edge;
    std::int32_t next;  // next piece towards b
  };
  static std::uint64_t key(std::int32_t a, std::int32_t b) {
    if (a > b) std::swap(a, b);
    return (std::uint64_t(std::uint32_t(a)) << 32) | std::uint32_t(b);
  }
  // Cells of a face are stored as the index of an edge of the overlay and its side: 2 e for the left, 2 e + 1 for the
  // right.
  [[nodiscard]] const std::array<Side, 2>& cells(std::int32_t info) const {
    return info % 2 == 0 ? plane_.left[std::size_t(info / 2)] : plane_.right[std::size_t(info / 2)];
  }
  [[nodiscard]] bool material(std::int32_t info) const {
    return info != kNone && (!cells(info)[0].empty() || !cells(info)[1].empty());
  }
  [[nodiscard]] GridPoint point(Cdt::Vertex_handle v) const { return points_[std::size_t(v->info())]; }
  /// The face on the left of a -> b, and the index of the vertex opposite to the edge.
  [[nodiscard]] std::pair<Cdt::Face_handle, int> left_face(std::int32_t a, std::int32_t b) const {
    Cdt::Face_handle f;
    int i = 0;
    if (!cdt_.is_edge(handles_[std::size_t(a)], handles_[std::size_t(b)], f, i))
      throw GeometryError(Stage::Triangulate, -1, -1,
                          "a contour edge is missing from its plane; this is a defect of slice2mesh");
    if (f->vertex(Cdt::ccw(i))->info() == a) return {f, i};
    const int j = cdt_.mirror_index(f, i);
    return {f->neighbor(i), j};
  }
  void label_faces() {
    for (const Cdt::Face_handle f : cdt_.all_face_handles()) f->info() = kNone;
    std::vector<Cdt::Face_handle> stack;
    const auto put = [&](Cdt::Face_handle f, std::int32_t label) {
      if (cdt_.is_infinite(f) || f->info() != kNone) return;
      f->info() = label;
      stack.push_back(f);
    };
    for (const Sub& s : subs_) {
      poll();
      put(left_face(s.a, s.b).first, 2 * s.edge);
      put(left_face(s.b, s.a).first, 2 * s.edge + 1);
      while (!stack.empty()) {
        poll();
        const Cdt::Face_handle f = stack.back();
        stack.pop_back();
        for (int i = 0; i < 3; ++i)
          if (!f->is_constrained(i)) put(f->neighbor(i), f->info());
      }
    }
  }
  void check_budget() {
    poll(kWorkAtVertex);
    if (options_.max_vertices > 0 && points_.size() > options_.max_vertices)
      throw BudgetError(Stage::Triangulate, "a plane needs more vertices than max_vertices");
  }

  /// Listens to the caller every so many steps.
  void poll(std::uint32_t steps = 1) const {
    constexpr std::uint32_t kPollEvery = 1024;
    steps_ += steps;
    if (steps_ < kPollEvery || !options_.poll) return;
    steps_ = 0;
    options_.poll();
  }

  /// The vertex in the diametral disc of a piece that is nearest to it, of the two opposite ones; kNone if the piece is
  /// Gabriel.
  [[nodiscard]] std::int32_t encroacher(const Sub& s) const {
    const GridPoint a = points_[std::size_t(s.a)], b = points_[std::size_t(s.b)];
    std::int32_t result = kNone;
    double nearest = HUGE_VAL;
    for (int side = 0; side < 2; ++side) {
      const auto [f, i] = side == 0 ? left_face(s.a, s.b) : left_face(s.b, s.a);
      // Also on a side without material: across a gap no vertex may be nearer than those on its walls.
      if (cdt_.is_infinite(f)) continue;
      const std::int32_t v = f->vertex(i)->info();
      if (!in_diametral_disc(a, b, points_[std::size_t(v)])) continue;
      const double d = segment_distance(points_[std::size_t(v)], a, b);
      if (d < nearest) {
        nearest = d;
        result = v;
      }
    }
    return result;
  }
  /// Where a piece that another contour runs along very closely is split: opposite to the vertex v of that contour, so
  /// that the line between them makes the same angle with both contours. Then neither point is in a disc of the other
  /// contour, however narrow the gap, where halving would go on until the pieces are as short as the gap is wide. False
  /// if v is not so near.
  [[nodiscard]] bool split_opposite(const Sub& s, std::int32_t v, GridPoint& result) const {
    constexpr double kFromEnds = 1;  // of gaps: no piece is shorter than the gap is wide
    const GridPoint a = points_[std::size_t(s.a)], b = points_[std::size_t(s.b)], p = points_[std::size_t(v)];
    const double length = distance(a, b), gap = segment_distance(p, a, b);
    if (!(gap < length / 2)) return false;
    const double ex = double(b.x - a.x) / length, ey = double(b.y - a.y) / length;
    // The mean direction of the contour edges at v that run along the piece.
    double tx = 0, ty = 0;
    std::int32_t tip = kNone;  // the end of the piece that an edge leads to from v
    Cdt::Edge_circulator e = cdt_.incident_edges(handles_[std::size_t(v)]), begin = e;
    if (e == nullptr) return false;
    do {
      poll();
      if (!e->first->is_constrained(e->second) || cdt_.is_infinite(e)) continue;
      const Cdt::Vertex_handle u = e->first->vertex(Cdt::ccw(e->second)), w = e->first->vertex(Cdt::cw(e->second));
      const Cdt::Vertex_handle far = u->info() == v ? w : u;
      if (far->info() == s.a || far->info() == s.b) tip = far->info();
      const GridPoint q = point(far);
      const double l = distance(p, q);
      double dx = double(q.x - p.x) / l, dy = double(q.y - p.y) / l;
      const double along = dx * ex + dy * ey;
      if (std::fabs(along) < 0.9) continue;
      tx += along > 0 ? dx : -dx;
      ty += along > 0 ? dy : -dy;
    } while (++e != begin);
    const double t = std::hypot(tx, ty);
    double bx = ex + (t > 0 ? tx / t : ex), by = ey + (t > 0 ? ty / t : ey);
    // Distance from a. Of two edges that leave a tip, both get the same distance from it, whether the other one bends
    // at v or not: around a fan of edges, splits that come back to its first edge nearer to the tip go on to the end of
    // the grid.
    const double at = tip == s.a   ? distance(a, p)
                      : tip == s.b ? length - distance(b, p)
                                   : (double(p.x - a.x) * bx + double(p.y - a.y) * by) / (ex * bx + ey * by);
    // Towards a sharp tip the play for a split opposite to a vertex (gap^2 over length) shrinks with the distance from
    // the tip. Where half of it is less than a few pitches, halving would go on to the end of the grid: then the split
    // is made even if it is very near to an end, and at the grid point nearby that is in no disc.
    constexpr double kPlay = 4;  // pitches
    const bool tight = gap * gap / (2 * length) < kPlay && (is_sharp(s.a, s.b) || is_sharp(s.b, s.a));
    if (!tight && (at < kFromEnds * gap || at > length - kFromEnds * gap)) return false;
    result = {a.x + std::llround(at * ex), a.y + std::llround(at * ey)};
    if (is_clear_opposite(s, v, result) || split_tightly(s, v, {at * ex, at * ey}, result)) return true;
    if (tip != kNone) return false;
    // Where the other contour bends at v, only the foot of v is in no disc.
    const double foot = double(dot(a, b, p)) / length;
    if (foot < kFromEnds * gap || foot > length - kFromEnds * gap) return false;
    return split_tightly(s, v, {foot * ex, foot * ey}, result);
  }
  /// Has a split at m the vertex v in no disc of the two halves, and m in no disc of the contour edges at v?
  [[nodiscard]] bool is_clear_opposite(const Sub& s, std::int32_t v, const GridPoint& m) const {
    const GridPoint a = points_[std::size_t(s.a)], b = points_[std::size_t(s.b)], p = points_[std::size_t(v)];
    if (m == a || m == b || in_diametral_disc(a, m, p) || in_diametral_disc(m, b, p)) return false;
    Cdt::Edge_circulator e = cdt_.incident_edges(handles_[std::size_t(v)]), begin = e;
    do {
      poll();
      if (!e->first->is_constrained(e->second) || cdt_.is_infinite(e)) continue;
      if (in_diametral_disc(point(e->first->vertex(Cdt::ccw(e->second))), point(e->first->vertex(Cdt::cw(e->second))),
                            m))
        return false;
    } while (++e != begin);
    return true;
  }
  /// The grid point near an ideal one (from the start of the piece, pitches) that is clear (see is_clear_opposite); the
  /// one nearest to the ideal one.
  [[nodiscard]] bool split_tightly(const Sub& s, std::int32_t v, const std::array<double, 2>& ideal,
                                   GridPoint& result) const {
    const GridPoint a = points_[std::size_t(s.a)];
    constexpr std::int64_t kAround = 3;  // pitches: walls bend by no more than a few roundings
    const GridPoint middle{a.x + std::llround(ideal[0]), a.y + std::llround(ideal[1])};
    double nearest = HUGE_VAL;
    for (std::int64_t i = -kAround; i <= kAround; ++i)
      for (std::int64_t j = -kAround; j <= kAround; ++j) {
        const GridPoint m{middle.x + i, middle.y + j};
        const double off = std::hypot(double(m.x - a.x) - ideal[0], double(m.y - a.y) - ideal[1]);
        if (off >= nearest || !is_clear_opposite(s, v, m)) continue;
        nearest = off;
        result = m;
      }
    return nearest < HUGE_VAL;
  }
  /// Where to split a piece: in the middle, but at a power of two from a vertex where contours meet at a sharp angle,
  /// so that the pieces on both sides of the angle get the same lengths.
  [[nodiscard]] GridPoint split_point(const Sub& s) const {
    const GridPoint a = points_[std::size_t(s.a)], b = points_[std::size_t(s.b)];
    const bool sharp_a = is_sharp(s.a, s.b), sharp_b = is_sharp(s.b, s.a);
    const double length = distance(a, b);
    // The middle of a long edge is rounded like a contour vertex: where another plane has one there, both coincide.
    if (sharp_a == sharp_b && length > 1024 * double(kContourStep)) return contour_point_between(a, b, 0.5);
    if (sharp_a == sharp_b) return {a.x + (b.x - a.x) / 2, a.y + (b.y - a.y) / 2};
    const GridPoint from = sharp_a ? a : b, to = sharp_a ? b : a;
    const double shell = std::exp2(std::round(std::log2(length / 2)));
    const double t = shell / length;  // in [0.35, 0.71]
    return {from.x + std::llround(t * double(to.x - from.x)), from.y + std::llround(t * double(to.y - from.y))};
  }
  /// Does another contour edge leave v at less than 60 degrees from the edge to w?
  [[nodiscard]] bool is_sharp(std::int32_t v, std::int32_t w) const {
    const Cdt::Vertex_handle handle = handles_[std::size_t(v)];
    const GridPoint p = points_[std::size_t(v)], q = points_[std::size_t(w)];
    Cdt::Edge_circulator e = cdt_.incident_edges(handle), begin = e;
    if (e == nullptr) return false;
    do {
      poll();
      if (!e->first->is_constrained(e->second) || cdt_.is_infinite(e)) continue;
      const Cdt::Vertex_handle u = e->first->vertex(Cdt::ccw(e->second)), x = e->first->vertex(Cdt::cw(e->second));
      const Cdt::Vertex_handle other = u == handle ? x : u;
      if (other->info() == w) continue;
      const GridPoint r = point(other);
      const double d = double(dot(p, q, r));
      if (d > 0.5 * distance(p, q) * distance(p, r)) return true;
    } while (++e != begin);
    return false;
  }
  /// Flips the edges at a new vertex that are not Delaunay, and those that become so by it. CGAL looks only at the
  /// edges opposite to a new vertex: those at it are Delaunay if it lies in the circumcircles of the triangles that it
  /// splits. A point that was rounded to beside a short edge may not: the circle through the edge and a vertex far away
  /// reaches over the edge by less than a pitch.
  void flip_spokes(Cdt::Vertex_handle v, std::vector<std::int32_t>& queue) {
    std::vector<std::array<Cdt::Vertex_handle, 2>> stack;
    Cdt::Vertex_circulator u = cdt_.incident_vertices(v), begin = u;
    do
      if (!cdt_.is_infinite(u)) stack.push_back({v, u});
    while (++u != begin);
    while (!stack.empty()) {
      const auto [p, q] = stack.back();
      stack.pop_back();
      poll(kWorkAtVertex);
      Cdt::Face_handle f;
      int i = 0;
      if (!cdt_.is_edge(p, q, f, i)) continue;
      if (f->is_constrained(i)) {
        push_sub(f, i, queue);  // another vertex may lie opposite to it
        continue;
      }
      if (!cdt_.is_flipable(f, i)) continue;
      const Cdt::Vertex_handle x = f->vertex(i), y = cdt_.mirror_vertex(f, i);
      cdt_.flip(f, i);
      for (const Cdt::Vertex_handle end : {p, q}) {
        stack.push_back({end, x});
        stack.push_back({end, y});
      }
    }
  }
  /// Splits a piece; false if the grid leaves no room for it.
  bool split(std::int32_t index, std::int32_t encroaching, std::vector<std::int32_t>& queue) {
    const Sub s = subs_[std::size_t(index)];
    const GridPoint a = points_[std::size_t(s.a)], b = points_[std::size_t(s.b)];
    if (distance(a, b) < options_.min_edge) return false;
    GridPoint m;
    if (!split_opposite(s, encroaching, m)) m = split_point(s);
    auto [f, i] = left_face(s.a, s.b);
    // Rounding may put the point beside the edge by half a pitch; the four triangles around it must still turn left.
    for (int side = 0; side < 2; ++side) {
      const Cdt::Face_handle g = side == 0 ? f : f->neighbor(i);
      const int j = side == 0 ? i : cdt_.mirror_index(f, i);
      const GridPoint c = point(g->vertex(j));
      const GridPoint u = side == 0 ? a : b, w = side == 0 ? b : a;
      if (orientation(u, m, c) <= 0 || orientation(m, w, c) <= 0) return false;
    }
    const Cdt::Vertex_handle v = cdt_.insert(to_cdt_point(m), Cdt::EDGE, f, i);
    v->info() = std::int32_t(points_.size());
    handles_.push_back(v);
    points_.push_back(m);
    contour_.push_back(1);
    const auto t = std::int32_t(subs_.size());
    sub_of_.erase(key(s.a, s.b));
    subs_[std::size_t(index)].b = v->info();
    subs_[std::size_t(index)].next = t;
    subs_.push_back({v->info(), s.b, s.edge, s.next});
    sub_of_[key(s.a, v->info())] = index;
    sub_of_[key(v->info(), s.b)] = t;
    // Faces around v: from b counter-clockwise to a they are on the left of a -> b.
    Cdt::Face_circulator c = cdt_.incident_faces(v), begin = c;
    while (c->vertex(Cdt::ccw(c->index(v)))->info() != s.b) ++c;
    begin = c;
    bool left = true;
    do {
      const int k = c->index(v);
      if (c->vertex(Cdt::ccw(k))->info() == s.a) left = false;
      if (!cdt_.is_infinite(c)) c->info() = 2 * s.edge + (left ? 0 : 1);
      if (c->is_constrained(k)) push_sub(c, k, queue);
    } while (++c != begin);
    if (orientation(a, m, b) != 0) flip_spokes(v, queue);
    queue.push_back(index);
    queue.push_back(t);
    check_budget();
    return true;
  }
  void push_sub(Cdt::Face_handle f, int i, std::vector<std::int32_t>& queue) const {
    const auto it = sub_of_.find(key(f->vertex(Cdt::ccw(i))->info(), f->vertex(Cdt::cw(i))->info()));
    if (it != sub_of_.end()) queue.push_back(it->second);
  }
  void make_gabriel() {
    std::vector<std::int32_t> queue;
    for (std::size_t s = subs_.size(); s-- > 0;) queue.push_back(std::int32_t(s));
    process(queue);
  }
  void process(std::vector<std::int32_t>& queue) {
    while (!queue.empty()) {
      const std::int32_t s = queue.back();
      queue.pop_back();
      poll();
      const std::int32_t v = encroacher(subs_[std::size_t(s)]);
      if (v != kNone) split(s, v, queue);
    }
  }

  /// Inserts p if it lies in material, is not in a diametral disc of a contour edge, and not nearer than `nearest` to a
  /// vertex.
  bool insert_free(const GridPoint& p, Cdt::Face_handle& hint, double nearest,
                   std::vector<std::int32_t>* blocking = nullptr) {
    Cdt::Locate_type type;
    int li = 0;
    const Cdt::Face_handle f = cdt_.locate(to_cdt_point(p), type, li, hint);
    if (f == nullptr || cdt_.is_infinite(f) || type == Cdt::VERTEX || type == Cdt::OUTSIDE_CONVEX_HULL) return false;
    hint = f;
    if (!material(f->info())) return false;
    if (type == Cdt::EDGE && f->is_constrained(li)) {
      if (blocking) push_sub(f, li, *blocking);
      return false;
    }
    zone_.clear();
    border_.clear();
    cdt_.get_conflicts_and_boundary(to_cdt_point(p), std::back_inserter(zone_), std::back_inserter(border_), f);
    poll(std::uint32_t(border_.size()));
    bool clear = true;
    for (const Cdt::Edge& e : border_) {
      const Cdt::Vertex_handle u = e.first->vertex(Cdt::ccw(e.second)), w = e.first->vertex(Cdt::cw(e.second));
      if (nearest > 0 && (distance(p, point(u)) < nearest || distance(p, point(w)) < nearest)) return false;
      if (e.first->is_constrained(e.second) && in_diametral_disc(point(u), point(w), p)) {
        clear = false;
        if (blocking) push_sub(e.first, e.second, *blocking);
      }
    }
    if (!clear) return false;
    const std::int32_t label = f->info();
    const Cdt::Vertex_handle v = cdt_.insert(to_cdt_point(p), type, f, li);
    v->info() = std::int32_t(points_.size());
    handles_.push_back(v);
    points_.push_back(p);
    contour_.push_back(0);
    Cdt::Face_circulator c = cdt_.incident_faces(v), begin = c;
    do c->info() = label;
    while (++c != begin);
    hint = v->face();
    check_budget();
    return true;
  }
  void insert_interior() {
    Cdt::Face_handle hint;
    for (const GridPoint& p : options_.interior) {
      poll();
      insert_free(p, hint, 0);
    }
  }

  struct Bad {
    Cdt::Vertex_handle v[3];
  };
  [[nodiscard]] bool is_bad(Cdt::Face_handle f, double& radius, double& shortest) const {
    if (cdt_.is_infinite(f) || !material(f->info())) return false;
    const GridPoint a = point(f->vertex(0)), b = point(f->vertex(1)), c = point(f->vertex(2));
    const double ab = distance(a, b), bc = distance(b, c), ca = distance(c, a);
    radius = ab * bc * ca / (2 * double(cross(a, b, c)));
    shortest = std::min({ab, bc, ca});
    return radius > options_.radius_edge_ratio * shortest && radius > options_.shortest;
  }
  /// The circumcenter, rounded to a coarse grid (a power of two below 1/64 of the shortest edge, off center so that
  /// symmetric input does not fall on its borders): the same triangles on other planes, and co-circular ones, give the
  /// same point and not one a pitch away.
  [[nodiscard]] static GridPoint rounded_circumcenter(GridPoint a, GridPoint b, GridPoint c, double shortest) {
    if (b < a) std::swap(a, b);
    if (c < a) std::swap(a, c);
    if (c < b) std::swap(b, c);
    const double bx = double(b.x - a.x), by = double(b.y - a.y), cx = double(c.x - a.x), cy = double(c.y - a.y);
    const double d = 2 * (bx * cy - by * cx), b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
    const double cell = std::max(double(kContourStep), std::exp2(std::floor(std::log2(shortest / 64))));
    constexpr double kOffset = 0.3125;  // in cells
    const auto round = [&](double v) { return std::llround((std::floor(v / cell + kOffset)) * cell); };
    return {round(double(a.x) + (cy * b2 - by * c2) / d), round(double(a.y) + (bx * c2 - cx * b2) / d)};
  }
  void refine() {
    std::vector<Bad> queue;
    const auto push = [&](Cdt::Face_handle f) {
      double radius = 0, shortest = 0;
      if (is_bad(f, radius, shortest)) queue.push_back({{f->vertex(0), f->vertex(1), f->vertex(2)}});
    };
    for (const Cdt::Face_handle f : cdt_.finite_face_handles()) {
      poll();
      push(f);
    }
    std::vector<std::int32_t> subs;
    for (std::size_t next = 0; next < queue.size(); ++next) {
      poll();
      const Bad bad = queue[next];
      Cdt::Face_handle f;
      if (!cdt_.is_face(bad.v[0], bad.v[1], bad.v[2], f)) continue;
      double radius = 0, shortest = 0;
      if (!is_bad(f, radius, shortest)) continue;
      const GridPoint p = rounded_circumcenter(point(f->vertex(0)), point(f->vertex(1)), point(f->vertex(2)), shortest);
      Cdt::Face_handle hint = f;
      if (!insert_free(p, hint, options_.shortest, nullptr)) continue;
      Cdt::Face_circulator circulator = cdt_.incident_faces(handles_.back()), begin = circulator;
      do push(circulator);
      while (++circulator != begin);
    }
  }

  InterfacePlane plane_;
  PlaneRefinement options_;
  std::vector<GridPoint> points_;
  std::vector<Cdt::Vertex_handle> handles_;
  std::vector<char> contour_;
  std::size_t frame_;  // index of the first of the four vertices of the frame
  std::vector<Sub> subs_;
  std::unordered_map<std::uint64_t, std::int32_t> sub_of_;
  std::vector<Cdt::Face_handle> zone_;
  std::vector<Cdt::Edge> border_;
  mutable std::uint32_t steps_ = 0;
  Cdt cdt_;
};

}  // namespace detail

/// The triangulation of a plane. A pure function of the plane and the options.
/// Errors: BudgetError above PlaneRefinement::max_vertices; what `poll` throws. Cost: O(n log n) plus the refinement,
/// about linear in the result.
[[nodiscard]] inline PlaneMesh triangulate_plane(const InterfacePlane& plane, const PlaneRefinement& options) {
  detail::PlaneMesher mesher(plane, options);
  mesher.run();
  return mesher.extract();
}

/// The constrained Delaunay triangulation of a plane without any further point: the paper's. Errors: none (no
/// limit, so no BudgetError). Cost: O(n log n).
[[nodiscard]] inline PlaneMesh triangulate_plane(const InterfacePlane& plane) {
  PlaneRefinement options;
  options.gabriel = false;
  return triangulate_plane(plane, options);
}

}  // namespace slice2mesh
