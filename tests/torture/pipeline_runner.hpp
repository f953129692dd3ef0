// SPDX-License-Identifier: MIT
/// @file
/// @brief The whole pipeline behind a plain function, compiled once for all tests and fuzzers that run it on hostile
/// input.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/core/diagnostics.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/slice_stack.hpp"
#include "slice2mesh/pipeline/options.hpp"
#include "slice2mesh/quality/certificate.hpp"

namespace slice2mesh_test {

/// How a run ended. All but the first and the `...Error`s of the library are faults of the library.
enum class Ending : std::uint8_t {
  Certified,
  OptionError,
  GeometryError,
  TetrahedralizationError,
  BudgetError,
  Cancelled,
  OtherError,     ///< slice2mesh::Error and none of those above
  NotCertified,   ///< a mesh with a certificate that does not hold
  NotWhatItSays,  ///< a certified mesh that contradicts the rest of the result
  Foreign         ///< an exception that is not of the library
};
inline constexpr std::size_t kEndings = 10;

[[nodiscard]] const char* to_string(Ending ending) noexcept;

/// What a run gave; the mesh and the rest only if it is certified.
struct Outcome {
  Ending ending = Ending::Foreign;
  std::string message;  ///< of the error, or of the checks that failed
  slice2mesh::Mesh mesh;
  slice2mesh::Plc plc;
  slice2mesh::Certificate certificate;
  slice2mesh::Diagnostics diagnostics;
  double eps = 0;            ///< mm, in force
  double max_deviation = 0;  ///< mm
  std::vector<std::pair<slice2mesh::Stage, double>> seconds;

  [[nodiscard]] bool certified() const { return ending == Ending::Certified; }
};

/// `slice_to_mesh`, with everything that it may throw caught and named, and what must hold of a certified result
/// checked once more.
[[nodiscard]] Outcome run_pipeline(const slice2mesh::SliceStack& stack, const slice2mesh::Options& options = {});

/// The union of the loops of every slab, before harmonization: area in mm^2 per slab.
[[nodiscard]] std::vector<double> united_areas(const slice2mesh::SliceStack& stack,
                                               const slice2mesh::Options& options = {});

/// With eps = 0: is a contour vertex of one slab within 2^-20 of the extent of an edge of a slab next to it, and not on
/// it? Such contours may leave no room for a mesh: then there may be a TetrahedralizationError, see
/// docs/reliability.md.
[[nodiscard]] bool exact_neighbors_nearly_coincide(const slice2mesh::SliceStack& stack,
                                                   const slice2mesh::Options& options);

/// Volume of the tets of each slab, in mm^3: in long double, compensated.
[[nodiscard]] std::vector<double> slab_volumes(const slice2mesh::Mesh& mesh);

/// Equal to the last bit.
[[nodiscard]] bool same_mesh(const slice2mesh::Mesh& a, const slice2mesh::Mesh& b);

/// A number that changes with every bit of a mesh (FNV-1a, 64 bits).
[[nodiscard]] std::uint64_t fingerprint(const slice2mesh::Mesh& mesh);

}  // namespace slice2mesh_test
