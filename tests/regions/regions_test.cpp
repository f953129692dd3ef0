// SPDX-License-Identifier: MIT
#include "slice2mesh/regions/regions.hpp"

#include <CGAL/Boolean_set_operations_2.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Polygon_set_2.h>

#include <cmath>
#include <cstdint>
#include <list>
#include <map>
#include <string>
#include <vector>

#include "plc/chain.hpp"
#include "test_support.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;

namespace {

constexpr double kPi = 3.14159265358979323846;

LayerRegions regions_of(const std::vector<Polyline>& slice, double radius = 0, Diagnostics* out = nullptr,
                        LineCap cap = LineCap::Square) {
  Diagnostics diagnostics;
  const SliceStack stack = stack_of({slice});
  SlabOptions slab_options;
  slab_options.thickness = 1;
  ThickenOptions options;
  options.radius = Length::mm(radius);
  options.cap = cap;
  LayerRegions result = build_regions(stack, make_slabs(stack, slab_options, diagnostics), options, diagnostics);
  if (out != nullptr) *out = diagnostics;
  return result;
}

double area_of(const LayerRegions& regions, std::int32_t region = kNone) {
  REQUIRE(regions.outlines.size() == 1);
  return double(detail::doubled_area(regions.outlines[0], region)) / 2 * regions.grid.pitch * regions.grid.pitch;
}

/// Edges separate different regions, do not repeat, and vertices are all used.
void check_outline(const Outline& outline) {
  std::vector<int> used(outline.vertices.size(), 0);
  for (const Outline::Edge& e : outline.edges) {
    REQUIRE(e.left != e.right);
    REQUIRE(outline.vertices[std::size_t(e.a)] != outline.vertices[std::size_t(e.b)]);
    ++used[std::size_t(e.a)];
    ++used[std::size_t(e.b)];
  }
  for (const int n : used) REQUIRE(n >= 2);
  std::vector<TaggedSegment> segments;
  detail::append_segments(outline, 0, segments);
  const Arrangement again = snap_round(segments);
  REQUIRE(again.crossings == 0);
  REQUIRE(again.vertices.size() == outline.vertices.size());
  REQUIRE(again.edges.size() == outline.edges.size());
}

using Exact = CGAL::Exact_predicates_exact_constructions_kernel;
using ExactPolygon = CGAL::Polygon_2<Exact>;
using ExactSet = CGAL::Polygon_set_2<Exact>;

ExactPolygon exact_polygon(const Polyline& line) {
  ExactPolygon polygon;
  for (const Point2& p : line.points) polygon.push_back(Exact::Point_2(p.x, p.y));
  if (polygon.is_clockwise_oriented()) polygon.reverse_orientation();
  return polygon;
}
double exact_area(const ExactSet& set) {
  std::list<CGAL::Polygon_with_holes_2<Exact>> parts;
  set.polygons_with_holes(std::back_inserter(parts));
  Exact::FT area = 0;
  for (const auto& part : parts) {
    area += part.outer_boundary().area();
    for (auto hole = part.holes_begin(); hole != part.holes_end(); ++hole) area += hole->area();
  }
  return CGAL::to_double(area);
}

}  // namespace

TEST_CASE("the area of a union is that of an exact boolean operation") {
  int overlapping = 0;
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    INFO("seed " << seed);
    const std::vector<Polyline> slice = random_stack(seed, 1).layers[0].polylines;
    ExactSet set;
    double sum = 0;
    for (const Polyline& line : slice) {
      const ExactPolygon polygon = exact_polygon(line);
      REQUIRE(polygon.is_simple());
      sum += CGAL::to_double(polygon.area());
      set.join(polygon);
    }
    const double expected = exact_area(set);
    overlapping += sum > expected * 1.001 ? 1 : 0;
    const LayerRegions regions = regions_of(slice);
    check_outline(regions.outlines[0]);
    CHECK(area_of(regions) == Approx(expected).epsilon(1e-6));
  }
  CHECK(overlapping > 3);
}

TEST_CASE("inner loops cut holes, outer loops inside of them are islands") {
  const std::vector<Polyline> slice{rectangle(0, 0, 8, 8), rectangle(1, 1, 7, 7, Direction::Inner),
                                    rectangle(3, 3, 5, 5)};
  const LayerRegions regions = regions_of(slice);
  check_outline(regions.outlines[0]);
  CHECK(area_of(regions) == Approx(64 - 36 + 4).epsilon(1e-7));
  CHECK(regions.regions.size() == 1);
  CHECK(regions.outlines[0].edges.size() == 12);
}

