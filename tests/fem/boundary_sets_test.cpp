// SPDX-License-Identifier: MIT
#include "slice2mesh/fem/boundary_sets.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <vector>

#include "io/sample_mesh.hpp"
#include "test_support.hpp"

namespace {

using slice2mesh::BoundaryKind;
using slice2mesh::BoundarySets;
using slice2mesh::kNone;
using slice2mesh::Mesh;
using slice2mesh::TetFace;
using slice2mesh_test::BoxSolid;

std::array<double, 3> face_normal(const Mesh& mesh, const TetFace& f) {
  const std::array<std::int32_t, 3> v = slice2mesh::face_vertices(mesh, f);
  const auto at = [&](std::size_t i) { return mesh.vertices[static_cast<std::size_t>(v[i])]; };
  return slice2mesh::detail::cross(slice2mesh::detail::difference(at(1), at(0)),
                                   slice2mesh::detail::difference(at(2), at(0)));
}

/// The definition of the exposed area, evaluated on areas and perimeters of the squares.
double exposed_area(const BoxSolid& solid, std::size_t k) {
  double area = solid.area(0) + solid.area(k);
  for (std::size_t j = 0; j <= k; ++j) {
    area += solid.perimeter(j) * solid.thickness[j];
    if (j < k) area += solid.area_without(j, j + 1) + solid.area_without(j + 1, j);
  }
  return area;
}

double volume(const BoxSolid& solid, std::size_t k) {
  double sum = 0;
  for (std::size_t j = 0; j <= k; ++j) sum += solid.area(j) * solid.thickness[j];
  return sum;
}

/// A random solid of boxes: squares that are filled or not, so that parts of it hang in the air, touch along edges or
/// enclose voids.
BoxSolid random_solid(std::mt19937& generator) {
  BoxSolid solid;
  solid.nx = 5;
  solid.ny = 4;
  solid.dx = 0.7;
  solid.dy = 1.1;
  solid.thickness = {0.3, 0.2, 0.25, 0.3, 0.1};
  solid.region_count = 2;
  std::vector<std::int32_t> regions;
  std::discrete_distribution<std::int32_t> draw({3, 4, 2});
  for (std::size_t i = 0; i < solid.nx * solid.ny * solid.thickness.size(); ++i) regions.push_back(draw(generator) - 1);
  solid.region = [regions](std::size_t x, std::size_t y, std::size_t s) { return regions[(s * 4 + y) * 5 + x]; };
  return solid;
}

}  // namespace

TEST_CASE("exposed area and volume equal their definition after every layer of the stepped sample, bit for bit") {
  // All lengths are short binary fractions: nothing is rounded.
  const BoxSolid solid = slice2mesh_test::stepped_sample();
  const BoundarySets sets = slice2mesh::boundary_sets(slice2mesh_test::mesh_of(solid));
  REQUIRE(sets.exposed_area.size() == 4);
  for (std::size_t k = 0; k < 4; ++k) {
    CHECK(sets.exposed_area[k] == exposed_area(solid, k));
    CHECK(sets.volume[k] == Approx(volume(solid, k)).epsilon(1e-15));
  }
}

TEST_CASE("exposed area and volume equal their definition to 1e-12 on random solids") {
  const std::uint32_t seed = 42;
  INFO("seed " << seed);
  std::mt19937 generator(seed);
  for (int i = 0; i < 50; ++i) {
    const BoxSolid solid = random_solid(generator);
    const Mesh mesh = slice2mesh_test::mesh_of(solid);
    const BoundarySets sets = slice2mesh::boundary_sets(mesh);
    for (std::size_t k = 0; k < solid.thickness.size(); ++k) {
      REQUIRE(sets.exposed_area[k] == Approx(exposed_area(solid, k)).epsilon(1e-12));
      REQUIRE(sets.volume[k] == Approx(volume(solid, k)).epsilon(1e-12));
      const auto layer = static_cast<std::int32_t>(k);
      REQUIRE(slice2mesh::area_of(mesh, slice2mesh::exposed_faces(sets, layer)) ==
              Approx(sets.exposed_area[k]).epsilon(1e-12));
    }
  }
}

TEST_CASE("the faces exposed after layer k are the boundary of the mesh of layers 0 to k") {
  const std::uint32_t seed = 43;
  INFO("seed " << seed);
  std::mt19937 generator(seed);
  std::size_t seen = 0;
  for (int i = 0; i < 10; ++i) {
    const Mesh mesh = slice2mesh_test::mesh_of(random_solid(generator));
    const BoundarySets sets = slice2mesh::boundary_sets(mesh);
    for (std::int32_t k = 0; k < 5; ++k) {
      // Count the faces of the tets that exist; those with one tet are exposed.
      std::map<std::array<std::int32_t, 3>, std::vector<TetFace>> faces;
      for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
        if (mesh.tet_slab[t] > k) continue;
        for (std::int32_t f = 0; f < 4; ++f) {
          const TetFace face{static_cast<std::int32_t>(t), f};
          std::array<std::int32_t, 3> v = slice2mesh::face_vertices(mesh, face);
          std::sort(v.begin(), v.end());
          faces[v].push_back(face);
        }
      }
      std::set<TetFace> expected;
      for (const auto& entry : faces)
        if (entry.second.size() == 1) expected.insert(entry.second[0]);
      const std::vector<TetFace> exposed = slice2mesh::exposed_faces(sets, k);
      REQUIRE(std::set<TetFace>(exposed.begin(), exposed.end()) == expected);
      REQUIRE(exposed.size() == expected.size());
      seen += exposed.size();
    }
  }
  CHECK(seen > 10000);
}

