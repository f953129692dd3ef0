// SPDX-License-Identifier: MIT
// The one translation unit that compiles the pipeline, and with it CGAL.
#define SLICE2MESH_IMPLEMENTATION
#include <slice2mesh/slice2mesh.hpp>
