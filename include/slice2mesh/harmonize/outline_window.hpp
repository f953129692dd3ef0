// SPDX-License-Identifier: MIT
/// @file
/// @brief A part of an outline in a rectangle, cut out to be worked on and put back.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <unordered_map>
#include <vector>

#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/arrange/snap_rounding.hpp"
#include "slice2mesh/core/progress.hpp"

namespace slice2mesh::detail {

/// A rectangle in the plane with its border.
struct OutlineWindow {
  GridPoint low{-kGridLimit, -kGridLimit}, high{kGridLimit, kGridLimit};

  [[nodiscard]] bool has(const GridPoint& p) const {
    return low.x <= p.x && p.x <= high.x && low.y <= p.y && p.y <= high.y;
  }
  /// Does it overlap the smallest rectangle around an edge?
  [[nodiscard]] bool may_meet(const GridPoint& a, const GridPoint& b) const {
    return std::min(a.x, b.x) <= high.x && low.x <= std::max(a.x, b.x) && std::min(a.y, b.y) <= high.y &&
           low.y <= std::max(a.y, b.y);
  }
  void add(const GridPoint& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  /// Wider by so many pitches on all sides, within the range of coordinates.
  [[nodiscard]] OutlineWindow grown(double by) const {
    const auto d = static_cast<std::int64_t>(std::ceil(std::min(by, 2 * double(kGridLimit))));
    return {{std::max(low.x - d, -kGridLimit), std::max(low.y - d, -kGridLimit)},
            {std::min(high.x + d, kGridLimit), std::min(high.y + d, kGridLimit)}};
  }
};

/// What of an outline may meet a window, or all else: whole edges, so that vertices in the window have all of theirs.
[[nodiscard]] inline Outline cut(const Outline& outline, const OutlineWindow& window, bool inside,
                                 const std::function<void()>& poll) {
  Poll listen(poll, 1 << 16);
  Outline part;
  std::vector<std::int32_t> index(outline.vertices.size(), kNone);
  const auto vertex = [&](std::int32_t v) {
    std::int32_t& i = index[std::size_t(v)];
    if (i == kNone) {
      i = std::int32_t(part.vertices.size());
      part.vertices.push_back(outline.vertices[std::size_t(v)]);
    }
    return i;
  };
  for (const Outline::Edge& e : outline.edges) {
    listen();
    if (window.may_meet(outline.vertices[std::size_t(e.a)], outline.vertices[std::size_t(e.b)]) != inside) continue;
    const std::int32_t a = vertex(e.a), b = vertex(e.b);
    part.edges.push_back({a, b, e.left, e.right});
  }
  normalize(part, poll);
  return part;
}

/// Puts something else in the place of what of an outline may meet a window: what was cut out there, changed.
inline void put_back(Outline& outline, const OutlineWindow& window, const Outline& part,
                     const std::function<void()>& poll) {
  Outline result = cut(outline, window, false, poll);
  std::unordered_map<GridPoint, std::int32_t, GridHash> index;
  for (const GridPoint& p : result.vertices) index.emplace(p, std::int32_t(index.size()));
  std::vector<std::int32_t> vertex;
  vertex.reserve(part.vertices.size());
  for (const GridPoint& p : part.vertices) {
    const auto [it, added] = index.emplace(p, std::int32_t(result.vertices.size()));
    if (added) result.vertices.push_back(p);
    vertex.push_back(it->second);
  }
  for (const Outline::Edge& e : part.edges)
    result.edges.push_back({vertex[std::size_t(e.a)], vertex[std::size_t(e.b)], e.left, e.right});
  normalize(result, poll);
  outline = std::move(result);
}

}  // namespace slice2mesh::detail
