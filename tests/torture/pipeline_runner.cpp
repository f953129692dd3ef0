// SPDX-License-Identifier: MIT
#include "torture/pipeline_runner.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <exception>
#include <utility>

#include "slice2mesh/arrange/segment_index.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/harmonize/harmonize.hpp"
#include "slice2mesh/pipeline/slice_to_mesh.hpp"
#include "slice2mesh/regions/base_plate.hpp"
#include "slice2mesh/regions/regions.hpp"
#include "slice2mesh/regions/slabs.hpp"

namespace slice2mesh_test {

using namespace slice2mesh;

const char* to_string(Ending ending) noexcept {
  switch (ending) {
    case Ending::Certified: return "certified";
    case Ending::OptionError: return "OptionError";
    case Ending::GeometryError: return "GeometryError";
    case Ending::TetrahedralizationError: return "TetrahedralizationError";
    case Ending::BudgetError: return "BudgetError";
    case Ending::Cancelled: return "Cancelled";
    case Ending::OtherError: return "Error";
    case Ending::NotCertified: return "NOT CERTIFIED";
    case Ending::NotWhatItSays: return "NOT WHAT IT SAYS";
    case Ending::Foreign: return "FOREIGN EXCEPTION";
  }
  return "unknown";
}

namespace {

// Area of the walls of the complex, mm^2.
double wall_area(const Plc& plc) {
  double area = 0;
  for (const Facet& facet : plc.facets) {
    if (facet.label != FacetLabel::Wall && facet.label != FacetLabel::InnerWall) continue;
    std::array<std::array<double, 3>, 3> p{};
    for (std::size_t i = 0; i < 3; ++i) p[i] = plc.position(static_cast<std::size_t>(facet.vertices[i]));
    double low = p[0][2], high = low, length = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      low = std::min(low, p[i][2]);
      high = std::max(high, p[i][2]);
      length = std::max(length, std::hypot(p[i][0] - p[(i + 1) % 3][0], p[i][1] - p[(i + 1) % 3][1]));
    }
    area += length * (high - low) / 2;
  }
  return area;
}

// What is wrong with a result that calls itself certified; empty if nothing is.
std::string contradiction(const Result& result) {
  const Mesh& mesh = result.mesh;
  if (mesh.tets.empty()) return "no tets";
  if (mesh.tet_slab.size() != mesh.tets.size() || mesh.tet_region.size() != mesh.tets.size()) return "lengths";
  if (result.report.max_deviation > result.report.eps) return "the deviation is above eps";
  if (result.report.quality.crossing != 0) return "tets cross layers";
  const Certificate& certificate = result.report.certificate;
  // Points that split walls are rounded: by a pitch at most, along each axis.
  const double rounding = 2 * result.plc.grid.pitch * wall_area(result.plc);
  if (!(std::fabs(certificate.volume - certificate.expected_volume) <= 1e-9 * certificate.expected_volume + rounding))
    return "volume " + std::to_string(certificate.volume) + " instead of " +
           std::to_string(certificate.expected_volume);
  std::vector<char> seen(mesh.slabs.size(), 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const auto slab = static_cast<std::size_t>(mesh.tet_slab[t]);
    seen[slab] = 1;
    for (const std::int32_t v : mesh.tets[t]) {
      const double z = mesh.vertices[static_cast<std::size_t>(v)][2];
      if (z != mesh.slabs[slab].z_low && z != mesh.slabs[slab].z_high) return "a vertex between the planes of its slab";
    }
  }
  for (const char s : seen)
    if (s == 0) return "a slab without tets";
  return {};
}

std::string failed_checks(const Certificate& certificate) {
  std::string text;
  for (const CertificateCheck& check : certificate.checks)
    if (!check.passed) text += (text.empty() ? "" : "; ") + check.name + ": " + check.detail;
  return text;
}

}  // namespace

