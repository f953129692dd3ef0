// SPDX-License-Identifier: MIT
/// @file
/// @brief Conditions that are asked for one place after the other.
#pragma once

#include <cstddef>

namespace slice2mesh::detail {

/// Does f(k) hold for all k below n? Begins with `doubt`, which becomes the one for which it does not: what is in the
/// way of one place is in the way of the next one, most likely. Precondition: doubt < n, or n is 0.
template <class F>
[[nodiscard]] bool all_from(std::size_t& doubt, std::size_t n, F&& f) {
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t k = (doubt + i) % n;
    if (f(k)) continue;
    doubt = k;
    return false;
  }
  return true;
}

}  // namespace slice2mesh::detail
