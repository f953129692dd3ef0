// SPDX-License-Identifier: MIT
// The base plate: its slabs and region, and that nothing else changes.
#include "slice2mesh/regions/base_plate.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "slice2mesh/fem/activation.hpp"
#include "slice2mesh/fem/boundary_sets.hpp"
#include "slice2mesh/pipeline/slice_to_mesh.hpp"
#include "test_support.hpp"

using namespace slice2mesh;

namespace {

Polyline line_of(std::int32_t part, Direction direction, std::vector<Point2> points) {
  Polyline line;
  line.part = part;
  line.direction = direction;
  line.points = std::move(points);
  return line;
}

// Part 3 (8 x 6 mm with a hole, 10 mm long in the upper half) with support lines, and part 5 beside it (4 x 4 mm).
// Layers of 0.5 mm, in hundredths of mm.
SliceStack sample() {
  SliceStack stack;
  stack.unit = 0.01;
  stack.z_unit = 0.01;
  for (int i = 0; i < 4; ++i) {
    Layer layer;
    layer.z = 50.0 * (i + 1);
    const double right = i < 2 ? 800 : 1000;
    layer.polylines = {line_of(3, Direction::Outer, {{0, 0}, {right, 0}, {right, 600}, {0, 600}}),
                       line_of(3, Direction::Inner, {{200, 200}, {200, 400}, {400, 400}, {400, 200}}),
                       line_of(5, Direction::Outer, {{1200, 0}, {1600, 0}, {1600, 400}, {1200, 400}})};
    if (i < 2) layer.polylines.push_back(line_of(3, Direction::Open, {{900, 100}, {900, 500}}));
    stack.layers.push_back(layer);
  }
  return stack;
}

Options sample_options() {
  Options options;
  options.supports.radius = Length::mm(0.2);
  options.plate.thickness = Length::mm(2);
  options.plate.margin = Length::mm(3);
  return options;
}

double area_of(const LayerRegions& regions, std::size_t slab, std::int32_t region) {
  return static_cast<double>(slice2mesh::detail::doubled_area(regions.outlines[slab], region)) / 2 *
         regions.grid.pitch * regions.grid.pitch;
}

LayerRegions regions_of(const Options& options, Diagnostics& diagnostics) {
  const SliceStack stack = sample();
  const SlabPlan plan = make_slabs(stack, options.slabs, diagnostics);
  return build_regions_on_plate(stack, plan, options.supports, options.plate, diagnostics);
}

}  // namespace

TEST_CASE("the slabs of a plate fill its thickness, end exactly under the part, and are thin at the top") {
  for (const double thickness : {0.05, 0.1, 0.7, 3.0, 40.0})
    for (const double top : {0.0, 0.3, -7.1}) {
      INFO("thickness " << thickness << ", top " << top);
      const std::vector<double> planes = slice2mesh::detail::plate_planes(top, thickness, 0.1, 0);
      REQUIRE(planes.size() >= 2);
      CHECK(planes.front() == top - thickness);
      CHECK(planes.back() == top);
      double above = 0;
      for (std::size_t i = planes.size() - 1; i-- > 0;) {
        const double height = planes[i + 1] - planes[i];
        CHECK(height > 0);
        CHECK(height < 0.8 + 1e-9);
        if (above > 0) CHECK(height < 2 * above * (1 + 1e-9));
        above = height;
      }
      CHECK(planes[planes.size() - 1] - planes[planes.size() - 2] < 0.1 + 1e-9);
      const std::vector<double> even = slice2mesh::detail::plate_planes(top, thickness, 0.1, 4);
      REQUIRE(even.size() == 5);
      for (std::size_t i = 0; i < 4; ++i) CHECK(even[i + 1] - even[i] == Approx(thickness / 4));
    }
  CHECK(slice2mesh::detail::plate_planes(0, 1000, 0.01, 0).size() < 120);
}

