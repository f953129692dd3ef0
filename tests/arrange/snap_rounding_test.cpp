// SPDX-License-Identifier: MIT
#include "slice2mesh/arrange/snap_rounding.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "test_support.hpp"

using namespace slice2mesh;

namespace {

constexpr std::int64_t kUnit = kContourStep;

/// Closed loops of random corners within +-range steps; small ranges make many ties. Tags are the loops.
std::vector<TaggedSegment> random_loops(std::mt19937& random, int loops, std::int64_t range) {
  const auto number = [&] { return (std::int64_t(random() % std::uint64_t(2 * range + 1)) - range) * kUnit; };
  std::vector<TaggedSegment> segments;
  for (int l = 0; l < loops; ++l) {
    std::vector<GridPoint> p(3 + random() % 5);
    for (GridPoint& q : p) q = {number(), number()};
    for (std::size_t i = 0; i < p.size(); ++i) segments.push_back({p[i], p[(i + 1) % p.size()], l});
  }
  return segments;
}

/// No two edges meet but in common vertices; vertices are different and sorted; all are on the contour grid.
void check_planar(const Arrangement& a) {
  REQUIRE(std::is_sorted(a.vertices.begin(), a.vertices.end()));
  REQUIRE(std::adjacent_find(a.vertices.begin(), a.vertices.end()) == a.vertices.end());
  for (const GridPoint& p : a.vertices) REQUIRE((p.x % kUnit == 0 && p.y % kUnit == 0));
  std::size_t meetings = 0;
  for (std::size_t i = 0; i < a.edges.size(); ++i) {
    const GridPoint &p = a.vertices[std::size_t(a.edges[i].a)], &q = a.vertices[std::size_t(a.edges[i].b)];
    REQUIRE(p < q);
    for (std::size_t j = i + 1; j < a.edges.size(); ++j) {
      const GridPoint &r = a.vertices[std::size_t(a.edges[j].a)], &s = a.vertices[std::size_t(a.edges[j].b)];
      if (q.x < r.x || s.x < p.x) continue;
      const int o1 = detail::orientation(p, q, r), o2 = detail::orientation(p, q, s);
      const int o3 = detail::orientation(r, s, p), o4 = detail::orientation(r, s, q);
      const bool cross = o1 * o2 < 0 && o3 * o4 < 0;
      const bool on = (o1 == 0 && p < r && r < q) || (o2 == 0 && p < s && s < q) || (o3 == 0 && r < p && p < s) ||
                      (o4 == 0 && r < q && q < s);
      meetings += cross || on || (p == r && q == s) ? 1U : 0U;
    }
  }
  REQUIRE(meetings == 0);
}

/// Twice the area that a tag's pieces wind around.
std::map<std::int32_t, detail::Int128> areas(const Arrangement& a) {
  std::map<std::int32_t, detail::Int128> result;
  for (const Arrangement::Edge& e : a.edges) {
    const GridPoint &p = a.vertices[std::size_t(e.a)], &q = a.vertices[std::size_t(e.b)];
    for (auto t = e.first_tag; t < e.last_tag; ++t)
      result[a.tags[std::size_t(t)].tag] +=
          a.tags[std::size_t(t)].winding * (detail::Int128(p.x) * q.y - detail::Int128(p.y) * q.x);
  }
  return result;
}

struct Flat {
  GridPoint a, b;
  std::int32_t tag, winding;
  bool operator==(const Flat& o) const { return a == o.a && b == o.b && tag == o.tag && winding == o.winding; }
};
std::vector<Flat> flat(const Arrangement& a) {
  std::vector<Flat> result;
  for (const Arrangement::Edge& e : a.edges)
    for (auto t = e.first_tag; t < e.last_tag; ++t)
      result.push_back({a.vertices[std::size_t(e.a)], a.vertices[std::size_t(e.b)], a.tags[std::size_t(t)].tag,
                        a.tags[std::size_t(t)].winding});
  return result;
}

}  // namespace

