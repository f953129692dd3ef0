// SPDX-License-Identifier: MIT
/// @file
/// @brief Mesh3Mesher: CGAL::Mesh_3 as a tetrahedralizer.
///
/// Mesh_3 (Jamin, Alliez, Yvinec, Boissonnat, "CGALmesh", ACM TOMS 41 (2015)) refines a Delaunay triangulation until
/// every element meets its criteria. The domain is the complex of all cells, one subdomain per slab and region, with
/// the edges where facets meet at an angle as features. Contours are replaced by polylines with edges of the wanted
/// size: see docs/tetrahedralizers.md. CGAL's package is under the GPL. This header takes long to compile: include it
/// in one place, or see core/separate.hpp.
#pragma once

#include "slice2mesh/core/separate.hpp"

#if !SLICE2MESH_DECLARED_ONLY
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"  // a false alarm inside Boost.Graph
#endif
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_polyhedron_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polyhedral_complex_mesh_domain_3.h>
#include <CGAL/Random.h>
#include <CGAL/make_mesh_3.h>
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <map>
#include <new>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/length.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/tet/child_process.hpp"
#include "slice2mesh/tet/raw_tets_bytes.hpp"
#include "slice2mesh/tet/restore_layers.hpp"
#include "slice2mesh/tet/tetrahedralizer.hpp"

namespace slice2mesh {

/// Criteria of Mesh_3. Relative lengths are multiples of the median thickness of the slabs.
struct Mesh3Options {
  Length size = Length::layers(2);        ///< circumradii of tets and of surface triangles are at most this, > 0
  Length edge_size = Length::mm(0);       ///< longest edge on features; 0: `size`
  Length distance = Length::layers(0.1);  ///< of surface triangles from the facets that they stand for, > 0
  double facet_angle = 25;                ///< degrees, of surface triangles, 0 to 30 (with more it need not end)
  double radius_edge = 2;     ///< largest ratio of circumradius to shortest edge of a tet, at least 2 to be sure to end
  double feature_angle = 60;  ///< degrees between the normals of facets, from which on their edge is a feature
  bool perturb = true;        ///< move vertices of slivers
  bool exude = true;          ///< change weights of vertices of slivers
};

namespace detail {

#if !SLICE2MESH_DECLARED_ONLY

using Mesh3Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh3Polyhedron = CGAL::Mesh_polyhedron_3<Mesh3Kernel>::type;
using Mesh3Domain = CGAL::Polyhedral_complex_mesh_domain_3<Mesh3Kernel, Mesh3Polyhedron>;
using Mesh3Triangulation = CGAL::Mesh_triangulation_3<Mesh3Domain>::type;
using Mesh3Complex = CGAL::Mesh_complex_3_in_triangulation_3<Mesh3Triangulation>;
using Mesh3Criteria = CGAL::Mesh_criteria_3<Mesh3Triangulation>;

/// The facets of a complex as surfaces: those with the same label between the same cells make one.
struct Mesh3Surfaces {
  std::vector<Mesh3Polyhedron> surfaces;
  std::vector<std::pair<int, int>> sides;  // subdomains at back and front; 0: outside
};

/// Subdomain of a cell: from 1.
[[nodiscard]] inline int mesh3_subdomain(const Side& side, std::size_t regions) {
  return side.empty() ? 0 : side.slab * static_cast<int>(regions) + side.region + 1;
}

[[nodiscard]] inline Mesh3Surfaces mesh3_surfaces(const Plc& plc) {
  namespace PMP = CGAL::Polygon_mesh_processing;
  std::map<std::array<int, 3>, std::vector<std::size_t>> groups;
  for (std::size_t f = 0; f < plc.facets.size(); ++f) {
    const Facet& facet = plc.facets[f];
    groups[{static_cast<int>(facet.label), mesh3_subdomain(facet.back, plc.regions.size()),
            mesh3_subdomain(facet.front, plc.regions.size())}]
        .push_back(f);
  }
  Mesh3Surfaces result;
  for (const auto& [key, facets] : groups) {
    std::vector<Mesh3Kernel::Point_3> points;
    std::vector<std::array<std::size_t, 3>> triangles;
    std::unordered_map<std::int32_t, std::size_t> number;
    for (const std::size_t f : facets) {
      std::array<std::size_t, 3> triangle{};
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t v = plc.facets[f].vertices[k];
        const auto [it, is_new] = number.emplace(v, points.size());
        if (is_new) {
          const std::array<double, 3> p = plc.position(static_cast<std::size_t>(v));
          points.emplace_back(p[0], p[1], p[2]);
        }
        triangle[k] = it->second;
      }
      triangles.push_back(triangle);
    }
    // Where a surface touches itself along an edge or at a vertex, the vertices there are doubled.
    if (!PMP::is_polygon_soup_a_polygon_mesh(triangles)) PMP::orient_polygon_soup(points, triangles);
    result.surfaces.emplace_back();
    PMP::polygon_soup_to_polygon_mesh(points, triangles, result.surfaces.back());
    result.sides.emplace_back(key[1], key[2]);
  }
  return result;
}

#endif

[[nodiscard]] SLICE2MESH_INLINE RawTets run_mesh3(const Plc& plc, const Mesh3Options& options);

#if !SLICE2MESH_DECLARED_ONLY

SLICE2MESH_INLINE RawTets run_mesh3(const Plc& plc, const Mesh3Options& options) {
  try {
    CGAL::get_default_random() = CGAL::Random(0);  // whatever ran before, the same rays are shot
    Mesh3Surfaces surfaces = mesh3_surfaces(plc);
    Mesh3Domain domain(surfaces.surfaces.begin(), surfaces.surfaces.end(), surfaces.sides.begin(),
                       surfaces.sides.end());
    domain.detect_features(options.feature_angle);
    namespace parameters = CGAL::parameters;
    const Mesh3Criteria criteria(
        parameters::edge_size = options.edge_size.value, parameters::facet_angle = options.facet_angle,
        parameters::facet_size = options.size.value, parameters::facet_distance = options.distance.value,
        parameters::cell_radius_edge_ratio = options.radius_edge, parameters::cell_size = options.size.value);
    const Mesh3Complex complex = CGAL::make_mesh_3<Mesh3Complex>(
        domain, criteria, options.perturb ? parameters::perturb() : parameters::no_perturb(),
        options.exude ? parameters::exude() : parameters::no_exude());
    RawTets tets;
    std::unordered_map<Mesh3Triangulation::Vertex_handle, std::int32_t, CGAL::Handle_hash_function> number;
    const auto regions = static_cast<int>(plc.regions.size());
    for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell) {
      std::array<std::int32_t, 4> tet{};
      for (int k = 0; k < 4; ++k) {
        const auto v = cell->vertex(k);
        const auto [it, is_new] = number.emplace(v, static_cast<std::int32_t>(tets.vertices.size()));
        if (is_new) {
          const auto& p = v->point().point();
          tets.vertices.push_back({p.x(), p.y(), p.z()});
        }
        tet[static_cast<std::size_t>(k)] = it->second;
      }
      const int subdomain = complex.subdomain_index(cell) - 1;
      tets.tets.push_back(tet);
      tets.cells.push_back({subdomain / regions, subdomain % regions});
    }
    return tets;
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw TetrahedralizationError(-1, "Mesh_3 ran out of memory");
  } catch (const std::exception& error) {
    throw TetrahedralizationError(-1, std::string("Mesh_3: ") + error.what());
  }
}

