// SPDX-License-Identifier: MIT
#include "slice2mesh/fem/activation.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <set>
#include <vector>

#include "io/sample_mesh.hpp"
#include "slice2mesh/fem/boundary_sets.hpp"
#include "test_support.hpp"

namespace {

using slice2mesh::kNone;
using slice2mesh::Mesh;
using slice2mesh::SubMesh;

Mesh sample() {
  return slice2mesh_test::mesh_of(slice2mesh_test::stepped_sample());
}

}  // namespace

TEST_CASE("activation times are layer times time per layer, or those of the user's function") {
  const Mesh mesh = sample();
  const std::vector<double> times = slice2mesh::activation_time(mesh, 2.5);
  REQUIRE(times.size() == mesh.tets.size());
  for (std::size_t t = 0; t < times.size(); ++t) CHECK(times[t] == 2.5 * mesh.tet_slab[t]);
  const std::vector<double> own = slice2mesh::activation_times(
      mesh, [](std::int32_t slab, std::size_t tet) { return 1000 * slab + static_cast<double>(tet); });
  for (std::size_t t = 0; t < own.size(); ++t) CHECK(own[t] == 1000 * mesh.tet_slab[t] + static_cast<double>(t));
  CHECK_THROWS_AS(slice2mesh::activation_time(mesh, -1), slice2mesh::OptionError);
  CHECK_THROWS_AS(slice2mesh::activation_time(mesh, std::numeric_limits<double>::quiet_NaN()), slice2mesh::OptionError);
}

TEST_CASE("growing domains hold every tet once, slab after slab") {
  Mesh mesh = sample();
  std::swap(mesh.tets.front(), mesh.tets.back());
  std::swap(mesh.tet_slab.front(), mesh.tet_slab.back());
  std::swap(mesh.tet_region.front(), mesh.tet_region.back());
  const slice2mesh::GrowingDomains domains = slice2mesh::growing_domains(mesh);
  REQUIRE(domains.size() == mesh.slabs.size());
  std::vector<int> seen(mesh.tets.size(), 0);
  std::int32_t slab = 0;
  std::size_t so_far = 0;
  for (const slice2mesh::GrowingDomain& domain : domains) {
    REQUIRE(domain.slab == slab++);
    CHECK_FALSE(domain.born.empty());
    CHECK(std::is_sorted(domain.born.begin(), domain.born.end()));
    for (const std::int32_t t : domain.born) {
      ++seen[static_cast<std::size_t>(t)];
      REQUIRE(mesh.tet_slab[static_cast<std::size_t>(t)] == domain.slab);
    }
    so_far += domain.born.size();
    CHECK(domain.all.size() == so_far);
    CHECK(domain.all.end() == domain.born.end());
    for (const std::int32_t t : domain.all) REQUIRE(mesh.tet_slab[static_cast<std::size_t>(t)] <= domain.slab);
  }
  CHECK(slab == 4);
  CHECK(seen == std::vector<int>(mesh.tets.size(), 1));
}

TEST_CASE("the labels of an element are those of its slab and its region") {
  const Mesh mesh = sample();
  std::set<std::int32_t> parts;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const slice2mesh::ElementLabels labels = slice2mesh::element_labels(mesh, t);
    REQUIRE(labels.layer == mesh.tet_slab[t]);
    REQUIRE(labels.bundle_first == 3 * labels.layer);
    REQUIRE(labels.bundle_last == 3 * labels.layer + 2);
    REQUIRE(labels.region == mesh.tet_region[t]);
    REQUIRE((labels.kind == slice2mesh::RegionKind::Support) == (labels.region == 1));
    parts.insert(labels.part);
  }
  CHECK(parts == std::set<std::int32_t>{7, 9});
}

TEST_CASE("a base plate is there from the beginning, and the print starts on it") {
  Mesh mesh = sample();
  CHECK(slice2mesh::plate_slabs(mesh) == 0);
  for (slice2mesh::Slab* slab : {&mesh.slabs[0], &mesh.slabs[1]})
    slab->first_layer = slab->last_layer = slab->slice = kNone;
  CHECK(slice2mesh::plate_slabs(mesh) == 2);
  const std::vector<double> times = slice2mesh::activation_time(mesh, 2.5);
  for (std::size_t t = 0; t < times.size(); ++t) REQUIRE(times[t] == (mesh.tet_slab[t] == 3 ? 2.5 : 0));
}

