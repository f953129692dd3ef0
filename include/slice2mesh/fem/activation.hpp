// SPDX-License-Identifier: MIT
/// @file
/// @brief Activation of layers: times per tet, growing domains, and the sub-mesh of a range of layers.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/fem/boundary_sets.hpp"

namespace slice2mesh {

/// Time at which every tet comes to life, #T: `time(slab, tet)`, a function of the slab's index and the tet's index, in
/// its units (s where a writer is given them). Precondition: `tet_slab` is as long as `tets` (not checked). Errors:
/// what `time` throws. Cost: linear.
template <class TimeOfTet>
[[nodiscard]] std::vector<double> activation_times(const Mesh& mesh, TimeOfTet time) {
  std::vector<double> times(mesh.tets.size());
  for (std::size_t t = 0; t < times.size(); ++t) times[t] = static_cast<double>(time(mesh.tet_slab[t], t));
  return times;
}

/// Number of slabs of the base plate; they are the lowest ones. Cost: linear in the slabs of the plate.
[[nodiscard]] inline std::int32_t plate_slabs(const Mesh& mesh) {
  std::int32_t count = 0;
  while (static_cast<std::size_t>(count) < mesh.slabs.size() && mesh.slabs[static_cast<std::size_t>(count)].is_plate())
    ++count;
  return count;
}

/// Time at which every tet comes to life, #T, s: number of its layer (from 0) times `time_per_layer` (s, finite, >= 0).
/// The base plate is there from the beginning, as the first layer is.
/// Errors: OptionError. Cost: linear.
[[nodiscard]] inline std::vector<double> activation_time(const Mesh& mesh, double time_per_layer) {
  if (!(time_per_layer >= 0) || std::isinf(time_per_layer)) throw OptionError("time_per_layer", "must be >= 0");
  const std::int32_t plate = plate_slabs(mesh);
  return activation_times(mesh, [time_per_layer, plate](std::int32_t slab, std::size_t) {
    return time_per_layer * std::max(0, slab - plate);
  });
}

/// What an element belongs to besides its slab and region.
struct ElementLabels {
  std::int32_t layer = 0;         ///< index of the slab, from 0
  std::int32_t bundle_first = 0;  ///< index of the first slice of the file that the slab stands for; kNone: base plate
  /// Index of the last one (inclusive), or kNone.
  std::int32_t bundle_last = 0;
  std::int32_t part = 0;    ///< part id of the file
  std::int32_t region = 0;  ///< index of the region
  /// What the region is made for.
  RegionKind kind = RegionKind::Part;
};

/// The labels of the tet of index `tet`. Precondition: there is one, and the arrays of the mesh fit together (not
/// checked).
[[nodiscard]] inline ElementLabels element_labels(const Mesh& mesh, std::size_t tet) {
  const Slab& slab = mesh.slabs[static_cast<std::size_t>(mesh.tet_slab[tet])];
  const Region& region = mesh.regions[static_cast<std::size_t>(mesh.tet_region[tet])];
  return {mesh.tet_slab[tet], slab.first_layer, slab.last_layer, region.part, mesh.tet_region[tet], region.kind};
}

/// Some tets, by index, in a row.
class TetRange {
public:
  /// The indices in [first, last), which must outlive the range.
  TetRange(const std::int32_t* first, const std::int32_t* last) : first_(first), last_(last) {}
  /// First index.
  [[nodiscard]] const std::int32_t* begin() const noexcept { return first_; }
  /// Behind the last index.
  [[nodiscard]] const std::int32_t* end() const noexcept { return last_; }
  /// Number of tets.
  [[nodiscard]] std::size_t size() const noexcept { return static_cast<std::size_t>(last_ - first_); }
  /// True if there are none.
  [[nodiscard]] bool empty() const noexcept { return first_ == last_; }

private:
  const std::int32_t* first_;
  const std::int32_t* last_;
};

/// The print when one slab is the last one deposited. Valid as long as the GrowingDomains it comes from.
struct GrowingDomain {
  /// Index of the last slab deposited.
  std::int32_t slab = 0;
  TetRange born;  ///< the tets of this slab, ascending
  TetRange all;   ///< those of this slab and of all below, by slab
};

/// The growing domains of the print. A range: `for (const GrowingDomain& domain : growing_domains(mesh))` runs through
/// the slabs from below.
class GrowingDomains {
public:
  /// Errors: Error (Stage::Fem) if the arrays of the mesh do not fit together. Cost: linear.
  explicit GrowingDomains(const Mesh& mesh) {
    detail::check_mesh_arrays(mesh, Stage::Fem);
    offsets_.assign(mesh.slabs.size() + 1, 0);
    for (const std::int32_t s : mesh.tet_slab) ++offsets_[static_cast<std::size_t>(s) + 1];
    for (std::size_t s = 1; s < offsets_.size(); ++s) offsets_[s] += offsets_[s - 1];
    order_.resize(mesh.tets.size());
    std::vector<std::size_t> next(offsets_);
    for (std::size_t t = 0; t < mesh.tets.size(); ++t)
      order_[next[static_cast<std::size_t>(mesh.tet_slab[t])]++] = static_cast<std::int32_t>(t);
  }

