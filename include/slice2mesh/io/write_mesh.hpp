// SPDX-License-Identifier: MIT
/// @file
/// @brief Write a mesh or a PLC, format by extension.
#pragma once

#include <cstddef>
#include <string>

#include "slice2mesh/core/atomic_file.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/io/inp.hpp"
#include "slice2mesh/io/medit.hpp"
#include "slice2mesh/io/mfem.hpp"
#include "slice2mesh/io/msh.hpp"
#include "slice2mesh/io/plc_files.hpp"
#include "slice2mesh/io/tetgen_files.hpp"
#include "slice2mesh/io/vtu.hpp"
#include "slice2mesh/io/write_options.hpp"

namespace slice2mesh {

namespace detail {

[[noreturn]] inline void throw_unknown_extension(const std::string& path, const char* known) {
  const std::string found = extension(path);
  throw FileError(Stage::Write, path,
                  (found.empty() ? std::string("the name has no extension") : "unknown extension ." + found) +
                      "; known are " + known);
}

}  // namespace detail

/// Throws FileError unless `write_mesh` knows a format for the path. Lets a program fail before the work is done.
inline void check_mesh_path(const std::string& path) {
  const std::string e = detail::extension(path);
  for (const char* const known : {"vtu", "msh", "mesh", "inp", "mfem", "node", "ele"})
    if (e == known) return;
  detail::throw_unknown_extension(path, ".vtu, .msh, .mesh, .inp, .mfem, .node, .ele");
}

/// Throws FileError unless `write_plc` knows a format for the path.
inline void check_plc_path(const std::string& path) {
  const std::string e = detail::extension(path);
  for (const char* const known : {"off", "obj", "ply", "stl", "poly"})
    if (e == known) return;
  detail::throw_unknown_extension(path, ".off, .obj, .ply, .stl, .poly");
}

/// Write a mesh, whole or not at all; the format follows from the extension (any case): .vtu (VTK), .msh (Gmsh 4.1),
/// .mesh (MEDIT), .inp (Abaqus, CalculiX), .mfem (MFEM), .node or .ele (TetGen, both are written). See the writers of
/// the formats for what they keep. The same mesh and options give the same bytes. Errors: FileError (unknown extension,
/// naming the known ones; the file cannot be written), Error (Stage::Write) for a mesh whose arrays do not fit together
/// or that has a coordinate that is not finite. Cost: linear.
inline void write_mesh(const std::string& path, const Mesh& mesh, const WriteOptions& options = {}) {
  check_mesh_path(path);
  const std::string e = detail::extension(path);
  if (e == "vtu")
    write_vtu(path, mesh, options);
  else if (e == "msh")
    write_msh(path, mesh, options);
  else if (e == "mesh")
    write_medit(path, mesh, options);
  else if (e == "inp")
    write_inp(path, mesh, options);
  else if (e == "mfem")
    write_mfem(path, mesh, options);
  else
    write_tetgen(path, mesh);
}

/// Write a PLC, whole or not at all; the format follows from the extension (any case): .off, .obj, .ply,
/// .stl, .poly.
/// Errors: FileError, Error (Stage::Write) for a complex whose arrays do not fit together. Cost: linear.
inline void write_plc(const std::string& path, const Plc& plc, const PlcWriteOptions& options = {}) {
  check_plc_path(path);
  const std::string e = detail::extension(path);
  write_file_atomically(path, Stage::Write, [&](std::ostream& out) {
    if (e == "off")
      write_off(out, plc, options);
    else if (e == "obj")
      write_obj(out, plc, options);
    else if (e == "ply")
      write_ply(out, plc, options);
    else if (e == "stl")
      write_stl(out, plc, options);
    else
      write_poly(out, plc, options);
  });
}

}  // namespace slice2mesh
