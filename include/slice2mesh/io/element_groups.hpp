// SPDX-License-Identifier: MIT
/// @file
/// @brief Groups and names that all mesh formats share.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/fem/boundary_sets.hpp"
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

/// Throws Error (Stage::Write) unless the mesh can be written: arrays that fit together, finite coordinates.
inline void check_writable(const Mesh& mesh) {
  check_mesh_arrays(mesh, Stage::Write);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    for (const double x : mesh.vertices[v])
      if (!std::isfinite(x))
        throw Error(Stage::Write, "vertex " + std::to_string(v) + " has a coordinate that is not finite");
}

[[nodiscard]] inline ElementGroups group_elements(const Mesh& mesh) {
  const std::size_t regions = mesh.regions.size();
  const auto key = [&mesh, regions](std::size_t t) {
    return static_cast<std::size_t>(mesh.tet_slab[t]) * regions + static_cast<std::size_t>(mesh.tet_region[t]);
  };
  std::vector<std::size_t> begin(mesh.slabs.size() * regions + 1, 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) ++begin[key(t) + 1];
  for (std::size_t k = 1; k < begin.size(); ++k) begin[k] += begin[k - 1];
  ElementGroups result;
  for (std::size_t k = 0; k + 1 < begin.size(); ++k)
    if (begin[k] != begin[k + 1])
      result.groups.push_back(
          {static_cast<std::int32_t>(k / regions), static_cast<std::int32_t>(k % regions), begin[k], begin[k + 1]});
  result.order.resize(mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) result.order[begin[key(t)]++] = t;
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

/// The boundary sets that the options ask for: empty lists otherwise.
[[nodiscard]] inline std::array<std::vector<TetFace>, kBoundaryKinds> wanted_surfaces(const Mesh& mesh,
                                                                                      const WriteOptions& options) {
  if (!options.surfaces) return {};
  std::array<std::vector<TetFace>, kBoundaryKinds> sets = std::move(boundary_sets(mesh).sets);
  if (!options.interfaces) sets[static_cast<std::size_t>(BoundaryKind::SupportInterface)].clear();
  return sets;
}

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