  /// Number of slabs.
  [[nodiscard]] std::size_t size() const noexcept { return offsets_.size() - 1; }
  /// The domain after the slab of index `k`. Precondition: 0 <= k < size() (not checked).
  [[nodiscard]] GrowingDomain operator[](std::size_t k) const {
    const std::int32_t* const first = order_.data();
    return {
        static_cast<std::int32_t>(k), {first + offsets_[k], first + offsets_[k + 1]}, {first, first + offsets_[k + 1]}};
  }

  /// Input iterator over the domains, from the lowest slab.
  class Iterator {
  public:
    /// Input: its values are made on the way.
    using iterator_category = std::input_iterator_tag;  // its values are made on the way
    /// What it gives.
    using value_type = GrowingDomain;
    /// A number of slabs. Unused; asked for by the standard library.
    using difference_type = std::ptrdiff_t;
    /// Unused; asked for by the standard library.
    using pointer = const GrowingDomain*;
    /// What it gives, by value.
    using reference = GrowingDomain;
    /// At the domain after the slab of index `k`.
    Iterator(const GrowingDomains& domains, std::size_t k) : domains_(&domains), k_(k) {}
    /// The domain.
    [[nodiscard]] GrowingDomain operator*() const { return (*domains_)[k_]; }
    /// On to the next slab.
    Iterator& operator++() {
      ++k_;
      return *this;
    }
    /// The same; gives the iterator as it was.
    Iterator operator++(int) {
      const Iterator old = *this;
      ++k_;
      return old;
    }
    friend bool operator==(const Iterator& a, const Iterator& b) { return a.k_ == b.k_; }
    friend bool operator!=(const Iterator& a, const Iterator& b) { return a.k_ != b.k_; }

