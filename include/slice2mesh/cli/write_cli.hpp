// SPDX-License-Identifier: MIT
/// @file
/// @brief Writer of the Common Layer Interface (CLI), text and binary.
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "slice2mesh/cli/cli_limits.hpp"
#include "slice2mesh/core/atomic_file.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/slice_stack.hpp"

namespace slice2mesh {

/// How a CLI file is written.
struct CliWriteOptions {
  bool binary = false;          ///< text (every number reads back exactly) or binary (32-bit floats)
  bool short_commands = false;  ///< binary: 16-bit commands for polylines, hatches and layers whose numbers fit
  bool align = false;           ///< binary: `$$ALIGN`, commands filled up to multiples of 32 bits
  bool exact = false;           ///< throw instead of writing a file that says less than the stack
  /// Called now and then; what it throws ends the writing and goes on to the caller, and where a path was given an
  /// older file is as it was.
  std::function<void()> poll;
};

/// What a written file does not say exactly.
struct CliWriteReport {
  std::uint64_t rounded_numbers = 0;  ///< binary: numbers that are not 32-bit floats and were rounded
  double largest_rounding = 0;        ///< mm, the largest change of a number by its rounding
  std::uint64_t lost_parameters = 0;  ///< number of blocks whose process parameters could not be written: binary files
                                      ///< have no command for them, and in text a parameter cannot be unset
  std::uint64_t bytes = 0;            ///< size of the file in bytes
};

namespace detail {

class CliWriter {
public:
  CliWriter(std::ostream& stream, const SliceStack& stack, const CliWriteOptions& options)
      : stream_(stream), stack_(stack), options_(options),
        z_scale_(stack.z_unit == stack.unit ? 1 : stack.z_unit / stack.unit) {}

  CliWriteReport write() {
    check();
    measure();
    header();
    if (options_.binary)
      binary();
    else
      text();
    flush();
    if (!stream_) throw FileError(Stage::Write, "<stream>", "cannot be written");
    return report_;
  }

private:
  static constexpr std::size_t kBlock = std::size_t{1} << 16;
  static constexpr double kShortHighUnsigned = 65535;
  static constexpr double kShortLow = -32768;
  static constexpr double kShortHighSigned = 32767;
  static constexpr std::size_t kShortCount = 65535;

  void listen() const {
    if (options_.poll) options_.poll();
  }

  // ---- what can be written

  void check() const {
    const auto positive = [](double v) { return std::isfinite(v) && v > 0; };
    if (!positive(stack_.unit) || !positive(stack_.z_unit))
      throw Error(Stage::Write, "the units of the stack must be positive numbers");
    if (!(stack_.unit >= kCliSmallestUnit && stack_.unit <= kCliLargestUnit))
      throw Error(Stage::Write, "the unit of the stack is out of range (1e-9 to 1e6 mm)");
    for (const auto& [id, text] : stack_.labels) {
      bool good = text.find("$$") == std::string::npos && text.find("//") == std::string::npos;
      for (const char c : text) good = good && (static_cast<unsigned char>(c) >= 0x20);
      if (!text.empty()) good = good && text.front() != ' ' && text.back() != ' ';
      if (!good)
        throw Error(Stage::Write, "the label of part " + std::to_string(id) +
                                      " cannot be written: line breaks, $$, // or blanks at its ends");
    }
    if (stack_.dimension)
      for (const double v : *stack_.dimension)
        if (!std::isfinite(v)) throw Error(Stage::Write, "the dimension of the stack has a number that is not finite");
    for (std::size_t l = 0; l < stack_.layers.size(); ++l) {
      listen();
      check_layer(l);
    }
  }

