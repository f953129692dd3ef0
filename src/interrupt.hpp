// SPDX-License-Identifier: MIT
/// @file
/// @brief Signals: the first one to interrupt or terminate ends the work in an orderly way, with no partial file.
#pragma once

#include "slice2mesh/core/error.hpp"

namespace slice2mesh_program {

/// From now on SIGINT and SIGTERM are noted, once each; a second one ends the program at once, as usual. A file that
/// grows over the limit of the process (SIGXFSZ) is an error of writing and not the end.
void note_signals();

/// Whether the program was asked to stop.
[[nodiscard]] bool interrupted() noexcept;

/// For work that listens, of that stage. Errors: Cancelled where the program was asked to stop.
void stop_if_interrupted(slice2mesh::Stage stage);

}  // namespace slice2mesh_program