TEST_CASE("a box plate is the box of the whole part with its margin, in the last region, and nothing else changes") {
  Diagnostics diagnostics;
  Diagnostics diagnostics_without;
  Options options = sample_options();
  const LayerRegions with = regions_of(options, diagnostics);
  options.plate.thickness = Length::mm(0);
  const LayerRegions without = regions_of(options, diagnostics_without);
  REQUIRE(with.regions.size() == 4);
  REQUIRE(without.regions.size() == 3);
  CHECK(with.regions[3].kind == RegionKind::Plate);
  CHECK(with.regions[3].part == kNone);
  CHECK(with.regions[3].name == "base_plate");
  for (std::size_t r = 0; r < 3; ++r) {
    CHECK(with.regions[r].name == without.regions[r].name);
    CHECK(with.regions[r].kind == without.regions[r].kind);
    CHECK(with.regions[r].part == without.regions[r].part);
  }
  const std::size_t plate = with.slabs.size() - without.slabs.size();
  REQUIRE(plate >= 2);
  for (std::size_t s = 0; s < plate; ++s) {
    CHECK(with.slabs[s].is_plate());
    CHECK(area_of(with, s, 3) == Approx((16.0 + 6) * (6.0 + 6)).epsilon(1e-9));
    CHECK(area_of(with, s, kNone) == area_of(with, s, 3));
    CHECK(with.outlines[s].vertices == with.outlines[0].vertices);
    CHECK(with.slabs[s].z_high == with.slabs[s + 1].z_low);
  }
  CHECK(with.slabs[0].z_low == -2);
  for (std::size_t s = 0; s < without.slabs.size(); ++s) {
    CHECK_FALSE(with.slabs[plate + s].is_plate());
    CHECK(with.slabs[plate + s].slice == without.slabs[s].slice);
    CHECK(with.slabs[plate + s].z_low == without.slabs[s].z_low);
    for (std::int32_t r = 0; r < 3; ++r)
      CHECK(area_of(with, plate + s, r) == Approx(area_of(without, s, r)).epsilon(1e-9));
  }
  CHECK(with.thickness == without.thickness);
  CHECK(diagnostics.entries().size() == diagnostics_without.entries().size());
}

TEST_CASE("an offset plate follows the first slice, fills its holes and has round corners") {
  Options options = sample_options();
  options.plate.shape = BasePlateShape::Offset;
  options.plate.margin = Length::mm(0.75);
  Diagnostics diagnostics;
  const LayerRegions regions = regions_of(options, diagnostics);
  CHECK(diagnostics.count("contours_cross") == 0);
  const double pi = std::acos(-1.0);
  const auto rounded = [&](double a, double b, double m) { return a * b + 2 * m * (a + b) + pi * m * m; };
  // The support line, 0.2 mm to both sides with square ends, is under the plate's own margin; the two parts are apart.
  const double parts = rounded(8, 6, 0.75) + rounded(4, 4, 0.75);
  const std::int32_t plate = static_cast<std::int32_t>(regions.regions.size()) - 1;
  CHECK(area_of(regions, 0, plate) > parts * (1 - 1e-3));
  CHECK(area_of(regions, 0, plate) < parts + 6 * 2);
  options.supports.radius = Length::mm(0);
  const LayerRegions alone = regions_of(options, diagnostics);
  CHECK(area_of(alone, 0, static_cast<std::int32_t>(alone.regions.size()) - 1) == Approx(parts).epsilon(1e-3));
}

TEST_CASE("a hole by itself stands on no plate: the plate is under the first slice with a contour or a support") {
  for (const BasePlateShape shape : {BasePlateShape::Box, BasePlateShape::Offset}) {
    Options options = sample_options();
    options.plate.shape = shape;
    SliceStack stack = sample();
    const auto plate_of = [&] {
      Diagnostics diagnostics;
      const SlabPlan plan = make_slabs(stack, options.slabs, diagnostics);
      return build_regions_on_plate(stack, plan, options.supports, options.plate, diagnostics);
    };
    stack.layers[0].polylines = {line_of(3, Direction::Inner, {{200, 200}, {200, 400}, {400, 400}, {400, 200}})};
    const LayerRegions regions = plate_of();
    REQUIRE(regions.regions.back().kind == RegionKind::Plate);
    CHECK(area_of(regions, 0, static_cast<std::int32_t>(regions.regions.size()) - 1) > 8 * 6);
    std::size_t part = 0;
    while (part < regions.slabs.size() && regions.slabs[part].is_plate()) ++part;
    REQUIRE(part > 0);
    REQUIRE(part < regions.slabs.size());
    CHECK(regions.slabs[part].slice == 1);
    CHECK(regions.slabs[part - 1].z_high == regions.slabs[part].z_low);
    for (Layer& layer : stack.layers) layer.polylines = stack.layers[0].polylines;
    CHECK_THROWS_AS(plate_of(), GeometryError);
  }
}

