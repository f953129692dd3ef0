// SPDX-License-Identifier: MIT
// Makes the sample part: slices from one's own data, written as a CLI file.
//
//   make_sample sample.cli [--binary]
//
// A bracket of 16 x 10 x 6 mm in 24 layers of 0.25 mm: a base plate, a column whose front wall slopes, a round hole
// through all of it, and a top plate that overhangs the base and is held up by support lines.
#include <cmath>
#include <cstdio>
#include <exception>
#include <string>

#include "slice2mesh/cli/write_cli.hpp"
#include "slice2mesh/core/slice_stack.hpp"

namespace {

using slice2mesh::Direction;
using slice2mesh::Layer;
using slice2mesh::Point2;
using slice2mesh::Polyline;
using slice2mesh::SliceStack;

constexpr double kLayerThickness = 0.25;  // mm
constexpr int kLayers = 24;
constexpr double kUnit = 0.001;  // mm per unit of the file
constexpr int kPartId = 1;
constexpr double kBaseTop = 2;    // mm
constexpr double kColumnTop = 4;  // mm
constexpr double kPi = 3.14159265358979323846;

// Coordinates are given in mm and kept as whole units of the file.
double units(double mm) {
  return std::round(mm / kUnit);
}
Point2 point(double x, double y) {
  return {units(x), units(y)};
}

Polyline polyline(Direction direction) {
  Polyline line;
  line.part = kPartId;
  line.direction = direction;
  return line;
}

Polyline rectangle(double x_low, double y_low, double x_high, double y_high) {
  Polyline line = polyline(Direction::Outer);
  line.points = {point(x_low, y_low), point(x_high, y_low), point(x_high, y_high), point(x_low, y_high)};
  return line;
}

Polyline hole(double x, double y, double radius, int corners) {
  Polyline line = polyline(Direction::Inner);
  for (int i = 0; i < corners; ++i) {
    const double angle = -2 * kPi * i / corners;  // clockwise
    line.points.push_back(point(x + radius * std::cos(angle), y + radius * std::sin(angle)));
  }
  return line;
}

Polyline support(double x1, double y1, double x2, double y2) {
  Polyline line = polyline(Direction::Open);
  line.points = {point(x1, y1), point(x2, y2)};
  return line;
}

// The slice of the layer between z_low and z_low + kLayerThickness (mm).
Layer slice(double z_low) {
  Layer layer;
  layer.z = units(z_low + kLayerThickness);  // the upper surface
  const double middle = z_low + kLayerThickness / 2;
  const double front = 0.3 * middle;  // the sloped wall
  const double right = middle < kBaseTop || middle > kColumnTop ? 16 : 8;
  layer.polylines.push_back(rectangle(0, front, right, 10));
  layer.polylines.push_back(hole(4, 5.5, 2, 48));
  if (middle > kBaseTop && middle < kColumnTop) {
    for (int i = 0; i <= 6; ++i) layer.polylines.push_back(support(9 + i, 2, 9 + i, 9));
    layer.polylines.push_back(support(9, 4, 15, 4));
    layer.polylines.push_back(support(9, 7, 15, 7));
  }
  return layer;
}

SliceStack bracket() {
  SliceStack stack;
  stack.unit = kUnit;
  stack.z_unit = kUnit;
  stack.version = 200;
  stack.labels[kPartId] = "bracket";
  stack.dimension = {0, 0, 0, 16, 10, kLayers * kLayerThickness};
  stack.layers.emplace_back();  // z = 0, empty: gives the thickness of the first layer
  for (int i = 0; i < kLayers; ++i) stack.layers.push_back(slice(i * kLayerThickness));
  return stack;
}

}  // namespace

int main(int argc, char* argv[]) {
  if (argc < 2 || argc > 3 || (argc == 3 && std::string(argv[2]) != "--binary")) {
    std::fputs("usage: make_sample sample.cli [--binary]\n", stderr);
    return 1;
  }
  try {
    slice2mesh::CliWriteOptions options;
    options.binary = argc == 3;
    slice2mesh::write_cli(argv[1], bracket(), options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make_sample: %s\n", error.what());
    return 2;
  }
  std::printf("%s: %d layers of %g mm\n", argv[1], kLayers, kLayerThickness);
  return 0;
}
