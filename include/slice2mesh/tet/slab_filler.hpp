// SPDX-License-Identifier: MIT
/// @file
/// @brief SlabFiller: fills every slab of a conforming complex with the Delaunay tetrahedra of its two planes.
///
/// The Delaunay tetrahedralization of points on two parallel planes is the overlay of the two planar Voronoi diagrams
/// (Boissonnat, "Shape reconstruction from planar cross sections", CVGIP 44 (1988) 1-29). It is read off here without
/// any three-dimensional construction: a Voronoi edge of one plane is followed through the Voronoi cells of the other,
/// all tests are exact comparisons of distances in the plane. Ties are broken as if the upper plane were moved by an
/// infinitesimal
/// (-d, -d^2): of two equally near vertices a lower query takes the lexicographically larger, an upper query the
/// smaller. That makes any choice between co-circular vertices in the planes' own triangulations valid, and the result
/// unique.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/core/short_number.hpp"
#include "slice2mesh/tet/wall_facets.hpp"

namespace slice2mesh {

namespace detail {

/// The triangles that bound a slab from below or above, as seen from above.
struct Sheet {
  std::vector<GridPoint> points;                       // #V
  std::vector<std::int32_t> global;                    // #V, vertex of the complex
  std::vector<std::array<std::int32_t, 3>> triangles;  // #T by 3, counter-clockwise from above
  std::vector<std::array<std::int32_t, 3>>
      neighbors;  // #T by 3: triangle of the same region across the edge opposite to a vertex
  std::vector<std::array<std::int32_t, 3>> walls;  // #T by 3: wall over that edge where there is no neighbor
  std::vector<std::int32_t> regions;               // #T
  std::vector<char> on_wall;                       // #V: on an edge without neighbor
};

/// A corner of a sheet: a vertex as seen from one of its triangles.
struct Corner {
  std::int32_t triangle = kNone;
  std::int32_t index = 0;
};

/// A flat tet between two edges of one wall, where their bisectors cross inside of a region.
struct WallTet {
  std::array<std::int32_t, 4> vertices;  ///< of the complex: an edge below, an edge above
  std::int32_t region, wall;
};

class SlabFill {
public:
  /// `grid` is that of the points, for messages. `poll` is called now and then; what it throws ends the work.
  SlabFill(std::int32_t slab, const Grid& grid, const Sheet& bottom, const Sheet& top,
           const std::function<void()>& poll)
      : slab_(slab), grid_(grid), bottom_(bottom), top_(top), listen_(poll, 1 << 16) {}

  /// Calls emit(tet, region) with vertices of the complex, positively oriented.
  template <class Emit>
  void run(Emit&& emit) {
    fill<true>(emit);
    fill<false>(emit);
  }
  /// The flat tets that were left out.
  [[nodiscard]] const std::vector<WallTet>& wall_tets() const { return wall_tets_; }

private:
  [[noreturn]] void fail(const GridPoint& at) const {
    throw TetrahedralizationError(slab_, "contours are not conforming (Gabriel) near " + place_text(grid_, at));
  }
  static const GridPoint& vertex(const Sheet& s, std::int32_t t, std::int32_t i) {
    return s.points[std::size_t(s.triangles[std::size_t(t)][std::size_t(i % 3)])];
  }
  static std::int32_t vertex_id(const Sheet& s, const Corner& c) {
    return s.triangles[std::size_t(c.triangle)][std::size_t(c.index)];
  }

  /// The center that stands for a triangle, or for the outside of a wall edge: circumcenter, or middle of the edge.
  struct Center {
    const GridPoint* p[3];  // p[2] == nullptr: middle of p[0] p[1]
  };
  static Center center(const Sheet& s, std::int32_t t) {
    return {{&vertex(s, t, 0), &vertex(s, t, 1), &vertex(s, t, 2)}};
  }
  static Center middle(const Sheet& s, std::int32_t t, std::int32_t edge) {
    return {{&vertex(s, t, edge + 1), &vertex(s, t, edge + 2), nullptr}};
  }
  /// Is q the nearer one of p and q? kLower: the center belongs to the lower plane.
  template <bool kLower>
  static bool second_is_nearer(const Center& c, const GridPoint& p, const GridPoint& q) {
    const int s =
        c.p[2] ? nearer_to_circumcenter(*c.p[0], *c.p[1], *c.p[2], p, q) : nearer_to_midpoint(*c.p[0], *c.p[1], p, q);
    if (s != 0) return s > 0;
    return kLower ? p < q : q < p;
  }

