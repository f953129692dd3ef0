// SPDX-License-Identifier: MIT
/// @file
/// @brief Corners, straight walls and curves of contours.
#pragma once

#include <cmath>
#include <cstdint>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/core/grid.hpp"

namespace slice2mesh::detail {

/// What a contour is at a vertex. Corners and straight walls are seen, and measured on the part, when they change.
enum class ContourShape : std::uint8_t { Corner, Straight, Curved };

/// Pitches: places of contours are rounded to steps, so what is as near as this to a line is on it.
inline constexpr double kOnLine = 2 * double(kContourStep);
/// Tangent of 30 degrees, the turn from which on a vertex is a corner.
inline constexpr double kCornerTangent = 0.5773502691896258;

/// Distance of p from the line through a and b, pitches. Precondition: a != b.
[[nodiscard]] inline double line_distance(const GridPoint& p, const GridPoint& a, const GridPoint& b) {
  return std::fabs(double(cross(a, b, p))) / distance(a, b);
}

/// The shape at p between its two neighbors.
[[nodiscard]] inline ContourShape contour_shape(const GridPoint& p, const GridPoint& a, const GridPoint& b) {
  const double ahead = -double(dot(p, a, b));
  if (!(ahead > 0)) return ContourShape::Corner;
  if (line_distance(p, a, b) <= kOnLine) return ContourShape::Straight;
  return std::fabs(double(cross(p, a, b))) < kCornerTangent * ahead ? ContourShape::Curved : ContourShape::Corner;
}

}  // namespace slice2mesh::detail
