// SPDX-License-Identifier: MIT
#include "slice2mesh/harmonize/harmonize.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "harmonize/valid_outline.hpp"
#include "plc/chain.hpp"
#include "test_support.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;

namespace {

struct Harmonized {
  LayerRegions input;
  Contours contours;
  Diagnostics diagnostics;
};
Harmonized harmonize_stack(const SliceStack& stack, double eps_in_layers, double contour_size = 1) {
  Harmonized h;
  const SlabPlan plan = make_slabs(stack, {}, h.diagnostics);
  ThickenOptions thicken_options;
  thicken_options.radius = Length::mm(0.1);
  h.input = build_regions(stack, plan, thicken_options, h.diagnostics);
  HarmonizeOptions options;
  options.eps = eps_in_layers * plan.thickness;
  options.contour_size = contour_size * plan.thickness;
  h.contours = harmonize(h.input, options, h.diagnostics);
  return h;
}

/// Distance of p to the nearest edge, by looking at all of them.
double distance_to(const Outline& outline, const GridPoint& p) {
  double best = HUGE_VAL;
  for (const Outline::Edge& e : outline.edges)
    best = std::min(
        best, detail::segment_distance(p, outline.vertices[std::size_t(e.a)], outline.vertices[std::size_t(e.b)]));
  return best;
}
/// Largest such distance of points along the edges of another outline.
double sampled_deviation(const Outline& from, const Outline& to) {
  double worst = 0;
  for (const Outline::Edge& e : from.edges)
    for (int i = 0; i <= 8; ++i) {
      const GridPoint &a = from.vertices[std::size_t(e.a)], &b = from.vertices[std::size_t(e.b)];
      worst = std::max(worst, distance_to(to, {a.x + (b.x - a.x) * i / 8, a.y + (b.y - a.y) * i / 8}));
    }
  return worst;
}

void check_all(const Harmonized& h, bool sampled) {
  const double pitch = h.contours.grid.pitch;
  REQUIRE(h.contours.outlines.size() == h.input.outlines.size());
  for (std::size_t s = 0; s < h.contours.outlines.size(); ++s) {
    INFO("slab " << s);
    check_valid(h.contours.outlines[s]);
    CHECK(h.contours.deviation[s] <= h.contours.eps);
    if (!sampled) continue;
    const double there = sampled_deviation(h.contours.outlines[s], h.input.outlines[s]) * pitch;
    const double back = sampled_deviation(h.input.outlines[s], h.contours.outlines[s]) * pitch;
    // What is reported bounds what is found, up to points of contours that were split on the grid.
    const double rounding = 2 * double(kContourStep) * pitch;
    CHECK(std::max(there, back) <= h.contours.deviation[s] + rounding);
    CHECK(h.contours.deviation[s] <= h.contours.eps);
  }
}

}  // namespace

TEST_CASE("every contour is within eps of its slice, both ways, and is a valid outline") {
  double largest = 0;
  for (std::uint32_t seed = 1; seed <= 10; ++seed)
    for (const double eps : {0.1, 0.5}) {
      INFO("seed " << seed << " eps " << eps);
      const Harmonized h = harmonize_stack(random_stack(seed, 5), eps);
      check_all(h, true);
      for (const double d : h.contours.deviation) largest = std::max(largest, d / h.contours.eps);
    }
  CHECK(largest > 0.1);  // something was changed at all
  for (const NamedStack& named : generated_stacks()) {
    INFO(named.name);
    check_all(harmonize_stack(named.stack, 0.1), true);
  }
}

TEST_CASE("with eps 0 contours are those of the slices but for 2^-20 of the extent") {
  for (std::uint32_t seed = 30; seed < 34; ++seed) {
    INFO("seed " << seed);
    const Harmonized h = harmonize_stack(random_stack(seed, 3), 0);
    for (std::size_t s = 0; s < h.contours.outlines.size(); ++s) {
      CHECK(detail::deviation(h.contours.outlines[s], h.input.outlines[s], 1) <= detail::kSmallestEps);
      CHECK(h.contours.deviation[s] <= detail::kSmallestEps * h.input.grid.pitch);
    }
  }
}

TEST_CASE("identical slices get identical contours") {
  for (std::uint32_t seed = 40; seed < 48; ++seed) {
    INFO("seed " << seed);
    SliceStack stack = random_stack(seed, 4);
    for (Layer& layer : stack.layers) layer.polylines = stack.layers[0].polylines;
    const Harmonized h = harmonize_stack(stack, 0.1);
    REQUIRE(h.contours.outlines.size() == 4);
    for (std::size_t s = 1; s < 4; ++s) CHECK(h.contours.outlines[s] == h.contours.outlines[0]);
  }
}

TEST_CASE("slices that differ by less than eps get the contour below, wider differences stay") {
  const auto shifted = [](double by) { return stack_of({{rectangle(0, 0, 4, 3)}, {rectangle(by, 0, 4 + by, 3)}}); };
  const Harmonized near = harmonize_stack(shifted(0.02), 0.1);  // eps is 0.05 mm
  CHECK(near.contours.outlines[0] == near.contours.outlines[1]);
  const Harmonized far = harmonize_stack(shifted(0.2), 0.1);
  CHECK_FALSE(far.contours.outlines[0] == far.contours.outlines[1]);
  const double unit = far.contours.grid.pitch * far.contours.grid.pitch / 2;
  CHECK(double(detail::doubled_area(far.contours.outlines[1], kNone)) * unit == Approx(12).epsilon(0.01));
}