  /// Follows the bisector of a and b (vertices of the plane kLower), to the right of a -> b, through the Voronoi cells
  /// of the other sheet, from the cell of `at` to that of `target`. Calls cross(u, w) for each Voronoi edge that is
  /// crossed, with the two corners.
  template <bool kLower, class Cross>
  Corner follow(const Sheet& sheet, Corner at, const GridPoint& a, const GridPoint& b, const Center& target,
                Cross&& cross) const {
    const auto beyond = [&](const Center& c) { return second_is_nearer<!kLower>(c, a, b); };
    std::size_t steps = 0;
    while (true) {
      if (++steps > sheet.triangles.size() + 8) fail(a);
      const std::int32_t u = vertex_id(sheet, at);
      const GridPoint& pu = sheet.points[std::size_t(u)];
      // The way out of the cell: two centers in a row around u, counter-clockwise, on the side of a and on that of b.
      // The cell of a vertex where walls meet at a reflex angle is not convex: then there may be two, one of them
      // beyond the walls. The way to the target is the one whose neighbor the target is nearer to; if there is none,
      // the target is in this cell.
      Corner out{}, w{};
      std::int32_t out_edge = kNone;  // edge opposite to this vertex index of out.triangle is crossed
      // The points that split a wall are rounded, so its two chains bend apart: the way may pass the end of the border
      // of two cells on the outside. It is crossed there all the same, if it is not crossed elsewhere.
      Corner outside{}, beside{};
      std::int32_t outside_edge = kNone;
      const bool first = beyond(center(sheet, at.triangle));
      const int passes = sheet.on_wall[std::size_t(u)] ? 2 : 1;
      for (int pass = 0; pass < passes && out_edge == kNone; ++pass) {
        Corner here = at;
        bool side = first;
        // Pass 0 turns towards the change of side that is the way out; pass 1 the other way, for open fans.
        const bool counter_clockwise = (pass == 0) != first;
        for (std::size_t turn = 0; turn <= sheet.triangles.size(); ++turn) {
          const auto t = std::size_t(here.triangle);
          listen_();
          // Around u counter-clockwise, the next triangle lies across the edge opposite to the vertex after u.
          const std::int32_t edge = (here.index + (counter_clockwise ? 1 : 2)) % 3;
          const std::int32_t next = sheet.neighbors[t][std::size_t(edge)];
          const bool next_side =
              next == kNone ? beyond(middle(sheet, here.triangle, edge)) : beyond(center(sheet, next));
          // The neighbor at the other end of the edge.
          const Corner end{here.triangle, (here.index + (counter_clockwise ? 2 : 1)) % 3};
          if (counter_clockwise ? (!side && next_side) : (side && !next_side)) {
            if (second_is_nearer<kLower>(target, pu, vertex(sheet, end.triangle, end.index))) {
              out = here;
              w = end;
              out_edge = edge;
              break;
            }
            if (passes == 1) return at;
          }
          if (next == kNone) {
            // Between two walls there may be two such ends: again the one that the target is nearer to.
            const GridPoint& nearest = outside_edge == kNone ? pu : vertex(sheet, beside.triangle, beside.index);
            if (second_is_nearer<kLower>(target, nearest, vertex(sheet, end.triangle, end.index))) {
              outside = here;
              beside = end;
              outside_edge = edge;
            }
            break;
          }
          if (next == at.triangle) break;
          here.triangle = next;
          here.index = index_of(sheet, next, u);
          side = next_side;
        }
      }
      if (out_edge == kNone) {
        if (outside_edge == kNone) return at;
        out = outside;
        w = beside;
        out_edge = outside_edge;
      }
      cross(out, w, out_edge);
      at = w;
    }
  }
  static std::int32_t index_of(const Sheet& s, std::int32_t t, std::int32_t v) {
    const auto& tri = s.triangles[std::size_t(t)];
    return tri[0] == v ? 0 : (tri[1] == v ? 1 : 2);
  }

