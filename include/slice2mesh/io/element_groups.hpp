// SPDX-License-Identifier: MIT
/// @file
/// @brief Groups and names that all mesh formats share.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/fem/boundary_sets.hpp"
#include "slice2mesh/fem/quadratic.hpp"
#include "slice2mesh/io/write_options.hpp"

namespace slice2mesh::detail {

/// Tets of one slab and one region.
struct ElementGroup {
  std::int32_t slab = 0;
  std::int32_t region = 0;
  std::size_t begin = 0;  ///< tets of the group: order[begin .. end)
  std::size_t end = 0;
};

/// All tets by slab, then region, then index; groups without tets are left out.
struct ElementGroups {
  std::vector<std::size_t> order;    ///< #T
  std::vector<ElementGroup> groups;  ///< by slab, then region
};

/// Throws Error (Stage::Write) unless the mesh can be written: arrays that fit together, finite coordinates. `poll` is
/// called now and then, here and below.
inline void check_writable(const Mesh& mesh, const std::function<void()>& poll = {}) {
  check_mesh_arrays(mesh, Stage::Write, poll);
  Poll listen(poll, 1 << 16);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    listen();
    for (const double x : mesh.vertices[v])
      if (!std::isfinite(x))
        throw Error(Stage::Write, "vertex " + std::to_string(v) + " has a coordinate that is not finite");
  }
}

[[nodiscard]] inline ElementGroups group_elements(const Mesh& mesh, const std::function<void()>& poll = {}) {
  Poll listen(poll, 1 << 16);
  const std::size_t regions = mesh.regions.size();
  const auto key = [&mesh, regions](std::size_t t) {
    return static_cast<std::size_t>(mesh.tet_slab[t]) * regions + static_cast<std::size_t>(mesh.tet_region[t]);
  };
  std::vector<std::size_t> begin(mesh.slabs.size() * regions + 1, 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    listen();
    ++begin[key(t) + 1];
  }
  for (std::size_t k = 1; k < begin.size(); ++k) begin[k] += begin[k - 1];
  ElementGroups result;
  for (std::size_t k = 0; k + 1 < begin.size(); ++k)
    if (begin[k] != begin[k + 1])
      result.groups.push_back(
          {static_cast<std::int32_t>(k / regions), static_cast<std::int32_t>(k % regions), begin[k], begin[k + 1]});
  result.order.resize(mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    listen();
    result.order[begin[key(t)]++] = t;
  }
  return result;
}

/// A number from 1 with leading zeros: as many digits as the largest needs, at least four.
[[nodiscard]] inline std::string padded(std::size_t number, std::size_t largest) {
  const std::string digits = std::to_string(number);
  const std::size_t width = std::max<std::size_t>(4, std::to_string(largest).size());
  return digits.size() < width ? std::string(width - digits.size(), '0') + digits : digits;
}

/// Names of the regions for use in files: letters, digits and '_' only, at most 70 of them, all different
/// (whatever the case of letters).
[[nodiscard]] inline std::vector<std::string> region_names(const Mesh& mesh) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (std::size_t r = 0; r < mesh.regions.size(); ++r) {
    std::string name;
    std::string folded;
    const auto append = [&name, &folded](char c) {
      name += c;
      folded += c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    };
    for (const char c : mesh.regions[r].name.substr(0, 50)) {
      const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
      append(plain ? c : '_');
    }
    if (name.empty())
      for (const char c : std::string("region")) append(c);
    if (taken.count(folded) > 0)
      for (const char c : "_" + std::to_string(r)) append(c);
    while (taken.count(folded) > 0) append('_');
    taken.insert(folded);
    names.push_back(std::move(name));
  }
  return names;
}

/// Name of a group in files: "layer_0001_part_0"; layers count from 1.
[[nodiscard]] inline std::string group_name(const Mesh& mesh, const std::vector<std::string>& names,
                                            const ElementGroup& group) {
  return "layer_" + padded(static_cast<std::size_t>(group.slab) + 1, mesh.slabs.size()) + "_" +
         names[static_cast<std::size_t>(group.region)];
}

