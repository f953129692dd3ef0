// SPDX-License-Identifier: MIT
#include "slice2mesh/cli/write_cli.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "cli_samples.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;

namespace {

SliceStack back(const std::string& bytes) {
  return parse_cli(bytes, CliReadOptions::as_written());
}

std::vector<CliWriteOptions> binary_options() {
  std::vector<CliWriteOptions> all;
  for (const bool align : {false, true})
    for (const bool short_commands : {false, true}) {
      CliWriteOptions options;
      options.binary = true;
      options.align = align;
      options.short_commands = short_commands;
      all.push_back(options);
    }
  return all;
}

/// The stack that binary files can hold: 32-bit floats, no process parameters.
SliceStack as_floats(SliceStack stack) {
  // volatile: GCC 12 drops the way through float when it vectorizes.
  const auto round = [](double& v) {
    volatile float narrow = static_cast<float>(v);
    v = static_cast<double>(narrow);
  };
  for (Layer& layer : stack.layers) {
    round(layer.z);
    for (Polyline& line : layer.polylines) {
      line.process = {};
      for (Point2& p : line.points) round(p.x), round(p.y);
      if (line.direction == Direction::Open) {
        line.points.erase(std::unique(line.points.begin(), line.points.end()), line.points.end());
      } else {
        std::vector<Point2>& p = line.points;
        p.erase(std::unique(p.begin(), p.end()), p.end());
      }
    }
    for (Hatches& hatches : layer.hatches) {
      hatches.process = {};
      for (auto& line : hatches.lines)
        for (Point2& p : line) round(p.x), round(p.y);
    }
  }
  return stack;
}

std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::size_t files_in(const std::filesystem::path& folder) {
  std::size_t n = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) n += !entry.path().empty();
  return n;
}

SliceStack small_stack() {
  SliceStack stack;
  stack.layers.resize(1);
  stack.layers[0].z = 1;
  Polyline line;
  line.points = {{0, 0}, {1, 0}, {1, 1}};
  stack.layers[0].polylines.push_back(line);
  return stack;
}

}  // namespace

TEST_CASE("Text read back gives the same stack, with every bit of every number", "[cli]") {
  const unsigned seed = 5;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-100, 100);
  std::uniform_real_distribution<double> power(-30, 3);
  for (int round = 0; round < 200; ++round) {
    const auto numbers = [&](auto& r) { return round % 2 == 0 ? place(r) : place(r) * std::pow(10.0, power(r)); };
    const SliceStack stack = random_stack(random, numbers, true);
    CliWriteReport report;
    CliWriteOptions options;
    options.exact = true;
    const std::string bytes = written(stack, options, &report);
    CHECK(report.rounded_numbers == 0);
    CHECK(report.lost_parameters == 0);
    CHECK(report.bytes == bytes.size());
    const SliceStack again = back(bytes);
    CHECK(again == stack);
    CHECK(again.version == stack.version);
    CHECK(written(again, options) == bytes);
  }
}

TEST_CASE("Binary read back gives the same stack when the numbers are 32-bit floats", "[cli]") {
  const unsigned seed = 6;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> eighths(-800, 800);
  std::uniform_int_distribution<int> whole(0, 60000);
  std::uniform_int_distribution<int> with_sign(-30000, 30000);
  for (int round = 0; round < 150; ++round) {
    const auto numbers = [&](auto& r) -> double {
      if (round % 3 == 0) return eighths(r) * 0.125;
      return round % 3 == 1 ? whole(r) : with_sign(r);
    };
    SliceStack stack = random_stack(random, numbers, false);
    stack.labels.clear();
    std::vector<std::size_t> sizes;
    for (CliWriteOptions options : binary_options()) {
      options.exact = true;
      CliWriteReport report;
      const std::string bytes = written(stack, options, &report);
      CHECK(report.bytes == bytes.size());
      sizes.push_back(bytes.size());
      CHECK(back(bytes) == stack);
      CHECK(back(written(stack)) == back(bytes));  // text and binary say the same
    }
    if (round % 3 != 0) CHECK(sizes[1] < sizes[0]);  // short is shorter
  }
}

