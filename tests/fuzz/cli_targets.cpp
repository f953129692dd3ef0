// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>
#include <string_view>

#include "fuzz/byte_source.hpp"
#include "fuzz/targets.hpp"
#include "slice2mesh/cli/read_cli.hpp"
#include "slice2mesh/cli/write_cli.hpp"

namespace slice2mesh_fuzz {

using namespace slice2mesh;

namespace {

SliceStack read_as_written(const std::string& bytes) {
  return parse_cli(bytes, CliReadOptions::as_written());
}

void check_read(const SliceStack& stack) {
  for (std::size_t i = 0; i < stack.layers.size(); ++i) {
    const Layer& layer = stack.layers[i];
    if (i > 0 && !(layer.z > stack.layers[i - 1].z)) throw Failure("layers do not ascend");
    for (const Polyline& line : layer.polylines) {
      if (line.points.empty()) throw Failure("a polyline without points");
      for (const Point2& p : line.points)
        if (!std::isfinite(p.x) || !std::isfinite(p.y)) throw Failure("a coordinate is not finite");
    }
  }
}

}  // namespace

void read_cli(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  // The dialects that options can force.
  CliReadOptions forced;
  const std::uint8_t choice = size > 0 ? data[size - 1] : std::uint8_t{0};
  forced.orientation = static_cast<CliOrientation>(choice & 3);
  forced.close_lines = static_cast<CliCloseLines>((choice >> 2) % 3);
  forced.z_unit = static_cast<CliZUnit>((choice >> 4) % 3);
  forced.short_coordinates = static_cast<CliShortCoordinates>((choice >> 6) % 3);
  try {
    Diagnostics diagnostics;
    check_read(parse_cli(bytes, forced, &diagnostics));
  } catch (const Error&) {  // what a file may be
  }
  SliceStack stack;
  try {
    stack = parse_cli(bytes);
  } catch (const Error&) {
    return;
  }
  check_read(stack);
  if (stack.z_unit != stack.unit) return;  // a file has one unit: heights are converted and may be rounded
  std::ostringstream file;
  CliWriteOptions exact;
  exact.exact = true;
  try {
    slice2mesh::write_cli(file, stack, exact);
  } catch (const Error&) {
    return;  // a text file cannot say everything that CLI+ parameters may do
  }
  if (!(read_as_written(file.str()) == stack)) throw Failure("a stack is not read back as it was written");
}

void write_cli(const std::uint8_t* data, std::size_t size) {
  ByteSource bytes(data, size);
  SliceStack stack;
  constexpr double kUnits[] = {1, 0.01, 0.001, 0.1, 1e-9, 1e6, 0.0333, 25.4};
  stack.unit = stack.z_unit = kUnits[bytes.whole(0, 7)];
  for (int labels = bytes.whole(0, 2); labels > 0; --labels) stack.labels[bytes.whole(-1, 6)] = bytes.text(8);
  // Short whole numbers, 32-bit floats, or anything; in units, at most a kilometer.
  const int numbers = bytes.whole(0, 3);
  const auto number = [&]() -> double {
    if (numbers == 0) return bytes.whole(0, 65535);
    if (numbers == 1) return bytes.whole(-32768, 32767);
    if (numbers == 2) return static_cast<double>(static_cast<float>(bytes.share() * 200 - 100));
    return bytes.finite_double();
  };
  double z = 0;
  while (!bytes.empty() && stack.layers.size() < 8) {
    Layer layer;
    z += numbers == 3 ? bytes.any_double() : 1 + bytes.whole(0, 200);
    layer.z = z;
    ProcessParameters process;
    for (int lines = bytes.whole(0, 4); lines > 0; --lines) {
      if (bytes.flag()) process.power = bytes.whole(0, 500);
      if (bytes.flag()) process.speed = bytes.share();
      if (bytes.whole(0, 9) == 9) process.focus.reset();
      if (bytes.whole(0, 3) == 3) {
        Hatches hatches;
        hatches.part = bytes.whole(0, 6);
        hatches.process = process;
        for (int n = bytes.whole(0, 4); n > 0; --n)
          hatches.lines.push_back({Point2{number(), number()}, Point2{number(), number()}});
        layer.hatches.push_back(hatches);
        continue;
      }
      Polyline line;
      line.part = bytes.whole(0, 6);
      line.direction = static_cast<Direction>(bytes.whole(0, 2));
      line.process = process;
      for (int n = bytes.whole(0, 6); n > 0; --n) line.points.push_back({number(), number()});
      layer.polylines.push_back(line);
    }
    stack.layers.push_back(layer);
  }
  for (int way = 0; way < 5; ++way) {
    CliWriteOptions options;
    options.binary = way > 0;
    options.short_commands = way == 2 || way == 4;
    options.align = way >= 3;
    options.exact = true;
    std::ostringstream file;
    try {
      slice2mesh::write_cli(file, stack, options);
    } catch (const Error&) {
      continue;  // what the format cannot hold
    }
    const std::string text = file.str();
    SliceStack again;
    try {
      again = read_as_written(text);
    } catch (const Error& error) {
      throw Failure(std::string("what was written is not read: ") + error.what());
    }
    // Reading repairs what a stack made by hand may have (repeated points, contours without area); what it repaired is
    // written and read back as it is.
    std::ostringstream once_more;
    try {
      slice2mesh::write_cli(once_more, again, options);
    } catch (const Error&) {
      if (way == 0) continue;  // process parameters that a text file cannot unset
      throw Failure("what was read cannot be written");
    }
    if (!(read_as_written(once_more.str()) == again)) throw Failure("a stack is not read back as it was written");
  }
}

}  // namespace slice2mesh_fuzz
