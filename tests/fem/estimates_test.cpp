// SPDX-License-Identifier: MIT
#include "slice2mesh/fem/estimates.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "io/sample_mesh.hpp"
#include "test_support.hpp"

using slice2mesh::estimate_slicing;
using slice2mesh::FinerSlice;
using slice2mesh::kNone;
using slice2mesh::Plc;
using slice2mesh::SlicingEstimates;
using slice2mesh_test::BoxSolid;

namespace {

/// A ramp: slab s is filled from x = 0 to `length(s)` squares.
template <class Length>
BoxSolid ramp(std::vector<double> thickness, Length length) {
  BoxSolid solid;
  solid.nx = 40;
  solid.ny = 2;
  solid.dx = 0.25;
  solid.dy = 1.5;
  solid.thickness = std::move(thickness);
  solid.region = [length](std::size_t x, std::size_t, std::size_t s) {
    return x < static_cast<std::size_t>(length(s)) ? 0 : kNone;
  };
  return solid;
}

}  // namespace

TEST_CASE("the staircase volume of an even ramp is that between the stairs and the ramp") {
  // Slabs of 0.5 mm, each 0.75 mm shorter than the one below, 3 mm wide: the ramp runs through the middles of the
  // walls, and cuts off a triangle of 0.375 x 0.25 mm below and above the middle of every slab.
  const SlicingEstimates found = estimate_slicing(
      slice2mesh_test::plc_of(ramp(std::vector<double>(8, 0.5), [](std::size_t s) { return 30 - 3 * s; })));
  REQUIRE(found.layers.size() == 8);
  const double triangle = 0.375 * 0.25 / 2 * 3;
  double sum = 0;
  for (std::size_t s = 0; s < 8; ++s) {
    const bool end = s == 0 || s == 7;
    CHECK(found.layers[s].staircase_volume == Approx((end ? 1 : 2) * triangle).epsilon(1e-14));
    CHECK(found.layers[s].area == Approx((30 - 3 * static_cast<double>(s)) * 0.25 * 3).epsilon(1e-14));
    CHECK(found.layers[s].perimeter == Approx(2 * ((30 - 3 * static_cast<double>(s)) * 0.25 + 3)).epsilon(1e-14));
    CHECK(found.layers[s].step_area == Approx(s == 7 ? 0 : 0.75 * 3).epsilon(1e-14));
    // The areas are linear: a finer slicing has the same volume.
    CHECK(std::fabs(found.layers[s].volume_loss) < 1e-14);
    CHECK_FALSE(found.layers[s].measured);
    sum += found.layers[s].staircase_volume;
  }
  CHECK(found.staircase_volume == Approx(sum).epsilon(1e-14));
}

TEST_CASE("thick and thin slabs share the staircase volume of an uneven ramp") {
  // 1 mm, 0.5 mm, 1.5 mm; the ramp loses 1 mm of length per 1 mm of height, so steps are 0.75 and 1 mm.
  const std::size_t length[] = {30, 27, 23};
  const SlicingEstimates found =
      estimate_slicing(slice2mesh_test::plc_of(ramp({1, 0.5, 1.5}, [&](std::size_t s) { return length[s]; })));
  // Over every step the ramp is a line of slope 1: triangles with legs of half the thickness.
  CHECK(found.layers[0].staircase_volume == Approx(0.5 * 0.5 / 2 * 3).epsilon(1e-14));
  CHECK(found.layers[1].staircase_volume == Approx(2 * 0.25 * 0.25 / 2 * 3).epsilon(1e-14));
  CHECK(found.layers[2].staircase_volume == Approx(0.75 * 0.75 / 2 * 3).epsilon(1e-14));
}

TEST_CASE("a part without slopes has no staircase and no loss") {
  const SlicingEstimates found =
      estimate_slicing(slice2mesh_test::plc_of(ramp({0.5, 0.25, 1}, [](std::size_t) { return 12; })));
  CHECK(found.staircase_volume == 0);
  CHECK(std::fabs(found.volume_loss) < 1e-15);
  CHECK(found.volume == Approx(12 * 0.25 * 3 * 1.75).epsilon(1e-14));
  for (const slice2mesh::LayerEstimate& layer : found.layers) CHECK(layer.cusp == 0);
}

