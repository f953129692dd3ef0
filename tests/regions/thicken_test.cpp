// SPDX-License-Identifier: MIT
#include "slice2mesh/regions/thicken.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "test_support.hpp"

using namespace slice2mesh;

namespace {

using Polygon = std::vector<Point2>;

constexpr double kPi = 3.14159265358979323846;

double orient(const Point2& a, const Point2& b, const Point2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

double area(const Polygon& p) {
  double sum = 0;
  for (std::size_t i = 1; i + 1 < p.size(); ++i) sum += orient(p[0], p[i], p[i + 1]);
  return sum / 2;
}

bool cross(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  return orient(a, b, c) * orient(a, b, d) < 0 && orient(c, d, a) * orient(c, d, b) < 0;
}

bool simple(const Polygon& p) {
  const std::size_t n = p.size();
  if (n < 3) return false;
  for (std::size_t i = 0; i < n; ++i) {
    if (p[i] == p[(i + 1) % n]) return false;
    for (std::size_t j = i + 1; j < n; ++j)
      if (cross(p[i], p[(i + 1) % n], p[j], p[(j + 1) % n])) return false;
  }
  return true;
}

bool inside(const Polygon& p, const Point2& q) {
  bool in = false;
  for (std::size_t i = 0, j = p.size() - 1; i < p.size(); j = i++)
    if ((p[i].y > q.y) != (p[j].y > q.y) && q.x < p[i].x + (q.y - p[i].y) / (p[j].y - p[i].y) * (p[j].x - p[i].x))
      in = !in;
  return in;
}

/// Points of the edges of a at which y has to be cut so that the union is a sum of trapezoids.
void cuts(const std::vector<Polygon>& pieces, std::vector<double>& ys) {
  struct Edge {
    Point2 a, b;
  };
  std::vector<Edge> edges;
  for (const Polygon& p : pieces)
    for (std::size_t i = 0; i < p.size(); ++i) {
      edges.push_back({p[i], p[(i + 1) % p.size()]});
      ys.push_back(p[i].y);
    }
  for (std::size_t i = 0; i < edges.size(); ++i)
    for (std::size_t j = i + 1; j < edges.size(); ++j) {
      const Edge& e = edges[i];
      const Edge& f = edges[j];
      if (!cross(e.a, e.b, f.a, f.b)) continue;
      const double s = orient(f.a, f.b, e.a);
      const double t = orient(f.a, f.b, e.b);
      ys.push_back(e.a.y + s / (s - t) * (e.b.y - e.a.y));
    }
  std::sort(ys.begin(), ys.end());
}

/// Area of the union: between two neighboring cuts the width is linear in y, so that its value in the middle is exact.
double union_area(const std::vector<Polygon>& pieces) {
  std::vector<double> ys;
  cuts(pieces, ys);
  double total = 0;
  for (std::size_t k = 0; k + 1 < ys.size(); ++k) {
    const double y = (ys[k] + ys[k + 1]) / 2;
    if (!(ys[k + 1] > ys[k])) continue;
    std::vector<std::pair<double, double>> spans;
    for (const Polygon& p : pieces) {
      std::vector<double> xs;
      for (std::size_t i = 0; i < p.size(); ++i) {
        const Point2& a = p[i];
        const Point2& b = p[(i + 1) % p.size()];
        if ((a.y > y) != (b.y > y)) xs.push_back(a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x));
      }
      std::sort(xs.begin(), xs.end());
      for (std::size_t i = 0; i + 1 < xs.size(); i += 2) spans.emplace_back(xs[i], xs[i + 1]);
    }
    std::sort(spans.begin(), spans.end());
    double width = 0;
    double reached = -std::numeric_limits<double>::infinity();
    for (const auto& [from, to] : spans) {
      if (to <= reached) continue;
      width += to - std::max(from, reached);
      reached = to;
    }
    total += width * (ys[k + 1] - ys[k]);
  }
  return total;
}

void check_pieces(const std::vector<Polygon>& pieces) {
  REQUIRE(!pieces.empty());
  for (const Polygon& p : pieces) {
    CHECK(area(p) > 0);
    CHECK(simple(p));
  }
}

double regular_polygon_area(double r, double n) {
  return n / 2 * r * r * std::sin(2 * kPi / n);
}

}  // namespace

TEST_CASE("A straight thickened line has the area of its rectangle and its ends", "[thicken]") {
  const double r = 0.25;
  const double turn = GENERATE(0.0, 0.3, 1.7, 3.0, 4.5);
  CAPTURE(turn);
  const Point2 a{1, 2};
  const Point2 b{1 + 3 * std::cos(turn), 2 + 3 * std::sin(turn)};
  ThickenOptions options;
  options.cap = LineCap::Flat;
  CHECK(union_area(thicken({a, b}, r, options)) == Approx(2 * r * 3).epsilon(1e-12));
  options.cap = LineCap::Square;
  CHECK(union_area(thicken({a, b}, r, options)) == Approx(2 * r * 3 + 4 * r * r).epsilon(1e-12));
  options.cap = LineCap::Round;
  for (const double tolerance : {0.2, 0.05, 0.001}) {
    options.arc_tolerance = tolerance;
    const auto pieces = thicken({a, b}, r, options);
    check_pieces(pieces);
    const double steps = std::ceil(kPi / (2 * std::acos(1 - tolerance)));
    CHECK(union_area(pieces) == Approx(2 * r * 3 + regular_polygon_area(r, 2 * steps)).epsilon(1e-12));
    CHECK(union_area(pieces) < 2 * r * 3 + kPi * r * r);
    CHECK(union_area(pieces) > 2 * r * 3 + kPi * r * r * (1 - tolerance) * (1 - tolerance));
  }
}

