// SPDX-License-Identifier: MIT
// Every mesh format from one mesh, made by hand: a column of two cubes, the upper one a layer of its own. Needs
// slice2mesh::core alone.
//
//   fem_files DIRECTORY
#include <slice2mesh/io/write_mesh.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <sstream>

int main(int argc, char* argv[]) try {
  if (argc != 2) throw std::runtime_error("usage: fem_files DIRECTORY");
  const std::filesystem::path directory = argv[1];
  std::filesystem::create_directories(directory);

  slice2mesh::Mesh mesh;
  mesh.slabs = {{0, 1, 0, 0, 0}, {1, 2, 1, 1, 1}};  // z_low, z_high, and the slices they stand for
  mesh.regions = {{1, slice2mesh::RegionKind::Part, "column"}};
  for (const double z : {0.0, 1.0, 2.0})
    for (const std::array<double, 2> p : {std::array<double, 2>{0, 0}, {1, 0}, {0, 1}, {1, 1}})
      mesh.vertices.push_back({p[0], p[1], z});
  for (std::int32_t slab = 0; slab < 2; ++slab) {
    const std::int32_t v = 4 * slab;
    // A cube in six tets around its diagonal from v to v + 7.
    for (const std::array<std::int32_t, 2> middle :
         {std::array<std::int32_t, 2>{1, 3}, {3, 2}, {2, 6}, {6, 4}, {4, 5}, {5, 1}}) {
      mesh.tets.push_back({v, v + middle[0], v + middle[1], v + 7});
      mesh.tet_slab.push_back(slab);
      mesh.tet_region.push_back(0);
    }
  }

  slice2mesh::WriteOptions options;
  options.time_per_layer = 10;                       // activation times in VTU, PVD and Exodus II
  options.inp_steps = slice2mesh::InpStepOptions{};  // column_steps.inp: a thermal job, layer after layer
  options.layer_faces = true;                        // the faces that each layer covers and newly exposes
  for (const char* const name : {"column.vtu", "column.pvd", "column.msh", "column.mesh", "column.inp", "column.mfem",
                                 "column.node", "column.exo"}) {
    if (slice2mesh::format_of_extension(std::filesystem::path(name).extension().string()) ==
            slice2mesh::MeshFormat::Exodus &&
        !slice2mesh::kHasExodus)
      continue;
    slice2mesh::write_mesh((directory / name).string(), mesh, options);
    std::cout << name << '\n';
  }
  options.quadratic = true;  // ten nodes per tet
  slice2mesh::write_mesh((directory / "quadratic.vtu").string(), mesh, options);

  // Each format also goes to a stream.
  std::ostringstream text;
  slice2mesh::write_mesh(text, slice2mesh::MeshFormat::Msh, mesh, options);
  std::cout << text.str().size() << " characters of MSH in memory\n";
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
