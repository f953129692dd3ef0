// SPDX-License-Identifier: MIT
/// @file
/// @brief Random slices whose contours cross at small angles.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "plc/chain.hpp"
#include "test_support.hpp"

namespace slice2mesh_test {

/// Slices with a corner in the same directions, each as far from the middle as it happens to be.
inline slice2mesh::SliceStack wobbling_stack(std::uint32_t seed) {
  using namespace slice2mesh;
  std::mt19937 random(seed);
  const auto real = [&](double low, double high) { return low + (high - low) * double(random()) / 0x1p32; };
  const auto corners = std::size_t(real(6, 24)), layers = std::size_t(real(3, 10));
  const double radius = real(2, 5), wobble = real(0.02, 0.15);
  std::vector<double> from_middle(corners);
  for (double& r : from_middle) r = radius * real(0.6, 1);
  std::vector<std::vector<Polyline>> slices(layers);
  for (std::vector<Polyline>& slice : slices) {
    std::vector<Point2> points;
    for (std::size_t i = 0; i < corners; ++i) {
      const double angle = 2 * detail::kPi * double(i) / double(corners),
                   r = from_middle[i] + (random() % 3 == 0 ? 0 : real(-wobble, wobble));
      points.push_back({r * std::cos(angle), r * std::sin(angle)});
    }
    slice.push_back(loop(std::move(points)));
  }
  return stack_of(std::move(slices));
}

}  // namespace slice2mesh_test
