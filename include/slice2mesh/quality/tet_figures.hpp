// SPDX-License-Identifier: MIT
/// @file
/// @brief Figures of one tetrahedron: R/3r, dihedral angles, edges, volume.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace slice2mesh {

/// The four corners of a tet, 4 by 3: x, y, z in mm.
using TetCorners = std::array<std::array<double, 3>, 4>;

/// 6 by 2: indices (0 to 3) of the vertices of the six edges. Edge e is the common edge of the faces opposite to the
/// vertices of edge 5 - e.
inline constexpr std::array<std::array<std::size_t, 2>, 6> kTetEdgeVertices = {
    {{{0, 1}}, {{0, 2}}, {{0, 3}}, {{1, 2}}, {{1, 3}}, {{2, 3}}}};

namespace detail {

/// a * b - c * d with an error of about one rounding of the result (Kahan; a fused multiply-add finds the rounding
/// error of the second product).
[[nodiscard]] inline double difference_of_products(double a, double b, double c, double d) {
  const double cd = c * d;
  const double error = std::fma(-c, d, cd);
  return std::fma(a, b, -cd) + error;
}

using Vector3 = std::array<double, 3>;

[[nodiscard]] inline Vector3 minus(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
[[nodiscard]] inline Vector3 careful_cross(const Vector3& a, const Vector3& b) {
  return {difference_of_products(a[1], b[2], a[2], b[1]), difference_of_products(a[2], b[0], a[0], b[2]),
          difference_of_products(a[0], b[1], a[1], b[0])};
}
[[nodiscard]] inline double inner(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
[[nodiscard]] inline double length(const Vector3& a) {
  return std::sqrt(inner(a, a));
}

/// What all figures are made of.
struct TetFrame {
  std::array<Vector3, 4> normal;         ///< outward normal of the face opposite to vertex i, twice the area long
  std::array<double, 6> squared_length;  ///< of the edges, in the order of kTetEdgeVertices
  double determinant;                    ///< six times the volume
  double radius_ratio;                   ///< R/3r; infinity unless the determinant is positive
};

/// Differences are taken from the vertex whose three edges are shortest: there they cancel least.
[[nodiscard]] inline TetFrame tet_frame(const TetCorners& p) {
  TetFrame frame;
  for (std::size_t e = 0; e < 6; ++e) {
    const Vector3 edge = minus(p[kTetEdgeVertices[e][1]], p[kTetEdgeVertices[e][0]]);
    frame.squared_length[e] = inner(edge, edge);
  }
  const std::array<double, 6>& l = frame.squared_length;
  const std::array<double, 4> reach = {l[0] + l[1] + l[2], l[0] + l[3] + l[4], l[1] + l[3] + l[5], l[2] + l[4] + l[5]};
  const auto base = static_cast<std::size_t>(std::min_element(reach.begin(), reach.end()) - reach.begin());
  // Even permutations keep the sign of the volume.
  constexpr std::array<std::array<std::size_t, 4>, 4> kOrder = {
      {{{0, 1, 2, 3}}, {{1, 0, 3, 2}}, {{2, 3, 0, 1}}, {{3, 2, 1, 0}}}};
  const std::array<std::size_t, 4>& o = kOrder[base];
  const Vector3 a = minus(p[o[1]], p[o[0]]);
  const Vector3 b = minus(p[o[2]], p[o[0]]);
  const Vector3 c = minus(p[o[3]], p[o[0]]);
  const Vector3 na = careful_cross(c, b);
  const Vector3 nb = careful_cross(a, c);
  const Vector3 nc = careful_cross(b, a);
  frame.normal[o[0]] = careful_cross(minus(p[o[2]], p[o[1]]), minus(p[o[3]], p[o[1]]));
  frame.normal[o[1]] = na;
  frame.normal[o[2]] = nb;
  frame.normal[o[3]] = nc;
  frame.determinant = -inner(a, na);
  frame.radius_ratio = std::numeric_limits<double>::infinity();
  if (frame.determinant > 0) {
    // The circumcenter seen from the base is `center` over twice the determinant; the inradius is the determinant over
    // the sum of the doubled face areas.
    const double a2 = inner(a, a);
    const double b2 = inner(b, b);
    const double c2 = inner(c, c);
    Vector3 center;
    for (std::size_t i = 0; i < 3; ++i) center[i] = a2 * na[i] + b2 * nb[i] + c2 * nc[i];
    double areas = 0;
    for (const Vector3& n : frame.normal) areas += length(n);
    frame.radius_ratio = (length(center) / frame.determinant) * (areas / frame.determinant) / 6;
  }
  return frame;
}

/// Cotangent of the dihedral angle at edge e. Precondition: positive determinant.
[[nodiscard]] inline double dihedral_cotangent(const TetFrame& frame, std::size_t e) {
  const std::array<std::size_t, 2>& faces = kTetEdgeVertices[5 - e];
  return -inner(frame.normal[faces[0]], frame.normal[faces[1]]) /
         (std::sqrt(frame.squared_length[e]) * frame.determinant);
}

inline constexpr double kDegrees = 57.295779513082320876798;  ///< of one radian

/// Angle in degrees, 0 to 180, of a cotangent.
[[nodiscard]] inline double angle_of_cotangent(double cotangent) {
  return std::isinf(cotangent) ? (cotangent > 0 ? 0 : 180) : std::atan2(1, cotangent) * kDegrees;
}

}  // namespace detail

/// R/3r: circumradius over three times the inradius. 1 for the regular tet, larger for all others; infinity for a tet
/// that is flat or inverted. Relative error about 1e-15 times the longest over the shortest height of the tet.
[[nodiscard]] inline double radius_ratio(const TetCorners& corners) {
  return detail::tet_frame(corners).radius_ratio;
}

/// The dihedral angles at the six edges in degrees, in the order of kTetEdgeVertices. All 0 for a flat or inverted tet.
[[nodiscard]] inline std::array<double, 6> dihedral_angles(const TetCorners& corners) {
  const detail::TetFrame frame = detail::tet_frame(corners);
  std::array<double, 6> angles{};
  if (frame.determinant > 0)
    for (std::size_t e = 0; e < 6; ++e) angles[e] = detail::angle_of_cotangent(detail::dihedral_cotangent(frame, e));
  return angles;
}

/// Lengths of the six edges, mm, in the order of kTetEdgeVertices.
[[nodiscard]] inline std::array<double, 6> edge_lengths(const TetCorners& corners) {
  std::array<double, 6> lengths = detail::tet_frame(corners).squared_length;
  for (double& l : lengths) l = std::sqrt(l);
  return lengths;
}

/// Volume, mm^3; negative for an inverted tet.
[[nodiscard]] inline double signed_volume(const TetCorners& corners) {
  return detail::tet_frame(corners).determinant / 6;
}

}  // namespace slice2mesh
