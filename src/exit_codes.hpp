// SPDX-License-Identifier: MIT
/// @file
/// @brief What the program ends with.
#pragma once

#include <stdexcept>

namespace slice2mesh_program {

inline constexpr int kExitOk = 0;
inline constexpr int kExitUsage = 1;        ///< an option or argument is wrong
inline constexpr int kExitInput = 2;        ///< a file cannot be opened, read, understood or written
inline constexpr int kExitMeshing = 3;      ///< no mesh can be made of it
inline constexpr int kExitCertificate = 4;  ///< there is a mesh, but a check of its certificate failed

/// The command line asks for something that cannot be; ends with kExitUsage.
class UsageError : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

}  // namespace slice2mesh_program
