// SPDX-License-Identifier: MIT
/// @file
/// @brief The axioms of a tetrahedralizer: what its meshes must be, checked at run time.
///
///     const slice2mesh::AxiomReport report = slice2mesh::check_tetrahedralizer(my_mesher, plc);
///     if (!report.passed()) std::cerr << report.text();
///
/// Which of them hold for any model and which only where its traits say so is in docs/tetrahedralizers.md. Nothing is
/// taken on trust: the checks use the coordinates of the mesh and the complex, no result of the model's own.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "slice2mesh/core/compensated_sum.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/fem/boundary_sets.hpp"
#include "slice2mesh/plc/plc_checks.hpp"
#include "slice2mesh/quality/certificate.hpp"
#include "slice2mesh/tet/restore_layers.hpp"
#include "slice2mesh/tet/tetrahedralizer.hpp"

namespace slice2mesh {

/// What was found about an axiom.
enum class AxiomStatus : std::uint8_t {
  Passed,      ///< holds
  Failed,      ///< does not hold, though it must or the traits promise it
  NotPromised  ///< does not hold, and the traits do not say that it does
};

/// The name in words.
[[nodiscard]] constexpr const char* to_string(AxiomStatus status) noexcept {
  switch (status) {
    case AxiomStatus::Passed: return "passed";
    case AxiomStatus::Failed: return "FAILED";
    case AxiomStatus::NotPromised: return "not promised";
  }
  return "unknown";
}

/// One axiom: its name, for programs, and what was found, for people.
struct Axiom {
  /// For programs.
  std::string name;
  /// What was found.
  AxiomStatus status = AxiomStatus::Passed;
  /// For people: numbers, and the first offenders.
  std::string detail;
};

/// What the checks found. The axioms, in this order: `structure`, `positive`, `faces`, `no_orphans`, `total_volume`,
/// `cell_volumes`, `one_slab`, `cell_labels`, `facets` and, from `check_tetrahedralizer`, `typed_errors` and
/// `same_twice`. After a structure that is not sound the others are left out.
struct AxiomReport {
  /// What the model promises.
  TetrahedralizerTraits traits;
  /// One per name above, in that order.
  std::vector<Axiom> axioms;
  LayerReport layers;  ///< empty if the structure is not sound

  /// True if there are axioms and none of them failed.
  [[nodiscard]] bool passed() const {
    return !axioms.empty() &&
           std::none_of(axioms.begin(), axioms.end(), [](const Axiom& a) { return a.status == AxiomStatus::Failed; });
  }
  /// The axiom of that name, or nullptr.
  [[nodiscard]] const Axiom* find(const std::string& name) const {
    for (const Axiom& axiom : axioms)
      if (axiom.name == name) return &axiom;
    return nullptr;
  }
  /// One line per axiom.
  [[nodiscard]] std::string text() const {
    std::string lines;
    for (const Axiom& axiom : axioms)
      lines += traits.name + ": " + axiom.name + " " + to_string(axiom.status) +
               (axiom.detail.empty() ? "" : ": " + axiom.detail) + "\n";
    return lines;
  }
};

/// Tolerances of `check_axioms`.
struct AxiomOptions {
  /// Relative difference (a ratio) of volumes and areas where facets are kept: rounded coordinates and the bends of
  /// walls.
  double exact_tolerance = 1e-7;
  /// Relative difference (a ratio) of the total volume where they are not.
  double approximate_tolerance = 0.05;
  std::size_t max_offenders = 3;  ///< how many offenders of an axiom are named
};

namespace detail {

class AxiomChecker {
public:
  AxiomChecker(const Mesh& mesh, const Plc& plc, const TetrahedralizerTraits& traits, const AxiomOptions& options,
               const Progress& progress)
      : mesh_(mesh), plc_(plc), options_(options), progress_(progress), keeps_(traits.facets != FacetKeeping::No),
        tolerance_(kCrossingTolerance * diagonal_of(plc)), cells_(plc) {
    report_.traits = traits;
  }

