// SPDX-License-Identifier: MIT
#include "slice2mesh/quality/volume_error.hpp"

#include <vector>

#include "plc/chain.hpp"
#include "test_support.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;

namespace {

/// A square with its corner in the origin, pitches.
Outline square(std::int64_t side) {
  Outline outline;
  outline.vertices = {{0, 0}, {side, 0}, {side, side}, {0, side}};
  for (std::int32_t i = 0; i < 4; ++i) outline.edges.push_back({i, (i + 1) % 4, 0, kNone});
  return outline;
}
std::vector<Slab> slabs_of(const std::vector<double>& heights) {
  std::vector<Slab> slabs;
  double z = 0;
  for (const double height : heights) {
    Slab slab;
    slab.z_low = z;
    slab.z_high = z += height;
    slabs.push_back(slab);
  }
  return slabs;
}

}  // namespace

TEST_CASE("the volume error is that of the sum over the slabs, each with its own thickness") {
  Grid grid;
  grid.pitch = 0.25;
  // 100 mm^2 and 25 mm^2, 2 mm and 4 mm high.
  const VolumeError error = measure_volume_error({square(40), square(20)}, grid, slabs_of({2, 4}), {202, 97});
  CHECK(error.slices == Approx(300));
  CHECK(error.error == Approx(-1.0 / 300));
  REQUIRE(error.slab_error.size() == 2);
  CHECK(error.slab_error[0] == Approx(0.01));
  CHECK(error.slab_error[1] == Approx(-0.03));
  CHECK(error.worst_slab == 1);
  // Areas of 1 mm^2 more along 40 mm, and 0.75 mm^2 less along 20 mm.
  REQUIRE(error.slab_shift.size() == 2);
  CHECK(error.slab_shift[0] == Approx(1.0 / 40));
  CHECK(error.slab_shift[1] == Approx(-0.75 / 20));
}

TEST_CASE("slabs that the mesh does not have, and slices without area, have a volume error all the same") {
  const VolumeError lost = measure_volume_error({square(10), square(10)}, {}, slabs_of({1, 1}), {100});
  CHECK(lost.error == Approx(-0.5));
  CHECK(lost.slab_error.back() == -1);
  CHECK(lost.worst_slab == 1);
  const VolumeError none = measure_volume_error({}, {}, {}, {});
  CHECK(none.error == 0);
  CHECK(none.worst_slab == -1);
  const VolumeError empty = measure_volume_error({Outline{}}, {}, slabs_of({1}), {0});
  CHECK(empty.error == 0);
  CHECK(empty.slab_error == std::vector<double>{0});
  CHECK(empty.slab_shift == std::vector<double>{0});
}

TEST_CASE("holes and regions that touch count once, and the whole of a mesh that keeps its slices has no error") {
  const Chain chain = run_chain(stack_of({{rectangle(0, 0, 8, 6), rectangle(2, 2, 4, 4, Direction::Inner)},
                                          {rectangle(0, 0, 8, 6), rectangle(2, 2, 4, 4, Direction::Inner)}}));
  const VolumeError error =
      measure_volume_error(chain.regions.outlines, chain.regions.grid, chain.regions.slabs, {22, 22});
  CHECK(error.slices == Approx(44).epsilon(1e-9));
  CHECK(error.error == Approx(0).margin(1e-9));
}
