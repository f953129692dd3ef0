// SPDX-License-Identifier: MIT
/// @file
/// @brief Figures of a whole mesh: R/3r, dihedral angles, crossing, columns, volumes, worst elements.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/fem/boundary_sets.hpp"
#include "slice2mesh/quality/tet_figures.hpp"

namespace slice2mesh {

/// Why an element is bad. From its own shape only ShortEdge and Flat can be told; the others need the slices, see
/// QualityOptions::classify.
enum class Cause : std::uint8_t {
  Unknown,          ///< none of the others
  ShortEdge,        ///< its shortest edge is below a fifth of its longest and of its slab's thickness
  Flat,             ///< a sliver: a dihedral angle above 150 degrees without a short edge
  SmallInputAngle,  ///< a corner of the input slice
  ThinWall,         ///< a wall or gap of the input slice thinner than the tolerance
  SizeJump          ///< element size changes too fast
};

/// The name in lower case.
[[nodiscard]] constexpr const char* to_string(Cause cause) noexcept {
  switch (cause) {
    case Cause::Unknown: return "unknown";
    case Cause::ShortEdge: return "short_edge";
    case Cause::Flat: return "flat";
    case Cause::SmallInputAngle: return "small_input_angle";
    case Cause::ThinWall: return "thin_wall";
    case Cause::SizeJump: return "size_jump";
  }
  return "unknown";
}

/// One of the worst elements.
struct WorstTet {
  /// Index of the tet.
  std::size_t tet = 0;
  std::array<double, 3> centroid{};  ///< x, y, z in mm
  /// Index of its slab.
  std::int32_t slab = 0;
  /// Index of its region.
  std::int32_t region = 0;
  double ratio = 1;          ///< R/3r
  double min_dihedral = 0;   ///< degrees
  double max_dihedral = 0;   ///< degrees
  double shortest_edge = 0;  ///< mm
  double longest_edge = 0;   ///< mm
  /// Why it is bad, as far as is known.
  Cause cause = Cause::Unknown;
};

/// What is measured.
struct QualityOptions {
  double metric_l = 0;           ///< mm, >= 0: horizontal size of the metric figures; 0: left out
  double metric_h = 0;           ///< mm, >= 0: vertical size of the metric figures; 0: left out
  std::size_t worst_count = 10;  ///< how many worst elements are listed
  double forced_above = 15;      ///< elements with a larger R/3r are asked for their cause, see ForcedFigures
  /// Says why an element is bad, if set; its `cause` then holds what its own shape tells. See default_cause
  /// (quality/causes.hpp).
  std::function<Cause(const Mesh&, const WorstTet&)> classify;
};

/// Distribution of R/3r. A share q of p: at least q of all tets have R/3r <= p, and p is that of a tet.
struct RatioFigures {
  /// Arithmetic mean of R/3r.
  double mean = 0;
  /// R/3r at the share of 50 %.
  double median = 0;
  double p99 = 0;    ///< R/3r at the share of 99 %
  double p999 = 0;   ///< R/3r at the share of 99.9 %
  double worst = 0;  ///< largest R/3r; infinity if a tet is flat or inverted
};

/// Bin i counts the values v with edges[i] <= v < edges[i+1]; the last bin includes its upper edge.
struct Histogram {
  std::vector<double> edges;          ///< #bins + 1, in the unit of the values, ascending; the last one may be infinity
  std::vector<std::uint64_t> counts;  ///< #bins
};

/// Bad elements that the input forces: those with the cause SmallInputAngle or ThinWall. Without
/// QualityOptions::classify no element counts as forced.
struct ForcedFigures {
  double above = 15;                  ///< the limit of R/3r, as in the options
  std::size_t elements = 0;           ///< number of elements with an R/3r above the limit
  std::size_t small_input_angle = 0;  ///< number of these that a corner forces
  std::size_t thin_wall = 0;          ///< number of these that a thin wall forces
  double worst_other = 0;             ///< the largest R/3r of all elements but the forced ones above the limit

