// SPDX-License-Identifier: MIT
#include "slice2mesh/quality/tet_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>

#include "test_support.hpp"

namespace {

using slice2mesh::TetCorners;

constexpr double kPi = 3.14159265358979323846;

TetCorners regular_tet() {
  return {{{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}}};
}
TetCorners corner_tet() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
}

/// Circumradius by solving for the center with Cramer's rule, inradius from Heron's areas: nothing in common with the
/// formula under test.
double independent_ratio(const TetCorners& p) {
  using Real = long double;
  std::array<std::array<Real, 3>, 3> m{};
  std::array<Real, 3> right{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      m[i][k] = static_cast<Real>(p[i + 1][k]) - p[0][k];
      right[i] += m[i][k] * m[i][k] / 2;
    }
  const auto determinant = [](const std::array<std::array<Real, 3>, 3>& a) {
    return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) - a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
           a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
  };
  const Real whole = determinant(m);
  Real radius2 = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    auto replaced = m;
    for (std::size_t i = 0; i < 3; ++i) replaced[i][k] = right[i];
    const Real x = determinant(replaced) / whole;
    radius2 += x * x;
  }
  const auto distance = [&p](std::size_t i, std::size_t j) {
    Real sum = 0;
    for (std::size_t k = 0; k < 3; ++k)
      sum += (static_cast<Real>(p[i][k]) - p[j][k]) * (static_cast<Real>(p[i][k]) - p[j][k]);
    return std::sqrt(sum);
  };
  Real surface = 0;
  for (std::size_t f = 0; f < 4; ++f) {
    const Real a = distance((f + 1) % 4, (f + 2) % 4);
    const Real b = distance((f + 2) % 4, (f + 3) % 4);
    const Real c = distance((f + 3) % 4, (f + 1) % 4);
    const Real s = (a + b + c) / 2;
    surface += std::sqrt(std::max<Real>(0, s * (s - a) * (s - b) * (s - c)));
  }
  const Real inradius = 3 * std::fabs(whole) / 6 / surface;
  return static_cast<double>(std::sqrt(radius2) / (3 * inradius));
}