TEST_CASE("exposed faces change from layer to layer by those born and those covered") {
  const BoundarySets sets = slice2mesh::boundary_sets(slice2mesh_test::mesh_of(slice2mesh_test::stepped_sample()));
  std::set<TetFace> exposed;
  std::size_t covered_in_all = 0;
  for (std::int32_t k = 0; k < 4; ++k) {
    for (const TetFace& f : slice2mesh::born_faces(sets, k)) CHECK(exposed.insert(f).second);
    for (const TetFace& f : slice2mesh::covered_faces(sets, k)) {
      CHECK(exposed.erase(f) == 1);
      ++covered_in_all;
    }
    const std::vector<TetFace> now = slice2mesh::exposed_faces(sets, k);
    CHECK(std::set<TetFace>(now.begin(), now.end()) == exposed);
  }
  CHECK(covered_in_all == sets.covered.size());
  CHECK(covered_in_all > 0);
  CHECK(slice2mesh::covered_faces(sets, 0).empty());
  CHECK_THROWS_AS(slice2mesh::exposed_faces(sets, 4), slice2mesh::Error);
  CHECK_THROWS_AS(slice2mesh::born_faces(sets, -1), slice2mesh::Error);
  CHECK_THROWS_AS(slice2mesh::covered_faces(sets, 4), slice2mesh::Error);
}

TEST_CASE("the areas of the boundary sets are those counted on squares") {
  const BoxSolid solid = slice2mesh_test::stepped_sample();
  const Mesh mesh = slice2mesh_test::mesh_of(solid);
  const BoundarySets sets = slice2mesh::boundary_sets(mesh);
  double wall = 0;
  double up = 0;
  double down = 0;
  for (std::size_t s = 0; s < 4; ++s) {
    wall += solid.perimeter(s) * solid.thickness[s];
    if (s > 0) down += solid.area_without(s, s - 1);
    if (s < 3) up += solid.area_without(s, s + 1);
  }
  REQUIRE(down > 0);
  REQUIRE(up > 0);
  const auto area = [&](BoundaryKind kind) { return slice2mesh::area_of(mesh, sets.of(kind)); };
  CHECK(area(BoundaryKind::Bottom) == Approx(solid.area(0)).epsilon(1e-14));
  CHECK(area(BoundaryKind::Top) == Approx(solid.area(3)).epsilon(1e-14));
  CHECK(area(BoundaryKind::Wall) == Approx(wall).epsilon(1e-14));
  CHECK(area(BoundaryKind::Upskin) == Approx(up).epsilon(1e-14));
  CHECK(area(BoundaryKind::Downskin) == Approx(down).epsilon(1e-14));
  // The supports are two squares: they touch the foot along two squares' sides (two slabs), the overhang from below.
  CHECK(area(BoundaryKind::SupportInterface) == Approx(2 * solid.dy * 0.5 + 2 * solid.dx * solid.dy).epsilon(1e-14));
}

TEST_CASE("what stands on a base plate meets it in the plate interface, seen from above") {
  const BoxSolid solid = slice2mesh_test::plated_sample();
  const BoxSolid part = slice2mesh_test::stepped_sample();
  const Mesh mesh = slice2mesh_test::mesh_of(solid);
  const BoundarySets sets = slice2mesh::boundary_sets(mesh);
  const auto area = [&](BoundaryKind kind) { return slice2mesh::area_of(mesh, sets.of(kind)); };
  CHECK(area(BoundaryKind::PlateInterface) == Approx(part.area(0)).epsilon(1e-14));
  CHECK(area(BoundaryKind::Bottom) == Approx(solid.area(0)).epsilon(1e-14));
  for (const TetFace& f : sets.of(BoundaryKind::PlateInterface)) {
    REQUIRE(mesh.tet_slab[static_cast<std::size_t>(f.tet)] == 2);
    REQUIRE(face_normal(mesh, f)[2] < 0);
  }
  for (std::size_t k = 0; k < solid.thickness.size(); ++k) {
    CHECK(sets.exposed_area[k] == Approx(exposed_area(solid, k)).epsilon(1e-14));
    CHECK(sets.volume[k] == Approx(volume(solid, k)).epsilon(1e-14));
  }
  // The supports touch the same faces of the part as without a plate.
  const Mesh alone = slice2mesh_test::mesh_of(part);
  CHECK(area(BoundaryKind::SupportInterface) ==
        Approx(slice2mesh::area_of(alone, slice2mesh::boundary_sets(alone).of(BoundaryKind::SupportInterface))));
}

