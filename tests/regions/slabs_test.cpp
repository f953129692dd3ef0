// SPDX-License-Identifier: MIT
#include "slice2mesh/regions/slabs.hpp"

#include <filesystem>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "slice2mesh/cli/read_cli.hpp"
#include "test_support.hpp"

using namespace slice2mesh;

namespace {

Polyline square() {
  Polyline p;
  p.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  return p;
}

/// A stack with these heights; layers whose number is in `empty` have no polyline.
SliceStack stack_of(const std::vector<double>& z, const std::vector<std::size_t>& empty = {}) {
  SliceStack stack;
  for (std::size_t i = 0; i < z.size(); ++i) {
    Layer layer;
    layer.z = z[i];
    if (std::find(empty.begin(), empty.end(), i) == empty.end()) layer.polylines.push_back(square());
    stack.layers.push_back(layer);
  }
  return stack;
}

SlabPlan plan_of(const SliceStack& stack, const SlabOptions& options = {}) {
  Diagnostics diagnostics;
  SlabPlan plan = make_slabs(stack, options, diagnostics);
  CHECK(diagnostics.count("z_convention") == 1);
  return plan;
}

SlabOptions with(ZConvention convention, std::int32_t lump = 1) {
  SlabOptions options;
  options.z_convention = convention;
  options.lump = lump;
  return options;
}

/// What holds for every plan: positive slabs, in order, that share planes or leave gaps, each with a filled slice.
void check_plan(const SliceStack& stack, const SlabPlan& plan) {
  REQUIRE(!plan.slabs.empty());
  CHECK(plan.thickness > 0);
  CHECK(plan.convention != ZConvention::Auto);
  for (std::size_t i = 0; i < plan.slabs.size(); ++i) {
    const Slab& s = plan.slabs[i];
    CHECK(s.z_low < s.z_high);
    CHECK(s.first_layer <= s.slice);
    CHECK(s.slice <= s.last_layer);
    CHECK(detail::is_filled(stack.layers[static_cast<std::size_t>(s.slice)], true));
    CHECK(detail::is_filled(stack.layers[static_cast<std::size_t>(s.first_layer)], true));
    CHECK(detail::is_filled(stack.layers[static_cast<std::size_t>(s.last_layer)], true));
    if (i == 0) continue;
    const Slab& below = plan.slabs[i - 1];
    CHECK(below.last_layer < s.first_layer);
    if (below.last_layer + 1 == s.first_layer)
      CHECK(below.z_high == s.z_low);  // the same double
    else
      CHECK(below.z_high < s.z_low);
  }
}

}  // namespace

TEST_CASE("The z convention is told by where the first slice lies", "[slabs]") {
  CHECK(plan_of(stack_of({0, 0.1, 0.2})).convention == ZConvention::Bottom);
  CHECK(plan_of(stack_of({0.1, 0.2, 0.3})).convention == ZConvention::Top);
  CHECK(plan_of(stack_of({0.05, 0.15, 0.25})).convention == ZConvention::Middle);
  CHECK(plan_of(stack_of({0, 0.1, 0.2, 0.3}, {0})).convention == ZConvention::Top);
  CHECK(plan_of(stack_of({3.09998, 6.2, 9.30001})).convention == ZConvention::Top);
  CHECK(plan_of(stack_of({1.55001, 4.65, 7.75001})).convention == ZConvention::Middle);
  CHECK(plan_of(stack_of({9.9, 10.8, 11.7})).convention == ZConvention::Top);         // other offset: as described
  CHECK(plan_of(stack_of({10.35, 11.25, 12.15})).convention == ZConvention::Middle);  // half a spacing off multiples
}

TEST_CASE("Where the first slice says nothing the box of the header decides", "[slabs]") {
  SliceStack stack = stack_of({9.9, 10.8, 11.7});
  stack.dimension = std::array<double, 6>{0, 0, 9.9, 1, 1, 12.6};
  CHECK(plan_of(stack).convention == ZConvention::Bottom);
  stack.dimension = std::array<double, 6>{0, 0, 9.45, 1, 1, 12.15};
  CHECK(plan_of(stack).convention == ZConvention::Middle);
  stack.dimension = std::array<double, 6>{0, 0, 9, 1, 1, 11.7};
  CHECK(plan_of(stack).convention == ZConvention::Top);
}