/// Extension of a file name in lower case, without the dot; empty if there is none.
[[nodiscard]] inline std::string extension(const std::string& path) {
  const std::size_t dot = path.find_last_of('.');
  const std::size_t slash = path.find_last_of("/\\");
  if (dot == std::string::npos || (slash != std::string::npos && dot < slash)) return {};
  std::string result = path.substr(dot + 1);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

/// A named set of faces, with its number in files (from 1).
struct SurfaceSet {
  std::string name;
  std::int32_t tag = 0;
  std::vector<TetFace> faces;
};

/// The sets of faces that the options ask for, without empty ones, by tag: the boundary sets (tag = BoundaryKind + 1);
/// with `layer_faces` also `covered_<layer>`, the faces that a layer covers (tag = number of kinds + layer, from 1),
/// and `born_<layer>`, the faces that a layer newly exposes (tags after those). Where the format has no sets that
/// overlap, `born_<layer>` is left out (it is what `covered_<layer + 1>` and the boundary faces of the layer's tets are
/// together), and faces of the interface sets are left out of `covered_<layer>`.
[[nodiscard]] inline std::vector<SurfaceSet> wanted_surfaces(const Mesh& mesh, const WriteOptions& options,
                                                             bool overlap) {
  if (!options.surfaces) return {};
  BoundarySets sets = boundary_sets(mesh, options.poll);
  Poll listen(options.poll, 1 << 14);
  std::vector<SurfaceSet> result;
  const auto add = [&result](std::string name, std::size_t tag, std::vector<TetFace> faces) {
    if (!faces.empty()) result.push_back({std::move(name), static_cast<std::int32_t>(tag), std::move(faces)});
  };
  for (std::size_t k = 0; k < kBoundaryKinds; ++k) {
    const auto kind = static_cast<BoundaryKind>(k);
    const bool inner = kind == BoundaryKind::SupportInterface || kind == BoundaryKind::PlateInterface;
    if (!inner || options.interfaces) add(to_string(kind), k + 1, std::move(sets.sets[k]));
  }
  if (!options.layer_faces) return result;
  // A face between two tets may be seen from either: compare by vertices.
  const auto corners = [&mesh](const TetFace& f) {
    std::array<std::int32_t, 3> v = face_vertices(mesh, f);
    std::sort(v.begin(), v.end());
    return v;
  };
  std::set<std::array<std::int32_t, 3>> taken;
  if (!overlap)
    for (const SurfaceSet& set : result)
      if (set.tag > static_cast<std::int32_t>(BoundaryKind::SupportInterface))
        for (const TetFace& f : set.faces) {
          listen(16);
          taken.insert(corners(f));
        }
  const std::size_t slabs = mesh.slabs.size();
  for (std::size_t s = 0; s < slabs; ++s) {
    listen(sets.covered_begin[s + 1] - sets.covered_begin[s] + 1);
    std::vector<TetFace> faces = covered_faces(sets, static_cast<std::int32_t>(s));
    faces.erase(std::remove_if(faces.begin(), faces.end(),
                               [&](const TetFace& f) { return !taken.empty() && taken.count(corners(f)) > 0; }),
                faces.end());
    add("covered_" + padded(s + 1, slabs), kBoundaryKinds + s + 1, std::move(faces));
  }
  if (overlap)
    for (std::size_t s = 0; s < slabs; ++s)
      add("born_" + padded(s + 1, slabs), kBoundaryKinds + slabs + s + 1,
          born_faces(sets, static_cast<std::int32_t>(s)));
  return result;
}

/// The nodes of a mesh as its file has them: its vertices, and with quadratic tets the middles of its edges behind
/// them.
class FileNodes {
public:
  FileNodes(const Mesh& mesh, const WriteOptions& options) : mesh_(mesh), quadratic_(options.quadratic) {
    if (quadratic_) nodes_ = quadratic_nodes(mesh, options.poll);
  }
  [[nodiscard]] bool quadratic() const { return quadratic_; }
  [[nodiscard]] std::size_t count() const { return mesh_.vertices.size() + nodes_.edges.size(); }
  [[nodiscard]] std::array<double, 3> position(std::size_t node) const {
    return node < mesh_.vertices.size() ? mesh_.vertices[node] : nodes_.middle(mesh_, node - mesh_.vertices.size());
  }
  [[nodiscard]] std::size_t per_tet() const { return quadratic_ ? 10 : 4; }
  [[nodiscard]] std::size_t per_face() const { return quadratic_ ? 6 : 3; }
  /// Node i of a tet; the order is that of VTK, Abaqus and Exodus (kQuadraticEdges).
  [[nodiscard]] std::size_t of_tet(std::size_t tet, std::size_t i) const {
    return i < 4 ? static_cast<std::size_t>(mesh_.tets[tet][i])
                 : mesh_.vertices.size() + static_cast<std::size_t>(nodes_.tet_edges[tet][i - 4]);
  }
  /// Node i of a face: its corners, then the middles of the edges from corner 0 to 1, 1 to 2 and 2 to 0.
  [[nodiscard]] std::size_t of_face(const TetFace& f, std::size_t i) const {
    const std::array<std::size_t, 3>& corner = kTetFaceVertices[static_cast<std::size_t>(f.face)];
    const auto tet = static_cast<std::size_t>(f.tet);
    if (i < 3) return of_tet(tet, corner[i]);
    return of_tet(tet, 4 + quadratic_edge(corner[i - 3], corner[(i - 2) % 3]));
  }

private:
  const Mesh& mesh_;
  bool quadratic_;
  QuadraticNodes nodes_;
};

/// Smallest and largest coordinates: x y z, x y z.
class BoundingBox {
public:
  void add(const std::array<double, 3>& p) {
    for (std::size_t i = 0; i < 3; ++i) {
      low_[i] = empty_ || p[i] < low_[i] ? p[i] : low_[i];
      high_[i] = empty_ || p[i] > high_[i] ? p[i] : high_[i];
    }
    empty_ = false;
  }
  [[nodiscard]] const std::array<double, 3>& low() const { return low_; }
  [[nodiscard]] const std::array<double, 3>& high() const { return high_; }

private:
  std::array<double, 3> low_{};
  std::array<double, 3> high_{};
  bool empty_ = true;
};

}  // namespace slice2mesh::detail
