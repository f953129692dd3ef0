// SPDX-License-Identifier: MIT
/// @file
/// @brief Ranges of the numbers of a slice file, for its reader and its writer.
#pragma once

namespace slice2mesh::detail {

/// Largest coordinate of a file, mm. A kilometer: far above any printer, and products of coordinates stay finite.
inline constexpr double kCliLargestCoordinate = 1e6;
/// Range of `$$UNITS`, mm per unit: a picometer to a kilometer.
inline constexpr double kCliSmallestUnit = 1e-9;
inline constexpr double kCliLargestUnit = 1e6;

}  // namespace slice2mesh::detail
