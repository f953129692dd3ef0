// SPDX-License-Identifier: MIT
/// @file
/// @brief The wall facets of a mesh after the faces that it has on the walls.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/progress.hpp"

namespace slice2mesh::detail {

/// Every triangle of a wall has one edge in a plane, and a mesh that fills the wall has one face on it at each such
/// edge. Where the two have different third vertices, the wall is cut along other diagonals.
class WallFacets {
public:
  WallFacets(const Plc& plc, Mesh& mesh, const std::function<void()>& poll)
      : plc_(plc), mesh_(mesh), listen_(poll, 1 << 16) {}

  void run() {
    collect();
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      listen_();
      find_faces(t);
    }
    for (std::size_t i = 0; i < bases_.size(); ++i) {
      listen_();
      const Base& base = bases_[i];
      if (base.faces % 2 == 0) continue;  // none: no face of the mesh
      if (base.faces > 1 && (std::size_t(base.apex) >= plc_.vertices.size() || !on_wall(base.apex, base.wall)))
        continue;
      for (std::int32_t& v : mesh_.facets[std::size_t(base.facet)].vertices)
        if (v != base.u && v != base.v) v = base.apex;
    }
  }

private:
  /// An edge of a plane at which a facet of a wall stands or hangs.
  struct Base {
    std::int32_t u, v;  // ascending
    std::int32_t facet, wall;
    bool up;                  // the wall is above
    std::uint32_t faces = 0;  // that tets of the cell at the back of the facet have on the wall at the edge
    std::int32_t apex = 0;    // their third vertices, added by exclusive or: those of faces inside of the cell, which
                              // two tets have, are gone
    [[nodiscard]] static bool is_before(const Base& base, std::int32_t w) { return base.v < w; }
  };

  /// The edges by their vertices, and the walls at each vertex.
  void collect() {
    base_start_.assign(plc_.vertices.size() + 1, 0);
    wall_start_.assign(plc_.vertices.size() + 1, 0);
    std::vector<Base> bases;
    for (std::size_t f = 0; f < mesh_.facets.size(); ++f) {
      listen_();
      const Facet& facet = mesh_.facets[f];
      if (facet.wall == kNone) continue;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::int32_t a = facet.vertices[i], b = facet.vertices[(i + 1) % 3], c = facet.vertices[(i + 2) % 3];
        ++wall_start_[std::size_t(a) + 1];
        if (plane(a) != plane(b)) continue;
        bases.push_back({std::min(a, b), std::max(a, b), std::int32_t(f), facet.wall, plane(c) > plane(a)});
        ++base_start_[std::size_t(bases.back().u) + 1];
      }
    }
    for (std::size_t v = 1; v < base_start_.size(); ++v) {
      base_start_[v] += base_start_[v - 1];
      wall_start_[v] += wall_start_[v - 1];
    }
    bases_.resize(bases.size());
    walls_.resize(std::size_t(wall_start_.back()));
    std::vector<std::int32_t> next(base_start_.begin(), base_start_.end() - 1),
        next_wall(wall_start_.begin(), wall_start_.end() - 1);
    for (const Base& base : bases) {
      listen_();
      bases_[std::size_t(next[std::size_t(base.u)]++)] = base;
    }
    for (const Facet& facet : mesh_.facets) {
      listen_();
      if (facet.wall == kNone) continue;
      for (const std::int32_t v : facet.vertices) walls_[std::size_t(next_wall[std::size_t(v)]++)] = facet.wall;
    }
    for (std::size_t v = 0; v + 1 < base_start_.size(); ++v) {
      listen_();
      std::sort(bases_.begin() + base_start_[v], bases_.begin() + base_start_[v + 1],
                [](const Base& a, const Base& b) { return a.v < b.v; });
      std::sort(walls_.begin() + wall_start_[v], walls_.begin() + wall_start_[v + 1]);
    }
  }
  [[nodiscard]] std::int32_t plane(std::int32_t v) const { return plc_.vertex_plane[std::size_t(v)]; }
  [[nodiscard]] bool on_contour(std::int32_t v) const {
    return wall_start_[std::size_t(v)] != wall_start_[std::size_t(v) + 1];
  }
  [[nodiscard]] bool on_wall(std::int32_t v, std::int32_t wall) const {
    return std::binary_search(walls_.begin() + wall_start_[std::size_t(v)],
                              walls_.begin() + wall_start_[std::size_t(v) + 1], wall);
  }
  void find_faces(std::size_t t) {
    const auto& tet = mesh_.tets[t];
    int n = 0;
    for (const std::int32_t v : tet) n += int(on_contour(v));
    if (n < 3) return;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::array<std::int32_t, 3> face{tet[(i + 1) % 4], tet[(i + 2) % 4], tet[(i + 3) % 4]};
      for (std::size_t k = 0; k < 3; ++k) {
        std::int32_t u = face[k], v = face[(k + 1) % 3];
        const std::int32_t apex = face[(k + 2) % 3];
        if (plane(u) != plane(v) || plane(apex) == plane(u) || !on_contour(apex)) continue;
        if (u > v) std::swap(u, v);
        const auto end = bases_.begin() + base_start_[std::size_t(u) + 1];
        auto it = std::lower_bound(bases_.begin() + base_start_[std::size_t(u)], end, v, Base::is_before);
        for (; it != end && it->v == v; ++it) {
          Base& base = *it;
          if (base.up != (plane(apex) > plane(u))) continue;
          const Side& back = mesh_.facets[std::size_t(base.facet)].back;
          if (back.slab != mesh_.tet_slab[t] || back.region != mesh_.tet_region[t]) continue;
          if (!on_wall(apex, base.wall)) continue;
          ++base.faces;
          base.apex ^= apex;
        }
      }
    }
  }

  const Plc& plc_;
  Mesh& mesh_;
  Poll listen_;
  std::vector<std::int32_t> base_start_, wall_start_;  // #V + 1
  std::vector<Base> bases_;                            // by u and v
  std::vector<std::int32_t> walls_;                    // at each vertex, ascending, some of them several times
};

}  // namespace slice2mesh::detail

namespace slice2mesh {

/// Gives the wall facets of a mesh the diagonals that its tets have on the walls, so that every facet is a face of a
/// tet: those of the complex are one choice of several. Facets keep their order, sides and orientation; where the tets
/// have no such face they stay. Precondition: the mesh fills `plc` with its vertices, in their order, and has its
/// facets (not checked). Errors: what `poll` throws. Cost: O(n log n).
inline void take_wall_diagonals(const Plc& plc, Mesh& mesh, const std::function<void()>& poll = {}) {
  detail::WallFacets(plc, mesh, poll).run();
}

}  // namespace slice2mesh
