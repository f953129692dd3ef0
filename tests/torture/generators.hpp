// SPDX-License-Identifier: MIT
/// @file
/// @brief Geometry that is hard to mesh, class by class: stacks of slices, made from a seed.
///
/// Every class says what may come of it: a certified mesh, or errors that are right. Needs nothing but the value types.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/core/slice_stack.hpp"
#include "slice2mesh/pipeline/options.hpp"

namespace slice2mesh_test {

/// Numbers from a seed, the same on every platform.
class Dice {
public:
  explicit Dice(std::uint32_t seed) : random_(seed) {}
  /// In [low, high).
  double real(double low, double high) { return low + (high - low) * (static_cast<double>(random_()) / 4294967296.0); }
  /// In [low, high].
  int whole(int low, int high) {
    return low + static_cast<int>(random_() % static_cast<std::uint32_t>(high - low + 1));
  }
  bool one_in(int n) { return whole(1, n) == 1; }

private:
  std::mt19937 random_;
};

/// What a run may end with.
struct Allowed {
  bool certified = true;
  bool geometry_error = false;
  bool option_error = false;
  bool budget_error = false;
  bool tetrahedralization_error = false;
};
inline constexpr Allowed kMeshOnly{true, false, false, false, false};
inline constexpr Allowed kMeshOrGeometryError{true, true, false, false, false};
inline constexpr Allowed kGeometryErrorOnly{false, true, false, false, false};
inline constexpr Allowed kOptionErrorOnly{false, false, true, false, false};
inline constexpr Allowed kBudgetErrorOnly{false, false, false, true, false};
/// What is thinner than 2^-20 of the part within one slice may leave no room for a conforming mesh on the grid.
inline constexpr Allowed kMeshOrTooThin{true, true, false, false, true};
inline constexpr double kThinnest = 1.0 / 1048576;  ///< share of the extent

/// One input.
struct TortureCase {
  std::string name;
  slice2mesh::SliceStack stack;
  slice2mesh::Options options;
  Allowed allowed;
};

/// One kind of inputs.
struct TortureClass {
  std::string name;
  std::string what;  ///< for the table of docs/reliability.md
  std::function<std::vector<TortureCase>(std::uint32_t seed)> make;
  bool large = false;  ///< 1e4 to 1e6 of something: only on demand
};

namespace torture {

using slice2mesh::Direction;
using slice2mesh::Layer;
using slice2mesh::Length;
using slice2mesh::Options;
using slice2mesh::Point2;
using slice2mesh::Polyline;
using slice2mesh::SliceStack;

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kHeight = 0.5;  ///< mm, of most layers

using Slice = std::vector<Polyline>;
using Cases = std::vector<TortureCase>;

[[nodiscard]] inline Polyline loop(std::vector<Point2> points, Direction direction = Direction::Outer,
                                   std::int32_t part = 0) {
  Polyline line;
  line.part = part;
  line.direction = direction;
  line.points = std::move(points);
  if (direction == Direction::Inner) std::reverse(line.points.begin(), line.points.end());
  return line;
}

[[nodiscard]] inline Polyline box(double x0, double y0, double x1, double y1, Direction direction = Direction::Outer,
                                  std::int32_t part = 0) {
  return loop({{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}, direction, part);
}

/// A star with so many corners, every other one at (1 - depth) of the radius.
[[nodiscard]] inline Polyline star(Point2 center, double radius, int corners, double depth = 0, double turn = 0,
                                   Direction direction = Direction::Outer, std::int32_t part = 0) {
  std::vector<Point2> points;
  for (int i = 0; i < corners; ++i) {
    const double angle = turn + 2 * kPi * i / corners;
    const double r = radius * (i % 2 == 0 ? 1 : 1 - depth);
    points.push_back({center.x + r * std::cos(angle), center.y + r * std::sin(angle)});
  }
  return loop(std::move(points), direction, part);
}

[[nodiscard]] inline Polyline moved(Polyline line, double dx, double dy) {
  for (Point2& p : line.points) p = {p.x + dx, p.y + dy};
  return line;
}

[[nodiscard]] inline Slice turned(Slice slice, double angle, Point2 center = {0, 0}) {
  const double c = std::cos(angle), s = std::sin(angle);
  for (Polyline& line : slice)
    for (Point2& p : line.points) {
      const double x = p.x - center.x, y = p.y - center.y;
      p = {center.x + c * x - s * y, center.y + s * x + c * y};
    }
  return slice;
}

[[nodiscard]] inline SliceStack stack_of(std::vector<Slice> slices, double thickness = kHeight) {
  SliceStack stack;
  for (std::size_t i = 0; i < slices.size(); ++i) {
    Layer layer;
    layer.z = thickness * static_cast<double>(i);
    layer.polylines = std::move(slices[i]);
    stack.layers.push_back(std::move(layer));
  }
  return stack;
}

/// Limits for inputs that may need more than anyone has: narrow slits in exact mode ask for elements as small.
inline void limit(TortureCase& input) {
  input.allowed.budget_error = true;
  input.options.budget.max_vertices = 50000;
  input.options.budget.max_tets = 500000;
  input.options.budget.time_limit = 20;
}

/// The same with eps = 0 as well.
inline void add(Cases& cases, const std::string& name, const SliceStack& stack, bool exact_too = true,
                const Allowed& allowed = kMeshOnly) {
  cases.push_back({name, stack, {}, allowed});
  if (allowed.tetrahedralization_error) limit(cases.back());
  if (!exact_too) return;
  cases.push_back({name + ", eps 0", stack, {}, allowed});
  cases.back().options.eps = Length::mm(0);
  limit(cases.back());
}

[[nodiscard]] inline std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%g", value);
  for (char& c : buffer)
    if (c == ',') c = '.';
  return buffer;
}

/// What may come of a feature of one slice that is so wide, in a part of that extent.
[[nodiscard]] inline Allowed allowed_for(double width, double extent) {
  return width > 0 && width < kThinnest * extent ? kMeshOrTooThin : kMeshOnly;
}

inline Cases touching_points(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  for (const double angle : {0.0, dice.real(0, 1.5)}) {
    const std::string at = ", turned by " + text(angle);
    const Slice corners = turned({box(0, 0, 2, 2), box(2, 2, 4, 4), box(4, 0, 6, 2)}, angle);
    add(cases, "squares that touch in corners" + at, stack_of({corners, corners, corners}));
    const Slice edge = turned({box(0, 0, 4, 2), loop({{2, 2}, {3, 4}, {1, 4}})}, angle);
    add(cases, "a corner on an edge" + at, stack_of({edge, edge}));
    const Slice two = turned({box(0, 0, 2, 2), box(2, 2, 4, 4, Direction::Outer, 1)}, angle);
    add(cases, "two parts that touch in a corner" + at, stack_of({two, {two[0]}, two}));
    Slice fan;
    const int n = dice.whole(3, 9);
    for (int i = 0; i < n; ++i) {
      const double a = 2 * kPi * i / n, b = a + kPi / n;
      fan.push_back(loop({{0, 0}, {3 * std::cos(a), 3 * std::sin(a)}, {3 * std::cos(b), 3 * std::sin(b)}}));
    }
    add(cases, std::to_string(n) + " triangles around a point" + at, stack_of({fan, turned(fan, 0.3), fan}));
    add(cases, "layers that touch in a point" + at,
        stack_of({turned({box(0, 0, 2, 2)}, angle), turned({box(2, 2, 4, 4)}, angle)}));
  }
  return cases;
}

inline Cases touching_edges(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  for (const double angle : {0.0, dice.real(0, 1.5)}) {
    const std::string at = ", turned by " + text(angle);
    const Slice whole = turned({box(0, 0, 2, 2), box(2, 0, 4, 2)}, angle);
    add(cases, "a common edge" + at, stack_of({whole, whole}));
    const Slice part = turned({box(0, 0, 2, 2), box(2, dice.real(0.1, 1), 4, 1.5)}, angle);
    add(cases, "part of a common edge" + at, stack_of({part, part}));
    const Slice parts = turned({box(0, 0, 2, 2), box(2, 0.7, 4, 3, Direction::Outer, 1)}, angle);
    add(cases, "two parts with a common edge" + at, stack_of({parts, {parts[1]}, {parts[0]}}));
    add(cases, "layers with a common edge" + at, stack_of({{whole[0]}, {whole[1]}, {whole[0]}}));
  }
  return cases;
}

inline Cases holes_at_the_boundary(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  for (const double angle : {0.0, dice.real(0, 1.5)}) {
    const std::string at = ", turned by " + text(angle);
    const Polyline outer = box(0, 0, 6, 6);
    const auto both = [&](const std::string& name, const std::vector<Polyline>& holes,
                          const Allowed& allowed = kMeshOnly) {
      Slice slice{outer};
      slice.insert(slice.end(), holes.begin(), holes.end());
      slice = turned(slice, angle);
      add(cases, name + at, stack_of({slice, turned({outer}, angle), slice}), true, allowed);
    };
    both("a hole that touches in a point", {loop({{0, 3}, {2, 2}, {2, 4}}, Direction::Inner)});
    both("a hole along an edge", {box(0, 2, 2, 4, Direction::Inner)});
    both("a hole in a corner", {box(0, 0, 2, 2, Direction::Inner)});
    both("a hole that reaches out", {box(-1, 2, 2, 4, Direction::Inner)});
    both("a hole from side to side", {box(0, 2, 6, 4, Direction::Inner)});
    both("holes that touch each other",
         {box(1, 1, 3, 3, Direction::Inner), box(3, 3, 5, 5, Direction::Inner), box(3, 1, 5, 3, Direction::Inner)});
    both("a hole beside the boundary by " + text(1e-9), {box(1e-9, 2, 2, 4, Direction::Inner)}, allowed_for(1e-9, 6));
  }
  const Polyline all = box(0, 0, 3, 3, Direction::Inner);
  cases.push_back(
      {"a hole that is the whole", stack_of({{box(0, 0, 3, 3), all}, {box(0, 0, 3, 3), all}}), {}, kGeometryErrorOnly});
  return cases;
}

inline Cases islands(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  for (const int depth : {3, 6, 12}) {
    std::vector<Slice> slices;
    for (int l = 0; l < 3; ++l) {
      Slice slice;
      for (int i = 0; i < depth; ++i) {
        const double inwards = dice.real(0, 0.1);  // one number after the other: arguments have no order
        const int spikes = dice.whole(4, 24);
        slice.push_back(
            star({0.05 * l, 0}, depth - i, spikes, 0, inwards, i % 2 == 0 ? Direction::Outer : Direction::Inner));
      }
      slices.push_back(slice);
    }
    add(cases, std::to_string(depth) + " loops in each other", stack_of(slices));
  }
  Slice many{box(0, 0, 20, 20), box(1, 1, 19, 19, Direction::Inner)};
  for (int i = 0; i < 40; ++i) {
    const double radius = dice.real(0.05, 1.5);
    many.push_back(star({dice.real(3, 17), dice.real(3, 17)}, radius, 9));
  }
  add(cases, "forty islands in a hole, some overlapping", stack_of({many, many, {many[0]}}), true);
  return cases;
}

[[nodiscard]] inline Polyline comb(int teeth, double tooth, double gap, double length) {
  std::vector<Point2> points{{0, -1}, {teeth * (tooth + gap) - gap, -1}};
  for (int i = teeth - 1; i >= 0; --i) {
    const double x = i * (tooth + gap);
    points.push_back({x + tooth, 0});
    points.push_back({x + tooth, length});
    points.push_back({x, length});
    points.push_back({x, 0});
  }
  return loop(points);
}

inline Cases combs(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  for (const double gap : {0.3, 0.02, 1e-4, 1e-7})
    add(cases, "teeth with gaps of " + text(gap),
        stack_of({{comb(8, 0.7, gap, 3)}, {comb(8, 0.7, gap, 3 + dice.real(0, 0.02))}, {comb(8, 0.7, gap, 2.9)}}), true,
        allowed_for(gap, 6));
  for (const double tooth : {0.02, 1e-4, 1e-7})
    add(cases, "teeth of " + text(tooth), stack_of({{comb(8, tooth, 0.7, 3)}, {comb(8, tooth, 0.7, 3.2)}}), true,
        allowed_for(tooth, 6));
  return cases;
}

inline Cases spikes(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  for (const int n : {20, 100, 400})
    for (const double depth : {0.02, 0.5, 0.95}) {
      // Between deep spikes the gaps are narrow, and elements as small: a million of them for 400.
      const double turn = dice.real(0, 0.02);
      add(cases, std::to_string(n) + " spikes, depth " + text(depth),
          stack_of({{star({0, 0}, 5, 2 * n, depth)}, {star({0, 0}, 5, 2 * n, depth, turn)}}), n < 400);
      if (n * depth > 50) limit(cases.back());
      if (n * depth > 50 && n < 400) limit(cases[cases.size() - 2]);
    }
  return cases;
}

/// Distances as shares of the layer thickness.
[[nodiscard]] inline std::vector<double> distances() {
  std::vector<double> result{0};
  for (int k = -15; k <= 0; ++k) {
    result.push_back(std::pow(10.0, k));
    result.push_back(3 * std::pow(10.0, k));
  }
  return result;
}

inline Cases near_parallel(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  const double turn = dice.real(0, 1.5);
  for (const double share : distances()) {
    const double d = share * kHeight;
    const Slice straight{loop({{0, 0}, {10, 0}, {10, 4}, {0, 4}})};
    const Slice tilted{loop({{0, -d}, {10, d}, {10, 4 - d}, {0, 4 + d}})};
    add(cases, "crossing edges of layers, " + text(share) + " h",
        stack_of({turned(straight, turn), turned(tilted, turn), turned(straight, turn)}));
    const Slice wedge{box(0, 0, 10, 4), loop({{0, 4 + d}, {10, 4}, {10, 8}, {0, 8}})};
    add(cases, "crossing edges of a layer, " + text(share) + " h", stack_of({turned(wedge, turn), wedge}), share > 1e-9,
        allowed_for(d, 10));
  }
  return cases;
}

inline Cases near_coincident(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  for (const double share : distances()) {
    const double d = share * kHeight;
    const double a = dice.real(0, 2 * kPi);
    const Polyline first = star({0, 0}, 4, 17, 0.2);
    add(cases, "moved by " + text(share) + " h",
        stack_of({{first}, {moved(first, d * std::cos(a), d * std::sin(a))}, {first}}));
    const Slice beside{box(0, 0, 3, 3), box(3 + d, 0, 6, 3)};
    add(cases, "a gap of " + text(share) + " h", stack_of({beside, beside}), share > 1e-9, allowed_for(d, 6));
    const Slice over{box(0, 0, 3, 3), box(3 - d, 0.1, 6, 3)};
    add(cases, "an overlap of " + text(share) + " h of two parts",
        stack_of({over, {over[0], box(3 - d, 0.1, 6, 3, Direction::Outer, 5)}}), false, allowed_for(d, 6));
  }
  return cases;
}

/// Figure 9 of the paper: a square, each layer turned a little against the one below.
inline Cases twisted_squares(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  for (int k = -9; k <= 0; ++k)
    for (const double factor : {1.0, dice.real(1, 7)}) {
      const double angle = factor * std::pow(10.0, k) * (k == 0 ? 0.7 : 1);
      std::vector<Slice> slices;
      for (int l = 0; l < 6; ++l) slices.push_back(turned({box(-3, -3, 3, 3)}, angle * l));
      add(cases, "turned by " + text(angle) + " rad", stack_of(slices));
    }
  return cases;
}

inline Cases tangent_circles(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  for (const int n : {12, 64, 360}) {
    const double r = dice.real(0.5, 2);
    const std::string corners = ", " + std::to_string(n) + " corners";
    const Slice outside{star({0, 0}, 3, n), star({3 + r, 0}, r, n, 0, kPi)};
    add(cases, "from outside" + corners, stack_of({outside, outside}), n < 360);
    const Slice inside{star({0, 0}, 3, n), star({3 - r / 4, 0}, r / 4, n, 0, 0, Direction::Inner)};
    add(cases, "a hole from inside" + corners, stack_of({inside, {inside[0]}, inside}), n < 360);
    add(cases, "between layers" + corners, stack_of({{star({0, 0}, 3, n)}, {star({3 - r, 0}, r, n)}}), n < 360);
    Slice packed;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) packed.push_back(star({2.0 * i + (j % 2), std::sqrt(3.0) * j}, 1, n));
    add(cases, "packed" + corners, stack_of({packed, turned(packed, 0.01)}), n < 100);
  }
  return cases;
}

[[nodiscard]] inline Polyline spiral(double turns, double pitch, double width, int per_turn) {
  std::vector<Point2> outside, inside;
  const int n = static_cast<int>(turns * per_turn);
  for (int i = 0; i <= n; ++i) {
    const double a = 2 * kPi * i / per_turn;
    const double r = 1 + pitch * i / per_turn;
    outside.push_back({(r + width) * std::cos(a), (r + width) * std::sin(a)});
    inside.push_back({r * std::cos(a), r * std::sin(a)});
  }
  std::reverse(inside.begin(), inside.end());
  outside.insert(outside.end(), inside.begin(), inside.end());
  return loop(outside);
}

inline Cases spirals(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  for (const double gap : {0.3, 0.01, 1e-6, -0.05})
    add(cases, "arms with gaps of " + text(gap),
        stack_of({{spiral(3, 0.5 + gap, 0.5, 24)}, {spiral(3.2, 0.5 + gap, 0.5, 24)}}), true, allowed_for(gap, 5));
  Polyline line;
  line.direction = Direction::Open;
  for (int i = 0; i < 60; ++i) line.points.push_back({0.05 * i * std::cos(0.5 * i), 0.05 * i * std::sin(0.5 * i)});
  for (const double radius : {0.02, 0.2, 2.0}) {
    add(cases, "a support line, radius " + text(radius), stack_of({{line}, {line, box(2, -4, 4, 4)}, {line}}), false);
    cases.back().options.supports.radius = Length::mm(radius * dice.real(0.9, 1.1));
  }
  return cases;
}

inline Cases checkerboards(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  for (const int n : {2, 5, 9})
    for (const double angle : {0.0, dice.real(0, 1)}) {
      std::vector<Slice> slices(3);
      for (int l = 0; l < 3; ++l)
        for (int i = 0; i < n; ++i)
          for (int j = 0; j < n; ++j)
            if ((i + j + l) % 2 == 0) slices[static_cast<std::size_t>(l)].push_back(box(i, j, i + 1, j + 1));
      for (Slice& slice : slices) slice = turned(slice, angle);
      add(cases, std::to_string(n) + " by " + std::to_string(n) + ", turned by " + text(angle), stack_of(slices));
    }
  return cases;
}

inline Cases vanishing_layers(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  std::vector<Slice> slices;
  for (int l = 0; l < 12; ++l) {
    if (l % 3 == 1)
      slices.emplace_back();
    else
      slices.push_back({star({dice.real(0, 1), 0}, dice.real(1, 3), 11, 0.2)});
  }
  add(cases, "every third layer is empty", stack_of(slices));
  add(cases, "a part of the layer comes and goes",
      stack_of({{box(0, 0, 2, 2), box(4, 0, 6, 2)}, {box(0, 0, 2, 2)}, {box(4, 0, 6, 2)}, {box(0, 0, 6, 2)}}));
  add(cases, "a hole comes and goes",
      stack_of({{box(0, 0, 4, 4), box(1, 1, 2, 2, Direction::Inner)},
                {box(0, 0, 4, 4)},
                {box(0, 0, 4, 4), box(1, 1, 2, 2, Direction::Inner)},
                {box(0, 0, 4, 4), box(2, 2, 3, 3, Direction::Inner)}}));
  add(cases, "a layer without area between two",
      stack_of({{box(0, 0, 2, 2)}, {loop({{0, 0}, {2, 2}, {1, 1}})}, {box(0, 0, 2, 2)}}));
  add(cases, "half of the layers empty at both ends",
      stack_of({{}, {}, {box(0, 0, 2, 2)}, {}, {box(0, 0, 2, 2)}, {}, {}}));
  return cases;
}

inline Cases one_layer(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  const Slice slice{star({1, 1}, 3, dice.whole(5, 40), 0.3), star({1, 1}, 1, 7, 0, 0, Direction::Inner)};
  SliceStack stack = stack_of({slice});
  stack.layers[0].z = 0.4;
  add(cases, "its thickness from its z", stack);
  stack.layers[0].z = 0;
  cases.push_back({"nothing says how thick", stack, {}, kGeometryErrorOnly});
  cases.push_back({"its thickness from the options", stack, {}, kMeshOnly});
  cases.back().options.slabs.thickness = 0.2;
  cases.push_back({"no layers", SliceStack{}, {}, kGeometryErrorOnly});
  cases.push_back({"one empty layer", stack_of({{}}), {}, kGeometryErrorOnly});
  return cases;
}

inline Cases far_away(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  for (const double distance : {1e3, 1e6, 1e9, 1e12, 1e14}) {
    const double a = dice.real(0, 6);
    const Polyline line = moved(star({0, 0}, 4, 15, 0.3), distance * std::cos(a), distance * std::sin(a));
    const Polyline next = moved(line, 0.1, 0.05);
    // Beyond, less than 24 of the 53 bits of a coordinate are left for the part.
    add(cases, text(distance) + " mm from the origin", stack_of({{line}, {next}, {line}}), true,
        distance > 1e9 ? kMeshOrGeometryError : kMeshOnly);
  }
  SliceStack high = stack_of({{star({0, 0}, 4, 15, 0.3)}, {star({0, 0}, 4.1, 15, 0.3)}});
  for (Layer& layer : high.layers) layer.z += 1e6;
  add(cases, "1e6 mm above the plate", high);
  return cases;
}

[[nodiscard]] inline SliceStack scaled(SliceStack stack, double xy, double z) {
  for (Layer& layer : stack.layers) {
    layer.z *= z;
    for (Polyline& line : layer.polylines)
      for (Point2& p : line.points) p = {p.x * xy, p.y * xy};
  }
  return stack;
}

inline Cases scales(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  const double turn = dice.real(0, 0.1);
  const SliceStack part =
      stack_of({{star({0, 0}, 3, 13, 0.3)}, {star({0.1, 0}, 3, 13, 0.3, turn)}, {star({0, 0}, 2, 20)}});
  for (const double scale : {1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9})
    add(cases, "times " + text(scale), scaled(part, scale, scale));
  // Where squares of lengths leave the range of double.
  for (const double scale : {1e-320, 1e-300, 1e-160, 1e-100, 1e100, 1e149, 1e160, 1e300})
    add(cases, "times " + text(scale), scaled(part, scale, scale), true, kMeshOrGeometryError);
  SliceStack units = part;
  units.unit = 1e-3;
  units.z_unit = 1e-3;
  add(cases, "in micrometers", scaled(units, 1e3, 1e3), false);
  return cases;
}

inline Cases thicknesses(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  const double size = 5;
  for (const double ratio : {1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0, 1e3}) {
    const double h = ratio * size;
    SliceStack stack = stack_of({{star({0, 0}, size / 2, 13, 0.3)},
                                 {star({0, 0}, size / 2, 13, 0.3, dice.real(0, 0.02))},
                                 {star({0.02, 0}, size / 2, 13, 0.3)}},
                                h);
    add(cases, text(ratio) + " of the size", stack);
    for (std::size_t i = cases.size() - 2; i < cases.size(); ++i)
      if (ratio < 1e-2) cases[i].options.size.size = Length::mm(size / 10);
  }
  SliceStack mixed = stack_of({{box(0, 0, 3, 3)}, {box(0, 0, 3, 2)}, {box(0, 0, 3, 3)}, {box(0, 0, 2, 3)}});
  mixed.layers[1].z = 1e-4;
  mixed.layers[2].z = 1;
  mixed.layers[3].z = 1.01;
  add(cases, "very different layers", mixed);
  for (std::size_t i = cases.size() - 2; i < cases.size(); ++i) cases[i].options.size.size = Length::mm(0.5);
  return cases;
}

inline Cases self_crossing(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  add(cases, "a figure eight", stack_of({{loop({{0, 0}, {4, 4}, {4, 0}, {0, 4}})}, {box(0, 0, 4, 4)}}));
  for (int i = 0; i < 6; ++i) {
    std::vector<Slice> slices;
    for (int l = 0; l < 2; ++l) {
      std::vector<Point2> points;
      for (int n = dice.whole(5, 25); n > 0; --n) points.push_back({dice.real(0, 8), dice.real(0, 8)});
      slices.push_back({loop(points)});
    }
    add(cases, "random loops " + std::to_string(i), stack_of(slices));
  }
  for (int i = 0; i < 4; ++i) {
    std::vector<Slice> slices;
    for (int l = 0; l < 3; ++l) {  // on a small lattice: everything coincides and is collinear
      Slice slice;
      for (int k = 0; k < 3; ++k) {
        std::vector<Point2> points;
        for (int n = dice.whole(3, 12); n > 0; --n)
          points.push_back({static_cast<double>(dice.whole(0, 4)), static_cast<double>(dice.whole(0, 4))});
        slice.push_back(loop(points, dice.one_in(4) ? Direction::Inner : Direction::Outer, dice.whole(0, 1)));
      }
      slices.push_back(slice);
    }
    add(cases, "random loops on a lattice " + std::to_string(i), stack_of(slices), true, kMeshOrGeometryError);
  }
  add(cases, "there and back", stack_of({{loop({{0, 0}, {3, 0}, {3, 3}, {6, 3}, {3, 3}, {0, 3}})}, {box(0, 0, 3, 3)}}));
  add(cases, "repeated points",
      stack_of({{loop({{0, 0}, {0, 0}, {3, 0}, {3, 0}, {3, 3}, {0, 3}, {0, 3}, {0, 0}})}, {box(0, 0, 3, 3)}}));
  return cases;
}

inline Cases repeated_loops(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  const Polyline part = star({0, 0}, 3, dice.whole(5, 15), 0.2);
  Polyline reversed = part;
  std::reverse(reversed.points.begin(), reversed.points.end());
  Polyline shifted = part;
  std::rotate(shifted.points.begin(), shifted.points.begin() + 2, shifted.points.end());
  Polyline other = part;
  other.part = 3;
  add(cases, "the same loop three times", stack_of({{part, part, part}, {part}}));
  add(cases, "the same loop the other way", stack_of({{part, reversed}, {reversed}, {shifted, part}}));
  add(cases, "the same loop in two parts", stack_of({{part, other}, {other, part}, {other}}));
  Slice many;
  for (int i = 0; i < 30; ++i) many.push_back(star({dice.real(0, 1e-7), dice.real(0, 1e-7)}, 3, 15, 0.2));
  add(cases, "thirty loops that are nearly one", stack_of({many, many}), true, kMeshOrTooThin);
  for (const int parts : {2, 8}) {
    std::vector<Slice> slices(3);
    for (Slice& slice : slices)
      for (int p = 0; p < 3 * parts; ++p)
        slice.push_back(star({dice.real(0, 8), dice.real(0, 8)}, dice.real(1, 3), dice.whole(3, 12), 0, dice.real(0, 1),
                             dice.one_in(6) ? Direction::Inner : Direction::Outer, p % parts));
    add(cases, std::to_string(parts) + " parts over each other", stack_of(slices));
  }
  return cases;
}

inline Cases support_lines(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  for (const double radius : {1e-6, 0.05, 0.3, 5.0})
    for (int i = 0; i < 3; ++i) {
      std::vector<Slice> slices;
      for (int l = 0; l < 3; ++l) {
        Slice slice{box(2, 2, 5, 5)};
        for (int k = 0; k < 6; ++k) {
          Polyline line;
          line.direction = Direction::Open;
          line.part = dice.whole(0, 1);
          for (int n = dice.whole(1, 7); n > 0; --n) line.points.push_back({dice.real(0, 8), dice.real(0, 8)});
          if (dice.one_in(3)) line.points.push_back(line.points[0]);
          if (dice.one_in(4)) line.points.insert(line.points.begin(), line.points.back());
          slice.push_back(line);
        }
        slices.push_back(slice);
      }
      add(cases, "random lines " + std::to_string(i) + ", radius " + text(radius), stack_of(slices), false,
          allowed_for(2 * radius, 8));
      Options& options = cases.back().options;
      options.supports.radius = Length::mm(radius);
      options.supports.cap = static_cast<slice2mesh::LineCap>(i);
      options.supports.join = i == 1 ? slice2mesh::LineJoin::Miter : slice2mesh::LineJoin::Round;
      options.supports.miter_limit = i == 1 ? 100 : 2;
    }
  Polyline line;
  line.direction = Direction::Open;
  line.points = {{0, 0}, {1, 1}};
  cases.push_back({"lines alone without a radius", stack_of({{line}, {line}}), {}, kGeometryErrorOnly});
  return cases;
}

/// Needles and fans: angles that no mesh can be good at.
inline Cases needles(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  for (const double width : {1e-1, 1e-4, 1e-7, 1e-10, 1e-13}) {
    const Slice needle{loop({{0, 0}, {10, 0}, {0, width}}), box(-2, -1, 0, 1)};
    add(cases, "a needle of " + text(width), stack_of({needle, turned(needle, dice.real(0, 0.1)), needle}), true,
        allowed_for(width, 12));
  }
  for (const int n : {5, 40, 200}) {
    Slice fan;
    for (int i = 0; i < n; ++i) {
      const double a = 0.5 * kPi * i / n, b = a + 0.2 * kPi / n;
      fan.push_back(loop({{0, 0}, {5 * std::cos(a), 5 * std::sin(a)}, {5 * std::cos(b), 5 * std::sin(b)}}));
    }
    add(cases, "a fan of " + std::to_string(n), stack_of({fan, fan}), n < 200);
    std::vector<Point2> zigzag;
    for (int i = 0; i <= n; ++i) zigzag.push_back({10.0 * i / n, i % 2 == 0 ? 0 : 3.0});
    for (int i = n; i >= 0; --i) zigzag.push_back({10.0 * i / n, (i % 2 == 0 ? 0 : 3.0) + 0.05});
    add(cases, "a zigzag of " + std::to_string(n), stack_of({{loop(zigzag)}, {loop(zigzag)}}), n < 200);
  }
  return cases;
}

/// Features of the size of the grid itself: a few pitches of 2^-40 of the part.
inline Cases at_the_grid(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  const double pitch = std::ldexp(1.0, -36);  // of a part of 8 to 16 mm
  for (const int steps : {1, 4, 8, 15, 16, 17, 24, 32, 64, 100, 1000, 100000}) {
    const double d = steps * pitch;
    add(cases, "steps of " + std::to_string(steps) + " pitches",
        stack_of({{box(0, 0, 10, 5)}, {box(d, -d, 10 + d, 5 - d)}, {box(2 * d, 0, 10, 5 + d)}}));
    Slice dust{box(0, 0, 10, 5)};
    for (int i = 0; i < 12; ++i) {
      const double x = dice.real(-1, 11), y = dice.real(-1, 6);
      dust.push_back(loop({{x, y}, {x + d * dice.whole(0, 3), y + d * dice.whole(0, 3)}, {x, y + d * dice.whole(1, 3)}},
                          dice.one_in(2) ? Direction::Inner : Direction::Outer));
    }
    add(cases, "dust of " + std::to_string(steps) + " pitches", stack_of({dust, {dust[0]}, dust}), true,
        allowed_for(d, 12));
  }
  return cases;
}

inline Cases random_stacks(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  for (int i = 0; i < 8; ++i) {
    const double noise = std::pow(10.0, dice.real(-9, 0));
    struct Shape {
      Point2 center;
      double radius, depth, turn;
      int corners, part;
      bool inner;
    };
    std::vector<Shape> shapes;
    for (int k = dice.whole(1, 6); k > 0; --k)
      shapes.push_back({{dice.real(0, 8), dice.real(0, 8)},
                        dice.real(0.5, 3),
                        dice.real(0, 0.6),
                        dice.real(0, 6),
                        dice.whole(3, 30),
                        dice.whole(0, 1),
                        !shapes.empty() && dice.one_in(4)});
    std::vector<Slice> slices;
    for (int l = 0; l < 5; ++l) {
      Slice slice;
      for (Shape& s : shapes) {
        slice.push_back(star(s.center, s.radius, s.corners, s.depth, s.turn,
                             s.inner ? Direction::Inner : Direction::Outer, s.part));
        for (Point2& p : slice.back().points) p = {p.x + noise * dice.real(-1, 1), p.y + noise * dice.real(-1, 1)};
        if (dice.one_in(3)) s.center.x += dice.real(-0.3, 0.3);
        if (dice.one_in(3)) s.turn += dice.real(-0.05, 0.05);
      }
      slices.push_back(slice);
    }
    add(cases, "noise of " + text(noise) + " mm", stack_of(slices), true, kMeshOrGeometryError);
    if (dice.one_in(2)) cases.back().options.slabs.lump = 2;
    if (dice.one_in(3)) {
      cases.back().options.plate.thickness = Length::mm(1);
      cases.back().options.plate.margin = Length::mm(dice.real(0.5, 3));
      if (dice.one_in(2)) cases.back().options.plate.shape = slice2mesh::BasePlateShape::Offset;
    }
  }
  return cases;
}

/// Numbers that are none, heights that do not ascend, options out of range: typed errors and nothing else.
inline Cases wrong_numbers(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  const SliceStack good = stack_of({{box(0, 0, 3, 3)}, {box(0, 0, 3, 3)}});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -inf, 1e308, -1e308}) {
    const std::string value = text(bad);
    const auto slice = static_cast<std::size_t>(dice.whole(0, 1));
    const auto point = static_cast<std::size_t>(dice.whole(0, 3));
    SliceStack stack = good;
    stack.layers[slice].polylines[0].points[point].x = bad;
    add(cases, "x " + value, stack, false, kGeometryErrorOnly);
    stack = good;
    stack.layers[slice].z = bad;
    add(cases, "z " + value, stack, false, kMeshOrGeometryError);
    stack = good;
    stack.unit = bad;
    add(cases, "unit " + value, stack, false, kGeometryErrorOnly);
    stack = good;
    stack.z_unit = bad;
    add(cases, "z unit " + value, stack, false, kMeshOrGeometryError);
    cases.back().allowed.option_error = true;  // lengths in layer thicknesses are not finite any more
    const auto option = [&](const std::string& name, const std::function<void(Options&)>& change,
                            const Allowed& allowed) {
      std::string label = name;
      label.append(" ").append(value);
      cases.push_back({label, good, {}, allowed});
      change(cases.back().options);
    };
    const bool finite = std::isfinite(bad) && bad > 0;
    Allowed either = kOptionErrorOnly;
    either.certified = finite;
    either.geometry_error = finite;
    option(
        "eps", [&](Options& o) { o.eps = Length::mm(bad); }, either);
    option(
        "size", [&](Options& o) { o.size.size = Length::mm(bad); }, either);
    option(
        "contour size", [&](Options& o) { o.size.contour_size = Length::mm(bad); }, either);
    option(
        "coarsest", [&](Options& o) { o.size.coarsest = Length::mm(bad); }, either);
    option(
        "support radius", [&](Options& o) { o.supports.radius = Length::mm(bad); }, either);
    option(
        "plate thickness", [&](Options& o) { o.plate.thickness = Length::mm(bad); }, either);
  }
  SliceStack stack = good;
  stack.unit = 0;
  add(cases, "unit 0", stack, false, kGeometryErrorOnly);
  stack = good;
  stack.unit = -1;
  add(cases, "unit -1", stack, false, kMeshOrGeometryError);
  stack = good;
  stack.layers[1].z = 0;
  add(cases, "equal heights", stack, false, kGeometryErrorOnly);
  stack.layers[1].z = -1;
  add(cases, "descending heights", stack, false, kGeometryErrorOnly);
  stack.layers[1].z = 5e-324;
  add(cases, "a layer of 5e-324 mm", stack, false, kMeshOrGeometryError);
  return cases;
}