TEST_CASE("what stands twice, has no length or no area changes nothing") {
  const Polyline square = rectangle(0, 0, 2, 3);
  Polyline stutter = square;
  stutter.points.insert(stutter.points.begin() + 1, stutter.points[1]);
  stutter.points.insert(stutter.points.begin(), {0, 0});
  const Outline plain = regions_of({square}).outlines[0];
  const auto same = [&](const std::vector<Polyline>& slice) {
    const Outline other = regions_of(slice).outlines[0];
    return other.vertices == plain.vertices && other.edges.size() == plain.edges.size();
  };
  CHECK(same({square, square}));
  CHECK(same({stutter}));
  CHECK(same({square, loop({{0.5, 1}, {1, 1}})}));
  CHECK(same({square, loop({{1, 1}})}));
  CHECK_FALSE(same({rectangle(0, 0, 2, 2.5), loop({{1, 1}, {2, 1}})}));
}

TEST_CASE("a loop that crosses itself bounds all that it surrounds") {
  const LayerRegions regions = regions_of({loop({{0, 0}, {2, 2}, {2, 0}, {0, 2}})});
  check_outline(regions.outlines[0]);
  CHECK(area_of(regions) == Approx(2).epsilon(1e-6));
  // The direction of a loop does not matter, its kind does.
  Polyline reversed = rectangle(0, 0, 2, 3);
  std::reverse(reversed.points.begin(), reversed.points.end());
  CHECK(area_of(regions_of({reversed})) == Approx(6).epsilon(1e-7));
}

TEST_CASE("the union does not depend on the order of the loops") {
  for (std::uint32_t seed = 20; seed < 26; ++seed) {
    INFO("seed " << seed);
    std::vector<Polyline> slice = random_stack(seed, 1).layers[0].polylines;
    slice.push_back(rectangle(2, 2, 3, 3, Direction::Inner));
    const Outline expected = regions_of(slice).outlines[0];
    std::reverse(slice.begin(), slice.end());
    const Outline other = regions_of(slice).outlines[0];
    CHECK(other.vertices == expected.vertices);
    CHECK(other.edges.size() == expected.edges.size());
  }
}

TEST_CASE("where supports and object overlap, the area belongs to the object, and supports keep the rest") {
  Polyline line;
  line.direction = Direction::Open;
  line.points = {{-3, 1}, {5, 1}};
  Diagnostics diagnostics;
  const LayerRegions regions = regions_of({rectangle(0, 0, 2, 2), line}, 0.25, &diagnostics, LineCap::Flat);
  check_outline(regions.outlines[0]);
  REQUIRE(regions.regions.size() == 2);
  CHECK(regions.regions[0].kind == RegionKind::Part);
  CHECK(regions.regions[1].kind == RegionKind::Support);
  CHECK(area_of(regions, 0) == Approx(4).epsilon(1e-6));
  CHECK(area_of(regions, 1) == Approx(6 * 0.5).epsilon(1e-6));
  CHECK(area_of(regions) == Approx(7).epsilon(1e-6));
  CHECK(diagnostics.count("regions_overlap") == 1);
}

TEST_CASE("lower part ids go before higher ones") {
  const LayerRegions regions =
      regions_of({rectangle(1, 0, 3, 2, Direction::Outer, 7), rectangle(0, 0, 2, 2, Direction::Outer, 3)});
  REQUIRE(regions.regions.size() == 2);
  CHECK(regions.regions[0].part == 3);
  CHECK(area_of(regions, 0) == Approx(4).epsilon(1e-6));
  CHECK(area_of(regions, 1) == Approx(2).epsilon(1e-6));
}

TEST_CASE("a thickened line has the area of its strip and its ends") {
  Polyline line;
  line.direction = Direction::Open;
  line.points = {{0, 0}, {3, 4}};
  const double radius = 0.5, length = 5;
  CHECK(area_of(regions_of({line}, radius, nullptr, LineCap::Flat)) == Approx(2 * radius * length).epsilon(1e-6));
  CHECK(area_of(regions_of({line}, radius, nullptr, LineCap::Square)) ==
        Approx(2 * radius * (length + 2 * radius)).epsilon(1e-6));
  const double round = area_of(regions_of({line}, radius, nullptr, LineCap::Round));
  CHECK(round <= 2 * radius * length + kPi * radius * radius);
  CHECK(round >= 2 * radius * length + 0.85 * kPi * radius * radius);
}

