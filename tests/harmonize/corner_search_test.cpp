// SPDX-License-Identifier: MIT
#include "slice2mesh/harmonize/corner_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <vector>

#include "harmonize/valid_outline.hpp"
#include "harmonize/wobbling_stack.hpp"
#include "plc/chain.hpp"
#include "slice2mesh/harmonize/attach.hpp"
#include "slice2mesh/harmonize/harmonize.hpp"
#include "slice2mesh/harmonize/separation.hpp"
#include "test_support.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;

namespace {

/// Contours whose corners are closed, and what they were made from. The slabs are as thick as the slices.
struct Closed {
  LayerRegions regions;
  Contours contours;
};
Closed closed_contours(const SliceStack& stack, double eps = 0.2) {
  Diagnostics diagnostics;
  const SlabPlan plan = make_slabs(stack, {}, diagnostics);
  ThickenOptions thicken_options;
  thicken_options.radius = Length::mm(0.1);
  Closed result{build_regions(stack, plan, thicken_options, diagnostics), {}};
  HarmonizeOptions options;
  options.eps = eps * plan.thickness;
  options.contour_size = 4 * plan.thickness;
  options.open_corners = false;
  result.contours = harmonize(result.regions, options, diagnostics);
  return result;
}
/// So many slabs of a square below the part, which it does not lie on.
void put_on(Closed& closed, std::size_t count) {
  Outline square;
  square.vertices = {{0, 0}, {1 << 24, 0}, {1 << 24, 1 << 24}, {0, 1 << 24}};
  square.edges = {{0, 1, 0, kNone}, {1, 2, 0, kNone}, {2, 3, 0, kNone}, {3, 0, 0, kNone}};
  detail::normalize(square);
  Contours& contours = closed.contours;
  contours.outlines.insert(contours.outlines.begin(), count, square);
  closed.regions.outlines.insert(closed.regions.outlines.begin(), count, square);
  contours.deviation.insert(contours.deviation.begin(), count, 0);
  const double bottom = contours.slabs.front().z_low - 1;
  for (std::size_t i = 0; i < count; ++i) {
    Slab slab = contours.slabs.front();
    slab.z_low = bottom - double(i + 1);
    slab.z_high = bottom - double(i);
    contours.slabs.insert(contours.slabs.begin(), slab);
  }
}

struct Searched {
  std::vector<Outline> outlines;
  std::vector<char> changed;
  std::vector<detail::CornerFinder::Corner> left;
};
/// `opener`: a CornerOpener or CornerSearch for what is given.
template <class F>
Searched open_by(const Closed& closed, F&& opener) {
  const Contours& contours = closed.contours;
  Searched result{contours.outlines, {}, {}};
  const double pitch = contours.grid.pitch;
  const detail::ColumnLimits limits = detail::corner_limits(contours.tolerance / pitch, 4 * contours.thickness / pitch);
  result.left = opener(result.outlines, closed.regions.outlines, contours.slabs, limits, result.changed);
  return result;
}
Searched search(const Closed& closed, const std::vector<char>& frozen) {
  return open_by(closed, [&](auto& outlines, auto& slices, auto& slabs, auto& limits, auto& changed) {
    return detail::CornerSearch(outlines, slices, slabs, frozen, limits).run(changed, [] {});
  });
}
Searched open_alone(const Closed& closed, const std::vector<char>& frozen) {
  return open_by(closed, [&](auto& outlines, auto& slices, auto& slabs, auto& limits, auto& changed) {
    return detail::CornerOpener(outlines, slices, slabs, frozen, limits).run(changed, [] {});
  });
}
/// All corners of contours that are sharp.
std::vector<detail::CornerFinder::Corner> corners_of(const Closed& closed, std::vector<Outline> outlines) {
  const std::vector<char> frozen(outlines.size(), 0);
  return detail::CornerTrial(outlines, closed.regions.outlines, closed.contours.slabs, frozen, {}).look({}).corners;
}
bool same(const detail::CornerFinder::Corner& c, const detail::CornerFinder::Corner& d) {
  return !(c < d) && !(d < c);
}

/// What there is between contours after harmonization; checks that all are within eps of their slices.
SeparationFigures harmonized_separation(const SliceStack& stack, double eps_in_layers) {
  Diagnostics diagnostics;
  const SlabPlan plan = make_slabs(stack, {}, diagnostics);
  HarmonizeOptions options;
  options.eps = eps_in_layers * plan.thickness;
  options.contour_size = 4 * plan.thickness;
  const Contours contours = harmonize(build_regions(stack, plan, {}, diagnostics), options, diagnostics);
  for (const double deviation : contours.deviation) CHECK(deviation <= contours.eps);
  return measure_separation(contours).between;
}

// Of random stacks those that keep sharp corners where they are opened one by one.
const std::vector<std::uint32_t> kSeeds{13, 38, 67, 206};

}  // namespace

