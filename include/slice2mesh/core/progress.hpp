// SPDX-License-Identifier: MIT
/// @file
/// @brief Progress and cancellation.
#pragma once

#include <functional>

#include "slice2mesh/core/error.hpp"

namespace slice2mesh {

/// Called with the stage and the share of it that is done (0 to 1). Return false to cancel: the running call then
/// throws `Cancelled`. An empty function means nobody listens.
using Progress = std::function<bool(Stage stage, double share)>;

/// Report and, if the listener wants to stop, throw `Cancelled`.
inline void report(const Progress& progress, Stage stage, double share) {
  if (progress && !progress(stage, share)) throw Cancelled(stage);
}

}  // namespace slice2mesh
