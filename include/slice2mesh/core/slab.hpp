// SPDX-License-Identifier: MIT
/// @file
/// @brief Slab and Region: what a mesh element belongs to.
#pragma once

#include <cstdint>
#include <string>

namespace slice2mesh {

/// One slab: the volume between two consecutive planes that a slice (or a bundle of slices) fills.
struct Slab {
  double z_low = 0;              ///< mm
  double z_high = 0;             ///< mm, above z_low
  std::int32_t first_layer = 0;  ///< index into SliceStack::layers of the first slice of the bundle
  std::int32_t last_layer = 0;   ///< index of the last one (inclusive)
  std::int32_t slice = 0;        ///< index of the slice that represents the bundle
};

enum class RegionKind : std::uint8_t { Part, Support };

[[nodiscard]] constexpr const char* to_string(RegionKind kind) noexcept {
  return kind == RegionKind::Part ? "part" : "support";
}

/// A region: the object or the supports of one part id. Its index in the list of regions is its id everywhere.
struct Region {
  std::int32_t part = 0;  ///< part id of the file
  RegionKind kind = RegionKind::Part;
  std::string name;  ///< label of the file, or "part_<id>" / "support_<id>"
};

/// "nothing here": outside of every slab or region.
inline constexpr std::int32_t kNone = -1;

}  // namespace slice2mesh
