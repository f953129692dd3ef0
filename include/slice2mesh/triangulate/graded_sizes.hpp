// SPDX-License-Identifier: MIT
/// @file
/// @brief Sizes that grow with the distance from short contour edges and narrow bands, and where they are below a
/// limit.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/arrange/segment_index.hpp"
#include "slice2mesh/arrange/snap_rounding.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/progress.hpp"

namespace slice2mesh::detail {

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

/// A point that elements around it should not be much larger than `size` (pitches) at.
struct SizeSource {
  GridPoint at;
  double size;
  friend bool operator<(const SizeSource& a, const SizeSource& b) {
    return a.size != b.size ? a.size < b.size : a.at < b.at;
  }
};

/// The sources of a plane, the smallest first: at every contour vertex the length of the shortest edge there, and where
/// contours of neighboring slabs run side by side, nearer to each other than `narrow` (pitches), the distance between
/// them. `outlines`: of slabs that follow each other upwards.
[[nodiscard]] inline std::vector<SizeSource> size_sources(const std::vector<const Outline*>& outlines, double narrow,
                                                          Poll& listen) {
  std::vector<SegmentIndex> index;
  index.reserve(outlines.size());
  for (const Outline* outline : outlines) index.emplace_back(*outline, &listen);
  std::vector<SizeSource> sources;
  std::vector<double> shortest;
  for (std::size_t i = 0; i < outlines.size(); ++i) {
    const Outline& outline = *outlines[i];
    shortest.assign(outline.vertices.size(), HUGE_VAL);
    listen(outline.edges.size());
    for (const Outline::Edge& e : outline.edges)
      for (const std::int32_t v : {e.a, e.b})
        shortest[std::size_t(v)] = std::min(
            shortest[std::size_t(v)], distance(outline.vertices[std::size_t(e.a)], outline.vertices[std::size_t(e.b)]));
    for (std::size_t v = 0; v < shortest.size(); ++v) {
      listen();
      const GridPoint& p = outline.vertices[v];
      double size = shortest[v];
      for (const std::size_t other : {i - 1, i + 1}) {
        if (other >= outlines.size()) continue;
        const double width = index[other].distance(p, narrow, &listen);
        // What stands on the other contour is not beside it.
        if (width < narrow && width > kAttachSteps * double(kContourStep)) size = std::min(size, width);
      }
      sources.push_back({p, size});
    }
  }
  sort_listening(sources.begin(), sources.end(), listen);
  return sources;
}

/// Where a size that grows by a share of the distance from its sources is below a limit.
class GradedSizes {
public:
  /// `sources`: the smallest first; of those nearer to each other than `spacing` (pitches, > 0) only the first counts.
  /// `limit`: pitches, > 0. `growth`: that share, > 0.
  GradedSizes(const std::vector<SizeSource>& sources, double limit, double spacing, double growth, Poll& listen)
      : reach_(limit / growth), limit_(limit), growth_(growth) {
    SpacedPoints taken(std::max(1.0, spacing));
    for (const SizeSource& source : sources) {
      listen();
      if (!(source.size < limit)) break;
      if (!taken.clear(source.at, spacing)) continue;
      taken.add(source.at);
      const GridPoint c = cell_of(source.at);
      for (std::int64_t x = c.x - 1; x <= c.x + 1; ++x)
        for (std::int64_t y = c.y - 1; y <= c.y + 1; ++y) near_[{x, y}].push_back(source);
    }
  }
  [[nodiscard]] bool is_below(const GridPoint& p) const {
    const auto it = near_.find(cell_of(p));
    return it != near_.end() && std::any_of(it->second.begin(), it->second.end(), [&](const SizeSource& source) {
             return source.size + growth_ * distance(source.at, p) < limit_;
           });
  }
  /// Squares, of which no two overlap, that hold all of these places: the lower left corners, sorted, in `side()`.
  [[nodiscard]] std::vector<GridPoint> squares(Poll& listen) const {
    std::vector<GridPoint> result;
    result.reserve(near_.size());
    for (const auto& square : near_) {  // in any order
      listen();
      result.push_back(square.first);
    }
    sort_listening(result.begin(), result.end(), listen);
    return result;
  }
  /// Pitches.
  [[nodiscard]] double side() const { return reach_; }

private:
  [[nodiscard]] GridPoint cell_of(const GridPoint& p) const {
    return {std::int64_t(std::floor(double(p.x) / reach_)), std::int64_t(std::floor(double(p.y) / reach_))};
  }
  double reach_, limit_, growth_;
  std::unordered_map<GridPoint, std::vector<SizeSource>, GridHash> near_;  // a square, and what may matter there
};

}  // namespace slice2mesh::detail