#endif

}  // namespace detail

/// CGAL::Mesh_3 as a tetrahedralizer. Facets in the planes and in plane walls are met up to rounding, contours only as
/// far as `edge_size` allows; it may take long, or for ever where features are much closer than the size: it runs in a
/// child process with limits unless `child_process` is false.
/// Errors: TetrahedralizationError, also for a complex that is not sound; OptionError; Cancelled, and what `progress`
/// throws.
struct Mesh3Mesher {
  /// Criteria of the mesh.
  Mesh3Options options;
  /// False: in this process, without limits.
  bool child_process = true;
  /// Of the child process.
  ChildLimits limits;
  /// Listener; may cancel.
  Progress progress;

  /// What the model promises.
  [[nodiscard]] TetrahedralizerTraits traits() const { return {"mesh3", FacetKeeping::No, false, false}; }
  /// The mesh. Errors: see above.
  [[nodiscard]] Mesh operator()(const Plc& plc) const { return restored(plc).mesh; }

  /// The mesh with what became of the layers. Errors: see above.
  [[nodiscard]] RestoredMesh restored(const Plc& plc) const {
    detail::require_sound(plc);
    const Mesh3Options used = resolved(plc);
    const auto work = [&plc, &used] { return detail::run_mesh3(plc, used); };
    RestoreOptions restore;
    restore.outside = OutsideTets::Keep;
    return restore_layers(child_process ? detail::raw_tets_from_child("Mesh_3", work, limits, progress) : work(), plc,
                          restore);
  }

  /// The options with all lengths in mm. Errors: OptionError. Precondition: a sound complex.
  [[nodiscard]] Mesh3Options resolved(const Plc& plc) const {
    std::vector<double> heights;
    for (const Slab& slab : plc.slabs) heights.push_back(slab.z_high - slab.z_low);
    std::sort(heights.begin(), heights.end());
    const double thickness = heights[(heights.size() - 1) / 2];
    Mesh3Options used = options;
    const auto resolve = [thickness](const char* option, Length& length) {
      length = Length::mm(length.in_mm(thickness));
      if (!(length.value > 0) || !std::isfinite(length.value)) throw OptionError(option, "must be a length above 0");
    };
    const auto check = [](const char* option, double value, double low, double high) {
      if (!(value >= low && value <= high))
        throw OptionError(option, "must be from " + detail::number_text(low) + " to " + detail::number_text(high));
    };
    if (used.edge_size.value == 0) used.edge_size = used.size;
    resolve("size", used.size);
    resolve("edge_size", used.edge_size);
    resolve("distance", used.distance);
    check("facet_angle", used.facet_angle, 0, 30);
    constexpr double kLargestRatio = 1e6;
    check("radius_edge", used.radius_edge, 0, kLargestRatio);
    check("feature_angle", used.feature_angle, 0, 180);
    return used;
  }
};

}  // namespace slice2mesh