  [[nodiscard]] AxiomReport run() {
    if (!check_structure()) return std::move(report_);
    poll_();
    triangles_ = sorted_triangles(mesh_.tets);
    poll_();
    report_.layers = measure_layers(mesh_, plc_);
    poll_();
    check_positive();
    poll_();
    check_faces();
    poll_();
    check_orphans();
    check_volumes();
    poll_();
    check_slabs();
    poll_();
    check_labels();
    poll_();
    if (report_.traits.facets == FacetKeeping::Exactly && plc_.has_inner_faces)
      check_exact_facets();
    else
      check_covering_facets();
    return std::move(report_);
  }

private:
  [[nodiscard]] CheckNotes notes() const { return CheckNotes(options_.max_offenders); }
  void add(const std::string& name, const CheckNotes& found, const std::string& good, const std::string& bad,
           bool promised) {
    const CertificateCheck check = found.check(name, good, bad);
    const AxiomStatus otherwise = promised ? AxiomStatus::Failed : AxiomStatus::NotPromised;
    report_.axioms.push_back({name, check.passed ? AxiomStatus::Passed : otherwise, check.detail});
  }
  [[nodiscard]] static std::string tet_text(std::size_t t) { return "tet " + std::to_string(t); }
  [[nodiscard]] Side cell(std::int32_t t) const {
    return {mesh_.tet_slab[static_cast<std::size_t>(t)], mesh_.tet_region[static_cast<std::size_t>(t)]};
  }
  [[nodiscard]] static bool near(double a, double b, double tolerance) {
    return std::fabs(a - b) <= tolerance * std::max(std::fabs(a), std::fabs(b));
  }

  [[nodiscard]] bool check_structure() {
    CheckNotes found = notes();
    const auto offend = [&found](const std::string& text) { found.offend([&text] { return text; }); };
    const std::size_t count = mesh_.tets.size();
    if (count == 0) offend("no tets");
    if (mesh_.tet_slab.size() != count) offend("#tet_slab is not #tets");
    if (mesh_.tet_region.size() != count) offend("#tet_region is not #tets");
    bool slabs = mesh_.slabs.size() == plc_.slabs.size();
    for (std::size_t s = 0; slabs && s < plc_.slabs.size(); ++s)
      slabs = mesh_.slabs[s].z_low == plc_.slabs[s].z_low && mesh_.slabs[s].z_high == plc_.slabs[s].z_high;
    if (!slabs) offend("the slabs are not those of the complex");
    if (mesh_.regions.size() != plc_.regions.size()) offend("#regions is not that of the complex");
    for (std::size_t v = 0; v < mesh_.vertices.size(); ++v)
      for (const double c : mesh_.vertices[v])
        if (!std::isfinite(c)) {
          offend("vertex " + std::to_string(v) + " is not finite");
          break;
        }
    for (std::size_t t = 0; t < count; ++t) {
      const std::array<std::int32_t, 4>& tet = mesh_.tets[t];
      bool good = t >= mesh_.tet_slab.size() || in_range(mesh_.tet_slab[t], plc_.slabs.size());
      good = good && (t >= mesh_.tet_region.size() || in_range(mesh_.tet_region[t], plc_.regions.size()));
      for (std::size_t i = 0; i < 4; ++i) {
        good = good && in_range(tet[i], mesh_.vertices.size());
        for (std::size_t j = 0; j < i; ++j) good = good && tet[i] != tet[j];
      }
      if (!good) offend(tet_text(t));
    }
    for (std::size_t f = 0; f < mesh_.facets.size(); ++f) {
      const Facet& facet = mesh_.facets[f];
      bool good = static_cast<std::uint8_t>(facet.label) <= 4 && !facet.back.empty();
      for (const std::int32_t v : facet.vertices) good = good && in_range(v, mesh_.vertices.size());
      for (const Side* side : {&facet.back, &facet.front})
        good = good && (side->empty() ||
                        (in_range(side->slab, plc_.slabs.size()) && in_range(side->region, plc_.regions.size())));
      if (!good) offend("facet " + std::to_string(f));
    }
    add("structure", found, "sizes, indices and coordinates are sound", "defects", true);
    return found.count() == 0;
  }

