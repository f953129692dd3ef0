// SPDX-License-Identifier: MIT
/// @file
/// @brief The integer grid on which all coordinates in the plane lie.
#pragma once

#include <cstdint>

namespace slice2mesh {

/// A point of the grid, in pitches from the grid's origin.
struct GridPoint {
  std::int64_t x = 0;
  std::int64_t y = 0;
  friend bool operator==(const GridPoint& a, const GridPoint& b) { return a.x == b.x && a.y == b.y; }
  friend bool operator!=(const GridPoint& a, const GridPoint& b) { return !(a == b); }
  friend bool operator<(const GridPoint& a, const GridPoint& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; }
};

/// The grid. `pitch` is a power of two (mm); the origin is a whole number of pitches. Every grid point within the
/// bounds that `make_grid` promises has coordinates that are exact in double: nothing is rounded on the way to a file.
struct Grid {
  double pitch = 1;           ///< mm, a power of two
  std::int64_t origin_x = 0;  ///< in pitches
  std::int64_t origin_y = 0;  ///< in pitches

  [[nodiscard]] double x_mm(const GridPoint& p) const { return static_cast<double>(origin_x + p.x) * pitch; }
  [[nodiscard]] double y_mm(const GridPoint& p) const { return static_cast<double>(origin_y + p.y) * pitch; }
};

/// Largest coordinate of a grid point, either sign: differences stay below 2^38 and products of two below 2^77.
inline constexpr std::int64_t kGridLimit = std::int64_t{1} << 37;

}  // namespace slice2mesh
