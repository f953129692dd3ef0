// SPDX-License-Identifier: MIT
// The one call: equal to the chain of stages, deterministic, stoppable.
#include "slice2mesh/slice2mesh.hpp"

#include <cmath>

#include "test_support.hpp"

using namespace slice2mesh;

namespace {

// A part with a hole and a sloped wall, an overhang in the upper half, and support lines under it.
SliceStack sample() {
  SliceStack stack;
  for (int i = 0; i < 8; ++i) {
    Layer layer;
    layer.z = 0.5 * i;
    const double left = 0.13 * i;
    Polyline outer;
    outer.points = {{left, 0}, {i < 4 ? 6.0 : 9.0, 0}, {i < 4 ? 6.0 : 9.0, 5}, {left, 5}};
    Polyline hole;
    hole.direction = Direction::Inner;
    hole.points = {{2.5, 2}, {2.5, 3}, {4, 3}, {4, 2}};
    layer.polylines = {outer, hole};
    if (i < 4)
      for (int k = 0; k < 3; ++k) {
        Polyline line;
        line.direction = Direction::Open;
        line.points = {{6.8, 1.0 + 1.5 * k}, {8.8, 1.0 + 1.5 * k}};
        layer.polylines.push_back(line);
      }
    stack.layers.push_back(layer);
  }
  return stack;
}

Options sample_options() {
  Options options;
  options.supports.radius = Length::mm(0.2);
  return options;
}

}  // namespace

TEST_CASE("the chain of stages gives the same mesh as the one call") {
  const SliceStack stack = sample();
  const Options options = sample_options();
  const Result result = slice_to_mesh(stack, options);
  REQUIRE(result.mesh.tets.size() > 1000);
  CHECK(result.report.certificate.passed());

  Diagnostics diagnostics;
  const SlabPlan plan = make_slabs(stack, options.slabs, diagnostics);
  const LayerRegions regions = build_regions(stack, plan, options.supports, diagnostics);
  const PlaneSizes sizes = resolve_sizes(options.size, regions);
  HarmonizeOptions harmonize_options;
  harmonize_options.eps = options.eps.in_mm(plan.thickness);
  harmonize_options.contour_size = sizes.contour_size;
  Contours contours = harmonize(regions, harmonize_options, diagnostics);
  PlaneStack planes = triangulate_planes(contours, sizes);
  Plc plc = build_plc(contours, planes.meshes, planes.slab_planes);
  CHECK(verify_plc(plc).passed());
  Mesh mesh = SlabFiller{}(plc);
  CHECK(improve(regions, contours, planes, plc, mesh, options.improve));
  CHECK(verify_plc(plc).passed());
  CHECK(mesh.vertices == result.mesh.vertices);
  CHECK(mesh.tets == result.mesh.tets);
  CHECK(mesh.tet_slab == result.mesh.tet_slab);
  CHECK(mesh.tet_region == result.mesh.tet_region);
  CHECK(diagnostics.entries().size() == result.diagnostics.entries().size());
}

TEST_CASE("two runs give the same mesh") {
  const Result first = slice_to_mesh(sample(), sample_options());
  const Result second = slice_to_mesh(sample(), sample_options());
  REQUIRE(!first.mesh.tets.empty());
  CHECK(first.mesh.vertices == second.mesh.vertices);
  CHECK(first.mesh.tets == second.mesh.tets);
}

TEST_CASE("supports have a region of their own, and are left out without a radius") {
  const Result with = slice_to_mesh(sample(), sample_options());
  REQUIRE(with.mesh.regions.size() == 2);
  CHECK(with.mesh.regions[0].kind == RegionKind::Part);
  CHECK(with.mesh.regions[1].kind == RegionKind::Support);
  REQUIRE(with.report.quality.region_volume.size() == 2);
  // Three lines, 2 mm long and 0.4 wide with square ends, four layers of 0.5 mm.
  CHECK(with.report.quality.region_volume[1] == Approx(3 * (2.0 + 0.4) * 0.4 * 4 * 0.5).epsilon(1e-9));
  const Result without = slice_to_mesh(sample());
  CHECK(without.mesh.regions.size() == 1);
  CHECK(without.diagnostics.count("supports_left_out") == 12);
}

