// SPDX-License-Identifier: MIT
/// @file
/// @brief Slab and Region: what a mesh element belongs to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace slice2mesh {

/// The index that stands for "nothing here": outside of every slab or region.
inline constexpr std::int32_t kNone = -1;

/// One slab: the volume between two consecutive planes that a slice (or a bundle of slices) fills, or a layer of the
/// base plate below the first slice.
struct Slab {
  double z_low = 0;              ///< mm, height of its bottom
  double z_high = 0;             ///< mm, height of its top, above z_low
  std::int32_t first_layer = 0;  ///< index into SliceStack::layers of the first slice of the bundle
  std::int32_t last_layer = 0;   ///< index of the last one (inclusive)
  std::int32_t slice = 0;        ///< index of the slice that represents the bundle

  /// True for a slab of the base plate: it has no slice, and kNone for all three indices.
  [[nodiscard]] bool is_plate() const noexcept { return slice == kNone; }
};

/// What a region is made for. The numbers are those of the cell array `material` in files.
enum class RegionKind : std::uint8_t {
  Part = 0,     ///< what contours enclose
  Support = 1,  ///< a thickened open line
  Plate = 2     ///< the base plate
};

/// The name in lower case.
[[nodiscard]] constexpr const char* to_string(RegionKind kind) noexcept {
  return kind == RegionKind::Part ? "part" : kind == RegionKind::Support ? "support" : "plate";
}

/// A region: the object or the supports of one part id, or the base plate. Its index in the list of regions is its id
/// everywhere.
struct Region {
  std::int32_t part = 0;  ///< part id of the file
  /// What it is made for.
  RegionKind kind = RegionKind::Part;
  std::string name;  ///< label of the file, or "part_<id>" / "support_<id>"
};

namespace detail {

/// Does slab s exist, and lie on the one before it without room between? Heights are compared exactly.
[[nodiscard]] inline bool lies_on_last(const std::vector<Slab>& slabs, std::size_t s) {
  return s > 0 && s < slabs.size() && slabs[s - 1].z_high == slabs[s].z_low;
}

}  // namespace detail

}  // namespace slice2mesh
