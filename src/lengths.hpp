// SPDX-License-Identifier: MIT
/// @file
/// @brief Lengths and numbers as they are written on the command line.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "slice2mesh/core/length.hpp"
#include "slice2mesh/pipeline/options.hpp"

namespace slice2mesh_program {

/// A finite number that is not negative, and nothing else; otherwise nothing. Does not depend on the locale.
[[nodiscard]] std::optional<double> parse_number(std::string_view text);

/// A whole number that is not negative, and nothing else; otherwise nothing.
[[nodiscard]] std::optional<std::int64_t> parse_count(std::string_view text);

/// "0.1" or "0.1mm": millimetres; "0.1h": layer thicknesses. Finite and not negative, and nothing else around it;
/// otherwise nothing.
[[nodiscard]] std::optional<slice2mesh::Length> parse_length(std::string_view text);

/// "7:0.2": a part id, which may be negative, and a length; otherwise nothing.
[[nodiscard]] std::optional<std::pair<std::int32_t, slice2mesh::Length>> parse_part_length(std::string_view text);

/// "10,-5,2,3:0.5h": center and radius of a ball in mm, and an edge length above 0; otherwise nothing.
[[nodiscard]] std::optional<slice2mesh::RefinedBall> parse_ball(std::string_view text);

/// How a length is written: "0.1" or "0.1h". The shortest text that gives the same number.
[[nodiscard]] std::string to_text(const slice2mesh::Length& length);

/// How many slices make a slab.
struct Lump {
  std::int32_t count = 1;
  double thickness = 0;  ///< mm; if > 0 it takes the place of the count
};

/// "4": four slices; "0.2mm": slices up to this thickness. Positive; otherwise nothing.
[[nodiscard]] std::optional<Lump> parse_lump(std::string_view text);

}  // namespace slice2mesh_program
