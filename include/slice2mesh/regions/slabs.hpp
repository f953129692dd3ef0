// SPDX-License-Identifier: MIT
/// @file
/// @brief From slices to slabs: z conventions, layer thickness, bundles of slices.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "slice2mesh/core/diagnostics.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/short_number.hpp"
#include "slice2mesh/core/slab.hpp"
#include "slice2mesh/core/slice_stack.hpp"
#include "slice2mesh/pipeline/options.hpp"

namespace slice2mesh {

/// The slabs of a stack.
struct SlabPlan {
  std::vector<Slab> slabs;                    ///< #S, lowest first; neighbors without a gap share the same double
  ZConvention convention = ZConvention::Top;  ///< what was used; never Auto
  double thickness = 0;                       ///< mm, median of the slabs: the layer thickness h of `Length`
};

namespace detail {

/// Numbers of a file are rounded (3.09998 and 3.10001 are both 3.1), and thickness may vary by a unit. Two heights are
/// the same in the signs of a z convention if they differ by less than this share of the spacing. Signs differ by half
/// a spacing, so that anything well below 0.25 would do.
inline constexpr double kSameHeight = 0.1;
/// A bundle may exceed `lump_thickness` by this share of a layer, for the same reason.
inline constexpr double kLumpSlack = 0.01;

inline bool is_filled(const Layer& layer, bool with_open_lines) {
  for (const Polyline& line : layer.polylines) {
    if (line.direction == Direction::Open ? with_open_lines && !line.points.empty() : line.points.size() >= 3)
      return true;
  }
  return false;
}

inline double lower_median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Chooses the z convention by the signs of formats.md; the second is the reason. z in mm, at least two.
inline std::pair<ZConvention, std::string> choose_convention(const std::vector<double>& z, std::size_t first_filled,
                                                             const SliceStack& stack) {
  const double step = z[1] - z[0];
  const auto same = [&](double a, double b) { return std::abs(a - b) <= kSameHeight * step; };
  const std::string first = "the first slice is at z = " + short_number(z[0]) + " mm";
  const std::string spacing = "the spacing (" + short_number(step) + " mm)";
  if (same(z[0], step / 2)) return {ZConvention::Middle, first + ", half of " + spacing};
  if (first_filled > 0) return {ZConvention::Top, "the first " + std::to_string(first_filled) + " slices are empty"};
  if (same(z[0], 0)) return {ZConvention::Bottom, first + " and has geometry"};
  if (same(z[0], step)) return {ZConvention::Top, first + ", equal to " + spacing};
  const std::string other = first + ", neither 0 nor half of nor equal to " + spacing;
  if (stack.dimension && (*stack.dimension)[5] > (*stack.dimension)[2]) {
    const double low = (*stack.dimension)[2];
    const double high = (*stack.dimension)[5];
    const double last_step = z[z.size() - 1] - z[z.size() - 2];
    const auto box = [&](double below, double above) {
      return same(low, z.front() - below) && std::abs(high - (z.back() + above)) <= kSameHeight * last_step;
    };
    if (box(step, 0)) return {ZConvention::Top, other + "; the box of the header agrees"};
    if (box(0, last_step)) return {ZConvention::Bottom, other + "; the box of the header agrees"};
    if (box(step / 2, last_step / 2)) return {ZConvention::Middle, other + "; the box of the header agrees"};
  }
  const double phase = z[0] / step - std::floor(z[0] / step);
  if (std::abs(phase - 0.5) <= kSameHeight)
    return {ZConvention::Middle, other + ", but half a spacing off its multiples"};
  return {ZConvention::Top, other + "; the upper surface is what the format describes"};
}

/// The same for a single slice, of a given thickness (mm) or of an unknown one (0).
inline std::pair<ZConvention, std::string> choose_convention_of_one(double z, double thickness) {
  const std::string one = "there is one slice only, at z = " + short_number(z) + " mm";
  if (thickness <= 0) return {ZConvention::Top, one + ", which is taken as its thickness"};
  const auto same = [&](double a) { return std::abs(z - a) <= kSameHeight * thickness; };
  if (same(0)) return {ZConvention::Bottom, one};
  if (same(thickness / 2)) return {ZConvention::Middle, one + ", half of the thickness"};
  return {ZConvention::Top, one};
}

/// The planes between the slices, in mm: slice i lies between planes i and i+1. #slices + 1, ascending; for Paper the
/// last slice has no upper plane, so that there are only #slices. `single` is the thickness of a single slice, mm.
inline std::vector<double> slice_planes(const std::vector<double>& z, ZConvention convention, double single) {
  const std::size_t n = z.size();
  std::vector<double> planes;
  if (n == 1) {
    if (convention == ZConvention::Top)
      planes = {std::abs(z[0] - single) <= kSameHeight * single ? 0 : z[0] - single, z[0]};
    else if (convention == ZConvention::Bottom)
      planes = {z[0], z[0] + single};
    else
      planes = {z[0] - single / 2, z[0] + single / 2};
    return planes;
  }
  planes.reserve(n + 1);
  switch (convention) {
    case ZConvention::Auto:
    case ZConvention::Top: {
      // A first layer may be thinner or thicker than the others: up to one and a half spacings it stands on the plate.
      const double step = z[1] - z[0];
      planes.push_back(z[0] > 0 && z[0] <= 1.5 * step ? 0 : z[0] - step);
      planes.insert(planes.end(), z.begin(), z.end());
      break;
    }
    case ZConvention::Bottom:
      planes = z;
      planes.push_back(z[n - 1] + (z[n - 1] - z[n - 2]));
      break;
    case ZConvention::Middle: {
      const double first = (z[0] + z[1]) / 2;
      const double step = z[1] - z[0];
      planes.push_back(std::abs(z[0] - step / 2) <= kSameHeight * step ? 0 : z[0] - (first - z[0]));
      for (std::size_t i = 1; i < n; ++i) planes.push_back((z[i - 1] + z[i]) / 2);
      planes.push_back(z[n - 1] + (z[n - 1] - planes.back()));
      break;
    }
    case ZConvention::Paper: planes = z; break;
  }
  return planes;
}

inline void check_slab_options(const SlabOptions& options) {
  switch (options.z_convention) {
    case ZConvention::Auto:
    case ZConvention::Top:
    case ZConvention::Bottom:
    case ZConvention::Middle:
    case ZConvention::Paper: break;
    default: throw OptionError("z_convention", "is not one of auto, top, bottom, middle, paper");
  }
  if (options.lump < 1) throw OptionError("lump", "must be at least 1");
  if (!(options.lump_thickness >= 0) || !std::isfinite(options.lump_thickness))
    throw OptionError("lump_thickness", "must be a finite number of mm, at least 0");
  if (!(options.thickness >= 0) || !std::isfinite(options.thickness))
    throw OptionError("thickness", "must be a finite number of mm, at least 0");
}

}  // namespace detail

/// Make the slabs of a stack: N filled slices give N slabs (without bundles).
///
/// A slice is filled if it has a contour of three points or, with `with_open_lines`, an open line; hatches do not
/// count. Empty slices give the thickness of their neighbors and leave gaps between slabs.
/// * Convention Top: a slab reaches from the z of the slice below to that of its own; the first one down to z = 0 if it
///   is at most one and a half spacings above it, else by one spacing. Bottom: from its z to the next; the last one by
///   the spacing before. Middle: planes halfway between slices; the first and last slab are symmetric to their z, and a
///   first slab that begins within a tenth of a spacing of z = 0 begins at 0. Paper: like Bottom, without the last
///   slice of the file. Auto chooses and says why (diagnostic `z_convention`).
/// * Slabs that follow each other without a gap share the same plane, bit by bit.
/// * Bundles: from the first filled slice on, `lump` slices (or as many as `lump_thickness` allows, at least one) make
///   one slab, empty ones counted; the last bundle may be smaller. Empty slices at the ends of a bundle are not part of
///   its slab. The middle slice, first + (last - first) / 2, stands for the bundle, or the filled one nearest to it
///   (the lower of two).
/// * One single slice: `thickness`, or its z (Top; Auto chooses that), or twice its z (Middle).
///
/// Precondition: z finite and ascending (GeometryError with the layer otherwise).
/// Errors: OptionError; GeometryError if no slice is filled or a single slice does not tell its thickness.
/// Diagnostics: `z_convention`, `paper_drops_last`, `empty_slices_between`, `thickness_varies`. Cost: linear.
[[nodiscard]] inline SlabPlan make_slabs(const SliceStack& stack, const SlabOptions& options,
                                         Diagnostics& diagnostics) {
  detail::check_slab_options(options);
  if (!(stack.z_unit > 0) || !std::isfinite(stack.z_unit))
    throw GeometryError(Stage::Regions, -1, -1, "the z unit of the stack is not a positive number");
  const std::size_t n = stack.layers.size();
  std::vector<double> z(n);
  std::vector<bool> filled(n);
  std::size_t first = n;
  std::size_t last = n;
  for (std::size_t i = 0; i < n; ++i) {
    z[i] = stack.layers[i].z * stack.z_unit;
    if (!std::isfinite(z[i])) throw GeometryError(Stage::Regions, static_cast<std::int64_t>(i), -1, "z is not finite");
    if (i > 0 && !(z[i] > z[i - 1]))
      throw GeometryError(Stage::Regions, static_cast<std::int64_t>(i), -1, "z is not above that of the layer before");
    filled[i] = detail::is_filled(stack.layers[i], options.with_open_lines);
    if (filled[i]) {
      if (first == n) first = i;
      last = i;
    }
  }
  if (first == n)
    throw GeometryError(Stage::Regions, -1, -1,
                        n == 0 ? "there are no layers" : "no layer has a contour or a line: there is nothing to mesh");

  SlabPlan plan;
  plan.convention = options.z_convention;
  std::string reason = "as the options say";
  double single = options.thickness;
  if (n == 1) {
    if (plan.convention == ZConvention::Paper)
      throw GeometryError(Stage::Regions, 0, -1,
                          "the convention paper drops the last slice, and there is no other one");
    if (plan.convention == ZConvention::Auto) {
      std::tie(plan.convention, reason) = detail::choose_convention_of_one(z[0], single);
    }
    if (single <= 0 && plan.convention == ZConvention::Top) single = z[0];
    if (single <= 0 && plan.convention == ZConvention::Middle) single = 2 * z[0];
    if (!(single > 0))
      throw GeometryError(Stage::Regions, 0, -1,
                          "there is one slice only, at z = " + detail::short_number(z[0]) +
                              " mm, and nothing says how thick it is (option thickness)");
  } else if (plan.convention == ZConvention::Auto) {
    std::tie(plan.convention, reason) = detail::choose_convention(z, first, stack);
  }
  diagnostics.add(Severity::Note, Stage::Regions, "z_convention",
                  std::string(to_string(plan.convention)) + ": " + reason);
  if (plan.convention == ZConvention::Paper && last == n - 1) {
    diagnostics.add(Severity::Warning, Stage::Regions, "paper_drops_last",
                    "the last slice is dropped, as in the reference implementation", static_cast<std::int64_t>(last));
    while (last > first && (last == n - 1 || !filled[last])) --last;
    if (last == n - 1) throw GeometryError(Stage::Regions, 0, -1, "only the last slice is filled, and it is dropped");
  }

  const std::vector<double> planes = detail::slice_planes(z, plan.convention, single);
  for (std::size_t i = first; i <= last; ++i)
    if (!(planes[i + 1] > planes[i]) || !std::isfinite(planes[i + 1]) || !std::isfinite(planes[i]))
      throw GeometryError(Stage::Regions, static_cast<std::int64_t>(i), -1, "the layer has no thickness");

  const double slice_thickness = [&] {
    std::vector<double> values;
    for (std::size_t i = first; i <= last; ++i) values.push_back(planes[i + 1] - planes[i]);
    return detail::lower_median(std::move(values));
  }();
  const double most = options.lump_thickness + detail::kLumpSlack * slice_thickness;
  const auto bundle_end = [&](std::size_t begin) {  // the last slice of the bundle
    if (options.lump_thickness <= 0) {
      const auto lump = static_cast<std::size_t>(options.lump);
      return last - begin < lump ? last : begin + lump - 1;
    }
    std::size_t end = begin;
    while (end < last && planes[end + 2] - planes[begin] <= most) ++end;
    return end;
  };

  std::uint64_t empty = 0;
  std::vector<double> heights;
  for (std::size_t begin = first; begin <= last;) {
    const std::size_t end = bundle_end(begin);
    std::size_t low = begin;
    std::size_t high = end;
    while (low <= end && !filled[low]) ++low;
    while (high > begin && !filled[high]) --high;
    for (std::size_t i = begin; i <= end; ++i) empty += filled[i] ? 0u : 1u;
    begin = end + 1;
    if (low > end) continue;
    const std::size_t middle = low + (high - low) / 2;
    std::size_t slice = middle;  // NOLINT(clang-analyzer-deadcode.DeadStores): compilers ask for a value here
    for (std::size_t d = 0;; ++d) {
      if (middle - low >= d && filled[middle - d])
        slice = middle - d;
      else if (middle + d <= high && filled[middle + d])
        slice = middle + d;
      else
        continue;
      break;
    }
    Slab slab;
    slab.z_low = planes[low];
    slab.z_high = planes[high + 1];
    slab.first_layer = static_cast<std::int32_t>(low);
    slab.last_layer = static_cast<std::int32_t>(high);
    slab.slice = static_cast<std::int32_t>(slice);
    heights.push_back(slab.z_high - slab.z_low);
    plan.slabs.push_back(slab);
  }
  plan.thickness = detail::lower_median(heights);
  if (empty > 0)
    diagnostics.add(Severity::Warning, Stage::Regions, "empty_slices_between",
                    std::to_string(empty) + " empty slices lie between filled ones", -1, -1, empty);
  const auto [thinnest, thickest] = std::minmax_element(heights.begin(), heights.end());
  if (*thickest > (1 + detail::kSameHeight) * *thinnest)
    diagnostics.add(
        Severity::Note, Stage::Regions, "thickness_varies",
        "slabs are " + detail::short_number(*thinnest) + " to " + detail::short_number(*thickest) + " mm thick");
  return plan;
}

}  // namespace slice2mesh
