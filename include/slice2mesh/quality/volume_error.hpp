// SPDX-License-Identifier: MIT
/// @file
/// @brief Volumes of a mesh against those of the slices that it was made from.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/core/compensated_sum.hpp"
#include "slice2mesh/core/grid.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/core/slab.hpp"

namespace slice2mesh {

/// What a mesh gains and loses against its input slices, as they are after thickening and union.
struct VolumeError {
  double slices = 0;  ///< mm^3, sum over the slabs of area x thickness of the slice
  double error = 0;   ///< a ratio: volume of the mesh over that, less 1; 0 where there is none
  /// #S, the same ratio for each slab.
  std::vector<double> slab_error;
  /// #S, mm: the area that the slab gains over the length of its contours. So far, on average, it is outside of its
  /// slice.
  std::vector<double> slab_shift;
  std::int32_t worst_slab = -1;  ///< index of the slab with the largest `slab_error`, either sign; -1: no slab
};

/// Compares volumes with those of the slices.
///
/// `slices` (#S): the outlines of the slices, vertices in pitches of `grid`; `slabs` (#S); `slab_volume`: mm^3 of the
/// mesh by slab, as `QualityReport::slab_volume`; slabs beyond its end count as empty. Preconditions: outlines and
/// slabs are of one length. `poll` is called now and then; what it throws ends the work. Errors: none. Cost: linear in
/// the edges of the outlines. Areas are exact; what is made of them is rounded. Source: docs/quality.md, section 1.
[[nodiscard]] inline VolumeError measure_volume_error(const std::vector<Outline>& slices, const Grid& grid,
                                                      const std::vector<Slab>& slabs,
                                                      const std::vector<double>& slab_volume,
                                                      const std::function<void()>& poll = {}) {
  VolumeError result;
  detail::CompensatedSum wanted, there;
  detail::Poll listen(poll, 1 << 16);
  double largest = -1;
  for (std::size_t s = 0; s < slices.size(); ++s) {
    double length = 0;
    for (const Outline::Edge& edge : slices[s].edges) {
      listen();
      length += detail::distance(slices[s].vertices[static_cast<std::size_t>(edge.a)],
                                 slices[s].vertices[static_cast<std::size_t>(edge.b)]);
    }
    const double area = static_cast<double>(detail::doubled_area(slices[s], kNone)) / 2 * grid.pitch * grid.pitch,
                 height = slabs[s].z_high - slabs[s].z_low, volume = s < slab_volume.size() ? slab_volume[s] : 0,
                 gain = volume - area * height;
    wanted.add(area * height);
    there.add(volume);
    result.slab_error.push_back(area > 0 ? gain / (area * height) : 0);
    result.slab_shift.push_back(length > 0 ? gain / height / (length * grid.pitch) : 0);
    if (std::fabs(result.slab_error.back()) <= largest) continue;
    largest = std::fabs(result.slab_error.back());
    result.worst_slab = static_cast<std::int32_t>(s);
  }
  result.slices = wanted.value();
  if (result.slices > 0) result.error = (there.value() - result.slices) / result.slices;
  return result;
}

}  // namespace slice2mesh
