// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "fuzz/byte_source.hpp"
#include "fuzz/targets.hpp"
#include "slice2mesh/harmonize/harmonize.hpp"
#include "slice2mesh/regions/base_plate.hpp"
#include "slice2mesh/regions/slabs.hpp"
#include "torture/generators.hpp"
#include "torture/pipeline_runner.hpp"

namespace slice2mesh_fuzz {

using namespace slice2mesh;
using namespace slice2mesh_test;

namespace {

// Coordinates: a small lattice, where everything coincides, or free ones, or lattice points that are moved by little.
class Places {
public:
  explicit Places(ByteSource& bytes) : bytes_(bytes) {
    kind_ = bytes.whole(0, 2);
    little_ = std::ldexp(1.0, -bytes.whole(0, 45));
  }
  [[nodiscard]] double coordinate() {
    if (kind_ == 0) return bytes_.whole(0, 8);
    if (kind_ == 1) return bytes_.whole(0, 2047) / 256.0;
    return bytes_.whole(0, 8) + little_ * bytes_.whole(-3, 3);
  }
  [[nodiscard]] Point2 point() {
    const double x = coordinate();
    return {x, coordinate()};
  }

private:
  ByteSource& bytes_;
  int kind_ = 0;
  double little_ = 0;
};

// A difference of coordinates. Bytes are taken one after the other: the order of arguments is up to the compiler.
double little(ByteSource& bytes) {
  const int times = bytes.whole(-3, 3);
  return std::ldexp(times, -4 * bytes.whole(1, 12));
}

// Is something of one slice thinner than the smallest tolerance? Then there may be no mesh, see docs/reliability.md.
bool has_thin_part(const SliceStack& stack, const Options& options) {
  Diagnostics diagnostics;
  const SlabPlan plan = make_slabs(stack, options.slabs, diagnostics);
  const LayerRegions regions = build_regions_on_plate(stack, plan, options.supports, options.plate, diagnostics);
  return std::any_of(regions.outlines.begin(), regions.outlines.end(), [](const Outline& outline) {
    return !detail::vertices_beside_edges(outline, detail::kSmallestEps, {}, 0, detail::EdgeEnds::With).empty();
  });
}

}  // namespace

void pipeline(const std::uint8_t* data, std::size_t size) {
  ByteSource bytes(data, size);
  constexpr double kScales[] = {1, 1e-6, 1e6, 1e-3, 1e3, 1e-12, 1e12, 1e100};
  const double scale = bytes.flag() ? kScales[bytes.whole(0, 7)] : 1;
  const double shift = bytes.flag() ? scale * std::pow(10.0, bytes.whole(0, 16)) : 0;
  const double heights[] = {0.5, 0.5, 1e-3, 50};
  const double height = heights[bytes.whole(0, 3)];
  Options options;
  options.eps = Length::layers(bytes.flag() ? 0.1 : bytes.share());
  if (bytes.whole(0, 3) == 3) options.eps = Length::mm(0);
  options.supports.radius = Length::mm(bytes.flag() ? scale * (1.0 / 256 + bytes.share()) : 0);
  options.supports.cap = static_cast<LineCap>(bytes.whole(0, 2));
  options.supports.join = static_cast<LineJoin>(bytes.whole(0, 1));
  options.slabs.lump = bytes.whole(0, 7) == 7 ? 2 : 1;
  options.slabs.thickness = height * scale;
  options.slabs.z_convention = static_cast<ZConvention>(bytes.whole(0, 15) < 11 ? 0 : bytes.whole(0, 4));
  options.size.size = Length::mm(scale * (1 + bytes.whole(0, 3)));
  if (bytes.whole(0, 7) == 7) {
    options.plate.thickness = Length::layers(1 + bytes.whole(0, 3));
    options.plate.margin = Length::mm(scale * (0.25 + bytes.share()));
    options.plate.shape = static_cast<BasePlateShape>(bytes.whole(0, 1));
  }
  options.improve.rounds = bytes.whole(0, 3);
  options.budget.max_vertices = 3000;
  options.budget.max_tets = 15000;
  options.budget.time_limit = 10;

  Places places(bytes);
  SliceStack stack;
  std::vector<Polyline> last;
  const int layers = bytes.whole(1, 5);
  for (int l = 0; l < layers; ++l) {
    Layer layer;
    layer.z = height * l;
    if (bytes.whole(0, 3) == 3) layer.polylines = last;  // the layer below once more
    for (int n = bytes.whole(0, 4); n > 0; --n) {
      Polyline line;
      line.part = bytes.whole(0, 7) == 7 ? 1 : 0;
      line.direction = static_cast<Direction>(bytes.whole(0, 7) < 5 ? 1 : bytes.whole(0, 2));
      switch (bytes.whole(0, 3)) {
        case 0:  // any loop
          for (int k = bytes.whole(1, 9); k > 0; --k) line.points.push_back(places.point());
          break;
        case 1: {  // a box
          const Point2 a = places.point(), b = places.point();
          line.points = {a, {b.x, a.y}, b, {a.x, b.y}};
          break;
        }
        case 2: {  // a star
          const Point2 center = places.point();
          const double radius = 0.5 + bytes.whole(0, 15) / 4.0;
          const int corners = 3 + bytes.whole(0, 29);
          const double depth = bytes.whole(0, 7) / 8.0;
          line.points = torture::star(center, radius, corners, depth, bytes.whole(0, 15) * 1e-3).points;
          break;
        }
        default:  // a loop of the layer below, moved a little
          if (!last.empty()) line = last[static_cast<std::size_t>(bytes.whole(0, static_cast<int>(last.size()) - 1))];
          for (Point2& p : line.points) {
            p.x += little(bytes);
            if (bytes.flag()) p.y += little(bytes);
          }
      }
      layer.polylines.push_back(std::move(line));
    }
    last = layer.polylines;
    stack.layers.push_back(std::move(layer));
  }
  for (Layer& layer : stack.layers) {
    layer.z *= scale;
    for (Polyline& line : layer.polylines)
      for (Point2& p : line.points) p = {p.x * scale + shift, p.y * scale + shift};
  }
  const Outcome outcome = run_pipeline(stack, options);
  switch (outcome.ending) {
    case Ending::NotWhatItSays:
    case Ending::Foreign:
    case Ending::OtherError:
    case Ending::Cancelled: throw Failure(std::string(to_string(outcome.ending)) + ": " + outcome.message);
    case Ending::TetrahedralizationError:
      if (exact_neighbors_nearly_coincide(stack, options)) break;
      [[fallthrough]];
    case Ending::NotCertified:
      if (!has_thin_part(stack, options))
        throw Failure(std::string(to_string(outcome.ending)) + ", but nothing is thin: " + outcome.message);
      break;
    default: break;
  }
}

}  // namespace slice2mesh_fuzz
