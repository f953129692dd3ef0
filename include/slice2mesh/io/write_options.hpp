// SPDX-License-Identifier: MIT
/// @file
/// @brief Options of the writers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

namespace slice2mesh {

/// What the mesh writers can be told. A field that a format has no use for is ignored by it.
struct WriteOptions {
  bool binary = false;      ///< MSH: binary instead of text
  bool compress = false;    ///< VTU: zlib; OptionError where the build has no zlib (SLICE2MESH_HAS_ZLIB)
  bool surfaces = true;     ///< MSH, MEDIT, INP, MFEM: write the boundary sets
  bool interfaces = true;   ///< with the inner faces between part and support (some readers refuse inner faces)
  bool mfem_names = false;  ///< MFEM: format v1.3 with named sets instead of v1.0
  /// s, >= 0; if > 0 (or `activation` is set) VTU has the cell array activation_time = layer * time_per_layer
  double time_per_layer = 0;
  /// time (s) at which a tet comes to life, from its slab and index; used instead of time_per_layer if set
  std::function<double(std::int32_t slab, std::size_t tet)> activation;
};

/// What the PLC writers can be told.
struct PlcWriteOptions {
  bool inner_faces = true;  ///< false: the outer skin alone, with the vertices it uses
};

}  // namespace slice2mesh
