// SPDX-License-Identifier: MIT
/// @file
/// @brief Small CLI files and stacks for the tests of reader and writer.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "slice2mesh/cli/read_cli.hpp"
#include "slice2mesh/cli/write_cli.hpp"
#include "test_support.hpp"

namespace slice2mesh_test {

using namespace slice2mesh;

inline std::string text_file(const std::string& geometry, const std::string& header = "$$UNITS/1\n") {
  return "$$HEADERSTART\n$$ASCII\n" + header + "$$HEADEREND\n$$GEOMETRYSTART\n" + geometry + "$$GEOMETRYEND\n";
}

/// A binary file, built command by command.
struct BinaryFile {
  std::string bytes;
  explicit BinaryFile(const std::string& header = "$$UNITS/1\n")
      : bytes("$$HEADERSTART\n$$BINARY\n" + header + "$$HEADEREND") {}
  BinaryFile& u16(unsigned v) {
    bytes.push_back(static_cast<char>(v & 0xff));
    bytes.push_back(static_cast<char>((v >> 8) & 0xff));
    return *this;
  }
  BinaryFile& u32(std::uint32_t v) { return u16(v & 0xffff).u16(v >> 16); }
  BinaryFile& f32(float v) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &v, sizeof bits);
    return u32(bits);
  }
};

inline const char* const kSquare = "$$POLYLINE/1,1,5,0,0,1,0,1,1,0,1,0,0\n";

/// The outcome of a call that must end with a stack or a ParseError, and with nothing else.
inline bool parses(const std::string& bytes, const CliReadOptions& options = {}) {
  try {
    Diagnostics diagnostics;
    const SliceStack stack = parse_cli(bytes, options, &diagnostics, "sample");
    for (std::size_t i = 1; i < stack.layers.size(); ++i) REQUIRE(stack.layers[i].z > stack.layers[i - 1].z);
    for (const Layer& layer : stack.layers)
      for (const Polyline& line : layer.polylines) {
        REQUIRE(!line.points.empty());
        REQUIRE((line.direction == Direction::Open || line.points.size() >= 3));
        for (const Point2& p : line.points) REQUIRE((std::isfinite(p.x) && std::isfinite(p.y)));
      }
    return true;
  } catch (const ParseError& e) {
    REQUIRE(e.byte() <= bytes.size());
    return false;
  }
}

inline std::string written(const SliceStack& stack, const CliWriteOptions& options = {},
                           CliWriteReport* report = nullptr) {
  std::ostringstream out;
  const CliWriteReport r = write_cli(out, stack, options);
  if (report != nullptr) *report = r;
  return out.str();
}

/// A random stack in the form that the reader makes. `numbers` draws coordinates.
template <class Random, class Numbers>
SliceStack random_stack(Random& random, Numbers numbers, bool with_process) {
  std::uniform_int_distribution<int> small(0, 3);
  std::uniform_int_distribution<int> ids(0, 5);
  SliceStack stack;
  stack.unit = stack.z_unit = small(random) == 0 ? 1 : 0.01;
  stack.version = 200;
  stack.labels[1] = "part one";
  stack.labels[4] = "b,c";
  double z = 0;
  ProcessParameters process;
  for (int l = 0; l < 6; ++l) {
    Layer layer;
    layer.z = z;
    z += 0.25 * (1 + small(random));
    for (int i = small(random); i > 0; --i) {
      Polyline line;
      line.part = ids(random);
      const Point2 c{numbers(random), numbers(random)};
      const int kind = small(random);
      if (kind == 0) {
        line.direction = Direction::Open;
        line.points = {c, {c.x + 1, c.y}, {c.x, c.y + 2}, c};
        if (small(random) == 0) line.points.resize(1);
      } else {
        line.direction = kind == 1 ? Direction::Inner : Direction::Outer;
        line.points = {c, {c.x + 3, c.y}, {c.x + 3, c.y + 2}, {c.x, c.y + 1}};
        if (kind == 1) std::reverse(line.points.begin(), line.points.end());
      }
      if (with_process && small(random) == 0) process.power = 100.0 + small(random);
      if (with_process && small(random) == 0) process.speed = 0.1 * small(random);
      line.process = process;
      layer.polylines.push_back(line);
    }
    for (int i = small(random); i > 1; --i) {
      Hatches hatches;
      hatches.part = ids(random);
      for (int k = small(random); k > 0; --k)
        hatches.lines.push_back({Point2{numbers(random), numbers(random)}, Point2{numbers(random), numbers(random)}});
      if (with_process && small(random) == 0) process.focus = 1.5;
      hatches.process = process;
      layer.hatches.push_back(hatches);
    }
    stack.layers.push_back(layer);
  }
  return stack;
}

/// The CLI files of the shared data.
inline std::vector<std::filesystem::path> shared_cli_files() {
  std::vector<std::filesystem::path> files;
  if (const auto data = shared_data())
    for (const char* folder : {"reference", "machine"})
      if (std::filesystem::is_directory(*data / folder))
        for (const auto& entry : std::filesystem::directory_iterator(*data / folder))
          if (entry.path().extension() == ".cli") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace slice2mesh_test
