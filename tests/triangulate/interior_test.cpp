// SPDX-License-Identifier: MIT
#include "slice2mesh/triangulate/interior.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <set>
#include <vector>

#include "plc/chain.hpp"
#include "slice2mesh/triangulate/graded_sizes.hpp"
#include "test_support.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;

namespace {

const std::function<void()> kNobody;

/// The distance to the nearest of some points that is another one.
double nearest(const GridPoint& p, const std::vector<GridPoint>& points) {
  double result = HUGE_VAL;
  for (const GridPoint& q : points)
    if (q != p) result = std::min(result, detail::distance(p, q));
  return result;
}

}  // namespace

TEST_CASE("graded sizes are the smallest size of a source plus a share of the distance from it") {
  std::size_t below = 0, above = 0, in_squares = 0;
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    std::uniform_int_distribution<std::int64_t> place(-200000, 200000);
    std::uniform_real_distribution<double> size(1, 30000);
    std::vector<detail::SizeSource> sources;
    for (int i = 0; i < 40; ++i) sources.push_back({{place(random), place(random)}, size(random)});
    std::sort(sources.begin(), sources.end());
    const double limit = 20000, growth = seed % 2 == 0 ? 0.5 : 0.25 * (1 + seed % 8);
    detail::Poll listen(kNobody, 1);
    const detail::GradedSizes graded(sources, limit, 1, growth, listen);
    const std::vector<GridPoint> squares = graded.squares(listen);
    REQUIRE(std::set<GridPoint>(squares.begin(), squares.end()).size() == squares.size());
    for (int i = 0; i < 2000; ++i) {
      const GridPoint p{place(random), place(random)};
      double least = HUGE_VAL;
      for (const detail::SizeSource& source : sources)
        least = std::min(least, source.size + growth * detail::distance(source.at, p));
      REQUIRE(graded.is_below(p) == (least < limit));
      ++(least < limit ? below : above);
      if (least >= limit) continue;
      const GridPoint square{std::int64_t(std::floor(double(p.x) / graded.side())),
                             std::int64_t(std::floor(double(p.y) / graded.side()))};
      REQUIRE(std::binary_search(squares.begin(), squares.end(), square));
      ++in_squares;
    }
  }
  CHECK(below > 1000);
  CHECK(above > 1000);
  CHECK(in_squares == below);
}

TEST_CASE("of sources that are near to each other the smallest counts") {
  detail::Poll listen(kNobody, 1);
  const std::vector<detail::SizeSource> sources{{{0, 0}, 10}, {{50, 0}, 20}, {{1000, 0}, 30}};
  const detail::GradedSizes all(sources, 100, 1, 0.5, listen), few(sources, 100, 60, 0.5, listen);
  const GridPoint p{200, 0};  // 20 + 75 from the second, 10 + 100 from the first
  CHECK(all.is_below(p));
  CHECK_FALSE(few.is_below(p));
  CHECK(few.is_below({150, 0}));
  CHECK(few.is_below({1130, 0}));
}

TEST_CASE("sources are the shortest edges at contour vertices, and the widths of bands between contours") {
  Chain chain = run_chain(stack_of({{rectangle(0, 0, 10, 8)}, {rectangle(0, 0, 10.2, 8)}}), {});
  const Contours& contours = chain.contours;
  std::vector<const Outline*> outlines{&contours.outlines[0], &contours.outlines[1]};
  detail::Poll listen(kNobody, 1);
  const double pitch = contours.grid.pitch;
  std::size_t in_band = 0, edges = 0;
  for (const double narrow : {0.1, 0.3}) {  // mm; the band is 0.2 wide
    const auto sources = detail::size_sources(outlines, narrow / pitch, listen);
    // One by one: edges of its own contour, distances to all edges of the other one.
    std::vector<detail::SizeSource> expected;
    for (std::size_t i = 0; i < 2; ++i)
      for (const GridPoint& p : outlines[i]->vertices) {
        double size = HUGE_VAL, width = HUGE_VAL;
        for (const Outline::Edge& e : outlines[i]->edges) {
          const GridPoint &a = outlines[i]->vertices[std::size_t(e.a)], &b = outlines[i]->vertices[std::size_t(e.b)];
          if (a == p || b == p) size = std::min(size, detail::distance(a, b));
        }
        for (const auto& [a, b] : detail::SegmentIndex::segments_of(*outlines[1 - i]))
          width = std::min(width, detail::segment_distance(p, a, b));
        const bool beside = width * pitch < narrow && width > kAttachSteps * double(kContourStep);
        ++(beside && width < size ? in_band : edges);
        expected.push_back({p, beside ? std::min(size, width) : size});
      }
    std::sort(expected.begin(), expected.end());
    REQUIRE(sources.size() == expected.size());
    for (std::size_t k = 0; k < sources.size(); ++k) {
      REQUIRE(sources[k].at == expected[k].at);
      REQUIRE(sources[k].size == Approx(expected[k].size));
    }
  }
  CHECK(in_band > 10);
  CHECK(edges > 100);
}

TEST_CASE("the lattice has half the spacing along contours only, keeps away from them, and is the same in all planes") {
  ChainOptions options;
  const std::vector<Polyline> slice{rectangle(0, 0, 20, 16)};
  const Chain chain = run_chain(stack_of({slice, slice, slice}), options);
  const Contours& contours = chain.contours;
  const double h = contours.thickness / contours.grid.pitch, l = 2 * h;
  const InteriorSizes sizes{l, h};
  const std::vector<GridPoint> points = interior_points(contours, 0, 1, sizes);
  CHECK(points == interior_points(contours, 1, 2, sizes));
  REQUIRE(std::set<GridPoint>(points.begin(), points.end()).size() == points.size());

  const detail::SegmentIndex index(contours.outlines[0]);
  double shortest = HUGE_VAL;
  for (const auto& [a, b] : detail::SegmentIndex::segments_of(contours.outlines[0]))
    shortest = std::min(shortest, detail::distance(a, b));
  std::size_t coarse = 0, fine = 0;
  for (const GridPoint& p : points) {
    const double from_contour = index.distance(p, 100 * l);
    REQUIRE(from_contour >= 0.7 * l / 2);
    const double apart = nearest(p, points);
    // Sizes grow by half of the distance, from the shortest edge to 0.8 l; the finer lattice goes no farther than that.
    if (from_contour > 2 * l) {
      REQUIRE(apart > 0.99 * l);
      ++coarse;
    }
    if (apart < 0.51 * l) {
      REQUIRE(from_contour < 2 * (0.8 * l - shortest) + l / 2);
      ++fine;
    }
  }
  CHECK(coarse > 100);
  CHECK(fine > 50);
  // Where l is no more than one and a half thicknesses, nothing finer is used.
  const std::vector<GridPoint> small = interior_points(contours, 0, 1, {1.4 * h, h});
  REQUIRE(small.size() > points.size());
  for (const GridPoint& p : small) REQUIRE(nearest(p, small) > 1.39 * h);
}
