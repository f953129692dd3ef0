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

  /// Are these vertices, on the two planes of a slab, on one of its walls? `on_lower(v)`: is v on the lower plane?
  template <class Vertices, class OnLower>
  [[nodiscard]] bool on_one_wall(const Vertices& vertices, OnLower&& on_lower) const {
    const auto side_of = [&](std::int32_t v) { return on_lower(v) ? Above : Below; };
    // One of them may be the corner of any number of walls.
    std::int32_t first = *std::begin(vertices);
    for (const std::int32_t v : vertices)
      if (walls_at(v, side_of(v)) < walls_at(first, side_of(first))) first = v;
    const Side side = side_of(first);
    for (std::int32_t i = start_[side][std::size_t(first)]; i < start_[side][std::size_t(first) + 1]; ++i)
      if (std::all_of(std::begin(vertices), std::end(vertices), [&](std::int32_t v) {
            const Side at = side_of(v);
            return std::binary_search(walls_[at].begin() + start_[at][std::size_t(v)],
                                      walls_[at].begin() + start_[at][std::size_t(v) + 1],
                                      walls_[side][std::size_t(i)]);
          }))
        return true;
    return false;
  }
  /// There is one vertex more, on no wall.
  void add_vertex() {
    for (std::vector<std::int32_t>& start : start_) start.push_back(start.back());
  }
  /// Puts the last vertex, which was added, on these walls, by `Side`, and takes it off others; kNone: none.
  void put_last(const std::array<std::int32_t, 2>& walls) {
    for (const Side side : {Below, Above}) {
      walls_[side].resize(std::size_t(start_[side][start_[side].size() - 2]));
      if (walls[side] != kNone) walls_[side].push_back(walls[side]);
      start_[side].back() = std::int32_t(walls_[side].size());
    }
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
