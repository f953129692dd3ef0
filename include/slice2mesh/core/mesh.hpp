// SPDX-License-Identifier: MIT
/// @file
/// @brief Mesh: tetrahedra, each in one slab and one region.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/slab.hpp"

namespace slice2mesh {

/// A tetrahedral mesh. Arrays are dense and row-major, so that `vertices.data()->data()` is a #V by 3 array of doubles
/// and `tets.data()->data()` a #T by 4 array of 32-bit integers.
struct Mesh {
  std::vector<std::array<double, 3>> vertices;    ///< #V by 3: x, y, z in mm
  std::vector<std::array<std::int32_t, 4>> tets;  ///< #T by 4: indices of vertices; positive: (b-a) x (c-a) . (d-a) > 0
  std::vector<std::int32_t> tet_slab;             ///< #T, index into slabs
  std::vector<std::int32_t> tet_region;           ///< #T, index into regions
  std::vector<Facet> facets;                      ///< #F labelled facets (skin, interfaces, walls), may be empty
  std::vector<Slab> slabs;                        ///< #S, lowest first
  std::vector<Region> regions;                    ///< #R
};

}  // namespace slice2mesh