TEST_CASE("a trial gives edges the vertices of the next slabs that lie on them, and they are alike from there on") {
  std::size_t shared = 0;
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    INFO("seed " << seed);
    const Closed closed = closed_contours(wobbling_stack(seed));
    const std::size_t count = closed.contours.slabs.size();
    const std::vector<char> frozen(count, 0);
    const double pitch = closed.contours.grid.pitch;
    const detail::ColumnLimits limits =
        detail::corner_limits(closed.contours.tolerance / pitch, 4 * closed.contours.thickness / pitch);
    std::vector<Outline> outlines = closed.contours.outlines;
    std::vector<char> changed;
    const detail::OutlineWindow all;
    detail::CornerTrial(outlines, closed.regions.outlines, closed.contours.slabs, frozen, limits)
        .share_vertices({all, all, {}, 1, 1}, changed, [] {});
    REQUIRE(changed.size() == count);
    for (std::size_t s = 0; s < count; ++s) {
      check_valid(outlines[s]);
      const Outline& before = closed.contours.outlines[s];
      CHECK((changed[s] != 0) == !(outlines[s] == before));
      const auto has = [](const Outline& outline, const GridPoint& p) {
        return std::find(outline.vertices.begin(), outline.vertices.end(), p) != outline.vertices.end();
      };
      for (const GridPoint& p : before.vertices) CHECK(has(outlines[s], p));
      for (const GridPoint& p : outlines[s].vertices) {
        if (has(before, p)) continue;
        ++shared;
        // One of the slabs beside has it, and it lies on an edge of this one.
        CHECK(((s > 0 && has(outlines[s - 1], p)) || (s + 1 < count && has(outlines[s + 1], p))));
        double least = HUGE_VAL;
        for (const Outline::Edge& e : before.edges)
          least = std::min(
              least, detail::segment_distance(p, before.vertices[std::size_t(e.a)], before.vertices[std::size_t(e.b)]));
        CHECK(least <= kAttachSteps * double(kContourStep));
      }
    }
  }
  CHECK(shared > 20);
}