TEST_CASE("the volume loss of a parabola of areas is that of halved layers") {
  // Lengths s^2: between the middles of slabs the area is the parabola 0.75 (z / h)^2, z from the middle of slab 0.
  const double h = 0.5;
  const SlicingEstimates found =
      estimate_slicing(slice2mesh_test::plc_of(ramp(std::vector<double>(7, h), [](std::size_t s) { return s * s; })));
  const auto area = [](double s) { return 0.75 * s * s; };
  for (std::size_t s = 2; s < 6; ++s) {
    const auto middle = static_cast<double>(s);
    const double halves = h / 2 * (area(middle - 0.25) + area(middle + 0.25));
    CHECK(found.layers[s].volume_loss == Approx(halves - h * area(middle)).epsilon(1e-10));
  }
  CHECK(found.layers[6].volume_loss == 0);
}

TEST_CASE("bundles are compared with the slices that they stand for") {
  // Two bundles of 1 mm for four slices of 0.5 mm.
  const BoxSolid solid = ramp({1, 1}, [](std::size_t s) { return s == 0 ? 20 : 16; });
  const Plc plc = slice2mesh_test::plc_of(solid);  // its slabs stand for three slices each
  const std::vector<FinerSlice> finer = {{0, 0.5, 16}, {0.5, 1, 14}, {1, 1.5, 12}, {1.5, 2, 11}};
  const SlicingEstimates found = estimate_slicing(plc, finer);
  CHECK(found.layers[0].measured);
  CHECK(found.layers[0].volume_loss == Approx(15 - 15).margin(1e-14));
  CHECK(found.layers[1].volume_loss == Approx(11.5 - 12).epsilon(1e-14));
  CHECK(found.volume_loss == Approx(-0.5).epsilon(1e-14));
  CHECK_FALSE(estimate_slicing(plc).layers[0].measured);
}

TEST_CASE("supports and base plates are no material of the estimates; real tops and bottoms are no steps") {
  for (const bool plate : {false, true}) {
    const BoxSolid solid = plate ? slice2mesh_test::plated_sample() : slice2mesh_test::stepped_sample();
    const std::size_t first = solid.plate_slabs;
    const SlicingEstimates found = estimate_slicing(slice2mesh_test::plc_of(solid));
    REQUIRE(found.layers.size() == first + 4);
    for (std::size_t s = 0; s < first; ++s) {
      CHECK(found.layers[s].area == 0);
      CHECK(found.layers[s].step_area == 0);
      CHECK(found.layers[s].staircase_volume == 0);
    }
    // Squares of the parts in each slab, counted, and where consecutive ones differ.
    const auto is_part = [&](std::size_t x, std::size_t y, std::size_t s) {
      const std::int32_t region = solid.at(x, y, s);
      return region == 0 || region == 2;
    };
    for (std::size_t s = first; s < first + 4; ++s) {
      double area = 0;
      double steps = 0;
      for (std::size_t x = 0; x < solid.nx; ++x)
        for (std::size_t y = 0; y < solid.ny; ++y) {
          area += is_part(x, y, s) ? solid.dx * solid.dy : 0;
          if (s + 1 < first + 4) steps += is_part(x, y, s) != is_part(x, y, s + 1) ? solid.dx * solid.dy : 0;
        }
      CHECK(found.layers[s].area == Approx(area).epsilon(1e-14));
      CHECK(found.layers[s].step_area == Approx(steps).epsilon(1e-14));
    }
    CHECK(found.layers[first + 1].step_area > 0);
  }
  Plc skin = slice2mesh_test::plc_of(slice2mesh_test::single_box());
  skin.has_inner_faces = false;
  CHECK_THROWS_AS(estimate_slicing(skin), slice2mesh::Error);
}
