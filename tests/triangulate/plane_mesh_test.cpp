// SPDX-License-Identifier: MIT
#include "slice2mesh/triangulate/plane_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "flooded_faces.hpp"
#include "plc/chain.hpp"
#include "slice2mesh/arrange/faces.hpp"
#include "test_support.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;

namespace {

struct Seen {
  std::size_t planes = 0, contour_edges = 0, split = 0, interior = 0;
};

detail::Int128 shoelace(const PlaneMesh& mesh, const std::vector<std::int32_t>& chain) {
  detail::Int128 sum = 0;
  for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
    const GridPoint &p = mesh.vertices[std::size_t(chain[i])], &q = mesh.vertices[std::size_t(chain[i + 1])];
    sum += detail::Int128(p.x) * q.y - detail::Int128(p.y) * q.x;
  }
  return sum;
}

/// Everything that holds for the triangulation of a plane; `gabriel` for the conforming ones.
void check_mesh(const Contours& contours, const InterfacePlane& plane, const PlaneMesh& mesh, bool gabriel,
                Seen& seen) {
  ++seen.planes;
  const auto point = [&](std::int32_t v) -> const GridPoint& { return mesh.vertices[std::size_t(v)]; };
  REQUIRE(mesh.vertices.size() >= plane.overlay.vertices.size());
  for (std::size_t v = 0; v < plane.overlay.vertices.size(); ++v)
    REQUIRE(mesh.vertices[v] == plane.overlay.vertices[v]);
  REQUIRE(std::set<GridPoint>(mesh.vertices.begin(), mesh.vertices.end()).size() == mesh.vertices.size());

  // Triangles turn left; each directed edge has one.
  std::map<std::pair<std::int32_t, std::int32_t>, std::size_t> half;
  REQUIRE(mesh.sides.size() == mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& tri = mesh.triangles[t];
    REQUIRE(detail::orientation(point(tri[0]), point(tri[1]), point(tri[2])) > 0);
    REQUIRE((!mesh.sides[t][0].empty() || !mesh.sides[t][1].empty()));
    for (std::size_t k = 0; k < 3; ++k) REQUIRE(half.emplace(std::make_pair(tri[k], tri[(k + 1) % 3]), t).second);
  }
  const auto apex = [&](std::size_t t, std::int32_t a, std::int32_t b) {
    for (const std::int32_t v : mesh.triangles[t])
      if (v != a && v != b) return v;
    return kNone;
  };

  // Contour edges are chains of edges that separate what they should, and are Gabriel.
  std::set<std::pair<std::int32_t, std::int32_t>> contour;
  const Outline nothing;
  for (const bool above : {false, true}) {
    const std::int32_t slab = above ? plane.slab_above : plane.slab_below;
    const Outline& outline = slab == kNone ? nothing : contours.outlines[std::size_t(slab)];
    const auto& chains = above ? mesh.above_chain : mesh.below_chain;
    REQUIRE(chains.size() == outline.edges.size());
    detail::Int128 lifted = 0, triangles = 0;
    for (std::size_t e = 0; e < chains.size(); ++e) {
      const Outline::Edge& edge = outline.edges[e];
      REQUIRE(chains[e].size() >= 2);
      REQUIRE(point(chains[e].front()) == outline.vertices[std::size_t(edge.a)]);
      REQUIRE(point(chains[e].back()) == outline.vertices[std::size_t(edge.b)]);
      seen.split += chains[e].size() - 2;
      for (std::size_t i = 0; i + 1 < chains[e].size(); ++i) {
        const std::int32_t a = chains[e][i], b = chains[e][i + 1];
        contour.insert(std::minmax(a, b));
        ++seen.contour_edges;
        REQUIRE((mesh.fixed[std::size_t(a)] != 0 && mesh.fixed[std::size_t(b)] != 0));
        for (const bool left : {true, false}) {
          const auto it = half.find(left ? std::make_pair(a, b) : std::make_pair(b, a));
          const std::int32_t region = left ? edge.left : edge.right;
          const Side own = it == half.end() ? Side{} : mesh.sides[it->second][above ? 1 : 0];
          REQUIRE(own == Side{region == kNone ? kNone : slab, region});
          if (it != half.end() && gabriel)
            REQUIRE_FALSE(detail::in_diametral_disc(point(a), point(b), point(apex(it->second, a, b))));
        }
      }
      const detail::Int128 term = shoelace(mesh, chains[e]);
      if (edge.left != kNone) lifted += term;
      if (edge.right != kNone) lifted -= term;
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      if (!mesh.sides[t][above ? 1 : 0].empty())
        triangles +=
            detail::cross(point(mesh.triangles[t][0]), point(mesh.triangles[t][1]), point(mesh.triangles[t][2]));
    REQUIRE(triangles == lifted);
  }

  // Edges off the contours have the same cells on both sides, and are locally Delaunay.
  for (const auto& [edge, t] : half) {
    if (contour.count(std::minmax(edge.first, edge.second)) != 0) continue;
    const auto other = half.find({edge.second, edge.first});
    REQUIRE(other != half.end());
    REQUIRE(mesh.sides[t] == mesh.sides[other->second]);
    const auto& tri = mesh.triangles[t];
    REQUIRE(detail::nearer_to_circumcenter(point(tri[0]), point(tri[1]), point(tri[2]), point(tri[0]),
                                           point(apex(other->second, edge.first, edge.second))) <= 0);
  }
  for (const char f : mesh.fixed) seen.interior += f == 0 ? 1U : 0U;
}

}  // namespace

