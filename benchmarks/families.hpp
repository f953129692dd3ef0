// SPDX-License-Identifier: MIT
/// @file
/// @brief Generated slices for the benchmarks: families in which one number varies, all else being equal.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "slice2mesh/core/slice_stack.hpp"

namespace slice2mesh_benchmarks {

/// A wavy ring in layers of 1 mm. Contour edges are about as long as a layer is thick and the ring has the same width
/// whatever its number of points, so that the volume grows in proportion to `points * layers`.
struct Ring {
  int points = 256;   ///< of the outer contour, at least 48; the inner one has as many as its length asks for
  int layers = 8;     ///< of 1 mm
  double slope = 0;   ///< mm by which the ring is shifted from layer to layer
  double noise = 0;   ///< mm, largest displacement of each point of each layer, along both axes
  double width = 6;   ///< mm
  double waves = 12;  ///< of the outer contour, 0.5 mm high
};

/// The slices of a ring. The same numbers give the same slices.
inline slice2mesh::SliceStack slices_of(const Ring& ring) {
  constexpr double kPi = 3.14159265358979323846;
  std::mt19937 random(20240229);  // the raw numbers are the same everywhere, unlike those of the distributions
  const auto noise = [&random, &ring] { return ring.noise * (2 * (static_cast<double>(random()) / 4294967295.0) - 1); };
  const double radius = ring.points / (2 * kPi);
  const auto contour = [&](double at, double wave, int points, bool inner, double shift) {
    slice2mesh::Polyline line;
    line.direction = inner ? slice2mesh::Direction::Inner : slice2mesh::Direction::Outer;
    for (int i = 0; i < points; ++i) {
      const double angle = (inner ? -2 : 2) * kPi * i / points;
      const double r = at + wave * std::cos(ring.waves * angle);
      line.points.push_back({r * std::cos(angle) + shift + noise(), r * std::sin(angle) + noise()});
    }
    return line;
  };
  slice2mesh::SliceStack stack;
  stack.layers.emplace_back();  // z = 0, empty: gives the thickness of the first layer
  for (int k = 0; k < ring.layers; ++k) {
    slice2mesh::Layer layer;
    layer.z = k + 1;
    layer.polylines.push_back(contour(radius, 0.5, ring.points, false, k * ring.slope));
    const double inner = radius - ring.width;
    layer.polylines.push_back(contour(inner, 0, static_cast<int>(2 * kPi * inner), true, k * ring.slope));
    stack.layers.push_back(layer);
  }
  return stack;
}

/// One member of a family: `name` is "points:256".
struct Member {
  std::string family;
  std::string name;
  Ring ring;
};

/// All members of all families; `tiny`: one small member of each, to see that everything runs.
inline std::vector<Member> members(bool tiny) {
  std::vector<Member> all;
  const auto add = [&all](const std::string& family, const std::string& value, const Ring& ring) {
    all.push_back({family, family + ":" + value, ring});
  };
  const auto base = [tiny] {
    Ring ring;
    if (tiny) {
      ring.points = 48;
      ring.layers = 2;
      ring.width = 3;
      ring.waves = 4;
    }
    return ring;
  };
  const auto counts = [tiny](std::vector<int> values) { return tiny ? std::vector<int>{values.front()} : values; };
  for (const int points : counts({64, 128, 256, 512, 1024})) {
    Ring ring = base();
    ring.points = points;
    add("points", std::to_string(points), ring);
  }
  for (const int layers : counts({2, 4, 8, 16, 32})) {
    Ring ring = base();
    ring.layers = layers;
    add("layers", std::to_string(layers), ring);
  }
  // In hundredths of a mm, that is, of the layer thickness.
  for (const int slope : tiny ? std::vector<int>{20} : std::vector<int>{0, 1, 5, 10, 20, 50, 100, 200}) {
    Ring ring = base();
    ring.slope = slope / 100.0;
    add("slope", std::to_string(slope), ring);
  }
  for (const int amount : tiny ? std::vector<int>{5} : std::vector<int>{0, 1, 2, 5, 10, 20}) {
    Ring ring = base();
    ring.noise = amount / 100.0;
    add("noise", std::to_string(amount), ring);
  }
  return all;
}

}  // namespace slice2mesh_benchmarks
