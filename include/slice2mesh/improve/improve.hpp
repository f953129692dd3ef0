// SPDX-License-Identifier: MIT
/// @file
/// @brief Improvement of a filled stack of slabs.
#pragma once

#include <functional>

#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/harmonize/harmonize.hpp"
#include "slice2mesh/improve/mesh_optimizer.hpp"
#include "slice2mesh/pipeline/options.hpp"
#include "slice2mesh/plc/build_plc.hpp"
#include "slice2mesh/tet/wall_facets.hpp"
#include "slice2mesh/triangulate/plane_stack.hpp"

namespace slice2mesh {

/// Improves a mesh that fills a complex by flips and larger changes inside of its slabs, by moving, collapsing and, at
/// the worst elements, adding vertices in their planes, and with `ImproveOptions::move_contours` by moving contour
/// vertices within the tolerance; contours, planes, complex and mesh are changed together. Every tet stays in its slab
/// and region, every wall vertical, every tet positive (decided exactly); contours stay where they are, or within
/// `contours.tolerance` of their slices (both ways; `contours.deviation` is measured again). Deterministic.
///
/// Precondition: `contours` were made from `regions`, `plc` is
/// `build_plc(contours, stack.meshes, stack.slab_planes)`, and `mesh` fills it with its vertices, in their order, and
/// no others. A mesh with other vertices stays as it is, and so does one of exact mode, which promises no quality.
/// Returns whether it was worked on. Errors: OptionError, Cancelled; after that, contours, stack, complex and mesh are
/// of no use. Cost: bounded by ImproveOptions::most_work, apart from a linear part.
inline bool improve(const LayerRegions& regions, Contours& contours, PlaneStack& stack, Plc& plc, Mesh& mesh,
                    const ImproveOptions& options, const Progress& progress = {}) {
  if (options.rounds < 0) throw OptionError("improve.rounds", "must be 0 or more");
  if (!(options.target >= 1)) throw OptionError("improve.target", "must be at least 1");
  if (!(options.collapse_above >= 1)) throw OptionError("improve.collapse_above", "must be at least 1");
  if (!(options.most_work >= 0)) throw OptionError("improve.most_work", "must be 0 or more");
  if (options.rounds == 0 || contours.eps == 0 || mesh.vertices.size() != plc.vertices.size()) return false;
  const std::function<void()> poll = [&] { report(progress, Stage::Improve, 1); };
  const std::function<void()> begin = [&] { report(progress, Stage::Improve, 0); };
  detail::Poll listen_first(begin, 1 << 16), listen(poll, 1 << 16);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    listen_first();
    if (mesh.vertices[v] != plc.position(v)) return false;
  }
  {
    detail::MeshOptimizer optimizer(contours, options.move_contours ? &regions.outlines : nullptr, stack, mesh, options,
                                    progress);
    optimizer.run();
    if (const detail::ContourColumns* columns = optimizer.columns()) {
      contours.outlines = columns->outlines();
      const double eps = contours.tolerance / contours.grid.pitch;
      for (std::size_t s = 0; s < contours.outlines.size(); ++s) {
        poll();
        if (columns->touched()[s])
          contours.deviation[s] =
              detail::measured_deviation(contours.outlines[s], regions.outlines[s], eps, poll) * contours.grid.pitch;
      }
    }
  }
  poll();
  plc = build_plc(contours, stack.meshes, stack.slab_planes, true, {}, poll);
  poll();
  mesh.vertices.clear();
  for (std::size_t v = 0; v < plc.vertices.size(); ++v) {
    listen();
    mesh.vertices.push_back(plc.position(v));
  }
  mesh.facets = plc.facets;
  take_wall_diagonals(plc, mesh, poll);
  poll();
  plc.facets = mesh.facets;
  return true;
}

}  // namespace slice2mesh
