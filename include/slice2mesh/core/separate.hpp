// SPDX-License-Identifier: MIT
/// @file
/// @brief Compile what takes longest once, for programs of many translation units: SLICE2MESH_SEPARATE.
///
/// Define SLICE2MESH_SEPARATE for a whole program, and SLICE2MESH_IMPLEMENTATION in one of its translation units before
/// it includes `pipeline/slice_to_mesh.hpp` (and, if it is used, in one that includes `tet/mesh3_model.hpp`). In all
/// others these headers then declare their functions only and bring in nothing of CGAL: a translation unit costs a
/// quarter. Without these macros the library is header-only as ever.
#pragma once

/// `inline`, or nothing where the function is compiled once.
#ifdef SLICE2MESH_SEPARATE
#define SLICE2MESH_INLINE
#else
#define SLICE2MESH_INLINE inline
#endif

/// 1 where functions are declared, and defined in another translation unit; else 0.
#if defined(SLICE2MESH_SEPARATE) && !defined(SLICE2MESH_IMPLEMENTATION)
#define SLICE2MESH_DECLARED_ONLY 1
#else
#define SLICE2MESH_DECLARED_ONLY 0
#endif
