// SPDX-License-Identifier: MIT
/// @file
/// @brief The version of slice2mesh; the one place where it is written.
#pragma once

/// Changes when the interface breaks (from 1.0 on).
#define SLICE2MESH_VERSION_MAJOR 0
/// Changes when something is added (before 1.0: or breaks).
#define SLICE2MESH_VERSION_MINOR 1
/// Changes when something is repaired.
#define SLICE2MESH_VERSION_PATCH 0
/// "major.minor.patch".
#define SLICE2MESH_VERSION "0.1.0"
