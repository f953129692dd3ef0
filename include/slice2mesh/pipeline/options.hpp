// SPDX-License-Identifier: MIT
/// @file
/// @brief Options of the whole pipeline: one aggregate, every field defaulted.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "slice2mesh/core/length.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/core/size_function.hpp"
#include "slice2mesh/core/slice_stack.hpp"

namespace slice2mesh {

/// Where the z of a slice lies in its layer.
enum class ZConvention : std::uint8_t {
  Auto,    ///< make_slabs chooses by the z of the slices, and says so in a note
  Top,     ///< the upper face: a layer reaches from the z of the slice below to its own
  Bottom,  ///< the lower face: from its own z to that of the slice above
  Middle,  ///< half way: layers meet halfway between slices
  Paper    ///< upward from z, and the last slice is dropped, as the reference implementation does
};

/// How a z convention is written in options and reports.
[[nodiscard]] constexpr const char* to_string(ZConvention convention) noexcept {
  switch (convention) {
    case ZConvention::Auto: return "auto";
    case ZConvention::Top: return "top";
    case ZConvention::Bottom: return "bottom";
    case ZConvention::Middle: return "middle";
    case ZConvention::Paper: return "paper";
  }
  return "unknown";
}

/// From slices to slabs.
struct SlabOptions {
  /// Where the z of a slice lies.
  ZConvention z_convention = ZConvention::Auto;
  std::int32_t lump = 1;        ///< number of slices that become one slab, >= 1; the middle one stands for the bundle
  double lump_thickness = 0;    ///< mm; if > 0, slices are bundled up to this thickness instead of by number
  bool with_open_lines = true;  ///< a slice that has only open lines counts as filled
  double thickness = 0;         ///< mm, of a stack of one slice; 0: taken from its z
};

/// The end of a thickened line.
enum class LineCap : std::uint8_t {
  Round,   ///< half a disc
  Square,  ///< half a square beyond the end
  Flat     ///< nothing beyond the end
};
/// The corner of a thickened line.
enum class LineJoin : std::uint8_t {
  Round,  ///< an arc
  Miter   ///< the outer sides led on until they meet, within `miter_limit`
};

/// From open lines to areas.
struct ThickenOptions {
  Length radius = Length::mm(0);  ///< half the width of a support line; 0: supports are left out
  /// Half the width of the lines, by part id, in place of `radius`; 0: they are left out.
  std::map<std::int32_t, Length> part_radius;
  /// If set, half the width of each line, in place of both: of an open polyline as it is in the stack (points in file
  /// units) and the index of its layer there. The same for the same line, whenever it is asked; 0: the line is left
  /// out.
  std::function<Length(const Polyline& line, std::int32_t layer)> line_radius;
  /// Ends of lines.
  LineCap cap = LineCap::Square;
  /// Corners of lines.
  LineJoin join = LineJoin::Miter;
  double miter_limit = 2;  ///< mitres longer than this times the radius are beveled, >= 1
  double arc_tolerance =
      0.05;  ///< of round ends and joints: largest distance from the true arc, as a share of the radius, (0, 1)
  double simplify =
      0.01;  ///< Douglas-Peucker tolerance on the line, as a share of the radius, >= 0 (the paper's value)
};

/// What a base plate follows.
enum class BasePlateShape : std::uint8_t {
  Box,    ///< the box around the whole part
  Offset  ///< the first slice without its holes
};

/// A plate under the part.
struct BasePlateOptions {
  Length thickness = Length::mm(0);    ///< 0: no plate
  Length margin = Length::layers(10);  ///< how far it reaches beyond the part, at least 2 eps and above 0
  /// What the plate follows.
  BasePlateShape shape = BasePlateShape::Box;
  std::int32_t slabs = 0;  ///< number of slabs of equal height, >= 0; 0: higher ones the deeper they lie
};

/// A ball with smaller elements. Outside of it sizes grow with the distance (`SizeOptions::growth`).
struct RefinedBall {
  double x = 0;                     ///< mm, center
  double y = 0;                     ///< mm, center
  double z = 0;                     ///< mm, center
  double radius = 0;                ///< mm, >= 0
  Length size = Length::layers(1);  ///< horizontal edge length, > 0
};

/// Horizontal element size.
struct SizeOptions {
  /// Target edge length in the interior. 0: twice the layer thickness, or more (up to `coarsest`) where that would give
  /// more than `automatic_tets` elements.
  Length size = Length::mm(0);
  Length coarsest = Length::layers(40);  ///< of the automatic size, > 0
  double automatic_tets = 4e6;           ///< number of tets that the automatic size aims to stay below, > 0
  Length contour_size = Length::mm(0);   ///< longest edge of a contour; 0: chosen from `size` and the layer thickness
  /// Growth of sizes with the distance from contours and from `refined`, as a ratio to it, 0.05 to 10.
  double growth = 0.5;
  std::vector<RefinedBall> refined;  ///< any number: where elements are smaller
  /// The edge length wanted at (x, y, z) in mm, coordinates of the slices, z between the planes too: mm, > 0, what is
  /// above `size` counts as that. Where it does not depend on z, planes keep to one lattice. It is called often,
  /// all over the box around the part, and looked at about every `size`: it should change by less than half of the
  /// distance.
  SizeFunction size_at;
};

/// Improvement of the elements.
struct ImproveOptions {
  std::int32_t rounds = 16;   ///< number of rounds, >= 0; 0 leaves the raw fill
  double target = 1.45;       ///< R/3r above which tets are flipped, and contours moved at them, >= 1
  double collapse_above = 2;  ///< R/3r above which vertices of tets are taken out where that gains, >= 1
  double most_work = 4.2e7;   ///< number of rated tets after which the rounds end, >= 0, apart from a quarter more for
                              ///< the worst elements; below ten times the number of tets, columns of long elements are
                              ///< left alone for what is worse than they are
  bool move_contours = true;  ///< move contour vertices too, within eps, where elements gain
  /// Keep vertical edges where no element at them is bad (R/3r above 3, or a dihedral angle below 13.5 degrees), though
  /// elements gain without them: where neighboring contours are the same, neighboring planes are too, and the slab is
  /// prisms cut in three.
  bool keep_columns = false;
};

/// Limits of one run; 0 means no limit.
struct Budget {
  /// Number of vertices of the mesh, >= 0.
  std::int64_t max_vertices = 0;
  /// Number of tets of the mesh, >= 0.
  std::int64_t max_tets = 0;
  double time_limit = 0;  ///< s of wall-clock time, >= 0
};

/// Everything `slice_to_mesh` can be told. `Options{}` is a good start.
struct Options {
  /// From slices to slabs.
  SlabOptions slabs;
  /// Open lines.
  ThickenOptions supports;
  /// Base plate.
  BasePlateOptions plate;
  Length eps = Length::layers(0.1);  ///< tolerance of harmonization; 0: exact mode of the paper
  /// Horizontal element size.
  SizeOptions size;
  /// Improvement of the elements.
  ImproveOptions improve;
  bool finer_slices = true;  ///< estimate the volume loss of bundles from all their slices, which have to be united
  /// Limits of the run.
  Budget budget;
  /// Listener; may cancel.
  Progress progress;
};

}  // namespace slice2mesh
