// SPDX-License-Identifier: MIT
/// @file
/// @brief Harmonized contours: a slab differs from the slab below only where the difference is wide enough to mesh.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/arrange/segment_index.hpp"
#include "slice2mesh/arrange/size_field.hpp"
#include "slice2mesh/core/diagnostics.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/core/size_function.hpp"
#include "slice2mesh/harmonize/adopt.hpp"
#include "slice2mesh/harmonize/anticipate.hpp"
#include "slice2mesh/harmonize/attach.hpp"
#include "slice2mesh/harmonize/columns.hpp"
#include "slice2mesh/harmonize/corner_search.hpp"
#include "slice2mesh/harmonize/pockets.hpp"
#include "slice2mesh/harmonize/simplify.hpp"
#include "slice2mesh/harmonize/subdivide.hpp"
#include "slice2mesh/regions/regions.hpp"

namespace slice2mesh {

/// Options of harmonization, in mm.
struct HarmonizeOptions {
  double eps = 0;  ///< mm, >= 0: largest deviation from the input, both ways; 0: exact mode, contours stay as they are
  double contour_size = 0;  ///< mm, >= 0: longest edge of a contour; 0: no limit
  /// Longest edge at a place, x, y, z and result in mm, above 0; where it is less than `contour_size`, edges are split
  /// in the end.
  SizeFunction size_at;
  /// Merge contour vertices that are close, in all slabs (with eps and contour_size above 0).
  bool merge_columns = true;
  /// Open sharp corners between contours of neighboring slabs, as far as eps allows it (where columns are merged).
  bool open_corners = true;
};

/// The contours of all slabs, harmonized.
struct Contours {
  /// The grid of the outlines.
  Grid grid;
  std::vector<Slab> slabs;        ///< #S
  std::vector<Outline> outlines;  ///< #S
  std::vector<Region> regions;    ///< #R
  std::vector<double> deviation;  ///< #S, mm: Hausdorff distance to the input slice, both ways
  double thickness = 0;           ///< median of the slabs, mm
  double eps = 0;                 ///< mm, as asked for; 0: exact mode
  bool corners_opened = false;    ///< sharp corners between them are opened; improvement makes none
  double tolerance = 0;           ///< mm, in force: eps, or the smallest tolerance of the grid
  /// As chosen by make_slabs.
  ZConvention z_convention = ZConvention::Bottom;
};

namespace detail {

/// The smallest tolerance in pitches: 2^-20 of the extent of the part. Pockets narrower than this cannot be meshed
/// conformingly in double coordinates: at the tip of one of 10^-6 of its length, the place where a contour edge has to
/// be split so that neither contour has a point in a diametral disc of the other lies between two grid points. Exact
/// mode closes them too.
inline constexpr double kSmallestEps = 1048576;

/// Shares of eps. What simplification and the dropped differences cost together stays below 1; the measured deviation
/// is checked all the same.
inline constexpr double kOpeningShare = 0.85;        // differences narrower than this go
inline constexpr double kAheadShare = 0.75;          // contours go ahead of their slices by up to this
inline constexpr double kSimplifyShare = 0.1;        // tolerance of simplification
inline constexpr double kShortEdgeShare = 0.9;       // edges shorter than this are worth ...
inline constexpr double kShortToleranceShare = 0.3;  // ... this tolerance
inline constexpr double kSnapShare = 0.45;           // vertices this near to one below move onto it
/// What simplification and merging after the opening have moved is compared with the contour below once more, where
/// nothing else does that: contours that settle are compared with their neighbors again.
inline constexpr int kPasses = 2, kPassesBeforeSettling = 1;
inline constexpr double kAdoptShare = 0.8;   // a contour takes the way of a neighbor that is this near to its slice
inline constexpr int kSettleRounds = 2;      // of adopting and merging
inline constexpr double kColumnShare = 2.0;  // columns nearer than this are merged ...
inline constexpr double kColumnDeviation = 0.97;  // ... within this deviation ...
inline constexpr double kColumnMost = 0.995;      // ... or this one where there was more before ...
inline constexpr double kClearanceShare = 1.0;    // ... and not if a vertex gets nearer than this to an edge
inline constexpr double kApartShare = 2.1;        // columns nearer than this to something are moved away from it
inline constexpr double kWallsApartShare = 1.1;   // ... and straight walls bent for that only below this
// Where corners are opened: edges shorter than this go if they can, ...
inline constexpr double kTidyShare = 4;
inline constexpr double kCornerClearance = 0.5;    // ... vertices keep this distance from edges, ...
inline constexpr double kCornerApart = 1.2;        // ... and this one from each other
inline constexpr double kSplitClearance = 0.5;     // where sizes say so, no vertex is put nearer to another contour
inline constexpr double kResolutionShare = 0.005;  // resolution of the measured deviation ...
inline constexpr double kFineShare = 0.0001;       // ... and where that does not tell it from eps

/// The contour of a slab that has nothing to be harmonized with.
[[nodiscard]] inline Outline prepare(const Outline& input, double eps, const std::function<void()>& poll) {
  Outline outline = input;
  simplify(outline, {}, {kSimplifyShare * eps, kShortEdgeShare * eps, kShortToleranceShare * eps, HUGE_VAL}, poll);
  normalize(outline, poll);
  return outline;
}

/// The deviation of an outline from its slice in pitches, not above the true one by more than a share of eps.
/// `slice_index` is that of `slice`.
[[nodiscard]] inline double measured_deviation(const Outline& outline, const Outline& slice,
                                               const SegmentIndex& slice_index, double eps,
                                               const std::function<void()>& poll) {
  const double coarse = deviation(outline, slice, slice_index, kResolutionShare * eps, poll);
  if (coarse <= eps || coarse > (1 + kResolutionShare) * eps) return coarse;
  return deviation(outline, slice, slice_index, kFineShare * eps, poll);
}

[[nodiscard]] inline double measured_deviation(const Outline& outline, const Outline& slice, double eps,
                                               const std::function<void()>& poll) {
  Poll listen(poll, 1 << 14);
  return measured_deviation(outline, slice, SegmentIndex(slice, &listen), eps, poll);
}

/// Contours were made from the lowest slab up, each from the one below and what its slice needs; what the slabs above
/// would have liked was not known. Now it is: from the highest slab down, and up again, every contour takes the way of
/// its neighbor wherever its slice allows it. What two neighbors differ by never gets larger in all: where the
/// one on the other side had the old way, the difference is found there instead.
inline void adopt_ways(Contours& contours, const LayerRegions& input, double eps, double longest,
                       const Progress& progress) {
  const std::size_t count = contours.slabs.size();
  const auto regions = std::int32_t(contours.regions.size());
  const std::function<void()> poll = [&] { report(progress, Stage::Harmonize, 1); };
  const auto take_over = [&](std::size_t s, std::size_t neighbor) {
    poll();
    const std::size_t upper = std::max(s, neighbor);
    if (!lies_on_last(contours.slabs, upper)) return;
    const Outline &own = contours.outlines[s], &other = contours.outlines[neighbor];
    if (own == other) return;
    Poll listen(poll, 1 << 14);
    const SegmentIndex other_index(other, &listen);
    SliceNearness slice(input.outlines[s], &listen);
    Outline outline = adopt_ways(own, other, other_index, slice, regions, kAdoptShare * eps, longest, poll);
    if (outline == own) return;
    attach_vertices(outline, regions, poll);
    subdivide(outline, longest, poll);
    normalize(outline, poll);
    if (outline == own) return;
    const double measured = measured_deviation(outline, input.outlines[s], slice.index(), eps, poll);
    if (measured > kColumnDeviation * eps && measured * contours.grid.pitch > contours.deviation[s]) return;
    contours.deviation[s] = measured * contours.grid.pitch;
    contours.outlines[s] = std::move(outline);
  };
  for (std::size_t s = count; s-- > 1;) take_over(s - 1, s);
  for (std::size_t s = 1; s < count; ++s) take_over(s, s - 1);
}

/// Changes the contours by `change(outlines, frozen, changed, poll)`, and measures the deviation of the slabs that are
/// then marked in `changed`. Slabs that are then too far from their slices are left out of it, and all is done again.
/// False if that does not help.
template <class F>
[[nodiscard]] bool change_columns(Contours& contours, const LayerRegions& input, double eps, const Progress& progress,
                                  F&& change) {
  std::vector<char> frozen(contours.outlines.size(), 0), changed;
  constexpr int kAttempts = 4;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    std::vector<Outline> outlines = contours.outlines;
    const std::function<void()> poll = [&] { report(progress, Stage::Harmonize, 1); };
    change(outlines, frozen, changed, poll);
    poll();  // what it had takes its time to go
    std::vector<double> deviations = contours.deviation;
    bool good = true;
    for (std::size_t s = 0; s < outlines.size(); ++s) {
      if (!changed[s]) continue;
      attach_vertices(outlines[s], std::int32_t(contours.regions.size()), poll);
      const double measured = measured_deviation(outlines[s], input.outlines[s], eps, poll);
      deviations[s] = measured * contours.grid.pitch;
      if (measured <= eps) continue;
      frozen[s] = 1;
      good = false;
    }
    if (!good) continue;
    contours.outlines = std::move(outlines);
    contours.deviation = std::move(deviations);
    return true;
  }
  return false;
}

/// Merges contour vertices that are near to each other in all slabs, or moves them apart (see ColumnMerger).
inline void merge_columns(Contours& contours, const LayerRegions& input, double eps, double longest,
                          Diagnostics& diagnostics, const Progress& progress) {
  if (!(longest < double(kGridLimit))) return;
  const ColumnLimits limits{
      kColumnShare * eps, kColumnDeviation * eps, kColumnMost * eps, kClearanceShare * eps, longest,
      kApartShare * eps,  kWallsApartShare * eps};
  const auto merge = [&](std::vector<Outline>& outlines, const std::vector<char>& frozen, std::vector<char>& changed,
                         const std::function<void()>& poll) {
    ColumnMerger(outlines, input.outlines, contours.slabs, frozen, limits, poll).run(changed, poll);
  };
  if (!change_columns(contours, input, eps, progress, merge))
    diagnostics.add(Severity::Note, Stage::Harmonize, "columns_not_merged",
                    "contour vertices are not merged over the slabs: slabs got too far from their slices");
}

/// Limits in force where corners are opened.
[[nodiscard]] inline ColumnLimits corner_limits(double eps, double longest) {
  return {kTidyShare * eps,
          kColumnDeviation * eps,
          kColumnMost * eps,
          kCornerClearance * eps,
          longest,
          kCornerApart * eps,
          0,
          kSeparationShare * eps};
}
/// Opens sharp corners between the contours of neighboring slabs (see CornerSearch).
inline void open_corners(Contours& contours, const LayerRegions& input, double eps, double longest,
                         Diagnostics& diagnostics, const Progress& progress) {
  if (!(longest < double(kGridLimit))) return;
  const ColumnLimits limits = corner_limits(eps, longest);
  const auto open = [&](std::vector<Outline>& outlines, const std::vector<char>& frozen, std::vector<char>& changed,
                        const std::function<void()>& poll) {
    CornerSearch(outlines, input.outlines, contours.slabs, frozen, limits).run(changed, poll);
  };
  if (!change_columns(contours, input, eps, progress, open))
    diagnostics.add(Severity::Note, Stage::Harmonize, "corners_not_opened",
                    "sharp corners between contours are not opened: slabs got too far from their slices");
}

}  // namespace detail

