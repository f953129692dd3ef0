// SPDX-License-Identifier: MIT
/// @file
/// @brief Interior vertices of the planes: one graded lattice for all of them, and the contours of the planes next to
/// them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <unordered_map>
#include <vector>

#include "slice2mesh/arrange/segment_index.hpp"
#include "slice2mesh/arrange/snap_rounding.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/core/slab.hpp"
#include "slice2mesh/harmonize/harmonize.hpp"

namespace slice2mesh {

/// Sizes for interior vertices, in pitches.
struct InteriorSizes {
  double size = 0;          ///< pitches, > 0: spacing of the lattice
  double contour_size = 0;  ///< pitches, > 0: spacing along contours
};

namespace detail {

/// Points with a least distance from each other.
class SpacedPoints {
public:
  explicit SpacedPoints(double distance) : distance_(distance) {}
  [[nodiscard]] bool clear(const GridPoint& p, double limit) const {
    const auto reach = std::int64_t(std::ceil(limit / distance_));
    const std::int64_t c = column(p.x), r = column(p.y);
    for (std::int64_t i = c - reach; i <= c + reach; ++i)
      for (std::int64_t j = r - reach; j <= r + reach; ++j) {
        const auto range = cells_.equal_range(key(i, j));
        for (auto it = range.first; it != range.second; ++it)
          if (detail::distance(it->second, p) < limit) return false;
      }
    return true;
  }
  void add(const GridPoint& p) { cells_.emplace(key(column(p.x), column(p.y)), p); }

private:
  [[nodiscard]] std::int64_t column(std::int64_t x) const { return std::int64_t(std::floor(double(x) / distance_)); }
  static std::uint64_t key(std::int64_t c, std::int64_t r) { return GridHash{}({c, r}); }
  double distance_;
  std::unordered_multimap<std::uint64_t, GridPoint> cells_;
};

/// Where contours of neighboring slabs run side by side in a narrow band: triangles there are small, and those next to
/// them should not be much larger.
class NarrowBands {
public:
  /// `outlines`: of slabs that follow each other upwards. `size`: spacing of the lattice.
  NarrowBands(const std::vector<const Outline*>& outlines, double size, Poll& listen)
      : reach_(kFineBelow * size / kGrowth), limit_(kFineBelow * size) {
    std::vector<SegmentIndex> index;
    index.reserve(outlines.size());
    for (const Outline* outline : outlines) index.emplace_back(*outline, &listen);
    const double narrow = kNarrow * size, spacing = kSpacing * size;
    SpacedPoints taken(std::max(1.0, spacing));
    for (std::size_t i = 0; i + 1 < outlines.size(); ++i)
      for (const std::size_t side : {i, i + 1})
        for (const GridPoint& p : outlines[side]->vertices) {
          listen();
          const double width = index[side == i ? i + 1 : i].distance(p, narrow, &listen);
          // What stands on the other contour is not beside it.
          if (!(width < narrow) || width <= kAttachSteps * double(kContourStep) || !taken.clear(p, spacing)) continue;
          taken.add(p);
          const std::int64_t c = cell(p.x), r = cell(p.y);
          for (std::int64_t x = c - 1; x <= c + 1; ++x)
            for (std::int64_t y = r - 1; y <= r + 1; ++y) places_[GridHash{}({x, y})].push_back({p, width});
        }
  }
  [[nodiscard]] bool empty() const { return places_.empty(); }
  /// Is the size that grows from the bands still small at p, so that the lattice should be finer there?
  [[nodiscard]] bool is_fine(const GridPoint& p) const {
    const auto it = places_.find(GridHash{}({cell(p.x), cell(p.y)}));
    return it != places_.end() && std::any_of(it->second.begin(), it->second.end(), [&](const Place& place) {
             return place.width + kGrowth * distance(place.point, p) < limit_;
           });
  }

private:
  static constexpr double kNarrow = 0.15;    // of the lattice spacing: bands below this width count
  static constexpr double kGrowth = 0.5;     // of the size over distance
  static constexpr double kFineBelow = 0.8;  // of the lattice spacing: the size up to which the finer lattice is used
  static constexpr double kSpacing = 0.1;    // of the lattice spacing: places nearer to each other than this are one

