// SPDX-License-Identifier: MIT
/// @file
/// @brief Interior vertices of the planes: one graded lattice for all of them, and the contours of the planes next to
/// them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/segment_index.hpp"
#include "slice2mesh/arrange/size_field.hpp"
#include "slice2mesh/arrange/snap_rounding.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/core/slab.hpp"
#include "slice2mesh/harmonize/harmonize.hpp"
#include "slice2mesh/triangulate/graded_sizes.hpp"

namespace slice2mesh {

/// Sizes for interior vertices, in pitches.
struct InteriorSizes {
  double size = 0;                           ///< pitches, > 0: spacing of the lattice
  double contour_size = 0;                   ///< pitches, > 0: spacing along contours
  double growth = 0.5;                       ///< > 0, ratio of the growth of sizes to the distance from contours
  const detail::SizeField* field = nullptr;  ///< where points are nearer to each other than that
  std::size_t most = 0;                      ///< vertices that the plane may have; 0: any number
};

/// Candidates for the interior vertices of the plane between the slabs of index `slab_below` and `slab_above` (kNone:
/// none): any number. A pure function of the contours of these slabs and the next ones. Neighboring planes get the same
/// points wherever all their contours are far enough, and a field does not depend on the height. Errors: BudgetError,
/// OptionError of the field. `poll` is called now and then; what it throws ends the work. Precondition: the indices are
/// slabs of the contours, the sizes above 0 (not checked). Cost: O(n log n).
[[nodiscard]] inline std::vector<GridPoint> interior_points(const Contours& contours, std::int32_t slab_below,
                                                            std::int32_t slab_above, const InteriorSizes& asked,
                                                            const std::function<void()>& poll = {}) {
  // No two points are farther apart than the grid is wide: larger sizes mean the same, and fit the integers.
  constexpr double kLargest = 4 * static_cast<double>(kGridLimit);
  InteriorSizes sizes = asked;
  sizes.size = std::min(asked.size, kLargest);
  sizes.contour_size = std::min(asked.contour_size, kLargest);
  std::vector<GridPoint> result;
  const auto count = static_cast<std::int32_t>(contours.slabs.size());
  const auto touch = [&](std::int32_t s) {  // slab s touches slab s + 1
    return detail::lies_on_last(contours.slabs, std::size_t(s) + 1);
  };
  std::vector<std::pair<GridPoint, GridPoint>> own;
  GridPoint low{kGridLimit, kGridLimit}, high{-kGridLimit, -kGridLimit};
  double thickness = 0;  // pitches, of the thicker slab
  double z = 0;          // mm
  for (const std::int32_t s : {slab_below, slab_above}) {
    if (s == kNone) continue;
    const Slab& slab = contours.slabs[std::size_t(s)];
    thickness = std::max(thickness, (slab.z_high - slab.z_low) / contours.grid.pitch);
    z = s == slab_below ? slab.z_high : slab.z_low;
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

  // The lattice of spacing l, and that of l/2, which has the first one in it.
  // Some of the points are outside of the material: only what is far too much is told from a budget here.
  constexpr std::size_t kAtOnce = 10000000, kMost = INT32_MAX;
  const std::size_t most = sizes.most > 0 ? std::min(kMost, std::max(kAtOnce, sizes.most)) : kMost;
  constexpr double kFromContour = 0.7;  // of the spacing: nearer to contours there is no lattice point
  std::unordered_set<GridPoint, GridHash> chosen;
  // Chooses from the lattice of l/n what lies in low <= x < high, in y likewise, where `fits(point)`.
  const auto choose = [&](double n, double low_x, double low_y, double high_x, double high_y, auto&& fits) {
    const double dx = sizes.size, dy = sizes.size * std::sqrt(3.0) / 2, clear = kFromContour * sizes.size / n;
    for (auto row = std::int64_t(std::ceil(low_y * n / dy)); double(row) * dy < high_y * n; ++row) {
      const double shift = row % 2 != 0 ? 0.5 : 0;
      listen();
      for (auto column = std::int64_t(std::ceil(low_x * n / dx - shift)); (double(column) + shift) * dx < high_x * n;
           ++column) {
        listen();
        const GridPoint p{round_to_step(std::llround((double(column) + shift) * dx / n)),
                          round_to_step(std::llround(double(row) * dy / n))};
        if (fits(p) && own_index.distance(p, clear) >= clear && next_index.distance(p, clear) >= clear &&
            chosen.insert(p).second) {
          result.push_back(p);
          if (result.size() > most)
            throw BudgetError(Stage::Triangulate, "sizes ask for more vertices in a plane than " +
                                                      std::string(sizes.most > 0 ? "max_vertices" : "2^31"));
        }
      }
    }
  };
  choose(1, double(low.x), double(low.y), double(high.x), double(high.y), [](const GridPoint&) { return true; });
  constexpr double kFineBelow = 0.8;  // of the coarser spacing: the size up to which the finer lattice is used
  if (sizes.field) {
    // Lattices of l/2, l/4, ...: in squares of twice their spacing, where the size may be so small in one of them.
    struct Square {
      double x, y;
    };
    constexpr double kSteepest = 0.5;  // change of a field over the distance, unless it grows faster from balls
    const double steepest = std::max(kSteepest, sizes.growth);
    const detail::SizeField& field = *sizes.field;
    std::vector<Square> squares, smaller;
    const auto add = [&](std::vector<Square>& to, const Square& q, double side) {
      listen();
      const double center = field.wanted_at(q.x + side / 2, q.y + side / 2, z);
      if (center - steepest * side * std::sqrt(0.5) < kFineBelow * side) to.push_back(q);
    };
    double side = sizes.size;
    for (double y = std::floor(double(low.y) / side) * side; y < double(high.y); y += side)
      for (double x = std::floor(double(low.x) / side) * side; x < double(high.x); x += side)
        add(squares, {x, y}, side);
    for (double n = 2; !squares.empty(); n *= 2, side /= 2, squares.swap(smaller)) {
      const double limit = kFineBelow * side;
      smaller.clear();
      for (const Square& q : squares) {
        choose(n, q.x, q.y, q.x + side, q.y + side, [&](const GridPoint& p) { return field.wanted_at(p, z) < limit; });
        for (const double dx : {0.0, side / 2})
          for (const double dy : {0.0, side / 2}) add(smaller, {q.x + dx, q.y + dy}, side / 2);
      }
    }
  }
  // The finer one where sizes that grow from the contours are still small. Elements narrower than they are high would
  // be no better.
  constexpr double kNarrow = 0.15;     // of l: bands between two contours below this width count
  constexpr double kSources = 0.1;     // of l: sources nearer to each other than this are one
  constexpr double kNarrowest = 0.75;  // of the thickness: least spacing of the finer lattice
  if (sizes.size / 2 < kNarrowest * thickness) return result;
  std::vector<const Outline*> outlines;
  outlines.reserve(slabs.size());
  for (const std::int32_t s : slabs) outlines.push_back(&contours.outlines[std::size_t(s)]);
  const detail::GradedSizes graded(detail::size_sources(outlines, kNarrow * sizes.size, listen),
                                   kFineBelow * sizes.size, kSources * sizes.size, sizes.growth, listen);
  const double side = graded.side();
  for (const GridPoint& square : graded.squares(listen)) {
    const double x = double(square.x) * side, y = double(square.y) * side;
    choose(2, x, y, x + side, y + side, [&](const GridPoint& p) { return graded.is_below(p); });
  }
  return result;
}

}  // namespace slice2mesh