TEST_CASE(
    "vertices near to what the next slab has, and to nothing of their own, count as corners that are to be opened") {
  // Squares in squares: each corner of the inner one is near to two edges and a corner of the outer one.
  const Polyline square = loop({{0, 0}, {20, 0}, {20, 20}, {0, 20}});
  Closed closed = closed_contours(stack_of({{square}, {square}}));
  Contours& contours = closed.contours;
  REQUIRE(contours.outlines.size() == 2);
  REQUIRE(contours.outlines[0] == contours.outlines[1]);
  const double eps = contours.tolerance / contours.grid.pitch;
  const Outline outer = contours.outlines[0];
  const std::vector<char> frozen(2, 0);
  const detail::OutlineWindow all;
  const auto faults = [&](const detail::ColumnLimits& limits) {
    return detail::CornerTrial(contours.outlines, closed.regions.outlines, contours.slabs, frozen, limits)
        .look(all)
        .corners;
  };
  const detail::ColumnLimits limits = detail::corner_limits(eps, HUGE_VAL);
  CHECK(faults(limits).empty());
  for (const double share : {0.1, 0.3, 0.4, 0.5}) {
    INFO("distance in eps " << share);
    const std::int64_t inset = round_to_step(std::llround(share * eps));
    GridPoint low = outer.vertices.front(), high = low;
    for (const GridPoint& p : outer.vertices) low = std::min(low, p), high = std::max(high, p);
    Outline inner = outer;
    for (GridPoint& p : inner.vertices) {
      if (p.x == low.x || p.x == high.x) p.x += p.x == low.x ? inset : -inset;
      if (p.y == low.y || p.y == high.y) p.y += p.y == low.y ? inset : -inset;
    }
    for (const std::size_t upper : {std::size_t(0), std::size_t(1)}) {
      contours.outlines[upper] = inner;
      contours.outlines[1 - upper] = outer;
      const SeparationFigures figures = measure_separation(contours).between;
      const std::vector<detail::CornerFinder::Corner> found = faults(limits);
      CHECK(found.size() == figures.below_aim());
      CHECK(figures.sharp == 0);
      CHECK(found.empty() == (share > kSeparationShare));
      for (const detail::CornerFinder::Corner& corner : found) {
        CHECK(corner.degrees <= kSeparationAngle);
        CHECK(corner.degrees >= kSeparationAngle * 0.99 * share / kSeparationShare);
        CHECK(corner.slab == 0);
      }
      detail::ColumnLimits none = limits;
      none.separate = 0;
      CHECK(faults(none).empty());
    }
  }
}

TEST_CASE("a thin wall of one contour is not what a search is for, also where the next contour has vertices on it") {
  // The walls that go up and down from the strip put vertices of the upper slice on the long edges of the lower one.
  const Polyline strip = loop({{0, 0}, {10, 0}, {10, 0.03}, {0, 0.03}}), cross = loop({{0, 0},
                                                                                       {4.2, 0},
                                                                                       {4.2, -1},
                                                                                       {7, -1},
                                                                                       {7, 0},
                                                                                       {10, 0},
                                                                                       {10, 0.03},
                                                                                       {5.5, 0.03},
                                                                                       {5.5, 1},
                                                                                       {4.5, 1},
                                                                                       {4.5, 0.03},
                                                                                       {0, 0.03}});
  for (const auto& slices : {std::vector<std::vector<Polyline>>{{strip}, {cross}},
                             {{cross}, {strip}},
                             {{strip}, {strip}},
                             {{cross}, {cross}, {strip}, {strip}, {cross}}}) {
    Closed closed = closed_contours(stack_of(slices));
    const double pitch = closed.contours.grid.pitch;
    const detail::ColumnLimits limits = detail::corner_limits(closed.contours.tolerance / pitch, HUGE_VAL);
    const SeparationReport report = measure_separation(closed.contours);
    CAPTURE(closed.contours.outlines[0].vertices.size(), closed.contours.outlines[1].vertices.size(),
            report.within.angle.size, report.within.vertices.size, report.within.vertex_edge.size, slices.size());
    CHECK(report.within.below_aim() > 0);
    REQUIRE(report.between.below_aim() == 0);
    const std::vector<char> frozen(slices.size(), 0);
    CHECK(detail::CornerTrial(closed.contours.outlines, closed.regions.outlines, closed.contours.slabs, frozen, limits)
              .look({})
              .corners.empty());
  }
}

TEST_CASE("what is found too near in random contours is found by the measure as well") {
  std::size_t found = 0;
  for (std::uint32_t seed = 1; seed <= 60; ++seed) {
    INFO("seed " << seed);
    // Slices differ by much more than this: not all that is near can be merged or moved apart.
    Closed closed = closed_contours(wobbling_stack(seed), 0.05);
    const double pitch = closed.contours.grid.pitch;
    detail::ColumnLimits limits = detail::corner_limits(closed.contours.tolerance / pitch, HUGE_VAL);
    const std::vector<char> frozen(closed.contours.slabs.size(), 0);
    const auto faults = [&] {
      return detail::CornerTrial(closed.contours.outlines, closed.regions.outlines, closed.contours.slabs, frozen,
                                 limits)
          .look({})
          .corners.size();
    };
    const std::size_t all = faults();
    limits.separate = 0;
    const std::size_t near = all - faults();
    const SeparationFigures figures = measure_separation(closed.contours).between;
    CHECK(near <= figures.close_vertices.back() + figures.close_vertex_edge.back());
    found += near;
  }
  CHECK(found > 0);
}

