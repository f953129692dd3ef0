// SPDX-License-Identifier: MIT
/// @file
/// @brief The whole pipeline in one call.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/core/diagnostics.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/separate.hpp"
#include "slice2mesh/core/short_number.hpp"
#include "slice2mesh/core/slice_stack.hpp"
#include "slice2mesh/fem/estimates.hpp"
#include "slice2mesh/harmonize/separation_report.hpp"
#include "slice2mesh/pipeline/options.hpp"
#include "slice2mesh/quality/causes.hpp"
#include "slice2mesh/quality/certificate.hpp"
#include "slice2mesh/quality/quality.hpp"
#include "slice2mesh/quality/volume_error.hpp"
#include "slice2mesh/regions/slabs.hpp"
#include "slice2mesh/tet/axioms.hpp"
#include "slice2mesh/tet/slab_filler.hpp"
#include "slice2mesh/tet/tetrahedralizer.hpp"
#if !SLICE2MESH_DECLARED_ONLY
#include "slice2mesh/harmonize/harmonize.hpp"
#include "slice2mesh/harmonize/separation.hpp"
#include "slice2mesh/improve/improve.hpp"
#include "slice2mesh/plc/build_plc.hpp"
#include "slice2mesh/regions/base_plate.hpp"
#include "slice2mesh/regions/finer_slices.hpp"
#include "slice2mesh/regions/regions.hpp"
#include "slice2mesh/triangulate/plane_stack.hpp"
#endif

