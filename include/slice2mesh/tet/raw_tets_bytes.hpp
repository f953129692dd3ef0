// SPDX-License-Identifier: MIT
/// @file
/// @brief Tets on their way from a child process.
#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <type_traits>
#include <vector>

#include "slice2mesh/core/error.hpp"
#include "slice2mesh/tet/child_process.hpp"
#include "slice2mesh/tet/restore_layers.hpp"

namespace slice2mesh::detail {

template <class T>
void append_bytes(std::vector<char>& bytes, const std::vector<T>& values) {
  static_assert(std::is_trivially_copyable_v<T>);
  const std::uint64_t count = values.size();
  const auto* head = reinterpret_cast<const char*>(&count);
  bytes.insert(bytes.end(), head, head + sizeof count);
  const auto* data = reinterpret_cast<const char*>(values.data());
  bytes.insert(bytes.end(), data, data + values.size() * sizeof(T));
}

template <class T>
[[nodiscard]] bool take_bytes(const std::vector<char>& bytes, std::size_t& at, std::vector<T>& values) {
  static_assert(std::is_trivially_copyable_v<T>);
  std::uint64_t count = 0;
  if (bytes.size() - at < sizeof count) return false;
  std::memcpy(&count, bytes.data() + at, sizeof count);
  at += sizeof count;
  if ((bytes.size() - at) / sizeof(T) < count) return false;
  values.resize(static_cast<std::size_t>(count));
  if (count > 0) std::memcpy(static_cast<void*>(values.data()), bytes.data() + at, values.size() * sizeof(T));
  at += values.size() * sizeof(T);
  return true;
}

/// Lets a child process make tets. Errors: those of `run_in_child`.
[[nodiscard]] inline RawTets raw_tets_from_child(const std::string& name, const std::function<RawTets()>& work,
                                                 const ChildLimits& limits, const Progress& progress) {
  const ChildResult run = run_in_child(
      name,
      [&work] {
        const RawTets tets = work();
        std::vector<char> bytes;
        append_bytes(bytes, tets.vertices);
        append_bytes(bytes, tets.tets);
        append_bytes(bytes, tets.cells);
        return bytes;
      },
      limits, progress);
  RawTets tets;
  std::size_t at = 0;
  if (!take_bytes(run.bytes, at, tets.vertices) || !take_bytes(run.bytes, at, tets.tets) ||
      !take_bytes(run.bytes, at, tets.cells) || at != run.bytes.size())
    throw TetrahedralizationError(-1, name + " gave a broken result");
  return tets;
}

/// A number without exponent: TetGen takes the letter e of one for a switch.
[[nodiscard]] inline std::string fixed_text(double v) {
  std::array<char, 400> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), v, std::chars_format::fixed);
  return {buffer.data(), end.ptr};
}

}  // namespace slice2mesh::detail
