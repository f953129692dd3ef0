// SPDX-License-Identifier: MIT
#include "slice2mesh/quality/certificate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "plc/chain.hpp"
#include "slice2mesh/tet/slab_filler.hpp"
#include "test_support.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;

namespace {

std::string failed(const Certificate& certificate) {
  std::string text;
  for (const CertificateCheck& c : certificate.checks)
    if (!c.passed) text += c.name + " ";
  return text;
}

struct Sample {
  Plc plc;
  Mesh mesh;
};
/// Two regions, an overhang, a hole.
Sample sample() {
  Polyline line;
  line.direction = Direction::Open;
  line.points = {{4, 1.5}, {7, 1.5}};
  Sample s;
  s.plc = run_chain(stack_of({{rectangle(0, 0, 5, 3), rectangle(1, 1, 2, 2, Direction::Inner), line},
                              {rectangle(0, 0, 5, 3), rectangle(1, 1, 2, 2, Direction::Inner), line},
                              {rectangle(0, 0, 7, 3)}}))
              .plc();
  s.mesh = SlabFiller{}(s.plc);
  return s;
}

bool fails(const Mesh& mesh, const Plc& plc, const std::string& name) {
  const Certificate certificate = certify(mesh, plc);
  INFO("failed: " << failed(certificate));
  const CertificateCheck* check = certificate.find(name);
  return check != nullptr && !check->passed && !certificate.passed();
}

void erase_tet(Mesh& mesh, std::size_t t) {
  mesh.tets.erase(mesh.tets.begin() + std::ptrdiff_t(t));
  mesh.tet_slab.erase(mesh.tet_slab.begin() + std::ptrdiff_t(t));
  mesh.tet_region.erase(mesh.tet_region.begin() + std::ptrdiff_t(t));
}

}  // namespace

TEST_CASE("a certificate finds every tet that is flipped, missing, doubled or mislabeled, wherever it is") {
  const Sample good = sample();
  REQUIRE(failed(certify(good.mesh, good.plc)) == "");
  const std::uint32_t seed = 11;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  for (int i = 0; i < 25; ++i) {
    const std::size_t t = random() % good.mesh.tets.size();
    INFO("tet " << t);
    Mesh mesh = good.mesh;
    std::swap(mesh.tets[t][0], mesh.tets[t][1]);
    CHECK(fails(mesh, good.plc, "positive"));
    CHECK(fails(mesh, good.plc, "volume"));

    mesh = good.mesh;
    erase_tet(mesh, t);
    CHECK(fails(mesh, good.plc, "volume"));
    const Certificate holed = certify(mesh, good.plc);
    CHECK((!holed.find("faces")->passed || !holed.find("skin")->passed || !holed.find("interface_triangles")->passed));

    mesh = good.mesh;
    mesh.tets.push_back({mesh.tets[t][1], mesh.tets[t][2], mesh.tets[t][0], mesh.tets[t][3]});
    mesh.tet_slab.push_back(mesh.tet_slab[t]);
    mesh.tet_region.push_back(mesh.tet_region[t]);
    CHECK(fails(mesh, good.plc, "no_duplicates"));
    CHECK(fails(mesh, good.plc, "volume"));
    CHECK(fails(mesh, good.plc, "faces"));

    mesh = good.mesh;
    mesh.tet_slab[t] = (mesh.tet_slab[t] + 1) % 3;
    CHECK(fails(mesh, good.plc, "one_slab"));

    mesh = good.mesh;
    mesh.tet_region[t] = 1 - mesh.tet_region[t];
    CHECK(fails(mesh, good.plc, "volume"));
  }
}