  void check_positive() {
    CheckNotes found = notes();
    Poll listen(poll_, 1 << 13);
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      listen();
      const int sign =
          exact_volume(vertex_of(mesh_, t, 0), vertex_of(mesh_, t, 1), vertex_of(mesh_, t, 2), vertex_of(mesh_, t, 3))
              .sign;
      if (sign <= 0) found.offend([&] { return tet_text(t) + (sign == 0 ? " is flat" : " is inverted"); });
    }
    add("positive", found, "every tet is positive, by an exact predicate", "tets are not positive", true);
  }

  void check_faces() {
    CheckNotes found = notes();
    for (std::size_t i = 0; i < triangles_.size();) {
      std::size_t j = i + 1;
      while (j < triangles_.size() && triangles_[j].key == triangles_[i].key) ++j;
      bool good = j - i <= 2;
      if (j - i == 2) good = orientation(triangles_[i]) != orientation(triangles_[i + 1]);
      if (!good)
        found.offend([&] {
          return std::to_string(j - i) + " tets on a face of " + tet_text(std::size_t(triangles_[i].tet)) +
                 (j - i == 2 ? ", both on the same side" : "");
        });
      i = j;
    }
    add("faces", found, "a face has one tet on either side, or one alone", "faces with tets that overlap", true);
  }
  /// Is the outward order of a face an even permutation of its sorted vertices?
  [[nodiscard]] bool orientation(const TriangleOfTet& f) const {
    const std::array<std::int32_t, 3> v = face_vertices(mesh_, {f.tet, f.face});
    return (v[0] == f.key[0] && v[1] == f.key[1]) || (v[1] == f.key[0] && v[2] == f.key[1]) ||
           (v[2] == f.key[0] && v[0] == f.key[1]);
  }

  void check_orphans() {
    CheckNotes found = notes();
    std::vector<char> used(mesh_.vertices.size(), 0);
    for (const std::array<std::int32_t, 4>& tet : mesh_.tets)
      for (const std::int32_t v : tet) used[static_cast<std::size_t>(v)] = 1;
    for (std::size_t v = 0; v < used.size(); ++v)
      if (used[v] == 0) found.offend([v] { return "vertex " + std::to_string(v); });
    add("no_orphans", found, "every vertex belongs to a tet", "vertices belong to no tet", true);
  }

  void check_volumes() {
    const LayerReport& layers = report_.layers;
    CheckNotes total = notes();
    const double tolerance = keeps_ ? options_.exact_tolerance : options_.approximate_tolerance;
    if (!near(layers.volume, layers.exact_volume, tolerance))
      total.offend([&] { return number_text(layers.volume) + " mm^3 instead of " + number_text(layers.exact_volume); });
    add("total_volume", total, "relative error " + number_text(layers.volume_error), "wrong volume", true);

    CheckNotes found = notes();
    const std::size_t regions = plc_.regions.size();
    const bool by_region = plc_.has_inner_faces;
    std::vector<double> exact = exact_cell_volumes(plc_);
    std::vector<CompensatedSum> sums(exact.size());
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      const auto region = by_region ? static_cast<std::size_t>(mesh_.tet_region[t]) : 0;
      sums[static_cast<std::size_t>(mesh_.tet_slab[t]) * regions + region].add(
          sixfold_volume(mesh_.vertices, mesh_.tets[t]) / 6);
    }
    for (std::size_t s = 0; s < plc_.slabs.size(); ++s) {
      double slab = 0;  // a small region is judged by its slab's volume: walls bend
      for (std::size_t r = 0; r < regions; ++r) slab += exact[s * regions + r];
      if (!by_region) {
        std::fill_n(exact.begin() + std::ptrdiff_t(s * regions), regions, 0);
        exact[s * regions] = slab;
      }
      for (std::size_t r = 0; r < regions; ++r) {
        const double wanted = exact[s * regions + r], is = sums[s * regions + r].value();
        if (!(std::fabs(is - wanted) <= options_.exact_tolerance * slab))
          found.offend([&] {
            return "slab " + std::to_string(s) + (by_region ? " region " + std::to_string(r) : std::string()) + ": " +
                   number_text(is) + " mm^3 instead of " + number_text(wanted);
          });
      }
    }
    add("cell_volumes", found, "the volumes of every slab and region are area x height", "cells have another volume",
        keeps_);
  }