TEST_CASE("needles and gaps that are longer than those of the slice below keep their length") {
  // Both sides of such a one are near to the end of the one below, and its base is short: led through that end, or
  // merged, it would vanish from there on, and the slice be harmonized again with less and less of eps.
  const std::uint32_t seed = 20261128;
  CAPTURE(seed);
  std::mt19937 random(seed);
  const auto real = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  int again = 0;
  constexpr int kTries = 100;
  for (int i = 0; i < kTries; ++i) {
    const bool gap = i % 2 != 0;
    const double width = real(0.005, 0.055), depth = real(0.1, 0.4), slant = real(-0.15, 0.15);
    INFO("try " << i << ": " << (gap ? "gap" : "needle") << " of " << width << " mm");
    const auto slice = [&](double d, double w) {
      Polyline line;
      line.points = {{0, 0}, {4, 0}, {4, 3}, {2 + w, 3}, {2 + w / 3 + slant * d, gap ? 3 - d : 3 + d}, {2, 3}, {0, 3}};
      return std::vector<Polyline>{line};
    };
    const double share = real(0.3, 1.3), more = real(0.1, 0.5);
    const Harmonized h = harmonize_stack(stack_of({slice(depth, width * share), slice(depth + more, width)}), 0.1);
    check_all(h, true);
    for (const Diagnostic& d : h.diagnostics.entries()) again += d.code == "harmonized_again" ? int(d.count) : 0;
  }
  CHECK(again <= kTries / 20);  // without the rules against it: more than one per try
}

TEST_CASE("merging short edges takes away what is small as a whole, and nothing longer, and lets nothing cross") {
  using detail::Bond;
  const auto merged = [](Outline outline) {
    const std::vector<Bond> bond(outline.vertices.size(), Bond::Free);
    detail::merge_short_edges(outline, bond, std::vector<char>(outline.edges.size(), 0), 1000);
    return outline;
  };
  const auto triangle = [](const GridPoint& a, const GridPoint& b, const GridPoint& c) {
    Outline outline;
    outline.vertices = {a, b, c};
    outline.edges = {{0, 1, 0, kNone}, {1, 2, 0, kNone}, {2, 0, 0, kNone}};
    return outline;
  };
  CHECK(merged(triangle({0, 0}, {900, 5}, {450, 600})).edges.empty());
  CHECK(merged(triangle({0, 0}, {100, 0}, {50, 5000})).edges.size() == 3);
  CHECK(merged(triangle({0, 0}, {950, 5}, {1900, 0})).edges.size() == 3);
  CHECK(merged(triangle({0, 0}, {0, 400}, {950, 0})).edges.size() == 3);  // one side is longer
  // A small triangle that goes, at a vertex of a large one: the vertex that is left stands in the way of what is
  // beside.
  Outline outline;
  outline.vertices = {{0, 0},     {10, 0},    {5, 9},    {3000, -1000}, {3000, 1000},
                      {20, 2000}, {-60, -20}, {20, -20}, {20, -3000},   {-3000, -3000}};
  outline.edges = {{1, 2, 0, kNone}, {1, 0, kNone, 0}, {2, 0, 0, kNone}, {1, 3, 0, kNone},
                   {3, 4, 0, kNone}, {4, 1, 0, kNone}, {6, 5, 0, kNone}, {5, 9, 0, kNone},
                   {9, 8, 0, kNone}, {8, 7, 0, kNone}, {6, 7, kNone, 0}};
  const auto crossings = [](const Outline& o) {
    int count = 0;
    for (const Outline::Edge& e : o.edges)
      for (const Outline::Edge& f : o.edges)
        if (e.a != f.a && e.a != f.b && e.b != f.a && e.b != f.b)
          count += detail::segments_meet(o.vertices[std::size_t(e.a)], o.vertices[std::size_t(e.b)],
                                         o.vertices[std::size_t(f.a)], o.vertices[std::size_t(f.b)])
                       ? 1
                       : 0;
    return count;
  };
  REQUIRE(crossings(outline) == 0);
  const Outline result = merged(outline);
  CHECK(result.edges.size() < outline.edges.size());
  CHECK(crossings(result) == 0);
}

TEST_CASE("deviations do not add up over the layers") {
  // A wall that leans by less than eps per layer: every contour has to follow all the same.
  std::vector<std::vector<Polyline>> slices;
  for (int i = 0; i < 40; ++i) slices.push_back({rectangle(0.01 * i, 0, 4 + 0.01 * i, 3)});
  const Harmonized h = harmonize_stack(stack_of(slices), 0.1);
  check_all(h, true);
  CHECK_FALSE(h.contours.outlines.front() == h.contours.outlines.back());
}

