// SPDX-License-Identifier: MIT
// Sizes that depend on the place: functions of the user, balls, and how they grow.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "../plc/chain.hpp"
#include "slice2mesh/slice2mesh.hpp"
#include "test_support.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;

namespace {

/// Slabs of 0.5 mm with the same contour, 12 mm by 6 mm.
SliceStack block(int slices = 5) {
  const std::vector<std::vector<Polyline>> layers(std::size_t(slices), {rectangle(0, 0, 12, 6)});
  return stack_of(layers, 0.5);
}
struct EdgeLength {
  double x, y, z, length;
};
/// The edges of a mesh that lie in planes: where their middle is, and their lengths.
std::vector<EdgeLength> horizontal_edges(const Mesh& mesh) {
  std::set<std::pair<std::int32_t, std::int32_t>> seen;
  std::vector<EdgeLength> result;
  for (const auto& tet : mesh.tets)
    for (const auto& e : kTetEdgeVertices) {
      const auto [a, b] = std::minmax(tet[e[0]], tet[e[1]]);
      const auto &p = mesh.vertices[std::size_t(a)], &q = mesh.vertices[std::size_t(b)];
      if (p[2] != q[2] || !seen.insert({a, b}).second) continue;
      result.push_back({(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, p[2], std::hypot(p[0] - q[0], p[1] - q[1])});
    }
  return result;
}
template <class F>
double mean_length(const std::vector<EdgeLength>& edges, F&& where) {
  double sum = 0;
  std::size_t count = 0;
  for (const EdgeLength& e : edges)
    if (where(e)) {
      sum += e.length;
      ++count;
    }
  REQUIRE(count > 20);
  return sum / double(count);
}
std::uint64_t close_pairs(const Report& report) {
  return report.separation.between.close_vertices.back() + report.separation.between.close_vertex_edge.back();
}
std::string option_of(const Options& options) {
  try {
    (void)slice_to_mesh(block(2), options);
  } catch (const OptionError& error) {
    return error.option();
  }
  return "none";
}

}  // namespace

TEST_CASE(
    "elements have the sizes that a function asks for, inside and along contours, in columns where it ignores z") {
  Options options;
  options.size.size = Length::mm(1);
  options.improve.keep_columns = true;
  const auto wanted = [](double x) { return std::min(1.0, 0.25 + 0.15 * x); };
  options.size.size_at = [&](double x, double, double) { return wanted(x); };
  const Result result = slice_to_mesh(block(), options);
  CHECK(result.report.certificate.passed());
  CHECK(close_pairs(result.report) == 0);
  CHECK(result.report.quality.column_share > 0.9);
  CHECK(result.report.quality.ratio.worst < 6);
  const std::vector<EdgeLength> edges = horizontal_edges(result.mesh);
  for (const double x : {0.5, 1.5, 3.0, 4.5, 9.0}) {
    INFO("x " << x);
    const double inside =
        mean_length(edges, [&](const EdgeLength& e) { return std::fabs(e.x - x) < 0.4 && std::fabs(e.y - 3) < 2; });
    CHECK(inside > 0.6 * wanted(x));
    CHECK(inside < 1.3 * wanted(x));
  }
  double longest = 0;
  for (const EdgeLength& e : edges)
    if ((e.y < 1e-6 || e.y > 6 - 1e-6) && e.x < 1) longest = std::max(longest, e.length / wanted(e.x));
  CHECK(longest > 0.5);
  CHECK(longest < 1.2);
}

TEST_CASE("a function that asks for nothing smaller changes nothing, and one of the height changes planes near by") {
  Options options;
  options.size.size = Length::mm(1);
  const Mesh usual = slice_to_mesh(block(), options).mesh;
  for (const double size : {1.0, 5.0, std::numeric_limits<double>::infinity()}) {
    options.size.size_at = [size](double, double, double) { return size; };
    const Mesh same = slice_to_mesh(block(), options).mesh;
    CHECK(same.tets == usual.tets);
    CHECK((same.vertices == usual.vertices));
  }
  options.size.size_at = [](double, double, double z) { return 0.3 + 0.5 * std::fabs(z); };
  const Result result = slice_to_mesh(block(9), options);
  CHECK(result.report.certificate.passed());
  const std::vector<EdgeLength> edges = horizontal_edges(result.mesh);
  const double low = edges.front().z < 1 ? 0 : edges.front().z;
  const double below = mean_length(edges, [&](const EdgeLength&e) { return e.z < low + 0.6; }),
               above = mean_length(edges, [&](const EdgeLength&e) { return e.z > low + 3; });
  CHECK(below < 0.75 * above);
}

TEST_CASE("in balls elements are as small as asked for, and sizes grow from them and from contours as fast as said") {
  Options options;
  options.size.size = Length::mm(1);
  const RefinedBall ball{6, 3, 1, 1.5, Length::layers(0.5)};
  std::size_t last = 1000000000, last_more = last;
  for (const double growth : {0.1, 0.5, 2.0}) {
    INFO("growth " << growth);
    options.size.growth = growth;
    options.size.refined.clear();
    const std::size_t without = slice_to_mesh(block(), options).mesh.tets.size();
    options.size.refined.push_back(ball);
    const Result result = slice_to_mesh(block(), options);
    CHECK(result.report.certificate.passed());
    const std::vector<EdgeLength> edges = horizontal_edges(result.mesh);
    const auto from_center = [](const EdgeLength& e) { return std::hypot(e.x - 6, e.y - 3, e.z - 1); };
    const double inside = mean_length(edges, [&](const EdgeLength& e) { return from_center(e) < 1.5; });
    CHECK(inside > 0.15);
    CHECK(inside < 0.33);
    CHECK(10 * without < 9 * last);
    last = without;
    const std::size_t more = result.mesh.tets.size() - without;
    CHECK(10 * more < 9 * last_more);
    last_more = more;
  }
}

TEST_CASE("meshes of random stacks with random balls are certified, within the tolerance, and contours stay apart") {
  std::size_t larger = 0, seen = 0;
  for (std::uint32_t seed = 1; seed <= times(24); ++seed) {
    INFO("seed " << seed);
    const SliceStack stack = random_stack(seed);
    Options options;
    options.eps = Length::layers(seed % 2 == 0 ? 0.1 : 0.3);
    const Result usual = slice_to_mesh(stack, options);
    std::mt19937 random(seed);
    const auto uniform = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; };
    for (int i = 0; i < 3; ++i)
      options.size.refined.push_back(
          {uniform(0, 8), uniform(0, 8), uniform(0, 3), uniform(0, 2), Length::layers(uniform(0.4, 1))});
    const Result result = slice_to_mesh(stack, options);
    CHECK(result.report.certificate.passed());
    CHECK(result.report.max_deviation <= 1.0002 * options.eps.in_mm(result.report.thickness));
    CHECK(close_pairs(result.report) <= close_pairs(usual.report));
    CHECK(result.report.quality.ratio.worst <= std::max(15.0, 2 * usual.report.quality.ratio.worst));
    larger += result.mesh.tets.size() > usual.mesh.tets.size();
    ++seen;
  }
  CHECK(larger > seen / 2);
}

