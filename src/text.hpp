// SPDX-License-Identifier: MIT
/// @file
/// @brief Small pieces of text for the standard output.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include "slice2mesh/core/diagnostics.hpp"

namespace slice2mesh_program {

/// A number with six significant digits.
[[nodiscard]] std::string short_text(double value);

/// Prints "title   value" to a stream, the title padded to a fixed width.
void print_line(std::FILE* stream, const std::string& title, const std::string& value);

/// Prints one line per finding to a stream, each line with the given words before it.
void print_diagnostics(std::FILE* stream, const std::string& before, const slice2mesh::Diagnostics& diagnostics);

}  // namespace slice2mesh_program