  void check_layer(std::size_t l) const {
    const Layer& layer = stack_.layers[l];
    const auto number = static_cast<std::int64_t>(l);
    // What the reader refuses is not written.
    const double limit = kCliLargestCoordinate / stack_.unit;
    const auto in_range = [&](double v) {
      return std::fabs(options_.binary ? static_cast<double>(static_cast<float>(v)) : v) <= limit;
    };
    const auto finite = [&](const Point2& p) { return in_range(p.x) && in_range(p.y); };
    if (!std::isfinite(layer.z)) throw GeometryError(Stage::Write, number, -1, "z is not finite");
    if (!in_range(z_of(layer))) throw GeometryError(Stage::Write, number, -1, "z is out of range (1e6 mm)");
    if (l > 0 && !(layer.z > stack_.layers[l - 1].z))
      throw GeometryError(Stage::Write, number, -1, "z is not above the layer before");
    for (std::size_t i = 0; i < layer.polylines.size(); ++i) {
      const Polyline& line = layer.polylines[i];
      const auto index = static_cast<std::int64_t>(i);
      if (line.direction != Direction::Inner && line.direction != Direction::Outer && line.direction != Direction::Open)
        throw GeometryError(Stage::Write, number, index, "no valid direction");
      if (line.points.size() >= static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
        throw GeometryError(Stage::Write, number, index, "too many points for the format");
      if (!std::all_of(line.points.begin(), line.points.end(), finite))
        throw GeometryError(Stage::Write, number, index, "a coordinate is not finite, or out of range (1e6 mm)");
      check_process(line.process, number);
    }
    for (const Hatches& hatches : layer.hatches) {
      if (hatches.lines.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
        throw GeometryError(Stage::Write, number, -1, "too many hatches for the format");
      for (const std::array<Point2, 2>& line : hatches.lines)
        if (!finite(line[0]) || !finite(line[1]))
          throw GeometryError(Stage::Write, number, -1,
                              "a coordinate of a hatch is not finite, or out of range (1e6 mm)");
      check_process(hatches.process, number);
    }
  }

  static void check_process(const ProcessParameters& process, std::int64_t layer) {
    for (const std::optional<double>* v : {&process.power, &process.speed, &process.focus, &process.spot_size})
      if (*v && !std::isfinite(**v)) throw GeometryError(Stage::Write, layer, -1, "a process parameter is not finite");
  }

  [[nodiscard]] double z_of(const Layer& layer) const { return layer.z * z_scale_; }

  /// The box of the coordinates in file units, for $$DIMENSION and for the sign of short coordinates.
  void measure() {
    bool any = false;
    const auto add = [&](const Point2& p) {
      if (!any) low_ = high_ = p;
      any = true;
      low_.x = std::min(low_.x, p.x);
      low_.y = std::min(low_.y, p.y);
      high_.x = std::max(high_.x, p.x);
      high_.y = std::max(high_.y, p.y);
    };
    for (const Layer& layer : stack_.layers) {
      listen();
      for (const Polyline& line : layer.polylines)
        for (const Point2& p : line.points) add(p);
      for (const Hatches& hatches : layer.hatches)
        for (const std::array<Point2, 2>& line : hatches.lines)
          for (const Point2& p : line) add(p);
    }
    // A reader tells signed 16-bit coordinates by a negative minimum of $$DIMENSION, so that one sign holds for all.
    signed_ = low_.x < 0 || low_.y < 0;
  }

  // ---- header

  void header() {
    put("$$HEADERSTART\n");
    put(options_.binary ? "$$BINARY\n" : "$$ASCII\n");
    put("$$UNITS/");
    put(stack_.unit);
    put("\n$$VERSION/");
    put(static_cast<std::int64_t>(stack_.version.value_or(200)));
    if (stack_.date) {
      put("\n$$DATE/");
      put(static_cast<std::int64_t>(*stack_.date));
    }
    for (const auto& [id, text] : stack_.labels) {
      put("\n$$LABEL/");
      put(static_cast<std::int64_t>(id));
      put(",");
      put(text);
    }
    dimension();
    put("\n$$LAYERS/");
    put(static_cast<std::int64_t>(stack_.layers.size()));
    if (options_.binary && options_.align) put("\n$$ALIGN");
    put("\n$$HEADEREND");
    if (!options_.binary) put("\n");
    origin_ = report_.bytes + buffer_.size();
  }

  void dimension() {
    std::array<double, 6> box{};
    if (stack_.dimension && !(options_.binary && options_.short_commands)) {
      box = *stack_.dimension;
    } else if (!stack_.layers.empty()) {
      const double u = stack_.unit;
      box = {low_.x * u,  low_.y * u,  z_of(stack_.layers.front()) * u,
             high_.x * u, high_.y * u, z_of(stack_.layers.back()) * u};
    } else {
      return;
    }
    put("\n$$DIMENSION/");
    for (std::size_t i = 0; i < box.size(); ++i) {
      if (i > 0) put(",");
      put(box[i]);
    }
  }

  // ---- text

  static constexpr std::array<std::optional<double> ProcessParameters::*, 4> kParameters{
      &ProcessParameters::power, &ProcessParameters::speed, &ProcessParameters::focus, &ProcessParameters::spot_size};
  static constexpr std::array<const char*, 4> kParameterNames{"POWER", "SPEED", "FOCUS", "SPOTSIZE"};

  /// Would a block with these parameters unset one that is set?
  [[nodiscard]] static bool unsets(const ProcessParameters& set, const ProcessParameters& wanted) {
    for (const auto parameter : kParameters)
      if (set.*parameter && !(wanted.*parameter)) return true;
    return false;
  }

  void text_process(const ProcessParameters& wanted) {
    if (unsets(modal_, wanted)) lose_parameters();
    for (std::size_t i = 0; i < kParameters.size(); ++i) {
      const std::optional<double>& value = wanted.*kParameters[i];
      if (!value || modal_.*kParameters[i] == value) continue;
      put("$$");
      put(kParameterNames[i]);
      put("/");
      put(*value);
      put("\n");
      modal_.*kParameters[i] = value;
    }
  }

  void lose_parameters() {
    if (options_.exact)
      throw Error(Stage::Write, options_.binary
                                    ? "a binary CLI file cannot hold process parameters (option exact)"
                                    : "a CLI file cannot unset a process parameter that was set before (option exact)");
    ++report_.lost_parameters;
  }

  void text() {
    put("$$GEOMETRYSTART\n");
    for (const Layer& layer : stack_.layers) {
      put("$$LAYER/");
      put(z_of(layer));
      put("\n");
      // The stack does not say how polylines and hatches follow each other. Blocks that have fewer parameters come
      // first, since a parameter once set holds on.
      std::size_t p = 0;
      std::size_t h = 0;
      while (p < layer.polylines.size() || h < layer.hatches.size()) {
        const bool hatch = p == layer.polylines.size() ||
                           (h < layer.hatches.size() && unsets(layer.polylines[p].process, layer.hatches[h].process));
        if (hatch)
          text_hatches(layer.hatches[h++]);
        else
          text_polyline(layer.polylines[p++]);
      }
    }
    put("$$GEOMETRYEND\n");
  }

  void text_point(const Point2& p) {
    put(",");
    put(p.x);
    put(",");
    put(p.y);
  }

  /// Points as the file counts them: closed lines repeat the first.
  [[nodiscard]] static std::size_t count(const Polyline& line) {
    return line.points.size() + (line.direction != Direction::Open && !line.points.empty() ? 1 : 0);
  }

  void text_polyline(const Polyline& line) {
    text_process(line.process);
    put("$$POLYLINE/");
    put(static_cast<std::int64_t>(line.part));
    put(",");
    put(static_cast<std::int64_t>(line.direction));
    put(",");
    put(static_cast<std::int64_t>(count(line)));
    for (const Point2& p : line.points) text_point(p);
    if (count(line) > line.points.size()) text_point(line.points.front());
    put("\n");
  }

  void text_hatches(const Hatches& hatches) {
    text_process(hatches.process);
    put("$$HATCHES/");
    put(static_cast<std::int64_t>(hatches.part));
    put(",");
    put(static_cast<std::int64_t>(hatches.lines.size()));
    for (const std::array<Point2, 2>& line : hatches.lines) {
      text_point(line[0]);
      text_point(line[1]);
    }
    put("\n");
  }

  // ---- binary

  void put16(std::uint16_t v) {
    buffer_.push_back(static_cast<char>(v & 0xff));
    buffer_.push_back(static_cast<char>(v >> 8));
  }
  void put32(std::uint32_t v) {
    put16(static_cast<std::uint16_t>(v & 0xffff));
    put16(static_cast<std::uint16_t>(v >> 16));
  }
  void put_int(std::int32_t v) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &v, sizeof bits);
    put32(bits);
  }
  void put_float(double v) {
    if (std::abs(v) > static_cast<double>(std::numeric_limits<float>::max()))
      throw Error(Stage::Write, "a number is too large for a 32-bit float");
    const auto f = static_cast<float>(v);
    const double error = std::abs(static_cast<double>(f) - v);
    if (error > 0) {
      if (options_.exact)
        throw Error(Stage::Write, "the number " + text_of(v) + " is not a 32-bit float (option exact)");
      ++report_.rounded_numbers;
      report_.largest_rounding = std::max(report_.largest_rounding, error * stack_.unit);
    }
    std::uint32_t bits = 0;
    std::memcpy(&bits, &f, sizeof bits);
    put32(bits);
  }
  void put_number(double v, bool is_short) {
    if (is_short)
      put16(static_cast<std::uint16_t>(static_cast<std::int32_t>(v) & 0xffff));
    else
      put_float(v);
  }
  void put_count(std::size_t n, bool is_short) {
    if (is_short)
      put16(static_cast<std::uint16_t>(n));
    else
      put_int(static_cast<std::int32_t>(n));
  }
  /// A part id.
  void put_id(std::int32_t id, bool is_short) {
    if (is_short)
      put16(static_cast<std::uint16_t>(id));
    else
      put_int(id);
  }