TEST_CASE("the measured deviation is not above the true one by more than the resolution") {
  const std::uint32_t seed = 20261122;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  const auto uniform = [&](std::int64_t most) { return std::uniform_int_distribution<std::int64_t>(0, most)(random); };
  const double resolution = 400;
  double largest = 0;
  for (int round = 0; round < 20; ++round) {
    // Two rough lines beside each other, with steps of their own.
    Outline lines[2];
    for (Outline& line : lines)
      for (std::int64_t x = 0; x < 1000000; x += 1000 + uniform(8000)) {
        line.vertices.push_back({x, uniform(3000) + (&line == lines ? 0 : 20000)});
        const auto n = std::int32_t(line.vertices.size());
        if (n > 1) line.edges.push_back({n - 2, n - 1, 0, kNone});
      }
    double found = 0, step = 0;
    for (const Outline::Edge& e : lines[0].edges) {
      const GridPoint &a = lines[0].vertices[std::size_t(e.a)], &b = lines[0].vertices[std::size_t(e.b)];
      step = std::max(step, detail::distance(a, b) / 200);
      for (int i = 0; i <= 200; ++i)
        found = std::max(found, distance_to(lines[1], {a.x + (b.x - a.x) * i / 200, a.y + (b.y - a.y) * i / 200}));
    }
    const double measured = detail::one_sided_deviation(lines[0], detail::SegmentIndex(lines[1]), resolution);
    REQUIRE(measured >= found - 1);
    REQUIRE(measured <= found + step + resolution);
    largest = std::max(largest, measured - found);
  }
  CHECK(largest > 0);  // the bound is not taken for the value
}

TEST_CASE("a tolerance wider than the part is as any other that is") {
  const SliceStack stack = random_stack(3, 3);
  const Harmonized wide = harmonize_stack(stack, 1e6), wider = harmonize_stack(stack, 1e250);
  for (std::size_t s = 0; s < wide.contours.outlines.size(); ++s) {
    check_valid(wide.contours.outlines[s]);
    CHECK(wide.contours.outlines[s] == wider.contours.outlines[s]);
  }
  CHECK(wide.contours.outlines.size() == 3);
}

TEST_CASE("a contour has no edge longer than its size") {
  const Harmonized h = harmonize_stack(stack_of({{rectangle(0, 0, 10, 3)}, {rectangle(0, 0, 10, 4)}}), 0.1, 0.5);
  std::size_t edges = 0;
  for (const Outline& outline : h.contours.outlines)
    for (const Outline::Edge& e : outline.edges) {
      const double length = detail::distance(outline.vertices[std::size_t(e.a)], outline.vertices[std::size_t(e.b)]) *
                            h.contours.grid.pitch;
      CHECK(length <= 0.25 * (1 + 1e-6));  // half of the layer thickness
      ++edges;
    }
  CHECK(edges > 100);
}

namespace {

/// A closed polygon, material inside, counter-clockwise.
Outline polygon(const std::vector<GridPoint>& points) {
  Outline outline;
  outline.vertices = points;
  for (std::size_t i = 0; i < points.size(); ++i)
    outline.edges.push_back({std::int32_t(i), std::int32_t((i + 1) % points.size()), 0, kNone});
  detail::normalize(outline);
  return outline;
}

struct MergedColumns {
  std::vector<Outline> outlines;
  std::vector<char> changed;
};
/// Slabs of height 1 that stand on each other.
std::vector<Slab> stacked_slabs(std::size_t count) {
  std::vector<Slab> slabs(count);
  for (std::size_t s = 0; s < count; ++s) slabs[s].z_low = double(s), slabs[s].z_high = double(s + 1);
  return slabs;
}
/// Columns nearer than 1600 pitches merged, in slabs that stand on each other and are their own slices.
MergedColumns merge(const std::vector<Outline>& outlines, double deviation, const std::vector<char>& frozen = {},
                    double apart = 0) {
  const std::vector<Slab> slabs = stacked_slabs(outlines.size());
  const std::vector<char> none(outlines.size(), 0);
  MergedColumns result{outlines, {}};
  detail::ColumnMerger merger(result.outlines, outlines, slabs, frozen.empty() ? none : frozen,
                              {std::max(1600.0, apart), deviation, deviation, 600, 1e9, apart});
  merger.run(result.changed, [] {});
  return result;
}

const std::int64_t kSide = 160000;
const GridPoint kShort{kSide - 800, kSide};  // next to a corner of the square
const std::vector<GridPoint> kSquare{{0, 0}, {kSide, 0}, {kSide, kSide}, {0, kSide}};

}  // namespace

TEST_CASE("a short edge goes in all slabs that have it, and they stay alike") {
  const Outline with = polygon({{0, 0}, {kSide, 0}, {kSide, kSide}, kShort, {0, kSide}});
  const MergedColumns merged = merge({with, with, with}, 1000);
  for (const Outline& outline : merged.outlines) {
    check_valid(outline);
    CHECK(outline == polygon(kSquare));  // the corner stays, as nothing is nearer to the slice
  }
  CHECK(merged.changed == std::vector<char>(3, 1));
}

