// SPDX-License-Identifier: MIT
// Budgets, cancellation from any place, and the same bytes every time.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "slice2mesh/cli/read_cli.hpp"
#include "slice2mesh/cli/write_cli.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/io/write_mesh.hpp"
#include "slice2mesh/plc/verify_plc.hpp"
#include "slice2mesh/quality/certificate.hpp"
#include "slice2mesh/quality/quality.hpp"
#include "test_support.hpp"
#include "torture/generators.hpp"
#include "torture/pipeline_runner.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;

namespace {

SliceStack sample(std::uint32_t seed = 5) {
  Dice dice(seed);
  std::vector<torture::Slice> slices;
  for (int l = 0; l < 5; ++l)
    slices.push_back({torture::star({0.1 * l, 0}, 4, 21, 0.3, 0.02 * l + dice.real(0, 0.01)),
                      torture::star({1, 0}, 1, 9, 0, 0, Direction::Inner)});
  return torture::stack_of(slices);
}

struct Call {
  Stage stage;
  double share;
};

/// All calls of the progress function of a run.
std::vector<Call> calls_of(const SliceStack& stack, Options options) {
  std::vector<Call> calls;
  options.progress = [&](Stage stage, double share) {
    calls.push_back({stage, share});
    return true;
  };
  const Outcome outcome = run_pipeline(stack, options);
  REQUIRE(outcome.certified());
  return calls;
}

/// A run with many elements, made once, and how often every stage asked whether to go on.
struct FineRun {
  std::map<Stage, std::size_t> calls;
  Outcome outcome;
};
const FineRun& fine_run() {
  static const FineRun run = [] {
    FineRun r;
    Options options;
    options.size.size = Length::mm(0.12);
    options.size.contour_size = Length::mm(0.1);
    options.progress = [&](Stage stage, double) {
      ++r.calls[stage];
      return true;
    };
    r.outcome = run_pipeline(sample(), options);
    return r;
  }();
  REQUIRE(run.outcome.certified());
  return run;
}

class Stop : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

}  // namespace

TEST_CASE("progress comes from every stage, in their order, with shares that grow from 0 to 1") {
  for (const bool move : {false, true}) {
    Options options;
    options.slabs.lump = 2;  // so that the estimates unite all slices
    options.improve.move_contours = move;
    const std::vector<Call> calls = calls_of(sample(), options);
    std::set<Stage> seen;
    for (std::size_t i = 0; i < calls.size(); ++i) {
      seen.insert(calls[i].stage);
      CHECK(calls[i].share >= 0);
      CHECK(calls[i].share <= 1);
      if (i == 0) continue;
      CHECK(calls[i].stage >= calls[i - 1].stage);
      if (calls[i].stage == calls[i - 1].stage) CHECK(calls[i].share >= calls[i - 1].share);
    }
    for (const Stage stage : {Stage::Regions, Stage::Harmonize, Stage::Triangulate, Stage::Plc, Stage::Tetrahedralize,
                              Stage::Improve, Stage::Certify, Stage::Quality, Stage::Fem}) {
      INFO(to_string(stage));
      CHECK(seen.count(stage) == 1);
    }
  }
}

TEST_CASE("a run is cancelled by any of its calls, and a listener may throw what it likes") {
  Options options;
  options.size.size = Length::mm(1.5);
  const std::vector<Call> calls = calls_of(sample(), options);
  REQUIRE(calls.size() > 15);
  // The first and the last call of every stage, both ways, and about eighty between them, one way or the other.
  constexpr std::size_t kBetween = times(40);
  std::set<std::size_t> stops, ends;
  std::set<Stage> seen;
  for (std::size_t i = 0; i < calls.size(); ++i) {
    seen.insert(calls[i].stage);
    const bool first = i == 0 || calls[i - 1].stage != calls[i].stage;
    const bool last = i + 1 == calls.size() || calls[i + 1].stage != calls[i].stage;
    if (first || last) ends.insert(i);
    if (first || last || i < kBetween || i % std::max<std::size_t>(1, calls.size() / kBetween) == 0) stops.insert(i);
  }
  REQUIRE(seen.size() >= 8);
  REQUIRE(stops.size() > 12);
  for (const std::size_t stop : stops) {
    CAPTURE(stop);
    const bool at_end_of_stage = ends.count(stop) != 0;
    std::size_t n = 0;
    if (at_end_of_stage || stop % 2 == 0) {
      options.progress = [&](Stage, double) { return n++ != stop; };
      const Outcome outcome = run_pipeline(sample(), options);
      CHECK(outcome.ending == Ending::Cancelled);
      CHECK(outcome.message == std::string(to_string(calls[stop].stage)) + ": cancelled");
      CHECK(n == stop + 1);  // nobody asks again
    }
    if (!at_end_of_stage && stop % 2 == 0) continue;
    n = 0;
    options.progress = [&](Stage, double) -> bool {
      if (n++ == stop) throw Stop("enough");
      return true;
    };
    const Outcome thrown = run_pipeline(sample(), options);
    CHECK(thrown.ending == Ending::Foreign);
    CHECK(thrown.message == "enough");
  }
}

