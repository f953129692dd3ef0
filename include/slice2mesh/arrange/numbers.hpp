// SPDX-License-Identifier: MIT
/// @file
/// @brief Numbers for points and for pairs of numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "slice2mesh/core/grid.hpp"

namespace slice2mesh::detail {

/// The hash of a number, for Numbers.
[[nodiscard]] constexpr std::size_t hash_of(std::uint64_t key) noexcept {
  return static_cast<std::size_t>(key ^ ((key >> 32) * 0xD6E8FEB86659FD93ULL));  // both halves count
}
/// The hash of a point, for Numbers.
[[nodiscard]] inline std::size_t hash_of(const GridPoint& p) noexcept {
  return GridHash{}(p);
}

/// Numbers different keys, points or numbers, from 0 on, in the order in which they come.
template <class Key>
class Numbers {
public:
  /// `most`: how many keys are asked for, at most.
  explicit Numbers(std::size_t most) {
    std::size_t size = 16;
    while (size < 2 * most) size *= 2;
    slots_.assign(size, -1);
  }
  [[nodiscard]] std::int32_t of(const Key& key) {
    // The high bits of a product are the well mixed ones.
    std::size_t slot = (hash_of(key) * 0x9E3779B97F4A7C15ULL >> 20) & (slots_.size() - 1);
    for (; slots_[slot] >= 0; slot = (slot + 1) & (slots_.size() - 1))
      if (keys_[static_cast<std::size_t>(slots_[slot])] == key) return slots_[slot];
    slots_[slot] = static_cast<std::int32_t>(keys_.size());
    keys_.push_back(key);
    return slots_[slot];
  }
  [[nodiscard]] const std::vector<Key>& keys() const { return keys_; }

private:
  std::vector<std::int32_t> slots_;
  std::vector<Key> keys_;
};

/// Two numbers as one that sorts like the pair. Precondition: not negative.
[[nodiscard]] constexpr std::uint64_t packed(std::int32_t a, std::int32_t b) noexcept {
  return (static_cast<std::uint64_t>(a) << 32) | static_cast<std::uint64_t>(b);
}

}  // namespace slice2mesh::detail