TEST_CASE("Every piece of a thickened line is simple and counter-clockwise", "[thicken]") {
  const unsigned seed = 20240611;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-1, 1);
  for (const LineCap cap : {LineCap::Round, LineCap::Square, LineCap::Flat})
    for (const LineJoin join : {LineJoin::Round, LineJoin::Miter})
      for (int round = 0; round < 60; ++round) {
        ThickenOptions options;
        options.cap = cap;
        options.join = join;
        options.simplify = round % 2 == 0 ? 0 : 0.01;
        options.miter_limit = 1 + (round % 5);
        std::vector<Point2> line;
        // Segments from much longer to much shorter than the radius, and places far from the origin.
        const double scale = std::pow(10.0, round % 6 - 3);
        const double far = round % 3 == 0 ? 1000 : 0;
        for (int i = 0; i < 12; ++i) line.push_back({far + scale * place(random), far + scale * place(random)});
        if (round % 4 == 0) line.push_back(line.front());
        check_pieces(thicken(line, 0.1, options));
      }
}

TEST_CASE("No point near a thickened line is left out", "[thicken]") {
  // Round ends and joints make all points closer than the radius (less the arc tolerance) part of the union. Points
  // close to the vertices, where pieces meet, are tried most: a crack would be hit there.
  const unsigned seed = 7;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-1, 1);
  ThickenOptions options;
  options.cap = LineCap::Round;
  options.join = LineJoin::Round;
  options.simplify = 0;
  const double r = 0.3;
  int tried = 0;
  for (int round = 0; round < 60; ++round) {
    std::vector<Point2> line;
    for (int i = 0; i < 6; ++i) line.push_back({place(random), place(random)});
    const bool closed = round % 2 == 0;
    if (closed) line.push_back(line.front());
    const auto pieces = thicken(line, r, options);
    for (std::size_t i = 0; i < line.size(); ++i)
      for (int k = 0; k < 40; ++k) {
        const double distance = (1 - options.arc_tolerance) * r * std::pow(10.0, -(k % 12)) * 0.999;
        const double angle = kPi * place(random);
        const Point2 q{line[i].x + distance * std::cos(angle), line[i].y + distance * std::sin(angle)};
        ++tried;
        CHECK(std::any_of(pieces.begin(), pieces.end(), [&](const Polygon& p) { return inside(p, q); }));
      }
    // and no piece reaches farther than the radius
    for (const Polygon& p : pieces)
      for (const Point2& q : p) {
        double nearest = 1e300;
        for (std::size_t i = 0; i + 1 < line.size(); ++i)
          nearest = std::min(nearest, detail::distance_to_segment(q, line[i], line[i + 1]));
        CHECK(nearest <= r * (1 + 1e-12));
      }
  }
  CHECK(tried > 1000);
}

TEST_CASE("Joints overlap the quads they join by an area", "[thicken]") {
  for (const LineJoin join : {LineJoin::Round, LineJoin::Miter})
    for (int degrees = -179; degrees <= 180; degrees += 1) {
      CAPTURE(degrees);
      const double t = degrees * kPi / 180;
      ThickenOptions options;
      options.cap = LineCap::Flat;
      options.join = join;
      options.simplify = 0;
      const auto pieces = thicken({{-2, 0}, {0, 0}, {2 * std::cos(t), 2 * std::sin(t)}}, 0.5, options);
      REQUIRE(pieces.size() == 3);
      const double quads = union_area({pieces[0], pieces[1]});
      const double with_first = union_area({pieces[0], pieces[2]});
      const double with_second = union_area({pieces[1], pieces[2]});
      CHECK(with_first < area(pieces[0]) + area(pieces[2]) - 1e-3);
      CHECK(with_second < area(pieces[1]) + area(pieces[2]) - 1e-3);
      // The wedge between the quads is filled: by the kite, the bevel or the sector.
      const double turn = std::abs(t);
      double wedge = 0.125 * std::sin(turn);
      if (join == LineJoin::Round) {
        const double steps = std::max(1.0, std::ceil(turn / (2 * std::acos(1 - options.arc_tolerance))));
        wedge = steps * 0.125 * std::sin(turn / steps);
      } else if (1 / std::cos(turn / 2) <= options.miter_limit) {
        wedge = 0.25 * std::tan(turn / 2);
      }
      CHECK(union_area(pieces) == Approx(quads + wedge).epsilon(1e-9));
    }
}