TEST_CASE("Slabs of each convention lie where it says", "[slabs]") {
  const SliceStack stack = stack_of({1, 2, 4});
  const auto planes = [&](ZConvention c) {
    const SlabPlan plan = plan_of(stack, with(c));
    check_plan(stack, plan);
    std::vector<double> z{plan.slabs[0].z_low};
    for (const Slab& s : plan.slabs) z.push_back(s.z_high);
    return z;
  };
  CHECK(planes(ZConvention::Top) == std::vector<double>{0, 1, 2, 4});
  CHECK(planes(ZConvention::Bottom) == std::vector<double>{1, 2, 4, 6});
  CHECK(planes(ZConvention::Middle) == std::vector<double>{0.5, 1.5, 3, 5});
  CHECK(planes(ZConvention::Paper) == std::vector<double>{1, 2, 4});
}

TEST_CASE("A middle or upper stack on the plate begins exactly at zero", "[slabs]") {
  std::vector<double> z;
  for (int i = 0; i < 20; ++i) z.push_back(0.065 + 0.13 * i);
  CHECK(plan_of(stack_of(z)).slabs[0].z_low == 0);
  for (int i = 0; i < 20; ++i) z[static_cast<std::size_t>(i)] = 0.1 * (i + 1);
  CHECK(plan_of(stack_of(z)).slabs[0].z_low == 0);
}

TEST_CASE("N filled slices give N slabs and empty slices leave gaps", "[slabs]") {
  const SliceStack stack = stack_of({0, 1, 2, 3, 4, 5, 6, 7}, {0, 1, 4, 7});
  Diagnostics diagnostics;
  const SlabPlan plan = make_slabs(stack, {}, diagnostics);
  check_plan(stack, plan);
  CHECK(plan.convention == ZConvention::Top);
  REQUIRE(plan.slabs.size() == 4);
  CHECK(plan.slabs[0].z_low == 1);  // the empty slice below gives the thickness
  CHECK(plan.slabs[1].z_high == 3);
  CHECK(plan.slabs[2].z_low == 4);
  CHECK(diagnostics.count("empty_slices_between") == 1);
}

TEST_CASE("Slabs cover the range of the stack without overlap, whatever the spacing and the bundles", "[slabs]") {
  const unsigned seed = 4242;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> step(0.05, 0.2);
  std::uniform_int_distribution<int> percent(0, 99);
  int gaps = 0;
  for (int round = 0; round < 200; ++round) {
    std::vector<double> z;
    std::vector<std::size_t> empty;
    double at = round % 3 == 0 ? 0 : step(random);
    const bool full = round % 2 == 0;
    for (std::size_t i = 0; i < 40; ++i) {
      z.push_back(at);
      at += step(random);
      if (!full && i != 20 && percent(random) < 40) empty.push_back(i);
    }
    SliceStack stack = stack_of(z, empty);
    stack.z_unit = 0.3;
    for (const ZConvention c :
         {ZConvention::Auto, ZConvention::Top, ZConvention::Bottom, ZConvention::Middle, ZConvention::Paper})
      for (const std::int32_t lump : {1, 2, 3, 7, 100}) {
        const SlabPlan single = plan_of(stack, with(c));
        const SlabPlan plan = plan_of(stack, with(c, lump));
        check_plan(stack, plan);
        // Bundles keep the range, and their planes are planes of single slices.
        CHECK(plan.slabs.front().z_low == single.slabs.front().z_low);
        CHECK(plan.slabs.back().z_high == single.slabs.back().z_high);
        std::map<std::int32_t, Slab> by_layer;
        for (const Slab& s : single.slabs) by_layer[s.slice] = s;
        std::size_t covered = 0;
        for (const Slab& s : plan.slabs) {
          CHECK(s.z_low == by_layer.at(s.first_layer).z_low);
          CHECK(s.z_high == by_layer.at(s.last_layer).z_high);
          CHECK(s.last_layer - s.first_layer < lump);
          for (std::int32_t i = s.first_layer; i <= s.last_layer; ++i) covered += by_layer.count(i);
        }
        CHECK(covered == single.slabs.size());
        if (full) {
          const std::size_t n = single.slabs.size();
          CHECK(n == (plan.convention == ZConvention::Paper ? 39u : 40u));
          CHECK(plan.slabs.size() == (n + static_cast<std::size_t>(lump) - 1) / static_cast<std::size_t>(lump));
        }
        for (std::size_t i = 1; i < plan.slabs.size(); ++i) gaps += plan.slabs[i].z_low > plan.slabs[i - 1].z_high;
      }
  }
  CHECK(gaps > 0);
}