TEST_CASE("a certificate finds vertices that were moved, by no more than a pitch") {
  const Sample good = sample();
  const double pitch = good.plc.grid.pitch;
  std::size_t tested = 0;
  for (std::size_t v = 0; v < good.mesh.vertices.size(); v += 19) {
    INFO("vertex " << v);
    Mesh mesh = good.mesh;
    mesh.vertices[v][0] += pitch;
    CHECK_FALSE(certify(mesh, good.plc).passed());
    mesh = good.mesh;
    mesh.vertices[v][1] = std::nextafter(mesh.vertices[v][1], 1e9);  // off the grid
    if (mesh.vertices[v] != good.mesh.vertices[v]) CHECK_FALSE(certify(mesh, good.plc).passed());
    mesh = good.mesh;
    mesh.vertices[v][2] = std::nextafter(mesh.vertices[v][2], 1e9);
    CHECK_FALSE(certify(mesh, good.plc).passed());
    ++tested;
  }
  CHECK(tested > 10);
}

TEST_CASE("a certificate does not depend on the numbers of vertices and the order of tets") {
  const Sample good = sample();
  Mesh mesh = good.mesh;
  const std::uint32_t seed = 5;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  std::vector<std::int32_t> order(mesh.vertices.size());
  for (std::size_t v = 0; v < order.size(); ++v) order[v] = std::int32_t(v);
  std::shuffle(order.begin(), order.end(), random);
  for (std::size_t v = 0; v < order.size(); ++v) mesh.vertices[std::size_t(order[v])] = good.mesh.vertices[v];
  for (auto& tet : mesh.tets)
    for (std::int32_t& v : tet) v = order[std::size_t(v)];
  for (Facet& facet : mesh.facets)
    for (std::int32_t& v : facet.vertices) v = order[std::size_t(v)];
  for (std::size_t t = mesh.tets.size(); t-- > 1;) {
    const std::size_t u = random() % (t + 1);
    std::swap(mesh.tets[t], mesh.tets[u]);
    std::swap(mesh.tet_slab[t], mesh.tet_slab[u]);
    std::swap(mesh.tet_region[t], mesh.tet_region[u]);
  }
  for (auto& tet : mesh.tets) tet = {tet[1], tet[2], tet[0], tet[3]};
  const Certificate certificate = certify(mesh, good.plc);
  CHECK(failed(certificate) == "");
  CHECK(certificate.volume == Approx(certify(good.mesh, good.plc).volume).epsilon(1e-14));
}

TEST_CASE("vertices between the planes are judged exactly too") {
  // A tet cut in four by a vertex in its middle.
  const Sample good = sample();
  Mesh mesh = good.mesh;
  std::array<double, 3> middle{};
  for (const std::int32_t v : mesh.tets[7])
    for (std::size_t k = 0; k < 3; ++k) middle[k] += mesh.vertices[std::size_t(v)][k] / 4;
  const auto m = std::int32_t(mesh.vertices.size());
  mesh.vertices.push_back(middle);
  const auto whole = mesh.tets[7];
  for (std::size_t k = 0; k < 4; ++k) {
    auto part = whole;
    part[k] = m;
    if (k == 0) {
      mesh.tets[7] = part;
      continue;
    }
    mesh.tets.push_back(part);
    mesh.tet_slab.push_back(mesh.tet_slab[7]);
    mesh.tet_region.push_back(mesh.tet_region[7]);
  }
  CHECK(failed(certify(mesh, good.plc)) == "");
  mesh.vertices.back()[2] += 100;
  CHECK(fails(mesh, good.plc, "one_slab"));
  CHECK(fails(mesh, good.plc, "positive"));
}

TEST_CASE("a certificate says what is wrong with arrays and indices, and never throws") {
  const Sample good = sample();
  Mesh mesh = good.mesh;
  mesh.tets[3][2] = std::int32_t(mesh.vertices.size());
  CHECK(fails(mesh, good.plc, "structure"));
  mesh = good.mesh;
  mesh.tets[3][2] = -1;
  CHECK(fails(mesh, good.plc, "structure"));
  mesh = good.mesh;
  mesh.tets[3][2] = mesh.tets[3][1];
  CHECK(fails(mesh, good.plc, "structure"));
  mesh = good.mesh;
  mesh.tet_slab.pop_back();
  CHECK(fails(mesh, good.plc, "structure"));
  mesh = good.mesh;
  mesh.tet_region[0] = 17;
  CHECK(fails(mesh, good.plc, "structure"));
  mesh = good.mesh;
  mesh.vertices[0][1] = std::numeric_limits<double>::quiet_NaN();
  CHECK(fails(mesh, good.plc, "structure"));
  mesh = good.mesh;
  mesh.slabs[1].z_high += 1;
  CHECK(fails(mesh, good.plc, "structure"));
  mesh = good.mesh;
  mesh.vertices.push_back({0, 0, 0});
  CHECK(fails(mesh, good.plc, "no_orphans"));
  CHECK(fails(Mesh{}, good.plc, "structure"));
  CHECK(fails(Mesh{}, Plc{}, "structure"));
  Plc plc = good.plc;
  plc.facets.pop_back();
  CHECK_FALSE(certify(good.mesh, plc).passed());
  plc = good.plc;
  plc.facets[0].vertices[0] = -3;
  CHECK(fails(good.mesh, plc, "complex"));
}

