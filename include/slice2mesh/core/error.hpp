// SPDX-License-Identifier: MIT
/// @file
/// @brief Typed errors: what the library throws when it cannot go on.
///
/// Docstrings name the errors of a function; what holds everywhere is not repeated, see docs/reference.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

namespace slice2mesh {

/// The stage of the pipeline in which something was noticed.
enum class Stage : std::uint8_t {
  Read,            ///< of slices: read_cli
  Regions,         ///< slabs and their areas: make_slabs, build_regions
  Harmonize,       ///< harmonize
  Lift,            ///< the overlay of two contours: lift
  Triangulate,     ///< triangulate_plane
  Plc,             ///< the complex: build_plc, verify_plc
  Tetrahedralize,  ///< the fill of the complex
  Improve,         ///< improve
  Certify,         ///< the check of the finished mesh
  Quality,         ///< figures of the elements
  Fem,             ///< boundary sets, birth of layers, estimates
  Write,           ///< of meshes, complexes and slices
  Options          ///< checks of options, before anything is done
};

/// The stage's name, in lower case.
[[nodiscard]] constexpr const char* to_string(Stage stage) noexcept {
  switch (stage) {
    case Stage::Read: return "read";
    case Stage::Regions: return "regions";
    case Stage::Harmonize: return "harmonize";
    case Stage::Lift: return "lift";
    case Stage::Triangulate: return "triangulate";
    case Stage::Plc: return "plc";
    case Stage::Tetrahedralize: return "tetrahedralize";
    case Stage::Improve: return "improve";
    case Stage::Certify: return "certify";
    case Stage::Quality: return "quality";
    case Stage::Fem: return "fem";
    case Stage::Write: return "write";
    case Stage::Options: return "options";
  }
  return "unknown";
}

/// Base of every error of the library.
class Error : public std::runtime_error {
public:
  /// The text of what() is "<stage>: <message>".
  Error(Stage stage, const std::string& message)
      : std::runtime_error(std::string(to_string(stage)) + ": " + message), stage_(stage) {}
  /// The stage that gave up.
  [[nodiscard]] Stage stage() const noexcept { return stage_; }

private:
  Stage stage_;
};

/// An option is out of its range. Its name is the field of the options aggregate.
class OptionError : public Error {
public:
  /// `option` is the name of the field, such as "supports.miter_limit".
  OptionError(std::string option, const std::string& message)
      : Error(Stage::Options, option + ": " + message), option_(std::move(option)) {}
  /// Name of the field.
  [[nodiscard]] const std::string& option() const noexcept { return option_; }

private:
  std::string option_;
};

/// A file that cannot be opened, read, or written.
class FileError : public Error {
public:
  /// `stage` is Read or Write.
  FileError(Stage stage, std::string path, const std::string& message)
      : Error(stage, path + ": " + message), path_(std::move(path)) {}
  /// The file, as it was named.
  [[nodiscard]] const std::string& path() const noexcept { return path_; }

private:
  std::string path_;
};

/// Input that is not a readable slice file. Names the place: byte offset from 0, line from 1 (0 in binary geometry).
class ParseError : public Error {
public:
  /// `byte` from 0, `line` from 1 (0: in binary geometry); an empty `file` is a stream.
  ParseError(std::string file, std::uint64_t byte, std::uint64_t line, const std::string& message)
      : Error(Stage::Read, (file.empty() ? std::string("<stream>") : file) + ", byte " + std::to_string(byte) +
                               (line > 0 ? ", line " + std::to_string(line) : std::string()) + ": " + message),
        file_(std::move(file)), byte_(byte), line_(line) {}
  /// The file, as it was named; empty for a stream.
  [[nodiscard]] const std::string& file() const noexcept { return file_; }
  /// Offset of the fault, from 0.
  [[nodiscard]] std::uint64_t byte() const noexcept { return byte_; }
  /// Line of the fault, from 1; 0 in binary geometry.
  [[nodiscard]] std::uint64_t line() const noexcept { return line_; }

private:
  std::string file_;
  std::uint64_t byte_;
  std::uint64_t line_;
};

/// Geometry from which no mesh can be made. Layer and polyline count from 0; -1 means "not one in particular".
class GeometryError : public Error {
public:
  /// `stage` noticed it in `layer` and `polyline` (from 0; -1: not one in particular).
  GeometryError(Stage stage, std::int64_t layer, std::int64_t polyline, const std::string& message)
      : Error(stage, (layer >= 0 ? "layer " + std::to_string(layer) + ": " : std::string()) +
                         (polyline >= 0 ? "polyline " + std::to_string(polyline) + ": " : std::string()) + message),
        layer_(layer), polyline_(polyline) {}
  /// Index of the layer, from 0; -1: not one in particular.
  [[nodiscard]] std::int64_t layer() const noexcept { return layer_; }
  /// Index in the layer, from 0; -1: not one in particular.
  [[nodiscard]] std::int64_t polyline() const noexcept { return polyline_; }

private:
  std::int64_t layer_;
  std::int64_t polyline_;
};

/// A tetrahedralizer could not fill the complex.
class TetrahedralizationError : public Error {
public:
  /// `slab` from 0; -1: not one in particular.
  TetrahedralizationError(std::int64_t slab, const std::string& message)
      : Error(Stage::Tetrahedralize, (slab >= 0 ? "slab " + std::to_string(slab) + ": " : std::string()) + message),
        slab_(slab) {}
  /// Index of the slab, from 0; -1: not one in particular.
  [[nodiscard]] std::int64_t slab() const noexcept { return slab_; }

private:
  std::int64_t slab_;
};

/// A budget of the options (vertices, tets, time) is used up.
class BudgetError : public Error {
public:
  /// Stage and message, as for Error.
  using Error::Error;
};

/// The progress callback asked to stop.
class Cancelled : public Error {
public:
  /// `stage` was running.
  explicit Cancelled(Stage stage) : Error(stage, "cancelled") {}
};

}  // namespace slice2mesh