  template <bool kLower, class Emit>
  void fill(Emit&& emit) {
    const Sheet& own = kLower ? bottom_ : top_;
    const Sheet& other = kLower ? top_ : bottom_;
    // Corners of the other sheet on each wall, by wall and region.
    struct WallCorner {
      std::int32_t wall, region;
      Corner corner;
      std::int64_t along = 0;  // the coordinate in which the wall is longer
      bool along_x = true;
      bool operator<(const WallCorner& o) const { return wall != o.wall ? wall < o.wall : region < o.region; }
    };
    std::vector<WallCorner> wall_corners;
    for (std::size_t t = 0; t < other.triangles.size(); ++t) {
      listen_();
      for (std::int32_t i = 0; i < 3; ++i)
        if (other.neighbors[t][std::size_t(i)] == kNone)
          for (std::int32_t j = 1; j <= 2; ++j)
            wall_corners.push_back({other.walls[t][std::size_t(i)], other.regions[t], {std::int32_t(t), (i + j) % 3}});
    }
    std::stable_sort(wall_corners.begin(), wall_corners.end(), listening(listen_, std::less<>()));
    for (auto first = wall_corners.begin(); first != wall_corners.end();) {
      auto last = first;
      GridPoint low{kGridLimit, kGridLimit}, high{-kGridLimit, -kGridLimit};
      for (; last != wall_corners.end() && !(*first < *last); ++last) {
        const GridPoint& p = vertex(other, last->corner.triangle, last->corner.index);
        low = {std::min(low.x, p.x), std::min(low.y, p.y)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y)};
      }
      for (auto it = first; it != last; ++it) {
        const GridPoint& p = vertex(other, it->corner.triangle, it->corner.index);
        it->along_x = high.x - low.x >= high.y - low.y;
        it->along = it->along_x ? p.x : p.y;
      }
      listen_(std::size_t(last - first));
      std::stable_sort(first, last,
                       listening(listen_, [](const WallCorner& c, const WallCorner& d) { return c.along < d.along; }));
      first = last;
    }