TEST_CASE("A mitered right angle keeps its corner, a sharper one beyond the limit is beveled", "[thicken]") {
  ThickenOptions options;
  options.cap = LineCap::Flat;
  const auto pieces = thicken({{0, 0}, {1, 0}, {1, 1}}, 0.1, options);
  CHECK(union_area(pieces) == Approx(1.1 * 0.2 + 0.9 * 0.2).epsilon(1e-12));
  options.miter_limit = 1;
  CHECK(union_area(thicken({{0, 0}, {1, 0}, {1, 1}}, 0.1, options)) ==
        Approx(1.1 * 0.2 + 0.9 * 0.2 - 0.005).epsilon(1e-12));
}

TEST_CASE("A closed open line has no ends", "[thicken]") {
  for (const LineCap cap : {LineCap::Round, LineCap::Square, LineCap::Flat}) {
    ThickenOptions options;
    options.cap = cap;
    const auto pieces = thicken({{0, 0}, {2, 0}, {2, 1}, {0, 1}, {0, 0}}, 0.1, options);
    check_pieces(pieces);
    CHECK(pieces.size() == 8);
    CHECK(union_area(pieces) == Approx(2.2 * 1.2 - 1.8 * 0.8).epsilon(1e-12));
  }
}

TEST_CASE("A line without length becomes a dot, or nothing with flat ends", "[thicken]") {
  const std::vector<Point2> line = GENERATE(std::vector<Point2>{{3, 4}}, std::vector<Point2>{{3, 4}, {3, 4}},
                                            std::vector<Point2>{{3, 4}, {3, 4.0001}, {3, 4}});
  ThickenOptions options;
  options.cap = LineCap::Flat;
  CHECK(thicken(line, 0.5, options).empty());
  options.cap = LineCap::Square;
  auto pieces = thicken(line, 0.5, options);
  REQUIRE(pieces.size() == 1);
  CHECK(area(pieces[0]) == Approx(1).epsilon(1e-12));
  options.cap = LineCap::Round;
  options.arc_tolerance = GENERATE(0.05, 1e-4, 0.9);
  pieces = thicken(line, 0.5, options);
  REQUIRE(pieces.size() == 1);
  check_pieces(pieces);
  CHECK(area(pieces[0]) == Approx(regular_polygon_area(0.5, static_cast<double>(pieces[0].size()))).epsilon(1e-12));
  CHECK(area(pieces[0]) <= 0.25 * kPi);
  CHECK(thicken({}, 0.5, options).empty());
}

TEST_CASE("Simplification drops no point farther than its tolerance", "[thicken]") {
  const unsigned seed = 99;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 0.01);
  std::vector<Point2> line;
  for (int i = 0; i <= 400; ++i) line.push_back({i * 0.01, std::sin(i * 0.02) + noise(random)});
  for (const double tolerance : {0.005, 0.02, 0.1}) {
    const std::vector<Point2> kept = detail::simplify_line(line, tolerance);
    CHECK(kept.front() == line.front());
    CHECK(kept.back() == line.back());
    CHECK(kept.size() < line.size());
    double worst = 0;
    for (const Point2& p : line) {
      double nearest = 1e300;
      for (std::size_t i = 0; i + 1 < kept.size(); ++i)
        nearest = std::min(nearest, detail::distance_to_segment(p, kept[i], kept[i + 1]));
      worst = std::max(worst, nearest);
    }
    CHECK(worst <= tolerance);
  }
}

TEST_CASE("Repeated points and tiny segments do not change a thickened line", "[thicken]") {
  ThickenOptions options;
  options.simplify = 0;
  const double plain = union_area(thicken({{0, 0}, {1, 0}, {1, 1}}, 0.1, options));
  CHECK(union_area(thicken({{0, 0}, {0, 0}, {1, 0}, {1, 0}, {1, 1e-18}, {1, 1}, {1, 1}}, 0.1, options)) ==
        Approx(plain).epsilon(1e-12));
}

TEST_CASE("Thickening refuses options out of range and coordinates that are not finite", "[thicken]") {
  const std::vector<Point2> line{{0, 0}, {1, 0}};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto option_of = [&](double radius, const ThickenOptions& options) {
    try {
      (void)thicken(line, radius, options);
    } catch (const OptionError& e) {
      return e.option();
    }
    return std::string("none");
  };
  CHECK(option_of(0.1, {}) == "none");
  for (const double bad : {0.0, -1.0, nan, std::numeric_limits<double>::infinity()})
    CHECK(option_of(bad, {}) == "radius");
  CHECK(option_of(1e-15, {}) == "radius");
  ThickenOptions options;
  options.miter_limit = 0.5;
  CHECK(option_of(0.1, options) == "miter_limit");
  options = {};
  options.arc_tolerance = GENERATE(0.0, 1.0, -1.0);
  CHECK(option_of(0.1, options) == "arc_tolerance");
  options = {};
  options.simplify = -0.1;
  CHECK(option_of(0.1, options) == "simplify");
  CHECK_THROWS_AS(thicken({{0, 0}, {nan, 1}}, 0.1), GeometryError);
}