  struct Place {
    GridPoint point;
    double width;
  };
  [[nodiscard]] std::int64_t cell(std::int64_t x) const { return std::int64_t(std::floor(double(x) / reach_)); }
  double reach_, limit_;
  std::unordered_map<std::uint64_t, std::vector<Place>> places_;  // in each cell and the cells next to it
};

}  // namespace detail

/// Candidates for the interior vertices of the plane between the slabs of index `slab_below` and `slab_above` (kNone:
/// none): any number. A pure function of the contours of these slabs and the next ones. Neighboring planes get the same
/// points wherever all their contours are far enough. `poll` is called now and then; what it throws ends the work.
/// Precondition: the indices are slabs of the contours, the sizes above 0 (not checked). Cost: O(n log n).
[[nodiscard]] inline std::vector<GridPoint> interior_points(const Contours& contours, std::int32_t slab_below,
                                                            std::int32_t slab_above, const InteriorSizes& asked,
                                                            const std::function<void()>& poll = {}) {
  // No two points are farther apart than the grid is wide: larger sizes mean the same, and fit the integers.
  constexpr double kLargest = 4 * static_cast<double>(kGridLimit);
  const InteriorSizes sizes{std::min(asked.size, kLargest), std::min(asked.contour_size, kLargest)};
  std::vector<GridPoint> result;
  const auto count = static_cast<std::int32_t>(contours.slabs.size());
  const auto touch = [&](std::int32_t s) {  // slab s touches slab s + 1
    return detail::lies_on_last(contours.slabs, std::size_t(s) + 1);
  };
  std::vector<std::pair<GridPoint, GridPoint>> own;
  GridPoint low{kGridLimit, kGridLimit}, high{-kGridLimit, -kGridLimit};
  for (const std::int32_t s : {slab_below, slab_above}) {
    if (s == kNone) continue;
    const auto segments = detail::SegmentIndex::segments_of(contours.outlines[std::size_t(s)]);
    own.insert(own.end(), segments.begin(), segments.end());
    for (const GridPoint& p : contours.outlines[std::size_t(s)].vertices) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
  }
  detail::Poll listen(poll, 1024);
  const detail::SegmentIndex own_index(std::move(own), &listen);
  // Contours of the next planes: their vertices stand here too, so that the slab between has columns under them.
  std::vector<std::pair<GridPoint, GridPoint>> next;
  constexpr double kImprintFromContour = 0.7, kImprintSpacing = 0.6;  // of the contour size
  constexpr double kLatticeFromContour = 0.6;                         // of the lattice spacing
  detail::SpacedPoints taken(std::max(1.0, sizes.contour_size * kImprintSpacing));
  const auto imprint = [&](std::int32_t s) {
    const Outline& outline = contours.outlines[std::size_t(s)];
    const auto segments = detail::SegmentIndex::segments_of(outline);
    next.insert(next.end(), segments.begin(), segments.end());
    const double limit = kImprintFromContour * sizes.contour_size;
    for (const GridPoint& p : outline.vertices) {
      listen();
      if (own_index.distance(p, limit) < limit || !taken.clear(p, sizes.contour_size * kImprintSpacing)) continue;
      taken.add(p);
      result.push_back(p);
    }
  };
  std::vector<std::int32_t> slabs;  // this plane's and the next ones, upwards
  if (slab_below != kNone && slab_below > 0 && touch(slab_below - 1)) slabs.push_back(slab_below - 1);
  for (const std::int32_t s : {slab_below, slab_above})
    if (s != kNone) slabs.push_back(s);
  if (slab_above != kNone && slab_above + 1 < count && touch(slab_above)) slabs.push_back(slab_above + 1);
  for (const std::int32_t s : slabs)
    if (s != slab_below && s != slab_above) imprint(s);
  const detail::SegmentIndex next_index(std::move(next), &listen);
  const double dx = sizes.size, dy = sizes.size * std::sqrt(3.0) / 2, clear = kLatticeFromContour * sizes.size;
  const auto row0 = std::int64_t(std::floor(double(low.y) / dy)), row1 = std::int64_t(std::ceil(double(high.y) / dy));
  const auto column0 = std::int64_t(std::floor(double(low.x) / dx)) - 1,
             column1 = std::int64_t(std::ceil(double(high.x) / dx));
  // Calls f(row, column, point) for the lattice whose spacing is the n-th part.
  const auto for_each_lattice_point = [&](std::int64_t n, auto&& f) {
    constexpr std::int64_t kPollEvery = 4096;  // lattice points, and every row
    for (std::int64_t row = n * row0; row <= n * row1; ++row)
      for (std::int64_t column = n * column0; column <= n * column1; ++column) {
        if (poll && ((column - n * column0) % kPollEvery == 0)) poll();
        const double x = (double(column) + (row % 2 != 0 ? 0.5 : 0)) * dx, y = double(row) * dy;
        f(row, column,
          GridPoint{round_to_step(std::llround(x / double(n))), round_to_step(std::llround(y / double(n)))});
      }
  };
  for_each_lattice_point(1, [&](std::int64_t, std::int64_t, const GridPoint& p) {
    if (own_index.distance(p, clear) >= clear && next_index.distance(p, clear) >= clear) result.push_back(p);
  });
  // Next to narrow bands the lattice of half the spacing, which the coarse one is part of.
  std::vector<const Outline*> outlines;
  outlines.reserve(slabs.size());
  for (const std::int32_t s : slabs) outlines.push_back(&contours.outlines[std::size_t(s)]);
  const detail::NarrowBands bands(outlines, sizes.size, listen);
  if (bands.empty()) return result;
  for_each_lattice_point(2, [&](std::int64_t row, std::int64_t column, const GridPoint& p) {
    if (!bands.is_fine(p)) return;
    const bool coarse = row % 2 == 0 && (column - row / 2) % 2 == 0;
    const double near = std::min(own_index.distance(p, clear), next_index.distance(p, clear));
    if (near >= clear / 2 && !(coarse && near >= clear)) result.push_back(p);
  });
  return result;
}

}  // namespace slice2mesh
