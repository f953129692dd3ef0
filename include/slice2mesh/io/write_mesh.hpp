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
#include "slice2mesh/io/medit.hpp"
#include "slice2mesh/io/msh.hpp"
#include "slice2mesh/io/plc_files.hpp"
#include "slice2mesh/io/vtu.hpp"
#include "slice2mesh/io/write_options.hpp"

namespace slice2mesh {

namespace detail {

/// Extension of a file name in lower case, without the dot; empty if there is none.
[[nodiscard]] inline std::string extension(const std::string& path) {
  const std::size_t dot = path.find_last_of('.');
  const std::size_t slash = path.find_last_of("/\\");
  if (dot == std::string::npos || (slash != std::string::npos && dot < slash)) return {};
  std::string result = path.substr(dot + 1);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

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
  for (const char* const known : {"vtu", "msh", "mesh"})
    if (e == known) return;
  detail::throw_unknown_extension(path, ".vtu, .msh, .mesh");
}

/// Throws FileError unless `write_plc` knows a format for the path.
inline void check_plc_path(const std::string& path) {
  const std::string e = detail::extension(path);
  for (const char* const known : {"off", "obj", "ply", "stl"})
    if (e == known) return;
  detail::throw_unknown_extension(path, ".off, .obj, .ply, .stl");
}

/// Write a mesh, whole or not at all; the format follows from the extension (any case): .vtu (VTK), .msh (Gmsh 4.1),
/// .mesh (MEDIT). See the writers of the formats for what they keep. The same mesh and options give the same bytes.
/// Errors: FileError (unknown extension, naming the known ones; the file cannot be written), Error (Stage::Write) for a
/// mesh whose arrays do not fit together or that has a coordinate that is not finite. Cost: linear.
inline void write_mesh(const std::string& path, const Mesh& mesh, const WriteOptions& options = {}) {
  check_mesh_path(path);
  const std::string e = detail::extension(path);
  if (e == "vtu")
    write_vtu(path, mesh, options);
  else if (e == "msh")
    write_msh(path, mesh, options);
  else
    write_medit(path, mesh, options);
}

/// Write a PLC, whole or not at all; the format follows from the extension (any case): .off, .obj, .ply, .stl.
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
    else
      write_stl(out, plc, options);
  });
}

}  // namespace slice2mesh
