// SPDX-License-Identifier: MIT
/// @file
/// @brief Files of TetGen: .node and .ele of a mesh, .poly of a PLC.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numeric>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/core/atomic_file.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/io/element_groups.hpp"
#include "slice2mesh/io/output_buffer.hpp"
#include "slice2mesh/io/plc_files.hpp"
#include "slice2mesh/io/write_options.hpp"

namespace slice2mesh {

/// Write the vertices of a mesh as .node, counted from 0. Coordinates round-trip exactly. Cost: linear.
/// Errors: Error (Stage::Write) for a mesh whose arrays do not fit together.
inline void write_tetgen_nodes(std::ostream& out, const Mesh& mesh, const WriteOptions& options = {}) {
  detail::check_writable(mesh, options.poll);
  detail::OutputBuffer buffer(out, options.poll);
  buffer.integer(mesh.vertices.size()).text(" 3 0 0\n");
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    buffer.integer(v);
    for (const double x : mesh.vertices[v]) buffer.character(' ').real(x);
    buffer.character('\n');
  }
  buffer.flush();
}

/// Write the tets of a mesh as .ele, counted from 0, with one attribute: the index of the slab plus one. Cost: linear.
/// Errors: Error (Stage::Write) for a mesh whose arrays do not fit together.
inline void write_tetgen_elements(std::ostream& out, const Mesh& mesh, const WriteOptions& options = {}) {
  detail::check_writable(mesh, options.poll);
  detail::OutputBuffer buffer(out, options.poll);
  buffer.integer(mesh.tets.size()).text(" 4 1\n");
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const std::array<std::int32_t, 4>& tet = mesh.tets[t];
    buffer.integer(t);
    for (const std::int32_t v : tet) buffer.character(' ').integer(v);
    buffer.character(' ').integer(mesh.tet_slab[t] + 1).character('\n');
  }
  buffer.flush();
}

/// Write a mesh as `<stem>.node` and `<stem>.ele`; `path` names either of them. Both are complete before the first
/// takes its place. Errors: those of `write_tetgen_nodes` and `write_tetgen_elements`; FileError (also for
/// another extension).
inline void write_tetgen(const std::string& path, const Mesh& mesh, const WriteOptions& options = {}) {
  const std::string extension = detail::extension(path);
  if (extension != "node" && extension != "ele") throw FileError(Stage::Write, path, "must end in .node or .ele");
  const std::string stem = path.substr(0, path.size() - extension.size());
  AtomicFile nodes(stem + "node", Stage::Write);
  AtomicFile elements(stem + "ele", Stage::Write);
  write_tetgen_nodes(nodes.stream(), mesh, options);
  write_tetgen_elements(elements.stream(), mesh, options);
  nodes.commit();
  elements.commit();
}