TEST_CASE("snap rounding leaves no crossing, keeps the winding areas up to rounding, and balances every vertex") {
  std::size_t crossings = 0;
  for (std::uint32_t seed = 1; seed <= 60; ++seed) {
    INFO("seed " << seed);
    std::mt19937 random(seed);
    const std::int64_t range = std::vector<std::int64_t>{4, 10, 60, 5000, std::int64_t(1) << 26}[seed % 5];
    const std::vector<TaggedSegment> segments = random_loops(random, 3 + int(seed % 5), range);
    const Arrangement a = snap_round(segments);
    crossings += a.crossings;
    check_planar(a);
    // Closed loops stay closed.
    std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> balance;
    for (const Arrangement::Edge& e : a.edges)
      for (auto t = e.first_tag; t < e.last_tag; ++t) {
        balance[{e.a, a.tags[std::size_t(t)].tag}] += a.tags[std::size_t(t)].winding;
        balance[{e.b, a.tags[std::size_t(t)].tag}] -= a.tags[std::size_t(t)].winding;
      }
    for (const auto& [key, sum] : balance) REQUIRE(sum == 0);
    // No point moves by more than half a step in x and in y: the area changes by less than a step times the length.
    std::map<std::int32_t, detail::Int128> before;
    std::map<std::int32_t, double> length;
    for (const TaggedSegment& s : segments) {
      before[s.tag] += detail::Int128(s.from.x) * s.to.y - detail::Int128(s.from.y) * s.to.x;
      length[s.tag] += detail::distance(s.from, s.to);
    }
    const auto after = areas(a);
    for (const auto& [tag, area] : before) {
      const auto found = after.find(tag);
      const detail::Int128 got = found == after.end() ? detail::Int128(0) : found->second;
      REQUIRE(std::fabs(double(got - area)) <= 2 * double(kUnit) * (length[tag] + 8 * double(kUnit)));
    }
  }
  CHECK(crossings > 500);
}

TEST_CASE("segments without length give an empty arrangement, in which each has an empty path") {
  for (const std::size_t count : {0U, 1U, 3U}) {
    const std::vector<TaggedSegment> points(count, TaggedSegment{{5, 7}, {5, 7}, 0});
    const Arrangement arrangement = snap_round(points);
    CHECK(arrangement.vertices.empty());
    CHECK(arrangement.edges.empty());
    REQUIRE(arrangement.segment_chain.size() == count);
    for (std::size_t s = 0; s < count; ++s) CHECK(arrangement.path(s).empty());
  }
}

TEST_CASE("snap rounding leads every segment along edges, through cells that it meets") {
  for (std::uint32_t seed = 100; seed < 130; ++seed) {
    INFO("seed " << seed);
    std::mt19937 random(seed);
    const std::vector<TaggedSegment> segments = random_loops(random, 5, seed % 2 == 0 ? 12 : 100000);
    const Arrangement a = snap_round(segments);
    std::set<std::pair<std::int32_t, std::int32_t>> edges;
    for (const Arrangement::Edge& e : a.edges) edges.insert({e.a, e.b});
    for (std::size_t s = 0; s < segments.size(); ++s) {
      const std::vector<std::int32_t> path = a.path(s);
      if (segments[s].from == segments[s].to) {
        REQUIRE(path.empty());
        continue;
      }
      REQUIRE(path.size() >= 2);
      REQUIRE(a.vertices[std::size_t(path.front())] == segments[s].from);
      REQUIRE(a.vertices[std::size_t(path.back())] == segments[s].to);
      for (std::size_t i = 0; i < path.size(); ++i) {
        if (i > 0) REQUIRE(edges.count(std::minmax(path[i - 1], path[i])) == 1);
        // Half a diagonal of a cell, and the rounding of the distance itself.
        REQUIRE(detail::segment_distance(a.vertices[std::size_t(path[i])], segments[s].from, segments[s].to) <=
                0.7072 * double(kUnit));
      }
    }
  }
}

TEST_CASE("snap rounding does not depend on the order and direction of its input") {
  for (std::uint32_t seed = 200; seed < 220; ++seed) {
    INFO("seed " << seed);
    std::mt19937 random(seed);
    std::vector<TaggedSegment> segments = random_loops(random, 5, 20);
    const auto expected = flat(snap_round(segments));
    std::shuffle(segments.begin(), segments.end(), random);
    CHECK(flat(snap_round(segments)) == expected);
    for (TaggedSegment& s : segments) std::swap(s.from, s.to);
    auto reversed = flat(snap_round(segments));
    for (Flat& f : reversed) f.winding = -f.winding;
    CHECK(reversed == expected);
  }
}

TEST_CASE("snap rounding commutes with translations by steps, and with quarter turns but for ties") {
  for (std::uint32_t seed = 300; seed < 320; ++seed) {
    INFO("seed " << seed);
    std::mt19937 random(seed);
    const std::vector<TaggedSegment> segments = random_loops(random, 5, 1000);
    const Arrangement a = snap_round(segments);
    std::vector<TaggedSegment> moved = segments, turned = segments;
    const GridPoint by{12345 * kUnit, -54321 * kUnit};
    for (TaggedSegment& s : moved)
      for (GridPoint* p : {&s.from, &s.to}) *p = {p->x + by.x, p->y + by.y};
    for (TaggedSegment& s : turned)
      for (GridPoint* p : {&s.from, &s.to}) *p = {-p->y, p->x};
    auto back = flat(snap_round(moved));
    for (Flat& f : back)
      for (GridPoint* p : {&f.a, &f.b}) *p = {p->x - by.x, p->y - by.y};
    CHECK(back == flat(a));
    const Arrangement t = snap_round(turned);
    check_planar(t);
    CHECK(t.crossings == a.crossings);
    // Cells are half-open: a crossing just on a border may go to the other side. That is rare.
    std::size_t same = 0;
    for (const GridPoint& p : a.vertices)
      same += std::binary_search(t.vertices.begin(), t.vertices.end(), GridPoint{-p.y, p.x}) ? 1U : 0U;
    CHECK(double(same) >= 0.9 * double(a.vertices.size()));
  }
}