  /// Number of elements whose cause is in the input.
  [[nodiscard]] std::size_t forced() const noexcept { return small_input_angle + thin_wall; }
};

/// What `measure_quality` finds. A mesh without tets has zeros everywhere.
struct QualityReport {
  /// Number of those of the mesh.
  std::size_t vertices = 0;
  /// Number of those of the mesh.
  std::size_t tets = 0;
  RatioFigures ratio;                        ///< Euclidean
  std::optional<RatioFigures> metric_ratio;  ///< in the metric diag(1/l^2, 1/l^2, 1/h^2)
  double metric_l = 0;                       ///< mm, as in the options
  double metric_h = 0;                       ///< mm, as in the options
  double min_dihedral = 0;                   ///< degrees, over all tets; 0 if a tet is flat or inverted
  double max_dihedral = 0;                   ///< degrees, over all tets; 180 if a tet is flat or inverted
  Histogram ratio_histogram;                 ///< of R/3r, #T values
  Histogram dihedral_histogram;              ///< of all six angles of the positive tets, degrees
  std::size_t not_positive = 0;              ///< number of tets that are flat or inverted (floating-point test)
  std::size_t crossing = 0;  ///< number of tets whose z range is not inside one slab, labels not looked at
  /// `crossing` as a share of all tets.
  double crossing_share = 0;
  std::size_t mislabeled = 0;  ///< number of tets that are not inside the slab of their label
  std::size_t columns = 0;     ///< number of tets that have a vertical edge
  /// `columns` as a share of all tets.
  double column_share = 0;
  double volume = 0;                  ///< mm^3, of all tets
  std::vector<double> slab_volume;    ///< #S, mm^3, by label
  std::vector<double> region_volume;  ///< #R, mm^3, by label
  std::vector<WorstTet> worst;        ///< #W, as many as asked for: largest R/3r first, ties by index
  ForcedFigures forced;               ///< what the input makes bad, apart
};

namespace detail {

/// Heights count as inside a slab up to this share of the bounding box diagonal: coordinates that other programs
/// rounded stay inside, drifting off a plane does not.
inline constexpr double kCrossingTolerance = 1e-9;

/// A dihedral angle above this (degrees) makes an element with no short edge a sliver in the list of worst elements.
inline constexpr double kFlatAngle = 150;

/// An edge below this share of the longest edge and of the thickness is called short in the list of worst elements.
inline constexpr double kShortEdge = 0.2;

/// Precondition: not empty. Reorders the values.
[[nodiscard]] inline RatioFigures ratio_figures(std::vector<double>& values, Poll& listen) {
  RatioFigures figures;
  CompensatedSum sum;
  bool finite = true;
  for (const double v : values) {
    listen();
    if (std::isinf(v))
      finite = false;
    else
      sum.add(v);
  }
  figures.mean = finite ? sum.value() / static_cast<double>(values.size()) : std::numeric_limits<double>::infinity();
  auto begin = values.begin();
  const auto smallest_with_share = [&](std::size_t numerator, std::size_t denominator) {
    // Number of values that must be at most the result, rounded up without floating-point error.
    const std::size_t n = values.size();
    const std::size_t needed =
        n / denominator * numerator + (n % denominator * numerator + denominator - 1) / denominator;
    const auto place = values.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(needed, 1) - 1);
    std::nth_element(begin, place, values.end(), listening(listen, std::less<>()));
    begin = place;
    return *place;
  };
  figures.median = smallest_with_share(1, 2);
  figures.p99 = smallest_with_share(99, 100);
  figures.p999 = smallest_with_share(999, 1000);
  figures.worst = *std::max_element(begin, values.end());
  return figures;
}

/// Finds the bin of a value, without branches: values come in no order, and a processor would guess them wrongly.
class BinFinder {
public:
  /// `edges`: at most 63 inner edges of the bins, descending. A value that is an edge belongs to the bin behind it.
  explicit BinFinder(const std::vector<double>& edges) {
    edges_.fill(std::numeric_limits<double>::quiet_NaN());  // not at least anything
    std::copy(edges.begin(), edges.end(), edges_.begin());
  }
  /// How many edges are not below the value.
  [[nodiscard]] std::size_t operator()(double value) const {
    std::size_t bin = 0;
    for (std::size_t step = 32; step > 0; step /= 2) bin += edges_[bin + step - 1] >= value ? step : 0;
    return bin;
  }

private:
  std::array<double, 64> edges_;
};

/// Finds slabs by height.
class SlabFinder {
public:
  SlabFinder(const std::vector<Slab>& slabs, double tolerance) : slabs_(slabs), tolerance_(tolerance) {}
  [[nodiscard]] bool contains(std::size_t slab, double low, double high) const {
    return slabs_[slab].z_low - tolerance_ <= low && high <= slabs_[slab].z_high + tolerance_;
  }
  /// True if some slab contains the range.
  [[nodiscard]] bool in_one(double low, double high) const {
    const auto above = std::upper_bound(slabs_.begin(), slabs_.end(), low,
                                        [this](double z, const Slab& s) { return z < s.z_low - tolerance_; });
    return above != slabs_.begin() && contains(static_cast<std::size_t>(above - slabs_.begin()) - 1, low, high);
  }

private:
  const std::vector<Slab>& slabs_;
  double tolerance_;
};

}  // namespace detail

