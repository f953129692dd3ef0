// SPDX-License-Identifier: MIT
/// @file
/// @brief On which walls the vertices of a stack stand.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/triangulate/plane_stack.hpp"

namespace slice2mesh::detail {

/// The walls over the vertices of every plane, and under them. Vertices of all planes are counted through. It stays
/// true when vertices move, and when one that splits a contour edge goes into a neighbor on that edge.
class WallVertices {
public:
  enum Side : std::uint8_t { Below = 0, Above = 1 };  ///< of the plane, the slab of the wall

  /// `first`: #P, the number of the first vertex of each plane; `vertices`: of all planes.
  WallVertices(const PlaneStack& stack, const std::vector<std::int32_t>& first, std::size_t vertices, Poll listen) {
    for (const Side side : {Below, Above}) {
      std::vector<std::int32_t>& start = start_[side];
      start.assign(vertices + 1, 0);
      for_each(stack, first, side, listen, [&](std::size_t v, std::int32_t) { ++start[v + 1]; });
      for (std::size_t v = 0; v < vertices; ++v) start[v + 1] += start[v];
      walls_[side].resize(std::size_t(start[vertices]));
      std::vector<std::int32_t> next(start.begin(), start.end() - 1);
      for_each(stack, first, side, listen,
               [&](std::size_t v, std::int32_t wall) { walls_[side][std::size_t(next[v]++)] = wall; });
    }
  }

  /// The wall that has the edge uv of a plane in the slab on one side, kNone if there is none. Walls of one slab have
  /// different numbers; a wall has the same number on both of its planes.
  [[nodiscard]] std::int32_t wall_of(std::int32_t u, std::int32_t v, Side side) const {
    // One of them may be the corner of any number of walls.
    if (walls_at(u, side) > walls_at(v, side)) std::swap(u, v);
    const auto begin = walls_[side].begin() + start_[side][std::size_t(v)],
               end = walls_[side].begin() + start_[side][std::size_t(v) + 1];
    for (std::int32_t i = start_[side][std::size_t(u)]; i < start_[side][std::size_t(u) + 1]; ++i)
      if (std::binary_search(begin, end, walls_[side][std::size_t(i)])) return walls_[side][std::size_t(i)];
    return kNone;
  }

private:
  [[nodiscard]] std::int32_t walls_at(std::int32_t v, Side side) const {
    return start_[side][std::size_t(v) + 1] - start_[side][std::size_t(v)];
  }
  template <class Visit>
  static void for_each(const PlaneStack& stack, const std::vector<std::int32_t>& first, Side side, Poll& listen,
                       Visit&& visit) {
    for (std::size_t k = 0; k < stack.meshes.size(); ++k) {
      const auto& chains = side == Above ? stack.meshes[k].above_chain : stack.meshes[k].below_chain;
      for (std::size_t e = 0; e < chains.size(); ++e) {
        listen(chains[e].size());
        for (const std::int32_t v : chains[e]) visit(std::size_t(first[k] + v), std::int32_t(e));
      }
    }
  }

  std::array<std::vector<std::int32_t>, 2> start_, walls_;  // by side; walls at each vertex, ascending
};

}  // namespace slice2mesh::detail
