// SPDX-License-Identifier: MIT
/// @file
/// @brief From open lines to areas: the pieces whose union is a thickened line.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/slice_stack.hpp"
#include "slice2mesh/pipeline/options.hpp"

namespace slice2mesh {

namespace detail {

inline constexpr double kPi = 3.14159265358979323846;

/// Shortest segment and smallest radius that have a meaning in double, as a share of the largest coordinate: a
/// direction computed from less has only a few good bits.
inline constexpr double kSmallestLength = 1.0 / (std::int64_t{1} << 40);
/// Turns below this angle (rad) need no outer edge in their joint: the notch it would fill is this share of the radius
/// wide and deep.
inline constexpr double kStraightTurn = 1e-9;

/// Points of a full circle at most: then it is within 5e-10 radii of the true one, at the end of what a file means.
inline constexpr double kMostArcPoints = 1e5;

inline double distance(const Point2& a, const Point2& b) {
  return std::hypot(b.x - a.x, b.y - a.y);
}

inline double distance_to_segment(const Point2& p, const Point2& a, const Point2& b) {
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  const double squared = dx * dx + dy * dy;
  if (!(squared > 0)) return distance(p, a);
  const double t = std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / squared, 0.0, 1.0);
  return std::hypot(a.x + t * dx - p.x, a.y + t * dy - p.y);
}

/// Douglas-Peucker: the points that are kept, first and last among them. No dropped point is farther than `tolerance`
/// from the segment that replaces it. A closed line (equal ends) is split at the point farthest from its ends.
inline std::vector<Point2> simplify_line(const std::vector<Point2>& line, double tolerance) {
  if (line.size() < 3 || tolerance <= 0) return line;
  std::vector<bool> keep(line.size(), false);
  keep.front() = keep.back() = true;
  std::vector<std::pair<std::size_t, std::size_t>> open{{0, line.size() - 1}};
  while (!open.empty()) {
    const auto [begin, end] = open.back();
    open.pop_back();
    double farthest = tolerance;
    std::size_t at = begin;
    for (std::size_t i = begin + 1; i < end; ++i) {
      const double d = distance_to_segment(line[i], line[begin], line[end]);
      if (d > farthest) {
        farthest = d;
        at = i;
      }
    }
    if (at == begin) continue;
    keep[at] = true;
    open.emplace_back(begin, at);
    open.emplace_back(at, end);
  }
  std::vector<Point2> kept;
  for (std::size_t i = 0; i < line.size(); ++i)
    if (keep[i]) kept.push_back(line[i]);
  return kept;
}

/// One call of `thicken`.
class LineThickener {
public:
  LineThickener(double radius, const ThickenOptions& options)
      : radius_(radius), options_(options),
        arc_step_(std::max(4 * std::asin(std::sqrt(options.arc_tolerance / 2)), 2 * kPi / kMostArcPoints)) {}

  std::vector<std::vector<Point2>> run(const std::vector<Point2>& line) {
    double largest = 0;
    for (const Point2& p : line) {
      if (!std::isfinite(p.x) || !std::isfinite(p.y))
        throw GeometryError(Stage::Regions, -1, -1, "a coordinate of an open line is not finite");
      largest = std::max({largest, std::abs(p.x), std::abs(p.y)});
    }
    shortest_ = kSmallestLength * largest;
    if (radius_ <= shortest_) throw OptionError("radius", "is too small for coordinates of this size");
    straight_ = std::max(kStraightTurn, shortest_ / radius_);
    if (line.empty()) return {};

    const bool closed = line.size() > 2 && line.front() == line.back();
    const std::vector<Point2> points = without_short_segments(simplify_line(line, options_.simplify * radius_), closed);
    if (points.size() < 2) {
      dot(line.front());
      return std::move(pieces_);
    }
    const std::size_t n = points.size() - 1;  // segments
    std::vector<Segment> segments(n);
    for (std::size_t i = 0; i < n; ++i) segments[i] = segment(points[i], points[i + 1]);
    for (std::size_t i = 0; i < n; ++i) quad(segments[i], !closed && i == 0, !closed && i + 1 == n);
    for (std::size_t i = 1; i < n; ++i) joint(segments[i - 1], segments[i]);
    if (closed) {
      joint(segments[n - 1], segments[0]);
    } else if (options_.cap == LineCap::Round) {
      round_cap(segments[0].a, segments[0], -1);
      round_cap(segments[n - 1].b, segments[n - 1], 1);
    }
    return std::move(pieces_);
  }

private:
  struct Segment {
    Point2 a, b;
    double length = 0;
    Point2 d;  ///< unit direction
    Point2 n;  ///< to the left, as long as the radius
  };

  static Point2 along(const Point2& p, double s, const Point2& v) { return {p.x + s * v.x, p.y + s * v.y}; }

