// SPDX-License-Identifier: MIT
#include "slice2mesh/tet/slab_filler.hpp"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "plc/chain.hpp"
#include "slice2mesh/plc/verify_plc.hpp"
#include "slice2mesh/quality/certificate.hpp"
#include "test_support.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;

namespace {

std::string failures(const Certificate& certificate) {
  std::string text;
  for (const CertificateCheck& c : certificate.checks)
    if (!c.passed) text += c.name + " (" + c.detail + ") ";
  return text;
}

Mesh check_fill(const Plc& plc) {
  Mesh mesh = SlabFiller{}(plc);
  const Certificate certificate = certify(mesh, plc);
  CHECK(failures(certificate) == "");
  CHECK(certificate.passed());
  CHECK(certificate.volume == Approx(certificate.expected_volume).epsilon(1e-9));
  CHECK(mesh.vertices.size() == plc.vertices.size());  // no other vertices than the planes have
  return mesh;
}

/// One slab over a convex polygon, with other random points on its two planes.
struct RandomSlab {
  Chain chain;
  Plc plc;
};
RandomSlab random_slab(std::uint32_t seed, int interior = 40, bool hole = false) {
  std::mt19937 random(seed);
  RandomSlab result;
  Polyline polygon = star(0, 0, 4, 5 + int(random() % 6), 0, 0.1 * double(seed));
  SliceStack stack = stack_of({{polygon}});
  if (hole) {
    stack.layers[0].polylines.push_back(star(0, 0, 2.8, 4 + int(random() % 6), 0, double(seed)));
    std::reverse(stack.layers[0].polylines[1].points.begin(), stack.layers[0].polylines[1].points.end());
    stack.layers[0].polylines[1].direction = Direction::Inner;
  }
  SlabOptions slab_options;
  slab_options.thickness = 0.5;
  Chain& chain = result.chain;
  chain.regions = build_regions(stack, make_slabs(stack, slab_options, chain.diagnostics), {}, chain.diagnostics);
  chain.contours = harmonize(chain.regions, {}, chain.diagnostics);
  const auto number = [&] {
    return std::int64_t((double(random()) / 2147483648.0 - 1) * 4 / chain.contours.grid.pitch);
  };
  for (const auto& [below, above] : plane_slabs(chain.contours.slabs, chain.slab_planes)) {
    chain.lifted.push_back(lift(chain.contours, below, above));
    PlaneRefinement refinement;
    for (int i = 0; i < interior; ++i) refinement.interior.push_back({number(), number()});
    chain.planes.push_back(triangulate_plane(chain.lifted.back(), refinement));
  }
  result.plc = chain.plc();
  return result;
}

/// Is no vertex in the circle of a triangle or in the diametral disc of a contour edge? Each with each.
bool is_conforming(const PlaneMesh& mesh) {
  for (const auto& t : mesh.triangles)
    for (const GridPoint& p : mesh.vertices) {
      const GridPoint &a = mesh.vertices[std::size_t(t[0])], &b = mesh.vertices[std::size_t(t[1])],
                      &c = mesh.vertices[std::size_t(t[2])];
      if (slice2mesh::detail::nearer_to_circumcenter(a, b, c, a, p) > 0) return false;
    }
  for (const auto* all : {&mesh.below_chain, &mesh.above_chain})
    for (const auto& chain : *all)
      for (std::size_t i = 0; i + 1 < chain.size(); ++i)
        for (const GridPoint& p : mesh.vertices) {
          const GridPoint &a = mesh.vertices[std::size_t(chain[i])], &b = mesh.vertices[std::size_t(chain[i + 1])];
          if (p != a && p != b && slice2mesh::detail::in_diametral_disc(a, b, p)) return false;
        }
  return true;
}

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
/// Coordinates in pitches; heights in quarters of the pentagon's radius. Whole numbers below 2^53.
Kernel::Point_3 exact_point(const Plc& plc, std::size_t v, double height) {
  return {double(plc.vertices[v].x), double(plc.vertices[v].y), plc.vertex_plane[v] == 0 ? 0 : height};
}

}  // namespace