Outcome run_pipeline(const SliceStack& stack, const Options& options) {
  Outcome outcome;
  const auto ended = [&outcome](Ending ending, const std::exception& error) {
    outcome.ending = ending;
    outcome.message = error.what();
  };
  try {
    Result result = slice_to_mesh(stack, options);
    outcome.ending = Ending::Certified;
    if (!result.report.certificate.passed()) {
      outcome.ending = Ending::NotCertified;
      outcome.message = failed_checks(result.report.certificate);
    } else if (outcome.message = contradiction(result); !outcome.message.empty()) {
      outcome.ending = Ending::NotWhatItSays;
    }
    outcome.mesh = std::move(result.mesh);
    outcome.plc = std::move(result.plc);
    outcome.certificate = std::move(result.report.certificate);
    outcome.diagnostics = std::move(result.diagnostics);
    outcome.eps = result.report.eps;
    outcome.max_deviation = result.report.max_deviation;
    outcome.seconds = std::move(result.report.seconds);
  } catch (const OptionError& error) {
    ended(Ending::OptionError, error);
  } catch (const GeometryError& error) {
    // An error that calls itself a defect is one.
    ended(std::string(error.what()).find("defect of slice2mesh") == std::string::npos ? Ending::GeometryError
                                                                                      : Ending::NotCertified,
          error);
  } catch (const TetrahedralizationError& error) {
    ended(Ending::TetrahedralizationError, error);
  } catch (const BudgetError& error) {
    ended(Ending::BudgetError, error);
  } catch (const Cancelled& error) {
    ended(Ending::Cancelled, error);
  } catch (const Error& error) {
    ended(Ending::OtherError, error);
  } catch (const std::exception& error) {
    ended(Ending::Foreign, error);
  }
  return outcome;
}

std::vector<double> united_areas(const SliceStack& stack, const Options& options) {
  Diagnostics diagnostics;
  const SlabPlan plan = make_slabs(stack, options.slabs, diagnostics);
  const LayerRegions regions = build_regions(stack, plan, options.supports, diagnostics);
  std::vector<double> areas;
  for (const Outline& outline : regions.outlines)
    areas.push_back(static_cast<double>(slice2mesh::detail::doubled_area(outline, kNone)) / 2 * regions.grid.pitch *
                    regions.grid.pitch);
  return areas;
}

bool exact_neighbors_nearly_coincide(const SliceStack& stack, const Options& options) {
  if (options.eps.value != 0) return false;
  Diagnostics diagnostics;
  const SlabPlan plan = make_slabs(stack, options.slabs, diagnostics);
  const LayerRegions regions = build_regions_on_plate(stack, plan, options.supports, options.plate, diagnostics);
  const double limit = slice2mesh::detail::kSmallestEps;
  const auto nearly = [&](const Outline& vertices, const Outline& edges) {
    const slice2mesh::detail::SegmentIndex index(edges);
    return std::any_of(vertices.vertices.begin(), vertices.vertices.end(), [&](const GridPoint& p) {
      const auto near = index.nearest(p, limit);
      return near.segment >= 0 && near.distance > 0;
    });
  };
  for (std::size_t s = 0; s + 1 < regions.outlines.size(); ++s) {
    const Outline &below = regions.outlines[s], &above = regions.outlines[s + 1];
    if (nearly(below, above) || nearly(above, below)) return true;
  }
  return false;
}

std::vector<double> slab_volumes(const Mesh& mesh) {
  std::vector<long double> sums(mesh.slabs.size(), 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    long double e[3][3];
    const auto& o = mesh.vertices[static_cast<std::size_t>(mesh.tets[t][0])];
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k)
        e[i][k] = static_cast<long double>(mesh.vertices[static_cast<std::size_t>(mesh.tets[t][i + 1])][k]) - o[k];
    sums[static_cast<std::size_t>(mesh.tet_slab[t])] +=
        (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) - e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
         e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
        6;
  }
  std::vector<double> volumes;
  volumes.reserve(sums.size());
  for (const long double sum : sums) volumes.push_back(static_cast<double>(sum));
  return volumes;
}

bool same_mesh(const Mesh& a, const Mesh& b) {
  const auto same_facet = [](const Facet& f, const Facet& g) {
    return f.vertices == g.vertices && f.label == g.label && f.front == g.front && f.back == g.back && f.wall == g.wall;
  };
  if (a.facets.size() != b.facets.size()) return false;
  for (std::size_t i = 0; i < a.facets.size(); ++i)
    if (!same_facet(a.facets[i], b.facets[i])) return false;
  return a.vertices == b.vertices && a.tets == b.tets && a.tet_slab == b.tet_slab && a.tet_region == b.tet_region;
}

std::uint64_t fingerprint(const Mesh& mesh) {
  std::uint64_t hash = 14695981039346656037U;
  const auto add = [&hash](const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 1099511628211U;
  };
  for (const auto& v : mesh.vertices) add(v.data(), sizeof(v));
  for (const auto& t : mesh.tets) add(t.data(), sizeof(t));
  add(mesh.tet_slab.data(), mesh.tet_slab.size() * sizeof(std::int32_t));
  add(mesh.tet_region.data(), mesh.tet_region.size() * sizeof(std::int32_t));
  for (const Facet& f : mesh.facets) {
    add(f.vertices.data(), sizeof(f.vertices));
    const auto label = static_cast<unsigned char>(f.label);
    add(&label, 1);
  }
  return hash;
}

}  // namespace slice2mesh_test
