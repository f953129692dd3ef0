// SPDX-License-Identifier: MIT
/// @file
/// @brief Write a mesh or a PLC, format by extension.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <ostream>
#include <string>

#include "slice2mesh/core/atomic_file.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/io/exodus.hpp"
#include "slice2mesh/io/inp.hpp"
#include "slice2mesh/io/medit.hpp"
#include "slice2mesh/io/mfem.hpp"
#include "slice2mesh/io/msh.hpp"
#include "slice2mesh/io/plc_files.hpp"
#include "slice2mesh/io/pvd.hpp"
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

/// The formats of meshes. Each is one stream, but PVD (a collection and its steps) and TetGen (two files).
enum class MeshFormat : std::uint8_t {
  Vtu,             ///< `.vtu`: write_vtu
  Pvd,             ///< `.pvd`: write_pvd
  Msh,             ///< `.msh`: write_msh
  Medit,           ///< `.mesh`: write_medit
  Inp,             ///< `.inp`: write_inp
  Mfem,            ///< `.mfem`: write_mfem
  TetgenNodes,     ///< `.node`, and `.ele` beside it
  TetgenElements,  ///< `.ele`, and `.node` beside it
  Exodus           ///< `.exo`, `.e`: write_exodus, in builds with netCDF
};

/// The format that an extension (with or without the dot, any case) stands for, or nothing.
[[nodiscard]] inline std::optional<MeshFormat> format_of_extension(std::string extension) {
  if (!extension.empty() && extension[0] == '.') extension.erase(0, 1);
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  if (extension == "vtu") return MeshFormat::Vtu;
  if (extension == "pvd") return MeshFormat::Pvd;
  if (extension == "msh") return MeshFormat::Msh;
  if (extension == "mesh") return MeshFormat::Medit;
  if (extension == "inp") return MeshFormat::Inp;
  if (extension == "mfem") return MeshFormat::Mfem;
  if (extension == "node") return MeshFormat::TetgenNodes;
  if (extension == "ele") return MeshFormat::TetgenElements;
  if (extension == "exo" || extension == "e") return MeshFormat::Exodus;
  return std::nullopt;
}

/// The format of a file name. Throws FileError unless `write_mesh` knows one that this build can write. Lets a program
/// fail before the work is done.
inline MeshFormat check_mesh_path(const std::string& path) {
  const std::optional<MeshFormat> format = format_of_extension(detail::extension(path));
  if (!format) detail::throw_unknown_extension(path, ".vtu, .msh, .mesh, .inp, .mfem, .node, .ele, .pvd, .exo, .e");
  if (*format == MeshFormat::Exodus && !kHasExodus)
    throw FileError(Stage::Write, path, "this build cannot write Exodus II, which needs netCDF");
  return *format;
}

/// Throws FileError unless `write_plc` knows a format for the path.
inline void check_plc_path(const std::string& path) {
  const std::string e = detail::extension(path);
  for (const char* const known : {"off", "obj", "ply", "stl", "poly"})
    if (e == known) return;
  detail::throw_unknown_extension(path, ".off, .obj, .ply, .stl, .poly");
}

/// Write a mesh to a stream. Errors: OptionError for Pvd, which is not one stream (see `write_pvd_frame`); those of the
/// format. The state of the stream tells whether everything was taken. Cost: linear.
inline void write_mesh(std::ostream& out, MeshFormat format, const Mesh& mesh, const WriteOptions& options = {}) {
  switch (format) {
    case MeshFormat::Vtu: return write_vtu(out, mesh, options);
    case MeshFormat::Pvd: throw OptionError("format", "PVD is a collection of files and cannot be one stream");
    case MeshFormat::Msh: return write_msh(out, mesh, options);
    case MeshFormat::Medit: return write_medit(out, mesh, options);
    case MeshFormat::Inp: return write_inp(out, mesh, options);
    case MeshFormat::Mfem: return write_mfem(out, mesh, options);
    case MeshFormat::TetgenNodes: return write_tetgen_nodes(out, mesh, options);
    case MeshFormat::TetgenElements: return write_tetgen_elements(out, mesh, options);
    case MeshFormat::Exodus: return write_exodus(out, mesh, options);
  }
  throw OptionError("format", "is not one of the formats");
}

/// Write a mesh, whole or not at all; the format follows from the extension (any case): .vtu (VTK), .pvd (the growing
/// domains, see `write_pvd`), .msh (Gmsh 4.1), .mesh (MEDIT), .inp (Abaqus, CalculiX; with `inp_steps` the steps as
/// well), .mfem (MFEM), .node or .ele (TetGen, both are written), .exo or .e (Exodus II, where the build has netCDF).
/// See the writers of the formats for what they keep. The same mesh and options give the same bytes. Errors: FileError
/// (unknown extension, naming the known ones; the file cannot be written), OptionError, Error (Stage::Write) for a mesh
/// whose arrays do not fit together or that has a coordinate that is not finite. Cost: linear, but for PVD.
inline void write_mesh(const std::string& path, const Mesh& mesh, const WriteOptions& options = {}) {
  const MeshFormat format = check_mesh_path(path);
  if (format == MeshFormat::Pvd) return write_pvd(path, mesh, options);
  if (format == MeshFormat::TetgenNodes || format == MeshFormat::TetgenElements)
    return write_tetgen(path, mesh, options);
  if (format == MeshFormat::Inp && options.inp_steps) return write_inp_job(path, mesh, *options.inp_steps, options);
  write_file_atomically(path, Stage::Write, [&](std::ostream& out) { write_mesh(out, format, mesh, options); });
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
