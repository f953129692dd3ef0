// SPDX-License-Identifier: MIT
/// @file
/// @brief The tetrahedralizer that the command line names.
#pragma once

#include <cstdint>
#include <string>

#include "slice2mesh/core/length.hpp"
#include "slice2mesh/tet/tetrahedralizer.hpp"

namespace slice2mesh_program {

/// What the command line says about the tetrahedralizer.
struct MesherChoice {
  std::string mesher = "slab";  ///< slab, mesh3, tetgen, cdt3, or a command line with {in} or {skin}
  std::string arguments;        ///< tetgen: switches; mesh3: words like size=0.4; command: appended
  slice2mesh::Length size;      ///< of elements, for mesh3; 0: its own default
  slice2mesh::Length eps;       ///< tolerance, for mesh3; 0: its own default
  double time_limit = 0;        ///< seconds, of what runs in a child process; 0: the limit of the model
  std::int64_t max_tets = 0;    ///< budget of the slab filler; 0: none
};

/// What `--mesher-args` of mesh3 can say, for the help.
inline constexpr const char* kMesh3Arguments =
    "size, edge, distance (lengths), angle, ratio, features (degrees), perturb, exude (yes or no)";

/// The tetrahedralizer that is meant. Errors: UsageError for names and arguments that mean nothing, and for models that
/// this program was built without.
[[nodiscard]] slice2mesh::AnyTetrahedralizer make_mesher(const MesherChoice& choice);

/// The models of CGAL, which take long to compile.
[[nodiscard]] slice2mesh::AnyTetrahedralizer make_mesh3(const MesherChoice& choice);
[[nodiscard]] slice2mesh::AnyTetrahedralizer make_cdt3(const MesherChoice& choice);

}  // namespace slice2mesh_program
