// SPDX-License-Identifier: MIT
#include "slice2mesh/plc/verify_plc.hpp"

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "plc/chain.hpp"
#include "test_support.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;

namespace {

/// The names of the checks that failed, and what they say.
std::string failures(const PlcReport& report) {
  std::string text;
  for (const CertificateCheck& c : report.checks)
    if (!c.passed) text += c.name + " (" + c.detail + ") ";
  return text;
}
bool fails(const Plc& plc, const std::string& name) {
  const PlcReport report = verify_plc(plc);
  const CertificateCheck* check = report.find(name);
  return check != nullptr && !check->passed && !report.passed();
}

std::size_t first_facet(const Plc& plc, FacetLabel label) {
  for (std::size_t f = 0; f < plc.facets.size(); ++f)
    if (plc.facets[f].label == label) return f;
  FAIL("no facet with label " << to_string(label));
  return 0;
}

Plc sample() {
  return run_chain(stack_of({{rectangle(0, 0, 4, 3)}, {rectangle(0, 0, 6, 3)}, {rectangle(1, 1, 3, 2)}})).plc();
}

}  // namespace

TEST_CASE("complexes of stacks are closed, do not cross and have the volume of area x height") {
  std::size_t bent = 0;
  for (const NamedStack& named : generated_stacks()) {
    INFO(named.name);
    const Chain chain = run_chain(named.stack);
    const PlcReport report = verify_plc(chain.plc());
    CHECK(failures(report) == "");
    CHECK(report.passed());
    CHECK(report.volume == Approx(report.expected_volume).epsilon(1e-9));
    CHECK(report.volume > 0);
    bent += report.largest_bend > 0 ? 1U : 0U;
  }
  for (std::uint32_t seed = 1; seed <= 12; ++seed)
    for (const double eps : {0.0, 0.1}) {
      INFO("seed " << seed << " eps " << eps);
      ChainOptions options;
      options.eps = eps;
      const Chain chain = run_chain(random_stack(seed), options);
      const PlcReport report = verify_plc(chain.plc());
      CHECK(failures(report) == "");
      // Nothing bends by more than a few steps of the contour grid.
      CHECK(report.largest_bend <= 8 * double(kContourStep) * chain.contours.grid.pitch);
      bent += report.largest_bend > 0 ? 1U : 0U;
      double area_height = 0;
      for (std::size_t s = 0; s < chain.contours.slabs.size(); ++s)
        area_height += double(detail::doubled_area(chain.contours.outlines[s], kNone)) / 2 * chain.contours.grid.pitch *
                       chain.contours.grid.pitch * (chain.contours.slabs[s].z_high - chain.contours.slabs[s].z_low);
      CHECK(report.volume == Approx(area_height).epsilon(1e-8));
    }
  CHECK(bent > 0);
}

TEST_CASE("the outer skin alone is closed and holds the same volume") {
  std::size_t fewer = 0;
  for (const NamedStack& named : generated_stacks()) {
    INFO(named.name);
    const Chain chain = run_chain(named.stack);
    const Plc whole = chain.plc(), skin = chain.plc(false);
    const PlcReport report = verify_plc(skin);
    CHECK(failures(report) == "");
    CHECK(report.volume == Approx(verify_plc(whole).volume).epsilon(1e-10));
    CHECK(report.expected_volume == Approx(report.volume).epsilon(1e-9));
    for (const Facet& facet : skin.facets) CHECK((facet.front.empty() && !facet.back.empty()));
    fewer += skin.facets.size() < whole.facets.size() ? 1U : 0U;
  }
  CHECK(fewer > 5);
  Plc open = sample();
  open = run_chain(stack_of({{rectangle(0, 0, 4, 3)}, {rectangle(0, 0, 6, 3)}})).plc(false);
  open.facets.erase(open.facets.begin() + 3);
  CHECK(fails(open, "closed"));
}