TEST_CASE("the sub-mesh of a range of layers is that range, in its own numbering, with maps both ways") {
  const Mesh mesh = sample();
  std::size_t ranges = 0;
  for (std::int32_t first = 0; first < 4; ++first)
    for (std::int32_t last = first; last < 4; ++last) {
      ++ranges;
      const SubMesh sub = slice2mesh::layers_of(mesh, first, last);
      REQUIRE(sub.mesh.slabs.size() == static_cast<std::size_t>(last - first + 1));
      CHECK(sub.first_slab == first);
      CHECK(sub.mesh.slabs.front().z_low == mesh.slabs[static_cast<std::size_t>(first)].z_low);
      std::size_t expected = 0;
      for (const std::int32_t s : mesh.tet_slab)
        if (first <= s && s <= last) ++expected;
      REQUIRE(sub.mesh.tets.size() == expected);
      REQUIRE(sub.tet_in_whole.size() == expected);
      std::vector<int> used(sub.mesh.vertices.size(), 0);
      for (std::size_t t = 0; t < sub.mesh.tets.size(); ++t) {
        const auto whole = static_cast<std::size_t>(sub.tet_in_whole[t]);
        REQUIRE(sub.mesh.tet_slab[t] + first == mesh.tet_slab[whole]);
        REQUIRE(sub.mesh.tet_region[t] == mesh.tet_region[whole]);
        for (std::size_t i = 0; i < 4; ++i) {
          const auto v = static_cast<std::size_t>(sub.mesh.tets[t][i]);
          used[v] = 1;
          REQUIRE(sub.vertex_in_whole[v] == mesh.tets[whole][i]);
          REQUIRE(sub.vertex_in_sub[static_cast<std::size_t>(mesh.tets[whole][i])] == static_cast<std::int32_t>(v));
          REQUIRE(sub.mesh.vertices[v] == mesh.vertices[static_cast<std::size_t>(mesh.tets[whole][i])]);
        }
      }
      CHECK(used == std::vector<int>(sub.mesh.vertices.size(), 1));
    }
  CHECK(ranges == 10);
}

TEST_CASE("layers 0 to k alone have the exposed area and volume that the whole mesh has after layer k") {
  const Mesh mesh = sample();
  const slice2mesh::BoundarySets whole = slice2mesh::boundary_sets(mesh);
  for (std::int32_t k = 0; k < 4; ++k) {
    const slice2mesh::BoundarySets sub = slice2mesh::boundary_sets(slice2mesh::layers_of(mesh, 0, k).mesh);
    CHECK(sub.exposed_area.back() == Approx(whole.exposed_area[static_cast<std::size_t>(k)]).epsilon(1e-14));
    CHECK(sub.volume.back() == Approx(whole.volume[static_cast<std::size_t>(k)]).epsilon(1e-14));
  }
}

TEST_CASE("facets of a sub-mesh keep their sides within the range") {
  Mesh mesh = sample();
  // Every face between two slabs as an interface facet, seen from below.
  const slice2mesh::BoundarySets sets = slice2mesh::boundary_sets(mesh);
  for (const slice2mesh::GrowthFace& f : sets.growth) {
    if (f.covered == kNone) continue;
    slice2mesh::Facet facet;
    facet.vertices = slice2mesh::face_vertices(mesh, f.face);
    facet.label = slice2mesh::FacetLabel::Interface;
    facet.back = {f.born, 0};
    facet.front = {f.covered, 0};
    mesh.facets.push_back(facet);
  }
  REQUIRE_FALSE(mesh.facets.empty());
  const SubMesh sub = slice2mesh::layers_of(mesh, 1, 2);
  REQUIRE_FALSE(sub.mesh.facets.empty());
  std::size_t inner = 0;
  for (const slice2mesh::Facet& f : sub.mesh.facets) {
    CHECK_FALSE((f.front.empty() && f.back.empty()));
    if (!f.front.empty() && !f.back.empty()) ++inner;
    for (const std::int32_t v : f.vertices)
      REQUIRE((v >= 0 && v < static_cast<std::int32_t>(sub.mesh.vertices.size())));
  }
  CHECK(inner == slice2mesh::covered_faces(sets, 2).size());
  CHECK(sub.mesh.facets.size() ==
        slice2mesh::covered_faces(sets, 1).size() + inner + slice2mesh::covered_faces(sets, 3).size());
}

TEST_CASE("a range that is not within the slabs is an error") {
  const Mesh mesh = sample();
  CHECK_THROWS_AS(slice2mesh::layers_of(mesh, -1, 0), slice2mesh::Error);
  CHECK_THROWS_AS(slice2mesh::layers_of(mesh, 2, 1), slice2mesh::Error);
  CHECK_THROWS_AS(slice2mesh::layers_of(mesh, 0, 4), slice2mesh::Error);
}
