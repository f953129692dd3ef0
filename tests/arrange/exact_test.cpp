// SPDX-License-Identifier: MIT
#include "slice2mesh/arrange/exact.hpp"

#include <boost/multiprecision/cpp_int.hpp>
#include <random>
#include <vector>

#include "test_support.hpp"

using namespace slice2mesh;
using boost::multiprecision::cpp_int;

namespace {

/// Points that make near ties: anywhere, on a line, on a circle (Pythagorean turns), at the limits, some pitches apart.
class PointSource {
public:
  explicit PointSource(std::uint32_t seed) : random_(seed) {}
  std::int64_t number(std::int64_t limit) {
    return static_cast<std::int64_t>(random_() % static_cast<std::uint64_t>(2 * limit + 1)) - limit;
  }
  std::vector<GridPoint> points(std::size_t count) {
    std::vector<GridPoint> result;
    const auto kind = random_() % 5;
    const GridPoint base{number(kGridLimit / 4), number(kGridLimit / 4)};
    const GridPoint step{number(1 << 20), number(1 << 20)};
    static const std::int64_t turns[][2] = {{3, 4},  {4, 3},  {5, 0},   {0, 5}, {-3, 4},
                                            {4, -3}, {-5, 0}, {-4, -3}, {3, -4}};
    const std::int64_t scale = std::int64_t(1) << (random_() % 34);
    for (std::size_t i = 0; i < count; ++i) {
      GridPoint p;
      if (kind == 0) p = {number(kGridLimit), number(kGridLimit)};
      if (kind == 1) p = {number(3), number(3)};
      if (kind == 2) {
        const std::int64_t t = number(1000);
        p = {base.x + t * step.x + number(1), base.y + t * step.y + number(1)};
      }
      if (kind == 3) {
        const auto& turn = turns[random_() % 9];
        p = {base.x / 2 + turn[0] * scale / 8 * 1, base.y / 2 + turn[1] * scale / 8};
        if (random_() % 3 == 0) p.x += number(1);
      }
      if (kind == 4) p = {number(1) * kGridLimit, number(1) * kGridLimit};
      result.push_back(p);
    }
    return result;
  }

private:
  std::mt19937_64 random_;
};

int sign_of(const cpp_int& v) {
  return v > 0 ? 1 : (v < 0 ? -1 : 0);
}
cpp_int cross_of(const GridPoint& a, const GridPoint& b, const GridPoint& c) {
  return (cpp_int(b.x) - a.x) * (cpp_int(c.y) - a.y) - (cpp_int(b.y) - a.y) * (cpp_int(c.x) - a.x);
}
cpp_int squared(const cpp_int& x, const cpp_int& y) {
  return x * x + y * y;
}

int circumcenter_of(const std::vector<GridPoint>& t) {
  // c = t0 + n / (2 d): |c-p|^2 - |c-q|^2 times 4 d^2, in numbers of any size.
  const cpp_int bx = cpp_int(t[1].x) - t[0].x, by = cpp_int(t[1].y) - t[0].y;
  const cpp_int cx = cpp_int(t[2].x) - t[0].x, cy = cpp_int(t[2].y) - t[0].y;
  const cpp_int d2 = 2 * (bx * cy - by * cx);
  const cpp_int nx = cy * squared(bx, by) - by * squared(cx, cy), ny = bx * squared(cx, cy) - cx * squared(bx, by);
  const auto far = [&](const GridPoint& p) {
    return squared(nx - d2 * (cpp_int(p.x) - t[0].x), ny - d2 * (cpp_int(p.y) - t[0].y));
  };
  return sign_of(far(t[3]) - far(t[4]));
}

}  // namespace

TEST_CASE("exact predicates agree with numbers of any size, ties included") {
  const std::uint32_t seed = 20240611;
  INFO("seed " << seed);
  PointSource source(seed);
  int ties = 0, circles = 0, tested = 0, nearer = 0;
  for (int i = 0; i < 40000; ++i) {
    std::vector<GridPoint> p = source.points(5);
    const int turn = sign_of(cross_of(p[0], p[1], p[2]));
    REQUIRE(detail::orientation(p[0], p[1], p[2]) == turn);
    const cpp_int dot = (cpp_int(p[1].x) - p[0].x) * (cpp_int(p[2].x) - p[0].x) +
                        (cpp_int(p[1].y) - p[0].y) * (cpp_int(p[2].y) - p[0].y);
    REQUIRE(detail::sign(detail::dot(p[0], p[1], p[2])) == sign_of(dot));
    REQUIRE(detail::in_diametral_disc(p[1], p[2], p[0]) == (dot <= 0));
    const auto far = [&](const GridPoint& q) {  // from the middle of p0 p1, times 4
      return squared(2 * cpp_int(q.x) - p[0].x - p[1].x, 2 * cpp_int(q.y) - p[0].y - p[1].y);
    };
    REQUIRE(detail::nearer_to_midpoint(p[0], p[1], p[3], p[4]) == sign_of(far(p[3]) - far(p[4])));
    ties += turn == 0 ? 1 : 0;
    if (turn == 0) continue;
    if (turn < 0) std::swap(p[1], p[2]);
    const int expected = circumcenter_of(p);
    REQUIRE(detail::nearer_to_circumcenter(p[0], p[1], p[2], p[3], p[4]) == expected);
    REQUIRE(detail::nearer_to_circumcenter(p[0], p[1], p[2], p[4], p[3]) == -expected);
    REQUIRE(detail::nearer_to_circumcenter(p[0], p[1], p[2], p[0], p[2]) == 0);
    ++tested;
    circles += expected == 0 && p[3] != p[4] ? 1 : 0;
    nearer += expected > 0 ? 1 : 0;
  }
  CHECK(ties > 100);
  CHECK(circles > 100);
  CHECK(nearer > tested / 10);
}

TEST_CASE("numbers of 192 bits multiply, shift and add like numbers of any size") {
  const std::uint32_t seed = 7;
  INFO("seed " << seed);
  std::mt19937_64 random(seed);
  const auto wide = [](const detail::Int192& v) {
    const auto high = static_cast<std::int64_t>(v.high >> 64);
    return ((cpp_int(high) << 64) + static_cast<std::uint64_t>(v.high)) * (cpp_int(1) << 64) + v.low;
  };
  const auto big = [](detail::Int128 v) {
    return (cpp_int(static_cast<std::int64_t>(v >> 64)) << 64) + static_cast<std::uint64_t>(v);
  };
  // A negative number must not be shifted to the left.
  const auto wide_number = [&] {
    const auto high = static_cast<std::int64_t>(random());
    return detail::Int128(high) * (detail::Int128(1) << 64) + random();
  };
  for (int i = 0; i < 20000; ++i) {
    const detail::Int128 a = wide_number() >> (2 + random() % 100);
    const std::int64_t b = static_cast<std::int64_t>(random()) >> (2 + random() % 40);
    const detail::Int192 p = detail::multiply(a, b);
    REQUIRE(wide(p) == big(a) * b);
    const detail::Int128 c = wide_number() >> (40 + random() % 60);
    const detail::Int192 q = detail::multiply(c, b);
    REQUIRE(wide(detail::add(p, q)) == (big(a) + big(c)) * b);
    REQUIRE((p < q) == (wide(p) < wide(q)));
    const detail::Int192 small = detail::multiply(c >> 24, b);
    REQUIRE(wide(detail::shift_left(small, 40)) == wide(small) * (cpp_int(1) << 40));
  }
}
