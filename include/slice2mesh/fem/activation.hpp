// SPDX-License-Identifier: MIT
/// @file
/// @brief Activation of layers: times per tet, growing domains, and the sub-mesh of a range of layers.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/fem/boundary_sets.hpp"

namespace slice2mesh {

/// Time at which every tet comes to life, #T: `time(slab, tet)`, a function of the slab's index and the tet's index.
/// Cost: linear.
template <class TimeOfTet>
[[nodiscard]] std::vector<double> activation_times(const Mesh& mesh, TimeOfTet time) {
  std::vector<double> times(mesh.tets.size());
  for (std::size_t t = 0; t < times.size(); ++t) times[t] = static_cast<double>(time(mesh.tet_slab[t], t));
  return times;
}

/// Time at which every tet comes to life, #T: index of its slab times the time per layer (s, finite, >= 0).
/// Errors: OptionError. Cost: linear.
[[nodiscard]] inline std::vector<double> activation_time(const Mesh& mesh, double time_per_layer) {
  if (!(time_per_layer >= 0) || std::isinf(time_per_layer)) throw OptionError("time_per_layer", "must be >= 0");
  return activation_times(mesh, [time_per_layer](std::int32_t slab, std::size_t) { return time_per_layer * slab; });
}

/// The growing domains of the print: after slab k it is the tets order[0 .. begin[k+1]), slab k itself is
/// order[begin[k] .. begin[k+1]).
struct GrowingDomains {
  std::vector<std::int32_t> order;  ///< #T, tets by slab, then index
  std::vector<std::size_t> begin;   ///< #S+1
};

/// Sort the tets by slab. Errors: Error (Stage::Fem) if the arrays of the mesh do not fit together. Cost: linear.
[[nodiscard]] inline GrowingDomains growing_domains(const Mesh& mesh) {
  detail::check_mesh_arrays(mesh, Stage::Fem);
  GrowingDomains domains;
  domains.begin.assign(mesh.slabs.size() + 1, 0);
  for (const std::int32_t s : mesh.tet_slab) ++domains.begin[static_cast<std::size_t>(s) + 1];
  for (std::size_t s = 1; s < domains.begin.size(); ++s) domains.begin[s] += domains.begin[s - 1];
  domains.order.resize(mesh.tets.size());
  std::vector<std::size_t> next(domains.begin);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    domains.order[next[static_cast<std::size_t>(mesh.tet_slab[t])]++] = static_cast<std::int32_t>(t);
  return domains;
}

/// The mesh of some layers, with its own numbering.
struct SubMesh {
  Mesh mesh;                                  ///< slab i is slab `first_slab` + i of the whole; regions are kept
  std::int32_t first_slab = 0;                ///< of the whole mesh
  std::vector<std::int32_t> vertex_in_whole;  ///< #V of the sub-mesh: index in the whole mesh
  std::vector<std::int32_t> tet_in_whole;     ///< #T of the sub-mesh: index in the whole mesh
  std::vector<std::int32_t> vertex_in_sub;    ///< #V of the whole mesh: index in the sub-mesh or kNone
};

/// The sub-mesh of slabs first..last (inclusive). Vertices and tets keep their order; vertices of no tet are left out.
/// Facets are kept where all their vertices are; a side of a facet outside the range becomes empty, and a facet with
/// both sides outside is left out. Labels and orientation of facets stay those of the whole.
/// Errors: Error (Stage::Fem) for a range that is not within the slabs or arrays that do not fit together.
/// Cost: linear in the whole mesh.
[[nodiscard]] inline SubMesh layers_of(const Mesh& mesh, std::int32_t first, std::int32_t last) {
  detail::check_mesh_arrays(mesh, Stage::Fem);
  if (first < 0 || last < first || static_cast<std::size_t>(last) >= mesh.slabs.size())
    throw Error(Stage::Fem, "there are no slabs " + std::to_string(first) + " to " + std::to_string(last));
  SubMesh sub;
  sub.first_slab = first;
  sub.mesh.regions = mesh.regions;
  sub.mesh.slabs.assign(mesh.slabs.begin() + first, mesh.slabs.begin() + last + 1);
  sub.vertex_in_sub.assign(mesh.vertices.size(), kNone);
  const auto inside = [first, last](std::int32_t slab) { return first <= slab && slab <= last; };
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (!inside(mesh.tet_slab[t])) continue;
    sub.tet_in_whole.push_back(static_cast<std::int32_t>(t));
    for (const std::int32_t v : mesh.tets[t]) sub.vertex_in_sub[static_cast<std::size_t>(v)] = 0;
  }
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (sub.vertex_in_sub[v] == kNone) continue;
    sub.vertex_in_sub[v] = static_cast<std::int32_t>(sub.vertex_in_whole.size());
    sub.vertex_in_whole.push_back(static_cast<std::int32_t>(v));
    sub.mesh.vertices.push_back(mesh.vertices[v]);
  }
  for (const std::int32_t whole : sub.tet_in_whole) {
    const auto t = static_cast<std::size_t>(whole);
    std::array<std::int32_t, 4> tet = mesh.tets[t];
    for (std::int32_t& v : tet) v = sub.vertex_in_sub[static_cast<std::size_t>(v)];
    sub.mesh.tets.push_back(tet);
    sub.mesh.tet_slab.push_back(mesh.tet_slab[t] - first);
    sub.mesh.tet_region.push_back(mesh.tet_region[t]);
  }
  for (Facet facet : mesh.facets) {
    bool kept = false;
    for (Side* const side : {&facet.front, &facet.back}) {
      if (!side->empty() && inside(side->slab)) {
        side->slab -= first;
        kept = true;
      } else {
        *side = Side{};
      }
    }
    for (std::int32_t& v : facet.vertices) {
      if (v < 0 || static_cast<std::size_t>(v) >= mesh.vertices.size())
        throw Error(Stage::Fem, "a facet names a vertex that does not exist");
      v = sub.vertex_in_sub[static_cast<std::size_t>(v)];
      kept = kept && v != kNone;
    }
    if (kept) sub.mesh.facets.push_back(facet);
  }
  return sub;
}

}  // namespace slice2mesh
