// SPDX-License-Identifier: MIT
/// @file
/// @brief Edge lengths that depend on the place.
#pragma once

#include <functional>

namespace slice2mesh {

/// A length in mm at a place x, y, z in mm.
using SizeFunction = std::function<double(double x, double y, double z)>;

}  // namespace slice2mesh
