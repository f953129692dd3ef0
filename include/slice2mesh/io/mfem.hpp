// SPDX-License-Identifier: MIT
/// @file
/// @brief MFEM mesh v1.0 and v1.3.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <ostream>
#include <string>
#include <vector>

#include "slice2mesh/core/atomic_file.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/io/element_groups.hpp"
#include "slice2mesh/io/output_buffer.hpp"
#include "slice2mesh/io/write_options.hpp"

namespace slice2mesh {

/// Write a mesh in the format of MFEM, v1.0, or v1.3 with `mfem_names`. The attribute of a tet is the index of its
/// region times #S plus the index of its slab plus one, so that a mesh of one region has attribute = layer + 1;
/// boundary attributes are 1 bottom, 2 top, 3 wall, 4 upskin, 5 downskin, 6 support_interface, 7 plate_interface, with
/// `layer_faces` 7 + k for the faces that layer k covers. v1.3 names them, and has a set of attributes per layer
/// ("layer_0001"), per region and per layer and region. Coordinates round-trip exactly.
/// Options used: mfem_names, surfaces, interfaces, layer_faces.
/// Errors: Error (Stage::Write) for a mesh whose arrays do not fit together. The state of the stream tells whether
/// everything was taken. Cost: linear.
inline void write_mfem(std::ostream& out, const Mesh& mesh, const WriteOptions& options = {}) {
  detail::check_writable(mesh, options.poll);
  const std::size_t slab_count = mesh.slabs.size();
  if (slab_count * mesh.regions.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
    throw Error(Stage::Write, "more pairs of slab and region than attributes");
  const std::vector<detail::SurfaceSet> surfaces = detail::wanted_surfaces(mesh, options, false);
  const auto attribute = [slab_count](std::int32_t slab, std::int32_t region) {
    return static_cast<std::size_t>(region) * slab_count + static_cast<std::size_t>(slab) + 1;
  };
  detail::OutputBuffer buffer(out, options.poll);
  buffer.text(options.mfem_names ? "MFEM mesh v1.3\n" : "MFEM mesh v1.0\n");
  buffer.text("\ndimension\n3\n\nelements\n").integer(mesh.tets.size()).character('\n');
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    buffer.integer(attribute(mesh.tet_slab[t], mesh.tet_region[t])).text(" 4");
    for (const std::int32_t v : mesh.tets[t]) buffer.character(' ').integer(v);
    buffer.character('\n');
  }
  if (options.mfem_names) {
    const std::vector<std::string> names = detail::region_names(mesh);
    const std::vector<detail::ElementGroup> groups = detail::group_elements(mesh, options.poll).groups;
    std::vector<std::vector<std::size_t>> by_slab(slab_count);
    std::vector<std::vector<std::size_t>> by_region(names.size());
    std::size_t set_count = groups.size();
    for (const detail::ElementGroup& g : groups) {
      by_slab[static_cast<std::size_t>(g.slab)].push_back(attribute(g.slab, g.region));
      by_region[static_cast<std::size_t>(g.region)].push_back(attribute(g.slab, g.region));
    }
    for (const auto* lists : {&by_slab, &by_region})
      for (const std::vector<std::size_t>& list : *lists)
        if (!list.empty()) ++set_count;
    buffer.text("\nattribute_sets\n").integer(set_count).character('\n');
    const auto put_set = [&buffer](const std::string& name, const std::vector<std::size_t>& attributes) {
      if (attributes.empty()) return;
      buffer.text("\"").text(name).text("\" ").integer(attributes.size());
      for (const std::size_t a : attributes) buffer.character(' ').integer(a);
      buffer.character('\n');
    };
    for (std::size_t s = 0; s < slab_count; ++s) put_set("layer_" + detail::padded(s + 1, slab_count), by_slab[s]);
    for (std::size_t r = 0; r < names.size(); ++r) put_set("region_" + names[r], by_region[r]);
    for (const detail::ElementGroup& g : groups)
      put_set(detail::group_name(mesh, names, g), {attribute(g.slab, g.region)});
  }
  std::size_t triangle_count = 0;
  for (const detail::SurfaceSet& set : surfaces) triangle_count += set.faces.size();
  buffer.text("\nboundary\n").integer(triangle_count).character('\n');
  for (const detail::SurfaceSet& set : surfaces)
    for (const TetFace& f : set.faces) {
      buffer.integer(set.tag).text(" 2");
      for (const std::int32_t v : face_vertices(mesh, f)) buffer.character(' ').integer(v);
      buffer.character('\n');
    }
  if (options.mfem_names) {
    buffer.text("\nbdr_attribute_sets\n").integer(surfaces.size()).character('\n');
    for (const detail::SurfaceSet& set : surfaces)
      buffer.text("\"").text(set.name).text("\" 1 ").integer(set.tag).character('\n');
  }
  buffer.text("\nvertices\n").integer(mesh.vertices.size()).text("\n3\n");
  for (const std::array<double, 3>& p : mesh.vertices)
    buffer.real(p[0]).character(' ').real(p[1]).character(' ').real(p[2]).character('\n');
  if (options.mfem_names) buffer.text("\nmfem_mesh_end\n");
  buffer.flush();
}

/// Write a mesh in the format of MFEM, whole or not at all. Errors: those of the stream version, FileError.
inline void write_mfem(const std::string& path, const Mesh& mesh, const WriteOptions& options = {}) {
  write_file_atomically(path, Stage::Write, [&](std::ostream& out) { write_mfem(out, mesh, options); });
}

}  // namespace slice2mesh
