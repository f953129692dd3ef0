// SPDX-License-Identifier: MIT
/// @file
/// @brief From plane triangulations to the piecewise linear complex.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/harmonize/harmonize.hpp"
#include "slice2mesh/lift/lift.hpp"
#include "slice2mesh/triangulate/plane_mesh.hpp"

namespace slice2mesh {

namespace detail {

/// Calls triangle(a, b, c) with bottom (lower = true) or top vertices for the strip between two chains that run the
/// same way: lower(i, i + 1, j) for a bottom edge and the top vertex nearest to its middle, upper(j, j + 1, i) the
/// other way round. A tie goes to the lexicographically larger top vertex: the rule of the slab filler.
template <class Lower, class Upper>
void for_each_strip_triangle(const std::vector<GridPoint>& bottom, const std::vector<GridPoint>& top, Lower&& lower,
                             Upper&& upper) {
  std::size_t i = 0, j = 0;
  while (i + 1 < bottom.size() || j + 1 < top.size()) {
    bool advance_bottom = j + 1 == top.size();
    if (!advance_bottom && i + 1 < bottom.size()) {
      int next = nearer_to_midpoint(bottom[i], bottom[i + 1], top[j], top[j + 1]);
      if (next == 0) next = top[j] < top[j + 1] ? 1 : -1;
      advance_bottom = next < 0;
    }
    if (advance_bottom) {
      lower(i, i + 1, j);
      ++i;
    } else {
      upper(j, j + 1, i);
      ++j;
    }
  }
}

}  // namespace detail

/// Assembles the complex: horizontal facets from the triangulations, vertical ones over the contour edges, each the
/// strip between the edge's splits at its bottom and at its top. With `inner_faces` false only the outer skin is built.
///
/// `meshes`: #P, those of the planes of `plane_slabs`, in that order; `slab_planes`: #S by 2, indices of the bottom and
/// the top plane of each slab; `only`: #S, 1 for the slabs whose facets are wanted, or empty for all of them; `poll` is
/// called now and then. Precondition: all of them are made from `contours` (not checked: `verify_plc` tells what a
/// complex is worth). Errors: what `poll` throws. Cost: linear.
[[nodiscard]] inline Plc build_plc(const Contours& contours, const std::vector<PlaneMesh>& meshes,
                                   const std::vector<std::array<std::int32_t, 2>>& slab_planes, bool inner_faces = true,
                                   const std::vector<char>& only = {}, const std::function<void()>& poll = {}) {
  Plc plc;
  detail::Poll listen(poll, 1 << 16);
  plc.grid = contours.grid;
  plc.slabs = contours.slabs;
  plc.regions = contours.regions;
  plc.slab_planes = slab_planes;
  plc.has_inner_faces = inner_faces;
  std::vector<std::int32_t> first;
  for (const PlaneMesh& mesh : meshes) {
    first.push_back(static_cast<std::int32_t>(plc.vertices.size()));
    plc.vertices.insert(plc.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    plc.vertex_plane.resize(plc.vertices.size(), static_cast<std::int32_t>(plc.planes.size()));
    plc.planes.push_back(mesh.z);
  }
  const auto wanted = [&](std::int32_t slab) {
    return slab != kNone && (only.empty() || only[static_cast<std::size_t>(slab)]);
  };
  if (only.empty()) {
    std::size_t facets = 0;  // at most
    for (const PlaneMesh& mesh : meshes) {
      facets += mesh.triangles.size();
      for (const auto* chains : {&mesh.below_chain, &mesh.above_chain})
        for (const std::vector<std::int32_t>& chain : *chains) facets += chain.size() - 1;
    }
    plc.facets.reserve(facets);
  }
  for (std::size_t k = 0; k < meshes.size(); ++k) {
    for (std::size_t t = 0; t < meshes[k].triangles.size(); ++t) {
      listen();
      const Side &below = meshes[k].sides[t][0], &above = meshes[k].sides[t][1];
      Facet facet;
      if (!wanted(below.slab) && !wanted(above.slab)) continue;
      facet.label = classify(below, above);
      if (facet.label == FacetLabel::Interface && !inner_faces) continue;
      for (std::size_t i = 0; i < 3; ++i) facet.vertices[i] = first[k] + meshes[k].triangles[t][i];
      if (facet.label == FacetLabel::Down) {
        std::swap(facet.vertices[1], facet.vertices[2]);
        facet.back = above;
      } else {
        facet.back = below;
        facet.front = above;
      }
      plc.facets.push_back(facet);
    }
  }
  std::int32_t wall = 0;
  std::vector<GridPoint> bottom, top;
  for (std::size_t s = 0; s < contours.slabs.size(); ++s) {
    const auto low = static_cast<std::size_t>(slab_planes[s][0]), high = static_cast<std::size_t>(slab_planes[s][1]);
    const Outline& outline = contours.outlines[s];
    if (!wanted(static_cast<std::int32_t>(s))) {
      wall += static_cast<std::int32_t>(outline.edges.size());
      continue;
    }
    for (std::size_t e = 0; e < outline.edges.size(); ++e, ++wall) {
      const Outline::Edge& edge = outline.edges[e];
      const bool inner = edge.left != kNone && edge.right != kNone;
      if (inner && !inner_faces) continue;
      const std::vector<std::int32_t>&bottom_chain = meshes[low].above_chain[e],
            &top_chain = meshes[high].below_chain[e];
      listen(bottom_chain.size() + top_chain.size());
      bottom.clear();
      top.clear();
      for (const std::int32_t v : bottom_chain) bottom.push_back(meshes[low].vertices[static_cast<std::size_t>(v)]);
      for (const std::int32_t v : top_chain) top.push_back(meshes[high].vertices[static_cast<std::size_t>(v)]);
      const Side left{edge.left == kNone ? kNone : static_cast<std::int32_t>(s), edge.left};
      const Side right{edge.right == kNone ? kNone : static_cast<std::int32_t>(s), edge.right};
      // As given below, triangles have their normals to the right of the edge.
      const bool keep = right.empty() || (!left.empty() && left.region < right.region);
      const auto add = [&](std::int32_t a, std::int32_t b, std::int32_t c) {
        Facet facet;
        facet.vertices = keep ? std::array<std::int32_t, 3>{a, b, c} : std::array<std::int32_t, 3>{a, c, b};
        facet.label = inner ? FacetLabel::InnerWall : FacetLabel::Wall;
        facet.back = keep ? left : right;
        facet.front = keep ? right : left;
        facet.wall = wall;
        plc.facets.push_back(facet);
      };
      detail::for_each_strip_triangle(
          bottom, top,
          [&](std::size_t i, std::size_t i1, std::size_t j) {
            add(first[low] + bottom_chain[i], first[low] + bottom_chain[i1], first[high] + top_chain[j]);
          },
          [&](std::size_t j, std::size_t j1, std::size_t i) {
            add(first[low] + bottom_chain[i], first[high] + top_chain[j1], first[high] + top_chain[j]);
          });
    }
  }
  return plc;
}

}  // namespace slice2mesh
