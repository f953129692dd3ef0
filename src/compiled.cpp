// SPDX-License-Identifier: MIT
// The pipeline, compiled once.
#define SLICE2MESH_IMPLEMENTATION
#include "slice2mesh/pipeline/slice_to_mesh.hpp"