TEST_CASE("Binary rounds what is no 32-bit float, says so, and refuses it when it must be exact", "[cli]") {
  SliceStack stack = small_stack();
  stack.unit = stack.z_unit = 0.5;
  stack.layers[0].polylines[0].points[1].x = 0.1;
  stack.layers[0].polylines[0].process.power = 3;
  CliWriteOptions options;
  options.binary = true;
  CliWriteReport report;
  const std::string bytes = written(stack, options, &report);
  CHECK(report.rounded_numbers == 1);
  CHECK(report.lost_parameters == 1);
  CHECK(report.largest_rounding == Approx(0.5 * std::abs(0.1 - static_cast<double>(0.1f))));
  CHECK(back(bytes) == as_floats(stack));
  options.exact = true;
  CHECK_THROWS_AS(written(stack, options), Error);
  stack.layers[0].polylines[0].process = {};
  CHECK_THROWS_AS(written(stack, options), Error);
  stack.layers[0].polylines[0].points[1].x = 0.125;
  CHECK_NOTHROW(written(stack, options));
}

TEST_CASE("A process parameter that would have to be unset is counted, or refused when it must be exact", "[cli]") {
  SliceStack stack = small_stack();
  stack.layers[0].polylines.push_back(stack.layers[0].polylines[0]);
  stack.layers[0].polylines[0].process.power = 5;
  CliWriteReport report;
  (void)written(stack, {}, &report);
  CHECK(report.lost_parameters == 1);
  CliWriteOptions exact;
  exact.exact = true;
  CHECK_THROWS_AS(written(stack, exact), Error);
}

TEST_CASE("Every shared file rewritten as text and as binary gives the same stack", "[cli][data]") {
  const auto files = shared_cli_files();
  if (files.empty()) {
    WARN("skipped: no shared data");
    return;
  }
  int exact = 0;
  for (const auto& path : files) {
    CAPTURE(path.filename().string());
    const SliceStack stack = read_cli(path.string());
    CHECK(back(written(stack)) == stack);
    CHECK(parse_cli(written(stack)) == stack);  // and with the usual options
    for (const CliWriteOptions& options : binary_options()) {
      CliWriteReport report;
      const SliceStack again = back(written(stack, options, &report));
      CHECK(again == as_floats(stack));
      CHECK(report.largest_rounding < 1e-6);
      exact += report.rounded_numbers == 0 && report.lost_parameters == 0;
    }
  }
  CHECK(exact > 0);
}

TEST_CASE("Stacks that the format cannot hold are refused", "[cli]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<SliceStack> bad(9, small_stack());
  bad[0].unit = 0;
  bad[1].layers[0].z = nan;
  bad[2].layers.push_back(bad[2].layers[0]);
  bad[3].layers[0].polylines[0].points[0].y = std::numeric_limits<double>::infinity();
  bad[4].layers[0].polylines[0].process.speed = nan;
  bad[5].labels[1] = "a\nb";
  bad[6].labels[1] = "a$$LAYER/5";
  bad[7].layers[0].hatches.resize(1);
  bad[7].layers[0].hatches[0].lines.push_back({Point2{0, nan}, Point2{0, 0}});
  bad[8].dimension = std::array<double, 6>{0, 0, nan, 0, 0, 0};
  for (std::size_t i = 0; i < bad.size(); ++i)
    for (const bool binary : {false, true}) {
      CAPTURE(i, binary);
      CliWriteOptions options;
      options.binary = binary;
      CHECK_THROWS_AS(written(bad[i], options), Error);
    }
  // Two heights that only a double tells apart.
  SliceStack close = small_stack();
  close.layers.push_back(close.layers[0]);
  close.layers[1].z = 1 + 1e-12;
  CHECK(back(written(close)) == close);
  CliWriteOptions binary;
  binary.binary = true;
  CHECK_THROWS_AS(written(close, binary), GeometryError);
}

