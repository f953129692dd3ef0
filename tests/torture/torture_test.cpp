// SPDX-License-Identifier: MIT
// Geometry that is hard to mesh: a certified mesh, or an error that is right.
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "test_support.hpp"
#include "torture/generators.hpp"
#include "torture/pipeline_runner.hpp"

using namespace slice2mesh_test;

namespace {

constexpr std::uint32_t kSeed = 1;

/// Classes that take seconds each at seed 1.
const std::set<std::string> kSlow = {"checkerboards", "repeated_loops", "self_crossing", "at_the_grid"};
/// Classes that are left to torture_driver: up to minutes each, most of it in exact mode.
const std::set<std::string> kDriverOnly = {"islands",         "near_parallel", "near_coincident", "twisted_squares",
                                           "tangent_circles", "spirals",       "needles",         "random_stacks",
                                           "support_lines",   "thicknesses",   "spikes",          "too_much"};

void check_class(const TortureClass& kind, std::uint32_t seed) {
  const std::vector<TortureCase> inputs = kind.make(seed);
  REQUIRE(!inputs.empty());
  for (const TortureCase& input : inputs) {
    CAPTURE(kind.name, seed, input.name);
    const Outcome outcome = run_pipeline(input.stack, input.options);
    INFO(to_string(outcome.ending) << ": " << outcome.message);
    CHECK(is_allowed(input.allowed, to_string(outcome.ending)));
  }
}

}  // namespace

TEST_CASE("every class of the torture set has inputs that depend on the seed alone, and names them apart") {
  std::map<std::string, int> classes;
  std::size_t inputs = 0;
  for (const TortureClass& kind : torture_classes()) {
    CAPTURE(kind.name);
    CHECK(++classes[kind.name] == 1);
    if (kind.large) continue;
    const std::vector<TortureCase> first = kind.make(3), second = kind.make(3);
    REQUIRE(first.size() == second.size());
    std::map<std::string, int> names;
    for (std::size_t i = 0; i < first.size(); ++i) {
      CAPTURE(first[i].name);
      CHECK(++names[first[i].name] == 1);
      const bool with_nan = kind.name == "wrong_numbers";
      CHECK((with_nan || first[i].stack == second[i].stack));
      const Allowed& a = first[i].allowed;
      CHECK((a.certified || a.geometry_error || a.option_error || a.budget_error || a.tetrahedralization_error));
    }
    inputs += first.size();
  }
  CHECK(inputs > 500);
}

TEST_CASE("a fan of thin triangles needs elements in proportion to their number") {
  std::map<int, std::size_t> tets;
  for (const int n : {20, 80}) {
    torture::Slice fan;
    for (int i = 0; i < n; ++i) {
      const double a = 0.5 * torture::kPi * i / n, b = a + 0.2 * torture::kPi / n;
      fan.push_back(torture::loop({{0, 0}, {5 * std::cos(a), 5 * std::sin(a)}, {5 * std::cos(b), 5 * std::sin(b)}}));
    }
    const Outcome outcome = run_pipeline(torture::stack_of({fan, fan}));
    REQUIRE(outcome.certified());
    tets[n] = outcome.mesh.tets.size();
  }
  CHECK(tets[80] < 9 * tets[20]);  // 16 if it were with the square
}

TEST_CASE("exact mode says what is wrong where contours of neighbors nearly coincide; nothing else is excused") {
  // Noise of 3e-7 mm over 11 mm: the contours of two layers are a few pitches apart along an edge.
  bool seen = false;
  for (const TortureClass& kind : torture_classes()) {
    if (kind.name != "random_stacks") continue;
    for (const TortureCase& input : kind.make(7)) {
      if (input.name != "noise of 2.9572e-07 mm, eps 0") continue;
      seen = true;
      CHECK(exact_neighbors_nearly_coincide(input.stack, input.options));
      const Outcome outcome = run_pipeline(input.stack, input.options);
      CAPTURE(outcome.message);
      CHECK(outcome.ending == Ending::TetrahedralizationError);
      for (const char* part : {"slab 1: contours are not conforming", "near -0.1074", " mm", "eps > 0"})
        CHECK(outcome.message.find(part) != std::string::npos);
      slice2mesh::Options merged = input.options;
      merged.eps = slice2mesh::Options().eps;
      CHECK(run_pipeline(input.stack, merged).certified());
      CHECK_FALSE(exact_neighbors_nearly_coincide(input.stack, merged));
    }
  }
  CHECK(seen);
  slice2mesh::Options exact;
  exact.eps = slice2mesh::Length::mm(0);
  const auto boxes = [](double shift) {
    return torture::stack_of({{torture::box(0, 0, 8, 8)}, {torture::box(shift, 0, 8, 8)}});
  };
  for (const double shift : {0.0, 1e-4, 1.0}) CHECK_FALSE(exact_neighbors_nearly_coincide(boxes(shift), exact));
  CHECK(exact_neighbors_nearly_coincide(boxes(1e-6), exact));
}

TEST_CASE("contours do not leave the grid where the tolerance is wider than the part") {
  bool seen = false;
  for (const TortureClass& kind : torture_classes()) {
    if (kind.name != "thicknesses") continue;
    for (const TortureCase& input : kind.make(kSeed)) {
      if (input.name != "100 of the size" && input.name != "1000 of the size") continue;
      seen = true;
      CAPTURE(input.name);
      const Outcome outcome = run_pipeline(input.stack, input.options);
      INFO(outcome.message);
      CHECK(outcome.certified());
    }
  }
  CHECK(seen);
}

TEST_CASE("small inputs of every class give a certified mesh or an error that is right") {
  std::size_t seen = 0;
  for (const TortureClass& kind : torture_classes()) {
    if (kind.large || kSlow.count(kind.name) > 0 || kDriverOnly.count(kind.name) > 0) continue;
    check_class(kind, kSeed);
    ++seen;
  }
  CHECK(seen >= 8);
}

TEST_CASE("inputs of every class that take longer give a certified mesh or an error that is right", "[slow]") {
  std::size_t seen = 0;
  for (const TortureClass& kind : torture_classes()) {
    if (kSlow.count(kind.name) == 0) continue;
    check_class(kind, kSeed);
    ++seen;
  }
  CHECK(seen == kSlow.size());
}