TEST_CASE("the verifier finds what was changed in a complex") {
  const Plc good = sample();
  REQUIRE(failures(verify_plc(good)) == "");
  SECTION("a facet is missing") {
    for (const FacetLabel label : {FacetLabel::Down, FacetLabel::Up, FacetLabel::Interface, FacetLabel::Wall}) {
      Plc plc = good;
      plc.facets.erase(plc.facets.begin() + std::ptrdiff_t(first_facet(plc, label)));
      CHECK(fails(plc, "closed"));
    }
    Plc plc = good;
    plc.facets.erase(plc.facets.begin() + std::ptrdiff_t(first_facet(plc, FacetLabel::Wall)));
    CHECK(fails(plc, "walls"));
  }
  SECTION("a facet is turned over") {
    for (const FacetLabel label : {FacetLabel::Down, FacetLabel::Up, FacetLabel::Interface, FacetLabel::Wall}) {
      Plc plc = good;
      std::swap(plc.facets[first_facet(plc, label)].vertices[0], plc.facets[first_facet(plc, label)].vertices[1]);
      CHECK(fails(plc, "closed"));
      CHECK(fails(plc, label == FacetLabel::Wall ? "walls" : "horizontal_facets"));
    }
  }
  SECTION("a facet stands twice") {
    Plc plc = good;
    plc.facets.push_back(plc.facets[first_facet(plc, FacetLabel::Up)]);
    CHECK(fails(plc, "no_overlap"));
    CHECK(fails(plc, "closed"));
  }
  SECTION("a loose triangle covers a plane once more") {
    Plc plc = good;
    const Facet sample_facet = plc.facets[first_facet(plc, FacetLabel::Interface)];
    Facet loose = sample_facet;
    for (std::size_t k = 0; k < 3; ++k) {
      GridPoint p = plc.vertices[std::size_t(sample_facet.vertices[k])];
      GridPoint center{};
      for (const std::int32_t v : sample_facet.vertices) {
        center.x += plc.vertices[std::size_t(v)].x / 3;
        center.y += plc.vertices[std::size_t(v)].y / 3;
      }
      plc.vertices.push_back({(p.x + center.x) / 2, (p.y + center.y) / 2});
      plc.vertex_plane.push_back(plc.vertex_plane[std::size_t(sample_facet.vertices[k])]);
      loose.vertices[k] = std::int32_t(plc.vertices.size()) - 1;
    }
    plc.facets.push_back(loose);
    CHECK(fails(plc, "no_overlap"));
  }
  SECTION("a vertex is moved in its plane") {
    Plc plc = good;
    const std::int32_t corner = plc.facets[first_facet(plc, FacetLabel::Wall)].vertices[0];
    plc.vertices[std::size_t(corner)].x += std::int64_t(1) << 30;
    CHECK_FALSE(verify_plc(plc).passed());
  }
  SECTION("a vertex is on another plane") {
    Plc plc = good;
    const std::int32_t v = plc.facets[first_facet(plc, FacetLabel::Down)].vertices[0];
    plc.vertex_plane[std::size_t(v)] += 1;
    CHECK(fails(plc, "horizontal_facets"));
  }
  SECTION("a side is wrong") {
    Plc plc = good;
    plc.facets[first_facet(plc, FacetLabel::Interface)].front.slab = 2;
    CHECK_FALSE(verify_plc(plc).passed());
    plc = good;
    plc.facets[first_facet(plc, FacetLabel::Up)].label = FacetLabel::Interface;
    CHECK(fails(plc, "complex"));
  }
  SECTION("a vertex is on no facet") {
    Plc plc = good;
    plc.vertices.push_back({0, 0});
    plc.vertex_plane.push_back(0);
    CHECK(fails(plc, "no_orphans"));
  }
  SECTION("indices, planes and the grid are out of range") {
    Plc plc = good;
    plc.facets[0].vertices[1] = std::int32_t(plc.vertices.size());
    CHECK(fails(plc, "complex"));
    plc = good;
    plc.facets[0].back.slab = -5;
    CHECK(fails(plc, "complex"));
    plc = good;
    std::swap(plc.planes[0], plc.planes[1]);
    CHECK(fails(plc, "complex"));
    plc = good;
    plc.planes[1] = std::numeric_limits<double>::quiet_NaN();
    CHECK(fails(plc, "complex"));
    plc = good;
    plc.grid.pitch = 0;
    CHECK(fails(plc, "complex"));
    plc = good;
    plc.slab_planes.pop_back();
    CHECK(fails(plc, "complex"));
    plc = good;
    plc.vertices[0].x = kGridLimit + 1;
    CHECK(fails(plc, "complex"));
  }
}

TEST_CASE("cover by a sweep: once, twice, crossing") {
  using detail::CoverSweep;
  const auto run = [](std::vector<std::vector<GridPoint>> loops) {
    std::vector<CoverSweep::Edge> edges;
    for (const auto& l : loops)
      for (std::size_t i = 0; i < l.size(); ++i) {
        const GridPoint a = l[i], b = l[(i + 1) % l.size()];
        edges.push_back(a < b ? CoverSweep::Edge{a, b, true} : CoverSweep::Edge{b, a, false});
      }
    GridPoint at;
    const std::function<void()> nobody;
    detail::Poll listen(nobody, 1);
    return CoverSweep::run(edges, at, listen);
  };
  const auto square = [](std::int64_t x, std::int64_t y, std::int64_t size) {
    return std::vector<GridPoint>{{x, y}, {x + size, y}, {x + size, y + size}, {x, y + size}};
  };
  auto hole = square(2, 2, 3);
  std::reverse(hole.begin(), hole.end());
  CHECK(run({square(0, 0, 10)}) == CoverSweep::Finding::Once);
  CHECK(run({square(0, 0, 10), hole}) == CoverSweep::Finding::Once);
  CHECK(run({square(0, 0, 10), hole, square(3, 3, 1)}) == CoverSweep::Finding::Once);
  CHECK(run({square(0, 0, 10), square(10, 10, 5)}) == CoverSweep::Finding::Once);  // meet in a corner
  CHECK(run({square(0, 0, 10), square(2, 2, 3)}) == CoverSweep::Finding::Overlap);
  CHECK(run({square(0, 0, 10), square(5, 5, 10)}) == CoverSweep::Finding::Crossing);
  CHECK(run({square(0, 0, 10), square(10, 2, 3)}) == CoverSweep::Finding::Crossing);  // touches along an edge
  CHECK(run({square(0, 0, 10), square(0, 0, 10)}) == CoverSweep::Finding::Crossing);
  CHECK(run({hole}) == CoverSweep::Finding::Overlap);
  CHECK(run({}) == CoverSweep::Finding::Once);
}

TEST_CASE("the complexes of the slice files pass, whole and as a skin", "[corpus]") {
  std::size_t seen = 0;
  const auto files = small_corpus_files();
  for (const auto& path : files) {
    INFO(path.filename().string());
    const Chain chain = run_chain(read_cli(path.string()));
    CHECK(failures(verify_plc(chain.plc())) == "");
    CHECK(failures(verify_plc(chain.plc(false))) == "");
    ++seen;
  }
  if (!files.empty()) CHECK(seen >= 4);
}