TEST_CASE("no corner between contours of random slices is left sharp, nor anything near") {
  // At some of them corners were left, or vertices near to an edge, without the sharing of vertices, crossings beside
  // vertices, the last pass, what contours are gathered at, the look at what is near, or more for few.
  struct Stacks {
    double eps;
    std::vector<std::uint32_t> seeds;
  };
  for (const Stacks& stacks : {Stacks{0.2, {1, 2, 3, 4, 5, 20, 49, 128, 259, 401, 889, 1336, 1525}},
                               Stacks{0.1, {1, 2, 91, 108, 154, 223, 224, 299, 315, 588, 987, 1604, 2760}},
                               Stacks{0.05, {365, 736, 807, 1405, 1798}}})
    for (const std::uint32_t seed : stacks.seeds) {
      INFO("seed " << seed << ", eps " << stacks.eps << "h");
      CHECK(harmonized_separation(wobbling_stack(seed), stacks.eps).below_aim() == 0);
    }
}

TEST_CASE("no corner between contours of many random slices is left sharp, nor anything near", "[slow]") {
  // More of them: SLICE2MESH_STACKS=4000 build/test/tests/stages_tests "no corner between contours of many*"
  const char* given = std::getenv("SLICE2MESH_STACKS");
  const auto stacks = std::uint32_t(given != nullptr ? std::strtoul(given, nullptr, 10) : 400);
  REQUIRE(stacks > 0);
  for (const double eps : {0.3, 0.2, 0.1, 0.05})
    for (std::uint32_t seed = 1; seed <= stacks; ++seed) {
      INFO("seed " << seed << ", eps " << eps << "h");
      CHECK(harmonized_separation(wobbling_stack(seed), eps).below_aim() == 0);
    }
}

TEST_CASE("what is cut out of an outline and put back makes the same outline") {
  std::mt19937 random(7);
  std::size_t partly = 0;
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    INFO("seed " << seed);
    const Closed closed = closed_contours(wobbling_stack(seed));
    for (const Outline& outline : closed.contours.outlines) {
      REQUIRE(!outline.empty());
      const auto vertex = [&] { return outline.vertices[random() % outline.vertices.size()]; };
      const GridPoint p = vertex(), q = vertex();
      detail::OutlineWindow window{p, p};
      window.add(q);
      const Outline inside = detail::cut(outline, window, true, {}), outside = detail::cut(outline, window, false, {});
      CHECK(inside.edges.size() + outside.edges.size() == outline.edges.size());
      // Vertices in the window have all of their edges.
      for (const Outline::Edge& e : outside.edges) {
        CHECK(!window.has(outside.vertices[std::size_t(e.a)]));
        CHECK(!window.has(outside.vertices[std::size_t(e.b)]));
      }
      if (!outside.empty()) ++partly;
      Outline again = outline;
      detail::put_back(again, window, inside, {});
      CHECK(again == outline);
      detail::put_back(again, window, {}, {});
      CHECK(again == outside);
    }
  }
  CHECK(partly > 20);
}

TEST_CASE("windows stay within the range of coordinates") {
  const detail::OutlineWindow all, point{{kGridLimit, 5}, {kGridLimit, 5}};
  for (const detail::OutlineWindow& window : {all.grown(1e300), all.grown(1), point.grown(1e300)}) {
    CHECK(window.low == all.low);
    CHECK(window.high == all.high);
  }
  CHECK(point.grown(2.5).low == GridPoint{kGridLimit - 3, 2});
  CHECK(point.grown(2.5).high == GridPoint{kGridLimit, 8});
}

