// SPDX-License-Identifier: MIT
/// @file
/// @brief VTU: VTK unstructured grid, XML with raw appended data.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <ostream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#ifdef SLICE2MESH_HAS_ZLIB
#include <zlib.h>
#endif

#include "slice2mesh/core/atomic_file.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/fem/activation.hpp"
#include "slice2mesh/io/element_groups.hpp"
#include "slice2mesh/io/output_buffer.hpp"
#include "slice2mesh/io/write_options.hpp"

namespace slice2mesh {

namespace detail {

using ByteSink = std::function<void(const void*, std::size_t)>;

/// One array of a VTU file: what its element says, and a function that hands out its bytes piece by piece.
struct VtuArray {
  const char* type;
  std::string name;
  std::size_t components;
  std::size_t tuples;
  std::size_t value_bytes;
  std::function<void(const ByteSink&)> emit;
  [[nodiscard]] std::uint64_t bytes() const { return std::uint64_t{components} * tuples * value_bytes; }
};

/// An array that is in memory as it stands in the file.
template <class T>
[[nodiscard]] VtuArray stored_array(const char* type, std::string name, std::size_t components, std::size_t tuples,
                                    const T* data) {
  const std::size_t bytes = components * tuples * sizeof(T);
  return {type, std::move(name), components, tuples, sizeof(T), [data, bytes](const ByteSink& sink) {
            if (bytes > 0) sink(data, bytes);
          }};
}

/// Number of components of a tuple.
template <class T>
struct TupleSize : std::integral_constant<std::size_t, 1> {};
template <class T, std::size_t n>
struct TupleSize<std::array<T, n>> : std::integral_constant<std::size_t, n> {};

/// An array whose tuples (numbers, or std::array of them) are computed from their index when they are written.
template <class T, class Function>
[[nodiscard]] VtuArray computed_array(const char* type, std::string name, std::size_t tuples, Function value) {
  constexpr std::size_t kComponents = TupleSize<T>::value;
  return {type, std::move(name), kComponents, tuples, sizeof(T) / kComponents, [tuples, value](const ByteSink& sink) {
            std::vector<T> piece(std::min<std::size_t>(tuples, 8192));
            for (std::size_t begin = 0; begin < tuples; begin += piece.size()) {
              const std::size_t count = std::min(piece.size(), tuples - begin);
              for (std::size_t i = 0; i < count; ++i) piece[i] = value(begin + i);
              sink(piece.data(), count * sizeof(T));
            }
          }};
}

#ifdef SLICE2MESH_HAS_ZLIB
/// The array as the format's zlib block: number of blocks, their size, size of a last partial one (or 0), compressed
/// sizes (64 bits each), data.
[[nodiscard]] inline std::vector<unsigned char> compressed_array(const VtuArray& array,
                                                                 const std::function<void()>& poll) {
  constexpr std::size_t kBlock = std::size_t{1} << 18;
  std::vector<std::uint64_t> sizes;
  std::vector<unsigned char> data;
  std::vector<unsigned char> pending;
  const auto compress_block = [&](const unsigned char* block, std::size_t count) {
    if (poll) poll();
    uLongf room = compressBound(static_cast<uLong>(count));
    const std::size_t old_size = data.size();
    data.resize(old_size + room);
    if (compress2(data.data() + old_size, &room, block, static_cast<uLong>(count), Z_BEST_SPEED) != Z_OK)
      throw Error(Stage::Write, "zlib cannot compress the array " + array.name);
    data.resize(old_size + room);
    sizes.push_back(room);
  };
  array.emit([&](const void* bytes, std::size_t count) {
    const auto* source = static_cast<const unsigned char*>(bytes);
    while (count > 0) {
      const std::size_t taken = std::min(count, kBlock - pending.size());
      pending.insert(pending.end(), source, source + taken);
      source += taken;
      count -= taken;
      if (pending.size() == kBlock) {
        compress_block(pending.data(), pending.size());
        pending.clear();
      }
    }
  });
  const std::uint64_t partial = pending.size();
  if (partial > 0) compress_block(pending.data(), pending.size());
  std::vector<std::uint64_t> header = {sizes.size(), kBlock, partial};
  header.insert(header.end(), sizes.begin(), sizes.end());
  std::vector<unsigned char> result(header.size() * sizeof(std::uint64_t));
  std::memcpy(result.data(), header.data(), result.size());
  result.insert(result.end(), data.begin(), data.end());
  return result;
}
#endif

}  // namespace detail

/// Write a mesh as VTU (file version 1.0, 64-bit headers, raw appended data, byte order of this machine).
/// Cell arrays: layer (index of the slab, from 0), bundle (first and last slice of the file that the slab stands for,
/// -1 in the base plate), slice (the slice that represents them), part (part id), region (index of the region),
/// material (0 part, 1 support, 2 base plate), and activation_time (s) where the options ask for it. Field arrays:
/// slab_z_low, slab_z_high (mm, #S), slab_first_layer, slab_last_layer (#S), region_part (#R). Coordinates are exact,
/// but for the middles of edges of quadratic tets (VTK_QUADRATIC_TETRA), which are rounded. Options used: compress,
/// quadratic, time_per_layer, activation. Errors: Error (Stage::Write) for a mesh whose arrays do not fit together;
/// OptionError for `compress` without zlib. The state of the stream tells whether everything was taken. Cost: linear;
/// without compression no copy of the mesh.
inline void write_vtu(std::ostream& out, const Mesh& mesh, const WriteOptions& options = {}) {
  detail::check_writable(mesh, options.poll);
#ifndef SLICE2MESH_HAS_ZLIB
  if (options.compress) throw OptionError("compress", "this build has no zlib");
#endif
  if (!(options.time_per_layer >= 0)) throw OptionError("time_per_layer", "must not be negative");
  const std::size_t tet_count = mesh.tets.size();
  const std::int32_t plate = plate_slabs(mesh);
  const auto tet_region = [&mesh](std::size_t t) -> const Region& {
    return mesh.regions[static_cast<std::size_t>(mesh.tet_region[t])];
  };
  using detail::computed_array;
  using detail::stored_array;
  std::vector<detail::VtuArray> field;
  std::vector<detail::VtuArray> cell_data;
  std::vector<detail::VtuArray> points;
  std::vector<detail::VtuArray> cells;
  field.push_back(computed_array<double>("Float64", "slab_z_low", mesh.slabs.size(),
                                         [&](std::size_t s) { return mesh.slabs[s].z_low; }));
  field.push_back(computed_array<double>("Float64", "slab_z_high", mesh.slabs.size(),
                                         [&](std::size_t s) { return mesh.slabs[s].z_high; }));
  field.push_back(computed_array<std::int32_t>("Int32", "slab_first_layer", mesh.slabs.size(),
                                               [&](std::size_t s) { return mesh.slabs[s].first_layer; }));
  field.push_back(computed_array<std::int32_t>("Int32", "slab_last_layer", mesh.slabs.size(),
                                               [&](std::size_t s) { return mesh.slabs[s].last_layer; }));
  field.push_back(computed_array<std::int32_t>("Int32", "region_part", mesh.regions.size(),
                                               [&](std::size_t r) { return mesh.regions[r].part; }));
  cell_data.push_back(stored_array("Int32", "layer", 1, tet_count, mesh.tet_slab.data()));
  cell_data.push_back(
      computed_array<std::int32_t>("Int32", "part", tet_count, [=](std::size_t t) { return tet_region(t).part; }));
  cell_data.push_back(stored_array("Int32", "region", 1, tet_count, mesh.tet_region.data()));
  cell_data.push_back(computed_array<std::uint8_t>(
      "UInt8", "material", tet_count, [=](std::size_t t) { return static_cast<std::uint8_t>(tet_region(t).kind); }));
  cell_data.push_back(computed_array<std::int32_t>("Int32", "slice", tet_count, [&mesh](std::size_t t) {
    return mesh.slabs[static_cast<std::size_t>(mesh.tet_slab[t])].slice;
  }));
  cell_data.push_back(computed_array<std::array<std::int32_t, 2>>("Int32", "bundle", tet_count, [&](std::size_t t) {
    const ElementLabels labels = element_labels(mesh, t);
    return std::array<std::int32_t, 2>{labels.bundle_first, labels.bundle_last};
  }));
  if (options.activation)
    cell_data.push_back(computed_array<double>("Float64", "activation_time", tet_count,
                                               [&](std::size_t t) { return options.activation(mesh.tet_slab[t], t); }));
  else if (options.time_per_layer > 0)
    cell_data.push_back(
        computed_array<double>("Float64", "activation_time", tet_count, [&mesh, &options, plate](std::size_t t) {
          return options.time_per_layer * std::max(0, mesh.tet_slab[t] - plate);
        }));
  const detail::FileNodes nodes(mesh, options);
  if (options.quadratic) {
    points.push_back(computed_array<std::array<double, 3>>("Float64", "Points", nodes.count(),
                                                           [&nodes](std::size_t v) { return nodes.position(v); }));
    cells.push_back(
        computed_array<std::array<std::int32_t, 10>>("Int32", "connectivity", tet_count, [&nodes](std::size_t t) {
          std::array<std::int32_t, 10> tet{};
          for (std::size_t i = 0; i < 10; ++i) tet[i] = static_cast<std::int32_t>(nodes.of_tet(t, i));
          return tet;
        }));
    cells.back().tuples *= 10;  // the format wants it as a plain list
    cells.back().components = 1;
  } else {
    points.push_back(
        stored_array("Float64", "Points", 3, mesh.vertices.size(),
                     mesh.vertices.empty() ? static_cast<const double*>(nullptr) : mesh.vertices.data()->data()));
    cells.push_back(
        stored_array("Int32", "connectivity", 1, 4 * tet_count,
                     mesh.tets.empty() ? static_cast<const std::int32_t*>(nullptr) : mesh.tets.data()->data()));
  }
  const std::size_t per_tet = nodes.per_tet();
  if (per_tet * tet_count <= static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
    cells.push_back(computed_array<std::int32_t>("Int32", "offsets", tet_count, [per_tet](std::size_t t) {
      return static_cast<std::int32_t>(per_tet * (t + 1));
    }));
  else
    cells.push_back(computed_array<std::int64_t>("Int64", "offsets", tet_count, [per_tet](std::size_t t) {
      return static_cast<std::int64_t>(per_tet * (t + 1));
    }));
  const std::uint8_t cell_type = options.quadratic ? 24 : 10;  // VTK_QUADRATIC_TETRA, VTK_TETRA
  cells.push_back(
      computed_array<std::uint8_t>("UInt8", "types", tet_count, [cell_type](std::size_t) { return cell_type; }));

  std::vector<std::vector<unsigned char>> compressed;
  const auto describe = [&](detail::OutputBuffer& buffer, const std::vector<detail::VtuArray>& arrays, bool with_tuples,
                            std::uint64_t& offset) {
    for (const detail::VtuArray& array : arrays) {
      buffer.text("<DataArray type=\"").text(array.type).text("\" Name=\"").text(array.name).character('"');
      if (array.components > 1) buffer.text(" NumberOfComponents=\"").integer(array.components).character('"');
      if (with_tuples) buffer.text(" NumberOfTuples=\"").integer(array.tuples).character('"');
      buffer.text(" format=\"appended\" offset=\"").integer(offset).text("\"/>\n");
#ifdef SLICE2MESH_HAS_ZLIB
      if (options.compress) {
        compressed.push_back(detail::compressed_array(array, options.poll));
        offset += compressed.back().size();
        continue;
      }
#endif
      offset += sizeof(std::uint64_t) + array.bytes();
    }
  };
  detail::OutputBuffer buffer(out, options.poll);
  std::uint64_t offset = 0;
  buffer.text("<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"")
      .text(detail::is_little_endian() ? "LittleEndian" : "BigEndian")
      .text("\" header_type=\"UInt64\"")
      .text(options.compress ? " compressor=\"vtkZLibDataCompressor\"" : "")
      .text(">\n<UnstructuredGrid>\n<FieldData>\n");
  describe(buffer, field, true, offset);
  buffer.text("</FieldData>\n<Piece NumberOfPoints=\"").integer(nodes.count());
  buffer.text("\" NumberOfCells=\"").integer(tet_count).text("\">\n<CellData Scalars=\"layer\">\n");
  describe(buffer, cell_data, false, offset);
  buffer.text("</CellData>\n<Points>\n");
  describe(buffer, points, false, offset);
  buffer.text("</Points>\n<Cells>\n");
  describe(buffer, cells, false, offset);
  buffer.text("</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_");
  if (options.compress) {
    for (const std::vector<unsigned char>& bytes : compressed) buffer.bytes(bytes.data(), bytes.size());
  } else {
    for (const std::vector<detail::VtuArray>* arrays : {&field, &cell_data, &points, &cells})
      for (const detail::VtuArray& array : *arrays) {
        buffer.native(array.bytes());
        array.emit([&buffer](const void* data, std::size_t count) { buffer.bytes(data, count); });
      }
  }
  buffer.text("\n</AppendedData>\n</VTKFile>\n");
  buffer.flush();
}

/// Write a mesh as VTU, whole or not at all. Errors: those of the stream version, FileError.
inline void write_vtu(const std::string& path, const Mesh& mesh, const WriteOptions& options = {}) {
  write_file_atomically(path, Stage::Write, [&](std::ostream& out) { write_vtu(out, mesh, options); });
}

}  // namespace slice2mesh
