// SPDX-License-Identifier: MIT
/// @file
/// @brief Files of the PLC: OFF, OBJ, PLY, STL.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "slice2mesh/core/atomic_file.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/fem/boundary_sets.hpp"
#include "slice2mesh/io/output_buffer.hpp"
#include "slice2mesh/io/write_options.hpp"

namespace slice2mesh {

namespace detail {

/// The facets and vertices that go into a file.
struct PlcSelection {
  std::vector<std::size_t> facets;                 ///< indices into plc.facets
  std::vector<std::array<double, 3>> points;       ///< #P by 3, mm
  std::vector<std::array<std::int32_t, 3>> faces;  ///< facets by 3, indices into points
};

/// Throws Error (Stage::Write) if the arrays of the complex do not fit together.
[[nodiscard]] inline PlcSelection select_facets(const Plc& plc, const PlcWriteOptions& options) {
  if (plc.vertex_plane.size() != plc.vertices.size())
    throw Error(Stage::Write, "vertex_plane must be as long as vertices");
  for (std::size_t v = 0; v < plc.vertices.size(); ++v)
    if (plc.vertex_plane[v] < 0 || static_cast<std::size_t>(plc.vertex_plane[v]) >= plc.planes.size())
      throw Error(Stage::Write, "vertex " + std::to_string(v) + " names a plane that does not exist");
  PlcSelection selection;
  Poll listen(options.poll, 1 << 16);
  std::vector<std::int32_t> number(plc.vertices.size(), options.inner_faces ? 0 : kNone);
  for (std::size_t f = 0; f < plc.facets.size(); ++f) {
    listen();
    const Facet& facet = plc.facets[f];
    for (const std::int32_t v : facet.vertices)
      if (v < 0 || static_cast<std::size_t>(v) >= plc.vertices.size())
        throw Error(Stage::Write, "facet " + std::to_string(f) + " names a vertex that does not exist");
    if (!options.inner_faces && !facet.front.empty() && !facet.back.empty()) continue;
    selection.facets.push_back(f);
    for (const std::int32_t v : facet.vertices) number[static_cast<std::size_t>(v)] = 0;
  }
  for (std::size_t v = 0; v < plc.vertices.size(); ++v)
    if (number[v] != kNone) {
      number[v] = static_cast<std::int32_t>(selection.points.size());
      selection.points.push_back(plc.position(v));
    }
  selection.faces.reserve(selection.facets.size());
  for (const std::size_t f : selection.facets) {
    listen();
    const std::array<std::int32_t, 3>& v = plc.facets[f].vertices;
    selection.faces.push_back({number[static_cast<std::size_t>(v[0])], number[static_cast<std::size_t>(v[1])],
                               number[static_cast<std::size_t>(v[2])]});
  }
  return selection;
}

}  // namespace detail

/// Write a PLC as OFF. Triangles keep their orientation; with all inner faces vertex i of the file is vertex i of the
/// complex. Coordinates round-trip exactly.
/// Errors: Error (Stage::Write) if the arrays do not fit together. The state of the stream tells whether everything was
/// taken. Cost: linear. The same holds for the other formats.
inline void write_off(std::ostream& out, const Plc& plc, const PlcWriteOptions& options = {}) {
  const detail::PlcSelection selection = detail::select_facets(plc, options);
  detail::OutputBuffer buffer(out, options.poll);
  buffer.text("OFF\n").integer(selection.points.size()).character(' ').integer(selection.faces.size()).text(" 0\n");
  for (const std::array<double, 3>& p : selection.points)
    buffer.real(p[0]).character(' ').real(p[1]).character(' ').real(p[2]).character('\n');
  for (const std::array<std::int32_t, 3>& f : selection.faces)
    buffer.text("3 ").integer(f[0]).character(' ').integer(f[1]).character(' ').integer(f[2]).character('\n');
  buffer.flush();
}

/// Write a PLC as OBJ, one group ("g down", "g up", ...) per label. Otherwise as `write_off`.
inline void write_obj(std::ostream& out, const Plc& plc, const PlcWriteOptions& options = {}) {
  const detail::PlcSelection selection = detail::select_facets(plc, options);
  detail::OutputBuffer buffer(out, options.poll);
  for (const std::array<double, 3>& p : selection.points)
    buffer.text("v ").real(p[0]).character(' ').real(p[1]).character(' ').real(p[2]).character('\n');
  for (const FacetLabel label :
       {FacetLabel::Down, FacetLabel::Up, FacetLabel::Interface, FacetLabel::Wall, FacetLabel::InnerWall}) {
    bool first = true;
    for (std::size_t i = 0; i < selection.faces.size(); ++i) {
      if (plc.facets[selection.facets[i]].label != label) continue;
      if (first) buffer.text("g ").text(to_string(label)).character('\n');
      first = false;
      const std::array<std::int32_t, 3>& f = selection.faces[i];
      buffer.text("f ").integer(f[0] + 1).character(' ').integer(f[1] + 1).character(' ').integer(f[2] + 1);
      buffer.character('\n');
    }
  }
  buffer.flush();
}

/// Write a PLC as PLY, binary, little endian. Vertex properties: double x, y, z. Face properties: list uchar int
/// vertex_indices, uchar label (FacetLabel), int slab_front, region_front, slab_back, region_back (-1: no material).
/// Otherwise as `write_off`.
inline void write_ply(std::ostream& out, const Plc& plc, const PlcWriteOptions& options = {}) {
  const detail::PlcSelection selection = detail::select_facets(plc, options);
  detail::OutputBuffer buffer(out, options.poll);
  buffer.text("ply\nformat binary_little_endian 1.0\ncomment label: 0 down, 1 up, 2 interface, 3 wall, 4 inner_wall\n");
  buffer.text("element vertex ").integer(selection.points.size());
  buffer.text("\nproperty double x\nproperty double y\nproperty double z\nelement face ")
      .integer(selection.faces.size());
  buffer.text(
      "\nproperty list uchar int vertex_indices\nproperty uchar label\nproperty int slab_front\nproperty int "
      "region_front\nproperty int slab_back\nproperty int region_back\nend_header\n");
  for (const std::array<double, 3>& p : selection.points)
    for (const double x : p) buffer.little_endian(x);
  for (std::size_t i = 0; i < selection.faces.size(); ++i) {
    const Facet& facet = plc.facets[selection.facets[i]];
    buffer.little_endian(std::uint8_t{3});
    for (const std::int32_t v : selection.faces[i]) buffer.little_endian(v);
    buffer.little_endian(static_cast<std::uint8_t>(facet.label));
    for (const Side& side : {facet.front, facet.back}) buffer.little_endian(side.slab).little_endian(side.region);
  }
  buffer.flush();
}

/// Write a PLC as binary STL. The format has single precision only: coordinates are rounded. Otherwise as `write_off`.
inline void write_stl(std::ostream& out, const Plc& plc, const PlcWriteOptions& options = {}) {
  const detail::PlcSelection selection = detail::select_facets(plc, options);
  if (selection.faces.size() > 0xffffffffU) throw Error(Stage::Write, "more triangles than STL can count");
  detail::OutputBuffer buffer(out, options.poll);
  std::array<char, 80> header{};  // must not begin with "solid"
  const std::string title = "slice2mesh, millimetres";
  std::copy(title.begin(), title.end(), header.begin());
  buffer.bytes(header.data(), header.size());
  buffer.little_endian(static_cast<std::uint32_t>(selection.faces.size()));
  for (const std::array<std::int32_t, 3>& f : selection.faces) {
    const std::array<double, 3>& a = selection.points[static_cast<std::size_t>(f[0])];
    const std::array<double, 3>& b = selection.points[static_cast<std::size_t>(f[1])];
    const std::array<double, 3>& c = selection.points[static_cast<std::size_t>(f[2])];
    const std::array<double, 3> n = detail::cross(detail::difference(b, a), detail::difference(c, a));
    const double length = std::sqrt(detail::dot(n, n));
    for (const double x : n) buffer.little_endian(static_cast<float>(length > 0 ? x / length : 0));
    for (const std::array<double, 3>* p : {&a, &b, &c})
      for (const double x : *p) buffer.little_endian(static_cast<float>(x));
    buffer.little_endian(std::uint16_t{0});
  }
  buffer.flush();
}

}  // namespace slice2mesh
