// SPDX-License-Identifier: MIT
#include "slice2mesh/quality/quality.hpp"

#include <algorithm>
#include <array>
#include <clocale>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "io/sample_mesh.hpp"
#include "slice2mesh/quality/format_quality.hpp"
#include "slice2mesh/quality/quality_svg.hpp"
#include "test_support.hpp"

namespace {

using slice2mesh::Cause;
using slice2mesh::measure_quality;
using slice2mesh::Mesh;
using slice2mesh::QualityOptions;
using slice2mesh::QualityReport;

std::uint64_t total(const slice2mesh::Histogram& histogram) {
  std::uint64_t sum = 0;
  for (const std::uint64_t count : histogram.counts) sum += count;
  return sum;
}

slice2mesh::TetCorners corners(const Mesh& mesh, std::size_t t) {
  slice2mesh::TetCorners p;
  for (std::size_t i = 0; i < 4; ++i) p[i] = mesh.vertices[static_cast<std::size_t>(mesh.tets[t][i])];
  return p;
}

/// The sample with every vertex that is not on the skin of its plane moved within the plane, so that all tets differ.
Mesh jittered_sample(std::uint32_t seed) {
  Mesh mesh = slice2mesh_test::mesh_of(slice2mesh_test::stepped_sample());
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> move(-0.1, 0.1);
  for (std::array<double, 3>& p : mesh.vertices) {
    p[0] += move(generator);
    p[1] += move(generator);
  }
  return mesh;
}

}  // namespace

TEST_CASE("the histograms count every tet once and every dihedral angle once") {
  const std::uint32_t seed = 11;
  INFO("seed " << seed);
  const Mesh mesh = jittered_sample(seed);
  const QualityReport report = measure_quality(mesh);
  REQUIRE(report.tets == mesh.tets.size());
  REQUIRE(report.not_positive == 0);
  CHECK(total(report.ratio_histogram) == mesh.tets.size());
  CHECK(total(report.dihedral_histogram) == 6 * mesh.tets.size());
  for (const slice2mesh::Histogram* h : {&report.ratio_histogram, &report.dihedral_histogram}) {
    CHECK(h->edges.size() == h->counts.size() + 1);
    CHECK(std::is_sorted(h->edges.begin(), h->edges.end()));
  }
}

TEST_CASE("histograms and figures equal those of a slow count over the tets") {
  const std::uint32_t seed = 12;
  INFO("seed " << seed);
  const Mesh mesh = jittered_sample(seed);
  const QualityReport report = measure_quality(mesh);
  std::vector<double> ratios;
  std::vector<std::uint64_t> angle_counts(report.dihedral_histogram.counts.size(), 0);
  double min_angle = 180;
  double max_angle = 0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    ratios.push_back(slice2mesh::radius_ratio(corners(mesh, t)));
    for (const double angle : slice2mesh::dihedral_angles(corners(mesh, t))) {
      ++angle_counts[std::min<std::size_t>(static_cast<std::size_t>(angle / 5), angle_counts.size() - 1)];
      min_angle = std::min(min_angle, angle);
      max_angle = std::max(max_angle, angle);
    }
  }
  CHECK(report.dihedral_histogram.counts == angle_counts);
  CHECK(report.min_dihedral == Approx(min_angle).epsilon(1e-12));
  CHECK(report.max_dihedral == Approx(max_angle).epsilon(1e-12));
  std::sort(ratios.begin(), ratios.end());
  double sum = 0;
  for (const double r : ratios) sum += r;
  const std::size_t n = ratios.size();
  REQUIRE(n == 624);
  CHECK(report.ratio.mean == Approx(sum / static_cast<double>(n)).epsilon(1e-12));
  CHECK(report.ratio.median == ratios[311]);
  CHECK(report.ratio.p99 == ratios[617]);   // 618 of 624 are at least 99 %, 617 are not
  CHECK(report.ratio.p999 == ratios[623]);  // 623 of 624 are less than 99.9 %
  CHECK(report.ratio.worst == ratios.back());
  for (std::size_t bin = 0; bin + 1 < report.ratio_histogram.edges.size(); ++bin) {
    const auto from = std::lower_bound(ratios.begin(), ratios.end(), report.ratio_histogram.edges[bin]);
    const auto to = std::lower_bound(ratios.begin(), ratios.end(), report.ratio_histogram.edges[bin + 1]);
    CHECK(report.ratio_histogram.counts[bin] == static_cast<std::uint64_t>(to - from));
  }
}

