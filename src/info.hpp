// SPDX-License-Identifier: MIT
/// @file
/// @brief What is in a slice file.
#pragma once

#include <string>

#include "slice2mesh/cli/read_cli.hpp"
#include "slice2mesh/pipeline/options.hpp"

namespace slice2mesh_program {

/// Reads a file and prints what it holds to the standard output. Returns an exit code. Errors of the library pass
/// through.
int print_info(const std::string& path, const slice2mesh::CliReadOptions& read, const slice2mesh::SlabOptions& slabs);

}  // namespace slice2mesh_program
