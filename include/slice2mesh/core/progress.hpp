// SPDX-License-Identifier: MIT
/// @file
/// @brief Progress and cancellation.
#pragma once

#include <cstddef>
#include <functional>

#include "slice2mesh/core/error.hpp"

namespace slice2mesh {

/// Called with the stage and the share of it that is done (0 to 1). Return false to cancel: the running call then
/// throws `Cancelled`. An empty function means nobody listens.
using Progress = std::function<bool(Stage stage, double share)>;

/// Report that the share `share` of a stage is done, from 0 to 1. Errors: Cancelled if the listener wants to stop, and
/// what it throws.
inline void report(const Progress& progress, Stage stage, double share) {
  if (progress && !progress(stage, share)) throw Cancelled(stage);
}

namespace detail {

/// A listener that hears of `stage` whatever stage is told: for work of an earlier one that is done within it. Errors:
/// Cancelled, of that stage.
[[nodiscard]] inline Progress within(const Progress& progress, Stage stage) {
  return [progress, stage](Stage, double share) {
    report(progress, stage, share);
    return true;
  };
}

/// Calls a function once in so many steps of work; what it throws ends the work. Nothing is called where it is empty.
class Poll {
public:
  explicit Poll(const std::function<void()>& function, std::size_t every) : function_(function), every_(every) {}
  /// `work`: how many steps have been made since the last call.
  void operator()(std::size_t work = 1) {
    steps_ += work;
    if (steps_ < every_ || !function_) return;
    steps_ = 0;
    function_();
  }

private:
  const std::function<void()>& function_;
  std::size_t every_;
  std::size_t steps_ = 0;
};

}  // namespace detail

}  // namespace slice2mesh