TEST_CASE("a search opens corners that are left when they are opened one by one") {
  std::size_t one_by_one = 0, searched = 0;
  for (const std::uint32_t seed : kSeeds) {
    INFO("seed " << seed);
    const Closed closed = closed_contours(wobbling_stack(seed));
    const std::vector<char> frozen(closed.contours.slabs.size(), 0);
    const Searched before = open_alone(closed, frozen), after = search(closed, frozen);
    const double eps = closed.contours.tolerance / closed.contours.grid.pitch;
    for (std::size_t s = 0; s < frozen.size(); ++s) {
      check_valid(after.outlines[s]);
      CHECK(detail::measured_deviation(after.outlines[s], closed.regions.outlines[s], eps, {}) <= eps);
      if (after.changed[s] == 0) CHECK(after.outlines[s] == closed.contours.outlines[s]);
    }
    const auto left = corners_of(closed, after.outlines), one_left = corners_of(closed, before.outlines);
    CHECK(left.size() <= one_left.size());
    one_by_one += one_left.size();
    searched += left.size();
    // It tells what it leaves.
    CHECK(before.left.size() == one_left.size());
    for (const auto& c : left)
      CHECK(std::any_of(after.left.begin(), after.left.end(), [&](const auto& d) { return same(c, d); }));
    // The same again.
    CHECK(search(closed, frozen).outlines == after.outlines);
  }
  CHECK(one_by_one >= kSeeds.size());
  CHECK(4 * searched <= one_by_one);
}

TEST_CASE("a search knows the slabs of its corners far up in a stack") {
  constexpr std::size_t kBelow = 150;  // more than what is cut out reaches down
  std::size_t before = 0, after = 0;
  for (const std::uint32_t seed : kSeeds) {
    INFO("seed " << seed);
    Closed closed = closed_contours(wobbling_stack(seed));
    put_on(closed, kBelow);
    const std::vector<char> frozen(closed.contours.slabs.size(), 0);
    const Searched searched = search(closed, frozen);
    for (std::size_t s = 0; s < kBelow; ++s) REQUIRE(searched.outlines[s] == closed.contours.outlines[s]);
    for (const auto& c : searched.left) CHECK(c.slab >= kBelow);
    const auto left = corners_of(closed, searched.outlines);
    for (const auto& c : left)
      CHECK(std::any_of(searched.left.begin(), searched.left.end(), [&](const auto& d) { return same(c, d); }));
    before += corners_of(closed, open_alone(closed, frozen).outlines).size();
    after += left.size();
  }
  CHECK(before >= kSeeds.size());
  CHECK(4 * after <= before);
}

TEST_CASE("a search leaves slabs alone that may not change") {
  const Closed closed = closed_contours(wobbling_stack(49));
  std::vector<char> frozen(closed.contours.slabs.size(), 0);
  for (std::size_t s = 0; s < frozen.size(); s += 2) frozen[s] = 1;
  const Searched after = search(closed, frozen);
  CHECK(std::count(after.changed.begin(), after.changed.end(), 1) > 0);
  for (std::size_t s = 0; s < frozen.size(); s += 2) {
    CHECK(after.outlines[s] == closed.contours.outlines[s]);
    CHECK(after.changed[s] == 0);
  }
  CHECK(corners_of(closed, after.outlines).size() <= corners_of(closed, closed.contours.outlines).size());
}

TEST_CASE("a search listens while it works") {
  struct Stop {};
  const Closed closed = closed_contours(wobbling_stack(kSeeds.front()));
  const std::vector<char> frozen(closed.contours.slabs.size(), 0);
  std::vector<Outline> outlines = closed.contours.outlines;
  std::vector<char> changed;
  const double pitch = closed.contours.grid.pitch;
  const detail::ColumnLimits limits =
      detail::corner_limits(closed.contours.tolerance / pitch, 4 * closed.contours.thickness / pitch);
  std::size_t calls = 0;
  detail::CornerSearch(outlines, closed.regions.outlines, closed.contours.slabs, frozen, limits).run(changed, [&] {
    ++calls;
  });
  REQUIRE(calls > 1);
  outlines = closed.contours.outlines;
  std::size_t now = 0;
  CHECK_THROWS_AS(detail::CornerSearch(outlines, closed.regions.outlines, closed.contours.slabs, frozen, limits)
                      .run(changed,
                           [&] {
                             if (++now == calls) throw Stop{};
                           }),
                  Stop);
}