TEST_CASE("the deviation stays within eps, and exact mode and bundles of slices are certified") {
  for (const double eps : {0.0, 0.1, 0.5})
    for (const int lump : {1, 3}) {
      Options options = sample_options();
      options.eps = Length::layers(eps);
      options.slabs.lump = lump;
      const Result result = slice_to_mesh(sample(), options);
      INFO("eps " << eps << " h, lump " << lump);
      CHECK(result.report.certificate.passed());
      CHECK(result.report.quality.crossing == 0);
      CHECK(result.mesh.slabs.size() == (lump == 1 ? 8U : 3U));
      CHECK(result.report.max_deviation <= result.report.eps);
      // Exact mode closes what is narrower than 2^-20 of the extent (16 mm, as a power of two, at most).
      if (eps == 0) CHECK(result.report.eps < 2e-5);
    }
}

TEST_CASE("the report has what the mesh gains and loses against its slices") {
  for (const double eps : {0.0, 0.1, 0.5}) {
    INFO("eps " << eps << " h");
    Options options = sample_options();
    options.eps = Length::layers(eps);
    const Result result = slice_to_mesh(sample(), options);
    const VolumeError& error = result.report.volume_error;
    // The mean width of the layers, less the hole; the supports.
    double slices = 3 * (2.0 + 0.4) * 0.4 * 4 * 0.5;
    for (int i = 0; i < 8; ++i) slices += (((i < 4 ? 6.0 : 9.0) - 0.13 * i) * 5 - 1.5) * 0.5;
    CHECK(error.slices == Approx(slices).epsilon(1e-9));
    CHECK(error.error == Approx(result.report.quality.volume / slices - 1).margin(1e-9));
    REQUIRE(error.slab_error.size() == 8);
    for (const double shift : error.slab_shift) CHECK(std::fabs(shift) <= result.report.eps);
    if (eps == 0) CHECK(std::fabs(error.error) < 1e-5);
  }
}

TEST_CASE("sliver removal makes no element worse than the raw fill's worst and keeps the certificate") {
  Options raw = sample_options();
  raw.improve.rounds = 0;
  const Result before = slice_to_mesh(sample(), raw);
  const Result after = slice_to_mesh(sample(), sample_options());
  CHECK(after.report.certificate.passed());
  CHECK(after.report.quality.ratio.worst <= before.report.quality.ratio.worst);
}

TEST_CASE("budgets and cancellation end a run with their own errors") {
  Options options = sample_options();
  options.budget.max_tets = 100;
  CHECK_THROWS_AS(slice_to_mesh(sample(), options), BudgetError);
  options = sample_options();
  options.budget.max_vertices = 100;
  CHECK_THROWS_AS(slice_to_mesh(sample(), options), BudgetError);
  options = sample_options();
  options.budget.time_limit = 1e-9;
  CHECK_THROWS_AS(slice_to_mesh(sample(), options), BudgetError);
  options = sample_options();
  options.progress = [](Stage stage, double) { return stage != Stage::Triangulate; };
  CHECK_THROWS_AS(slice_to_mesh(sample(), options), Cancelled);
}

TEST_CASE("options out of range are named") {
  const auto option_of = [](auto change) {
    Options options;
    change(options);
    try {
      static_cast<void>(slice_to_mesh(sample(), options));
    } catch (const OptionError& error) {
      return error.option();
    }
    return std::string("none");
  };
  CHECK(option_of([](Options& o) { o.eps = Length::mm(-1); }) == "eps");
  CHECK(option_of([](Options& o) { o.size.size = Length::mm(-1); }) == "size.size");
  CHECK(option_of([](Options& o) { o.supports.radius = Length::mm(-1); }) == "supports.radius");
  CHECK(option_of([](Options& o) { o.improve.rounds = -1; }) == "improve.rounds");
  CHECK(option_of([](Options& o) { o.budget.max_tets = -1; }) == "budget.max_tets");
}