TEST_CASE("the figures do not depend on the size of the part") {
  Mesh mesh = slice2mesh_test::mesh_of(slice2mesh_test::stepped_sample());
  const QualityReport report = measure_quality(mesh);
  for (std::array<double, 3>& p : mesh.vertices)
    for (double& x : p) x *= 64;
  for (slice2mesh::Slab& s : mesh.slabs) {
    s.z_low *= 64;
    s.z_high *= 64;
  }
  const QualityReport scaled = measure_quality(mesh);
  CHECK(scaled.ratio.mean == report.ratio.mean);
  CHECK(scaled.ratio.worst == report.ratio.worst);
  CHECK(scaled.ratio_histogram.counts == report.ratio_histogram.counts);
  CHECK(scaled.dihedral_histogram.counts == report.dihedral_histogram.counts);
  CHECK(scaled.crossing == 0);
  CHECK(scaled.volume == 64.0 * 64 * 64 * report.volume);
}

TEST_CASE("metric figures of a stretched mesh equal the Euclidean figures of the mesh before") {
  slice2mesh_test::BoxSolid cube = slice2mesh_test::single_box();
  const QualityReport plain = measure_quality(slice2mesh_test::mesh_of(cube));
  CHECK_FALSE(plain.metric_ratio);
  cube.dx = cube.dy = 8;
  cube.thickness = {0.25};
  QualityOptions options;
  options.metric_l = 8;
  options.metric_h = 0.25;
  const QualityReport flat = measure_quality(slice2mesh_test::mesh_of(cube), options);
  REQUIRE(flat.metric_ratio);
  CHECK(flat.metric_ratio->worst == plain.ratio.worst);
  CHECK(flat.metric_ratio->mean == plain.ratio.mean);
  CHECK(flat.ratio.worst > 5 * plain.ratio.worst);
  options.metric_l = -1;
  CHECK_THROWS_AS(measure_quality(slice2mesh_test::mesh_of(cube), options), slice2mesh::OptionError);
}

TEST_CASE("volumes per slab and region are those of the solid") {
  const slice2mesh_test::BoxSolid solid = slice2mesh_test::stepped_sample();
  const QualityReport report = measure_quality(slice2mesh_test::mesh_of(solid));
  REQUIRE(report.slab_volume.size() == solid.thickness.size());
  double sum = 0;
  for (std::size_t s = 0; s < solid.thickness.size(); ++s) {
    CHECK(report.slab_volume[s] == Approx(solid.area(s) * solid.thickness[s]).epsilon(1e-14));
    sum += report.slab_volume[s];
  }
  CHECK(report.volume == Approx(sum).epsilon(1e-14));
  REQUIRE(report.region_volume.size() == 3);
  CHECK(report.region_volume[0] + report.region_volume[1] + report.region_volume[2] == Approx(sum).epsilon(1e-14));
  CHECK(report.region_volume[1] == Approx(2 * solid.dx * solid.dy * 0.5).epsilon(1e-14));
  CHECK(report.region_volume[2] == Approx(2 * solid.dx * solid.dy * 1.0).epsilon(1e-14));
}

