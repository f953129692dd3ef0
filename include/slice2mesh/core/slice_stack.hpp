// SPDX-License-Identifier: MIT
/// @file
/// @brief SliceStack: the slices as a printer's file has them.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace slice2mesh {

/// A point in the plane.
struct Point2 {
  /// In mm or in file units, as its owner says.
  double x = 0;
  /// In mm or in file units, as its owner says.
  double y = 0;
  friend bool operator==(const Point2& a, const Point2& b) { return a.x == b.x && a.y == b.y; }
  friend bool operator!=(const Point2& a, const Point2& b) { return !(a == b); }
};

/// What a polyline bounds. The numbers are those of the CLI format.
enum class Direction : std::uint8_t {
  Inner = 0,  ///< closed, boundary of a hole
  Outer = 1,  ///< closed, outer boundary
  Open = 2    ///< open line (supports)
};

/// Process parameters that hold for a polyline or a block of hatches (CLI+); unset where the file has none.
struct ProcessParameters {
  std::optional<double> power;      ///< W
  std::optional<double> speed;      ///< mm/s
  std::optional<double> focus;      ///< in the unit of whoever wrote the file, which the format does not fix
  std::optional<double> spot_size;  ///< in the unit of whoever wrote the file, which the format does not fix
  friend bool operator==(const ProcessParameters& a, const ProcessParameters& b) {
    return a.power == b.power && a.speed == b.speed && a.focus == b.focus && a.spot_size == b.spot_size;
  }
};

/// A contour or an open line. A closed one does not repeat its first point.
struct Polyline {
  std::int32_t part = 0;  ///< part id
  /// What it bounds.
  Direction direction = Direction::Outer;
  std::vector<Point2> points;  ///< #P, in file units
  /// Process parameters.
  ProcessParameters process;
  friend bool operator==(const Polyline& a, const Polyline& b) {
    return a.part == b.part && a.direction == b.direction && a.points == b.points && a.process == b.process;
  }
};

/// A block of hatch lines (paths of the laser or nozzle); kept, not meshed.
struct Hatches {
  /// Part id.
  std::int32_t part = 0;
  std::vector<std::array<Point2, 2>> lines;  ///< #H by 2: start and end, in file units
  /// Process parameters.
  ProcessParameters process;
  friend bool operator==(const Hatches& a, const Hatches& b) {
    return a.part == b.part && a.lines == b.lines && a.process == b.process;
  }
};

/// One slice. Its z is the file's number; where it lies in the layer is decided by `make_slabs`.
struct Layer {
  double z = 0;  ///< in file units
  /// Contours and open lines: any number, in the order of the file.
  std::vector<Polyline> polylines;
  /// Blocks of hatch lines: any number, in the order of the file.
  std::vector<Hatches> hatches;
  friend bool operator==(const Layer& a, const Layer& b) {
    return a.z == b.z && a.polylines == b.polylines && a.hatches == b.hatches;
  }
};

/// The slices of a part, lowest first. Coordinates are in file units: multiply by `unit` (and z by `z_unit`) for mm.
/// Built by `read_cli` or by hand: a stack made by hand needs no more than `layers`.
struct SliceStack {
  double unit = 1;             ///< mm per unit of x and y, > 0
  double z_unit = 1;           ///< mm per unit of z, > 0 (differs from `unit` only for writers that give z in mm)
  std::optional<int> version;  ///< a hundred times the number of the version, as in the file: 200 is 2.00
  std::optional<int> date;     ///< as in the file: a number of the form DDMMYY
  std::optional<std::array<double, 6>> dimension;  ///< mm: x1 y1 z1 x2 y2 z2, as in the file
  std::map<std::int32_t, std::string> labels;      ///< names, by part id
  /// #L, lowest first.
  std::vector<Layer> layers;
  std::string source;  ///< file name, for messages; not compared

  /// Geometry and meaning are equal; header remarks (version, date, dimension, source) are not compared.
  friend bool operator==(const SliceStack& a, const SliceStack& b) {
    return a.unit == b.unit && a.z_unit == b.z_unit && a.labels == b.labels && a.layers == b.layers;
  }
};

}  // namespace slice2mesh
