// SPDX-License-Identifier: MIT
/// @file
/// @brief CGAL's constrained Delaunay triangulation, with points of the grid.
#pragma once

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Constrained_triangulation_face_base_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/hilbert_sort.h>

#include <cstdint>
#include <functional>
#include <numeric>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/snap_rounding.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/progress.hpp"

namespace slice2mesh {

namespace detail {

using CdtKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CdtPoint = CdtKernel::Point_2;
using CdtVertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::int32_t, CdtKernel>;
using CdtFaceBase = CGAL::Triangulation_face_base_with_info_2<std::int32_t, CdtKernel,
                                                              CGAL::Constrained_triangulation_face_base_2<CdtKernel>>;
using Cdt = CGAL::Constrained_Delaunay_triangulation_2<CdtKernel,
                                                       CGAL::Triangulation_data_structure_2<CdtVertexBase, CdtFaceBase>,
                                                       CGAL::No_constraint_intersection_requiring_constructions_tag>;

/// Grid coordinates are integers below 2^38: exact in double, and so are the kernel's predicates on them.
[[nodiscard]] inline CdtPoint to_cdt_point(const GridPoint& p) {
  return {static_cast<double>(p.x), static_cast<double>(p.y)};
}

/// Traits for CGAL's spatial sorting of indices of points; a listener is told the comparisons.
struct ListeningSpatialTraits {
  using Point_2 = std::size_t;  // NOLINT(readability-identifier-naming): names of CGAL, here and below
  template <int kAxis>
  struct Less {
    const std::vector<CdtPoint>* points;
    Poll* listen;
    bool operator()(std::size_t i, std::size_t j) const {
      (*listen)();
      return (*points)[i][kAxis] < (*points)[j][kAxis];
    }
  };
  using Less_x_2 = Less<0>;  // NOLINT(readability-identifier-naming)
  using Less_y_2 = Less<1>;  // NOLINT(readability-identifier-naming)
  const std::vector<CdtPoint>* points;
  Poll* listen;
  [[nodiscard]] Less_x_2 less_x_2_object() const { return {points, listen}; }
  [[nodiscard]] Less_y_2 less_y_2_object() const { return {points, listen}; }
};

/// Inserts the points in a spatially coherent order. The vertex with info i stands at points[i]. `poll` is called now
/// and then.
inline std::vector<Cdt::Vertex_handle> insert_points(Cdt& cdt, const std::vector<GridPoint>& points,
                                                     const std::function<void()>& poll = {}) {
  if (points.empty()) return {};
  std::vector<CdtPoint> coordinates;
  coordinates.reserve(points.size());
  for (const GridPoint& p : points) coordinates.push_back(to_cdt_point(p));
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  Poll compared(poll, 1 << 16);
  CGAL::hilbert_sort(order.begin(), order.end(), ListeningSpatialTraits{&coordinates, &compared});
  std::vector<Cdt::Vertex_handle> handles(points.size());
  Cdt::Face_handle hint;
  Poll listen(poll, 1024);
  for (const std::size_t i : order) {
    listen();
    handles[i] = cdt.insert(coordinates[i], hint);
    handles[i]->info() = static_cast<std::int32_t>(i);
    hint = handles[i]->face();
  }
  return handles;
}

inline void insert_edge(Cdt& cdt, Cdt::Vertex_handle a, Cdt::Vertex_handle b, Stage stage) {
  try {
    cdt.insert_constraint(a, b);
  } catch (const Cdt::Intersection_of_constraints_exception&) {
    throw GeometryError(stage, -1, -1, "edges of an arrangement cross; this is a defect of slice2mesh");
  }
}

}  // namespace detail

}  // namespace slice2mesh
