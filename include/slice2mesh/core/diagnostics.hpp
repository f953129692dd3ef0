// SPDX-License-Identifier: MIT
/// @file
/// @brief Diagnostics: what was repaired or noticed on the way, without stopping.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/core/error.hpp"

namespace slice2mesh {

/// How much a finding matters.
enum class Severity : std::uint8_t {
  Note,    ///< good to know
  Repair,  ///< something was changed
  Warning  ///< the result may not be what was meant
};

/// The name in lower case.
[[nodiscard]] constexpr const char* to_string(Severity severity) noexcept {
  switch (severity) {
    case Severity::Note: return "note";
    case Severity::Repair: return "repair";
    case Severity::Warning: return "warning";
  }
  return "unknown";
}

/// One finding. `code` is stable and made for programs ("zero_length_segment"); `message` is for people.
struct Diagnostic {
  /// How much it matters.
  Severity severity = Severity::Note;
  /// Where it was noticed.
  Stage stage = Stage::Read;
  /// Stable name, see docs/errors.md.
  std::string code;
  /// A sentence for people; may change between versions.
  std::string message;
  std::int64_t layer = -1;     ///< index in the stack, from 0; -1: not one in particular
  std::int64_t polyline = -1;  ///< index in its layer, from 0; -1: not one in particular
  std::uint64_t count = 1;     ///< how many findings of the same code this entry stands for
};

/// A list of findings. Findings of one code beyond `per_code_limit` are counted in the last entry of that code
/// instead of being listed, so that the memory stays bounded on bad input.
class Diagnostics {
public:
  /// Number of entries that are listed per code and severity.
  std::size_t per_code_limit = 20;

  /// Add a finding. Cost: linear in the number of entries.
  void add(Diagnostic diagnostic) {
    std::size_t same = 0;
    std::size_t last = entries_.size();
    for (std::size_t i = entries_.size(); i-- > 0;) {
      if (entries_[i].code == diagnostic.code && entries_[i].severity == diagnostic.severity) {
        if (same++ == 0) last = i;
        if (same >= per_code_limit) break;
      }
    }
    if (same >= per_code_limit) {
      entries_[last].count += diagnostic.count;
      return;
    }
    entries_.push_back(std::move(diagnostic));
  }
  /// The same from its parts: `layer` and `polyline` are indices from 0 (-1: not one in particular), `count` the number
  /// of findings that it stands for.
  void add(Severity severity, Stage stage, std::string code, std::string message, std::int64_t layer = -1,
           std::int64_t polyline = -1, std::uint64_t count = 1) {
    add(Diagnostic{severity, stage, std::move(code), std::move(message), layer, polyline, count});
  }
  /// Add all findings of another list.
  void append(const Diagnostics& other) {
    for (const Diagnostic& d : other.entries_) add(d);
  }

  /// The findings, in the order in which they came: any number, at most `per_code_limit` per code and severity.
  [[nodiscard]] const std::vector<Diagnostic>& entries() const noexcept { return entries_; }
  /// True if nothing was found.
  [[nodiscard]] bool empty() const noexcept { return entries_.empty(); }
  /// Number of findings of a code, listed or counted.
  [[nodiscard]] std::uint64_t count(const std::string& code) const {
    std::uint64_t n = 0;
    for (const Diagnostic& d : entries_)
      if (d.code == code) n += d.count;
    return n;
  }

private:
  std::vector<Diagnostic> entries_;
};

}  // namespace slice2mesh