  void check_slabs() {
    CheckNotes found = notes();
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      const auto [low, high] = heights(t);
      const std::int32_t slab = mesh_.tet_slab[t];
      if (inside(slab, low, high)) continue;
      crossing_.push_back(t);
      found.offend([&, l = low, h = high] {
        return tet_text(t) + " of slab " + std::to_string(slab) + " reaches from z = " + number_text(l) + " to " +
               number_text(h);
      });
    }
    add("one_slab", found, "every tet lies in its slab", "tets do not lie in their slab", keeps_);
  }
  [[nodiscard]] std::pair<double, double> heights(std::size_t t) const {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t k = 0; k < 4; ++k) {
      low = std::min(low, vertex_of(mesh_, t, k)[2]);
      high = std::max(high, vertex_of(mesh_, t, k)[2]);
    }
    return {low, high};
  }
  [[nodiscard]] bool inside(std::int32_t slab, double low, double high) const {
    const Slab& range = plc_.slabs[static_cast<std::size_t>(slab)];
    return range.z_low - tolerance_ <= low && high <= range.z_high + tolerance_;
  }

  // The labels are those of the place where a tet is. What crosses layers must at least touch the slab of its label.
  void check_labels() {
    CheckNotes wrong_slab = notes(), wrong_region = notes();
    std::size_t next_crossing = 0;
    // Walls bend by half a pitch and thin tets hug them: this near to a wall either of its sides will do.
    const double hug = tolerance_ + 2 * plc_.grid.pitch;
    Poll listen(poll_, 1 << 10);
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      listen();
      const std::int32_t slab = mesh_.tet_slab[t];
      if (next_crossing < crossing_.size() && crossing_[next_crossing] == t) {
        ++next_crossing;
        const auto [low, high] = heights(t);
        const Slab& range = plc_.slabs[static_cast<std::size_t>(slab)];
        if (cells_.slab_of(low, high, tolerance_) != kNone || high < range.z_low || low > range.z_high)
          wrong_slab.offend([&] { return tet_text(t) + " is labelled slab " + std::to_string(slab); });
        continue;
      }
      double x = 0, y = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        x += vertex_of(mesh_, t, k)[0] / 4;
        y += vertex_of(mesh_, t, k)[1] / 4;
      }
      const std::int32_t region = cells_.region_at(slab, x, y);
      const bool same = plc_.has_inner_faces ? region == mesh_.tet_region[t] : region != kNone;
      if (!same && cells_.nearest_wall(slab, x, y).distance > hug)
        wrong_region.offend([&] {
          return tet_text(t) + " is labelled region " + std::to_string(mesh_.tet_region[t]) + " but lies " +
                 (region == kNone ? "outside" : "in region " + std::to_string(region));
        });
    }
    if (wrong_slab.count() > 0)
      add("cell_labels", wrong_slab, "", "tets have the label of a slab that they do not touch", true);
    else
      add("cell_labels", wrong_region, "slab and region are those of the place", "tets have the label of another place",
          keeps_);
  }

  // Every facet of the complex is a facet of the mesh with the same label and sides, and the faces of the mesh are
  // there: the certificate knows how.
  void check_exact_facets() {
    CheckNotes found = notes();
    const auto place = [](const std::array<double, 3>& a, const std::array<double, 3>& b,
                          const std::array<double, 3>& c, const Facet& facet) {
      std::array<std::array<double, 3>, 3> p{a, b, c};
      std::rotate(p.begin(), std::min_element(p.begin(), p.end()), p.end());
      return std::make_tuple(p, static_cast<int>(facet.label), facet.back.slab, facet.back.region, facet.front.slab,
                             facet.front.region);
    };
    using Place = decltype(place({}, {}, {}, Facet{}));
    std::vector<std::pair<Place, std::size_t>> wanted, given;
    for (std::size_t f = 0; f < plc_.facets.size(); ++f) {
      const auto& v = plc_.facets[f].vertices;
      wanted.emplace_back(place(plc_.position(std::size_t(v[0])), plc_.position(std::size_t(v[1])),
                                plc_.position(std::size_t(v[2])), plc_.facets[f]),
                          f);
    }
    for (std::size_t f = 0; f < mesh_.facets.size(); ++f) {
      const auto& v = mesh_.facets[f].vertices;
      given.emplace_back(place(mesh_.vertices[std::size_t(v[0])], mesh_.vertices[std::size_t(v[1])],
                               mesh_.vertices[std::size_t(v[2])], mesh_.facets[f]),
                         f);
    }
    std::sort(wanted.begin(), wanted.end());
    std::sort(given.begin(), given.end());
    for (std::size_t i = 0, j = 0; i < wanted.size() || j < given.size();) {
      const bool missing = j == given.size() || (i < wanted.size() && wanted[i].first < given[j].first);
      const bool extra = i == wanted.size() || (j < given.size() && given[j].first < wanted[i].first);
      if (missing)
        found.offend([&] {
          return "facet " + std::to_string(wanted[i].second) + " of the complex is not in the list of the mesh";
        });
      else if (extra)
        found.offend([&] {
          return "facet " + std::to_string(given[j].second) +
                 " of the mesh is not in the complex, or labelled otherwise";
        });
      if (!extra) ++i;
      if (!missing) ++j;
    }
    const Certificate certificate = certify(mesh_, plc_, {}, progress_);
    for (const char* name : {"interface_triangles", "faces", "skin"}) {
      const CertificateCheck* check = certificate.find(name);
      if (check == nullptr || !check->passed)
        found.offend([&] { return std::string(name) + ": " + (check == nullptr ? "not checked" : check->detail); });
    }
    add("facets", found, "every facet of the complex is there, with its label", "facets are missing or wrong", true);
  }

  // The facets of the mesh are just its faces between cells, and they cover those of the complex.
  void check_covering_facets() {
    CheckNotes found = notes();
    check_listed_facets(found);
    // Areas by what a facet is: its label and the cells on its sides, which also say in which plane it is.
    using Kind = std::array<std::int32_t, 5>;
    const auto kind = [&](const Facet& f) {
      const bool by_region = plc_.has_inner_faces;
      return Kind{static_cast<std::int32_t>(f.label), f.back.slab, by_region ? f.back.region : 0, f.front.slab,
                  by_region || f.front.empty() ? f.front.region : 0};
    };
    const auto area = [](const std::array<double, 3>& a, const std::array<double, 3>& b,
                         const std::array<double, 3>& c) {
      const std::array<double, 3> n = cross(difference(b, a), difference(c, a));
      return std::sqrt(dot(n, n)) / 2;
    };
    struct Areas {
      CompensatedSum wanted, given;
    };
    std::map<Kind, Areas> areas;
    std::map<std::int32_t, CompensatedSum> of_slab;  // what small areas are judged by: walls bend
    for (const Facet& facet : plc_.facets) {
      const double a =
          area(plc_.position(std::size_t(facet.vertices[0])), plc_.position(std::size_t(facet.vertices[1])),
               plc_.position(std::size_t(facet.vertices[2])));
      areas[kind(facet)].wanted.add(a);
      of_slab[facet.back.slab].add(a);
    }
    std::size_t f = 0;
    Poll listen(poll_, 1 << 10);
    for (const Facet& facet : mesh_.facets) {
      listen();
      const std::size_t index = f++;
      if (!plc_.has_inner_faces && !facet.front.empty()) continue;
      const auto& a = mesh_.vertices[std::size_t(facet.vertices[0])];
      const auto& b = mesh_.vertices[std::size_t(facet.vertices[1])];
      const auto& c = mesh_.vertices[std::size_t(facet.vertices[2])];
      areas[kind(facet)].given.add(area(a, b, c));
      if (!on_complex(facet, {a, b, c}))
        found.offend(
            [&] { return "facet " + std::to_string(index) + " (" + to_string(facet.label) + ") is off the complex"; });
    }
    for (const auto& [key, sums] : areas) {
      const double wanted = sums.wanted.value(), given = sums.given.value();
      const double scale = std::max(wanted, of_slab[key[1]].value());
      if (std::fabs(wanted - given) <= options_.exact_tolerance * scale) continue;
      found.offend([&, k = key] {
        return std::string(to_string(static_cast<FacetLabel>(k[0]))) + " of slab " + std::to_string(k[1]) + " region " +
               std::to_string(k[2]) + ": " + number_text(given) + " mm^2 instead of " + number_text(wanted);
      });
    }
    add("facets", found, "faces of the mesh cover the facets of the complex, with their labels",
        "facets are missing or wrong", keeps_);
  }

  // Is a facet of the mesh on facets of the complex of its kind?
  [[nodiscard]] bool on_complex(const Facet& facet, const std::array<std::array<double, 3>, 3>& p) const {
    const Slab& slab = plc_.slabs[static_cast<std::size_t>(facet.back.slab)];
    if (facet.label == FacetLabel::Wall || facet.label == FacetLabel::InnerWall) {
      const double distance = tolerance_ + 2 * plc_.grid.pitch;
      std::array<double, 2> middle{};
      for (const std::array<double, 3>& q : p) {
        if (q[2] < slab.z_low - tolerance_ || q[2] > slab.z_high + tolerance_) return false;
        for (std::size_t k = 0; k < 2; ++k) middle[k] += q[k] / 3;
      }
      return cells_.near_wall(facet.back.slab, facet.back.region, facet.front.region, middle[0], middle[1], distance);
    }
    const double z = facet.label == FacetLabel::Down ? slab.z_low : slab.z_high;
    return std::all_of(p.begin(), p.end(),
                       [&](const std::array<double, 3>& q) { return std::fabs(q[2] - z) <= tolerance_; });
  }

  // The list of facets is the list of faces between different cells, with the right sides, each once.
  void check_listed_facets(CheckNotes& found) const {
    struct Listed {
      std::array<std::int32_t, 3> key;
      std::size_t facet;
      bool operator<(const Listed& o) const { return key != o.key ? key < o.key : facet < o.facet; }
    };
    std::vector<Listed> listed;
    for (std::size_t f = 0; f < mesh_.facets.size(); ++f) {
      std::array<std::int32_t, 3> key = mesh_.facets[f].vertices;
      std::sort(key.begin(), key.end());
      listed.push_back({key, f});
    }
    std::sort(listed.begin(), listed.end());
    std::size_t next = 0;
    const auto no_face = [&](std::size_t f) {
      found.offend([f] { return "facet " + std::to_string(f) + " is no face between two cells"; });
    };
    for (std::size_t i = 0; i < triangles_.size();) {
      std::size_t j = i + 1;
      while (j < triangles_.size() && triangles_[j].key == triangles_[i].key) ++j;
      const TriangleOfTet* first = &triangles_[i];
      const TriangleOfTet* second = j - i >= 2 ? &triangles_[i + 1] : nullptr;
      i = j;
      for (; next < listed.size() && listed[next].key < first->key; ++next) no_face(listed[next].facet);
      const bool wanted = second == nullptr || !(cell(first->tet) == cell(second->tet));
      std::size_t seen = 0;
      for (; next < listed.size() && listed[next].key == first->key; ++next) {
        const Facet& facet = mesh_.facets[listed[next].facet];
        if (!wanted || ++seen > 1) {
          no_face(listed[next].facet);
          continue;
        }
        // The normal points out of the back: the face of the tet there, seen from it, has the order of the facet.
        const auto fits = [&](const TriangleOfTet* back, const TriangleOfTet* front) {
          const std::array<std::int32_t, 3> v = face_vertices(mesh_, {back->tet, back->face});
          const auto& w = facet.vertices;
          const bool same = v == w || (v[1] == w[0] && v[2] == w[1]) || (v[2] == w[0] && v[0] == w[1]);
          return same && facet.back == cell(back->tet) &&
                 (front == nullptr ? facet.front.empty() : facet.front == cell(front->tet));
        };
        if (!fits(first, second) && (second == nullptr || !fits(second, first)))
          found.offend([&] { return "facet " + std::to_string(listed[next].facet) + " has other cells on its sides"; });
      }
      if (wanted && seen == 0)
        found.offend(
            [&] { return "a face of " + tet_text(std::size_t(first->tet)) + " is not in the list of facets"; });
    }
    for (; next < listed.size(); ++next) no_face(listed[next].facet);
  }

  const Mesh& mesh_;
  const Plc& plc_;
  AxiomOptions options_;
  const Progress& progress_;
  std::function<void()> poll_ = [this] { report(progress_, Stage::Certify, 0); };
  bool keeps_;
  double tolerance_;  // mm
  CellLocator cells_;
  std::vector<TriangleOfTet> triangles_;
  std::vector<std::size_t> crossing_;
  AxiomReport report_;
};