/// Dihedral angle at edge (i, j): angle between the other two vertices seen along the edge.
double independent_angle(const TetCorners& p, std::size_t i, std::size_t j, std::size_t k, std::size_t l) {
  using Vector = std::array<double, 3>;
  const auto minus = [](const Vector& a, const Vector& b) { return Vector{a[0] - b[0], a[1] - b[1], a[2] - b[2]}; };
  const auto dot = [](const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  const Vector e = minus(p[j], p[i]);
  const auto across = [&](std::size_t v) {
    const Vector d = minus(p[v], p[i]);
    const double along = dot(d, e) / dot(e, e);
    return minus(d, {e[0] * along, e[1] * along, e[2] * along});
  };
  const Vector u = across(k);
  const Vector v = across(l);
  return std::acos(dot(u, v) / std::sqrt(dot(u, u) * dot(v, v))) * 180 / kPi;
}

class RandomTets {
public:
  explicit RandomTets(std::uint32_t seed) : generator_(seed) {}
  /// A positive tet that is not nearly flat, so that the comparison formulas are accurate.
  TetCorners next() {
    for (;;) {
      TetCorners p;
      for (auto& corner : p)
        for (double& x : corner) x = uniform_(generator_);
      if (slice2mesh::signed_volume(p) < 0) std::swap(p[0], p[1]);
      if (slice2mesh::signed_volume(p) > 0.01) return p;
    }
  }

private:
  std::mt19937 generator_;
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

}  // namespace

TEST_CASE("R/3r is 1 for the regular tet and all its dihedral angles are arccos(1/3)") {
  CHECK(slice2mesh::radius_ratio(regular_tet()) == Approx(1).epsilon(1e-14));
  for (const double angle : slice2mesh::dihedral_angles(regular_tet()))
    CHECK(angle == Approx(std::acos(1.0 / 3) * 180 / kPi).epsilon(1e-14));
}

TEST_CASE("the corner of a cube has R/3r = (3 + sqrt 3) sqrt 3 / 6 and three right dihedral angles") {
  // R = sqrt(3)/2, r = (3 - sqrt(3))/6.
  CHECK(slice2mesh::radius_ratio(corner_tet()) == Approx((3 + std::sqrt(3.0)) * std::sqrt(3.0) / 6).epsilon(1e-14));
  const std::array<double, 6> angles = slice2mesh::dihedral_angles(corner_tet());
  for (std::size_t e = 0; e < 3; ++e) CHECK(angles[e] == Approx(90).epsilon(1e-14));
  for (std::size_t e = 3; e < 6; ++e) CHECK(angles[e] == Approx(std::acos(1 / std::sqrt(3.0)) * 180 / kPi));
  CHECK(slice2mesh::signed_volume(corner_tet()) == Approx(1.0 / 6).epsilon(1e-15));
}

TEST_CASE("flat and inverted tets have an infinite R/3r") {
  TetCorners flat = corner_tet();
  flat[3] = {0.3, 0.3, 0};
  CHECK(std::isinf(slice2mesh::radius_ratio(flat)));
  TetCorners inverted = corner_tet();
  std::swap(inverted[0], inverted[1]);
  CHECK(std::isinf(slice2mesh::radius_ratio(inverted)));
  CHECK(slice2mesh::signed_volume(inverted) == Approx(-1.0 / 6));
  const TetCorners point = {{{1, 2, 3}, {1, 2, 3}, {1, 2, 3}, {1, 2, 3}}};
  CHECK(std::isinf(slice2mesh::radius_ratio(point)));
}

TEST_CASE("R/3r and dihedral angles of random tets equal those of independent formulas") {
  const std::uint32_t seed = 20240501;
  INFO("seed " << seed);
  RandomTets tets(seed);
  for (int i = 0; i < 2000; ++i) {
    const TetCorners p = tets.next();
    REQUIRE(slice2mesh::radius_ratio(p) == Approx(independent_ratio(p)).epsilon(1e-11));
    REQUIRE(slice2mesh::radius_ratio(p) >= 1 - 1e-14);
    const std::array<double, 6> angles = slice2mesh::dihedral_angles(p);
    for (std::size_t e = 0; e < 6; ++e) {
      const auto& edge = slice2mesh::kTetEdgeVertices[e];
      const auto& opposite = slice2mesh::kTetEdgeVertices[5 - e];
      REQUIRE(angles[e] == Approx(independent_angle(p, edge[0], edge[1], opposite[0], opposite[1])).margin(1e-5));
    }
  }
}

TEST_CASE("R/3r does not depend on size, place, rotation about z or an even reordering of the corners") {
  const std::uint32_t seed = 7;
  INFO("seed " << seed);
  RandomTets tets(seed);
  for (int i = 0; i < 500; ++i) {
    const TetCorners p = tets.next();
    const double ratio = slice2mesh::radius_ratio(p);
    for (const double scale : {1e-6, 0.125, 3.0, 1e6}) {
      TetCorners q = p;
      for (auto& corner : q)
        for (double& x : corner) x *= scale;
      REQUIRE(slice2mesh::radius_ratio(q) == Approx(ratio).epsilon(1e-12));
    }
    TetCorners moved = p;
    for (auto& corner : moved) corner = {-corner[1] + 100, corner[0] - 50, corner[2] + 8};
    REQUIRE(slice2mesh::radius_ratio(moved) == Approx(ratio).epsilon(1e-10));
    REQUIRE(slice2mesh::radius_ratio({{p[1], p[2], p[0], p[3]}}) == Approx(ratio).epsilon(1e-12));
    REQUIRE(slice2mesh::radius_ratio({{p[3], p[2], p[1], p[0]}}) == Approx(ratio).epsilon(1e-12));
    REQUIRE(std::isinf(slice2mesh::radius_ratio({{p[1], p[0], p[2], p[3]}})));
  }
}

TEST_CASE("the figures of slivers and needles far from the origin stay accurate") {
  // A square of side 2 whose diagonals are s apart in height: all four heights are about s. The place is a multiple of
  // the smallest coordinate step, so that the exact tet does not change with it.
  for (const double s : {0.5, 1.0 / 1024, 1.0 / (1 << 20)}) {
    for (const double place : {0.0, 512.0}) {
      const TetCorners p = {{{place + 1, place, place},
                             {place - 1, place, place},
                             {place, place - 1, place + s},
                             {place, place + 1, place + s}}};
      // Circumcenter on the axis by symmetry at height s/2: R^2 = 1 + s^2/4; r = 3V/S, V = 2s/3, S = 4 sqrt(1 + s^2).
      const double exact = std::sqrt(1 + s * s / 4) / (3 * (2 * s / (4 * std::sqrt(1 + s * s))));
      REQUIRE(slice2mesh::signed_volume(p) > 0);
      CHECK(slice2mesh::radius_ratio(p) == Approx(exact).epsilon(1e-12));
      const std::array<double, 6> angles = slice2mesh::dihedral_angles(p);
      // The edges on the two planes see each other at an angle of 180 degrees minus twice arctan(s).
      CHECK(*std::max_element(angles.begin(), angles.end()) ==
            Approx(180 - 2 * std::atan(s) * 180 / kPi).epsilon(1e-13));
    }
  }
}