TEST_CASE("crossing is found from coordinates, not from labels") {
  Mesh mesh = slice2mesh_test::mesh_of(slice2mesh_test::stepped_sample());
  CHECK(measure_quality(mesh).crossing == 0);
  CHECK(measure_quality(mesh).mislabeled == 0);

  SECTION("a wrong label is no crossing") {
    ++mesh.tet_slab[0];
    const QualityReport report = measure_quality(mesh);
    CHECK(report.crossing == 0);
    CHECK(report.mislabeled == 1);
  }
  SECTION("a vertex that drifts off its plane makes the tets on one side of it cross") {
    // The vertex of the plane z = 0.25 at the outer corner of slabs 0 and 1 belongs to both.
    std::size_t v = 0;
    while (mesh.vertices[v] != std::array<double, 3>{0, 0, 0.25}) ++v;
    for (const double drift : {0.01, -0.01}) {
      mesh.vertices[v][2] = 0.25 + drift;
      std::size_t expected = 0;
      for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
        const bool uses = std::count(mesh.tets[t].begin(), mesh.tets[t].end(), static_cast<std::int32_t>(v)) > 0;
        if (uses && mesh.tet_slab[t] == (drift > 0 ? 0 : 1)) ++expected;
      }
      const QualityReport report = measure_quality(mesh);
      REQUIRE(expected > 0);
      CHECK(report.crossing == expected);
      CHECK(report.mislabeled == expected);
      CHECK(report.crossing_share == static_cast<double>(expected) / static_cast<double>(mesh.tets.size()));
    }
  }
  SECTION("rounding far below the tolerance is no crossing") {
    for (std::array<double, 3>& p : mesh.vertices) p[2] += 1e-13;
    CHECK(measure_quality(mesh).crossing == 0);
  }
  SECTION("a tet outside all slabs crosses") {
    for (slice2mesh::Slab& s : mesh.slabs) {
      s.z_low += 100;
      s.z_high += 100;
    }
    CHECK(measure_quality(mesh).crossing == mesh.tets.size());
  }
}

TEST_CASE("a tet is a column exactly when it has a vertical edge") {
  Mesh mesh = slice2mesh_test::mesh_of(slice2mesh_test::stepped_sample());
  CHECK(measure_quality(mesh).columns == mesh.tets.size());
  CHECK(measure_quality(mesh).column_share == 1);
  // Shear every second plane: no edge stays vertical.
  for (std::array<double, 3>& p : mesh.vertices)
    if (p[2] == 0.25 || p[2] == 1) p[0] += 1.0 / 1024;
  CHECK(measure_quality(mesh).columns == 0);
}

TEST_CASE("flat and inverted tets are counted and make the worst figures infinite") {
  Mesh mesh = slice2mesh_test::mesh_of(slice2mesh_test::single_box());
  std::swap(mesh.tets[2][0], mesh.tets[2][1]);
  const QualityReport report = measure_quality(mesh);
  CHECK(report.not_positive == 1);
  CHECK(std::isinf(report.ratio.worst));
  CHECK(report.min_dihedral == 0);
  CHECK(report.max_dihedral == 180);
  CHECK(total(report.ratio_histogram) == mesh.tets.size());
  REQUIRE(!report.worst.empty());
  CHECK(report.worst[0].tet == 2);
  CHECK(slice2mesh::format_quality(report).find("inf") != std::string::npos);
}

TEST_CASE("the worst elements are listed worst first, with place and cause") {
  const std::uint32_t seed = 13;
  INFO("seed " << seed);
  const Mesh mesh = jittered_sample(seed);
  QualityOptions options;
  options.worst_count = 25;
  const QualityReport report = measure_quality(mesh, options);
  REQUIRE(report.worst.size() == 25);
  std::vector<double> ratios;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) ratios.push_back(slice2mesh::radius_ratio(corners(mesh, t)));
  std::vector<double> sorted = ratios;
  std::sort(sorted.rbegin(), sorted.rend());
  for (std::size_t i = 0; i < report.worst.size(); ++i) {
    const slice2mesh::WorstTet& w = report.worst[i];
    CHECK(w.ratio == sorted[i]);
    CHECK(w.ratio == ratios[w.tet]);
    CHECK(w.slab == mesh.tet_slab[w.tet]);
    CHECK(w.region == mesh.tet_region[w.tet]);
    const slice2mesh::Slab& slab = mesh.slabs[static_cast<std::size_t>(w.slab)];
    CHECK((slab.z_low < w.centroid[2] && w.centroid[2] < slab.z_high));
  }
  options.worst_count = 100000;
  CHECK(measure_quality(mesh, options).worst.size() == mesh.tets.size());
  options.worst_count = 0;
  CHECK(measure_quality(mesh, options).worst.empty());
}