namespace detail {

/// Disjoint sets.
class Components {
public:
  explicit Components(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  [[nodiscard]] std::size_t find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t i, std::size_t j) { parent_[find(i)] = find(j); }

private:
  std::vector<std::size_t> parent_;
};

/// A side of a triangle: its vertices in ascending order, and the place of the triangle in the list it comes from.
struct TriangleSide {
  std::int32_t a;
  std::int32_t b;
  std::size_t triangle;
  friend bool operator<(const TriangleSide& s, const TriangleSide& t) {
    if (s.a != t.a) return s.a < t.a;
    return s.b != t.b ? s.b < t.b : s.triangle < t.triangle;
  }
};

/// Calls `visit(first, last)` for the triangles around every edge: a range of TriangleSide.
template <class Visit>
void for_each_edge(const Plc& plc, const std::vector<std::size_t>& facets, Poll& listen, Visit visit) {
  std::vector<TriangleSide> sides;
  sides.reserve(3 * facets.size());
  for (std::size_t i = 0; i < facets.size(); ++i) {
    listen();
    const std::array<std::int32_t, 3>& v = plc.facets[facets[i]].vertices;
    for (std::size_t k = 0; k < 3; ++k)
      sides.push_back({std::min(v[k], v[(k + 1) % 3]), std::max(v[k], v[(k + 1) % 3]), i});
  }
  sort_listening(sides.begin(), sides.end(), listen);
  for (auto first = sides.begin(); first != sides.end();) {
    listen();
    auto last = first + 1;
    while (last != sides.end() && last->a == first->a && last->b == first->b) ++last;
    visit(first, last);
    first = last;
  }
}

/// The point over the middle of a horizontal facet, half way up to the next plane.
[[nodiscard]] inline std::array<double, 3> point_above(const Plc& plc, const Facet& facet) {
  std::array<double, 3> point{};
  for (const std::int32_t v : facet.vertices) {
    const std::array<double, 3> p = plc.position(static_cast<std::size_t>(v));
    point[0] += p[0] / 3;
    point[1] += p[1] / 3;
  }
  const auto plane = static_cast<std::size_t>(plc.vertex_plane[static_cast<std::size_t>(facet.vertices[0])]);
  point[2] = plc.planes[plane] + (plc.planes[plane + 1] - plc.planes[plane]) / 2;
  return point;
}

/// One point in every closed void. What stands over an up-facing facet is void up to the next plane, so the points are
/// taken there, one per component of the skin that is oriented inward. Components that touch themselves or others along
/// an edge get a point as well, whatever their orientation; in the open it does no harm.
[[nodiscard]] inline std::vector<std::array<double, 3>> void_points(const Plc& plc,
                                                                    const std::function<void()>& poll = {}) {
  Poll listen(poll, 1 << 16);
  std::vector<std::size_t> skin;
  for (std::size_t f = 0; f < plc.facets.size(); ++f)
    if (plc.facets[f].front.empty() || plc.facets[f].back.empty()) skin.push_back(f);
  Components components(skin.size());
  std::vector<bool> touches(skin.size(), false);
  for_each_edge(plc, skin, listen, [&](auto first, auto last) {
    if (last - first == 2)
      components.join(first->triangle, (first + 1)->triangle);
    else
      for (auto side = first; side != last; ++side) touches[side->triangle] = true;
  });
  struct Shell {
    double volume = 0;
    std::size_t up = 0;  // an up-facing facet of the component, plus one
    bool touches = false;
  };
  std::vector<Shell> shells(skin.size());
  for (std::size_t i = 0; i < skin.size(); ++i) {
    listen();
    const Facet& facet = plc.facets[skin[i]];
    Shell& shell = shells[components.find(i)];
    // Horizontal facets alone give the volume: height times area seen from above, down-facing negative.
    if (facet.label == FacetLabel::Up || facet.label == FacetLabel::Down) {
      const std::array<double, 3> a = plc.position(static_cast<std::size_t>(facet.vertices[0]));
      const std::array<double, 3> b = plc.position(static_cast<std::size_t>(facet.vertices[1]));
      const std::array<double, 3> c = plc.position(static_cast<std::size_t>(facet.vertices[2]));
      const double area = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
      shell.volume += area * (a[2] - plc.planes.front());
    }
    const auto plane = static_cast<std::size_t>(plc.vertex_plane[static_cast<std::size_t>(facet.vertices[0])]);
    if (facet.label == FacetLabel::Up && plane + 1 < plc.planes.size() && shell.up == 0) shell.up = skin[i] + 1;
    shell.touches = shell.touches || touches[i];
  }
  std::vector<std::array<double, 3>> points;
  for (const Shell& shell : shells)
    if (shell.up > 0 && (shell.volume < 0 || shell.touches))
      points.push_back(point_above(plc, plc.facets[shell.up - 1]));
  return points;
}

/// One point in every connected piece of every slab and region, with the slab: taken above its floor.
[[nodiscard]] inline std::vector<std::pair<std::array<double, 3>, std::int32_t>> cell_points(
    const Plc& plc, const std::function<void()>& poll = {}) {
  Poll listen(poll, 1 << 16);
  const auto cell_above = [](const Facet& facet) {
    if (facet.label == FacetLabel::Interface) return facet.front;
    return facet.label == FacetLabel::Down ? facet.back : Side{};
  };
  std::vector<std::size_t> floors;
  for (std::size_t f = 0; f < plc.facets.size(); ++f)
    if (!cell_above(plc.facets[f]).empty()) floors.push_back(f);
  Components components(floors.size());
  for_each_edge(plc, floors, listen, [&](auto first, auto last) {
    for (auto i = first; i != last; ++i)
      for (auto j = i + 1; j != last; ++j)
        if (cell_above(plc.facets[floors[i->triangle]]) == cell_above(plc.facets[floors[j->triangle]]))
          components.join(i->triangle, j->triangle);
  });
  std::vector<std::pair<std::array<double, 3>, std::int32_t>> points;
  for (std::size_t i = 0; i < floors.size(); ++i) {
    if (components.find(i) != i) continue;
    const Facet& facet = plc.facets[floors[i]];
    points.emplace_back(point_above(plc, facet), cell_above(facet).slab);
  }
  return points;
}

}  // namespace detail

/// Write a PLC as .poly: vertices counted from 0, one triangle per facet with its label plus one as boundary marker, a
/// hole point in every closed void, and, with inner faces, a region point with the attribute slab + 1 in every
/// connected piece of every slab and region. Coordinates round-trip exactly. Errors: Error (Stage::Write) if the arrays
/// do not fit together. Cost: n log n.
inline void write_poly(std::ostream& out, const Plc& plc, const PlcWriteOptions& options = {}) {
  const detail::PlcSelection selection = detail::select_facets(plc, options);
  detail::OutputBuffer buffer(out, options.poll);
  buffer.integer(selection.points.size()).text(" 3 0 0\n");
  for (std::size_t v = 0; v < selection.points.size(); ++v) {
    buffer.integer(v);
    for (const double x : selection.points[v]) buffer.character(' ').real(x);
    buffer.character('\n');
  }
  buffer.integer(selection.faces.size()).text(" 1\n");
  for (std::size_t i = 0; i < selection.faces.size(); ++i) {
    buffer.text("1 0 ").integer(static_cast<int>(plc.facets[selection.facets[i]].label) + 1).text("\n3");
    for (const std::int32_t v : selection.faces[i]) buffer.character(' ').integer(v);
    buffer.character('\n');
  }
  const auto put_point = [&buffer](std::size_t number, const std::array<double, 3>& p) {
    buffer.integer(number);
    for (const double x : p) buffer.character(' ').real(x);
  };
  const std::vector<std::array<double, 3>> holes = detail::void_points(plc, options.poll);
  buffer.integer(holes.size()).character('\n');
  for (std::size_t i = 0; i < holes.size(); ++i) {
    put_point(i, holes[i]);
    buffer.character('\n');
  }
  if (options.inner_faces) {
    const auto cells = detail::cell_points(plc, options.poll);
    buffer.integer(cells.size()).character('\n');
    for (std::size_t i = 0; i < cells.size(); ++i) {
      put_point(i, cells[i].first);
      buffer.character(' ').integer(cells[i].second + 1).text(" -1\n");
    }
  } else {
    buffer.text("0\n");
  }
  buffer.flush();
}

}  // namespace slice2mesh