  void align() {
    if (!options_.align) return;
    while ((report_.bytes + buffer_.size() - origin_) % 4 != 0) buffer_.push_back('\0');
  }
  void code(std::uint16_t value) {
    put16(value);
    align();
  }

  [[nodiscard]] bool fits_short(double v) const {
    if (v != std::floor(v)) return false;
    return signed_ ? v >= kShortLow && v <= kShortHighSigned : v >= 0 && v <= kShortHighUnsigned;
  }
  [[nodiscard]] bool fits_short(const Point2& p) const { return fits_short(p.x) && fits_short(p.y); }
  [[nodiscard]] static bool fits_id(std::int32_t id) { return id >= 0 && id <= 65535; }

  void binary() {
    for (std::size_t l = 0; l < stack_.layers.size(); ++l) {
      if (l > 0 && static_cast<float>(z_of(stack_.layers[l])) <= static_cast<float>(z_of(stack_.layers[l - 1])))
        throw GeometryError(Stage::Write, static_cast<std::int64_t>(l), -1,
                            "z is the same 32-bit float as that of the layer before");
      binary_layer(stack_.layers[l]);
    }
  }

  void binary_layer(const Layer& layer) {
    const double z = z_of(layer);
    const bool z_short =
        options_.short_commands && z_of(stack_.layers.front()) >= 0 && z == std::floor(z) && z <= kShortHighUnsigned;
    code(z_short ? 128 : 127);
    put_number(z, z_short);
    align();
    for (const Polyline& line : layer.polylines) {
      if (!(line.process == ProcessParameters{})) lose_parameters();
      const bool is_short =
          options_.short_commands && fits_id(line.part) && count(line) <= kShortCount &&
          std::all_of(line.points.begin(), line.points.end(), [&](const Point2& p) { return fits_short(p); });
      code(is_short ? 129 : 130);
      put_id(line.part, is_short);
      put_count(static_cast<std::size_t>(line.direction), is_short);
      put_count(count(line), is_short);
      for (const Point2& p : line.points) put_point(p, is_short);
      if (count(line) > line.points.size()) put_point(line.points.front(), is_short);
      align();
    }
    for (const Hatches& hatches : layer.hatches) {
      if (!(hatches.process == ProcessParameters{})) lose_parameters();
      const bool is_short =
          options_.short_commands && fits_id(hatches.part) && hatches.lines.size() <= kShortCount &&
          std::all_of(hatches.lines.begin(), hatches.lines.end(),
                      [&](const std::array<Point2, 2>& line) { return fits_short(line[0]) && fits_short(line[1]); });
      code(is_short ? 131 : 132);
      put_id(hatches.part, is_short);
      put_count(hatches.lines.size(), is_short);
      for (const std::array<Point2, 2>& line : hatches.lines) {
        put_point(line[0], is_short);
        put_point(line[1], is_short);
      }
      align();
    }
    flush_full();
  }