TEST_CASE("the filler's mesh passes every check on generated and random stacks") {
  std::size_t tets = 0, regions = 0;
  for (const NamedStack& named : generated_stacks()) {
    INFO(named.name);
    const Plc plc = run_chain(named.stack).plc();
    const Mesh mesh = check_fill(plc);
    tets += mesh.tets.size();
    regions = std::max(regions, std::set<std::int32_t>(mesh.tet_region.begin(), mesh.tet_region.end()).size());
    CHECK(std::set<std::int32_t>(mesh.tet_slab.begin(), mesh.tet_slab.end()).size() == plc.slabs.size());
  }
  CHECK(regions == 2);
  for (std::uint32_t seed = 1; seed <= 20; ++seed)
    for (const double eps : {0.1, 0.0}) {
      INFO("seed " << seed << " eps " << eps);
      ChainOptions options;
      options.eps = eps;
      const Plc plc = run_chain(random_stack(seed), options).plc();
      REQUIRE(verify_plc(plc).passed());
      tets += check_fill(plc).tets.size();
    }
  CHECK(tets > 10000);
}

TEST_CASE("plane triangulations without interior vertices, fine and coarse, are filled too") {
  for (std::uint32_t seed = 50; seed <= 56; ++seed)
    for (const double size : {0.5, 1.0, 4.0}) {
      INFO("seed " << seed << " size " << size);
      ChainOptions options;
      options.interior = size == 1.0;
      options.contour_size = size;
      options.radius_edge_ratio = size > 2 ? 0 : 1.3;
      check_fill(run_chain(random_stack(seed, 3), options).plc());
    }
}

TEST_CASE("where both planes have the same triangles, every prism is cut in three") {
  const Plc plc =
      run_chain(stack_of({{rectangle(0, 0, 4, 3)}, {rectangle(0, 0, 4, 3)}, {rectangle(0, 0, 4, 3)}})).plc();
  const Mesh mesh = check_fill(plc);
  std::size_t bottom = 0;
  for (const Facet& facet : plc.facets) bottom += facet.label == FacetLabel::Down ? 1U : 0U;
  REQUIRE(bottom > 10);
  CHECK(mesh.tets.size() == 9 * bottom);
  // Each tet has a vertical edge.
  for (const auto& tet : mesh.tets) {
    bool vertical = false;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < i; ++j)
        vertical = vertical || plc.vertices[std::size_t(tet[i])] == plc.vertices[std::size_t(tet[j])];
    CHECK(vertical);
  }
}

TEST_CASE("over a convex contour the fill is Delaunay: no vertex in any circumsphere, as many tets as in CGAL's") {
  std::size_t compared = 0, same = 0;
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    INFO("seed " << seed);
    const RandomSlab slab = random_slab(seed);
    const Mesh mesh = check_fill(slab.plc);
    const double height = std::round(1.0 / slab.plc.grid.pitch);
    std::vector<Kernel::Point_3> points;
    for (std::size_t v = 0; v < slab.plc.vertices.size(); ++v) points.push_back(exact_point(slab.plc, v, height));
    std::set<std::array<std::int32_t, 4>> own;
    for (const auto& tet : mesh.tets) {
      const Kernel::Tetrahedron_3 t(points[std::size_t(tet[0])], points[std::size_t(tet[1])],
                                    points[std::size_t(tet[2])], points[std::size_t(tet[3])]);
      REQUIRE(CGAL::orientation(t[0], t[1], t[2], t[3]) == CGAL::POSITIVE);
      std::size_t inside = 0;
      for (std::size_t v = 0; v < points.size(); ++v)
        inside += CGAL::side_of_oriented_sphere(t[0], t[1], t[2], t[3], points[v]) == CGAL::ON_POSITIVE_SIDE ? 1U : 0U;
      REQUIRE(inside == 0);
      auto key = tet;
      std::sort(key.begin(), key.end());
      own.insert(key);
    }
    // Another Delaunay mesh of the same points; it may differ where points are co-spherical (columns at the walls).
    CGAL::Delaunay_triangulation_3<Kernel> delaunay;
    std::map<Kernel::Point_3, std::int32_t> index;
    for (std::size_t v = 0; v < points.size(); ++v) {
      delaunay.insert(points[v]);
      index[points[v]] = std::int32_t(v);
    }
    for (auto cell = delaunay.finite_cells_begin(); cell != delaunay.finite_cells_end(); ++cell) {
      std::array<std::int32_t, 4> key{};
      for (int i = 0; i < 4; ++i) key[std::size_t(i)] = index[cell->vertex(i)->point()];
      std::sort(key.begin(), key.end());
      ++compared;
      same += own.count(key);
    }
  }
  CHECK(compared > 1000);
  CHECK(double(same) > 0.8 * double(compared));
}