namespace slice2mesh {

/// What was done, and how good it is.
struct Report {
  ZConvention z_convention = ZConvention::Auto;  ///< as chosen
  double thickness = 0;                          ///< mm, median layer thickness
  double eps = 0;  ///< mm, in force: in exact mode the smallest tolerance of the grid, 2^-20 of the extent
  /// In mm, edge length in the interior, as chosen.
  double size = 0;
  std::vector<double> deviation;  ///< #S, mm: distance between contour and input slice, both ways
  /// The largest of `deviation`, mm.
  double max_deviation = 0;
  VolumeError volume_error;     ///< what the mesh gains and loses against the input slices
  SeparationReport separation;  ///< how near contours come to each other and to themselves
  /// What was checked on the finished mesh.
  Certificate certificate;
  /// Figures of the elements.
  QualityReport quality;
  SlicingEstimates estimates;                     ///< staircase error, volume loss; of the complex
  std::vector<std::pair<Stage, double>> seconds;  ///< s of wall-clock time, one entry per stage
  std::string tetrahedralizer = "slab";           ///< name of the model that filled the complex
  std::optional<LayerReport> layers;              ///< of models that do not keep the facets of the complex as they are
};

/// Everything a run gives.
struct Result {
  /// The tets.
  Mesh mesh;
  /// The complex that was filled.
  Plc plc;
  /// Figures.
  Report report;
  /// What was repaired or noticed; that of reading is where `read_cli` put it.
  Diagnostics diagnostics;
};

#if !SLICE2MESH_DECLARED_ONLY

namespace detail {

/// Wall-clock times of stages, and the time limit of a run.
class StageClock {
public:
  StageClock(Report& report, const Options& options)
      : report_(report), options_(options), start_(Clock::now()), last_(start_) {}
  void done(Stage stage) {
    const auto now = Clock::now();
    report_.seconds.emplace_back(stage, std::chrono::duration<double>(now - last_).count());
    last_ = now;
  }
  /// A progress function that also watches the time limit.
  [[nodiscard]] Progress watched() const {
    if (!(options_.budget.time_limit > 0)) return options_.progress;
    return
        [progress = options_.progress, limit = options_.budget.time_limit, start = start_](Stage stage, double share) {
          if (std::chrono::duration<double>(Clock::now() - start).count() > limit)
            throw BudgetError(stage, "the time limit of " + detail::short_number(limit) + " s is used up");
          return !progress || progress(stage, share);
        };
  }

private:
  using Clock = std::chrono::steady_clock;
  Report& report_;
  const Options& options_;
  Clock::time_point start_;
  Clock::time_point last_;
};

inline void check_options(const Options& options) {
  if (options.budget.max_vertices < 0) throw OptionError("budget.max_vertices", "must be 0 or more");
  if (options.budget.max_tets < 0) throw OptionError("budget.max_tets", "must be 0 or more");
  if (!(options.budget.time_limit >= 0)) throw OptionError("budget.time_limit", "must be 0 or more");
}

/// The contour of a plate must not come so near to that of the part that harmonization takes them for one.
inline void check_plate(const Options& options, const SlabPlan& plan) {
  if (options.plate.thickness.value > 0 &&
      !(options.plate.margin.in_mm(plan.thickness) >= 2 * options.eps.in_mm(plan.thickness)))
    throw OptionError("plate.margin", "must be at least twice eps");
}

/// Ends a run before the work where its sizes alone ask for more than the budget has, or than indices of 32 bits can
/// count: areas and lengths of the contours give a number of vertices and tets that the mesh has at least. Without
/// this, the points would be made, and memory used up, before the budget is looked at.
inline void check_sizes(const LayerRegions& regions, const Options& options, const PlaneSizes& sizes) {
  const double smallest = smallest_size(regions.outlines) * regions.grid.pitch;
  if (!(sizes.size >= smallest)) throw OptionError("size.size", "is below 2^-20 of the extent of the part");
  if (options.size.contour_size.value > 0 && !(sizes.contour_size >= smallest))
    throw OptionError("size.contour_size", "is below 2^-20 of the extent of the part");
  constexpr double kCautious = 0.25;  // harmonization shortens contours, the lattice is not everywhere
  double vertices = 0, tets = 0;
  for (const Outline& outline : regions.outlines) {
    const double area = static_cast<double>(doubled_area(outline, kNone)) / 2 * regions.grid.pitch * regions.grid.pitch;
    double length = 0;
    for (const Outline::Edge& edge : outline.edges)
      length += distance(outline.vertices[static_cast<std::size_t>(edge.a)],
                         outline.vertices[static_cast<std::size_t>(edge.b)]);
    const double triangles = area / (std::sqrt(3.0) / 4 * sizes.size * sizes.size);
    vertices += kCautious * (triangles / 2 + length * regions.grid.pitch / sizes.contour_size);
    tets += kCautious * 3 * triangles;
  }
  const auto over = [](double needed, std::int64_t budget) {
    return needed > (budget > 0 ? static_cast<double>(budget) : static_cast<double>(INT32_MAX));
  };
  if (over(vertices, options.budget.max_vertices))
    throw BudgetError(Stage::Triangulate, "the sizes ask for more vertices than " +
                                              std::string(options.budget.max_vertices > 0 ? "max_vertices" : "2^31"));
  if (over(tets, options.budget.max_tets))
    throw BudgetError(Stage::Tetrahedralize, "the sizes ask for more tets than " +
                                                 std::string(options.budget.max_tets > 0 ? "max_tets" : "2^31"));
}

/// The axioms that were checked, as a certificate.
[[nodiscard]] inline Certificate certificate_of(const AxiomReport& axioms, const Mesh& mesh, const Plc& plc) {
  Certificate certificate;
  for (const Axiom& axiom : axioms.axioms)
    certificate.checks.push_back({axiom.name, axiom.status != AxiomStatus::Failed,
                                  (axiom.status == AxiomStatus::NotPromised ? "not promised: " : "") + axiom.detail});
  certificate.volume = axioms.layers.volume;
  certificate.expected_volume = axioms.layers.exact_volume;
  certificate.tets = static_cast<std::int64_t>(mesh.tets.size());
  certificate.vertices = static_cast<std::int64_t>(mesh.vertices.size());
  certificate.facets = static_cast<std::int64_t>(plc.facets.size());
  return certificate;
}

/// The same error, with what helps where contours of neighboring slabs nearly coincide.
inline TetrahedralizationError with_remedy(const TetrahedralizationError& error) {
  // The constructor puts stage and slab in front of the message, which has both already.
  const std::size_t prefix = std::string(TetrahedralizationError(error.slab(), "").what()).size();
  return {error.slab(), std::string(error.what()).substr(prefix) +
                            "; with eps = 0 contours of neighboring slabs may come too near to each other there for "
                            "double coordinates: eps > 0 merges them"};
}

}  // namespace detail

#endif

/// From slices to a mesh with a tetrahedralizer of choice: make_slabs, build_regions_on_plate, harmonize,
/// triangulate_planes, build_plc, `model`, improve, certify, measure_quality, estimate_slicing. Each may be called on
/// its own; the chain gives the identical result.
///
/// If the model keeps the facets exactly, a mesh without further vertices is improved (improve/improve.hpp), and the
/// mesh is certified; for any other model the certificate holds the
/// axioms that its traits promise (tet/axioms.hpp), and `report.layers` says what became of the layers. A certificate
/// that does not hold is not an error: look at `report.certificate`.
/// Errors: OptionError, GeometryError, TetrahedralizationError, BudgetError, Cancelled; what the model throws, and
/// Error (Stage::Quality) where it gives a mesh whose arrays do not fit together. Cost: about linear in the result,
/// apart from the model; see docs/pipeline.md.
[[nodiscard]] SLICE2MESH_INLINE Result slice_to_mesh(const SliceStack& stack, const Options& options,
                                                     const AnyTetrahedralizer& model);

/// The same with the default tetrahedralizer, the slab filler. Errors and cost as above.
[[nodiscard]] SLICE2MESH_INLINE Result slice_to_mesh(const SliceStack& stack, const Options& options = {});

#if !SLICE2MESH_DECLARED_ONLY

SLICE2MESH_INLINE Result slice_to_mesh(const SliceStack& stack, const Options& options,
                                       const AnyTetrahedralizer& model) {
  detail::check_options(options);
  const TetrahedralizerTraits traits = model.traits();
  Result result;
  Report& report = result.report;
  detail::StageClock clock(report, options);
  const Progress progress = clock.watched();

  const SlabPlan plan = make_slabs(stack, options.slabs, result.diagnostics);
  const LayerRegions regions =
      build_regions_on_plate(stack, plan, options.supports, options.plate, result.diagnostics, progress);
  detail::check_plate(options, plan);
  const PlaneSizes sizes = resolve_sizes(options.size, regions);
  detail::check_sizes(regions, options, sizes);
  clock.done(Stage::Regions);
  HarmonizeOptions harmonize_options;
  harmonize_options.eps = options.eps.in_mm(plan.thickness);
  harmonize_options.contour_size = sizes.contour_size;
  harmonize_options.size_at = sizes.size_at;
  Contours contours = harmonize(regions, harmonize_options, result.diagnostics, progress);
  slice2mesh::report(progress, Stage::Harmonize, 1);
  clock.done(Stage::Harmonize);
  PlaneStack planes = triangulate_planes(contours, sizes, options.budget, progress);
  clock.done(Stage::Triangulate);
  slice2mesh::report(progress, Stage::Plc, 0);
  result.plc = build_plc(contours, planes.meshes, planes.slab_planes, true, {},
                         [&] { slice2mesh::report(progress, Stage::Plc, 0); });
  slice2mesh::report(progress, Stage::Plc, 1);
  clock.done(Stage::Plc);
  try {
    result.mesh = model.with_progress(progress)(result.plc);
  } catch (const TetrahedralizationError& error) {
    if (options.eps.value == 0 && traits.needs_conforming_plc) throw detail::with_remedy(error);
    throw;
  }
  slice2mesh::report(progress, Stage::Tetrahedralize, 1);
  if (options.budget.max_tets > 0 && static_cast<std::int64_t>(result.mesh.tets.size()) > options.budget.max_tets)
    throw BudgetError(Stage::Tetrahedralize, "the mesh needs more tets than max_tets");
  clock.done(Stage::Tetrahedralize);
  if (traits.facets == FacetKeeping::Exactly)
    improve(regions, contours, planes, result.plc, result.mesh, options.improve, progress);
  report.separation = measure_separation(contours, detail::within(progress, Stage::Improve));
  note_separation(report.separation, contours.slabs, result.diagnostics);
  planes = {};  // nobody needs it any more, and to give it back takes its time
  slice2mesh::report(progress, Stage::Improve, 1);
  clock.done(Stage::Improve);
  slice2mesh::report(progress, Stage::Certify, 0);
  if (traits.facets == FacetKeeping::Exactly) {
    report.certificate = certify(result.mesh, result.plc, {}, progress);
  } else {
    const AxiomReport axioms = check_axioms(result.mesh, result.plc, traits, {}, progress);
    report.certificate = detail::certificate_of(axioms, result.mesh, result.plc);
    report.layers = axioms.layers;
  }
  report.tetrahedralizer = traits.name;
  slice2mesh::report(progress, Stage::Certify, 1);
  clock.done(Stage::Certify);
  slice2mesh::report(progress, Stage::Quality, 0);
  QualityOptions quality_options;
  quality_options.metric_l = sizes.size;
  quality_options.metric_h = plan.thickness;
  quality_options.classify = default_cause(result.plc, contours.tolerance, &regions.outlines,
                                           [&] { slice2mesh::report(progress, Stage::Quality, 0); });
  report.quality = measure_quality(result.mesh, quality_options, progress);
  report.volume_error = measure_volume_error(regions.outlines, regions.grid, regions.slabs, report.quality.slab_volume,
                                             [&] { slice2mesh::report(progress, Stage::Quality, 1); });
  slice2mesh::report(progress, Stage::Quality, 1);
  clock.done(Stage::Quality);

  slice2mesh::report(progress, Stage::Fem, 0);
  report.estimates = estimate_slicing(
      result.plc,
      options.finer_slices ? finer_slices(stack, plan, options.slabs, detail::within(progress, Stage::Fem))
                           : std::vector<FinerSlice>(),
      [&] { slice2mesh::report(progress, Stage::Fem, 0); });
  clock.done(Stage::Fem);

  report.z_convention = plan.convention;
  report.thickness = plan.thickness;
  report.eps = contours.tolerance;
  report.size = sizes.size;
  report.deviation = contours.deviation;
  for (const double d : report.deviation) report.max_deviation = std::max(report.max_deviation, d);
  return result;
}

SLICE2MESH_INLINE Result slice_to_mesh(const SliceStack& stack, const Options& options) {
  SlabFiller filler;
  filler.max_tets = options.budget.max_tets;
  return slice_to_mesh(stack, options, filler);
}

#endif

}  // namespace slice2mesh
