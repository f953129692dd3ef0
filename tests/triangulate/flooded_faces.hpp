// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "slice2mesh/arrange/faces.hpp"
#include "slice2mesh/triangulate/planar.hpp"

namespace slice2mesh_test {

using namespace slice2mesh;

/// A triangulation of the convex hull of an arrangement's vertices that holds all of its edges. Indices only.
struct PlanarTriangulation {
  std::vector<std::array<std::int32_t, 3>> triangles;  ///< #T by 3: indices of vertices, counter-clockwise
  std::vector<std::array<std::int32_t, 3>>
      neighbors;  ///< #T by 3: indices of triangles, across the edge opposite to a vertex; kNone outside
  std::vector<std::array<std::int32_t, 3>>
      edges;  ///< #T by 3: index of the arrangement's edge opposite to a vertex, or kNone
};

/// The constrained Delaunay triangulation of an arrangement. Empty if all vertices lie on one line.
/// Throws where edges cross or a vertex lies on an edge.
[[nodiscard]] inline PlanarTriangulation triangulate(const Arrangement& arrangement) {
  using detail::Cdt;
  PlanarTriangulation result;
  Cdt cdt;
  const std::vector<Cdt::Vertex_handle> handles = detail::insert_points(cdt, arrangement.vertices);
  for (const Arrangement::Edge& e : arrangement.edges) {
    detail::insert_edge(cdt, handles[static_cast<std::size_t>(e.a)], handles[static_cast<std::size_t>(e.b)],
                        Stage::Triangulate);
  }
  if (cdt.dimension() < 2) return result;
  std::int32_t count = 0;
  for (const Cdt::Face_handle f : cdt.all_face_handles()) f->info() = cdt.is_infinite(f) ? kNone : count++;
  result.triangles.resize(static_cast<std::size_t>(count));
  result.neighbors.resize(static_cast<std::size_t>(count));
  result.edges.assign(static_cast<std::size_t>(count), {kNone, kNone, kNone});
  for (const Cdt::Face_handle f : cdt.finite_face_handles()) {
    const auto t = static_cast<std::size_t>(f->info());
    for (int i = 0; i < 3; ++i) {
      result.triangles[t][static_cast<std::size_t>(i)] = f->vertex(i)->info();
      result.neighbors[t][static_cast<std::size_t>(i)] = f->neighbor(i)->info();
    }
  }
  for (std::size_t e = 0; e < arrangement.edges.size(); ++e) {
    Cdt::Face_handle f;
    int i = 0;
    const auto a = handles[static_cast<std::size_t>(arrangement.edges[e].a)];
    const auto b = handles[static_cast<std::size_t>(arrangement.edges[e].b)];
    if (!cdt.is_edge(a, b, f, i))
      throw GeometryError(Stage::Triangulate, -1, -1,
                          "a vertex lies on an edge of an arrangement; this is a defect of slice2mesh");
    const Cdt::Face_handle g = f->neighbor(i);
    if (!cdt.is_infinite(f)) result.edges[static_cast<std::size_t>(f->info())][static_cast<std::size_t>(i)] = int(e);
    if (!cdt.is_infinite(g))
      result.edges[static_cast<std::size_t>(g->info())][static_cast<std::size_t>(cdt.mirror_index(f, i))] = int(e);
  }
  return result;
}

/// Faces and winding numbers in another way than `find_faces`: by flooding a triangulation from outside.
[[nodiscard]] inline ArrangementFaces flooded_faces(const Arrangement& arrangement) {
  const PlanarTriangulation triangulation = triangulate(arrangement);
  ArrangementFaces faces;
  std::vector<std::int32_t> of_triangle;  // face
  const std::size_t count = triangulation.triangles.size();
  of_triangle.assign(count, kNone);
  faces.of_edge.assign(arrangement.edges.size(), {0, 0});
  std::int32_t face_count = 1;
  std::vector<std::int32_t> stack;
  // Triangles that reach the outside of the hull without crossing an edge belong to face 0.
  const auto flood = [&](std::int32_t face) {
    while (!stack.empty()) {
      const auto t = static_cast<std::size_t>(stack.back());
      stack.pop_back();
      for (std::size_t i = 0; i < 3; ++i) {
        const std::int32_t n = triangulation.neighbors[t][i];
        if (n == kNone || triangulation.edges[t][i] != kNone || of_triangle[static_cast<std::size_t>(n)] != kNone)
          continue;
        of_triangle[static_cast<std::size_t>(n)] = face;
        stack.push_back(n);
      }
    }
  };
  for (std::size_t t = 0; t < count; ++t)
    for (std::size_t i = 0; i < 3; ++i)
      if (of_triangle[t] == kNone && triangulation.neighbors[t][i] == kNone && triangulation.edges[t][i] == kNone) {
        of_triangle[t] = 0;
        stack.push_back(static_cast<std::int32_t>(t));
      }
  flood(0);
  for (std::size_t t = 0; t < count; ++t) {
    if (of_triangle[t] != kNone) continue;
    of_triangle[t] = face_count;
    stack.push_back(static_cast<std::int32_t>(t));
    flood(face_count++);
  }
  for (std::size_t t = 0; t < count; ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int32_t e = triangulation.edges[t][i];
      if (e == kNone) continue;
      const std::int32_t from = triangulation.triangles[t][(i + 1) % 3];
      const std::size_t side = arrangement.edges[static_cast<std::size_t>(e)].a == from ? 0 : 1;
      faces.of_edge[static_cast<std::size_t>(e)][side] = of_triangle[t];
    }
  }
  detail::find_windings(arrangement, static_cast<std::size_t>(face_count), faces, {});
  return faces;
}

}  // namespace slice2mesh_test
