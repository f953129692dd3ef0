// SPDX-License-Identifier: MIT
/// @file
/// @brief Exact predicates on grid points, in integer arithmetic.
#pragma once

#include <cmath>
#include <cstdint>

#include "slice2mesh/core/grid.hpp"

namespace slice2mesh::detail {

__extension__ typedef __int128 Int128;
__extension__ typedef unsigned __int128 Uint128;

[[nodiscard]] constexpr int sign(Int128 v) noexcept {
  return v > 0 ? 1 : (v < 0 ? -1 : 0);
}

/// (b - a) x (c - a): twice the signed area of abc in squared pitches; exact.
[[nodiscard]] constexpr Int128 cross(const GridPoint& a, const GridPoint& b, const GridPoint& c) noexcept {
  return Int128(b.x - a.x) * (c.y - a.y) - Int128(b.y - a.y) * (c.x - a.x);
}

/// +1: abc turns left, -1: right, 0: on one line; exact.
[[nodiscard]] constexpr int orientation(const GridPoint& a, const GridPoint& b, const GridPoint& c) noexcept {
  return sign(cross(a, b, c));
}

/// Do the closed segments ab and cd have a point in common? Exact; segments on one line are told by their boxes.
[[nodiscard]] constexpr bool segments_meet(const GridPoint& a, const GridPoint& b, const GridPoint& c,
                                           const GridPoint& d) noexcept {
  const auto apart = [](std::int64_t p, std::int64_t q, std::int64_t r, std::int64_t s) {
    return (p < q ? q : p) < (r < s ? r : s) || (r < s ? s : r) < (p < q ? p : q);
  };
  if (apart(a.x, b.x, c.x, d.x) || apart(a.y, b.y, c.y, d.y)) return false;
  return orientation(a, b, c) * orientation(a, b, d) <= 0 && orientation(c, d, a) * orientation(c, d, b) <= 0;
}

/// (b - a) . (c - a), exact.
[[nodiscard]] constexpr Int128 dot(const GridPoint& a, const GridPoint& b, const GridPoint& c) noexcept {
  return Int128(b.x - a.x) * (c.x - a.x) + Int128(b.y - a.y) * (c.y - a.y);
}

/// |b - a|^2, exact.
[[nodiscard]] constexpr Int128 squared_distance(const GridPoint& a, const GridPoint& b) noexcept {
  return Int128(b.x - a.x) * (b.x - a.x) + Int128(b.y - a.y) * (b.y - a.y);
}

/// |b - a| in pitches, rounded.
[[nodiscard]] inline double distance(const GridPoint& a, const GridPoint& b) noexcept {
  const double x = static_cast<double>(b.x - a.x), y = static_cast<double>(b.y - a.y);
  return std::sqrt(x * x + y * y);  // not hypot: nothing overflows here, and it is several times faster
}

/// Distance of p to the segment ab in pitches, rounded. For choices of quality, never for topology.
[[nodiscard]] inline double segment_distance(const GridPoint& p, const GridPoint& a, const GridPoint& b) noexcept {
  const double dx = static_cast<double>(b.x - a.x), dy = static_cast<double>(b.y - a.y);
  const double px = static_cast<double>(p.x - a.x), py = static_cast<double>(p.y - a.y);
  const double length2 = dx * dx + dy * dy;
  double t = length2 > 0 ? (px * dx + py * dy) / length2 : 0;
  t = t < 0 ? 0 : (t > 1 ? 1 : t);
  const double x = px - t * dx, y = py - t * dy;
  return std::sqrt(x * x + y * y);
}

/// A signed 192-bit number, high part times 2^64 plus low part; just enough for comparing products of the predicates.
struct Int192 {
  Int128 high;
  std::uint64_t low;
  friend constexpr bool operator<(const Int192& a, const Int192& b) noexcept {
    return a.high != b.high ? a.high < b.high : a.low < b.low;
  }
};

/// a * b for |a| < 2^126, |b| < 2^62; exact.
[[nodiscard]] constexpr Int192 multiply(Int128 a, std::int64_t b) noexcept {
  const Int128 a_high = a >> 64;  // rounds down: a = a_high 2^64 + a_low with a_low in [0, 2^64)
  const auto a_low = static_cast<std::uint64_t>(a);
  // a_low * b as a 128-bit signed number: 64 + 62 bits fit
  const Int128 low = Int128(Int128(a_low) * b);
  return {a_high * b + (low >> 64), static_cast<std::uint64_t>(low)};
}

[[nodiscard]] constexpr Int192 add(const Int192& a, const Int192& b) noexcept {
  const std::uint64_t low = a.low + b.low;
  return {a.high + b.high + (low < a.low ? 1 : 0), low};
}

/// v * 2^bits for bits in [1, 63].
[[nodiscard]] constexpr Int192 shift_left(const Int192& v, int bits) noexcept {
  const auto carried = static_cast<std::uint64_t>(v.low >> (64 - bits));
  return {Int128((static_cast<Uint128>(v.high) << bits) | carried), v.low << bits};
}

/// The circumcenter c of the triangle t0 t1 t2 (counter-clockwise) against two points: +1 if q is nearer to c than p,
/// -1 if p is nearer, 0 if they are equally far. Exact for coordinates within kGridLimit.
[[nodiscard]] inline int nearer_to_circumcenter(const GridPoint& t0, const GridPoint& t1, const GridPoint& t2,
                                                const GridPoint& p, const GridPoint& q) noexcept {
  // With t0 as origin: c = (nx, ny) / (2 D), |c-p|^2 - |c-q|^2 = |p|^2 - |q|^2 - 2 c.(p-q).
  const std::int64_t bx = t1.x - t0.x, by = t1.y - t0.y, cx = t2.x - t0.x, cy = t2.y - t0.y;
  const std::int64_t px = p.x - t0.x, py = p.y - t0.y, qx = q.x - t0.x, qy = q.y - t0.y;
  const std::int64_t dx = px - qx, dy = py - qy;
  {
    // Filter: with u = 2^-53 and at most a dozen roundings the error is below 16 u times the sum of magnitudes.
    const double fbx = double(bx), fby = double(by), fcx = double(cx), fcy = double(cy);
    const double fpx = double(px), fpy = double(py), fqx = double(qx), fqy = double(qy);
    const double b2 = fbx * fbx + fby * fby, c2 = fcx * fcx + fcy * fcy;
    const double d_area = fbx * fcy - fby * fcx;
    const double a_area = std::fabs(fbx * fcy) + std::fabs(fby * fcx);
    const double p2 = fpx * fpx + fpy * fpy, q2 = fqx * fqx + fqy * fqy;
    const double nx = fcy * b2 - fby * c2, ny = fbx * c2 - fcx * b2;
    const double anx = std::fabs(fcy) * b2 + std::fabs(fby) * c2, any = std::fabs(fbx) * c2 + std::fabs(fcx) * b2;
    const double value = d_area * (p2 - q2) - (nx * double(dx) + ny * double(dy));
    const double magnitude = a_area * (p2 + q2) + anx * std::fabs(double(dx)) + any * std::fabs(double(dy));
    constexpr double kFilter = 16 * 0x1p-53;
    if (value > kFilter * magnitude) return 1;
    if (value < -kFilter * magnitude) return -1;
  }
  const Int128 b2 = Int128(bx) * bx + Int128(by) * by, c2 = Int128(cx) * cx + Int128(cy) * cy;
  const Int128 area = Int128(bx) * cy - Int128(by) * cx;
  const Int128 nx = cy * b2 - by * c2, ny = bx * c2 - cx * b2;
  const Int128 power = Int128(px) * px + Int128(py) * py - Int128(qx) * qx - Int128(qy) * qy;
  // power = high 2^40 + low with low in [0, 2^40), so that each product is one of 128 by 62 bits.
  const auto high = static_cast<std::int64_t>(power >> 40);
  const auto low = static_cast<std::int64_t>(power - Int128(high) * (Int128(1) << 40));
  const Int192 left = add(shift_left(multiply(area, high), 40), multiply(area, low));
  const Int192 right = add(multiply(nx, dx), multiply(ny, dy));
  if (right < left) return 1;
  if (left < right) return -1;
  return 0;
}

/// The midpoint of ab against two points: +1 if q is nearer than p, -1 if p is nearer, 0 if equally far; exact.
[[nodiscard]] constexpr int nearer_to_midpoint(const GridPoint& a, const GridPoint& b, const GridPoint& p,
                                               const GridPoint& q) noexcept {
  const Int128 px = p.x - a.x, py = p.y - a.y, qx = q.x - a.x, qy = q.y - a.y;
  return sign(px * px + py * py - qx * qx - qy * qy - (b.x - a.x) * (px - qx) - (b.y - a.y) * (py - qy));
}

/// Is v inside or on the circle with diameter ab? Exact.
[[nodiscard]] constexpr bool in_diametral_disc(const GridPoint& a, const GridPoint& b, const GridPoint& v) noexcept {
  return dot(v, a, b) <= 0;
}

}  // namespace slice2mesh::detail