  [[nodiscard]] Segment segment(const Point2& a, const Point2& b) const {
    Segment s;
    s.a = a;
    s.b = b;
    s.length = distance(a, b);
    s.d = {(b.x - a.x) / s.length, (b.y - a.y) / s.length};
    s.n = {-radius_ * s.d.y, radius_ * s.d.x};
    return s;
  }

  /// Drop points that are too close to the one before; of a closed line the last one takes its first point's place.
  [[nodiscard]] std::vector<Point2> without_short_segments(const std::vector<Point2>& line, bool closed) const {
    std::vector<Point2> kept;
    for (const Point2& p : line)
      if (kept.empty() || distance(kept.back(), p) > shortest_) kept.push_back(p);
    if (closed && kept.size() > 1 && kept.back() != kept.front()) {
      while (kept.size() > 1 && distance(kept.back(), kept.front()) <= shortest_) kept.pop_back();
      if (kept.size() > 1) kept.push_back(kept.front());
    }
    return kept;
  }

  void dot(const Point2& p) {
    const double r = radius_;
    if (options_.cap == LineCap::Square) {
      pieces_.push_back({{p.x - r, p.y - r}, {p.x + r, p.y - r}, {p.x + r, p.y + r}, {p.x - r, p.y + r}});
    } else if (options_.cap == LineCap::Round) {
      std::vector<Point2> disc{{p.x + r, p.y}};
      arc(disc, p, {r, 0}, 2 * kPi, 3);
      pieces_.push_back(std::move(disc));
    }
  }

  /// Points strictly between `from` and its image by a turn of `angle` around the center, evenly spaced.
  void arc(std::vector<Point2>& polygon, const Point2& center, const Point2& from, double angle,
           double fewest = 1) const {
    const double steps = std::max(fewest, std::ceil(angle / arc_step_));
    for (double i = 1; i < steps; ++i) {
      const double t = angle * (i / steps);
      const double c = std::cos(t);
      const double s = std::sin(t);
      polygon.push_back({center.x + c * from.x - s * from.y, center.y + s * from.x + c * from.y});
    }
  }

  void quad(const Segment& s, bool first, bool last) {
    const bool square = options_.cap == LineCap::Square;
    const Point2 a = first && square ? along(s.a, -radius_, s.d) : s.a;
    const Point2 b = last && square ? along(s.b, radius_, s.d) : s.b;
    pieces_.push_back({along(a, -1, s.n), along(b, -1, s.n), along(b, 1, s.n), along(a, 1, s.n)});
  }

  /// Half a disc behind an end, with a tip that reaches into the quad so that the two overlap by an area.
  /// side: -1 at the first point of the line, 1 at the last one.
  void round_cap(const Point2& end, const Segment& s, double side) {
    const Point2 from{-side * s.n.x, -side * s.n.y};
    std::vector<Point2> polygon{along(end, 1, from)};
    arc(polygon, end, from, kPi);
    polygon.push_back(along(end, -1, from));
    polygon.push_back(along(end, -side * std::min(radius_, s.length) / 2, s.d));
    pieces_.push_back(std::move(polygon));
  }

  /// What two quads leave open on the outer side of a turn. The piece reaches into both quads. Its corners are sorted
  /// by the angle around the vertex, with gaps below 180 degrees, so that it is simple.
  void joint(const Segment& s, const Segment& t) {
    const Point2 v = s.b;
    const double cross = s.d.x * t.d.y - s.d.y * t.d.x;
    const double dot = s.d.x * t.d.x + s.d.y * t.d.y;
    const double turn = std::atan2(std::abs(cross), dot);  // 0 to pi
    const bool left = cross >= 0;
    // Walk the outer side counter-clockwise: along the line at a left turn, against it at a right turn.
    const Segment& from = left ? s : t;
    const Segment& to = left ? t : s;
    const double side = left ? -1 : 1;
    const double forward = left ? 1 : -1;
    const Point2 begin{side * from.n.x, side * from.n.y};
    const Point2 end{side * to.n.x, side * to.n.y};

    std::vector<Point2> polygon{along(v, 1, begin)};
    if (turn > straight_) {
      if (options_.join == LineJoin::Round) {
        arc(polygon, v, begin, turn);
      } else if (1 <= options_.miter_limit * std::cos(turn / 2)) {
        const double scale = 1 / (1 + dot);
        polygon.push_back({v.x + scale * (begin.x + end.x), v.y + scale * (begin.y + end.y)});
      }
      polygon.push_back(along(v, 1, end));
    }
    const double before = std::min(radius_, from.length) / 2;
    const double after = std::min(radius_, to.length) / 2;
    const double inner = std::min(before, after) / 2;
    if (dot > 0) polygon.push_back(along(v, forward * after, to.d));
    polygon.push_back(along(v, inner, inner_direction(s, t, left, dot)));
    if (dot > 0) polygon.push_back(along(v, -forward * before, from.d));
    pieces_.push_back(std::move(polygon));
  }

