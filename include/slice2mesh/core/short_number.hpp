// SPDX-License-Identifier: MIT
/// @file
/// @brief Numbers and places as text, for messages and reports.
#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <string>

#include "slice2mesh/core/grid.hpp"

namespace slice2mesh::detail {

/// A number with so many significant digits, as short as possible, whatever the locale.
[[nodiscard]] inline std::string short_number(double value, int digits = 6) {
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  std::array<char, 64> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, digits).ptr;
  return {text.data(), end};
}

/// Where a grid point is, for messages: "x, y mm".
[[nodiscard]] inline std::string place_text(const Grid& grid, const GridPoint& p) {
  constexpr int kDigits = 12;
  return short_number(grid.x_mm(p), kDigits) + ", " + short_number(grid.y_mm(p), kDigits) + " mm";
}

}  // namespace slice2mesh::detail