/// Harmonizes the regions of all slabs from the lowest up: where a slab differs from the one below by less than eps, it
/// gets the contour of the one below; where it differs by more, it keeps its own.
///
/// Postcondition: the deviation of every slab from its input, measured both ways, is at most eps. A slab for which the
/// usual shares of eps would exceed that is done again with smaller ones, in the end with its input as it is.
/// With eps = 0 (exact mode) only pockets below the smallest tolerance are closed, 2^-20 of the extent. Slabs that do
/// not touch the slab below start anew. Errors: OptionError for an eps that is not finite and 0 or more; Cancelled, or
/// whatever `progress` throws. Cost: O(n log n) per slab.
[[nodiscard]] inline Contours harmonize(const LayerRegions& input, const HarmonizeOptions& options,
                                        Diagnostics& diagnostics, const Progress& progress = {}) {
  if (!(options.eps >= 0) || !std::isfinite(options.eps))
    throw OptionError("eps", "must be a finite length, 0 or more");
  Contours result;
  result.grid = input.grid;
  result.slabs = input.slabs;
  result.regions = input.regions;
  result.thickness = input.thickness;
  result.eps = options.eps;
  result.z_convention = input.z_convention;
  // Nothing is farther apart than the grid is wide: a larger tolerance means the same, and fits the integers.
  const double eps =
      std::clamp(options.eps / input.grid.pitch, detail::kSmallestEps, 4 * static_cast<double>(kGridLimit));
  result.tolerance = eps * input.grid.pitch;
  if (options.eps > 0 && options.eps / input.grid.pitch < detail::kSmallestEps)
    diagnostics.add(Severity::Warning, Stage::Harmonize, "eps_too_small",
                    "eps is below what can be told apart in double precision; 2^-20 of the extent is used instead");
  const double finest = options.contour_size > 0 ? options.contour_size / input.grid.pitch : HUGE_VAL;
  // Edges that are short against eps are merged as fast as they are made: finer pieces are made in the end.
  const double longest = std::max(finest, eps);
  const bool settle = options.eps > 0 && options.merge_columns;
  detail::SlabsAhead ahead(input);
  for (std::size_t s = 0; s < input.slabs.size(); ++s) {
    const std::function<void()> poll = [&] {
      report(progress, Stage::Harmonize, double(s) / double(input.slabs.size()));
    };
    poll();
    const Outline& own = input.outlines[s];
    const bool stacked = detail::lies_on_last(input.slabs, s);
    detail::Poll listen(poll, 1 << 14);
    const detail::SegmentIndex below(stacked ? result.outlines[s - 1] : Outline{}, &listen);
    const detail::SegmentIndex own_index(own, &listen);
    Outline outline;
    double deviation = 0;
    double share = 1;
    for (int attempt = 0;; ++attempt, share *= 0.85) {
      if (attempt == 8) {
        outline = own;
        deviation = 0;
        diagnostics.add(Severity::Warning, Stage::Harmonize, "not_harmonized",
                        "the slice could not be harmonized within eps and is used as it is", input.slabs[s].slice);
        break;
      }
      outline = detail::prepare(own, share * eps, poll);
      if (options.eps > 0) {
        detail::subdivide(outline, longest, poll);
        detail::anticipate(outline, stacked ? &below : nullptr, ahead, s, share * eps * detail::kOpeningShare,
                           share * eps * detail::kAheadShare, poll);
      }
      if (stacked) {
        detail::snap_vertices(outline, result.outlines[s - 1], detail::kSnapShare * share * eps, poll);
        const detail::SimplifyLimits limits{detail::kSimplifyShare * share * eps, detail::kShortEdgeShare * share * eps,
                                            detail::kShortToleranceShare * share * eps, longest};
        for (int pass = 0; pass < (settle ? detail::kPassesBeforeSettling : detail::kPasses); ++pass)
          outline = detail::open_difference(
              outline, result.outlines[s - 1], below, static_cast<std::int32_t>(input.regions.size()),
              share * eps * detail::kOpeningShare, limits,
              options.eps > 0 ? detail::BandSplits::All : detail::BandSplits::AtCuts, poll);
      } else {
        // As open_difference does at its end, so that the same slice gets the same contour wherever it is.
        detail::simplify(outline, {}, {double(kContourStep), 0, 0, longest}, poll);
        detail::normalize(outline, poll);
      }
      detail::attach_vertices(outline, static_cast<std::int32_t>(input.regions.size()), poll);
      deviation = detail::measured_deviation(outline, own, own_index, eps, poll);
      if (deviation <= eps) break;
      diagnostics.add(Severity::Note, Stage::Harmonize, "harmonized_again",
                      "deviation of " + std::to_string(deviation / eps) + " eps; done again with a smaller share",
                      input.slabs[s].slice);
    }
    detail::subdivide(outline, longest, poll);
    detail::normalize(outline, poll);
    result.deviation.push_back(deviation * input.grid.pitch);
    result.outlines.push_back(std::move(outline));
  }
  if (settle) {
    // What is merged leaves other ways to be adopted, and those other columns to be merged.
    for (int round = 0; round < detail::kSettleRounds; ++round) {
      detail::adopt_ways(result, input, eps, longest, progress);
      detail::merge_columns(result, input, eps, longest, diagnostics, progress);
    }
    if (options.open_corners) {
      detail::open_corners(result, input, eps, longest, diagnostics, progress);
      result.corners_opened = true;
    }
  }
  if (finest < longest)
    for (Outline& outline : result.outlines) {
      const std::function<void()> poll = [&] { report(progress, Stage::Harmonize, 1); };
      poll();
      detail::subdivide(outline, finest, poll);
      detail::normalize(outline, poll);
    }
  if (options.size_at) {
    const double begin = std::isfinite(finest) ? finest : detail::largest_extent(result.outlines);
    detail::subdivide_by_field(result.outlines, result.slabs, begin, detail::kSplitClearance * eps,
                               detail::SizeField(options.size_at, result.grid, detail::smallest_size(result.outlines)),
                               [&] { report(progress, Stage::Harmonize, 1); });
  }
  report(progress, Stage::Harmonize, 1);
  return result;
}

}  // namespace slice2mesh