  /// The unit vector that halves the inner angle of a turn.
  [[nodiscard]] Point2 inner_direction(const Segment& s, const Segment& t, bool left, double dot) const {
    Point2 m{t.d.x - s.d.x, t.d.y - s.d.y};  // good for sharp turns; the sum of the normals for others
    if (dot > 0) {
      const double sign = left ? 1 : -1;
      m = {sign * (s.n.x + t.n.x), sign * (s.n.y + t.n.y)};
    }
    const double length = std::hypot(m.x, m.y);
    return {m.x / length, m.y / length};
  }

  double radius_;
  const ThickenOptions& options_;  // of the caller, who outlives the call
  double arc_step_;
  double shortest_ = 0;
  double straight_ = 0;
  std::vector<std::vector<Point2>> pieces_;
};

inline void check_thicken_options(double radius, const ThickenOptions& options) {
  if (!(radius > 0) || !std::isfinite(radius)) throw OptionError("radius", "must be a finite length above 0");
  if (options.cap != LineCap::Round && options.cap != LineCap::Square && options.cap != LineCap::Flat)
    throw OptionError("cap", "is not one of round, square, flat");
  if (options.join != LineJoin::Round && options.join != LineJoin::Miter)
    throw OptionError("join", "is not one of round, miter");
  if (!(options.miter_limit >= 1) || !std::isfinite(options.miter_limit))
    throw OptionError("miter_limit", "must be finite and at least 1");
  if (!(options.arc_tolerance > 0 && options.arc_tolerance < 1))
    throw OptionError("arc_tolerance", "must be between 0 and 1");
  if (!(options.simplify >= 0) || !std::isfinite(options.simplify))
    throw OptionError("simplify", "must be finite and at least 0");
}

/// A radius in mm. Errors: OptionError.
inline double radius_in_mm(const char* option, const Length& length, double thickness) {
  const double radius = length.in_mm(thickness);
  if (!(radius >= 0) || !std::isfinite(radius)) throw OptionError(option, "must be a finite length, 0 or more");
  return radius;
}

/// Errors: OptionError for radii out of range, also those of parts that the slices do not have.
inline void check_support_radii(const ThickenOptions& options, double thickness) {
  radius_in_mm("supports.radius", options.radius, thickness);
  for (const auto& [part, length] : options.part_radius) radius_in_mm("supports.part_radius", length, thickness);
}

}  // namespace detail

/// Half the width of an open line in mm: `line_radius` says it, else `part_radius` of its part id, else `radius`;
/// 0: the line is left out. `layer` is its index in the stack, `thickness` the median layer thickness in mm.
/// Errors: OptionError where it is not finite or below 0; what `line_radius` throws. Cost: logarithmic in the parts.
[[nodiscard]] inline double support_radius(const ThickenOptions& options, const Polyline& line, std::int32_t layer,
                                           double thickness) {
  if (options.line_radius)
    return detail::radius_in_mm("supports.line_radius", options.line_radius(line, layer), thickness);
  const auto part = options.part_radius.find(line.part);
  if (part != options.part_radius.end()) return detail::radius_in_mm("supports.part_radius", part->second, thickness);
  return detail::radius_in_mm("supports.radius", options.radius, thickness);
}

/// Thicken an open line by a radius: the pieces whose union (non-zero winding) is the thickened line.
///
/// `line`: #P points, mm. `radius`: mm; the radii in `options` are not looked at. Each piece is a closed, simple,
/// counter-clockwise polygon without repeated last point: a quad per segment (longer by the radius at square ends), a
/// joint at each inner vertex (round: a sector; miter: a kite, beveled beyond `miter_limit` times the radius) and half
/// a disc at round ends. Arcs are inscribed: at most `arc_tolerance` times the radius inside of the true ones. Joints
/// and caps overlap the quads by an area, so that rounding leaves no cracks between them. The line is simplified first
/// (Douglas-Peucker, `simplify` times the radius).
/// A line whose ends are equal gets a joint there and no ends. A line without length (one point, or points that
/// simplify to one) becomes a dot: a disc (round), a square along the axes (square), or nothing (flat; the result is
/// empty). An empty line gives an empty result.
///
/// Errors: OptionError for options out of range and a radius below 2^-40 of the largest coordinate; GeometryError if a
/// coordinate is not finite. Cost: linear in the pieces; the simplification O(#P log #P) on usual lines.
[[nodiscard]] inline std::vector<std::vector<Point2>> thicken(const std::vector<Point2>& line, double radius,
                                                              const ThickenOptions& options = {}) {
  detail::check_thicken_options(radius, options);
  return detail::LineThickener(radius, options).run(line);
}

}  // namespace slice2mesh