TEST_CASE("vertices of neighboring slabs that are close get one place, whichever slab is the lower one") {
  const Outline lower = polygon(kSquare), upper = polygon({{0, 0}, {kSide, 0}, {kSide + 800, kSide + 480}, {0, kSide}});
  for (const bool swapped : {false, true}) {
    const MergedColumns merged =
        merge(swapped ? std::vector<Outline>{upper, upper, lower} : std::vector<Outline>{lower, lower, upper}, 1000);
    for (const Outline& outline : merged.outlines) {
      check_valid(outline);
      CHECK(outline == merged.outlines[0]);
    }
  }
}

TEST_CASE("an edge is led through a vertex that lies on it where a close pair could not be merged otherwise") {
  // Whichever of the two edges at the corners turns, a vertex of the other slab that lies on it would be left beside
  // it, by 1280 to 2560 pitches, more than what the overlay takes for the same.
  const std::int64_t gap = 5120;
  const GridPoint lower_corner{kSide, kSide}, upper_corner{kSide + gap, kSide + gap};
  const GridPoint on_lower{kSide, kSide / 2}, on_upper{(kSide + gap) / 2, kSide + gap / 2};
  const Outline lower = polygon({{0, 0}, {kSide, 0}, lower_corner, on_upper, {0, kSide}});
  const Outline upper = polygon({{0, 0}, {kSide, 0}, on_lower, upper_corner, {0, kSide}});
  for (const bool swapped : {false, true}) {
    INFO("swapped " << swapped);
    const std::vector<Outline> slices =
        swapped ? std::vector<Outline>{upper, lower} : std::vector<Outline>{lower, upper};
    const std::vector<Slab> slabs = stacked_slabs(2);
    MergedColumns merged{slices, {}};
    const std::vector<char> none(2, 0);
    detail::ColumnMerger merger(merged.outlines, slices, slabs, none, {24000, 16000, 16000, 11000, 1e9, 0});
    merger.run(merged.changed, [] {});
    std::size_t corners = 0;
    for (const Outline& outline : merged.outlines) check_valid(outline);
    for (const GridPoint& v : merged.outlines[0].vertices)
      if (v.x > kSide * 3 / 4 && v.y > kSide * 3 / 4) {
        ++corners;
        CHECK(detail::distance(v, lower_corner) < 8000);
        CHECK(std::count(merged.outlines[1].vertices.begin(), merged.outlines[1].vertices.end(), v) == 1);
      }
    CHECK(corners == 1);
    CHECK(merged.changed == std::vector<char>(2, 1));
  }
}

namespace {

/// The own contour with the ways of another one within 10000 pitches of the slice.
Outline adopt(const Outline& own, const Outline& other, const Outline& slice) {
  const detail::SegmentIndex index(other);
  detail::SliceNearness nearness(slice);
  return detail::adopt_ways(own, other, index, nearness, 1, 10000, 1e9);
}

/// Twice the area of a valid outline of one region.
double twice_area(const Outline& outline) {
  double sum = 0;
  for (const Outline::Edge& e : outline.edges) {
    const GridPoint &a = outline.vertices[std::size_t(e.a)], &b = outline.vertices[std::size_t(e.b)];
    const double part = double(a.x) * double(b.y) - double(b.x) * double(a.y);
    sum += e.left != kNone ? part : -part;
  }
  return sum;
}

}  // namespace

TEST_CASE("a contour takes the way of its neighbor where its slice is near to it, and keeps its own elsewhere") {
  const std::int64_t deep = 32000, flat = 6400;
  const Outline square = polygon(kSquare);
  // A dent of the right side, and one of the top.
  const std::vector<GridPoint> right{{kSide, 40000}, {kSide - flat, 42000}, {kSide - flat, 80000}, {kSide, 82000}};
  const auto with_top = [&](std::int64_t depth) {
    std::vector<GridPoint> points{{0, 0}, {kSide, 0}};
    points.insert(points.end(), right.begin(), right.end());
    for (const GridPoint& p : {GridPoint{kSide, kSide}, GridPoint{90000, kSide}, GridPoint{88000, kSide - depth},
                               GridPoint{50000, kSide - depth}, GridPoint{48000, kSide}, GridPoint{0, kSide}})
      points.push_back(p);
    return polygon(points);
  };
  SECTION("shallow dents go, and come, with the neighbor") {
    CHECK(adopt(with_top(flat), square, with_top(flat)) == square);
    CHECK(adopt(square, with_top(flat), square) == with_top(flat));
  }
  SECTION("a deep one stays, beside a shallow one that goes") {
    const Outline result = adopt(with_top(deep), square, with_top(deep));
    check_valid(result);
    CHECK(twice_area(result) == twice_area(square) - 80000.0 * double(deep));  // the trapezoid: (42000 + 38000) / 2
    for (const GridPoint& p : right) CHECK(std::count(result.vertices.begin(), result.vertices.end(), p) == 0);
  }
  SECTION("a deep one of the neighbor is not taken") {
    const Outline result = adopt(square, with_top(deep), square);
    check_valid(result);
    CHECK(twice_area(result) == twice_area(square) - 80000.0 * double(flat));
  }
  SECTION("nothing changes where the slice asks for the own way though both contours are near to each other") {
    const Outline far_slice = polygon({{0, 0}, {kSide - 12000, 0}, {kSide - 12000, kSide}, {0, kSide}});
    const Outline own = polygon({{0, 0}, {kSide - flat, 0}, {kSide - flat, kSide}, {0, kSide}});
    CHECK(adopt(own, square, far_slice) == own);
  }
}

