// SPDX-License-Identifier: MIT
/// @file
/// @brief What slicing costs, layer by layer, read off the complex: staircase error and volume loss.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "slice2mesh/core/compensated_sum.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/core/slab.hpp"

namespace slice2mesh {

/// Estimates for one slab. A_k is the area of the part in slab k, h_k its thickness, and the steps between two slabs
/// that touch are where one of them has part material and the other has none (supports are no material here).
struct LayerEstimate {
  double area = 0;       ///< A_k, mm^2
  double perimeter = 0;  ///< mm, of the part
  /// mm^2, steps between this slab and the one above: |S_k xor S_(k+1)|
  double step_area = 0;
  /// mm, mean cusp height at these steps: h w / sqrt(h^2 + w^2), where w is the mean width of the steps (their area
  /// over the mean perimeter of the two slabs) and h the mean thickness
  double cusp = 0;
  /// mm^3, volume between the staircase and the surface that runs straight from the contour in the middle of one slab
  /// to that in the middle of the next, the share of it that lies in this slab; exact for plane walls
  double staircase_volume = 0;
  /// mm^3, volume of the next finer slicing minus that of this slab: positive where the coarser slicing loses
  double volume_loss = 0;
  /// true: the finer slices of the file were measured; false: `volume_loss` is the second difference of the areas
  bool measured = false;
};

/// What `estimate_slicing` finds; base plates are left out.
struct SlicingEstimates {
  std::vector<LayerEstimate> layers;  ///< #S; zeros for slabs of a base plate
  double volume = 0;                  ///< mm^3, of the part
  double staircase_volume = 0;        ///< mm^3, sum over the layers
  double volume_loss = 0;             ///< mm^3, sum over the layers
};

/// A slice of the finer slicing that slabs are compared with.
struct FinerSlice {
  double z_low = 0;   ///< mm, height of its bottom
  double z_high = 0;  ///< mm, height of its top
  double area = 0;    ///< mm^2, of the part
};

/// Estimate the staircase error and the volume loss of every layer from the complex alone.
///
/// Volume loss against the next finer slicing: a slab that stands for several slices of the file is compared with these
/// (`finer`: any number, in any order; those whose middle lies in the slab). A slab that is one slice is compared with
/// two of half its thickness, which the file does not have: their areas are taken from the parabola through the areas
/// of the slab and its two neighbors at their middles, which gives h/2 f'' (h/4)^2; where a neighbor is missing, 0.
/// Real horizontal faces (tops, ledges) cannot be told from steps of a slope: they count as steps, but for the top and
/// the bottom of the part and of pieces with a gap above or below.
/// Precondition: `verify_plc` passes (not checked). `poll` is called now and then; what it throws ends the work.
/// Errors: Error (Stage::Fem) if the complex has no inner faces. Cost: linear in the facets and the finer slices.
[[nodiscard]] inline SlicingEstimates estimate_slicing(const Plc& plc, const std::vector<FinerSlice>& finer = {},
                                                       const std::function<void()>& poll = {}) {
  if (!plc.has_inner_faces) throw Error(Stage::Fem, "estimates need the inner faces of the complex");
  const std::size_t slab_count = plc.slabs.size();
  SlicingEstimates result;
  result.layers.resize(slab_count);
  std::vector<detail::CompensatedSum> up(slab_count);      // part with no part above, at the top
  std::vector<detail::CompensatedSum> down(slab_count);    // part with no part below, at the bottom
  std::vector<detail::CompensatedSum> floors(slab_count);  // part, at the bottom
  std::vector<detail::CompensatedSum> walls(slab_count);
  const auto is_part = [&plc](const Side& side) {
    return !side.empty() && plc.regions[static_cast<std::size_t>(side.region)].kind == RegionKind::Part;
  };
  detail::Poll listen(poll, 1 << 16);
  for (const Facet& facet : plc.facets) {
    listen();
    std::array<std::array<double, 3>, 3> p{};
    for (std::size_t i = 0; i < 3; ++i) p[i] = plc.position(static_cast<std::size_t>(facet.vertices[i]));
    const double ux = p[1][0] - p[0][0], uy = p[1][1] - p[0][1], uz = p[1][2] - p[0][2];
    const double vx = p[2][0] - p[0][0], vy = p[2][1] - p[0][1], vz = p[2][2] - p[0][2];
    const double nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    const double area = std::sqrt(nx * nx + ny * ny + nz * nz) / 2;
    const bool front = is_part(facet.front);
    const bool back = is_part(facet.back);
    if (facet.label == FacetLabel::Wall || facet.label == FacetLabel::InnerWall) {
      if (front != back) walls[static_cast<std::size_t>(front ? facet.front.slab : facet.back.slab)].add(area);
      continue;
    }
    // Down facets have the slab above at their back, the others the slab below.
    const Side& above = facet.label == FacetLabel::Down ? facet.back : facet.front;
    const Side& below = facet.label == FacetLabel::Down ? facet.front : facet.back;
    if (is_part(above)) floors[static_cast<std::size_t>(above.slab)].add(area);
    if (is_part(above) && !is_part(below)) down[static_cast<std::size_t>(above.slab)].add(area);
    if (is_part(below) && !is_part(above)) up[static_cast<std::size_t>(below.slab)].add(area);
  }

  const auto thickness = [&plc](std::size_t s) { return plc.slabs[s].z_high - plc.slabs[s].z_low; };
  for (std::size_t s = 0; s < slab_count; ++s) {
    result.layers[s].area = floors[s].value();
    result.layers[s].perimeter = walls[s].value() / thickness(s);
  }
  // Two slabs with part material that touch.
  const auto touch = [&](std::size_t s) {
    return detail::lies_on_last(plc.slabs, s + 1) && result.layers[s].area > 0 && result.layers[s + 1].area > 0;
  };
  for (std::size_t s = 0; s < slab_count; ++s) {
    if (!touch(s)) continue;
    LayerEstimate& layer = result.layers[s];
    LayerEstimate& next = result.layers[s + 1];
    layer.step_area = up[s].value() + down[s + 1].value();
    const double height = (thickness(s) + thickness(s + 1)) / 2;
    const double length = (layer.perimeter + next.perimeter) / 2;
    const double width = layer.step_area / length;
    layer.cusp = height * width / std::hypot(height, width);
    // Over a step the surface rises evenly from -a to b around the plane between the slabs: the mean distance is
    // (a^2 + b^2) / (2 (a + b)), the first term below the plane.
    const double a = thickness(s) / 2;
    const double b = thickness(s + 1) / 2;
    layer.staircase_volume += layer.step_area * a * a / (2 * (a + b));
    next.staircase_volume += layer.step_area * b * b / (2 * (a + b));
  }
  for (std::size_t s = 1; s + 1 < slab_count; ++s) {
    if (!touch(s - 1) || !touch(s)) continue;
    const double h = thickness(s);
    const double below = (thickness(s - 1) + h) / 2;
    const double above = (h + thickness(s + 1)) / 2;
    const double slope_below = (result.layers[s].area - result.layers[s - 1].area) / below;
    const double slope_above = (result.layers[s + 1].area - result.layers[s].area) / above;
    const double second = 2 * (slope_above - slope_below) / (below + above);
    result.layers[s].volume_loss = h / 2 * second * (h / 4) * (h / 4);
  }

  // Slices of the file, where a slab stands for several.
  std::vector<detail::CompensatedSum> finer_volume(slab_count);
  std::size_t slab = 0;
  for (const FinerSlice& slice : finer) {
    const double middle = slice.z_low + (slice.z_high - slice.z_low) / 2;
    while (slab < slab_count && plc.slabs[slab].z_high <= middle) ++slab;
    if (slab == slab_count) break;
    if (middle > plc.slabs[slab].z_low) finer_volume[slab].add(slice.area * (slice.z_high - slice.z_low));
  }
  detail::CompensatedSum volume;
  detail::CompensatedSum staircase;
  detail::CompensatedSum loss;
  for (std::size_t s = 0; s < slab_count; ++s) {
    LayerEstimate& layer = result.layers[s];
    const double own = layer.area * thickness(s);
    if (!plc.slabs[s].is_plate() && plc.slabs[s].last_layer > plc.slabs[s].first_layer && !finer.empty()) {
      detail::CompensatedSum difference = finer_volume[s];
      difference.add(-own);
      layer.volume_loss = difference.value();
      layer.measured = true;
    }
    volume.add(own);
    staircase.add(layer.staircase_volume);
    loss.add(layer.volume_loss);
  }
  result.volume = volume.value();
  result.staircase_volume = staircase.value();
  result.volume_loss = loss.value();
  return result;
}

}  // namespace slice2mesh
