// SPDX-License-Identifier: MIT
/// @file
/// @brief Sorting that listens: the algorithms of the standard library, with polls.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <type_traits>

#include "slice2mesh/core/progress.hpp"

namespace slice2mesh::detail {

/// A comparison for algorithms of the standard library that tells `listen` each time it is made. Where that throws, the
/// algorithm leaves its range in any order, and may lose an element that it holds apart: only for elements that own
/// nothing.
template <class Less>
[[nodiscard]] auto listening(Poll& listen, Less less) {
  return [&listen, less](const auto& a, const auto& b) {
    listen();
    return less(a, b);
  };
}

/// Sorts as std::sort does, to the same order; `listen` is told the comparisons, of short ranges the elements.
template <class Iterator, class Less = std::less<>>
void sort_listening(Iterator first, Iterator last, Poll& listen, Less less = {}) {
  static_assert(std::is_trivially_destructible_v<std::remove_reference_t<decltype(*first)>>, "see listening");
  constexpr std::ptrdiff_t kShort = 4096;  // elements: sorted before anybody has waited
  if (last - first > kShort) {
    std::sort(first, last, listening(listen, less));
    return;
  }
  listen(static_cast<std::size_t>(last - first));
  std::sort(first, last, less);
}

}  // namespace slice2mesh::detail
