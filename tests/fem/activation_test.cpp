// SPDX-License-Identifier: MIT
#include "slice2mesh/fem/activation.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
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
  REQUIRE(domains.begin.size() == mesh.slabs.size() + 1);
  CHECK(domains.begin.back() == mesh.tets.size());
  std::vector<int> seen(mesh.tets.size(), 0);
  for (std::size_t s = 0; s < mesh.slabs.size(); ++s) {
    CHECK(domains.begin[s] < domains.begin[s + 1]);
    for (std::size_t i = domains.begin[s]; i < domains.begin[s + 1]; ++i) {
      const auto t = static_cast<std::size_t>(domains.order[i]);
      ++seen[t];
      REQUIRE(mesh.tet_slab[t] == static_cast<std::int32_t>(s));
    }
  }
  CHECK(seen == std::vector<int>(mesh.tets.size(), 1));
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
