// SPDX-License-Identifier: MIT
#include "info.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "exit_codes.hpp"
#include "interrupt.hpp"
#include "slice2mesh/regions/slabs.hpp"
#include "text.hpp"

namespace slice2mesh_program {

namespace {

using slice2mesh::SliceStack;

struct Counts {
  std::array<std::size_t, 3> polylines{};  // by direction
  std::size_t points = 0;
  std::size_t hatches = 0;
};

struct Box {
  std::array<double, 2> low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  std::array<double, 2> high{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  void add(const slice2mesh::Point2& p) {
    low = {std::min(low[0], p.x), std::min(low[1], p.y)};
    high = {std::max(high[0], p.x), std::max(high[1], p.y)};
  }
};

void print_range(const char* title, double low, double high) {
  print_line(stdout, title, short_text(low) + " to " + short_text(high) + " mm");
}

void print_contents(const SliceStack& stack) {
  std::map<std::int32_t, Counts> parts;
  Box box;
  std::size_t filled = 0;
  for (const slice2mesh::Layer& layer : stack.layers) {
    if (!layer.polylines.empty()) ++filled;
    for (const slice2mesh::Polyline& line : layer.polylines) {
      Counts& counts = parts[line.part];
      ++counts.polylines[static_cast<std::size_t>(line.direction)];
      counts.points += line.points.size();
      for (const slice2mesh::Point2& p : line.points) box.add(p);
    }
    for (const slice2mesh::Hatches& hatches : layer.hatches) parts[hatches.part].hatches += hatches.lines.size();
  }
  print_line(stdout, "layers",
             std::to_string(stack.layers.size()) + " (" + std::to_string(filled) + " with polylines)");
  if (!stack.layers.empty())
    print_range("z", stack.layers.front().z * stack.z_unit, stack.layers.back().z * stack.z_unit);
  if (box.low[0] <= box.high[0]) {
    print_range("x", box.low[0] * stack.unit, box.high[0] * stack.unit);
    print_range("y", box.low[1] * stack.unit, box.high[1] * stack.unit);
  }
  for (const auto& [part, counts] : parts) {
    const auto label = stack.labels.find(part);
    const std::string name = label == stack.labels.end() ? "" : " (" + label->second + ")";
    print_line(stdout, "part " + std::to_string(part) + name,
               std::to_string(counts.polylines[1]) + " outer contours, " + std::to_string(counts.polylines[0]) +
                   " holes, " + std::to_string(counts.polylines[2]) + " open lines, " + std::to_string(counts.points) +
                   " points, " + std::to_string(counts.hatches) + " hatches");
  }
}

}  // namespace

int print_info(const std::string& path, const slice2mesh::CliReadOptions& read, const slice2mesh::SlabOptions& slabs) {
  slice2mesh::Diagnostics diagnostics;
  slice2mesh::CliReadOptions listening = read;
  listening.poll = [] { stop_if_interrupted(slice2mesh::Stage::Read); };
  const SliceStack stack = slice2mesh::read_cli(path, listening, &diagnostics);
  print_line(stdout, "file", path);
  if (stack.version) print_line(stdout, "version", short_text(*stack.version / 100.0));
  if (stack.date) print_line(stdout, "date", std::to_string(*stack.date));
  print_line(stdout, "unit", short_text(stack.unit) + " mm");
  if (stack.z_unit != stack.unit) print_line(stdout, "unit of z", short_text(stack.z_unit) + " mm");
  print_contents(stack);
  // A file whose slices make no slabs is still worth looking at.
  try {
    const slice2mesh::SlabPlan plan = slice2mesh::make_slabs(stack, slabs, diagnostics);
    print_line(stdout, "z convention", to_string(plan.convention));
    print_line(stdout, "slabs", std::to_string(plan.slabs.size()));
    print_line(stdout, "thickness", short_text(plan.thickness) + " mm (median)");
  } catch (const slice2mesh::GeometryError& error) {
    print_line(stdout, "slabs", std::string("none (") + error.what() + ")");
  }
  print_diagnostics(stdout, "", diagnostics);
  return kExitOk;
}

}  // namespace slice2mesh_program
