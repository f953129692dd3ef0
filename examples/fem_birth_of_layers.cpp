// SPDX-License-Identifier: MIT
// What a solver needs while a part grows: the elements born with each layer, the surface that is exposed then, and the
// sub-mesh up to it. The solver here is lumped cooling, one temperature for all: T' = -h A (T - T_air) / (rho c V).
//
//   fem_birth_of_layers sample.cli
#include <slice2mesh/slice2mesh.hpp>

#include <cmath>
#include <cstddef>
#include <iomanip>
#include <iostream>

int main(int argc, char* argv[]) try {
  if (argc != 2) throw std::runtime_error("usage: fem_birth_of_layers part.cli");
  slice2mesh::Options options;
  options.supports.radius = slice2mesh::Length::mm(0.1);
  options.slabs.lump = 4;
  options.plate.thickness = slice2mesh::Length::mm(2);  // a base plate, 3 mm wider than the part
  options.plate.margin = slice2mesh::Length::mm(3);
  const slice2mesh::Mesh mesh = slice2mesh::slice_to_mesh(slice2mesh::read_cli(argv[1]), options).mesh;

  constexpr double kTimePerLayer = 10;       // s
  constexpr double kFilm = 2e-5;             // W/(mm^2 K)
  constexpr double kCapacity = 8e-6 * 500;   // J/(mm^3 K): density times specific heat of a steel
  constexpr double kHot = 1500, kAir = 300;  // K
  const slice2mesh::BoundarySets sets = slice2mesh::boundary_sets(mesh);
  const std::int32_t plate = slice2mesh::plate_slabs(mesh);

  double temperature = kAir;
  std::cout << std::fixed << std::setprecision(1);
  for (const slice2mesh::GrowingDomain& domain : slice2mesh::growing_domains(mesh)) {
    if (domain.slab < plate) continue;  // the plate is there from the beginning
    const auto k = static_cast<std::size_t>(domain.slab);
    // What is born is hot and shares its heat with what is there.
    const double before = k > 0 ? sets.volume[k - 1] : 0;
    temperature = (before * temperature + (sets.volume[k] - before) * kHot) / sets.volume[k];
    // The faces exposed now, for convection: exposed_faces gives them, exposed_area their area.
    const auto faces = slice2mesh::exposed_faces(sets, domain.slab);
    const double rate = kFilm * sets.exposed_area[k] / (kCapacity * sets.volume[k]);
    temperature = kAir + (temperature - kAir) * std::exp(-rate * kTimePerLayer);
    std::cout << "layer " << domain.slab - plate + 1 << ": " << domain.born.size() << " tets born, " << faces.size()
              << " faces exposed, " << temperature << " K\n";
  }

  // A solver with its own arrays takes the mesh as it is: no copies are made.
  const auto vertices = slice2mesh::vertex_view(mesh);  // #V by 3
  const auto tets = slice2mesh::tet_view(mesh);         // #T by 4
  std::cout << "whole mesh: " << vertices.rows() << " vertices, " << tets.rows() << " tets\n";
  // And a solver that starts with some layers only takes their sub-mesh, with its own numbering.
  const slice2mesh::SubMesh lower = slice2mesh::layers_of(mesh, 0, plate + 1);
  std::cout << "plate and two layers: " << lower.mesh.vertices.size() << " vertices, " << lower.mesh.tets.size()
            << " tets\n";
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
