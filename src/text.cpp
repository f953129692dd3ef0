// SPDX-License-Identifier: MIT
#include "text.hpp"

#include <array>
#include <charconv>
#include <system_error>

namespace slice2mesh_program {

std::string short_text(double value) {
  std::array<char, 32> buffer{};
  const auto [end, error] =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::general, 6);
  return {buffer.data(), error == std::errc() ? end : buffer.data()};
}

void print_line(std::FILE* stream, const std::string& title, const std::string& value) {
  constexpr int kTitleWidth = 20;
  std::fprintf(stream, "%-*s%s\n", kTitleWidth, title.c_str(), value.c_str());
}

void print_diagnostics(std::FILE* stream, const std::string& before, const slice2mesh::Diagnostics& diagnostics) {
  for (const slice2mesh::Diagnostic& entry : diagnostics.entries()) {
    std::string place;
    if (entry.layer >= 0) place += ", layer " + std::to_string(entry.layer);
    if (entry.polyline >= 0) place += ", polyline " + std::to_string(entry.polyline);
    const std::string times = entry.count > 1 ? " (" + std::to_string(entry.count) + " times)" : "";
    std::fprintf(stream, "%s%s (%s%s): %s%s\n", before.c_str(), to_string(entry.severity), to_string(entry.stage),
                 place.c_str(), entry.message.c_str(), times.c_str());
  }
}

}  // namespace slice2mesh_program