    std::vector<Corner> apex(own.triangles.size());
    std::vector<std::int32_t> queue;
    const auto emit_crossing = [&](std::int32_t t, std::int32_t a, std::int32_t b, std::int32_t wall) {
      return [&, t, a, b, wall](const Corner& u, const Corner& w, std::int32_t edge) {
        if constexpr (kLower) {
          const std::array<std::int32_t, 4> tet{own.global[std::size_t(a)], own.global[std::size_t(b)],
                                                other.global[std::size_t(vertex_id(other, u))],
                                                other.global[std::size_t(vertex_id(other, w))]};
          // Two edges on one wall span nothing, but for the rounding of their ends.
          if (wall != kNone && other.neighbors[std::size_t(u.triangle)][std::size_t(edge)] == kNone &&
              other.walls[std::size_t(u.triangle)][std::size_t(edge)] == wall) {
            wall_tets_.push_back({tet, own.regions[std::size_t(t)], wall});
            return;
          }
          emit(tet, own.regions[std::size_t(t)]);
        } else {
          (void)u, (void)w, (void)edge, (void)t, (void)a, (void)b, (void)wall;
        }
      };
    };
    // From the walls inwards: the vertex of the wall nearest to the middle of a wall edge starts the way.
    for (std::size_t t = 0; t < own.triangles.size(); ++t) {
      for (std::int32_t i = 0; i < 3; ++i) {
        if (own.neighbors[t][std::size_t(i)] != kNone) continue;
        if (!kLower && apex[t].triangle != kNone) continue;
        const std::int32_t wall = own.walls[t][std::size_t(i)];
        const Center from = middle(own, std::int32_t(t), i);
        const auto range =
            std::equal_range(wall_corners.begin(), wall_corners.end(), WallCorner{wall, own.regions[t], {}});
        if (wall == kNone || range.first == range.second) fail(*from.p[0]);
        // Vertices of a wall lie on a line up to a few pitches, and two of them have two corners each: the nearest is
        // among the next ones along the wall.
        constexpr std::ptrdiff_t kWindow = 16;  // corners on either side
        const std::int64_t doubled_middle =
            range.first->along_x ? from.p[0]->x + from.p[1]->x : from.p[0]->y + from.p[1]->y;
        const auto at = std::lower_bound(range.first, range.second, doubled_middle,
                                         [](const WallCorner& c, std::int64_t m) { return 2 * c.along < m; });
        const auto window_first = at - std::min(at - range.first, kWindow),
                   window_last = at + std::min(range.second - at, kWindow);
        listen_(std::size_t(window_last - window_first));
        Corner best = window_first->corner;
        for (auto it = window_first; it != window_last; ++it) {
          const GridPoint &p = vertex(other, best.triangle, best.index),
                          &q = vertex(other, it->corner.triangle, it->corner.index);
          if (p != q && second_is_nearer<kLower>(from, p, q)) best = it->corner;
        }
        // Inwards is to the left of the edge, so to the right of its reverse.
        const std::int32_t a = own.triangles[t][std::size_t((i + 2) % 3)],
                           b = own.triangles[t][std::size_t((i + 1) % 3)];
        const Corner end = follow<kLower>(other, best, own.points[std::size_t(a)], own.points[std::size_t(b)],
                                          center(own, std::int32_t(t)), emit_crossing(std::int32_t(t), a, b, wall));
        if (apex[t].triangle == kNone) {
          apex[t] = end;
          queue.push_back(std::int32_t(t));
        } else if (vertex_id(other, apex[t]) != vertex_id(other, end)) {
          fail(own.points[std::size_t(a)]);
        }
      }
    }
    // Through the inner edges, each once.
    for (std::size_t next = 0; next < queue.size(); ++next) {
      const auto t = std::size_t(queue[next]);
      for (std::int32_t i = 0; i < 3; ++i) {
        const std::int32_t n = own.neighbors[t][std::size_t(i)];
        if (n == kNone) continue;
        const bool known = apex[std::size_t(n)].triangle != kNone;
        if (!kLower && known) continue;
        if (known && done_.count(edge_key(std::int32_t(t), n)) != 0) continue;
        const std::int32_t a = own.triangles[t][std::size_t((i + 1) % 3)],
                           b = own.triangles[t][std::size_t((i + 2) % 3)];
        const Corner end = follow<kLower>(other, apex[t], own.points[std::size_t(a)], own.points[std::size_t(b)],
                                          center(own, n), emit_crossing(std::int32_t(t), a, b, kNone));
        if constexpr (kLower) done_.emplace(edge_key(std::int32_t(t), n), 1);
        if (!known) {
          apex[std::size_t(n)] = end;
          queue.push_back(n);
        } else if (vertex_id(other, apex[std::size_t(n)]) != vertex_id(other, end)) {
          fail(own.points[std::size_t(a)]);
        }
      }
    }
    for (std::size_t t = 0; t < own.triangles.size(); ++t) {
      if (apex[t].triangle == kNone) fail(vertex(own, std::int32_t(t), 0));
      const auto& tri = own.triangles[t];
      const std::int32_t top_or_bottom = other.global[std::size_t(vertex_id(other, apex[t]))];
      const std::int32_t a = own.global[std::size_t(tri[0])], b = own.global[std::size_t(tri[1])],
                         c = own.global[std::size_t(tri[2])];
      emit(kLower ? std::array<std::int32_t, 4>{a, b, c, top_or_bottom}
                  : std::array<std::int32_t, 4>{a, c, b, top_or_bottom},
           own.regions[t]);
    }
  }
  static std::uint64_t edge_key(std::int32_t a, std::int32_t b) {
    if (a > b) std::swap(a, b);
    return (std::uint64_t(std::uint32_t(a)) << 32) | std::uint32_t(b);
  }

  std::int32_t slab_;
  const Grid& grid_;
  const Sheet& bottom_;
  const Sheet& top_;
  mutable Poll listen_;  // triangles looked at
  std::unordered_map<std::uint64_t, char> done_;
  std::vector<WallTet> wall_tets_;
};

/// Makes the two sides of inner walls agree. Split points of a wall's two chains are rounded apart, so the bisectors of
/// two of its edges may cross far inside of the region on one side: that region then has the other diagonal on the
/// wall, with a flat tet in between that belongs to nobody. Here the diagonal is taken out of the region: the tets
/// around it and the flat one are filled anew without it. Where that does not work the flat tet stays, as an element.
class WallTets {
public:
  /// `first`: the first tet of the slab in the mesh. `poll` is called now and then.
  WallTets(const Plc& plc, Mesh& mesh, std::size_t first, std::int32_t slab, const std::function<void()>& poll)
      : plc_(plc), mesh_(mesh), first_(first), slab_(slab), low_(plc.slab_planes[std::size_t(slab)][0]),
        listen_(poll, 1 << 14) {}