  private:
    const GrowingDomains* domains_;
    std::size_t k_;
  };
  /// The domain of the lowest slab.
  [[nodiscard]] Iterator begin() const { return {*this, 0}; }
  /// Behind that of the highest one.
  [[nodiscard]] Iterator end() const { return {*this, size()}; }

private:
  std::vector<std::int32_t> order_;   // #T, tets by slab, then index
  std::vector<std::size_t> offsets_;  // #S+1: slab k is order_[offsets_[k] .. offsets_[k+1])
};

/// The growing domains of a mesh. Errors: Error (Stage::Fem) if the arrays of the mesh do not fit together.
/// Cost: linear.
[[nodiscard]] inline GrowingDomains growing_domains(const Mesh& mesh) {
  return GrowingDomains(mesh);
}

/// The mesh of some layers, with its own numbering.
struct SubMesh {
  Mesh mesh;                                  ///< slab i is slab `first_slab` + i of the whole; regions are kept
  std::int32_t first_slab = 0;                ///< index in the whole mesh
  std::vector<std::int32_t> vertex_in_whole;  ///< #V of the sub-mesh: index in the whole mesh
  std::vector<std::int32_t> tet_in_whole;     ///< #T of the sub-mesh: index in the whole mesh
  std::vector<std::int32_t> vertex_in_sub;    ///< #V of the whole mesh: index in the sub-mesh or kNone
};

/// The sub-mesh of the slabs of index `first` to `last` (inclusive). Vertices and tets keep their order; vertices of no
/// tet are left out. Facets are kept where all their vertices are; a side of a facet outside the range becomes empty,
/// and a facet with both sides outside is left out. Labels and orientation of facets stay those of the whole. Errors:
/// Error (Stage::Fem) for a range that is not within the slabs or arrays that do not fit together. `poll` is called now
/// and then; what it throws ends the work. Cost: linear in the whole mesh.
[[nodiscard]] inline SubMesh layers_of(const Mesh& mesh, std::int32_t first, std::int32_t last,
                                       const std::function<void()>& poll = {}) {
  detail::check_mesh_arrays(mesh, Stage::Fem, poll);
  detail::Poll listen(poll, 1 << 14);
  if (first < 0 || last < first || static_cast<std::size_t>(last) >= mesh.slabs.size())
    throw Error(Stage::Fem, "there are no slabs " + std::to_string(first) + " to " + std::to_string(last));
  SubMesh sub;
  sub.first_slab = first;
  sub.mesh.regions = mesh.regions;
  sub.mesh.slabs.assign(mesh.slabs.begin() + first, mesh.slabs.begin() + last + 1);
  sub.vertex_in_sub.assign(mesh.vertices.size(), kNone);
  const auto inside = [first, last](std::int32_t slab) { return first <= slab && slab <= last; };
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    listen();
    if (!inside(mesh.tet_slab[t])) continue;
    sub.tet_in_whole.push_back(static_cast<std::int32_t>(t));
    for (const std::int32_t v : mesh.tets[t]) sub.vertex_in_sub[static_cast<std::size_t>(v)] = 0;
  }
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    listen();
    if (sub.vertex_in_sub[v] == kNone) continue;
    sub.vertex_in_sub[v] = static_cast<std::int32_t>(sub.vertex_in_whole.size());
    sub.vertex_in_whole.push_back(static_cast<std::int32_t>(v));
    sub.mesh.vertices.push_back(mesh.vertices[v]);
  }
  for (const std::int32_t whole : sub.tet_in_whole) {
    listen();
    const auto t = static_cast<std::size_t>(whole);
    std::array<std::int32_t, 4> tet = mesh.tets[t];
    for (std::int32_t& v : tet) v = sub.vertex_in_sub[static_cast<std::size_t>(v)];
    sub.mesh.tets.push_back(tet);
    sub.mesh.tet_slab.push_back(mesh.tet_slab[t] - first);
    sub.mesh.tet_region.push_back(mesh.tet_region[t]);
  }
  for (Facet facet : mesh.facets) {
    listen();
    bool kept = false;
    for (Side* const side : {&facet.front, &facet.back}) {
      if (!side->empty() && inside(side->slab)) {
        side->slab -= first;
        kept = true;
      } else {
        *side = Side{};
      }
    }
    for (std::int32_t& v : facet.vertices) {
      if (v < 0 || static_cast<std::size_t>(v) >= mesh.vertices.size())
        throw Error(Stage::Fem, "a facet names a vertex that does not exist");
      v = sub.vertex_in_sub[static_cast<std::size_t>(v)];
      kept = kept && v != kNone;
    }
    if (kept) sub.mesh.facets.push_back(facet);
  }
  return sub;
}

}  // namespace slice2mesh
