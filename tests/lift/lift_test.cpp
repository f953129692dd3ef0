// SPDX-License-Identifier: MIT
#include "slice2mesh/lift/lift.hpp"

#include <array>
#include <set>
#include <string>
#include <vector>

#include "plc/chain.hpp"
#include "slice2mesh/triangulate/plane_mesh.hpp"
#include "test_support.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;

namespace {

/// Twice the areas of the faces of a plane: by the cells below and above.
struct FaceAreas {
  detail::Int128 down = 0, up = 0, interface = 0;
};
FaceAreas face_areas(const InterfacePlane& plane) {
  FaceAreas areas;
  for (std::size_t e = 0; e < plane.overlay.edges.size(); ++e) {
    const GridPoint &p = plane.overlay.vertices[std::size_t(plane.overlay.edges[e].a)],
                    &q = plane.overlay.vertices[std::size_t(plane.overlay.edges[e].b)];
    const detail::Int128 term = detail::Int128(p.x) * q.y - detail::Int128(p.y) * q.x;
    for (const bool left : {true, false}) {
      const auto& cells = left ? plane.left[e] : plane.right[e];
      const detail::Int128 part = left ? term : -term;
      switch (classify(cells[0], cells[1])) {
        case FacetLabel::Down: areas.down += part; break;
        case FacetLabel::Up: areas.up += part; break;
        case FacetLabel::Interface: areas.interface += part; break;
        default: break;
      }
    }
  }
  return areas;
}
/// Twice the area inside of the lifted contour: along the paths of its edges.
detail::Int128 lifted_area(const InterfacePlane& plane, const Outline& outline,
                           const std::vector<std::vector<std::int32_t>>& paths) {
  detail::Int128 area = 0;
  for (std::size_t e = 0; e < paths.size(); ++e)
    for (std::size_t i = 0; i + 1 < paths[e].size(); ++i) {
      const GridPoint &p = plane.overlay.vertices[std::size_t(paths[e][i])],
                      &q = plane.overlay.vertices[std::size_t(paths[e][i + 1])];
      const detail::Int128 term = detail::Int128(p.x) * q.y - detail::Int128(p.y) * q.x;
      if (outline.edges[e].left != kNone) area += term;
      if (outline.edges[e].right != kNone) area -= term;
    }
  return area;
}

void check_plane(const Contours& contours, const InterfacePlane& plane, std::size_t& splits, std::size_t& overlaps) {
  const Outline nothing;
  const Outline& below = plane.slab_below == kNone ? nothing : contours.outlines[std::size_t(plane.slab_below)];
  const Outline& above = plane.slab_above == kNone ? nothing : contours.outlines[std::size_t(plane.slab_above)];
  std::set<std::pair<std::int32_t, std::int32_t>> edges;
  for (const Arrangement::Edge& e : plane.overlay.edges) edges.insert({e.a, e.b});
  REQUIRE(plane.left.size() == plane.overlay.edges.size());
  REQUIRE(plane.right.size() == plane.overlay.edges.size());
  const auto follow = [&](const Outline& outline, const std::vector<std::int32_t>& image,
                          const std::vector<std::vector<std::int32_t>>& paths) {
    REQUIRE(image.size() == outline.vertices.size());
    REQUIRE(paths.size() == outline.edges.size());
    for (std::size_t v = 0; v < image.size(); ++v)
      REQUIRE(plane.overlay.vertices[std::size_t(image[v])] == outline.vertices[v]);
    for (std::size_t e = 0; e < paths.size(); ++e) {
      const Outline::Edge& edge = outline.edges[e];
      const GridPoint &a = outline.vertices[std::size_t(edge.a)], &b = outline.vertices[std::size_t(edge.b)];
      REQUIRE(paths[e].front() == image[std::size_t(edge.a)]);
      REQUIRE(paths[e].back() == image[std::size_t(edge.b)]);
      detail::Int128 last = -1;
      for (std::size_t i = 0; i < paths[e].size(); ++i) {
        const GridPoint& p = plane.overlay.vertices[std::size_t(paths[e][i])];
        // A split is on its edge, up to rounding and to what is led through end points just beside.
        REQUIRE(detail::segment_distance(p, a, b) <= (kAttachSteps + 1) * double(kContourStep));
        const detail::Int128 along = detail::dot(a, b, p);
        REQUIRE(along > last);
        last = along;
        if (i > 0) REQUIRE(edges.count(std::minmax(paths[e][i - 1], paths[e][i])) == 1);
      }
      splits += paths[e].size() - 2;
    }
  };
  follow(below, plane.below_image, plane.below_path);
  follow(above, plane.above_image, plane.above_path);
  const FaceAreas areas = face_areas(plane);
  REQUIRE((areas.down >= 0 && areas.up >= 0 && areas.interface >= 0));
  REQUIRE(areas.down + areas.interface == lifted_area(plane, above, plane.above_path));
  REQUIRE(areas.up + areas.interface == lifted_area(plane, below, plane.below_path));
  overlaps += areas.interface > 0 ? 1U : 0U;
  // Cells are those of the slabs next to the plane.
  for (const auto* sides : {&plane.left, &plane.right})
    for (const auto& cells : *sides) {
      REQUIRE((cells[0].empty() || cells[0].slab == plane.slab_below));
      REQUIRE((cells[1].empty() || cells[1].slab == plane.slab_above));
    }
}

}  // namespace