TEST_CASE("nearly horizontal and nearly vertical segments find all that they cross") {
  const std::int64_t width = std::int64_t(1) << 26;
  for (const bool upright : {false, true})
    for (std::int64_t place = -30; place <= 30; ++place) {
      const std::int64_t y = place * (width / 32);
      std::vector<TaggedSegment> segments{{{-width, y - 1}, {width, y}, 0}};
      for (std::int64_t i = 0; i < 64; ++i) {
        const std::int64_t x = -width + (2 * i + 1) * (width / 64);
        segments.push_back({{x, -width}, {x, width}, 1});
      }
      for (TaggedSegment& s : segments)
        for (GridPoint* p : {&s.from, &s.to}) {
          *p = {p->x * kUnit, p->y * kUnit};
          if (upright) std::swap(p->x, p->y);
        }
      const Arrangement a = snap_round(segments);
      REQUIRE(a.crossings == 64);
      REQUIRE(a.path(0).size() == 66);
    }
}

TEST_CASE("an index over the full range of coordinates visits every cell of a nearly horizontal segment") {
  const std::int64_t width = kGridLimit / 2;
  const detail::Buckets buckets({-width, -width}, {width, width}, 1000);
  for (std::int64_t row = 1; row < 30; ++row) {
    const std::int64_t y = -width + row * buckets.cell();
    std::set<std::size_t> cells;
    buckets.for_each_on({-width, y - 1}, {width, y}, 0, [&](std::size_t cell) { cells.insert(cell); });
    for (std::int64_t x = -width; x < width; x += buckets.cell() / 2) {
      // The line is between y - 1 and y: in the row below but at its end.
      REQUIRE(cells.count(buckets.of({x, y - 1})) == 1);
    }
    REQUIRE(cells.count(buckets.of({width, y})) == 1);
  }
}

TEST_CASE("a segment that the others have too is not led through their points near by, one beside it is") {
  // A fan of spokes, each of three pieces: the points of neighboring spokes are near each other.
  constexpr int kSpokes = 30, kPieces = 3;
  std::vector<TaggedSegment> segments;
  Attachment attachment;
  attachment.near = kAttachSteps * double(kContourStep);
  attachment.strong_tags = 1;
  attachment.strong_near = 3e4 * double(kUnit);
  std::size_t with_same = 0, with_beside = 0;
  for (const bool same : {true, false}) {
    segments.clear();
    attachment.strong.clear();
    for (int i = 0; i < kSpokes; ++i)
      for (std::int32_t tag = 0; tag < 2; ++tag) {
        // Those beside are turned by half a step of the fan and end nearer to the center.
        const double angle = 0.01 * (i + (same || tag == 1 ? 0 : 0.5)), length = same || tag == 1 ? 1e6 : 0.9e6;
        GridPoint last{};
        for (int k = 1; k <= kPieces; ++k) {
          const double r = length * k / kPieces;
          const GridPoint next{std::llround(r * std::cos(angle)) * kUnit, std::llround(r * std::sin(angle)) * kUnit};
          segments.push_back({last, next, tag});
          if (tag == 1) attachment.strong.push_back(next);
          last = next;
        }
      }
    const Arrangement arrangement = snap_round(segments, attachment);
    check_planar(arrangement);
    (same ? with_same : with_beside) = arrangement.edges.size();
    if (same) CHECK(arrangement.crossings == 0);
  }
  constexpr std::size_t kAll = std::size_t(kSpokes) * kPieces;
  CHECK(with_same == kAll);
  CHECK(with_beside > 2 * kAll);
}

TEST_CASE("snap rounding asks whether to go on, the more often the more there is to do, and ends when told to") {
  struct Stop {};
  std::mt19937 random(5);
  const std::vector<TaggedSegment> segments = random_loops(random, 150, 1 << 20);
  std::size_t calls = 0, stop = std::size_t(-1);
  const std::function<void()> poll = [&] {
    if (calls++ == stop) throw Stop();
  };
  Attachment attachment;
  attachment.near = kAttachSteps * double(kContourStep);
  const Arrangement all = snap_round(segments, attachment, poll);
  CHECK(all.vertices == snap_round(segments, attachment).vertices);
  REQUIRE(all.crossings > 10000);
  REQUIRE(calls >= 3);
  const std::size_t most = calls;
  for (stop = 0; stop < most; ++stop) {
    calls = 0;
    CHECK_THROWS_AS(snap_round(segments, attachment, poll), Stop);
    CHECK(calls == stop + 1);
  }
}