TEST_CASE("the more there is to do, the more often every stage asks whether to go on") {
  // Counts of calls, since times depend on the machine: about one per 8192 elements, or per 1024 steps of refinement.
  std::map<Stage, std::size_t> count = fine_run().calls;
  const Outcome& outcome = fine_run().outcome;
  const std::size_t tets = outcome.mesh.tets.size();
  REQUIRE(tets > 15000);
  const std::size_t slabs = outcome.mesh.slabs.size();
  CHECK(count[Stage::Harmonize] >= 4 * slabs);
  CHECK(count[Stage::Triangulate] >= outcome.mesh.vertices.size() / 2048);
  CHECK(count[Stage::Tetrahedralize] >= tets / 4096);
  CHECK(count[Stage::Improve] >= 10);
  CHECK(count[Stage::Certify] >= slabs + 2);
  CHECK(count[Stage::Quality] >= 3 + tets / 8192);
  // Without the pipeline around them: whoever is asked may say no.
  for (std::size_t stop : {std::size_t{0}, std::size_t{2}}) {
    std::size_t n = 0;
    const Progress until = [&](Stage, double) { return n++ != stop; };
    CHECK_THROWS_AS(certify(outcome.mesh, outcome.plc, {}, until), Cancelled);
    CHECK(n == stop + 1);
    n = 0;
    CHECK_THROWS_AS(measure_quality(outcome.mesh, {}, until), Cancelled);
    CHECK(n == stop + 1);
  }
}

TEST_CASE("harmonization of contours with many vertices can be cancelled within a slab") {
  SliceStack stack;
  constexpr int kPoints = 5000;
  for (int l = 0; l < 2; ++l) {
    Polyline ring;
    for (int i = 0; i < kPoints; ++i) {
      const double angle = 2 * 3.14159265358979 * i / kPoints, r = 10 + 0.3 * std::sin(40 * angle + l);
      ring.points.push_back({r * std::cos(angle), r * std::sin(angle)});
    }
    stack.layers.emplace_back();
    stack.layers.back().z = 0.5 * l;
    stack.layers.back().polylines.push_back(ring);
  }
  Options options;
  options.eps = Length::mm(0);
  // Two slabs with few vertices take eight calls.
  std::size_t n = 0;
  options.progress = [&](Stage stage, double) {
    n += stage == Stage::Harmonize ? 1 : 0;
    return n < 12;
  };
  const Outcome outcome = run_pipeline(stack, options);
  CHECK(outcome.ending == Ending::Cancelled);
  CHECK(outcome.message == std::string(to_string(Stage::Harmonize)) + ": cancelled");
  CHECK(n == 12);
}

TEST_CASE("reading a slice file, writing one and checking a complex can be cancelled on the way") {
  SliceStack stack;
  stack.layers.emplace_back();
  Polyline line;
  constexpr int kPoints = 40000 * (1 + int(times(4)));
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2 * 3.14159265358979 * i / kPoints, r = 10 + (i % 2 != 0 ? 0.001 : 0);
    line.points.push_back({r * std::cos(angle), r * std::sin(angle)});
  }
  stack.layers[0].polylines.push_back(line);
  // `work` hands the listener on; each of its calls can end it.
  const auto check = [](std::size_t least, const std::function<void(const std::function<void()>&)>& work) {
    std::size_t n = 0;
    work([&] { ++n; });
    REQUIRE(n >= least);
    for (const std::size_t stop : {std::size_t{1}, n / 2, n}) {
      CAPTURE(stop, n);
      std::size_t calls = 0;
      CHECK_THROWS_AS(work([&] {
                        if (++calls == stop) throw Stop("enough");
                      }),
                      Stop);
      CHECK(calls == stop);  // nobody asks again
    }
  };
  for (const bool binary : {false, true}) {
    CAPTURE(binary);
    CliWriteOptions write;
    write.binary = binary;
    std::string bytes;
    check(kPoints * (binary ? 8 : 20) / 65536, [&](const std::function<void()>& poll) {
      write.poll = poll;
      std::ostringstream out;
      write_cli(out, stack, write);
      bytes = out.str();
    });
    const std::filesystem::path folder = std::filesystem::current_path() / "cancelled_writing";
    std::filesystem::remove_all(folder);
    std::filesystem::create_directory(folder);
    const std::string path = (folder / "part.cli").string();
    write.poll = [n = 0]() mutable {
      if (++n == 6) throw Stop("enough");
    };
    CHECK_THROWS_AS(write_cli(path, stack, write), Stop);
    CHECK(std::filesystem::is_empty(folder));
    write.poll = [n = 0]() mutable {
      if (++n == 6) throw FileError(Stage::Write, "elsewhere", "is full");  // not of this file
    };
    CHECK_THROWS_AS(write_cli(path, stack, write), FileError);
    CHECK(std::filesystem::is_empty(folder));
    std::filesystem::remove_all(folder);
    CliReadOptions read = CliReadOptions::as_written();
    const auto of_memory = [&](const std::function<void()>& poll) {
      read.poll = poll;
      const SliceStack got = parse_cli(bytes, read);  // CHECK would catch what the listener throws
      CHECK(got.layers.size() == 1);
    };
    check(kPoints / 65536 + 2, of_memory);  // reading the points, and twice for all of them at once
    check(bytes.size() / 65536, [&](const std::function<void()>& poll) {
      read.poll = poll;
      std::istringstream in(bytes);
      const SliceStack got = read_cli(in, read);
      CHECK(got.layers.size() == 1);
    });
  }
  // Contours side by side, which nesting compares each with all others.
  SliceStack fence;
  fence.layers.emplace_back();
  for (int i = 0; i < 2000; ++i) {
    Polyline picket;
    picket.points = {{0.1 * i, 0.001 * i}, {0.1 * i + 0.05, 0.001 * i}, {0.1 * i + 0.05, 10}, {0.1 * i, 10}};
    fence.layers[0].polylines.push_back(picket);
  }
  std::ostringstream written;
  write_cli(written, fence);
  check(30, [&](const std::function<void()>& poll) {
    CliReadOptions nesting = CliReadOptions::as_written();
    nesting.orientation = CliOrientation::Nesting;
    nesting.poll = poll;
    const SliceStack got = parse_cli(written.str(), nesting);
    CHECK(got.layers[0].polylines.size() == 2000);
  });
  check(3, [&](const std::function<void()>& poll) {
    const PlcReport report = verify_plc(fine_run().outcome.plc, 3, poll);
    CHECK(report.passed());
  });
}

