// SPDX-License-Identifier: MIT
/// @file
/// @brief The least that a tetrahedralizer can be: for those who write functions that take any.
#pragma once

#include "slice2mesh/tet/tetrahedralizer.hpp"

namespace slice2mesh {

/// Meets the requirements of the concept and nothing beyond them: no default constructor, no assignment, no comparison,
/// no address, no traits. A function template that compiles with it asks for no more than the concept.
class TetrahedralizerArchetype {
public:
  /// There is no default constructor.
  explicit TetrahedralizerArchetype(int) {}
  /// Copies are allowed; nothing else is.
  TetrahedralizerArchetype(const TetrahedralizerArchetype&) = default;
  TetrahedralizerArchetype& operator=(const TetrahedralizerArchetype&) = delete;
  ~TetrahedralizerArchetype() = default;
  void operator&() const = delete;
  /// An empty mesh of the slabs and regions of the complex.
  [[nodiscard]] Mesh operator()(const Plc& plc) const {
    Mesh mesh;
    mesh.slabs = plc.slabs;
    mesh.regions = plc.regions;
    return mesh;
  }
};

}  // namespace slice2mesh