TEST_CASE("adopting ways never makes neighbors differ by more area in all, makes it less for most, and keeps eps") {
  // Twice the area where neighbors are in different regions, in square pitches.
  const auto difference = [](const Contours& contours) {
    double sum = 0;
    for (std::size_t s = 1; s < contours.outlines.size(); ++s) {
      const detail::OutlineOverlay overlay(contours.outlines[s], detail::SegmentIndex(contours.outlines[s]),
                                           contours.outlines[s - 1], std::int32_t(contours.regions.size()), 0, {});
      for (std::size_t e = 0; e < overlay.arrangement.edges.size(); ++e) {
        const auto& [left, right] = overlay.faces.of_edge[e];
        const GridPoint &a = overlay.arrangement.vertices[std::size_t(overlay.arrangement.edges[e].a)],
                        &b = overlay.arrangement.vertices[std::size_t(overlay.arrangement.edges[e].b)];
        sum += (double(overlay.differs(left)) - double(overlay.differs(right))) *
               (double(a.x) * double(b.y) - double(b.x) * double(a.y));
      }
    }
    return sum;
  };
  std::size_t less = 0;
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    INFO("seed " << seed);
    Harmonized h = harmonize_stack(random_stack(seed, 8), 0.5);
    HarmonizeOptions options;
    options.eps = h.contours.eps;
    options.contour_size = h.contours.thickness;
    options.merge_columns = false;
    h.contours = harmonize(h.input, options, h.diagnostics);
    const double before = difference(h.contours), eps = h.contours.eps / h.contours.grid.pitch;
    detail::adopt_ways(h.contours, h.input, eps, 2 * eps, {});
    const double after = difference(h.contours);
    REQUIRE(before > 0);
    CHECK(after <= (1 + 1e-6) * before);  // ways are led through vertices that they pass
    less += std::size_t(after < 0.999 * before);
    check_all(h, true);
  }
  CHECK(less > 6);
}

TEST_CASE("columns do not merge where a slab would leave its slice, nor in slabs that are to stay") {
  const Outline lower = polygon(kSquare), upper = polygon({{0, 0}, {kSide, 0}, {kSide + 800, kSide + 480}, {0, kSide}});
  const MergedColumns near = merge({lower, upper}, 300);  // half of their distance is 466
  CHECK(near.outlines[0] == lower);
  CHECK(near.outlines[1] == upper);
  CHECK(near.changed == std::vector<char>(2, 0));
  const MergedColumns frozen = merge({lower, upper}, 1000, {0, 1});
  CHECK(frozen.outlines[0] == lower);
  CHECK(frozen.outlines[1] == upper);
}

TEST_CASE("a vertex beside an edge of the next slab moves onto it or away, within the deviation") {
  const Outline lower = polygon(kSquare);
  const std::vector<char> none(2, 0);
  std::size_t onto = 0, away = 0;
  for (const std::int64_t beside : {1600, 3200, 4800, 6400, -1600, -3200, -4800, -6400}) {
    INFO("at " << beside << " pitches");
    const GridPoint bulge{kSide + beside, kSide / 2};
    const Outline upper = polygon({{0, 0}, {kSide, 0}, bulge, {kSide, kSide}, {0, kSide}});
    const double before = double(std::llabs(beside));
    const MergedColumns moved = merge({lower, upper}, 7000, none, 8000);
    CHECK(moved.changed != none);
    for (std::size_t k = 0; k < 2; ++k) {
      check_valid(moved.outlines[k]);
      CHECK(detail::deviation(moved.outlines[k], k == 0 ? lower : upper, 1) <= 7001);
    }
    double nearest = HUGE_VAL;  // of the vertices of the upper slab that the lower one does not have
    const std::vector<GridPoint>& common = moved.outlines[0].vertices;
    for (const GridPoint& v : moved.outlines[1].vertices)
      if (std::find(common.begin(), common.end(), v) == common.end())
        nearest = std::min(nearest, distance_to(moved.outlines[0], v));
    if (nearest <= kAttachSteps * double(kContourStep))
      ++onto;
    else if (nearest > before)
      ++away;
    else
      FAIL("still at " << nearest);
    // Not where it would leave its slice, nor where it is not wanted.
    CHECK(merge({lower, upper}, 100, none, 8000).changed == none);
    CHECK(merge({lower, upper}, 7000, {0, 1}, 8000).changed == none);
    CHECK(merge({lower, upper}, 7000, none, before).changed == none);
  }
  CHECK(onto + away == 8);
}

TEST_CASE("a column does not move across what stands in its way") {
  // The upper slab is a frame whose hole has a tip between the two vertices that are close.
  const Outline lower = polygon({{0, 0}, {kSide, 0}, {kSide, kSide}, {0, kSide}});
  Outline upper = polygon({{0, 0}, {kSide, 0}, {kSide + 1040, kSide + 1040}, {0, kSide}});
  const Outline tip =
      polygon({{kSide + 160, kSide + 640}, {kSide / 2 - 16000, kSide / 2 + 16000}, {kSide / 2, kSide / 2}});
  const auto first = std::int32_t(upper.vertices.size());
  upper.vertices.insert(upper.vertices.end(), tip.vertices.begin(), tip.vertices.end());
  for (const Outline::Edge& e : tip.edges) upper.edges.push_back({e.a + first, e.b + first, e.right, e.left});
  detail::normalize(upper);
  check_valid(upper);
  const MergedColumns merged = merge({lower, upper}, 3000);
  for (const Outline& outline : merged.outlines) check_valid(outline);
}