/// Measure a mesh; definitions as in the documentation of the figures (docs/pipeline).
/// Precondition: slabs ascend and do not overlap. Tets need not be positive or inside their slab: that is reported.
/// Errors: OptionError; Error (Stage::Quality) for a mesh whose arrays do not fit together; Cancelled, by the listener.
/// Cost: linear in #T, 8 bytes per tet (16 with metric figures).
[[nodiscard]] inline QualityReport measure_quality(const Mesh& mesh, const QualityOptions& options = {},
                                                   const Progress& progress = {}) {
  if (!(options.metric_l >= 0) || std::isinf(options.metric_l)) throw OptionError("metric_l", "must be a length >= 0");
  if (!(options.metric_h >= 0) || std::isinf(options.metric_h)) throw OptionError("metric_h", "must be a length >= 0");
  double share = 0;
  const std::function<void()> poll = [&] { slice2mesh::report(progress, Stage::Quality, share); };
  detail::check_mesh_arrays(mesh, Stage::Quality, poll);
  if (!(options.forced_above >= 1)) throw OptionError("forced_above", "must be at least 1");
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::size_t tet_count = mesh.tets.size();
  QualityReport report;
  report.vertices = mesh.vertices.size();
  report.tets = tet_count;
  report.metric_l = options.metric_l;
  report.metric_h = options.metric_h;
  report.forced.above = options.forced_above;
  report.ratio_histogram.edges = {1, 1.1, 1.2, 1.3, 1.4, 1.5, 1.75, 2,  2.5, 3,
                                  4, 5,   6,   8,   10,  15,  20,   50, 100, kInfinity};
  report.ratio_histogram.counts.assign(report.ratio_histogram.edges.size() - 1, 0);
  constexpr std::size_t kAngleBins = 36;
  std::vector<double> cotangents;  // of the inner edges of the bins, descending
  for (std::size_t i = 0; i <= kAngleBins; ++i) {
    const double angle = 180.0 * static_cast<double>(i) / static_cast<double>(kAngleBins);
    report.dihedral_histogram.edges.push_back(angle);
    if (i > 0 && i < kAngleBins) cotangents.push_back(2 * i == kAngleBins ? 0 : 1 / std::tan(angle / detail::kDegrees));
  }
  report.dihedral_histogram.counts.assign(kAngleBins, 0);
  report.slab_volume.assign(mesh.slabs.size(), 0);
  report.region_volume.assign(mesh.regions.size(), 0);
  if (tet_count == 0) return report;

  std::array<double, 3> low = mesh.vertices[static_cast<std::size_t>(mesh.tets[0][0])];
  std::array<double, 3> high = low;
  for (const std::array<double, 3>& p : mesh.vertices)
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], p[i]);
      high[i] = std::max(high[i], p[i]);
    }
  const double diagonal = std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
  const detail::SlabFinder slabs(mesh.slabs, detail::kCrossingTolerance * diagonal);

  const bool with_metric = options.metric_l > 0 && options.metric_h > 0;
  std::vector<double> ratios(tet_count);
  std::vector<double> metric_ratios(with_metric ? tet_count : 0);
  std::vector<detail::CompensatedSum> slab_volume(mesh.slabs.size());
  std::vector<detail::CompensatedSum> region_volume(mesh.regions.size());
  detail::CompensatedSum volume;
  const detail::BinFinder angle_bin_of(cotangents);
  std::vector<double> negative;  // inner edges of the bins, descending
  for (std::size_t i = 1; i + 1 < report.ratio_histogram.edges.size(); ++i)
    negative.push_back(-report.ratio_histogram.edges[i]);
  const detail::BinFinder negative_ratio_bin_of(negative);
  double largest_cotangent = -kInfinity;
  double smallest_cotangent = kInfinity;
  detail::Poll listen(poll, 1 << 13);
  for (std::size_t t = 0; t < tet_count; ++t) {
    share = double(t) / double(tet_count);
    listen();
    TetCorners p;
    for (std::size_t i = 0; i < 4; ++i) p[i] = detail::vertex_of(mesh, t, i);
    const detail::TetFrame frame = detail::tet_frame(p);
    ratios[t] = frame.radius_ratio >= 1 ? frame.radius_ratio : (frame.radius_ratio < 1 ? 1 : kInfinity);
    ++report.ratio_histogram.counts[negative_ratio_bin_of(-ratios[t])];
    if (frame.determinant > 0) {
      for (std::size_t e = 0; e < 6; ++e) {
        const double cotangent = detail::dihedral_cotangent(frame, e);
        largest_cotangent = std::max(largest_cotangent, cotangent);
        smallest_cotangent = std::min(smallest_cotangent, cotangent);
        ++report.dihedral_histogram.counts[angle_bin_of(cotangent)];
      }
    } else {
      ++report.not_positive;
      largest_cotangent = kInfinity;
      smallest_cotangent = -kInfinity;
    }
    if (with_metric) {
      TetCorners q = p;
      for (std::array<double, 3>& corner : q)
        corner = {corner[0] / options.metric_l, corner[1] / options.metric_l, corner[2] / options.metric_h};
      metric_ratios[t] = detail::tet_frame(q).radius_ratio;
    }

    const auto slab = static_cast<std::size_t>(mesh.tet_slab[t]);
    double z_low = p[0][2];
    double z_high = p[0][2];
    for (std::size_t i = 1; i < 4; ++i) {
      z_low = std::min(z_low, p[i][2]);
      z_high = std::max(z_high, p[i][2]);
    }
    if (!slabs.in_one(z_low, z_high)) ++report.crossing;
    if (!slabs.contains(slab, z_low, z_high)) ++report.mislabeled;
    for (const std::array<std::size_t, 2>& e : kTetEdgeVertices)
      if (p[e[0]][0] == p[e[1]][0] && p[e[0]][1] == p[e[1]][1]) {
        ++report.columns;
        break;
      }
    const double tet_volume_value = frame.determinant / 6;
    volume.add(tet_volume_value);
    slab_volume[slab].add(tet_volume_value);
    region_volume[static_cast<std::size_t>(mesh.tet_region[t])].add(tet_volume_value);
  }
  report.min_dihedral = detail::angle_of_cotangent(largest_cotangent);
  report.max_dihedral = detail::angle_of_cotangent(smallest_cotangent);
  report.crossing_share = static_cast<double>(report.crossing) / static_cast<double>(tet_count);
  report.column_share = static_cast<double>(report.columns) / static_cast<double>(tet_count);
  report.volume = volume.value();
  for (std::size_t s = 0; s < slab_volume.size(); ++s) report.slab_volume[s] = slab_volume[s].value();
  for (std::size_t r = 0; r < region_volume.size(); ++r) report.region_volume[r] = region_volume[r].value();

  const auto describe = [&](std::size_t t) {
    TetCorners p;
    WorstTet w;
    for (std::size_t i = 0; i < 4; ++i) {
      p[i] = detail::vertex_of(mesh, t, i);
      for (std::size_t k = 0; k < 3; ++k) w.centroid[k] += p[i][k] / 4;
    }
    const std::array<double, 6> angles = dihedral_angles(p);
    const std::array<double, 6> lengths = edge_lengths(p);
    w.tet = t;
    w.slab = mesh.tet_slab[t];
    w.region = mesh.tet_region[t];
    w.ratio = ratios[t];
    w.min_dihedral = *std::min_element(angles.begin(), angles.end());
    w.max_dihedral = std::isinf(w.ratio) ? 180 : *std::max_element(angles.begin(), angles.end());
    w.shortest_edge = *std::min_element(lengths.begin(), lengths.end());
    w.longest_edge = *std::max_element(lengths.begin(), lengths.end());
    const Slab& slab = mesh.slabs[static_cast<std::size_t>(w.slab)];
    if (w.shortest_edge < detail::kShortEdge * std::min(w.longest_edge, slab.z_high - slab.z_low))
      w.cause = Cause::ShortEdge;
    else if (w.max_dihedral > detail::kFlatAngle)
      w.cause = Cause::Flat;
    if (options.classify) w.cause = options.classify(mesh, w);
    return w;
  };

  // The worst elements: a heap of the worst so far, the least bad of them on top.
  const std::size_t listed = std::min(options.worst_count, tet_count);
  if (listed > 0) {
    const auto worse = [&ratios](std::size_t a, std::size_t b) {
      return ratios[a] != ratios[b] ? ratios[a] > ratios[b] : a < b;
    };
    std::vector<std::size_t> heap;
    for (std::size_t t = 0; t < tet_count; ++t) {
      listen();
      if (heap.size() == listed) {
        if (!worse(t, heap.front())) continue;
        std::pop_heap(heap.begin(), heap.end(), worse);
        heap.pop_back();
      }
      heap.push_back(t);
      std::push_heap(heap.begin(), heap.end(), worse);
    }
    std::sort_heap(heap.begin(), heap.end(), worse);
    for (const std::size_t t : heap) report.worst.push_back(describe(t));
  }
  for (std::size_t t = 0; t < tet_count; ++t) {
    listen();
    if (ratios[t] > options.forced_above) {
      // A classifier may look at the neighborhood of the element.
      if (report.forced.elements % 64 == 0) poll();
      ++report.forced.elements;
      const Cause cause = options.classify ? describe(t).cause : Cause::Unknown;
      if (cause == Cause::SmallInputAngle) ++report.forced.small_input_angle;
      if (cause == Cause::ThinWall) ++report.forced.thin_wall;
      if (cause == Cause::SmallInputAngle || cause == Cause::ThinWall) continue;
    }
    report.forced.worst_other = std::max(report.forced.worst_other, ratios[t]);
  }
  poll();
  report.ratio = detail::ratio_figures(ratios, listen);
  if (with_metric) report.metric_ratio = detail::ratio_figures(metric_ratios, listen);
  return report;
}

}  // namespace slice2mesh