TEST_CASE("The middle slice stands for a bundle, or the filled one nearest to it", "[slabs]") {
  const SlabPlan five = plan_of(stack_of({1, 2, 3, 4, 5, 6, 7}), with(ZConvention::Top, 5));
  REQUIRE(five.slabs.size() == 2);
  CHECK(five.slabs[0].slice == 2);
  CHECK(five.slabs[1].slice == 5);
  const SlabPlan hole = plan_of(stack_of({1, 2, 3, 4, 5}, {2}), with(ZConvention::Top, 5));
  REQUIRE(hole.slabs.size() == 1);
  CHECK(hole.slabs[0].slice == 1);
  CHECK(hole.slabs[0].first_layer == 0);
  CHECK(hole.slabs[0].last_layer == 4);
  const SlabPlan upper = plan_of(stack_of({1, 2, 3, 4, 5}, {1, 2}), with(ZConvention::Top, 5));
  CHECK(upper.slabs[0].slice == 3);
}

TEST_CASE("Bundles by thickness hold as many slices as fit, rounding aside", "[slabs]") {
  std::vector<double> z;
  for (int i = 0; i < 12; ++i) z.push_back(0.1 * (i + 1));
  SlabOptions options;
  options.lump_thickness = 0.3;
  CHECK(plan_of(stack_of(z), options).slabs.size() == 4);
  options.lump_thickness = 0.29;
  CHECK(plan_of(stack_of(z), options).slabs.size() == 6);
  options.lump_thickness = 0.01;  // thinner than a slice: every slice for itself
  CHECK(plan_of(stack_of(z), options).slabs.size() == 12);
  options.lump_thickness = 6.2;
  CHECK(plan_of(stack_of({3.09998, 6.2, 9.3, 12.40001}), options).slabs.size() == 2);
}

TEST_CASE("The thickness of a plan is the median of its slabs", "[slabs]") {
  CHECK(plan_of(stack_of({0, 1, 2, 3, 13})).thickness == 1);
  CHECK(plan_of(stack_of({0, 1, 2, 3, 4, 5}), with(ZConvention::Auto, 2)).thickness == 2);
  CHECK(plan_of(stack_of({3.09998, 6.19999, 9.3})).thickness == Approx(3.1).epsilon(1e-4));
}

TEST_CASE("Open lines fill a slice unless the options say otherwise", "[slabs]") {
  SliceStack stack = stack_of({0, 1, 2, 3});
  Polyline line;
  line.direction = Direction::Open;
  line.points = {{0, 0}, {1, 1}};
  stack.layers[0].polylines = {line};
  CHECK(plan_of(stack).slabs.size() == 4);
  SlabOptions options;
  options.with_open_lines = false;
  CHECK(plan_of(stack, options).slabs.size() == 3);
  stack.layers[0].polylines.clear();
  stack.layers[0].hatches.resize(1);
  stack.layers[0].hatches[0].lines.push_back({Point2{0, 0}, Point2{1, 1}});
  CHECK(plan_of(stack).slabs.size() == 3);
}

TEST_CASE("A single slice takes its thickness from its z, from an empty one, or from the options", "[slabs]") {
  SlabPlan plan = plan_of(stack_of({0.3}));
  CHECK(plan.convention == ZConvention::Top);
  CHECK(plan.slabs[0].z_low == 0);
  CHECK(plan.slabs[0].z_high == 0.3);
  plan = plan_of(stack_of({0.3}), with(ZConvention::Middle));
  CHECK(plan.slabs[0].z_low == 0);
  CHECK(plan.slabs[0].z_high == 0.6);
  plan = plan_of(stack_of({1, 1.25}, {0}));
  CHECK(plan.slabs[0].z_low == 1);
  CHECK(plan.slabs[0].z_high == 1.25);
  SlabOptions options;
  options.thickness = 0.5;
  plan = plan_of(stack_of({0}), options);
  CHECK(plan.convention == ZConvention::Bottom);
  CHECK(plan.slabs[0].z_high == 0.5);
  CHECK_THROWS_AS(plan_of(stack_of({0})), GeometryError);
  CHECK_THROWS_AS(plan_of(stack_of({-1})), GeometryError);
  CHECK_THROWS_AS(plan_of(stack_of({0.3}), with(ZConvention::Bottom)), GeometryError);
  CHECK_THROWS_AS(plan_of(stack_of({0.3}), with(ZConvention::Paper)), GeometryError);
}

