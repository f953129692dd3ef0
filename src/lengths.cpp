// SPDX-License-Identifier: MIT
#include "lengths.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <system_error>

namespace slice2mesh_program {

namespace {

// The number at the start of `text`, which loses it. Does not depend on the locale.
std::optional<double> take_number(std::string_view& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !std::isfinite(value) || value < 0) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value == 0 ? 0.0 : value;  // -0 counts as 0
}

}  // namespace

std::optional<double> parse_number(std::string_view text) {
  const std::optional<double> value = take_number(text);
  return text.empty() ? value : std::nullopt;
}

std::optional<std::int64_t> parse_count(std::string_view text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < 0) return std::nullopt;
  return value;
}

std::optional<slice2mesh::Length> parse_length(std::string_view text) {
  const std::optional<double> value = take_number(text);
  if (!value) return std::nullopt;
  if (text.empty() || text == "mm") return slice2mesh::Length::mm(*value);
  if (text == "h") return slice2mesh::Length::layers(*value);
  return std::nullopt;
}

std::optional<std::pair<std::int32_t, slice2mesh::Length>> parse_part_length(std::string_view text) {
  std::int32_t part = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), part);
  if (error != std::errc() || end == text.data() + text.size() || *end != ':') return std::nullopt;
  const auto length = parse_length(text.substr(static_cast<std::size_t>(end - text.data()) + 1));
  if (!length) return std::nullopt;
  return std::make_pair(part, *length);
}

std::optional<slice2mesh::RefinedBall> parse_ball(std::string_view text) {
  slice2mesh::RefinedBall ball;
  for (double* const number : {&ball.x, &ball.y, &ball.z, &ball.radius}) {
    const bool last = number == &ball.radius;
    const bool negative = !text.empty() && text.front() == '-';
    if (negative) text.remove_prefix(1);
    const std::optional<double> value = take_number(text);
    if (!value || text.empty() || text.front() != (last ? ':' : ',')) return std::nullopt;
    text.remove_prefix(1);
    *number = negative ? -*value : *value;
  }
  const std::optional<slice2mesh::Length> size = parse_length(text);
  if (ball.radius < 0 || !size || size->value <= 0) return std::nullopt;
  ball.size = *size;
  return ball;
}

std::string to_text(const slice2mesh::Length& length) {
  std::array<char, 32> buffer{};
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), length.value);
  std::string text(buffer.data(), error == std::errc() ? end : buffer.data());
  if (length.relative) text += 'h';
  return text;
}

std::optional<Lump> parse_lump(std::string_view text) {
  Lump lump;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), lump.count);
  if (error == std::errc() && end == text.data() + text.size()) {
    return lump.count >= 1 ? std::optional<Lump>(lump) : std::nullopt;
  }
  const std::optional<double> thickness = take_number(text);
  if (!thickness || *thickness <= 0 || text != "mm") return std::nullopt;
  lump.count = 1;
  lump.thickness = *thickness;
  return lump;
}

}  // namespace slice2mesh_program
