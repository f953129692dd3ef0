// SPDX-License-Identifier: MIT
#include "slice2mesh/fem/quadratic.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numeric>
#include <random>
#include <vector>

#include "io/sample_mesh.hpp"
#include "test_support.hpp"

using slice2mesh::Mesh;
using slice2mesh::QuadraticNodes;

TEST_CASE("every edge of the mesh has one node, in its middle, that all its tets share") {
  const Mesh mesh = slice2mesh_test::mesh_of(slice2mesh_test::stepped_sample());
  const QuadraticNodes nodes = slice2mesh::quadratic_nodes(mesh);
  std::map<std::array<std::int32_t, 2>, std::int32_t> number;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    for (std::size_t e = 0; e < 6; ++e) {
      const auto [i, j] = slice2mesh::kQuadraticEdges[e];
      std::array<std::int32_t, 2> ends = {mesh.tets[t][i], mesh.tets[t][j]};
      if (ends[0] > ends[1]) std::swap(ends[0], ends[1]);
      const std::int32_t edge = nodes.tet_edges[t][e];
      REQUIRE(nodes.edges.at(static_cast<std::size_t>(edge)) == ends);
      REQUIRE(number.insert({ends, edge}).first->second == edge);
      const std::array<double, 3> p = nodes.middle(mesh, static_cast<std::size_t>(edge));
      for (std::size_t k = 0; k < 3; ++k)
        REQUIRE(p[k] == (mesh.vertices[static_cast<std::size_t>(ends[0])][k] +
                         mesh.vertices[static_cast<std::size_t>(ends[1])][k]) /
                            2);
    }
  CHECK(number.size() == nodes.edges.size());
  CHECK(std::is_sorted(nodes.edges.begin(), nodes.edges.end()));
  // The tets of six per box: a box has 19 edges.
  const QuadraticNodes box = slice2mesh::quadratic_nodes(slice2mesh_test::mesh_of(slice2mesh_test::single_box()));
  CHECK(box.edges.size() == 19);
}

TEST_CASE("the nodes of edges do not depend on the order of the tets") {
  const std::uint32_t seed = 11;
  INFO("seed " << seed);
  const Mesh mesh = slice2mesh_test::mesh_of(slice2mesh_test::stepped_sample());
  std::vector<std::size_t> order(mesh.tets.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::shuffle(order.begin(), order.end(), std::mt19937(seed));
  Mesh shuffled = mesh;
  for (std::size_t i = 0; i < order.size(); ++i) shuffled.tets[i] = mesh.tets[order[i]];
  CHECK(slice2mesh::quadratic_nodes(shuffled).edges == slice2mesh::quadratic_nodes(mesh).edges);
}

TEST_CASE("an edge is found by its corners, either way round") {
  for (std::size_t e = 0; e < 6; ++e) {
    const auto [i, j] = slice2mesh::kQuadraticEdges[e];
    CHECK(slice2mesh::detail::quadratic_edge(i, j) == e);
    CHECK(slice2mesh::detail::quadratic_edge(j, i) == e);
  }
}