/// Elements so small that nobody has the memory, and budgets that say so.
inline Cases too_much(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  const SliceStack stack = stack_of({{star({0, 0}, 5, 20, 0.2)}, {star({0, 0}, 5, 20, 0.2, dice.real(0, 0.1))}});
  const auto ask = [&](const std::string& name, const std::function<void(Options&)>& change) {
    cases.push_back({name, stack, {}, kBudgetErrorOnly});
    cases.back().allowed.option_error = true;  // sizes below 2^-20 of the part
    change(cases.back().options);
  };
  for (const double size : {1e-3, 1e-5, 1e-6, 1e-300}) {
    const std::string at = "size " + text(size);
    ask(at + ", vertices", [&](Options& o) {
      o.size.size = Length::mm(size);
      o.budget.max_vertices = 20000;
    });
    ask(at + ", tets", [&](Options& o) {
      o.size.size = Length::mm(size);
      o.budget.max_tets = 100000;
    });
    ask("contour " + at + ", vertices", [&](Options& o) {
      o.size.contour_size = Length::mm(size);
      o.budget.max_vertices = 5000;
    });
    ask(at + ", time", [&](Options& o) {
      o.size.size = Length::mm(size);
      o.size.contour_size = Length::mm(1);
      o.budget.time_limit = 1;
    });
    ask("contour " + at + ", time", [&](Options& o) {
      o.size.contour_size = Length::mm(size);
      o.budget.time_limit = 1;
    });
  }
  ask("size 1e-5, no budget", [&](Options& o) { o.size.size = Length::mm(1e-5); });
  return cases;
}

