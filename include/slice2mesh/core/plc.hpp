// SPDX-License-Identifier: MIT
/// @file
/// @brief Plc: the piecewise linear complex of the slabs.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "slice2mesh/core/grid.hpp"
#include "slice2mesh/core/slab.hpp"

namespace slice2mesh {

/// What a facet is to the part. The numbers are those of the cell array `label` in files.
enum class FacetLabel : std::uint8_t {
  Down = 0,       ///< horizontal, material above only (bottom, overhang)
  Up = 1,         ///< horizontal, material below only (top, step)
  Interface = 2,  ///< horizontal, material on both sides
  Wall = 3,       ///< vertical, over a contour; material on one side
  InnerWall = 4   ///< vertical, between two regions of one slab
};

/// The name in lower case.
[[nodiscard]] constexpr const char* to_string(FacetLabel label) noexcept {
  switch (label) {
    case FacetLabel::Down: return "down";
    case FacetLabel::Up: return "up";
    case FacetLabel::Interface: return "interface";
    case FacetLabel::Wall: return "wall";
    case FacetLabel::InnerWall: return "inner_wall";
  }
  return "unknown";
}

/// The cell on one side of a facet: slab and region, or kNone for both where there is no material.
struct Side {
  /// Index of the slab, or kNone.
  std::int32_t slab = kNone;
  /// Index of the region, or kNone.
  std::int32_t region = kNone;
  /// True where there is no material.
  [[nodiscard]] bool empty() const { return slab == kNone; }
  friend bool operator==(const Side& a, const Side& b) { return a.slab == b.slab && a.region == b.region; }
  friend bool operator!=(const Side& a, const Side& b) { return !(a == b); }
};

/// An oriented triangle of the complex. Its normal (right-hand rule over `vertices`) points from `back` to `front`.
/// Horizontal: up or interface facets have their normal up, down facets down, so that the normal of a skin facet
/// points out of the material and its `front` is empty. Inner walls have the lower region index at the back.
struct Facet {
  /// Indices of the three corners, in `Plc::vertices` or `Mesh::vertices`.
  std::array<std::int32_t, 3> vertices{};
  /// What it is to the part.
  FacetLabel label = FacetLabel::Wall;
  /// What the normal points to.
  Side front;
  /// What the normal points away from.
  Side back;
  std::int32_t wall = kNone;  ///< walls: id of the vertical quad (contour edge of a slab) it is a part of
};

/// A piecewise linear complex. Horizontal positions lie on `grid`, heights are those of `planes`.
struct Plc {
  /// The grid of the positions.
  Grid grid;
  std::vector<double> planes;              ///< #P: heights in mm, ascending; boundaries of the slabs
  std::vector<GridPoint> vertices;         ///< #V: position in its plane, in pitches of `grid`
  std::vector<std::int32_t> vertex_plane;  ///< #V: index into `planes`
  std::vector<Facet> facets;               ///< #F
  std::vector<Slab> slabs;                 ///< #S
  std::vector<std::array<std::int32_t, 2>>
      slab_planes;              ///< #S by 2: indices of the bottom and the top plane of each slab
  std::vector<Region> regions;  ///< #R
  bool has_inner_faces = true;  ///< false: outer skin alone

  /// Coordinates x, y, z in mm of the vertex of index `vertex`, exact. Precondition: there is one (not checked).
  [[nodiscard]] std::array<double, 3> position(std::size_t vertex) const {
    return {grid.x_mm(vertices[vertex]), grid.y_mm(vertices[vertex]),
            planes[static_cast<std::size_t>(vertex_plane[vertex])]};
  }
};

}  // namespace slice2mesh