TEST_CASE("What the reader would refuse is not written", "[cli]") {
  std::vector<SliceStack> bad(6, small_stack());
  bad[0].unit = bad[0].z_unit = 1e7;
  bad[1].unit = bad[1].z_unit = 1e-10;
  bad[2].layers.back().z = 1.1e6;  // mm
  bad[3].layers[0].polylines[0].points[0].x = -1.1e6;
  bad[4].layers[0].hatches.resize(1);
  bad[4].layers[0].hatches[0].lines.push_back({Point2{0, 0}, Point2{0, 1e300}});
  bad[5].unit = bad[5].z_unit = 1e6;
  bad[5].layers[0].polylines[0].points[0].x = 2;
  for (std::size_t i = 0; i < bad.size(); ++i)
    for (const bool binary : {false, true}) {
      CAPTURE(i, binary);
      CliWriteOptions options;
      options.binary = binary;
      CHECK_THROWS_AS(written(bad[i], options), Error);
    }
  // Signed numbers of 16 bits, which are read before it is known that they have a sign, in a unit where they would be
  // out of range without it.
  SliceStack negative = small_stack();
  negative.unit = negative.z_unit = 100;
  negative.layers[0].polylines[0].points[0] = {-5, -7};
  CliWriteOptions short_binary;
  short_binary.binary = short_binary.short_commands = true;
  CHECK(back(written(negative, short_binary)) == negative);
  // The largest numbers that are allowed are read back.
  SliceStack large = small_stack();
  large.layers[0].polylines[0].points[0] = {-1e6, -1e6};
  CHECK(back(written(large)) == large);
}

TEST_CASE("z in mm is written in units", "[cli]") {
  SliceStack stack = small_stack();
  stack.unit = 0.25;
  stack.z_unit = 1;
  const SliceStack again = back(written(stack));
  CHECK(again.z_unit == 0.25);
  CHECK(again.layers[0].z == 4);
}

TEST_CASE("A file is written whole or not at all", "[cli]") {
  const TemporaryDirectory folder;
  const std::string path = folder.file("a.cli");
  const SliceStack stack = small_stack();
  const CliWriteReport report = write_cli(path, stack);
  CHECK(report.bytes == std::filesystem::file_size(path));
  CHECK(read_cli(path, CliReadOptions::as_written()) == stack);
  const std::string before = content(path);
  SliceStack bad = stack;
  bad.layers[0].z = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(write_cli(path, bad), GeometryError);
  CHECK(content(path) == before);
  CHECK(files_in(folder.path()) == 1);
  CHECK_THROWS_AS(write_cli(folder.file("b.cli"), bad), GeometryError);
  CHECK(files_in(folder.path()) == 1);
  CHECK_THROWS_AS(write_cli(folder.file("no/such/folder.cli"), stack), FileError);
}

TEST_CASE("A file written atomically replaces the old one only when all of it is there", "[core]") {
  const TemporaryDirectory folder;
  const std::string path = folder.file("file.txt");
  write_file_atomically(path, Stage::Write, [](std::ostream& out) { out << "old"; });
  CHECK(content(path) == "old");
  struct Stop {};
  CHECK_THROWS_AS(write_file_atomically(path, Stage::Write,
                                        [](std::ostream& out) {
                                          out << "new" << std::flush;
                                          throw Stop{};
                                        }),
                  Stop);
  CHECK(content(path) == "old");
  CHECK_THROWS_AS(write_file_atomically(path, Stage::Write,
                                        [](std::ostream& out) {
                                          out << "new";
                                          out.setstate(std::ios::badbit);
                                        }),
                  FileError);
  CHECK(content(path) == "old");
  {
    AtomicFile never_committed(path, Stage::Write);
    never_committed.stream() << "new";
  }
  CHECK(content(path) == "old");
  CHECK(files_in(folder.path()) == 1);
  write_file_atomically(path, Stage::Write, [](std::ostream& out) { out << "new"; });
  CHECK(content(path) == "new");
  CHECK(files_in(folder.path()) == 1);
  std::filesystem::create_symlink("file.txt", folder.path() / "link");
  write_file_atomically(folder.file("link"), Stage::Write, [](std::ostream& out) { out << "through"; });
  CHECK(std::filesystem::is_symlink(folder.path() / "link"));
  CHECK(content(path) == "through");
}

TEST_CASE("A full disk is a FileError", "[core]") {
  if (!std::filesystem::exists("/dev/full")) {
    WARN("skipped: no /dev/full");
    return;
  }
  for (const std::size_t bytes : {std::size_t{1}, std::size_t{1} << 20})
    CHECK_THROWS_AS(
        write_file_atomically("/dev/full", Stage::Write, [&](std::ostream& out) { out << std::string(bytes, 'x'); }),
        FileError);
  CHECK_THROWS_AS(write_cli("/dev/full", small_stack()), FileError);
}
