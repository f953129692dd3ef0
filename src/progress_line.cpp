// SPDX-License-Identifier: MIT
#include "progress_line.hpp"

#include <cstdio>

#if defined(__unix__) || defined(__APPLE__)
#include <unistd.h>
#endif

namespace slice2mesh_program {

namespace {

bool standard_error_is_terminal() {
#if defined(__unix__) || defined(__APPLE__)
  return isatty(STDERR_FILENO) != 0;
#else
  return false;
#endif
}

}  // namespace

ProgressLine::ProgressLine(bool wanted) : active_(wanted && standard_error_is_terminal()) {}

ProgressLine::~ProgressLine() {
  clear();
}

slice2mesh::Progress ProgressLine::callback() {
  if (!active_) return {};
  return [this](slice2mesh::Stage stage, double share) {
    show(stage, share);
    return true;
  };
}

void ProgressLine::clear() {
  if (!shown_) return;
  std::fputs("\r\033[K", stderr);
  shown_ = false;
}

void ProgressLine::show(slice2mesh::Stage stage, double share) {
  const auto now = std::chrono::steady_clock::now();
  if (shown_ && now - last_ < std::chrono::milliseconds(100)) return;
  std::fprintf(stderr, "\r\033[K%-15s %3.0f %%", to_string(stage), 100 * share);
  std::fflush(stderr);
  shown_ = true;
  last_ = now;
}

}  // namespace slice2mesh_program