[[nodiscard]] inline bool same_mesh(const Mesh& a, const Mesh& b) {
  const auto same_facet = [](const Facet& f, const Facet& g) {
    return f.vertices == g.vertices && f.label == g.label && f.front == g.front && f.back == g.back && f.wall == g.wall;
  };
  return a.vertices == b.vertices && a.tets == b.tets && a.tet_slab == b.tet_slab && a.tet_region == b.tet_region &&
         std::equal(a.facets.begin(), a.facets.end(), b.facets.begin(), b.facets.end(), same_facet);
}

}  // namespace detail

/// Checks a mesh of a complex against the axioms of a tetrahedralizer with these traits.
/// Errors: TetrahedralizationError if the complex itself is not sound; Cancelled, by the listener. Cost: O(n log n).
[[nodiscard]] inline AxiomReport check_axioms(const Mesh& mesh, const Plc& plc, const TetrahedralizerTraits& traits,
                                              const AxiomOptions& options = {}, const Progress& progress = {}) {
  detail::require_sound(plc);
  return detail::AxiomChecker(mesh, plc, traits, options, progress).run();
}

/// Runs a model and checks its mesh, then runs a copy of it and compares.
///
/// A model may fail on a complex, with an error of the library: that error goes on to the caller. Anything else that it
/// throws breaks the axiom `typed_errors`.
/// Errors: TetrahedralizationError if the complex is not sound; those of the model.
[[nodiscard]] inline AxiomReport check_tetrahedralizer(const AnyTetrahedralizer& model, const Plc& plc,
                                                       const AxiomOptions& options = {}) {
  detail::require_sound(plc);
  AxiomReport report;
  try {
    const Mesh mesh = model(plc);
    report = check_axioms(mesh, plc, model.traits(), options);
    report.axioms.push_back({"typed_errors", AxiomStatus::Passed, "nothing was thrown"});
    const AnyTetrahedralizer copy = model.copy();
    if (detail::same_mesh(mesh, copy(plc)))
      report.axioms.push_back({"same_twice", AxiomStatus::Passed, "a copy of the model gives the same mesh"});
    else
      report.axioms.push_back({"same_twice",
                               report.traits.deterministic ? AxiomStatus::Failed : AxiomStatus::NotPromised,
                               "a copy of the model gives another mesh"});
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    report.traits = model.traits();
    report.axioms.push_back(
        {"typed_errors", AxiomStatus::Failed, "threw what is no error of the library: " + std::string(error.what())});
  }
  return report;
}

}  // namespace slice2mesh
