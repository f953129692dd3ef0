// SPDX-License-Identifier: MIT
#include "slice2mesh/fem/eigen_views.hpp"

#include <cstddef>
#include <cstdint>

#include "io/sample_mesh.hpp"
#include "test_support.hpp"

TEST_CASE("Eigen views show the mesh's own memory") {
  slice2mesh::Mesh mesh = slice2mesh_test::mesh_of(slice2mesh_test::stepped_sample());
  const auto vertices = slice2mesh::vertex_view(mesh);
  const auto tets = slice2mesh::tet_view(mesh);
  const auto layers = slice2mesh::label_view(mesh.tet_slab);
  REQUIRE(vertices.rows() == static_cast<Eigen::Index>(mesh.vertices.size()));
  REQUIRE(vertices.cols() == 3);
  REQUIRE(tets.rows() == static_cast<Eigen::Index>(mesh.tets.size()));
  REQUIRE(tets.cols() == 4);
  CHECK(vertices.data() == &mesh.vertices[0][0]);
  CHECK(tets.data() == &mesh.tets[0][0]);
  CHECK(layers.data() == mesh.tet_slab.data());
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    for (std::size_t i = 0; i < 3; ++i)
      REQUIRE(vertices(static_cast<Eigen::Index>(v), static_cast<Eigen::Index>(i)) == mesh.vertices[v][i]);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    for (std::size_t i = 0; i < 4; ++i)
      REQUIRE(tets(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(i)) == mesh.tets[t][i]);
  CHECK(layers.maxCoeff() == 3);
}

TEST_CASE("writing through a view changes the mesh, and a const mesh gives a const view") {
  slice2mesh::Mesh mesh = slice2mesh_test::mesh_of(slice2mesh_test::single_box());
  slice2mesh::vertex_view(mesh) *= 2;
  CHECK(slice2mesh::vertex_view(mesh).colwise().maxCoeff() == Eigen::RowVector3d(2, 2, 2));
  const slice2mesh::Mesh& constant = mesh;
  CHECK(slice2mesh::vertex_view(constant).sum() == slice2mesh::vertex_view(mesh).sum());
  CHECK(slice2mesh::tet_view(constant).minCoeff() == 0);
  slice2mesh::tet_view(mesh)(0, 0) = 3;
  CHECK(mesh.tets[0][0] == 3);
}

TEST_CASE("views of an empty mesh have no rows") {
  slice2mesh::Mesh mesh;
  CHECK(slice2mesh::vertex_view(mesh).rows() == 0);
  CHECK(slice2mesh::tet_view(mesh).rows() == 0);
  CHECK(slice2mesh::label_view(mesh.tet_region).size() == 0);
}