TEST_CASE("regions that share walls agree on the diagonals of these walls") {
  // Split points of walls are rounded: bisectors of wall edges may cross far inside of one of the two regions.
  int shared = 0;
  std::vector<std::uint32_t> seeds(80);
  std::iota(seeds.begin(), seeds.end(), 0U);
  seeds.push_back(2480);  // merging left a contour vertex just beside an edge: two walls stood in one place
  for (const std::uint32_t seed : seeds) {
    INFO("seed " << seed);
    std::mt19937 random(seed);
    const auto number = [&] { return double(random()) / 4294967296.0; };
    const auto ring = [&](std::int32_t part, double x, double y, double radius, int count) {
      Polyline polygon;
      polygon.part = part;
      for (int i = 0; i < count; ++i) {
        const double angle = 2 * 3.14159265358979 * i / count + 0.1, rx = radius * (0.8 + 0.4 * number()),
                     ry = radius * (0.8 + 0.4 * number());
        polygon.points.push_back({x + rx * std::cos(angle), y + ry * std::sin(angle)});
      }
      return polygon;
    };
    std::vector<std::vector<Polyline>> layers;
    for (int i = 0; i < 3; ++i) layers.push_back({ring(0, 3, 4, 3, 12), ring(1, 1, 5, 1.7, 12), ring(1, 5, 3, 1.5, 9)});
    const Plc plc = run_chain(stack_of(layers)).plc();
    for (const Facet& f : plc.facets) shared += f.label == FacetLabel::InnerWall;
    check_fill(plc);
  }
  CHECK(shared > 1000);
}

TEST_CASE("a needle 10 mm long and 0.0001 mm wide is meshed, with another one above it turned") {
  std::vector<std::vector<Polyline>> layers;
  for (int i = 0; i < 3; ++i) {
    const double c = std::cos(i == 1 ? 0.1 : 0.0), s = std::sin(i == 1 ? 0.1 : 0.0);
    const auto turned = [&](std::vector<std::array<double, 2>> points) {
      Polyline polygon;
      for (const auto& [x, y] : points) polygon.points.push_back({c * x - s * y, s * x + c * y});
      return polygon;
    };
    layers.push_back({turned({{0, 0}, {10, 0}, {0, 0.0001}}), turned({{-2, -1}, {0, -1}, {0, 1}, {-2, 1}})});
  }
  check_fill(run_chain(stack_of(layers)).plc());
}

TEST_CASE("fans of triangles around a point are filled, whatever way each layer is turned", "[slow]") {
  using detail::kPi;
  constexpr std::uint32_t kSeed = 7;
  INFO("seed " << kSeed);
  std::mt19937 random(kSeed);
  const auto uniform = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; };
  for (int k = 0; k < 40; ++k) {
    const int n = 2 + int(random() % 7);
    const double filled = uniform(0.2, 0.95), turn = uniform(0, 2 * kPi / n), radius = uniform(1.5, 3);
    INFO("fan " << k << " of " << n << " triangles, " << filled << " of the circle, turned by " << turn);
    const auto fan = [&](double from) {
      std::vector<Polyline> slice;
      for (int i = 0; i < n; ++i) {
        const double a = from + 2 * kPi * i / n, b = a + filled * 2 * kPi / n;
        slice.push_back(
            loop({{0, 0}, {radius * std::cos(a), radius * std::sin(a)}, {radius * std::cos(b), radius * std::sin(b)}}));
      }
      return slice;
    };
    check_fill(run_chain(stack_of({fan(0), fan(turn), fan(turn / 3)})).plc());
  }
}