TEST_CASE("every budget ends a run with a BudgetError, and a budget that suffices changes nothing") {
  const Outcome free = run_pipeline(sample());
  REQUIRE(free.certified());
  const auto vertices = static_cast<std::int64_t>(free.mesh.vertices.size());
  const auto tets = static_cast<std::int64_t>(free.mesh.tets.size());
  for (const std::int64_t share : {1, 10, 100, 1000}) {
    Options options;
    options.budget.max_vertices = std::max<std::int64_t>(1, vertices / share / 2);
    CHECK(run_pipeline(sample(), options).ending == Ending::BudgetError);
    options = {};
    options.budget.max_tets = std::max<std::int64_t>(1, tets / share / 2);
    CHECK(run_pipeline(sample(), options).ending == Ending::BudgetError);
  }
  for (const double seconds : {1e-300, 1e-6, 1e-3}) {
    Options options;
    options.budget.time_limit = seconds;
    CHECK(run_pipeline(sample(), options).ending == Ending::BudgetError);
  }
  Options options;
  options.budget.max_vertices = 4 * vertices;  // planes are counted before vertices are taken out of them
  options.budget.max_tets = 4 * tets;
  options.budget.time_limit = 1e6;
  CHECK(same_mesh(free.mesh, run_pipeline(sample(), options).mesh));
}

TEST_CASE("sizes that ask for more than the budget end before the points are made") {
  Options options;
  options.size.size = Length::mm(1e-4);
  options.budget.max_vertices = 1000000;
  std::set<Stage> seen;
  options.progress = [&](Stage stage, double) {
    seen.insert(stage);
    return true;
  };
  CHECK(run_pipeline(sample(), options).ending == Ending::BudgetError);
  CHECK(seen.count(Stage::Triangulate) == 0);
  options.budget.max_vertices = 0;
  options.size.size = Length::mm(1.5e-5);  // more than indices of 32 bits can count
  CHECK(run_pipeline(sample(), options).ending == Ending::BudgetError);
  options.size.size = Length::mm(1e-7);
  CHECK(run_pipeline(sample(), options).ending == Ending::OptionError);
  options.size = {};
  options.size.contour_size = Length::mm(1e-300);
  CHECK(run_pipeline(sample(), options).ending == Ending::OptionError);
}

TEST_CASE("the same input gives the same mesh: once more, after other work, and in several threads at a time") {
  const std::vector<SliceStack> stacks = {sample(1), sample(2), sample(3)};
  std::vector<Mesh> first;
  std::set<std::uint64_t> different;
  for (const SliceStack& stack : stacks) {
    first.push_back(run_pipeline(stack).mesh);
    REQUIRE(!first.back().tets.empty());
    different.insert(fingerprint(first.back()));
  }
  CHECK(different.size() == stacks.size());
  std::vector<Mesh> again(stacks.size());
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < stacks.size(); ++i)
    threads.emplace_back([&, i] { again[i] = run_pipeline(stacks[i]).mesh; });
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < stacks.size(); ++i) {
    CAPTURE(i);
    CHECK(same_mesh(first[i], again[i]));
    CHECK(same_mesh(first[i], run_pipeline(stacks[i]).mesh));
    CHECK(fingerprint(first[i]) == fingerprint(again[i]));
  }
}
