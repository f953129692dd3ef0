// SPDX-License-Identifier: MIT
// A picture (SVG) of two consecutive slices and of the interface between them: on the left the slices as they are in
// the file, in the middle their contours after harmonization, on the right the triangles of the plane that they share.
//
//   slices_svg part.cli picture.svg [index of the lower slab, default: the one with the largest steps above it]
#include <slice2mesh/slice2mesh.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <iostream>
#include <string>

namespace {

struct Box {
  double x_low = 1e300, y_low = 1e300, x_high = -1e300, y_high = -1e300;
  void add(double x, double y) {
    x_low = std::min(x_low, x);
    x_high = std::max(x_high, x);
    y_low = std::min(y_low, y);
    y_high = std::max(y_high, y);
  }
};

// Draws in mm; y points up. The panels lie side by side.
class Picture {
public:
  Picture(std::ostream& out, const Box& box, int panels) : out_(out), box_(box) {
    scale_ = kWidth / std::max(box.x_high - box.x_low, 1e-9);
    height_ = (box.y_high - box.y_low) * scale_;
    out_ << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << panels * (kWidth + 2 * kMargin) << "\" height=\""
         << height_ + 2 * kMargin << "\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  }
  void title(int panel, const std::string& text) {
    out_ << "<text x=\"" << panel * (kWidth + 2 * kMargin) + kMargin
         << "\" y=\"14\" font-family=\"sans-serif\" font-size=\"13\">" << text << "</text>\n";
  }
  template <class Points>  // of pairs x, y in mm
  void line(int panel, const Points& points, bool closed, const char* style) {
    out_ << "<path d=\"";
    char command = 'M';
    for (const auto& [x, y] : points) {
      out_ << command << panel * (kWidth + 2 * kMargin) + kMargin + (x - box_.x_low) * scale_ << ' '
           << kMargin + height_ - (y - box_.y_low) * scale_;
      command = 'L';
    }
    out_ << (closed ? "Z" : "") << "\" " << style << "/>\n";
  }
  void end() { out_ << "</svg>\n"; }

private:
  static constexpr double kWidth = 420;  // pixels
  static constexpr double kMargin = 20;
  std::ostream& out_;
  Box box_;
  double scale_ = 1;
  double height_ = 0;
};

}  // namespace

int main(int argc, char* argv[]) try {
  using namespace slice2mesh;
  if (argc != 3 && argc != 4) throw std::runtime_error("usage: slices_svg part.cli picture.svg [slab]");
  const SliceStack stack = read_cli(argv[1]);
  Options options;
  options.slabs.lump = 3;
  options.supports.radius = Length::mm(0.1);
  Diagnostics diagnostics;
  const SlabPlan plan = make_slabs(stack, options.slabs, diagnostics);
  const LayerRegions regions = build_regions(stack, plan, options.supports, diagnostics);
  const PlaneSizes sizes = resolve_sizes(options.size, regions);
  HarmonizeOptions harmonize_options;
  harmonize_options.eps = options.eps.in_mm(plan.thickness);
  harmonize_options.contour_size = sizes.contour_size;
  const Contours contours = harmonize(regions, harmonize_options, diagnostics);
  const PlaneStack planes = triangulate_planes(contours, sizes);
  const Plc plc = build_plc(contours, planes.meshes, planes.slab_planes);

  // Area by label on the upper plane of every slab, to find the one with the largest steps.
  std::vector<double> steps(contours.slabs.size());
  const auto plane_of = [&plc](const Facet& f) { return plc.vertex_plane[static_cast<std::size_t>(f.vertices[0])]; };
  const auto corners = [&plc](const Facet& f) {
    std::array<std::array<double, 2>, 3> points{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto p = plc.position(static_cast<std::size_t>(f.vertices[i]));
      points[i] = {p[0], p[1]};
    }
    return points;
  };
  for (const Facet& f : plc.facets) {
    if (f.label != FacetLabel::Up && f.label != FacetLabel::Down) continue;
    const auto [a, b, c] = corners(f);
    const double area = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
    for (std::size_t s = 0; s + 1 < steps.size(); ++s)
      if (plc.slab_planes[s][1] == plane_of(f) && plc.slab_planes[s + 1][0] == plane_of(f))
        steps[s] += area < 0 ? -area : area;
  }
  std::size_t slab = static_cast<std::size_t>(std::max_element(steps.begin(), steps.end()) - steps.begin());
  if (argc == 4) {
    const std::string text = argv[3];
    const auto read = std::from_chars(text.data(), text.data() + text.size(), slab);
    if (read.ec != std::errc() || read.ptr != text.data() + text.size()) throw std::runtime_error("no index: " + text);
  }
  if (slab + 1 >= contours.slabs.size()) throw std::runtime_error("there is no slab above");

  Box box;
  for (const Layer& layer : stack.layers)
    for (const Polyline& line : layer.polylines)
      for (const Point2& p : line.points) box.add(p.x * stack.unit, p.y * stack.unit);

  std::array<int, 3> counts{};  // down, up, interface: the order of FacetLabel
  write_file_atomically(argv[2], Stage::Write, [&](std::ostream& out) {
    constexpr std::array<const char*, 2> kSlices = {"fill=\"none\" stroke=\"#1f77b4\"",
                                                    "fill=\"none\" stroke=\"#d62728\""};
    constexpr std::array<const char*, 3> kLabels = {"fill=\"#f4a582\" stroke=\"#555\" stroke-width=\"0.4\"",
                                                    "fill=\"#92c5de\" stroke=\"#555\" stroke-width=\"0.4\"",
                                                    "fill=\"#eeeeee\" stroke=\"#999\" stroke-width=\"0.4\""};
    Picture picture(out, box, 3);
    picture.title(0, "slices " + std::to_string(contours.slabs[slab].slice) + " (blue) and " +
                         std::to_string(contours.slabs[slab + 1].slice) + " (red)");
    picture.title(1, "harmonized contours");
    picture.title(2, "interface: steps up blue, overhangs red");
    for (std::size_t k = 0; k < 2; ++k) {
      const Slab& which = contours.slabs[slab + k];
      for (const Polyline& line : stack.layers[static_cast<std::size_t>(which.slice)].polylines) {
        std::vector<std::array<double, 2>> points;
        for (const Point2& p : line.points) points.push_back({p.x * stack.unit, p.y * stack.unit});
        picture.line(0, points, line.direction != Direction::Open, kSlices[k]);
      }
      const Outline& outline = contours.outlines[slab + k];
      for (const Outline::Edge& e : outline.edges) {
        std::array<std::array<double, 2>, 2> ends{};
        for (std::size_t i = 0; i < 2; ++i) {
          const GridPoint& p = outline.vertices[static_cast<std::size_t>(i == 0 ? e.a : e.b)];
          ends[i] = {contours.grid.x_mm(p), contours.grid.y_mm(p)};
        }
        picture.line(1, ends, false, kSlices[k]);
      }
    }
    for (const Facet& f : plc.facets) {
      const auto label = static_cast<std::size_t>(f.label);
      if (label >= kLabels.size() || plane_of(f) != plc.slab_planes[slab][1]) continue;
      picture.line(2, corners(f), true, kLabels[label]);
      ++counts[label];
    }
    picture.end();
  });
  std::cout << "plane above slab " << slab << ": " << counts[2] << " interface triangles, " << counts[1] << " up, "
            << counts[0] << " down\n";
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
