// SPDX-License-Identifier: MIT
/// @file
/// @brief Cdt3Mesher: the conforming constrained Delaunay triangulation of CGAL 6.1 and newer as a tetrahedralizer.
///
/// Needs `CGAL::make_conforming_constrained_Delaunay_triangulation_3` (GPL). Where it is not found this header defines
/// nothing but SLICE2MESH_HAS_CDT3 as 0.
#pragma once

#include <CGAL/version.h>

// 1MMmm...: major and minor version.
#if CGAL_VERSION_NR >= 1060100000 && __has_include(<CGAL/make_conforming_constrained_Delaunay_triangulation_3.h>)
#define SLICE2MESH_HAS_CDT3 1
#else
/// 1 where CGAL is new enough (6.1), else 0.
#define SLICE2MESH_HAS_CDT3 0
#endif

#if SLICE2MESH_HAS_CDT3

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/make_conforming_constrained_Delaunay_triangulation_3.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <new>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <vector>

#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/tet/child_process.hpp"
#include "slice2mesh/tet/raw_tets_bytes.hpp"
#include "slice2mesh/tet/restore_layers.hpp"
#include "slice2mesh/tet/tetrahedralizer.hpp"

namespace slice2mesh {

namespace detail {

/// All tets of the convex hull: `restore_layers` drops those outside of the skin.
[[nodiscard]] inline RawTets run_cdt3(const Plc& plc) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  try {
    std::vector<Kernel::Point_3> points;
    points.reserve(plc.vertices.size());
    for (std::size_t v = 0; v < plc.vertices.size(); ++v) {
      const std::array<double, 3> p = plc.position(v);
      points.emplace_back(p[0], p[1], p[2]);
    }
    // Every triangle is a constraint of its own: a wall whose contour edge was split is bent by a rounding, so that its
    // triangles together make no planar face.
    std::vector<std::vector<std::size_t>> polygons;
    polygons.reserve(plc.facets.size());
    for (const Facet& facet : plc.facets)
      polygons.push_back({static_cast<std::size_t>(facet.vertices[0]), static_cast<std::size_t>(facet.vertices[1]),
                          static_cast<std::size_t>(facet.vertices[2])});
    const auto ccdt = CGAL::make_conforming_constrained_Delaunay_triangulation_3(points, polygons);
    const auto& triangulation = ccdt.triangulation();
    RawTets tets;
    using Vertex = typename std::decay_t<decltype(triangulation)>::Vertex_handle;
    std::unordered_map<Vertex, std::int32_t> number;
    for (const auto v : triangulation.finite_vertex_handles()) {
      number.emplace(v, static_cast<std::int32_t>(tets.vertices.size()));
      const auto& p = v->point();
      tets.vertices.push_back({p.x(), p.y(), p.z()});
    }
    for (const auto c : triangulation.finite_cell_handles())
      tets.tets.push_back(
          {number.at(c->vertex(0)), number.at(c->vertex(1)), number.at(c->vertex(2)), number.at(c->vertex(3))});
    return tets;
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw TetrahedralizationError(-1, "CGAL's constrained Delaunay triangulation ran out of memory");
  } catch (const std::exception& error) {
    throw TetrahedralizationError(-1, std::string("CGAL's constrained Delaunay triangulation: ") + error.what());
  }
}

}  // namespace detail

/// CGAL's conforming constrained Delaunay triangulation as a tetrahedralizer: exact, without regard to shape. Points
/// are added on edges and facets where that is needed. Runs in a child process with limits unless `child_process` is
/// false. Errors: TetrahedralizationError, also for a complex that is not sound; OptionError for limits out of range;
/// Cancelled, and what `progress` throws.
struct Cdt3Mesher {
  /// False: in this process, without limits.
  bool child_process = true;
  /// Of the child process.
  ChildLimits limits;
  /// Listener; may cancel.
  Progress progress;

  /// What the model promises.
  [[nodiscard]] TetrahedralizerTraits traits() const { return {"cdt3", FacetKeeping::Subdivided, true, false}; }
  /// The mesh. Errors: see above.
  [[nodiscard]] Mesh operator()(const Plc& plc) const { return restored(plc).mesh; }

  /// The mesh with what became of the layers. Errors: see above.
  [[nodiscard]] RestoredMesh restored(const Plc& plc) const {
    detail::require_sound(plc);
    const auto work = [&plc] { return detail::run_cdt3(plc); };
    return restore_layers(child_process ? detail::raw_tets_from_child("CDT_3", work, limits, progress) : work(), plc);
  }
};

}  // namespace slice2mesh

#endif