  void close(const std::vector<WallTet>& flat) {
    for (const WallTet& w : flat)
      for (const std::int32_t v : w.vertices) tets_at_.try_emplace(v);
    for (std::size_t t = first_; t < mesh_.tets.size(); ++t) {
      listen_();
      list(t);
    }
    alive_.assign(mesh_.tets.size() - first_, 1);
    for (const WallTet& w : flat)
      if (volume(w.vertices) > 0) add(w.vertices, w.region);
    // Those that were crossed last lie innermost.
    std::vector<char> done(flat.size(), 0);
    for (bool again = true; again;) {
      again = false;
      for (std::size_t k = flat.size(); k-- > 0;) {
        listen_(64);
        if (done[k] || volume(flat[k].vertices) <= 0 || !take_out(flat[k])) continue;
        done[k] = 1;
        again = true;
      }
    }
    std::size_t end = first_;
    for (std::size_t t = first_; t < mesh_.tets.size(); ++t) {
      if (!alive_[t - first_]) continue;
      mesh_.tets[end] = mesh_.tets[t];
      mesh_.tet_region[end++] = mesh_.tet_region[t];
    }
    mesh_.tets.resize(end);
    mesh_.tet_region.resize(end);
    mesh_.tet_slab.resize(end);
  }

private:
  using Tet = std::array<std::int32_t, 4>;
  [[nodiscard]] const GridPoint& point(std::int32_t v) const { return plc_.vertices[std::size_t(v)]; }
  /// Six times the volume, for a slab of height one; exact.
  [[nodiscard]] Int128 volume(const Tet& t) const {
    const GridPoint& p = point(t[0]);
    const auto up = [&](std::int32_t v) { return plc_.vertex_plane[std::size_t(v)] == low_ ? 0 : 1; };
    const int h = up(t[0]);
    return (up(t[1]) - h) * cross(p, point(t[2]), point(t[3])) + (up(t[2]) - h) * cross(p, point(t[3]), point(t[1])) +
           (up(t[3]) - h) * cross(p, point(t[1]), point(t[2]));
  }
  void list(std::size_t t) {
    for (const std::int32_t v : mesh_.tets[t]) {
      const auto it = tets_at_.find(v);
      if (it != tets_at_.end()) it->second.push_back(t);
    }
  }
  void add(const Tet& tet, std::int32_t region) {
    mesh_.tets.push_back(tet);
    mesh_.tet_slab.push_back(slab_);
    mesh_.tet_region.push_back(region);
    alive_.push_back(1);
    list(mesh_.tets.size() - 1);
  }
  /// Takes the diagonal that the wall does not have out of the region. False if that is not possible.
  bool take_out(const WallTet& flat) {
    const auto [a, b, u, w] = flat.vertices;
    const GridPoint &pa = point(a), &pb = point(b), &pu = point(u), &pw = point(w);
    const bool same_way = Int128(pb.x - pa.x) * (pw.x - pu.x) + Int128(pb.y - pa.y) * (pw.y - pu.y) > 0;
    const std::int32_t x = same_way ? a : b;
    // The tets around x w, in a row.
    std::vector<std::size_t> around;
    std::unordered_map<std::int32_t, std::int32_t> next;
    for (const std::size_t t : tets_at_.at(x)) {
      Tet tet = mesh_.tets[t];
      if (!alive_[t - first_] || mesh_.tet_region[t] != flat.region) continue;
      const auto at_x = std::find(tet.begin(), tet.end(), x) - tet.begin();
      // Even permutations: x first, then w second.
      if (at_x != 0) {
        std::swap(tet[0], tet[std::size_t(at_x)]);
        std::swap(tet[at_x == 1 ? 2 : 1], tet[3 == at_x ? 2 : 3]);
      }
      const auto at_w = std::find(tet.begin(), tet.end(), w) - tet.begin();
      if (at_w == 4) continue;
      if (at_w == 2) tet = {tet[0], tet[2], tet[3], tet[1]};
      if (at_w == 3) tet = {tet[0], tet[3], tet[1], tet[2]};
      if (!next.emplace(tet[2], tet[3]).second) return false;
      around.push_back(t);
    }
    constexpr std::size_t kMostAround = 64;
    if (around.size() < 3 || around.size() > kMostAround) return false;
    std::vector<std::int32_t> ring{next.begin()->first};
    // The same start in every run.
    for (const auto& [from, to] : next) ring[0] = std::min(ring[0], from);
    while (ring.size() < around.size()) {
      const auto it = next.find(ring.back());
      if (it == next.end() || it->second == ring[0]) return false;
      ring.push_back(it->second);
    }
    if (next.find(ring.back()) == next.end() || next.at(ring.back()) != ring[0]) return false;
    // The triangulation of the ring whose smallest tet is largest.
    const std::size_t n = ring.size();
    std::vector<Int128> best(n * n, 0);
    std::vector<std::size_t> middle(n * n, 0);
    const Int128 least = volume(flat.vertices);
    for (std::size_t i = 0; i + 1 < n; ++i) best[i * n + i + 1] = Int128(1) << 100;
    for (std::size_t span = 2; span < n; ++span)
      for (std::size_t i = 0; i + span < n; ++i)
        for (std::size_t j = i + span, k = i + 1; k < j; ++k) {
          const Int128 worst = std::min({best[i * n + k], best[k * n + j], volume({ring[i], ring[k], ring[j], w}),
                                         volume({ring[i], ring[j], ring[k], x})});
          if (worst <= best[i * n + j]) continue;
          best[i * n + j] = worst;
          middle[i * n + j] = k;
        }
    if (best[n - 1] <= least) return false;
    for (const std::size_t t : around) alive_[t - first_] = 0;
    std::vector<std::array<std::size_t, 2>> stack{{0, n - 1}};
    while (!stack.empty()) {
      const auto [i, j] = stack.back();
      stack.pop_back();
      if (j - i < 2) continue;
      const std::size_t k = middle[i * n + j];
      add({ring[i], ring[k], ring[j], w}, flat.region);
      add({ring[i], ring[j], ring[k], x}, flat.region);
      stack.push_back({i, k});
      stack.push_back({k, j});
    }
    return true;
  }