TEST_CASE("down plus interface area is the contour above, up plus interface area the contour below, exactly") {
  std::size_t splits = 0, overlaps = 0, planes = 0;
  const auto check = [&](const SliceStack& stack, double eps) {
    ChainOptions options;
    options.eps = eps;
    options.interior = false;
    const Chain chain = run_chain(stack, options);
    for (const InterfacePlane& plane : chain.lifted) {
      check_plane(chain.contours, plane, splits, overlaps);
      ++planes;
    }
  };
  for (const NamedStack& named : generated_stacks()) {
    INFO(named.name);
    check(named.stack, 0.1);
  }
  for (std::uint32_t seed = 1; seed <= 6; ++seed)
    for (const double eps : {0.0, 0.1}) {
      INFO("seed " << seed << " eps " << eps);
      check(random_stack(seed), eps);
    }
  CHECK(planes > 50);
  CHECK(splits > 50);
  CHECK(overlaps > 30);
}

TEST_CASE("an overhang of known size has its areas to the last pitch") {
  ChainOptions options;
  options.eps = 0;
  const Chain chain = run_chain(stack_of({{rectangle(0, 0, 4, 4)}, {rectangle(2, 0, 6, 4)}}), options);
  REQUIRE(chain.lifted.size() == 3);
  const FaceAreas areas = face_areas(chain.lifted[1]);
  const double unit = chain.contours.grid.pitch * chain.contours.grid.pitch / 2;
  CHECK(double(areas.down) * unit == Approx(8));
  CHECK(double(areas.up) * unit == Approx(8));
  CHECK(double(areas.interface) * unit == Approx(8));
  CHECK(face_areas(chain.lifted[0]).up == 0);
  CHECK(double(face_areas(chain.lifted[0]).down) * unit == Approx(16));
  CHECK(double(face_areas(chain.lifted[2]).up) * unit == Approx(16));
}

TEST_CASE("slabs that touch share a plane, a gap has two") {
  const auto slab = [](double low, double high) {
    Slab s;
    s.z_low = low;
    s.z_high = high;
    return s;
  };
  std::vector<std::array<std::int32_t, 2>> of;
  const auto planes = plane_slabs({slab(0, 1), slab(1, 2), slab(3, 4)}, of);
  REQUIRE(planes.size() == 5);
  CHECK(planes[0] == std::make_pair(kNone, 0));
  CHECK(planes[1] == std::make_pair(0, 1));
  CHECK(planes[2] == std::make_pair(1, kNone));
  CHECK(planes[3] == std::make_pair(kNone, 2));
  CHECK(planes[4] == std::make_pair(2, kNone));
  CHECK(of == std::vector<std::array<std::int32_t, 2>>{{0, 1}, {1, 2}, {3, 4}});
}

TEST_CASE("the planes of the slice files carry the areas of their contours", "[corpus]") {
  std::size_t splits = 0, overlaps = 0;
  const auto files = small_corpus_files();
  for (const auto& path : files) {
    INFO(path.filename().string());
    ChainOptions options;
    options.interior = false;
    const Chain chain = run_chain(read_cli(path.string()), options);
    for (const InterfacePlane& plane : chain.lifted) check_plane(chain.contours, plane, splits, overlaps);
  }
  if (!files.empty()) CHECK(overlaps > 50);
}

TEST_CASE("what is so thin that it vanishes beside the contour of the next slab is an error with its place") {
  constexpr std::int64_t kLong = std::int64_t{1} << 36, kWide = std::int64_t{1} << 12, kSquare = kLong / 16;
  Contours contours;
  contours.slabs.resize(2);
  contours.regions.resize(1);
  contours.outlines.resize(2);
  contours.slabs[0].z_high = contours.slabs[1].z_low = 1;
  contours.slabs[1].z_high = 2;
  // A needle, and a square below its long edge: near the tip, where the planes cannot tell its sides apart, or not.
  contours.outlines[0].vertices = {{0, 0}, {kLong, 0}, {kLong, kWide}};
  contours.outlines[0].edges = {{0, 1, 0, kNone}, {0, 2, kNone, 0}, {1, 2, 0, kNone}};
  for (const std::int64_t from : {kSquare, kLong / 2}) {
    contours.outlines[1].vertices = {{from, -kSquare}, {from, 0}, {from + kSquare, -kSquare}, {from + kSquare, 0}};
    contours.outlines[1].edges = {{0, 1, kNone, 0}, {0, 2, 0, kNone}, {1, 3, kNone, 0}, {2, 3, 0, kNone}};
    CHECK_NOTHROW(lift(contours, kNone, 0));
    CHECK_NOTHROW(lift(contours, 1, kNone));
    if (from > kSquare) {
      CHECK_NOTHROW(lift(contours, 0, 1));
      continue;
    }
    try {
      (void)lift(contours, 0, 1);
      FAIL("the needle has not vanished");
    } catch (const TetrahedralizationError& error) {
      CHECK(error.slab() == 0);
      CHECK(std::string(error.what()).find(" mm") != std::string::npos);
    }
  }
}