TEST_CASE("a short edge and a sliver are told apart by their shape, and a caller can know better") {
  Mesh mesh;
  mesh.slabs = {{0, 1, 0, 0, 0}};
  mesh.regions = {{}};
  mesh.vertices = {{0, 0, 0}, {0.05, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {-1, 0, 0}, {0, -1, 0.05}, {0, 1, 0.05}};
  mesh.tets = {{0, 1, 2, 3}, {4, 5, 6, 7}};
  mesh.tet_slab = {0, 0};
  mesh.tet_region = {0, 0};
  QualityReport report = measure_quality(mesh);
  REQUIRE(report.worst.size() == 2);
  for (const slice2mesh::WorstTet& w : report.worst) CHECK(w.cause == (w.tet == 0 ? Cause::ShortEdge : Cause::Flat));
  QualityOptions options;
  int asked = 0;
  options.classify = [&asked](const Mesh&, const slice2mesh::WorstTet& w) {
    ++asked;
    return w.cause == Cause::ShortEdge ? Cause::ThinWall : w.cause;
  };
  report = measure_quality(mesh, options);
  CHECK(asked == 2);
  for (const slice2mesh::WorstTet& w : report.worst) CHECK(w.cause == (w.tet == 0 ? Cause::ThinWall : Cause::Flat));
}

TEST_CASE("a mesh without tets has an empty report, and arrays that do not fit are refused") {
  Mesh mesh;
  const QualityReport report = measure_quality(mesh);
  CHECK(report.tets == 0);
  CHECK(total(report.ratio_histogram) == 0);
  CHECK_FALSE(slice2mesh::format_quality(report).empty());
  CHECK_FALSE(slice2mesh::quality_svg(report).empty());
  mesh = slice2mesh_test::mesh_of(slice2mesh_test::single_box());
  mesh.tets[0][0] = 1000;
  CHECK_THROWS_AS(measure_quality(mesh), slice2mesh::Error);
  mesh = slice2mesh_test::mesh_of(slice2mesh_test::single_box());
  mesh.tet_slab.pop_back();
  CHECK_THROWS_AS(measure_quality(mesh), slice2mesh::Error);
}

TEST_CASE("the text of a report names every figure and does not depend on the locale") {
  const QualityReport report = measure_quality(slice2mesh_test::mesh_of(slice2mesh_test::stepped_sample()));
  const std::string text = slice2mesh::format_quality(report);
  for (const char* const part :
       {"tets", "R/3r", "99.9 %", "dihedral", "crossing", "columns", "volume", "worst elements"})
    CHECK(text.find(part) != std::string::npos);
  CHECK(text.find("11.90625 mm^3") != std::string::npos);
  const char* const used = std::setlocale(LC_ALL, "de_DE.UTF-8");
  if (used == nullptr) WARN("no locale with a decimal comma is installed: not compared under one");
  CHECK(slice2mesh::format_quality(report) == text);
  std::setlocale(LC_ALL, "C");
}

TEST_CASE("the picture has a bar for every filled bin, is escaped, and is written to a file") {
  const QualityReport report = measure_quality(slice2mesh_test::mesh_of(slice2mesh_test::stepped_sample()));
  const std::string svg = slice2mesh::quality_svg(report, "a < b & \"c\"");
  CHECK(svg.find("a &lt; b &amp; &quot;c&quot;") != std::string::npos);
  std::size_t bars = 0;
  for (std::size_t at = svg.find("<title>"); at != std::string::npos; at = svg.find("<title>", at + 1)) ++bars;
  std::size_t filled = 0;
  for (const slice2mesh::Histogram* h : {&report.ratio_histogram, &report.dihedral_histogram})
    for (const std::uint64_t count : h->counts)
      if (count > 0) ++filled;
  REQUIRE(filled > 2);
  CHECK(bars == filled);
  const slice2mesh_test::TemporaryDirectory directory;
  slice2mesh::write_quality_svg(directory.file("quality.svg"), report, "a < b & \"c\"");
  std::ifstream file(directory.file("quality.svg"), std::ios::binary);
  CHECK(std::string(std::istreambuf_iterator<char>(file), {}) == svg);
}