  const Plc& plc_;
  Mesh& mesh_;
  std::size_t first_;
  std::int32_t slab_;
  std::int32_t low_;
  std::vector<char> alive_;
  std::unordered_map<std::int32_t, std::vector<std::size_t>> tets_at_;
  Poll listen_;  // tets looked at
};

/// The sheets of every slab of a complex.
class Sheets {
public:
  /// `poll` is called now and then.
  Sheets(const Plc& plc, const std::function<void()>& poll)
      : plc_(plc), bottom_(plc.slabs.size()), top_(plc.slabs.size()), wall_facets_(plc.slabs.size()),
        local_(plc.vertices.size(), kNone) {
    Poll listen(poll, 1 << 16);
    for (std::size_t f = 0; f < plc.facets.size(); ++f) {
      listen();
      const Facet& facet = plc.facets[f];
      switch (facet.label) {
        case FacetLabel::Down: bottom_[std::size_t(facet.back.slab)].push_back(std::int32_t(f)); break;
        case FacetLabel::Up: top_[std::size_t(facet.back.slab)].push_back(std::int32_t(f)); break;
        case FacetLabel::Interface:
          bottom_[std::size_t(facet.front.slab)].push_back(std::int32_t(f));
          top_[std::size_t(facet.back.slab)].push_back(std::int32_t(f));
          break;
        case FacetLabel::Wall:
        case FacetLabel::InnerWall: wall_facets_[std::size_t(facet.back.slab)].push_back(std::int32_t(f)); break;
      }
    }
  }
  /// The sheet below (top = false) or above a slab. `poll` is called now and then.
  [[nodiscard]] Sheet make(std::int32_t slab, bool top, const std::function<void()>& poll) {
    Sheet sheet;
    Poll listen(poll, 1 << 16);
    const std::vector<std::int32_t>& facets = (top ? top_ : bottom_)[std::size_t(slab)];
    sheet.triangles.reserve(facets.size());
    for (const std::int32_t f : facets) {
      listen();
      const Facet& facet = plc_.facets[std::size_t(f)];
      std::array<std::int32_t, 3> tri = facet.vertices;
      if (facet.label == FacetLabel::Down) std::swap(tri[1], tri[2]);
      for (std::int32_t& v : tri) {
        std::int32_t& index = local_[std::size_t(v)];
        if (index == kNone) {
          index = std::int32_t(sheet.points.size());
          sheet.points.push_back(plc_.vertices[std::size_t(v)]);
          sheet.global.push_back(v);
        }
        v = index;
      }
      sheet.triangles.push_back(tri);
      sheet.regions.push_back(facet.label == FacetLabel::Interface && !top ? facet.front.region : facet.back.region);
    }
    sheet.neighbors.assign(sheet.triangles.size(), {kNone, kNone, kNone});
    sheet.walls.assign(sheet.triangles.size(), {kNone, kNone, kNone});
    struct Half {
      std::int32_t high, triangle, index;  // index -1: a wall; its id in `triangle`
      bool operator<(const Half& o) const {
        if (high != o.high) return high < o.high;
        return index != o.index ? index < o.index : triangle < o.triangle;
      }
    };
    // By their lower vertex: counted, then filled in.
    std::vector<std::size_t> start(sheet.points.size() + 1, 0);
    std::vector<Half> halves;
    const auto visit = [&](auto&& put) {
      for (std::size_t t = 0; t < sheet.triangles.size(); ++t)
        for (std::int32_t i = 0; i < 3; ++i) {
          listen();
          const auto [a, b] =
              std::minmax({sheet.triangles[t][std::size_t((i + 1) % 3)], sheet.triangles[t][std::size_t((i + 2) % 3)]});
          put(a, Half{b, std::int32_t(t), i});
        }
      const std::int32_t plane = plc_.slab_planes[std::size_t(slab)][top ? 1 : 0];
      for (const std::int32_t f : wall_facets_[std::size_t(slab)]) {
        const Facet& facet = plc_.facets[std::size_t(f)];
        for (std::size_t i = 0; i < 3; ++i) {
          listen();
          const std::int32_t u = facet.vertices[i], w = facet.vertices[(i + 1) % 3];
          if (plc_.vertex_plane[std::size_t(u)] != plane || plc_.vertex_plane[std::size_t(w)] != plane) continue;
          const auto [a, b] = std::minmax({local_[std::size_t(u)], local_[std::size_t(w)]});
          if (a != kNone) put(a, Half{b, facet.wall, -1});
        }
      }
    };
    visit([&](std::int32_t low, const Half&) { ++start[std::size_t(low) + 1]; });
    for (std::size_t v = 1; v < start.size(); ++v) start[v] += start[v - 1];
    halves.resize(start.back());
    std::vector<std::size_t> next(start.begin(), start.end() - 1);
    visit([&](std::int32_t low, const Half& half) { halves[next[std::size_t(low)]++] = half; });
    for (std::size_t v = 0; v + 1 < start.size(); ++v) {
      listen();
      sort_listening(halves.begin() + std::ptrdiff_t(start[v]), halves.begin() + std::ptrdiff_t(start[v + 1]), listen);
      for (std::size_t i = start[v]; i < start[v + 1];) {
        std::size_t j = i;
        std::int32_t wall = kNone;
        for (; j < start[v + 1] && halves[j].high == halves[i].high; ++j)
          if (halves[j].index < 0) wall = halves[j].triangle;
        for (std::size_t k = i; k < j; ++k) {
          if (halves[k].index < 0) continue;
          const auto t = std::size_t(halves[k].triangle);
          sheet.walls[t][std::size_t(halves[k].index)] = wall;
          if (wall != kNone) continue;
          for (std::size_t m = i; m < j; ++m)
            if (m != k && halves[m].index >= 0 && sheet.regions[std::size_t(halves[m].triangle)] == sheet.regions[t])
              sheet.neighbors[t][std::size_t(halves[k].index)] = halves[m].triangle;
        }
        i = j;
      }
    }
    sheet.on_wall.assign(sheet.points.size(), 0);
    for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
      listen();
      for (std::size_t i = 0; i < 3; ++i)
        if (sheet.neighbors[t][i] == kNone)
          for (std::size_t j = 1; j <= 2; ++j) sheet.on_wall[std::size_t(sheet.triangles[t][(i + j) % 3])] = 1;
    }
    for (const std::int32_t v : sheet.global) local_[std::size_t(v)] = kNone;
    return sheet;
  }

private:
  const Plc& plc_;
  std::vector<std::vector<std::int32_t>> bottom_, top_, wall_facets_;
  std::vector<std::int32_t> local_;
};

}  // namespace detail