TEST_CASE("contour sizes far below eps cost no more than their points") {
  // Harmonizing so fine pieces would merge them as fast as they are made.
  const Harmonized h = harmonize_stack(random_stack(7, 3), 0.5, 0.002);
  const double longest = 0.002 * h.contours.thickness / h.contours.grid.pitch;
  std::size_t edges = 0;
  for (std::size_t s = 0; s < h.contours.slabs.size(); ++s) {
    check_valid(h.contours.outlines[s]);
    CHECK(h.contours.deviation[s] <= h.contours.eps);
    edges += h.contours.outlines[s].edges.size();
    for (const Outline::Edge& e : h.contours.outlines[s].edges)
      REQUIRE(detail::distance(h.contours.outlines[s].vertices[std::size_t(e.a)],
                               h.contours.outlines[s].vertices[std::size_t(e.b)]) <= longest * 1.01);
  }
  CHECK(edges > 10000);
}

TEST_CASE("a sliver of a region that the planes cannot tell from nothing vanishes, a wider one stays as it is") {
  constexpr std::int64_t kWide = std::int64_t{1} << 30;
  for (const std::int64_t width : {std::int64_t{16}, std::int64_t{112}, std::int64_t{1008}, std::int64_t{2000}}) {
    INFO("width " << width);
    // Region 1 is a triangle between the outside and region 0.
    Outline outline;
    outline.vertices = {{0, 0}, {kWide / 2, -kWide / 2}, {kWide / 2, -width}, {kWide, 0}};
    outline.edges = {{0, 1, 0, kNone}, {0, 2, 1, 0}, {0, 3, kNone, 1}, {1, 3, 0, kNone}, {2, 3, 1, 0}};
    const bool stays = double(width) > kAttachSteps * double(kContourStep);
    CHECK(detail::vertices_beside_edges(outline, kAttachSteps * double(kContourStep)).empty() == stays);
    Outline attached = outline;
    detail::attach_vertices(attached, 2);
    CHECK(detail::vertices_beside_edges(attached, kAttachSteps * double(kContourStep)).empty());
    CHECK((attached == outline) == stays);
    if (stays) continue;
    CHECK(attached.vertices == outline.vertices);
    REQUIRE(attached.edges.size() == 4);
    for (const Outline::Edge& e : attached.edges) CHECK((e.left == kNone) != (e.right == kNone));
    CHECK(detail::doubled_area(attached, 1) == 0);
  }
}