TEST_CASE("Paper drops the last slice of the file and says so", "[slabs]") {
  Diagnostics diagnostics;
  CHECK(make_slabs(stack_of({0, 1, 2}), with(ZConvention::Paper), diagnostics).slabs.size() == 2);
  CHECK(diagnostics.count("paper_drops_last") == 1);
  CHECK(make_slabs(stack_of({0, 1, 2, 3}, {2}), with(ZConvention::Paper), diagnostics).slabs.size() == 2);
  Diagnostics none;
  CHECK(make_slabs(stack_of({0, 1, 2}, {2}), with(ZConvention::Paper), none).slabs.size() == 2);
  CHECK(none.count("paper_drops_last") == 0);
  CHECK_THROWS_AS(make_slabs(stack_of({0, 1, 2}, {0, 1}), with(ZConvention::Paper), none), GeometryError);
}

TEST_CASE("A stack from which no slab can be made is an error that says why", "[slabs]") {
  CHECK_THROWS_AS(plan_of({}), GeometryError);
  CHECK_THROWS_AS(plan_of(stack_of({1, 2, 3}, {0, 1, 2})), GeometryError);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const std::vector<double>& z : {std::vector<double>{1, nan, 3}, {1, 3, 2}, {1, 1}}) {
    try {
      (void)plan_of(stack_of(z));
      FAIL("no error");
    } catch (const GeometryError& e) {
      CHECK(e.layer() >= 1);
    }
  }
  // Heights whose differences vanish in double.
  CHECK_THROWS_AS(plan_of(stack_of({1e300, std::nextafter(1e300, 2e300)}), with(ZConvention::Middle)), GeometryError);
}

TEST_CASE("Slab options out of range are refused", "[slabs]") {
  const auto option_of = [](const SlabOptions& options) {
    try {
      (void)plan_of(stack_of({0, 1, 2}), options);
    } catch (const OptionError& e) {
      return e.option();
    }
    return std::string("none");
  };
  CHECK(option_of({}) == "none");
  CHECK(option_of(with(ZConvention::Auto, 0)) == "lump");
  CHECK(option_of(with(static_cast<ZConvention>(17))) == "z_convention");
  SlabOptions options;
  options.lump_thickness = GENERATE(-1.0, std::numeric_limits<double>::infinity());
  CHECK(option_of(options) == "lump_thickness");
  options = {};
  options.thickness = -1;
  CHECK(option_of(options) == "thickness");
}

TEST_CASE("Every file of the shared data gets the convention of its writer", "[slabs][data]") {
  const auto data = slice2mesh_test::shared_data();
  if (!data) {
    WARN("skipped: no shared data");
    return;
  }
  const std::map<std::string, ZConvention> expected{
      {"reference/CAD5_Lp_l0.13.cli", ZConvention::Middle},
      {"reference/T_supported.cli", ZConvention::Bottom},
      {"reference/anc_101_a1_l0.01.cli", ZConvention::Middle},
      {"reference/anchor_0_l0.06.cli", ZConvention::Middle},
      {"reference/fandisk_l0.03_cino.cli", ZConvention::Middle},
      {"reference/joint_l0.02.cli", ZConvention::Middle},
      {"reference/nugear_coarse.cli", ZConvention::Top},
      {"reference/pyramid_l0.03.cli", ZConvention::Middle},
      {"reference/sphere_l0.03.cli", ZConvention::Middle},
      {"reference/torus_coarse.cli", ZConvention::Top},
      {"machine/Box_support_solid_ascii_with_params.cli", ZConvention::Top},
      {"machine/Lanze_bottomdown_20mm_onlyblocksupport_p_s.cli", ZConvention::Bottom},
      {"machine/frustrum_ASCII.cli", ZConvention::Top},
      {"machine/s_Cylinder_ex.cli", ZConvention::Bottom},
      {"machine/s_MiniCooper_ex.cli", ZConvention::Bottom},
  };
  int seen = 0;
  for (const auto& [name, convention] : expected) {
    const std::filesystem::path path = *data / name;
    if (!std::filesystem::exists(path)) continue;
    CAPTURE(name);
    ++seen;
    const SliceStack stack = read_cli(path.string());
    const SlabPlan plan = plan_of(stack);
    check_plan(stack, plan);
    CHECK(plan.convention == convention);
    std::size_t filled = 0;
    for (const Layer& layer : stack.layers) filled += detail::is_filled(layer, true);
    CHECK(plan.slabs.size() == filled);
    check_plan(stack, plan_of(stack, with(ZConvention::Auto, 3)));
    check_plan(stack, plan_of(stack, with(ZConvention::Paper)));
  }
  CHECK(seen > 0);
}
