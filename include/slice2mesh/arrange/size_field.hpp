// SPDX-License-Identifier: MIT
/// @file
/// @brief Edge lengths that are wanted, as a function of the place.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/grid.hpp"
#include "slice2mesh/core/short_number.hpp"
#include "slice2mesh/core/size_function.hpp"

namespace slice2mesh::detail {

/// No element size below this share of the extent: the mesh would have more than 10^12 vertices.
inline constexpr double kSmallestSize = 1.0 / 1048576;

/// The larger side of the box around all outlines, pitches.
[[nodiscard]] inline double largest_extent(const std::vector<Outline>& outlines) {
  GridPoint low{kGridLimit, kGridLimit}, high{-kGridLimit, -kGridLimit};
  for (const Outline& outline : outlines)
    for (const GridPoint& p : outline.vertices) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
  return static_cast<double>(std::max(high.x - low.x, high.y - low.y));
}
/// The smallest edge length that may be asked for, pitches.
[[nodiscard]] inline double smallest_size(const std::vector<Outline>& outlines) {
  return kSmallestSize * largest_extent(outlines);
}

/// A size function, of mm, on the points of a grid.
class SizeField {
public:
  /// `smallest`: pitches, that the function may give.
  SizeField(SizeFunction size_at, const Grid& grid, double smallest)
      : size_at_(std::move(size_at)), grid_(grid), smallest_(smallest) {}
  /// The edge length wanted at a point in pitches, at a height in mm; may be infinite.
  /// Errors: OptionError where the function gives less than it may, or no number.
  [[nodiscard]] double wanted_at(double x, double y, double z) const {
    const double x_mm = (static_cast<double>(grid_.origin_x) + x) * grid_.pitch,
                 y_mm = (static_cast<double>(grid_.origin_y) + y) * grid_.pitch;
    const double size = size_at_(x_mm, y_mm, z) / grid_.pitch;
    if (!(size >= smallest_))
      throw OptionError("size.size_at", "is below 2^-20 of the extent of the part, or no number, at (" +
                                            short_number(x_mm) + ", " + short_number(y_mm) + ", " + short_number(z) +
                                            ")");
    return size;
  }
  [[nodiscard]] double wanted_at(const GridPoint& p, double z) const {
    return wanted_at(static_cast<double>(p.x), static_cast<double>(p.y), z);
  }

private:
  SizeFunction size_at_;
  Grid grid_;
  double smallest_;
};

}  // namespace slice2mesh::detail
