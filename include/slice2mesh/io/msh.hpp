// SPDX-License-Identifier: MIT
/// @file
/// @brief Gmsh MSH 4.1, text and binary.
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

/// Write a mesh as Gmsh MSH 4.1. One volume entity per slab and region, with exactly one physical group, named
/// "layer_0001_<region>" (layers from 1); their tags are 1, 2, ... by slab, then region. One surface entity per
/// non-empty boundary set, with one physical group: 1 bottom, 2 top, 3 wall, 4 upskin, 5 downskin, 6 support_interface,
/// 7 plate_interface, with `layer_faces` 8 and up covered_0001 and so on (see docs/formats.md); their triangles point
/// out of the material (out of the part). Node i of the mesh has tag i + 1, with quadratic tets the nodes of the edges
/// follow; tet t has tag t + 1, triangles follow. Coordinates round-trip exactly.
/// Options used: binary, quadratic, surfaces, interfaces, layer_faces (deal.II refuses inner faces: set `interfaces` to
/// false for it).
/// Errors: Error (Stage::Write) for a mesh whose arrays do not fit together. The state of the stream tells whether
/// everything was taken. Cost: linear.
inline void write_msh(std::ostream& out, const Mesh& mesh, const WriteOptions& options = {}) {
  detail::check_writable(mesh, options.poll);
  const detail::ElementGroups elements = detail::group_elements(mesh, options.poll);
  const std::vector<std::string> names = detail::region_names(mesh);
  const std::vector<detail::SurfaceSet> surfaces = detail::wanted_surfaces(mesh, options, false);
  const detail::FileNodes nodes(mesh, options);
  std::size_t triangle_count = 0;
  for (const detail::SurfaceSet& set : surfaces) triangle_count += set.faces.size();
  const bool binary = options.binary;
  detail::OutputBuffer buffer(out, options.poll);

  // Numbers of one line (text) or one record (binary): int is 4 bytes, size_t 8.
  const auto put_int = [&](std::int32_t value) {
    if (binary)
      buffer.native(value);
    else
      buffer.integer(value).character(' ');
  };
  const auto put_size = [&](std::size_t value) {
    if (binary)
      buffer.native(std::uint64_t{value});
    else
      buffer.integer(value).character(' ');
  };
  const auto put_real = [&](double value) {
    if (binary)
      buffer.native(value);
    else
      buffer.real(value).character(' ');
  };
  const auto end_line = [&] {
    if (!binary) buffer.character('\n');
  };
  const auto end_section = [&](const char* name) {
    if (binary) buffer.character('\n');
    buffer.text(name).character('\n');
  };

  buffer.text("$MeshFormat\n4.1 ").text(binary ? "1" : "0").text(" 8\n");
  if (binary) buffer.native(std::int32_t{1}).character('\n');
  buffer.text("$EndMeshFormat\n$PhysicalNames\n").integer(surfaces.size() + elements.groups.size()).character('\n');
  for (const detail::SurfaceSet& set : surfaces)
    buffer.text("2 ").integer(set.tag).text(" \"").text(set.name).text("\"\n");
  for (std::size_t g = 0; g < elements.groups.size(); ++g)
    buffer.text("3 ").integer(g + 1).text(" \"").text(detail::group_name(mesh, names, elements.groups[g])).text("\"\n");
  buffer.text("$EndPhysicalNames\n$Entities\n");

  const auto put_entity = [&](std::int32_t tag, const detail::BoundingBox& box) {
    put_int(tag);
    for (const double x : box.low()) put_real(x);
    for (const double x : box.high()) put_real(x);
    put_size(1);  // physical groups
    put_int(tag);
    put_size(0);  // bounding entities
    end_line();
  };
  put_size(0);  // points
  put_size(0);  // curves
  put_size(surfaces.size());
  put_size(elements.groups.size());
  end_line();
  for (const detail::SurfaceSet& set : surfaces) {
    detail::BoundingBox box;
    for (const TetFace& f : set.faces)
      for (const std::int32_t v : face_vertices(mesh, f)) box.add(mesh.vertices[static_cast<std::size_t>(v)]);
    put_entity(set.tag, box);
  }
  for (std::size_t g = 0; g < elements.groups.size(); ++g) {
    detail::BoundingBox box;
    for (std::size_t i = elements.groups[g].begin; i < elements.groups[g].end; ++i)
      for (const std::int32_t v : mesh.tets[elements.order[i]]) box.add(mesh.vertices[static_cast<std::size_t>(v)]);
    put_entity(static_cast<std::int32_t>(g + 1), box);
  }
  end_section("$EndEntities");

  // All nodes are in one block, in the order of the mesh. It belongs to the first volume.
  const std::size_t node_count = nodes.count();
  buffer.text("$Nodes\n");
  const bool with_nodes = node_count > 0 && !elements.groups.empty();
  put_size(with_nodes ? 1 : 0);
  put_size(with_nodes ? node_count : 0);
  put_size(with_nodes ? 1 : 0);
  put_size(with_nodes ? node_count : 0);
  end_line();
  if (with_nodes) {
    put_int(3);
    put_int(1);
    put_int(0);
    put_size(node_count);
    end_line();
    for (std::size_t v = 0; v < node_count; ++v) {
      if (binary)
        buffer.native(std::uint64_t{v + 1});
      else
        buffer.integer(v + 1).character('\n');
    }
    for (std::size_t v = 0; v < node_count; ++v) {
      const std::array<double, 3> p = nodes.position(v);
      if (binary)
        buffer.native(p);
      else
        buffer.real(p[0]).character(' ').real(p[1]).character(' ').real(p[2]).character('\n');
    }
  }
  end_section("$EndNodes");

  buffer.text("$Elements\n");
  const std::size_t element_count = mesh.tets.size() + triangle_count;
  put_size(surfaces.size() + elements.groups.size());
  put_size(element_count);
  put_size(element_count > 0 ? 1 : 0);
  put_size(element_count);
  end_line();
  std::size_t triangle_tag = mesh.tets.size() + 1;
  for (const detail::SurfaceSet& set : surfaces) {
    put_int(2);
    put_int(set.tag);
    put_int(options.quadratic ? 9 : 2);  // triangle of 6 or 3 nodes
    put_size(set.faces.size());
    end_line();
    for (const TetFace& f : set.faces) {
      put_size(triangle_tag++);
      for (std::size_t i = 0; i < nodes.per_face(); ++i) put_size(nodes.of_face(f, i) + 1);
      end_line();
    }
  }
  // The nodes of a quadratic tet are those of kQuadraticEdges, with the last two the other way round.
  constexpr std::array<std::size_t, 10> kOrder = {0, 1, 2, 3, 4, 5, 6, 7, 9, 8};
  for (std::size_t g = 0; g < elements.groups.size(); ++g) {
    const detail::ElementGroup& group = elements.groups[g];
    put_int(3);
    put_int(static_cast<std::int32_t>(g + 1));
    put_int(options.quadratic ? 11 : 4);  // tetrahedron of 10 or 4 nodes
    put_size(group.end - group.begin);
    end_line();
    for (std::size_t i = group.begin; i < group.end; ++i) {
      put_size(elements.order[i] + 1);
      for (std::size_t n = 0; n < nodes.per_tet(); ++n) put_size(nodes.of_tet(elements.order[i], kOrder[n]) + 1);
      end_line();
    }
  }
  end_section("$EndElements");
  buffer.flush();
}

/// Write a mesh as Gmsh MSH 4.1, whole or not at all. Errors: those of the stream version, FileError.
inline void write_msh(const std::string& path, const Mesh& mesh, const WriteOptions& options = {}) {
  write_file_atomically(path, Stage::Write, [&](std::ostream& out) { write_msh(out, mesh, options); });
}

}  // namespace slice2mesh
