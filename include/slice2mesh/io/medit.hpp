// SPDX-License-Identifier: MIT
/// @file
/// @brief MEDIT .mesh: FreeFEM, MMG.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "slice2mesh/core/atomic_file.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/io/element_groups.hpp"
#include "slice2mesh/io/output_buffer.hpp"
#include "slice2mesh/io/write_options.hpp"

namespace slice2mesh {

/// Write a mesh as MEDIT text (double precision). The reference of a tet is the index of its slab plus one; that of a
/// triangle its boundary set plus one (1 bottom, 2 top, 3 wall, 4 upskin, 5 downskin, 6 support_interface,
/// 7 plate_interface, with `layer_faces` 7 + k for the faces that layer k covers). The format has one number per
/// element: regions are not in the file. Coordinates round-trip exactly.
/// Options used: surfaces, interfaces, layer_faces.
/// Errors: Error (Stage::Write) for a mesh whose arrays do not fit together. The state of the stream tells whether
/// everything was taken. Cost: linear.
inline void write_medit(std::ostream& out, const Mesh& mesh, const WriteOptions& options = {}) {
  detail::check_writable(mesh, options.poll);
  const std::vector<detail::SurfaceSet> surfaces = detail::wanted_surfaces(mesh, options, false);
  std::size_t triangle_count = 0;
  for (const detail::SurfaceSet& set : surfaces) triangle_count += set.faces.size();
  detail::OutputBuffer buffer(out, options.poll);
  buffer.text("MeshVersionFormatted 2\n\nDimension 3\n\nVertices\n").integer(mesh.vertices.size()).character('\n');
  for (const std::array<double, 3>& p : mesh.vertices)
    buffer.real(p[0]).character(' ').real(p[1]).character(' ').real(p[2]).text(" 0\n");
  if (triangle_count > 0) {
    buffer.text("\nTriangles\n").integer(triangle_count).character('\n');
    for (const detail::SurfaceSet& set : surfaces)
      for (const TetFace& f : set.faces) {
        for (const std::int32_t v : face_vertices(mesh, f)) buffer.integer(v + 1).character(' ');
        buffer.integer(set.tag).character('\n');
      }
  }
  buffer.text("\nTetrahedra\n").integer(mesh.tets.size()).character('\n');
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (const std::int32_t v : mesh.tets[t]) buffer.integer(v + 1).character(' ');
    buffer.integer(mesh.tet_slab[t] + 1).character('\n');
  }
  buffer.text("\nEnd\n");
  buffer.flush();
}

/// Write a mesh as MEDIT text, whole or not at all. Errors: those of the stream version, FileError.
inline void write_medit(const std::string& path, const Mesh& mesh, const WriteOptions& options = {}) {
  write_file_atomically(path, Stage::Write, [&](std::ostream& out) { write_medit(out, mesh, options); });
}

}  // namespace slice2mesh