TEST_CASE("conforming triangulations hold every contour as a chain of Gabriel edges, and the exact areas") {
  Seen seen;
  for (const NamedStack& named : generated_stacks()) {
    INFO(named.name);
    const Chain chain = run_chain(named.stack);
    for (std::size_t k = 0; k < chain.planes.size(); ++k) {
      INFO("plane " << k);
      check_mesh(chain.contours, chain.lifted[k], chain.planes[k], true, seen);
    }
  }
  for (std::uint32_t seed = 1; seed <= 8; ++seed) {
    INFO("seed " << seed);
    const Chain chain = run_chain(random_stack(seed));
    for (std::size_t k = 0; k < chain.planes.size(); ++k) {
      INFO("plane " << k);
      check_mesh(chain.contours, chain.lifted[k], chain.planes[k], true, seen);
    }
  }
  CHECK(seen.planes > 60);
  CHECK(seen.contour_edges > 5000);
  CHECK(seen.split > 500);
  CHECK(seen.interior > 500);
}

TEST_CASE("plain triangulations hold every contour and have no other vertices") {
  Seen seen;
  for (std::uint32_t seed = 20; seed <= 26; ++seed) {
    INFO("seed " << seed);
    ChainOptions options;
    options.eps = seed % 2 == 0 ? 0.1 : 0;
    const Chain chain = run_chain(random_stack(seed), options);
    for (const InterfacePlane& plane : chain.lifted) {
      const PlaneMesh mesh = triangulate_plane(plane);
      REQUIRE(mesh.vertices.size() == plane.overlay.vertices.size());
      check_mesh(chain.contours, plane, mesh, false, seen);
    }
  }
  CHECK(seen.planes > 20);
  CHECK(seen.interior == 0);
}

