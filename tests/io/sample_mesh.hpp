// SPDX-License-Identifier: MIT
/// @file
/// @brief Hand-made meshes for the tests of quality, fem and io: prisms over a grid of squares, cut into tets.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/plc.hpp"

namespace slice2mesh_test {

/// Region of a square of a slab, or kNone where it is empty.
using SquareRegion = std::function<std::int32_t(std::size_t x, std::size_t y, std::size_t slab)>;

/// A solid made of boxes: which squares of an nx by ny grid are filled in each slab.
struct BoxSolid {
  std::size_t nx = 1;
  std::size_t ny = 1;
  double dx = 1;                  ///< mm
  double dy = 1;                  ///< mm
  std::vector<double> thickness;  ///< #S, mm
  SquareRegion region;            ///< called for every square of every slab
  std::size_t region_count = 1;   ///< region 0 is part 7; region 1 its support; region 2 part 9; region 3 the plate
  std::size_t plate_slabs = 0;    ///< the lowest slabs are a base plate

  [[nodiscard]] std::int32_t at(std::size_t x, std::size_t y, std::size_t s) const {
    return x < nx && y < ny && s < thickness.size() ? region(x, y, s) : slice2mesh::kNone;
  }
  [[nodiscard]] bool filled(std::size_t x, std::size_t y, std::size_t s) const {
    return at(x, y, s) != slice2mesh::kNone;
  }
  [[nodiscard]] std::vector<slice2mesh::Region> regions() const {
    const std::vector<slice2mesh::Region> all = {{7, slice2mesh::RegionKind::Part, "bracket"},
                                                 {7, slice2mesh::RegionKind::Support, "support_7"},
                                                 {9, slice2mesh::RegionKind::Part, "second \"part\""},
                                                 {10, slice2mesh::RegionKind::Plate, "base_plate"}};
    return {all.begin(), all.begin() + static_cast<std::ptrdiff_t>(region_count)};
  }
  [[nodiscard]] std::vector<slice2mesh::Slab> slabs() const {
    std::vector<slice2mesh::Slab> result;
    double z = 0;
    for (std::size_t s = 0; s < thickness.size(); ++s) {
      const auto layer = static_cast<std::int32_t>(s) - static_cast<std::int32_t>(plate_slabs);
      if (layer < 0)
        result.push_back({z, z + thickness[s], slice2mesh::kNone, slice2mesh::kNone, slice2mesh::kNone});
      else
        result.push_back({z, z + thickness[s], 3 * layer, 3 * layer + 2, 3 * layer + 1});
      z = result.back().z_high;
    }
    return result;
  }

