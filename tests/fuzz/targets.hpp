// SPDX-License-Identifier: MIT
/// @file
/// @brief The fuzz targets: each takes any bytes, and throws `Failure` (or crashes) only where there is a fault.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace slice2mesh_fuzz {

/// Bytes as a slice file, read in every way: a typed error, or a stack that is written and read back as the same.
void read_cli(const std::uint8_t* data, std::size_t size);
/// A stack of slices from the bytes, written as text and binary and read back.
void write_cli(const std::uint8_t* data, std::size_t size);
/// A small mesh from the bytes, written in every format and, where there is a reader, read back.
void mesh_files(const std::uint8_t* data, std::size_t size);
/// Bytes as a mesh file of another mesher (.msh, .mesh, .node and .ele): a typed error, or tets with vertices.
void read_tets(const std::uint8_t* data, std::size_t size);
/// A small stack and options from the bytes, through the whole pipeline: certified, or a typed error.
void pipeline(const std::uint8_t* data, std::size_t size);

struct Target {
  const char* name;  ///< also of the directory of its inputs below corpus/
  void (*run)(const std::uint8_t*, std::size_t);
};
inline constexpr std::array<Target, 5> kTargets = {{{"read_cli", read_cli},
                                                    {"write_cli", write_cli},
                                                    {"mesh_files", mesh_files},
                                                    {"read_tets", read_tets},
                                                    {"pipeline", pipeline}}};

}  // namespace slice2mesh_fuzz