TEST_CASE("split points that are rounded to beside a short edge leave every edge Delaunay") {
  // The vertex opposite to an edge of a few hundred or thousand pitches is so far away that the circumcircle reaches
  // over the edge by less than a pitch. A vertex of the other contour calls for a split, whose point lies beyond.
  struct Place {
    GridPoint end, vertex;
    std::int64_t far;
  };
  Contours contours;
  contours.grid.pitch = 1;
  contours.thickness = 1;
  contours.regions.resize(1);
  contours.slabs = {{0, 1}, {1, 2}};
  const auto outline = [](std::vector<GridPoint> points) {
    Outline result;
    for (std::int32_t v = 0; v < std::int32_t(points.size()); ++v)
      result.edges.push_back({v, (v + 1) % std::int32_t(points.size()), 0, kNone});
    result.vertices = std::move(points);
    return result;
  };
  Seen seen;
  for (const Place& place : {Place{{672, -704}, {-32, -352}, 1073741824}, {{5120, -1904}, {1680, -624}, 34359738368}}) {
    INFO("far vertices at " << place.far);
    const auto [end, v, far] = place;
    contours.outlines = {outline({{0, 0}, end, {far, far}, {-far, far}}),
                         outline({v, {v.x - far / 2, -far}, {v.x + far / 2, -far}})};
    const InterfacePlane plane = lift(contours, 0, 1);
    check_mesh(contours, plane, triangulate_plane(plane, {}), false, seen);
  }
  CHECK(seen.split >= 20);
}

TEST_CASE("a plane with a budget of vertices throws when it needs more") {
  const Chain chain = run_chain(stack_of({{rectangle(0, 0, 4, 3)}, {rectangle(0, 0, 4, 3)}}));
  PlaneRefinement refinement;
  refinement.interior = {};
  refinement.max_vertices = 3;
  refinement.radius_edge_ratio = 1.1;
  CHECK_THROWS_AS(triangulate_plane(chain.lifted[1], refinement), BudgetError);
}

TEST_CASE("points that find no place ask whether to go on, by the triangles that they look at") {
  // In a circle every point is in the circumcircles of nearly all triangles; beside an edge it finds no place.
  constexpr int kEdges = 1000, kPoints = 200;
  std::vector<Point2> circle;
  for (int i = 0; i < kEdges; ++i)
    circle.push_back(
        {10 * std::cos(2 * 3.14159265358979 * i / kEdges), 10 * std::sin(2 * 3.14159265358979 * i / kEdges)});
  ChainOptions options;
  options.eps = 0;
  options.contour_size = 1000;
  options.interior = false;
  options.radius_edge_ratio = 0;
  const Chain chain = run_chain(stack_of({{loop(circle)}, {loop(circle)}}), options);
  const InterfacePlane& plane = chain.lifted.front();
  REQUIRE(plane.overlay.edges.size() >= kEdges);
  const auto triangulate = [&](const std::vector<GridPoint>& interior, std::size_t& calls) {
    PlaneRefinement refinement;
    refinement.radius_edge_ratio = 0;
    refinement.interior = interior;
    refinement.poll = [&] { ++calls; };
    return triangulate_plane(plane, refinement);
  };
  std::vector<GridPoint> beside;
  for (std::size_t e = 0; e < kPoints; ++e) {
    const GridPoint &a = plane.overlay.vertices[std::size_t(plane.overlay.edges[e].a)],
                    &b = plane.overlay.vertices[std::size_t(plane.overlay.edges[e].b)];
    const double x = double(a.x + b.x) / 2, y = double(a.y + b.y) / 2;
    beside.push_back({std::llround(0.9995 * x), std::llround(0.9995 * y)});  // towards the center, by 0.005 mm
  }
  std::size_t without = 0, with = 0;
  const PlaneMesh empty = triangulate({}, without), mesh = triangulate(beside, with);
  CHECK(mesh.vertices.size() == empty.vertices.size());
  CHECK(with >= without + kPoints * kEdges / 4096);
}

TEST_CASE("the same plane gives the same triangulation") {
  const Chain a = run_chain(random_stack(5)), b = run_chain(random_stack(5));
  REQUIRE(a.planes.size() == b.planes.size());
  for (std::size_t k = 0; k < a.planes.size(); ++k) {
    CHECK(a.planes[k].vertices == b.planes[k].vertices);
    CHECK(a.planes[k].triangles == b.planes[k].triangles);
  }
}