TEST_CASE("normals of boundary faces point out of the material and fit the set; they sum to zero") {
  const Mesh mesh = slice2mesh_test::mesh_of(slice2mesh_test::stepped_sample());
  const BoundarySets sets = slice2mesh::boundary_sets(mesh);
  std::array<double, 3> sum{};
  for (std::size_t k = 0; k < slice2mesh::kBoundaryKinds; ++k) {
    const auto kind = static_cast<BoundaryKind>(k);
    REQUIRE(sets.of(kind).empty() == (kind == BoundaryKind::PlateInterface));
    CHECK(std::is_sorted(sets.of(kind).begin(), sets.of(kind).end()));
    for (const TetFace& f : sets.of(kind)) {
      const std::array<double, 3> n = face_normal(mesh, f);
      if (kind == BoundaryKind::Bottom || kind == BoundaryKind::Downskin) REQUIRE((n[2] < 0 && n[0] == 0 && n[1] == 0));
      if (kind == BoundaryKind::Top || kind == BoundaryKind::Upskin) REQUIRE((n[2] > 0 && n[0] == 0 && n[1] == 0));
      if (kind == BoundaryKind::Wall) REQUIRE(n[2] == 0);
      const auto tet = static_cast<std::size_t>(f.tet);
      const std::array<double, 3>& corner =
          mesh.vertices[static_cast<std::size_t>(mesh.tets[tet][static_cast<std::size_t>(f.face)])];
      const std::array<double, 3>& on_face =
          mesh.vertices[static_cast<std::size_t>(slice2mesh::face_vertices(mesh, f)[0])];
      REQUIRE(slice2mesh::detail::dot(n, slice2mesh::detail::difference(corner, on_face)) < 0);
      if (kind == BoundaryKind::SupportInterface) {
        REQUIRE(mesh.tet_region[tet] == 0);
        continue;
      }
      for (std::size_t i = 0; i < 3; ++i) sum[i] += n[i];
    }
  }
  for (const double x : sum) CHECK(std::fabs(x) < 1e-12);
}

TEST_CASE("neighbors are mutual and share a face") {
  const Mesh mesh = slice2mesh_test::mesh_of(slice2mesh_test::stepped_sample());
  const std::vector<std::array<std::int32_t, 4>> neighbors = slice2mesh::tet_neighbors(mesh);
  std::size_t inner = 0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    for (std::size_t f = 0; f < 4; ++f) {
      if (neighbors[t][f] == kNone) continue;
      ++inner;
      const auto other = static_cast<std::size_t>(neighbors[t][f]);
      REQUIRE(std::count(neighbors[other].begin(), neighbors[other].end(), static_cast<std::int32_t>(t)) == 1);
      std::size_t shared = 0;
      for (const std::int32_t v : mesh.tets[t])
        if (std::count(mesh.tets[other].begin(), mesh.tets[other].end(), v) > 0) ++shared;
      REQUIRE(shared == 3);
    }
  CHECK(inner > mesh.tets.size());
}

TEST_CASE("the sets do not depend on the order of the tets") {
  const std::uint32_t seed = 5;
  INFO("seed " << seed);
  const Mesh mesh = slice2mesh_test::mesh_of(slice2mesh_test::stepped_sample());
  std::vector<std::size_t> order(mesh.tets.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::shuffle(order.begin(), order.end(), std::mt19937(seed));
  Mesh shuffled = mesh;
  for (std::size_t i = 0; i < order.size(); ++i) {
    shuffled.tets[i] = mesh.tets[order[i]];
    shuffled.tet_slab[i] = mesh.tet_slab[order[i]];
    shuffled.tet_region[i] = mesh.tet_region[order[i]];
  }
  const BoundarySets a = slice2mesh::boundary_sets(mesh);
  const BoundarySets b = slice2mesh::boundary_sets(shuffled);
  CHECK(a.exposed_area == b.exposed_area);
  for (std::size_t k = 0; k < slice2mesh::kBoundaryKinds; ++k) {
    std::vector<TetFace> back;
    for (const TetFace& f : b.sets[k])
      back.push_back({static_cast<std::int32_t>(order[static_cast<std::size_t>(f.tet)]), f.face});
    std::sort(back.begin(), back.end());
    CHECK(back == a.sets[k]);
  }
}

TEST_CASE("a face with three tets and arrays that do not fit are errors") {
  Mesh mesh = slice2mesh_test::mesh_of(slice2mesh_test::single_box());
  mesh.tets.push_back(mesh.tets[0]);
  mesh.tets.push_back(mesh.tets[0]);
  mesh.tet_slab.resize(mesh.tets.size(), 0);
  mesh.tet_region.resize(mesh.tets.size(), 0);
  CHECK_THROWS_AS(slice2mesh::boundary_sets(mesh), slice2mesh::Error);
  mesh = slice2mesh_test::mesh_of(slice2mesh_test::single_box());
  mesh.tet_slab[0] = 1;
  CHECK_THROWS_AS(slice2mesh::boundary_sets(mesh), slice2mesh::Error);
  const BoundarySets empty = slice2mesh::boundary_sets(Mesh{});
  CHECK(empty.growth.empty());
  CHECK(empty.exposed_area.empty());
}
