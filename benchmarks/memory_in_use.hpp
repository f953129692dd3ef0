// SPDX-License-Identifier: MIT
/// @file
/// @brief How much memory operator new has given out, counted by a replacement of it (memory_in_use.cpp).
#pragma once

#include <cstddef>

namespace slice2mesh_benchmarks {

/// The bytes in use now; `memory_peak` begins anew.
std::size_t restart_memory_peak();

/// The most bytes in use at a time since `restart_memory_peak`.
std::size_t memory_peak();

}  // namespace slice2mesh_benchmarks
