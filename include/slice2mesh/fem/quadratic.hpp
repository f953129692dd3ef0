// SPDX-License-Identifier: MIT
/// @file
/// @brief Quadratic tetrahedra: a node in the middle of every edge.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/fem/boundary_sets.hpp"

namespace slice2mesh {

/// 6 by 2: the edges of a tet in the order of VTK, Abaqus and Exodus: indices (0 to 3) of the corners of edge i, which
/// has node 4 + i. Gmsh has the last two the other way round.
inline constexpr std::array<std::array<std::size_t, 2>, 6> kQuadraticEdges = {
    {{{0, 1}}, {{1, 2}}, {{0, 2}}, {{0, 3}}, {{1, 3}}, {{2, 3}}}};

/// What turns a mesh into one of tets of ten nodes: the vertices stay nodes 0 .. #V-1, edge e has node #V + e.
struct QuadraticNodes {
  std::vector<std::array<std::int32_t, 2>> edges;  ///< #E by 2: indices of vertices, the smaller one first; ascending
  std::vector<std::array<std::int32_t, 6>>
      tet_edges;  ///< #T by 6: indices of the edges of every tet, in the order of kQuadraticEdges

  /// Middle of the edge of index `edge`: x, y, z in mm. Edges are straight; the middle of a horizontal one is exactly
  /// at its height. Precondition: the mesh is the one that was numbered, and has such an edge (not checked).
  [[nodiscard]] std::array<double, 3> middle(const Mesh& mesh, std::size_t edge) const {
    const std::array<double, 3>& a = mesh.vertices[static_cast<std::size_t>(edges[edge][0])];
    const std::array<double, 3>& b = mesh.vertices[static_cast<std::size_t>(edges[edge][1])];
    return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
  }
};

/// Number the edges of all tets. Two tets that share an edge share its node, so the quadratic mesh conforms as the mesh
/// does. The numbering does not depend on the order of the tets.
/// Errors: Error (Stage::Fem) if the arrays of the mesh do not fit together, or nodes do not fit into 31 bits.
/// `poll` is called now and then; what it throws ends the work. Cost: linear; 96 bytes per tet while it runs.
[[nodiscard]] inline QuadraticNodes quadratic_nodes(const Mesh& mesh, const std::function<void()>& poll = {}) {
  detail::check_mesh_arrays(mesh, Stage::Fem, poll);
  detail::Poll listen(poll, 1 << 14);
  struct Entry {
    std::int32_t larger;
    std::size_t code;  // 6 * tet + edge
    bool operator<(const Entry& other) const {
      return larger != other.larger ? larger < other.larger : code < other.code;
    }
  };
  const auto ends = [&mesh](std::size_t tet, std::size_t edge) {
    const std::int32_t a = mesh.tets[tet][kQuadraticEdges[edge][0]];
    const std::int32_t b = mesh.tets[tet][kQuadraticEdges[edge][1]];
    return std::array<std::int32_t, 2>{std::min(a, b), std::max(a, b)};
  };
  // Buckets by the smaller vertex; a bucket holds a few edges, whatever the size of the mesh.
  std::vector<std::size_t> begin(mesh.vertices.size() + 1, 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    listen();
    for (std::size_t e = 0; e < 6; ++e) ++begin[static_cast<std::size_t>(ends(t, e)[0]) + 1];
  }
  for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
  std::vector<Entry> entries(6 * mesh.tets.size());
  {
    std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      listen();
      for (std::size_t e = 0; e < 6; ++e) {
        const std::array<std::int32_t, 2> v = ends(t, e);
        entries[next[static_cast<std::size_t>(v[0])]++] = {v[1], 6 * t + e};
      }
    }
  }
  QuadraticNodes nodes;
  nodes.tet_edges.resize(mesh.tets.size());
  for (std::size_t v = 0; v + 1 < begin.size(); ++v) {
    const auto first = entries.begin() + static_cast<std::ptrdiff_t>(begin[v]);
    const auto last = entries.begin() + static_cast<std::ptrdiff_t>(begin[v + 1]);
    detail::sort_listening(first, last, listen);
    for (auto i = first; i != last; ++i) {
      if (i == first || i->larger != (i - 1)->larger) nodes.edges.push_back({static_cast<std::int32_t>(v), i->larger});
      nodes.tet_edges[i->code / 6][i->code % 6] = static_cast<std::int32_t>(nodes.edges.size()) - 1;
    }
    if (mesh.vertices.size() + nodes.edges.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
      throw Error(Stage::Fem, "the nodes of the quadratic mesh do not fit into 31 bits");
  }
  return nodes;
}

namespace detail {

/// Which edge of kQuadraticEdges joins two corners.
[[nodiscard]] inline std::size_t quadratic_edge(std::size_t a, std::size_t b) {
  for (std::size_t e = 0; e < kQuadraticEdges.size(); ++e)
    if ((kQuadraticEdges[e][0] == a && kQuadraticEdges[e][1] == b) ||
        (kQuadraticEdges[e][0] == b && kQuadraticEdges[e][1] == a))
      return e;
  return kQuadraticEdges.size();
}

}  // namespace detail

}  // namespace slice2mesh