TEST_CASE("each support line has the radius of its part, or the one that it is given for itself") {
  // Straight walls that do not touch: areas tell which line became how wide. With flat ends 2 r times the length.
  const double length = 5;
  std::vector<Polyline> lines;
  for (std::int32_t part : {1, 2, 2, 3}) {
    Polyline line;
    line.part = part;
    line.direction = Direction::Open;
    const double x = 3.0 * static_cast<double>(lines.size());
    line.points = {{x, 0}, {x, length}};
    lines.push_back(line);
  }
  const SliceStack stack = stack_of({lines});
  SlabOptions slab_options;
  slab_options.thickness = 0.5;
  Diagnostics diagnostics;
  const SlabPlan plan = make_slabs(stack, slab_options, diagnostics);
  ThickenOptions options;
  options.cap = LineCap::Flat;
  options.radius = Length::mm(0.25);
  options.part_radius = {{2, Length::layers(1)}, {3, Length::mm(0)}, {99, Length::mm(1)}};
  const auto areas = [&] {
    diagnostics = {};
    const LayerRegions regions = build_regions(stack, plan, options, diagnostics);
    std::map<std::int32_t, double> result;
    for (std::size_t r = 0; r < regions.regions.size(); ++r)
      result[regions.regions[r].part] = area_of(regions, static_cast<std::int32_t>(r));
    return result;
  };
  auto found = areas();
  CHECK(found.size() == 2);
  CHECK(found[1] == Approx(2 * 0.25 * length).epsilon(1e-9));
  CHECK(found[2] == Approx(2 * 2 * 0.5 * length).epsilon(1e-9));
  CHECK(diagnostics.count("supports_left_out") == 1);

  options.line_radius = [&lines](const Polyline& line, std::int32_t layer) {
    CHECK(layer == 0);
    return Length::mm(line == lines[1] ? 0.125 : line == lines[3] ? 0.5 : 0.0);
  };
  found = areas();
  CHECK(found.size() == 2);
  CHECK(found[2] == Approx(2 * 0.125 * length).epsilon(1e-9));
  CHECK(found[3] == Approx(2 * 0.5 * length).epsilon(1e-9));
  CHECK(diagnostics.count("supports_left_out") == 2);
}

TEST_CASE("radii that are no lengths are refused, with the name of the option") {
  Polyline line;
  line.part = 4;
  line.direction = Direction::Open;
  line.points = {{0, 0}, {1, 0}};
  const auto option_of = [&line](const ThickenOptions& options) {
    try {
      (void)support_radius(options, line, 0, 1);
      detail::check_support_radii(options, 1);
    } catch (const OptionError& error) {
      return error.option();
    }
    return std::string("none");
  };
  for (const double bad : {-1.0, HUGE_VAL, std::nan("")}) {
    ThickenOptions options;
    CHECK(option_of(options) == "none");
    options.part_radius[4] = Length::mm(bad);
    CHECK(option_of(options) == "supports.part_radius");
    options.part_radius = {{5, Length::mm(bad)}};  // also where no line has the part id
    CHECK(option_of(options) == "supports.part_radius");
    options.line_radius = [bad](const Polyline&, std::int32_t) { return Length::layers(bad); };
    CHECK(option_of(options) == "supports.line_radius");
    options = {};
    options.radius = Length::mm(bad);
    CHECK(option_of(options) == "supports.radius");
  }
}

TEST_CASE("without a support radius open lines are left out, and this is said") {
  Polyline line;
  line.direction = Direction::Open;
  line.points = {{-3, 1}, {5, 1}};
  Diagnostics diagnostics;
  const LayerRegions regions = regions_of({rectangle(0, 0, 2, 2), line}, 0, &diagnostics);
  CHECK(area_of(regions) == Approx(4).epsilon(1e-6));
  CHECK(diagnostics.count("supports_left_out") == 1);
}

TEST_CASE("slices without area give an error, coordinates that are not finite too") {
  CHECK_THROWS_AS(regions_of({loop({{0, 0}, {1, 1}})}), GeometryError);
  CHECK_THROWS_AS(regions_of({rectangle(0, 0, std::nan(""), 1)}), GeometryError);
  CHECK_THROWS_AS(regions_of({rectangle(0, 0, 1e200, 1)}), GeometryError);
}

TEST_CASE("regions far from the origin, tiny and huge, keep their relative area") {
  for (const double scale : {1e-6, 1.0, 1e6})
    for (const double offset : {0.0, 1e3}) {
      INFO("scale " << scale << " offset " << offset);
      const Polyline p = rectangle(offset * scale, offset * scale, (offset + 3) * scale, (offset + 2) * scale);
      CHECK(area_of(regions_of({p})) == Approx(6 * scale * scale).epsilon(1e-6));
    }
}

TEST_CASE("the outlines of the slice files are sound", "[corpus]") {
  std::size_t seen = 0;
  const auto files = small_corpus_files();
  for (const auto& path : files) {
    INFO(path.filename().string());
    Diagnostics diagnostics;
    const SliceStack stack = read_cli(path.string());
    ThickenOptions options;
    options.radius = Length::mm(0.1);
    const LayerRegions regions = build_regions(stack, make_slabs(stack, {}, diagnostics), options, diagnostics);
    for (const Outline& outline : regions.outlines) {
      check_outline(outline);
      CHECK(detail::doubled_area(outline, kNone) > 0);
      ++seen;
    }
  }
  if (!files.empty()) CHECK(seen > 50);
}
