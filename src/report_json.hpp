// SPDX-License-Identifier: MIT
/// @file
/// @brief The report of a run as JSON.
#pragma once

#include <string>

#include "mesh.hpp"
#include "slice2mesh/pipeline/slice_to_mesh.hpp"

namespace slice2mesh_program {

/// The report of a run: options, what was chosen, deviation, certificate, quality, diagnostics. Indented, ends with a
/// line end. Numbers that are not finite are null.
[[nodiscard]] std::string report_json(const MeshJob& job, const slice2mesh::Result& result);

}  // namespace slice2mesh_program
