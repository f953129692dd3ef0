// SPDX-License-Identifier: MIT
/// @file
/// @brief Areas of all slices of a file, to compare bundles of slices with.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "slice2mesh/core/diagnostics.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/core/slice_stack.hpp"
#include "slice2mesh/fem/estimates.hpp"
#include "slice2mesh/pipeline/options.hpp"
#include "slice2mesh/regions/regions.hpp"
#include "slice2mesh/regions/slabs.hpp"

namespace slice2mesh {

/// The slices of the file that the bundles of a plan stand for, one per slice, lowest first, each with the area of its
/// part (supports left out), for `estimate_slicing`; nothing if no slab of the plan stands for more than one slice.
/// Errors: those of `build_regions`. Cost: that of `build_regions` for all slices.
[[nodiscard]] inline std::vector<FinerSlice> finer_slices(const SliceStack& stack, const SlabPlan& plan,
                                                          const SlabOptions& options, const Progress& progress = {}) {
  std::vector<FinerSlice> slices;
  bool bundles = false;
  for (const Slab& slab : plan.slabs) bundles = bundles || slab.last_layer > slab.first_layer;
  if (!bundles) return slices;
  SlabOptions single = options;
  single.lump = 1;
  single.lump_thickness = 0;
  single.z_convention = plan.convention;
  Diagnostics reported_already;
  const SlabPlan finer = make_slabs(stack, single, reported_already);
  const LayerRegions regions = build_regions(stack, finer, ThickenOptions{}, reported_already, progress);
  const double pitch_area = regions.grid.pitch * regions.grid.pitch;
  for (std::size_t s = 0; s < regions.slabs.size(); ++s) {
    double area = 0;
    for (std::size_t r = 0; r < regions.regions.size(); ++r)
      if (regions.regions[r].kind == RegionKind::Part)
        area += static_cast<double>(detail::doubled_area(regions.outlines[s], static_cast<std::int32_t>(r)));
    slices.push_back({regions.slabs[s].z_low, regions.slabs[s].z_high, area / 2 * pitch_area});
  }
  return slices;
}

}  // namespace slice2mesh