TEST_CASE("edges that meet at a sharp corner are split at the same distances from it") {
  constexpr int kTriangles = 9;
  std::vector<Polyline> fan;
  for (int i = 0; i < kTriangles; ++i) {
    const double a = 0.1 * i, b = a + 0.04;
    fan.push_back(loop({{0, 0}, {5.2 * std::cos(a), 5.2 * std::sin(a)}, {5.2 * std::cos(b), 5.2 * std::sin(b)}}));
  }
  const Harmonized h = harmonize_stack(stack_of({fan, fan}), 0.1);
  check_all(h, true);
  const double pitch = h.contours.grid.pitch, longest = 0.5 / pitch;
  Outline outline = h.input.outlines[0];
  detail::subdivide(outline, longest);
  detail::normalize(outline);
  check_valid(outline);
  std::map<std::int32_t, int> degree;
  for (const Outline::Edge& e : outline.edges) {
    ++degree[e.a], ++degree[e.b];
    CHECK(detail::distance(outline.vertices[std::size_t(e.a)], outline.vertices[std::size_t(e.b)]) < 1.001 * longest);
  }
  const auto center =
      std::max_element(degree.begin(), degree.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  CHECK(center->second == 2 * kTriangles);
  std::map<long long, int> at;  // vertices per distance from the center, in nanometers
  for (const GridPoint& p : outline.vertices)
    ++at[std::llround(detail::distance(p, outline.vertices[std::size_t(center->first)]) * pitch * 1e6)];
  CHECK(at.size() > 5);
  for (const auto& [r, count] : at)
    if (r > 0) CHECK(count == 2 * kTriangles);
}

TEST_CASE("no split of a contour is so near to another edge that planes would take it to lie there") {
  constexpr std::int64_t kLong = std::int64_t{1} << 36, kWide = std::int64_t{1} << 12;
  constexpr double kLongest = double(kLong) / 10;
  Outline tip;  // narrower than that over a tenth of its length
  tip.vertices = {{0, 0}, {kLong, 0}, {kLong, kWide}};
  tip.edges = {{0, 1, 0, kNone}, {0, 2, kNone, 0}, {1, 2, 0, kNone}};
  Outline strip;  // narrower than that, with no vertex inside of an edge's strip
  strip.vertices = {{0, 0}, {0, 512}, {kLong, 0}, {kLong, 512}};
  strip.edges = {{0, 1, kNone, 0}, {0, 2, 0, kNone}, {1, 3, kNone, 0}, {2, 3, 0, kNone}};
  for (Outline outline : {tip, strip}) {
    const Outline before = outline;
    REQUIRE(detail::vertices_beside_edges(outline, detail::kBeside).empty());
    detail::subdivide(outline, kLongest);
    check_valid(outline);
    CHECK(detail::vertices_beside_edges(outline, kAttachSteps * double(kContourStep)).empty());
    // Splits are rounded, by a step at most.
    const detail::Int128 change = detail::doubled_area(outline, 0) - detail::doubled_area(before, 0);
    CHECK((change < 0 ? -change : change) <= detail::Int128(4) * kLong * kContourStep);
    if (before.edges.size() == 4)
      CHECK(outline == before);
    else
      CHECK(outline.edges.size() > 10);
  }
}

TEST_CASE("vertices in triangles and boxes are found, whatever the cells") {
  std::mt19937 random(20261123);
  const auto whole = [&](std::int64_t n) { return std::int64_t(random() % std::uint64_t(2 * n + 1)) - n; };
  std::size_t inside = 0;
  for (const std::int64_t extent : {std::int64_t{3}, std::int64_t{1000}, kGridLimit / 2})
    for (const double cell : {1.0, double(extent) / 7, 4 * double(extent)}) {
      std::vector<GridPoint> points;
      for (int i = 0; i < 300; ++i) points.push_back({whole(extent), whole(i % 2 == 0 ? extent : extent / 50)});
      const detail::VertexIndex index(points, cell);
      for (int k = 0; k < 300; ++k) {
        const GridPoint u = points[random() % 300], v = points[random() % 300], w = points[random() % 300];
        std::vector<char> seen(points.size(), 0), boxed(points.size(), 0);
        CHECK(!index.any_in_triangle({u, v, w}, [&](std::int32_t x) { return (seen[std::size_t(x)] = 1, false); }));
        const GridPoint low{std::min(u.x, v.x), std::min(u.y, v.y)}, high{std::max(u.x, v.x), std::max(u.y, v.y)};
        CHECK(!index.any_in_box(low, high, [&](std::int32_t x) { return (boxed[std::size_t(x)] = 1, false); }));
        const int turn = detail::orientation(u, v, w);
        for (std::size_t x = 0; x < points.size(); ++x) {
          const GridPoint& p = points[x];
          if (p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y) REQUIRE(boxed[x] == 1);
          if (turn == 0 || detail::orientation(u, v, p) * turn < 0 || detail::orientation(v, w, p) * turn < 0 ||
              detail::orientation(w, u, p) * turn < 0)
            continue;
          ++inside;
          REQUIRE(seen[x] == 1);
        }
      }
    }
  CHECK(inside > 10000);
}

TEST_CASE("the nearest segment and all that are near are found, from anywhere") {
  std::mt19937 random(20261124);
  const auto whole = [&](std::int64_t n) { return std::int64_t(random() % std::uint64_t(2 * n + 1)) - n; };
  std::size_t near = 0;
  for (const std::int64_t extent : {std::int64_t{3}, std::int64_t{1000}, kGridLimit / 4})
    for (const std::int64_t longest : {extent / 50 + 1, extent}) {
      std::vector<std::pair<GridPoint, GridPoint>> segments;
      for (int i = 0; i < 200; ++i) {
        const GridPoint a{whole(extent), whole(i % 2 == 0 ? extent : extent / 50)};
        segments.push_back({a, {a.x + whole(longest), a.y + whole(longest)}});
      }
      const detail::SegmentIndex index(segments);
      for (int k = 0; k < 200; ++k) {
        const GridPoint p{whole(2 * extent), whole(2 * extent)}, q{p.x + whole(longest), p.y + whole(longest)};
        double least = HUGE_VAL;
        for (std::size_t i = 0; i < segments.size(); ++i) least = std::min(least, index.distance_to(i, p));
        const detail::SegmentIndex::Nearest found = index.nearest(p);
        CHECK(found.distance == least);
        REQUIRE(found.segment >= 0);
        CHECK(index.distance_to(std::size_t(found.segment), p) == least);
        CHECK(index.nearest(p, least).segment == -1);
        const std::int64_t pad = extent / 20;
        std::vector<char> seen(segments.size(), 0);
        CHECK(!index.any_near(p, q, pad, [&](std::size_t i) { return (seen[i] = 1, false); }));
        for (std::size_t i = 0; i < segments.size(); ++i) {
          const auto& [a, b] = segments[i];
          const double d = std::min({index.distance_to(i, p), index.distance_to(i, q),
                                     detail::segment_distance(a, p, q), detail::segment_distance(b, p, q)});
          if (d >= double(pad) && !detail::segments_meet(a, b, p, q)) continue;
          ++near;
          REQUIRE(seen[i] == 1);
        }
      }
    }
  CHECK(near > 1000);
}

TEST_CASE("a tolerance that is no length is refused") {
  const SliceStack stack = stack_of({{rectangle(0, 0, 1, 1)}, {rectangle(0, 0, 1, 1)}});
  CHECK_THROWS_AS(harmonize_stack(stack, -1), OptionError);
  CHECK_THROWS_AS(harmonize_stack(stack, std::nan("")), OptionError);
}

TEST_CASE("the contours of the slice files are within eps and valid", "[corpus]") {
  std::size_t seen = 0;
  const auto files = small_corpus_files();
  for (const auto& path : files) {
    INFO(path.filename().string());
    const Harmonized h = harmonize_stack(read_cli(path.string()), 0.1);
    check_all(h, false);
    seen += h.contours.outlines.size();
  }
  if (!files.empty()) CHECK(seen > 50);
}

TEST_CASE("contours that cross at a small angle are split where they are cut only, in exact mode") {
  for (const double angle : {1e-3, 1e-4, 1e-5}) {
    SliceStack stack;
    for (int l = 0; l < 2; ++l) {
      const double c = 10 * std::cos(angle * l), s = 10 * std::sin(angle * l);
      Polyline square;
      square.points = {{c, s}, {-s, c}, {-c, -s}, {s, -c}};
      stack.layers.emplace_back();
      stack.layers.back().z = l + 1;
      stack.layers.back().polylines.push_back(square);
    }
    Diagnostics diagnostics;
    const LayerRegions input = build_regions(stack, make_slabs(stack, {}, diagnostics), {}, diagnostics);
    HarmonizeOptions options;
    options.eps = 0;
    // Progress is called by the work done. One piece for each width of a band would be thousands of calls.
    int calls = 0;
    const Contours contours = harmonize(input, options, diagnostics, [&](Stage, double) {
      ++calls;
      return true;
    });
    INFO("angle " << angle << ", " << calls << " calls");
    CHECK(calls < 60);
    // The bands are wide enough to be kept: the contours still differ.
    CHECK(contours.outlines[0].edges.size() == 4);
    CHECK(contours.outlines[1].edges.size() > 4);
  }
}

TEST_CASE("contours of round slices are led together, or stay nearly two eps apart") {
  // Steps of 1.05 to 1.95 eps: two slabs at a time can have one contour, and three or four eps are left to the next.
  std::size_t seen = 0, near = 0;
  for (int step = 21; step <= 39; step += 2) {
    const double eps = 0.05;
    std::vector<std::vector<Polyline>> slices;
    for (int k = 0; k < 6; ++k) slices.push_back({star(10, 10, 6 + step * eps / 20 * k, 96, 0, 0.3 * k)});
    const Chain chain = run_chain(stack_of(slices));
    const double tolerance = chain.contours.tolerance / chain.contours.grid.pitch;
    for (std::size_t s = 1; s < slices.size(); ++s)
      for (const GridPoint& p : chain.contours.outlines[s].vertices) {
        const Outline& below = chain.contours.outlines[s - 1];
        double gap = HUGE_VAL;
        for (const Outline::Edge& e : below.edges)
          gap = std::min(
              gap, detail::segment_distance(p, below.vertices[std::size_t(e.a)], below.vertices[std::size_t(e.b)]));
        if (gap < 0.1 * tolerance) continue;  // the same contour
        ++seen;
        near += gap < 1.75 * tolerance;
      }
  }
  CAPTURE(seen, near);
  CHECK(seen > 1000);
  CHECK(near < seen / 20);
}

TEST_CASE("vertices of straight walls that cross go apart along the walls, which stay straight") {
  // The walls y = 1 and x = 8 (or x = 3) cross on a plane, and a vertex of the second stands half of what is wanted
  // away from the first.
  const std::vector<std::vector<Polyline>> pairs{{rectangle(3, 1, 11, 10), rectangle(0, 0, 8, 6)},
                                                 {rectangle(0, 1, 6, 7), rectangle(3, 0, 11, 6)},
                                                 {rectangle(1, 0, 8, 9), rectangle(0, 1, 7, 8)}};
  std::size_t seen = 0, apart = 0;
  for (const auto& pair : pairs) {
    const Chain chain = run_chain(stack_of({{pair[0]}, {pair[1]}}));
    const double step = 4 * double(kContourStep) * chain.contours.grid.pitch;
    for (std::size_t s = 0; s < 2; ++s) {
      const Point2 &low = pair[s].points[0], &high = pair[s].points[2];
      for (const GridPoint& p : chain.contours.outlines[s].vertices) {
        const double x = chain.contours.grid.x_mm(p), y = chain.contours.grid.y_mm(p);
        CAPTURE(s, x, y);
        CHECK(std::min({std::fabs(x - low.x), std::fabs(x - high.x), std::fabs(y - low.y), std::fabs(y - high.y)}) <=
              step);
        ++seen;
        const Point2 &other_low = pair[1 - s].points[0], &other_high = pair[1 - s].points[2];
        const double gap = std::min({std::fabs(x - other_low.x), std::fabs(x - other_high.x),
                                     std::fabs(y - other_low.y), std::fabs(y - other_high.y)});
        if (gap > step && gap < 0.1) ++apart;
      }
      CHECK(chain.contours.deviation[s] < 0.01 * chain.contours.tolerance);  // the resolution of its measure
    }
  }
  CHECK(seen > 300);
  CHECK(apart > 0);  // or nothing would have had to move
}
