// SPDX-License-Identifier: MIT
/// @file
/// @brief A quality report as a picture: the two histograms as SVG.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <ostream>
#include <string>
#include <string_view>

#include "slice2mesh/core/atomic_file.hpp"
#include "slice2mesh/core/short_number.hpp"
#include "slice2mesh/quality/format_quality.hpp"
#include "slice2mesh/quality/quality.hpp"

namespace slice2mesh {

namespace detail {

[[nodiscard]] inline std::string xml_text(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return result;
}

/// One histogram: bars of equal width, heights logarithmic, one decade per line of the grid.
inline void draw_histogram(std::string& svg, const Histogram& histogram, const std::string& title, double left,
                           double top, double width, double height, std::size_t label_step) {
  const auto number = [](double v) { return short_number(v, 6); };
  const auto label = [&](double x, double y, const char* anchor, int size, const std::string& text) {
    svg += "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\" text-anchor=\"" + anchor + "\" font-size=\"" +
           std::to_string(size) + "\">" + xml_text(text) + "</text>\n";
  };
  std::uint64_t total = 0;
  std::uint64_t largest = 1;
  for (const std::uint64_t count : histogram.counts) {
    total += count;
    largest = std::max(largest, count);
  }
  int decades = 1;
  for (std::uint64_t power = 10; power < largest && decades < 19; power *= 10) ++decades;
  // A bar of count c > 0 ends at (1 + log10 c) steps, so that a single element shows.
  const double step = height / (decades + 1);
  const double bottom = top + height;
  label(left, top - 10, "start", 14, title);
  for (int d = 0; d <= decades; ++d) {
    const double y = bottom - step * (d + 1);
    svg += "<line x1=\"" + number(left) + "\" y1=\"" + number(y) + "\" x2=\"" + number(left + width) + "\" y2=\"" +
           number(y) + "\" stroke=\"#ccc\"/>\n";
    label(left - 6, y + 4, "end", 10, "1e" + std::to_string(d));
  }
  const std::size_t bins = histogram.counts.size();
  const double bar = width / static_cast<double>(std::max<std::size_t>(bins, 1));
  for (std::size_t i = 0; i < bins; ++i) {
    const double x = left + bar * static_cast<double>(i);
    const std::uint64_t count = histogram.counts[i];
    if (count > 0) {
      const double tall = step * (1 + std::log10(static_cast<double>(count)));
      svg += "<rect x=\"" + number(x + 1) + "\" y=\"" + number(bottom - tall) + "\" width=\"" + number(bar - 2) +
             "\" height=\"" + number(tall) + "\" fill=\"#3b6ea5\"><title>" + short_number(histogram.edges[i], 4) +
             " to " + short_number(histogram.edges[i + 1], 4) + ": " + std::to_string(count) + " (" +
             percent(count, total) + ")</title></rect>\n";
    }
    if (i % label_step == 0) label(x, bottom + 14, "middle", 10, short_number(histogram.edges[i], 4));
  }
  if (!histogram.edges.empty()) label(left + width, bottom + 14, "middle", 10, short_number(histogram.edges.back(), 4));
  svg += "<line x1=\"" + number(left) + "\" y1=\"" + number(bottom) + "\" x2=\"" + number(left + width) + "\" y2=\"" +
         number(bottom) + "\" stroke=\"#000\"/>\n";
}

}  // namespace detail

/// A quality report as an SVG picture: histograms of R/3r and of the dihedral angles, with the main figures. Counts are
/// drawn on a logarithmic scale. The title is escaped.
[[nodiscard]] inline std::string quality_svg(const QualityReport& report, const std::string& title = {}) {
  using detail::short_number;
  std::string svg =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"760\" height=\"660\" viewBox=\"0 0 760 660\" "
      "font-family=\"sans-serif\">\n<rect width=\"760\" height=\"660\" fill=\"#fff\"/>\n";
  if (!title.empty())
    svg += "<text x=\"60\" y=\"28\" font-size=\"16\" font-weight=\"bold\">" + detail::xml_text(title) + "</text>\n";
  detail::draw_histogram(svg, report.ratio_histogram,
                         "R/3r of " + std::to_string(report.tets) + " tets: mean " +
                             short_number(report.ratio.mean, 4) + ", 99.9 % " + short_number(report.ratio.p999, 4) +
                             ", worst " + short_number(report.ratio.worst, 4),
                         60, 70, 660, 230, 1);
  detail::draw_histogram(svg, report.dihedral_histogram,
                         "dihedral angles (degrees): " + short_number(report.min_dihedral, 4) + " to " +
                             short_number(report.max_dihedral, 4),
                         60, 380, 660, 230, 3);
  svg += "</svg>\n";
  return svg;
}

/// Write the picture, whole or not at all. Errors: FileError.
inline void write_quality_svg(const std::string& path, const QualityReport& report, const std::string& title = {}) {
  const std::string svg = quality_svg(report, title);
  write_file_atomically(path, Stage::Write,
                        [&svg](std::ostream& out) { out.write(svg.data(), static_cast<std::streamsize>(svg.size())); });
}

}  // namespace slice2mesh