/// The default tetrahedralizer. Needs a complex with inner faces whose contour edges are Gabriel in their planes; adds
/// no vertex, keeps every horizontal facet, and every wall up to the diagonals of ties on bent walls. Errors:
/// TetrahedralizationError with the slab where the complex is not conforming; BudgetError above `max_tets`; Cancelled,
/// and what `progress` throws. Cost: about linear.
struct SlabFiller {
  /// Listener; may cancel.
  Progress progress;
  std::int64_t max_tets = 0;  ///< largest number of tets; 0: no limit

  /// The mesh. Errors: see above.
  [[nodiscard]] Mesh operator()(const Plc& plc) const {
    if (!plc.has_inner_faces) throw TetrahedralizationError(-1, "the slab filler needs a complex with inner faces");
    Mesh mesh;
    mesh.slabs = plc.slabs;
    mesh.regions = plc.regions;
    mesh.facets = plc.facets;
    mesh.vertices.reserve(plc.vertices.size());
    const std::function<void()> begun = [&] { report(progress, Stage::Tetrahedralize, 0); };
    detail::Poll listen_at_first(begun, 1 << 16);
    for (std::size_t v = 0; v < plc.vertices.size(); ++v) {
      listen_at_first();
      mesh.vertices.push_back(plc.position(v));
    }
    std::vector<char> inner_wall;
    std::size_t horizontal = 0;
    for (const Facet& facet : plc.facets) {
      listen_at_first();
      if (facet.wall < 0) {
        ++horizontal;
        continue;
      }
      if (std::size_t(facet.wall) >= inner_wall.size()) inner_wall.resize(std::size_t(facet.wall) + 1, 0);
      inner_wall[std::size_t(facet.wall)] = facet.label == FacetLabel::InnerWall;
    }
    // Columns are three tets over each triangle; what is no column has more.
    mesh.tets.reserve(3 * horizontal);
    mesh.tet_slab.reserve(3 * horizontal);
    mesh.tet_region.reserve(3 * horizontal);
    detail::Sheets sheets(plc, begun);
    constexpr std::size_t kPollEvery = 4096;  // tets
    const auto poll = [&](std::size_t s) {
      report(progress, Stage::Tetrahedralize, double(s) / double(plc.slabs.size()));
      if (max_tets > 0 && static_cast<std::int64_t>(mesh.tets.size()) > max_tets)
        throw BudgetError(Stage::Tetrahedralize, "the mesh needs more tets than max_tets");
    };
    for (std::size_t s = 0; s < plc.slabs.size(); ++s) {
      poll(s);
      const std::function<void()> listen = [&] { poll(s); };
      const auto slab = static_cast<std::int32_t>(s);
      const detail::Sheet bottom = sheets.make(slab, false, listen), top = sheets.make(slab, true, listen);
      const std::size_t first = mesh.tets.size();
      detail::SlabFill fill(slab, plc.grid, bottom, top, listen);
      fill.run([&](const std::array<std::int32_t, 4>& tet, std::int32_t region) {
        mesh.tets.push_back(tet);
        mesh.tet_slab.push_back(slab);
        mesh.tet_region.push_back(region);
        if (mesh.tets.size() % kPollEvery == 0) poll(s);
      });
      std::vector<detail::WallTet> flat;
      for (const detail::WallTet& w : fill.wall_tets())
        if (inner_wall[std::size_t(w.wall)]) flat.push_back(w);
      if (!flat.empty()) detail::WallTets(plc, mesh, first, slab, listen).close(flat);
      poll(s);
    }
    const std::function<void()> ends = [&] { report(progress, Stage::Tetrahedralize, 1); };
    take_wall_diagonals(plc, mesh, ends);
    ends();
    return mesh;
  }
};

}  // namespace slice2mesh