  // Areas and perimeters of the definition of the exposed area (mm^2, mm), counted on squares.
  [[nodiscard]] double area(std::size_t s) const {
    double squares = 0;
    for (std::size_t x = 0; x < nx; ++x)
      for (std::size_t y = 0; y < ny; ++y) squares += filled(x, y, s) ? 1 : 0;
    return squares * dx * dy;
  }
  [[nodiscard]] double perimeter(std::size_t s) const {
    double length = 0;
    for (std::size_t x = 0; x < nx; ++x)
      for (std::size_t y = 0; y < ny; ++y) {
        if (!filled(x, y, s)) continue;
        if (!filled(x + 1, y, s)) length += dy;
        if (x == 0 || !filled(x - 1, y, s)) length += dy;
        if (!filled(x, y + 1, s)) length += dx;
        if (y == 0 || !filled(x, y - 1, s)) length += dx;
      }
    return length;
  }
  /// Area filled in slab s but not in slab r.
  [[nodiscard]] double area_without(std::size_t s, std::size_t r) const {
    double squares = 0;
    for (std::size_t x = 0; x < nx; ++x)
      for (std::size_t y = 0; y < ny; ++y) squares += filled(x, y, s) && !filled(x, y, r) ? 1 : 0;
    return squares * dx * dy;
  }
};

/// Every box cut into six tets around its diagonal: conforming, all positive, every tet has a vertical edge.
[[nodiscard]] inline slice2mesh::Mesh mesh_of(const BoxSolid& solid) {
  slice2mesh::Mesh mesh;
  mesh.slabs = solid.slabs();
  mesh.regions = solid.regions();
  std::map<std::array<std::size_t, 3>, std::int32_t> number;
  const auto vertex = [&](std::size_t x, std::size_t y, std::size_t k) {
    const auto found = number.find({x, y, k});
    if (found != number.end()) return found->second;
    const auto v = static_cast<std::int32_t>(mesh.vertices.size());
    mesh.vertices.push_back({static_cast<double>(x) * solid.dx, static_cast<double>(y) * solid.dy,
                             k == 0 ? mesh.slabs[0].z_low : mesh.slabs[k - 1].z_high});
    number[{x, y, k}] = v;
    return v;
  };
  // Paths from corner (0,0,0) to (1,1,1) of a box, one axis after the other; odd orders of the axes are mirrored.
  constexpr std::array<std::array<std::size_t, 3>, 6> kAxes = {
      {{{0, 1, 2}}, {{1, 2, 0}}, {{2, 0, 1}}, {{0, 2, 1}}, {{1, 0, 2}}, {{2, 1, 0}}}};
  for (std::size_t s = 0; s < mesh.slabs.size(); ++s)
    for (std::size_t y = 0; y < solid.ny; ++y)
      for (std::size_t x = 0; x < solid.nx; ++x) {
        const std::int32_t region = solid.at(x, y, s);
        if (region == slice2mesh::kNone) continue;
        for (std::size_t path = 0; path < kAxes.size(); ++path) {
          std::array<std::size_t, 3> corner = {x, y, s};
          std::array<std::int32_t, 4> tet{};
          tet[0] = vertex(corner[0], corner[1], corner[2]);
          for (std::size_t i = 0; i < 3; ++i) {
            ++corner[kAxes[path][i]];
            tet[i + 1] = vertex(corner[0], corner[1], corner[2]);
          }
          if (path >= 3) std::swap(tet[2], tet[3]);
          mesh.tets.push_back(tet);
          mesh.tet_slab.push_back(static_cast<std::int32_t>(s));
          mesh.tet_region.push_back(region);
        }
      }
  return mesh;
}

/// The complex of the same solid: horizontal squares and walls, two triangles each; no inner walls between regions of
/// one slab.
[[nodiscard]] inline slice2mesh::Plc plc_of(const BoxSolid& solid) {
  using slice2mesh::Facet;
  using slice2mesh::FacetLabel;
  using slice2mesh::Side;
  slice2mesh::Plc plc;
  plc.grid.pitch = 0.25;
  plc.slabs = solid.slabs();
  plc.regions = solid.regions();
  plc.planes.push_back(plc.slabs[0].z_low);
  for (std::size_t s = 0; s < plc.slabs.size(); ++s) {
    plc.planes.push_back(plc.slabs[s].z_high);
    plc.slab_planes.push_back({static_cast<std::int32_t>(s), static_cast<std::int32_t>(s) + 1});
  }
  std::map<std::array<std::size_t, 3>, std::int32_t> number;
  const auto vertex = [&](std::size_t x, std::size_t y, std::size_t k) {
    const auto found = number.find({x, y, k});
    if (found != number.end()) return found->second;
    const auto v = static_cast<std::int32_t>(plc.vertices.size());
    plc.vertices.push_back({static_cast<std::int64_t>(static_cast<double>(x) * solid.dx / plc.grid.pitch),
                            static_cast<std::int64_t>(static_cast<double>(y) * solid.dy / plc.grid.pitch)});
    plc.vertex_plane.push_back(static_cast<std::int32_t>(k));
    number[{x, y, k}] = v;
    return v;
  };
  const auto side = [&](std::size_t x, std::size_t y, std::size_t s) {
    const std::int32_t region = solid.at(x, y, s);
    return region == slice2mesh::kNone ? Side{} : Side{static_cast<std::int32_t>(s), region};
  };
  const auto quad = [&](const std::array<std::int32_t, 4>& q, FacetLabel label, Side front, Side back) {
    plc.facets.push_back({{q[0], q[1], q[2]}, label, front, back, slice2mesh::kNone});
    plc.facets.push_back({{q[0], q[2], q[3]}, label, front, back, slice2mesh::kNone});
  };
  for (std::size_t k = 0; k < plc.planes.size(); ++k)
    for (std::size_t y = 0; y < solid.ny; ++y)
      for (std::size_t x = 0; x < solid.nx; ++x) {
        const Side above = side(x, y, k);
        const Side below = k == 0 ? Side{} : side(x, y, k - 1);
        if (above.empty() && below.empty()) continue;
        const std::array<std::int32_t, 4> up = {vertex(x, y, k), vertex(x + 1, y, k), vertex(x + 1, y + 1, k),
                                                vertex(x, y + 1, k)};
        if (below.empty())
          quad({up[3], up[2], up[1], up[0]}, FacetLabel::Down, below, above);
        else
          quad(up, above.empty() ? FacetLabel::Up : FacetLabel::Interface, above, below);
      }
  for (std::size_t s = 0; s < plc.slabs.size(); ++s)
    for (std::size_t y = 0; y < solid.ny; ++y)
      for (std::size_t x = 0; x < solid.nx; ++x) {
        const Side here = side(x, y, s);
        if (here.empty()) continue;
        const auto wall = [&](std::size_t ax, std::size_t ay, std::size_t bx, std::size_t by) {
          quad({vertex(ax, ay, s), vertex(bx, by, s), vertex(bx, by, s + 1), vertex(ax, ay, s + 1)}, FacetLabel::Wall,
               Side{}, here);
        };
        if (y == 0 || !solid.filled(x, y - 1, s)) wall(x, y, x + 1, y);
        if (!solid.filled(x + 1, y, s)) wall(x + 1, y, x + 1, y + 1);
        if (!solid.filled(x, y + 1, s)) wall(x + 1, y + 1, x, y + 1);
        if (x == 0 || !solid.filled(x - 1, y, s)) wall(x, y + 1, x, y);
      }
  return plc;
}

/// One box.
[[nodiscard]] inline BoxSolid single_box() {
  BoxSolid solid;
  solid.thickness = {1};
  solid.region = [](std::size_t, std::size_t, std::size_t) { return 0; };
  return solid;
}

/// A part with a hole, an overhang on supports, a step, a second part beside the first, and slabs of different
/// thickness: four slabs, three regions.
[[nodiscard]] inline BoxSolid stepped_sample() {
  BoxSolid solid;
  solid.nx = 8;
  solid.ny = 6;
  solid.dx = 0.5;
  solid.dy = 0.75;
  solid.thickness = {0.25, 0.25, 0.5, 0.125};
  solid.region_count = 3;
  solid.region = [](std::size_t x, std::size_t y, std::size_t s) -> std::int32_t {
    if (x == 7 && y >= 4) return s <= 2 ? 2 : slice2mesh::kNone;                 // second part, three slabs
    if (x >= 6) return slice2mesh::kNone;                                        // gap beside it
    if (x >= 1 && x <= 2 && y >= 1 && y <= 2) return slice2mesh::kNone;          // hole through all slabs
    if (s <= 1) return x <= 3 ? 0 : (x == 4 && y <= 1 ? 1 : slice2mesh::kNone);  // foot, and supports
    if (s == 2) return 0;                                                        // overhang
    return y >= 2 ? 0 : slice2mesh::kNone;                                       // step
  };
  return solid;
}

/// The same on a base plate of two slabs that is one square wider on every side.
[[nodiscard]] inline BoxSolid plated_sample() {
  const BoxSolid part = stepped_sample();
  BoxSolid solid = part;
  solid.nx = part.nx + 2;
  solid.ny = part.ny + 2;
  solid.thickness.insert(solid.thickness.begin(), {1, 0.5});
  solid.plate_slabs = 2;
  solid.region_count = 4;
  solid.region = [part](std::size_t x, std::size_t y, std::size_t s) -> std::int32_t {
    if (s < 2) return 3;
    return x >= 1 && y >= 1 ? part.at(x - 1, y - 1, s - 2) : slice2mesh::kNone;
  };
  return solid;
}

}  // namespace slice2mesh_test