TEST_CASE("faces of an arrangement know how often each loop winds around them") {
  // Two squares, one of them wound twice.
  std::vector<TaggedSegment> segments;
  const auto add = [&](std::int64_t x0, std::int64_t x1, std::int32_t tag) {
    const std::int64_t u = kContourStep * 10;
    const GridPoint p[4] = {{x0 * u, 0}, {x1 * u, 0}, {x1 * u, 4 * u}, {x0 * u, 4 * u}};
    for (int i = 0; i < 4; ++i) segments.push_back({p[i], p[(i + 1) % 4], tag});
  };
  add(0, 4, 0);
  add(2, 6, 1);
  add(2, 6, 1);
  const Arrangement arrangement = snap_round(segments);
  const ArrangementFaces faces = find_faces(arrangement);
  REQUIRE(faces.windings.size() == 4);
  CHECK(faces.windings[0].empty());
  std::set<std::vector<std::pair<std::int32_t, std::int32_t>>> states;
  for (std::size_t f = 1; f < 4; ++f) {
    std::vector<std::pair<std::int32_t, std::int32_t>> state;
    for (const EdgeTag& tag : faces.windings[f]) state.emplace_back(tag.tag, tag.winding);
    states.insert(state);
  }
  CHECK(states == std::set<std::vector<std::pair<std::int32_t, std::int32_t>>>{{{0, 1}}, {{0, 1}, {1, 2}}, {{1, 2}}});
}

TEST_CASE("faces by a sweep are those that flooding a triangulation finds", "[triangulate]") {
  std::mt19937 random(7);
  int with_many_faces = 0;
  for (int round = 0; round < 60; ++round) {
    INFO("round " << round);
    // Few different coordinates: crossings, common vertices, edges on each other, components within others.
    const int wide = round % 3 == 0 ? 6 : (round % 3 == 1 ? 40 : 4000);
    std::uniform_int_distribution<std::int64_t> coordinate(-wide, wide);
    std::vector<TaggedSegment> segments;
    const int polygons = 1 + round % 12;
    for (int polygon = 0; polygon < polygons; ++polygon) {
      const std::int64_t x = coordinate(random) * 2, y = coordinate(random) * 2;
      std::vector<GridPoint> points(std::size_t(3 + round % 4));
      for (GridPoint& p : points)
        p = {(x + coordinate(random)) * 64 * kContourStep, (y + coordinate(random)) * 64 * kContourStep};
      for (std::size_t i = 0; i < points.size(); ++i)
        segments.push_back({points[i], points[(i + 1) % points.size()], polygon % 3});
    }
    const Arrangement arrangement = snap_round(segments);
    const ArrangementFaces swept = find_faces(arrangement);
    const ArrangementFaces flooded = flooded_faces(arrangement);
    if (swept.windings.size() > 20) ++with_many_faces;
    REQUIRE(swept.of_edge.size() == flooded.of_edge.size());
    REQUIRE(swept.windings.size() == flooded.windings.size());
    std::map<std::int32_t, std::int32_t> same{{0, 0}};
    std::set<std::int32_t> taken;
    for (std::size_t e = 0; e < swept.of_edge.size(); ++e)
      for (std::size_t side = 0; side < 2; ++side)
        CHECK(same.emplace(swept.of_edge[e][side], flooded.of_edge[e][side]).first->second == flooded.of_edge[e][side]);
    for (const auto& [f, g] : same) {
      CHECK(taken.insert(g).second);
      const auto &a = swept.windings[std::size_t(f)], &b = flooded.windings[std::size_t(g)];
      CHECK(std::equal(a.begin(), a.end(), b.begin(), b.end(),
                       [](const EdgeTag& s, const EdgeTag& t) { return s.tag == t.tag && s.winding == t.winding; }));
    }
  }
  CHECK(with_many_faces > 10);
}

TEST_CASE("the planes of the slice files are conforming", "[corpus]") {
  Seen seen;
  const auto files = small_corpus_files();
  for (const auto& path : files) {
    INFO(path.filename().string());
    const Chain chain = run_chain(read_cli(path.string()));
    for (std::size_t k = 0; k < chain.planes.size(); ++k) {
      INFO("plane " << k);
      check_mesh(chain.contours, chain.lifted[k], chain.planes[k], true, seen);
    }
  }
  if (!files.empty()) CHECK(seen.planes > 50);
}