  void put_point(const Point2& p, bool is_short) {
    put_number(p.x, is_short);
    put_number(p.y, is_short);
    flush_full();
  }

  // ---- characters

  /// Shortest decimal number that reads back as the same double, in a notation without exponent where that is short.
  static std::string_view shortest(double v, std::array<char, 64>& space) {
    const double size = std::abs(v);
    const bool fixed = v == 0 || (size >= 1e-9 && size <= 1e15);  // at most 16 + 17 digits
    const auto [end, error] = std::to_chars(space.data(), space.data() + space.size(), v,
                                            fixed ? std::chars_format::fixed : std::chars_format::scientific);
    (void)error;  // 64 characters are enough for either
    return {space.data(), static_cast<std::size_t>(end - space.data())};
  }
  static std::string text_of(double v) {
    std::array<char, 64> space{};
    return std::string(shortest(v, space));
  }
  void put(std::string_view text) {
    buffer_.append(text);
    flush_full();
  }
  void put(const char* text) { put(std::string_view(text)); }
  void put(const std::string& text) { put(std::string_view(text)); }
  void put(double v) {
    std::array<char, 64> space{};
    put(shortest(v, space));
  }
  void put(std::int64_t v) {
    std::array<char, 32> space{};
    const auto [end, error] = std::to_chars(space.data(), space.data() + space.size(), v);
    (void)error;
    put(std::string_view(space.data(), static_cast<std::size_t>(end - space.data())));
  }
  void flush_full() {
    if (buffer_.size() >= kBlock) flush();
  }
  void flush() {
    listen();
    stream_.write(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    report_.bytes += buffer_.size();
    buffer_.clear();
  }

  std::ostream& stream_;
  const SliceStack& stack_;
  CliWriteOptions options_;
  double z_scale_;
  Point2 low_;
  Point2 high_;
  bool signed_ = false;
  ProcessParameters modal_;
  std::string buffer_;
  std::uint64_t origin_ = 0;
  CliWriteReport report_;
};

}  // namespace detail

/// Write a stack as CLI to a stream (opened in binary mode).
///
/// `read_cli(..., CliReadOptions::as_written())` of what was written gives an equal stack if the stack is in the form
/// that `read_cli` makes (ascending z; contours without repeated last point, oriented, of at least three points; no two
/// equal points in a row), if `z_unit` equals `unit`, and if the report says that nothing was rounded or lost. Where
/// `z_unit` differs, z is written in units, as the format wants it, and rounded once.
/// Text keeps every number. Binary has 32-bit floats and no process parameters. With `short_commands` a block whose
/// numbers are integers that 16 bits hold is written short, signed if any coordinate of the stack is negative (and
/// `$$DIMENSION` then says so).
///
/// Errors: Error or GeometryError (stage write) for a stack that the format cannot hold (numbers not finite, z not
/// ascending, labels with line breaks) and, with `options.exact`, for anything the report would count; FileError when
/// the stream fails; what `options.poll` throws. Cost: linear.
inline CliWriteReport write_cli(std::ostream& stream, const SliceStack& stack, const CliWriteOptions& options = {}) {
  return detail::CliWriter(stream, stack, options).write();
}

/// Write a stack as a CLI file, whole or not at all. Errors and cost: as above, and FileError.
inline CliWriteReport write_cli(const std::string& path, const SliceStack& stack, const CliWriteOptions& options = {}) {
  CliWriteReport report;
  AtomicFile file(path, Stage::Write);
  try {
    report = write_cli(file.stream(), stack, options);
  } catch (const FileError&) {
    if (file.stream()) throw;  // of the listener
    // The stream failed; committing finds the reason and names the file.
  }
  file.commit();
  return report;
}

}  // namespace slice2mesh
