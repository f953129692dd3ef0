// SPDX-License-Identifier: MIT
// Slices of a closed triangle mesh, for those who have none: STL (or OFF, OBJ, PLY) in, CLI out.
//
//   slices_from_mesh part.stl part.cli 0.1      layers of 0.1 mm; the file counts in mm
//   slices_from_mesh part.stl part.cli 1/60     layers of a 60th of the largest extent of the part
//   slices_from_mesh --sample washer.stl        writes a conical washer to try it with
//
// Each layer is cut in the middle of its height, and its z is its upper surface, as CLI files have it. The part is
// moved so that it begins at z = 0. CGAL::Polygon_mesh_slicer does the cutting; it is under the GPL.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_2_algorithms.h>
#include <CGAL/Polygon_mesh_slicer.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/IO/polygon_mesh_io.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iostream>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "slice2mesh/cli/write_cli.hpp"
#include "slice2mesh/core/atomic_file.hpp"

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using TriangleMesh = CGAL::Surface_mesh<Point>;
using Loop = std::vector<Kernel::Point_2>;

// A washer: inner radius 1.5, outer radius 4 at the bottom and 3 at the top, 3 high (mm).
void write_sample(const std::string& path) {
  constexpr int kCorners = 40;
  constexpr double kPi = 3.14159265358979323846;
  const std::array<std::array<double, 2>, 4> profile = {{{1.5, 0}, {4, 0}, {3, 3}, {1.5, 3}}};  // radius, z
  slice2mesh::write_file_atomically(path, slice2mesh::Stage::Write, [&](std::ostream& out) {
    const auto vertex = [&](int i, int k) {
      const double angle = 2 * kPi * (i % kCorners) / kCorners;
      const auto& [radius, z] = profile[static_cast<std::size_t>(k % 4)];
      out << "      vertex " << radius * std::cos(angle) << ' ' << radius * std::sin(angle) << ' ' << z << '\n';
    };
    const auto triangle = [&](std::array<std::array<int, 2>, 3> corners) {
      out << "  facet normal 0 0 0\n    outer loop\n";
      for (const auto& [i, k] : corners) vertex(i, k);
      out << "    endloop\n  endfacet\n";
    };
    out << "solid washer\n";
    for (int i = 0; i < kCorners; ++i) {
      for (int k = 0; k < 4; ++k) {
        triangle({{{i, k}, {i + 1, k + 1}, {i, k + 1}}});
        triangle({{{i, k}, {i + 1, k}, {i + 1, k + 1}}});
      }
    }
    out << "endsolid washer\n";
  });
}

// Largest extent along x, y or z.
double extent_of(const TriangleMesh& mesh) {
  double largest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const auto v : mesh.vertices()) {
      low = std::min(low, mesh.point(v)[axis]);
      high = std::max(high, mesh.point(v)[axis]);
    }
    largest = std::max(largest, high - low);
  }
  return largest;
}

slice2mesh::SliceStack slices_of(const TriangleMesh& mesh, double thickness) {
  double bottom = std::numeric_limits<double>::infinity(), top = -bottom;
  for (const auto v : mesh.vertices()) {
    bottom = std::min(bottom, mesh.point(v).z());
    top = std::max(top, mesh.point(v).z());
  }
  // A last layer of less than half the thickness is left out.
  const auto layers = std::max(1L, std::lround((top - bottom) / thickness));

  slice2mesh::SliceStack stack;
  stack.layers.emplace_back();  // z = 0, empty: where the first layer begins
  CGAL::Polygon_mesh_slicer<TriangleMesh, Kernel> slicer(mesh);
  for (long k = 0; k < layers; ++k) {
    const double middle = bottom + (static_cast<double>(k) + 0.5) * thickness;
    std::vector<std::vector<Point>> cuts;
    if (middle < top) slicer(Kernel::Plane_3(0, 0, 1, -middle), std::back_inserter(cuts));

    std::vector<Loop> loops;
    for (const std::vector<Point>& cut : cuts) {
      if (cut.size() < 4 || cut.front() != cut.back()) continue;  // touched only: no area
      Loop loop;
      for (std::size_t i = 0; i + 1 < cut.size(); ++i) loop.emplace_back(cut[i].x(), cut[i].y());
      loops.push_back(std::move(loop));
    }
    slice2mesh::Layer layer;
    layer.z = static_cast<double>(k + 1) * thickness;
    for (const Loop& loop : loops) {
      // Cuts do not cross: one that is inside of an odd number of others bounds a hole.
      const auto around = std::count_if(loops.begin(), loops.end(), [&loop](const Loop& other) {
        return &other != &loop &&
               CGAL::bounded_side_2(other.begin(), other.end(), loop.front(), Kernel()) == CGAL::ON_BOUNDED_SIDE;
      });
      slice2mesh::Polyline line;
      line.part = 1;
      line.direction = around % 2 == 1 ? slice2mesh::Direction::Inner : slice2mesh::Direction::Outer;
      for (const auto& p : loop) line.points.push_back({p.x(), p.y()});
      double area = 0;  // twice; outer contours go counter-clockwise, holes clockwise
      for (std::size_t i = 0; i < line.points.size(); ++i) {
        const auto &a = line.points[i], &b = line.points[(i + 1) % line.points.size()];
        area += a.x * b.y - a.y * b.x;
      }
      if ((area > 0) != (line.direction == slice2mesh::Direction::Outer))
        std::reverse(line.points.begin(), line.points.end());
      layer.polylines.push_back(std::move(line));
    }
    stack.layers.push_back(std::move(layer));
  }
  return stack;
}

}  // namespace

int main(int argc, char* argv[]) try {
  if (argc == 3 && std::string(argv[1]) == "--sample") {
    write_sample(argv[2]);
    return 0;
  }
  const std::string text = argc == 4 ? argv[3] : "";
  const bool is_share = text.compare(0, 2, "1/") == 0;
  const std::string number = is_share ? text.substr(2) : text;
  double value = 0;
  const auto read = std::from_chars(number.data(), number.data() + number.size(), value);
  if (read.ec != std::errc() || read.ptr != number.data() + number.size() || !(value > 0))
    throw std::runtime_error("usage: slices_from_mesh part.stl part.cli THICKNESS|1/NUMBER");
  TriangleMesh mesh;
  if (!CGAL::IO::read_polygon_mesh(std::string(argv[1]), mesh) || mesh.number_of_faces() == 0)
    throw std::runtime_error(std::string(argv[1]) + " is not a readable triangle mesh");
  if (!CGAL::is_closed(mesh) || !CGAL::is_triangle_mesh(mesh))
    throw std::runtime_error(std::string(argv[1]) + " is not a closed mesh of triangles");

  const slice2mesh::SliceStack stack = slices_of(mesh, is_share ? extent_of(mesh) / value : value);
  std::size_t contours = 0, holes = 0;
  for (const slice2mesh::Layer& layer : stack.layers) {
    for (const slice2mesh::Polyline& line : layer.polylines) {
      ++contours;
      if (line.direction == slice2mesh::Direction::Inner) ++holes;
    }
  }
  slice2mesh::write_cli(argv[2], stack);
  std::cout << stack.layers.size() - 1 << " layers, " << contours << " contours, " << holes << " of them holes\n";
} catch (const std::exception& error) {
  std::cerr << "slices_from_mesh: " << error.what() << '\n';
  return 1;
}