// --- large ones ---------------------------------------------------------------------------------------------------

inline Cases tall(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  std::vector<Slice> slices;
  for (int l = 0; l < 100000; ++l) slices.push_back({box(0, 0, 1 + 1e-3 * dice.real(0, 1), 1)});
  cases.push_back({"1e5 layers of a bar", stack_of(slices, 0.01), {}, kMeshOnly});
  cases.back().options.size.size = Length::mm(1);
  cases.back().options.eps = Length::mm(0.01);
  return cases;
}

inline Cases wide(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  std::vector<Point2> points;
  const int n = 1000000;
  points.reserve(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    const double a = 2 * kPi * i / n;
    const double r = 100 + 5 * std::sin(40 * a) + 1e-4 * dice.real(-1, 1);
    points.push_back({r * std::cos(a), r * std::sin(a)});
  }
  SliceStack stack = stack_of({{loop(points)}});
  stack.layers[0].z = 1;
  cases.push_back({"one layer of 1e6 points", stack, {}, kMeshOnly});
  return cases;
}

inline Cases many_spikes(std::uint32_t seed) {
  Dice dice(seed);
  Cases cases;
  cases.push_back({"1e4 spikes",
                   stack_of({{star({0, 0}, 50, 20000, 0.3)}, {star({0, 0}, 50, 20000, 0.3, dice.real(0, 1e-4))}}),
                   {},
                   kMeshOnly});
  Slice dust;
  for (int i = 0; i < 100; ++i)
    for (int j = 0; j < 100; ++j) dust.push_back(box(i, j, i + 0.5, j + 0.5));
  cases.push_back({"1e4 separate squares", stack_of({dust, dust}), {}, kMeshOnly});
  Slice nested;
  for (int i = 0; i < 1000; ++i)
    nested.push_back(star({0, 0}, 1000 - i, 12, 0, 0, i % 2 == 0 ? Direction::Outer : Direction::Inner));
  cases.push_back({"1e3 loops in each other", stack_of({nested, nested}, 2), {}, kMeshOnly});
  Slice crossing;
  for (int i = 0; i < 150; ++i) {
    crossing.push_back(box(0, 2 * i, 300, 2 * i + 1));
    crossing.push_back(box(2 * i, 0, 2 * i + 1, 300));
  }
  cases.push_back({"9e4 crossings", stack_of({crossing}, 2), {}, kMeshOnly});
  cases.back().stack.layers[0].z = 2;
  return cases;
}

}  // namespace torture