TEST_CASE("a wall may be bent apart exactly across, next to where it meets another one") {
  // The way to the middle of the triangle at the tip passes exactly the end of a border on one wall, and the symbolic
  // rule for ties puts it outside; beside the tip is the other wall, with an end that the way does not pass.
  using detail::kPi;
  std::size_t bent = 0;
  for (int degrees = 12; degrees < 60; degrees += 3)
    for (const int across : {1, 5, 12}) {
      INFO(degrees << " degrees, bent by " << across << " pitches");
      const double a = degrees * kPi / 180;
      for (const double tip : {0.0, a}) {  // the bent wall is the upper one, or the lower one
        const std::vector<Polyline> slice{
            loop({{0, 0}, {16 * std::cos(tip - a), 16 * std::sin(tip - a)}, {16 * std::cos(tip), 16 * std::sin(tip)}})};
        ChainOptions options;
        options.contour_size = 9;
        options.interior = false;
        Chain chain = run_chain(stack_of({slice, slice}), options);
        PlaneMesh& top = chain.planes[1];
        const GridPoint corner = *std::min_element(top.vertices.begin(), top.vertices.end());
        for (std::size_t v = chain.lifted[1].overlay.vertices.size(); v < top.vertices.size(); ++v) {
          GridPoint& p = top.vertices[v];
          if (!top.fixed[v] || p.y != corner.y) continue;
          p.y += tip == 0 ? -across : across;
          ++bent;
        }
        check_fill(chain.plc());
      }
    }
  CHECK(bent > 50);
}

TEST_CASE("the two chains of a wall may be bent apart by a few pitches") {
  // Split points of both planes nearly coincide: so do the borders of the cells that begin there.
  std::size_t tets = 0, bent = 0, tried = 0;
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    INFO("seed " << seed);
    RandomSlab slab = random_slab(seed, 40, true);
    std::mt19937 random(seed);
    PlaneMesh& top = slab.chain.planes[1];
    for (std::size_t v = slab.chain.lifted[1].overlay.vertices.size(); v < top.vertices.size(); ++v) {
      if (!top.fixed[v]) continue;
      GridPoint& p = top.vertices[v];
      p = {p.x + std::int64_t(random() % 7) - 3, p.y + std::int64_t(random() % 7) - 3};
      ++bent;
    }
    // What was out of a circle or a disc by a few pitches may not be so any more.
    if (!is_conforming(top)) continue;
    ++tried;
    tets += check_fill(slab.chain.plc()).tets.size();
  }
  CHECK(tets > 5000);
  CHECK(bent > 300);
  CHECK(tried > 150);
}

TEST_CASE("a wall may be split into any number of pieces at its bottom and at its top") {
  // One long edge, and a saw along it in the slices below and above, with other teeth.
  const auto saw = [](double tooth) {
    std::vector<Point2> points{{0, 0}, {20, 0}};
    for (double x = 20; x >= 0; x -= tooth) {
      points.push_back({x, 2.9});
      points.push_back({x - tooth / 2, 2.8});
    }
    return loop(points);
  };
  ChainOptions options;
  options.contour_size = 1000;
  options.interior = false;
  const Chain chain = run_chain(stack_of({{saw(0.2)}, {rectangle(0, 0, 20, 3)}, {saw(0.13)}}), options);
  std::size_t most = 0;
  for (std::size_t e = 0; e < chain.contours.outlines[1].edges.size(); ++e)
    most = std::max(most, std::min(chain.planes[1].above_chain[e].size(), chain.planes[2].below_chain[e].size()));
  CHECK(most > 80);
  check_fill(chain.plc());
}

TEST_CASE("the filler needs inner faces and keeps to its budget") {
  const Chain chain = run_chain(stack_of({{rectangle(0, 0, 4, 3)}, {rectangle(0, 0, 4, 3)}}));
  CHECK_THROWS_AS(SlabFiller{}(chain.plc(false)), TetrahedralizationError);
  SlabFiller filler;
  filler.max_tets = 10;
  CHECK_THROWS_AS(filler(chain.plc()), BudgetError);
}

TEST_CASE("the same complex gives the same mesh") {
  const Plc plc = run_chain(random_stack(3)).plc();
  const Mesh a = SlabFiller{}(plc), b = SlabFiller{}(plc);
  CHECK(a.tets == b.tets);
  CHECK(a.vertices == b.vertices);
}

TEST_CASE("the meshes of the slice files pass every check", "[corpus]") {
  std::size_t tets = 0;
  const auto files = small_corpus_files();
  for (const auto& path : files) {
    INFO(path.filename().string());
    tets += check_fill(run_chain(read_cli(path.string())).plc()).tets.size();
  }
  if (!files.empty()) CHECK(tets > 100000);
}