TEST_CASE("a triangle of a plane that is no face of the mesh is found, and the other way round") {
  const Sample good = sample();
  std::size_t tested = 0;
  for (std::size_t f = 0; f < good.plc.facets.size(); f += 23) {
    INFO("facet " << f << " " << to_string(good.plc.facets[f].label));
    Plc plc = good.plc;
    plc.facets.erase(plc.facets.begin() + std::ptrdiff_t(f));
    const Certificate certificate = certify(good.mesh, plc);
    CHECK_FALSE(certificate.passed());
    const bool wall = good.plc.facets[f].label == FacetLabel::Wall || good.plc.facets[f].label == FacetLabel::InnerWall;
    if (!wall) CHECK_FALSE(certificate.find("interface_triangles")->passed);
    ++tested;
  }
  CHECK(tested > 20);
}

TEST_CASE("the sign of a volume in doubles is exact") {
  const std::uint32_t seed = 3;
  INFO("seed " << seed);
  std::mt19937_64 random(seed);
  std::size_t flat = 0;
  for (int i = 0; i < 2000; ++i) {
    // Four points of a plane with whole coordinates; one of them moved by the last bit.
    const auto number = [&] { return double(std::int64_t(random() % 2000001) - 1000000); };
    const std::array<double, 3> u{number(), number(), number()}, w{number(), number(), number()},
        a{number(), number(), number()};
    const auto at = [&](double s, double t) {
      return std::array<double, 3>{a[0] + s * u[0] + t * w[0], a[1] + s * u[1] + t * w[1], a[2] + s * u[2] + t * w[2]};
    };
    const auto b = at(1, 0), c = at(0, 1);
    const auto t = double(random() % 100), s = double(random() % 100);
    auto d = at(s, t);
    CHECK(detail::exact_volume(a, b, c, d).sign == 0);
    ++flat;
    const double normal = u[0] * w[1] - u[1] * w[0];
    d[2] = std::nextafter(d[2], 1e30);
    CHECK(detail::exact_volume(a, b, c, d).sign == (normal > 0 ? 1 : (normal < 0 ? -1 : 0)));
  }
  CHECK(flat == 2000);
}

TEST_CASE("a certificate finds slabs that meet in different triangles, where each slab by itself is filled well") {
  const Sample good = sample();
  REQUIRE(failed(certify(good.mesh, good.plc)) == "");
  std::size_t interfaces = 0;
  for (std::size_t f = 0; f < good.plc.facets.size(); ++f) {
    const Facet& facet = good.plc.facets[f];
    if (facet.label != FacetLabel::Interface) continue;
    ++interfaces;
    // The same triangle twice, once for the slab below and once for the one above: nothing joins the two slabs there.
    Plc plc = good.plc;
    Facet below = facet, above = facet;
    below.label = FacetLabel::Up;
    below.front = {};
    above.label = FacetLabel::Down;
    above.back = facet.front;
    above.front = {};
    std::swap(above.vertices[1], above.vertices[2]);
    plc.facets[f] = below;
    plc.facets.push_back(above);
    const Certificate certificate = certify(good.mesh, plc);
    CHECK(failed(certificate) == "no_overlap ");
    CHECK_FALSE(certificate.passed());
    if (interfaces == 20) break;
  }
  CHECK(interfaces > 3);
}
