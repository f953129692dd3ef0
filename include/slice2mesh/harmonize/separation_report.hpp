// SPDX-License-Identifier: MIT
/// @file
/// @brief How near contours come to each other and to themselves: what `measure_separation` finds.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "slice2mesh/core/slab.hpp"

namespace slice2mesh {

/// What harmonization aims at: no vertex is nearer than this share of the tolerance to another vertex or to an edge.
inline constexpr double kSeparationShare = 0.45;
/// Pairs are counted below these shares of the tolerance: in ascending order, by index.
inline constexpr std::array<double, 4> kSeparationShares{0.05, 0.1, 0.2, kSeparationShare};
/// What harmonization aims at: contours of different layers do not meet at a smaller angle, in degrees.
inline constexpr double kSeparationAngle = 30;

/// The smallest of some kind, and where it is.
struct SeparationMinimum {
  double size = std::numeric_limits<double>::infinity();  ///< mm or degrees; infinity: none that was looked for
  std::array<double, 3> at{};                             ///< x, y, z in mm
  std::int32_t plane = kNone;                             ///< index of the plane, from the lowest one
  std::int32_t slab_below = kNone;  ///< index of the slab of the contour below; twice the same within one contour
  /// Index of the slab of the contour above, see `slab_below`.
  std::int32_t slab_above = kNone;

  /// True if there is any.
  [[nodiscard]] bool found() const { return plane != kNone; }
};

/// Distances and angles of one kind of pairs. Distances are looked for up to the tolerance, angles up to 180 degrees.
struct SeparationFigures {
  SeparationMinimum vertices;  ///< smallest distance of two vertices, mm
  SeparationMinimum
      vertex_edge;          ///< smallest distance of a vertex to the inside of an edge that does not end in it, mm
  SeparationMinimum angle;  ///< smallest angle of two edges that meet, degrees
  std::array<std::uint64_t, kSeparationShares.size()>
      close_vertices{};  ///< number of pairs nearer than each share, by its index
  std::array<std::uint64_t, kSeparationShares.size()>
      close_vertex_edge{};  ///< number of pairs nearer than each share, by its index
  std::uint64_t sharp = 0;  ///< number of angles below kSeparationAngle

  /// Number of pairs below kSeparationShare and of angles below kSeparationAngle.
  [[nodiscard]] std::uint64_t below_aim() const { return close_vertices.back() + close_vertex_edge.back() + sharp; }
};

/// What `measure_separation` finds.
struct SeparationReport {
  double tolerance = 0;       ///< mm, of the contours; the shares refer to it
  SeparationFigures between;  ///< between the contours of different layers
  SeparationFigures within;   ///< within one contour: thin walls, gaps, spikes, short edges; every slab counts
  std::vector<SeparationFigures> planes;  ///< #P: `between`, of each plane
  std::vector<SeparationFigures> slabs;   ///< #S: `within`, of each slab
};

}  // namespace slice2mesh