TEST_CASE("sizes without sense are errors that name the option, and a budget ends a run that asks for too small ones") {
  const auto with = [](const std::function<void(Options&)>& set) {
    Options options;
    options.size.size = Length::mm(1);
    set(options);
    return options;
  };
  for (const double size : {0.0, -1.0, 1e-9, std::numeric_limits<double>::quiet_NaN()}) {
    INFO(size);
    CHECK(option_of(with([=](Options& o) { o.size.size_at = [=](double, double, double) { return size; }; })) ==
          "size.size_at");
    CHECK(option_of(with([=](Options& o) {
            o.size.refined.push_back({0, 0, 0, 1, Length::mm(size)});
          })) == "size.refined");
  }
  CHECK(option_of(with([](Options& o) { o.size.refined.push_back({0, 0, 0, -1, Length::mm(1)}); })) == "size.refined");
  CHECK(option_of(with([](Options& o) {
          o.size.refined.push_back({std::nan(""), 0, 0, 1, Length::mm(1)});
        })) == "size.refined");
  for (const double growth : {0.0, 0.01, 11.0, std::nan("")})
    CHECK(option_of(with([=](Options& o) { o.size.growth = growth; })) == "size.growth");
  // What the function throws comes through.
  const Options throws = with(
      [](Options& o) { o.size.size_at = [](double, double, double) -> double { throw std::runtime_error("mine"); }; });
  CHECK_THROWS_WITH(slice_to_mesh(block(2), throws), "mine");
  Options small = with([](Options& o) { o.size.size_at = [](double, double, double) { return 0.02; }; });
  small.budget.max_vertices = 20000;
  CHECK_THROWS_AS(slice_to_mesh(block(2), small), BudgetError);
}
