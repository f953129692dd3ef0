// SPDX-License-Identifier: MIT
// Reads an MSH file with deal.II and prints, as JSON, what it finds: number and volume of cells by material id, number
// and area of boundary faces by boundary id. Built where deal.II is installed; run by check_deal_ii.py.
#include <deal.II/grid/grid_in.h>
#include <deal.II/grid/tria.h>

#include <cmath>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <fstream>
#include <map>
#include <utility>

namespace {

using Sums = std::map<unsigned int, std::pair<std::size_t, double>>;

void print(const char* name, const Sums& sums) {
  std::printf("\"%s\": {", name);
  const char* separator = "";
  for (const auto& [id, sum] : sums) {
    std::printf("%s\"%u\": [%zu, %.17g]", separator, id, sum.first, sum.second);
    separator = ", ";
  }
  std::printf("}");
}

dealii::Tensor<1, 3> cross(const dealii::Tensor<1, 3>& a, const dealii::Tensor<1, 3>& b) {
  return dealii::cross_product_3d(a, b);
}

}  // namespace

int main(int argc, char* argv[]) try {
  if (argc != 2) return 1;
  dealii::Triangulation<3> mesh;
  dealii::GridIn<3> reader;
  reader.attach_triangulation(mesh);
  std::ifstream file(argv[1]);
  reader.read_msh(file);
  Sums materials;
  Sums boundaries;
  for (const auto& cell : mesh.active_cell_iterators()) {
    auto& material = materials[cell->material_id()];
    ++material.first;
    material.second += std::fabs(cross(cell->vertex(1) - cell->vertex(0), cell->vertex(2) - cell->vertex(0)) *
                                 (cell->vertex(3) - cell->vertex(0))) /
                       6;
    for (const unsigned int f : cell->face_indices()) {
      const auto face = cell->face(f);
      if (!face->at_boundary()) continue;
      auto& boundary = boundaries[face->boundary_id()];
      ++boundary.first;
      boundary.second += cross(face->vertex(1) - face->vertex(0), face->vertex(2) - face->vertex(0)).norm() / 2;
    }
  }
  std::printf("{\"vertices\": %u, ", mesh.n_used_vertices());
  print("materials", materials);
  std::printf(", ");
  print("boundaries", boundaries);
  std::printf("}\n");
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
