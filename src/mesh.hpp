// SPDX-License-Identifier: MIT
/// @file
/// @brief The main job: a slice file in, meshes and reports out.
#pragma once

#include <string>
#include <vector>

#include "mesher.hpp"
#include "slice2mesh/cli/read_cli.hpp"
#include "slice2mesh/io/write_options.hpp"
#include "slice2mesh/pipeline/options.hpp"

namespace slice2mesh_program {

/// What the command line asks for.
struct MeshJob {
  std::string input;
  std::vector<std::string> outputs;  ///< meshes, format by extension
  std::string plc;                   ///< the complex; empty: not wanted
  bool plc_skin = false;             ///< the outer skin of the complex alone
  std::string report;                ///< JSON; empty: not wanted
  std::string quality_svg;           ///< picture of the element quality; empty: not wanted
  slice2mesh::CliReadOptions read;
  slice2mesh::Options options;
  MesherChoice mesher;  ///< its limits are set from the options
  slice2mesh::WriteOptions write;
  bool quiet = false;  ///< no log, no progress
};

/// Reads, meshes, writes; the report as text goes to the standard output, the log to the standard error stream.
/// Where a check of the certificate fails the reports are written, the mesh is not.
/// Returns an exit code. Errors of the library pass through.
int mesh_file(const MeshJob& job);

}  // namespace slice2mesh_program
