// SPDX-License-Identifier: MIT
/// @file
/// @brief One line on a terminal that tells how far the work is.
#pragma once

#include <chrono>

#include "slice2mesh/core/progress.hpp"

namespace slice2mesh_program {

/// Rewrites one line of the standard error stream, at most ten times a second, if that stream is a terminal; otherwise
/// does nothing. Not for use by several threads at a time.
class ProgressLine {
public:
  explicit ProgressLine(bool wanted);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// A function for `Options::progress` that refers to this object; empty if nothing would be shown.
  [[nodiscard]] slice2mesh::Progress callback();
  /// Removes the line.
  void clear();

private:
  void show(slice2mesh::Stage stage, double share);

  bool active_;
  bool shown_ = false;
  std::chrono::steady_clock::time_point last_;
};

}  // namespace slice2mesh_program
