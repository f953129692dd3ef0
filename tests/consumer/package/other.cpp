// SPDX-License-Identifier: MIT
#include <slice2mesh/pipeline/slice_to_mesh.hpp>

// Two layers of 1 mm: a square of 4 mm, and on it a square of 2 mm.
slice2mesh::SliceStack two_layers() {
  const auto square = [](double low, double high) {
    slice2mesh::Polyline line;
    line.points = {{low, low}, {high, low}, {high, high}, {low, high}};
    return line;
  };
  slice2mesh::SliceStack stack;
  stack.layers.resize(2);
  stack.layers[0].z = 1;
  stack.layers[0].polylines = {square(0, 4)};
  stack.layers[1].z = 2;
  stack.layers[1].polylines = {square(1, 3)};
  return stack;
}
