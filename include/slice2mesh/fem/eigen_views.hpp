// SPDX-License-Identifier: MIT
/// @file
/// @brief Eigen views of a mesh: #V by 3 and #T by 4 matrices without copying.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "slice2mesh/core/mesh.hpp"

namespace slice2mesh {

/// #V by 3 doubles, row-major: x, y, z in mm.
using VertexMatrix = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// #T by 4 indices of vertices, row-major.
using TetMatrix = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 4, Eigen::RowMajor>;
/// #T indices of slabs or regions.
using LabelVector = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 1>;

static_assert(sizeof(std::array<double, 3>) == 3 * sizeof(double), "the views need dense rows");
static_assert(sizeof(std::array<std::int32_t, 4>) == 4 * sizeof(std::int32_t), "the views need dense rows");

/// Vertices as a #V by 3 matrix (mm) that shares the mesh's memory: valid until the mesh's array is resized or gone.
[[nodiscard]] inline Eigen::Map<const VertexMatrix> vertex_view(const Mesh& mesh) {
  return {mesh.vertices.empty() ? nullptr : mesh.vertices.data()->data(),
          static_cast<Eigen::Index>(mesh.vertices.size()), 3};
}
/// The same, for writing.
[[nodiscard]] inline Eigen::Map<VertexMatrix> vertex_view(Mesh& mesh) {
  return {mesh.vertices.empty() ? nullptr : mesh.vertices.data()->data(),
          static_cast<Eigen::Index>(mesh.vertices.size()), 3};
}
/// Tets as a #T by 4 matrix of vertex indices that shares the mesh's memory, valid as long as that of vertex_view.
[[nodiscard]] inline Eigen::Map<const TetMatrix> tet_view(const Mesh& mesh) {
  return {mesh.tets.empty() ? nullptr : mesh.tets.data()->data(), static_cast<Eigen::Index>(mesh.tets.size()), 4};
}
/// The same, for writing.
[[nodiscard]] inline Eigen::Map<TetMatrix> tet_view(Mesh& mesh) {
  return {mesh.tets.empty() ? nullptr : mesh.tets.data()->data(), static_cast<Eigen::Index>(mesh.tets.size()), 4};
}
/// `labels` (tet_slab, tet_region: #T indices) as a vector of #T that shares their memory: valid until they are resized
/// or gone.
[[nodiscard]] inline Eigen::Map<const LabelVector> label_view(const std::vector<std::int32_t>& labels) {
  return {labels.data(), static_cast<Eigen::Index>(labels.size())};
}
// A view of a mesh that is about to vanish would dangle.
Eigen::Map<const VertexMatrix> vertex_view(const Mesh&&) = delete;
Eigen::Map<const TetMatrix> tet_view(const Mesh&&) = delete;
Eigen::Map<const LabelVector> label_view(const std::vector<std::int32_t>&&) = delete;

}  // namespace slice2mesh