TEST_CASE("a mesh on a plate is certified, conforms with it, and has the volumes of the part and of the plate") {
  Options options = sample_options();
  for (const BasePlateShape shape : {BasePlateShape::Box, BasePlateShape::Offset}) {
    options.plate.shape = shape;
    const Result result = slice_to_mesh(sample(), options);
    for (const CertificateCheck& check : result.report.certificate.checks) {
      INFO(check.name << ": " << check.detail);
      CHECK(check.passed);
    }
    const QualityReport& quality = result.report.quality;
    const std::vector<double> expected = {2 * (8 * 6 + 10 * 6 - 2 * 4) * 0.5, 4 * 4 * 4 * 0.5, 2 * 4.4 * 0.4 * 0.5};
    REQUIRE(quality.region_volume.size() == 4);
    for (std::size_t r = 0; r < 3; ++r)
      CHECK(quality.region_volume[r] == Approx(expected[r]).epsilon(r < 2 ? 1e-10 : 1e-8));
    if (shape == BasePlateShape::Box)
      CHECK(quality.region_volume[3] == Approx((16.0 + 6) * (6.0 + 6) * 2).epsilon(1e-10));
    CHECK(quality.mislabeled == 0);
    CHECK(quality.ratio.worst < 20);
    const BoundarySets sets = boundary_sets(result.mesh);
    const auto area = [&](BoundaryKind kind) { return slice2mesh::area_of(result.mesh, sets.of(kind)); };
    CHECK(area(BoundaryKind::PlateInterface) == Approx(8 * 6 - 4 + 16 + 4.4 * 0.4).epsilon(1e-10));
    CHECK(area(BoundaryKind::Bottom) == Approx(quality.region_volume[3] / 2).epsilon(1e-10));
    CHECK(result.report.estimates.volume == Approx(expected[0] + expected[1]).epsilon(1e-10));
    const std::int32_t plate = plate_slabs(result.mesh);
    CHECK(plate >= 2);
    const std::vector<double> times = activation_time(result.mesh, 1);
    CHECK(*std::max_element(times.begin(), times.end()) == 3);
    for (std::size_t t = 0; t < times.size(); ++t)
      if (result.mesh.tet_region[t] == 3) REQUIRE(times[t] == 0);
  }
}

TEST_CASE("options of a plate that are out of range are named") {
  const auto option_of = [](auto change) {
    Options options = sample_options();
    change(options);
    try {
      static_cast<void>(slice_to_mesh(sample(), options));
    } catch (const OptionError& error) {
      return error.option();
    }
    return std::string("none");
  };
  CHECK(option_of([](Options& o) { o.plate.thickness = Length::mm(-1); }) == "plate.thickness");
  CHECK(option_of([](Options& o) { o.plate.margin = Length::mm(0); }) == "plate.margin");
  CHECK(option_of([](Options& o) { o.plate.margin = Length::mm(0.05); }) == "plate.margin");
  CHECK(option_of([](Options& o) { o.plate.slabs = -1; }) == "plate.slabs");
}

TEST_CASE("bundles of slices are compared with all their slices") {
  Options options;
  options.slabs.lump = 4;
  const Result result = slice_to_mesh(sample(), options);
  REQUIRE(result.report.estimates.layers.size() == 1);
  const LayerEstimate& layer = result.report.estimates.layers[0];
  CHECK(layer.measured);
  // The second slice stands for all four: 8 x 6 mm instead of 10 x 6 mm in two of them.
  CHECK(layer.volume_loss == Approx(2 * 2 * 6 * 0.5).epsilon(1e-9));
  options.finer_slices = false;
  CHECK_FALSE(slice_to_mesh(sample(), options).report.estimates.layers[0].measured);
}
