// SPDX-License-Identifier: MIT
/// @file
/// @brief The version of slice2mesh; the one place where it is written.
#pragma once

#define SLICE2MESH_VERSION_MAJOR 0
#define SLICE2MESH_VERSION_MINOR 1
#define SLICE2MESH_VERSION_PATCH 0
#define SLICE2MESH_VERSION "0.1.0"
