// SPDX-License-Identifier: MIT
/// @file
/// @brief The integer grid on which all coordinates in the plane lie.
#pragma once

#include <cstddef>
#include <cstdint>

namespace slice2mesh {

/// A point of the grid, in pitches from the grid's origin.
struct GridPoint {
  /// In pitches.
  std::int64_t x = 0;
  /// In pitches.
  std::int64_t y = 0;
  friend bool operator==(const GridPoint& a, const GridPoint& b) { return a.x == b.x && a.y == b.y; }
  friend bool operator!=(const GridPoint& a, const GridPoint& b) { return !(a == b); }
  friend bool operator<(const GridPoint& a, const GridPoint& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; }
};

/// Hash of a grid point, or of the column and row of a cell.
struct GridHash {
  /// The hash.
  [[nodiscard]] std::size_t operator()(const GridPoint& p) const noexcept {
    return static_cast<std::size_t>(static_cast<std::uint64_t>(p.x) * 0x9E3779B97F4A7C15ULL ^
                                    (static_cast<std::uint64_t>(p.y) + 0x7F4A7C15ULL) * 0xC2B2AE3D27D4EB4FULL);
  }
};

/// The grid. `pitch` is a power of two (mm); the origin is a whole number of pitches. Every grid point within the
/// bounds that `make_grid` promises has coordinates that are exact in double: nothing is rounded on the way to a file.
struct Grid {
  double pitch = 1;           ///< mm, a power of two
  std::int64_t origin_x = 0;  ///< in pitches
  std::int64_t origin_y = 0;  ///< in pitches

  /// The x of a point in mm, exact.
  [[nodiscard]] double x_mm(const GridPoint& p) const { return static_cast<double>(origin_x + p.x) * pitch; }
  /// The y of a point in mm, exact.
  [[nodiscard]] double y_mm(const GridPoint& p) const { return static_cast<double>(origin_y + p.y) * pitch; }
};

/// Largest coordinate of a grid point, either sign, in pitches. Contours stay within half of it, so that their
/// differences are below 2^40, products of two below 2^81, and the predicates of arrange/exact.hpp within their 192
/// bits.
inline constexpr std::int64_t kGridLimit = std::int64_t{1} << 40;

/// Are the coordinates of a point, in pitches, within kGridLimit?
[[nodiscard]] constexpr bool is_on_grid(const GridPoint& p) noexcept {
  return p.x >= -kGridLimit && p.x <= kGridLimit && p.y >= -kGridLimit && p.y <= kGridLimit;
}

/// Contour vertices lie on multiples of this many pitches; the pitches in between are for points that split contour
/// edges. Splits and crossings bend an edge by their rounding, half a pitch to half a step; end points of other edges
/// that are within kAttachSteps (arrange/snap_rounding.hpp) by their distance.
inline constexpr std::int64_t kContourStep = std::int64_t{1} << 4;

/// The multiple of kContourStep nearest to a coordinate `v` in pitches (halves go up).
[[nodiscard]] constexpr std::int64_t round_to_step(std::int64_t v) noexcept {
  return (v + kContourStep / 2) & ~(kContourStep - 1);
}

/// The contour vertex nearest to the point between `a` and `b` at the share `t` of the way, from 0 to 1 (not checked);
/// rounded.
[[nodiscard]] inline GridPoint contour_point_between(const GridPoint& a, const GridPoint& b, double t) noexcept {
  const auto at = [t](std::int64_t u, std::int64_t v) {
    return round_to_step(u + static_cast<std::int64_t>(t * static_cast<double>(v - u)));
  };
  return {at(a.x, b.x), at(a.y, b.y)};
}

}  // namespace slice2mesh
