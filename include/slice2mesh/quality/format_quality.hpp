// SPDX-License-Identifier: MIT
/// @file
/// @brief A quality report as text.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "slice2mesh/core/short_number.hpp"
#include "slice2mesh/quality/quality.hpp"

namespace slice2mesh {

namespace detail {

[[nodiscard]] inline std::string padded_left(const std::string& text, std::size_t width) {
  return text.size() < width ? std::string(width - text.size(), ' ') + text : text;
}

[[nodiscard]] inline std::string padded_right(std::string text, std::size_t width) {
  if (text.size() < width) text.append(width - text.size(), ' ');
  return text;
}

[[nodiscard]] inline std::string percent(std::uint64_t count, std::uint64_t total) {
  const double share = total == 0 ? 0 : 100 * static_cast<double>(count) / static_cast<double>(total);
  return short_number(share, 3) + " %";
}

[[nodiscard]] inline std::string figures_line(const std::string& title, const RatioFigures& figures) {
  return padded_right(title, 20) + "mean " + short_number(figures.mean, 4) + ", median " +
         short_number(figures.median, 4) + ", 99 % " + short_number(figures.p99, 4) + ", 99.9 % " +
         short_number(figures.p999, 4) + ", worst " + short_number(figures.worst, 4) + "\n";
}

}  // namespace detail

/// A histogram as lines of text: bin, count, share, and a bar whose length grows with the logarithm of the count, so
/// that single elements show beside millions. Empty bins before the first and after the last value are left out.
[[nodiscard]] inline std::string format_histogram(const Histogram& histogram, const std::string& unit = {}) {
  std::uint64_t total = 0;
  std::uint64_t largest = 0;
  std::size_t first = histogram.counts.size();
  std::size_t last = 0;
  for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
    total += histogram.counts[i];
    largest = std::max(largest, histogram.counts[i]);
    if (histogram.counts[i] == 0) continue;
    first = std::min(first, i);
    last = i;
  }
  constexpr double kBarLength = 40;
  std::string text;
  for (std::size_t i = first; i < histogram.counts.size() && i <= last; ++i) {
    const std::uint64_t count = histogram.counts[i];
    const double share = std::log1p(static_cast<double>(count)) / std::log1p(static_cast<double>(largest));
    const auto bar = static_cast<std::size_t>(std::ceil(share * kBarLength));
    text += "  " + detail::padded_left(detail::short_number(histogram.edges[i], 4), 5) + " to " +
            detail::padded_left(detail::short_number(histogram.edges[i + 1], 4), 5) + unit +
            detail::padded_left(std::to_string(count), 12) + detail::padded_left(detail::percent(count, total), 12);
    if (bar > 0) text += "  " + std::string(bar, '#');
    text += '\n';
  }
  return text;
}

/// A quality report as text: a table of the figures, the two histograms, the worst elements. Ends with a line end.
[[nodiscard]] inline std::string format_quality(const QualityReport& report) {
  using detail::padded_left;
  using detail::padded_right;
  using detail::short_number;
  std::string text;
  const auto line = [&text](const std::string& title, const std::string& value) {
    text += padded_right(title, 20) + value + "\n";
  };
  line("tets", std::to_string(report.tets));
  line("vertices", std::to_string(report.vertices));
  line("volume", short_number(report.volume, 10) + " mm^3");
  if (report.tets == 0) return text;
  text += detail::figures_line("R/3r", report.ratio);
  if (report.metric_ratio) {
    text += detail::figures_line("R/3r in the metric", *report.metric_ratio);
    line("metric", "l = " + short_number(report.metric_l, 4) + " mm, h = " + short_number(report.metric_h, 4) + " mm");
  }
  line("dihedral angles",
       short_number(report.min_dihedral, 4) + " to " + short_number(report.max_dihedral, 4) + " degrees");
  line("crossing a slab", std::to_string(report.crossing) + " (" + detail::percent(report.crossing, report.tets) + ")");
  line("wrong slab label", std::to_string(report.mislabeled));
  line("flat or inverted", std::to_string(report.not_positive));
  line("columns", std::to_string(report.columns) + " (" + detail::percent(report.columns, report.tets) + ")");
  line("R/3r above " + short_number(report.forced.above, 4),
       std::to_string(report.forced.elements) + ", forced by the input " + std::to_string(report.forced.forced()) +
           " (angle " + std::to_string(report.forced.small_input_angle) + ", thin wall " +
           std::to_string(report.forced.thin_wall) + "); worst of the others " +
           short_number(report.forced.worst_other, 4));
  text += "\nR/3r (bars logarithmic)\n" + format_histogram(report.ratio_histogram);
  text += "\ndihedral angles, degrees (bars logarithmic)\n" + format_histogram(report.dihedral_histogram);
  if (!report.worst.empty()) {
    text += "\nworst elements\n       R/3r         tet   slab region  smallest and largest angle  edges (mm)";
    text += "               at (mm)\n";
    for (const WorstTet& w : report.worst)
      text += padded_left(short_number(w.ratio, 4), 11) + padded_left(std::to_string(w.tet), 12) +
              padded_left(std::to_string(w.slab), 7) + padded_left(std::to_string(w.region), 7) +
              padded_left(short_number(w.min_dihedral, 4), 15) + padded_left(short_number(w.max_dihedral, 4), 13) +
              "  " + padded_right(short_number(w.shortest_edge, 4) + " to " + short_number(w.longest_edge, 4), 24) +
              " " + short_number(w.centroid[0], 6) + ", " + short_number(w.centroid[1], 6) + ", " +
              short_number(w.centroid[2], 6) + "  " + to_string(w.cause) + "\n";
  }
  return text;
}

}  // namespace slice2mesh