/// All classes. The seed that makes the inputs is an argument of `make`.
[[nodiscard]] inline std::vector<TortureClass> torture_classes() {
  using namespace torture;
  return {
      {"touching_points", "contours and layers that touch in a point", touching_points},
      {"touching_edges", "contours, parts and layers that touch along an edge", touching_edges},
      {"holes_at_the_boundary", "holes that touch, follow or cross the outer boundary", holes_at_the_boundary},
      {"islands", "islands in holes, up to twelve deep", islands},
      {"combs", "teeth and gaps down to 1e-7 mm", combs},
      {"spikes", "stars with up to 400 spikes", spikes},
      {"near_parallel", "edges that cross at 1e-15 to 3 of the thickness over 10 mm", near_parallel},
      {"near_coincident", "contours at distances of 1e-15 to 3 of the thickness", near_coincident},
      {"twisted_squares", "squares turned by 1e-9 to 1 rad per layer (figure 9 of the paper)", twisted_squares},
      {"tangent_circles", "circles that touch each other, from outside, inside, and between layers", tangent_circles},
      {"spirals", "spiral walls and spiral support lines", spirals},
      {"checkerboards", "checkerboards that flip each layer: everything is overhang", checkerboards},
      {"vanishing_layers", "layers, parts and holes that vanish and come back", vanishing_layers},
      {"one_layer", "one layer, or none", one_layer},
      {"far_away", "parts 1e3 to 1e14 mm from the origin", far_away},
      {"scales", "sizes of 1e-9 to 1e9 mm, and of 1e-320 to 1e300", scales},
      {"thicknesses", "layers of 1e-4 to 1e3 of the size", thicknesses},
      {"self_crossing", "loops that cross and retrace themselves", self_crossing},
      {"repeated_loops", "loops that stand twice, reversed, in two parts, nearly", repeated_loops},
      {"support_lines", "random support lines, radii of 1e-6 to 5 mm", support_lines},
      {"needles", "needles, fans and zigzags: angles down to 1e-14", needles},
      {"at_the_grid", "features of 1 to 1e5 pitches of the grid", at_the_grid},
      {"random_stacks", "random stacks with noise, holes, two parts, plates, bundles", random_stacks},
      {"wrong_numbers", "NaN, infinite and huge numbers in slices and options", wrong_numbers},
      {"too_much", "sizes that ask for more than the budget", too_much},
      {"tall", "1e5 layers", tall, true},
      {"wide", "one layer of 1e6 points", wide, true},
      {"many_spikes", "1e4 spikes, 1e4 squares, 1e3 nested loops, 9e4 crossings", many_spikes, true},
  };
}

/// Whether a run may end like this.
[[nodiscard]] inline bool is_allowed(const Allowed& allowed, const std::string& ending) {
  return (ending == "certified" && allowed.certified) || (ending == "GeometryError" && allowed.geometry_error) ||
         (ending == "OptionError" && allowed.option_error) || (ending == "BudgetError" && allowed.budget_error) ||
         (ending == "TetrahedralizationError" && allowed.tetrahedralization_error);
}

}  // namespace slice2mesh_test
