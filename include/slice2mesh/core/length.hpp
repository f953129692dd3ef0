// SPDX-License-Identifier: MIT
/// @file
/// @brief Length: millimetres or multiples of the layer thickness.
#pragma once

namespace slice2mesh {

/// A length that is either absolute (mm) or relative to the layer thickness h.
struct Length {
  /// In mm, or in layer thicknesses if `relative`.
  double value = 0;
  bool relative = false;  ///< true: multiply by the layer thickness

  /// `value` mm.
  [[nodiscard]] static constexpr Length mm(double value) { return {value, false}; }
  /// `value` times the layer thickness.
  [[nodiscard]] static constexpr Length layers(double value) { return {value, true}; }
  /// The length in mm for the layer thickness `h` in mm.
  [[nodiscard]] constexpr double in_mm(double h) const { return relative ? value * h : value; }
};

}  // namespace slice2mesh
