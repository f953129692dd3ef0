// SPDX-License-Identifier: MIT
/// @file
/// @brief Values from the bytes of a fuzzer. As LLVM's FuzzedDataProvider, which only Clang has: the inputs that were
/// found are replayed by tests that any compiler builds.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

namespace slice2mesh_fuzz {

/// Thrown by a target when something that must hold does not.
class Failure : public std::logic_error {
public:
  using std::logic_error::logic_error;
};

/// The bytes, in order; zeros when they are used up.
class ByteSource {
public:
  ByteSource(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  [[nodiscard]] bool empty() const { return at_ >= size_; }
  [[nodiscard]] std::uint8_t byte() { return empty() ? std::uint8_t{0} : data_[at_++]; }
  [[nodiscard]] bool flag() { return (byte() & 1) != 0; }
  /// In [low, high]; takes one byte, or two where the range is larger.
  [[nodiscard]] int whole(int low, int high) {
    const int range = high - low + 1;
    int value = byte();
    if (range > 256) value = value * 256 + byte();
    return low + value % range;
  }
  /// In [0, 1], in steps of 1/65535.
  [[nodiscard]] double share() { return whole(0, 65535) / 65535.0; }
  /// Any double: from eight bytes.
  [[nodiscard]] double any_double() {
    std::uint64_t bits = 0;
    for (int i = 0; i < 8; ++i) bits = bits << 8 | byte();
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
  [[nodiscard]] double finite_double() {
    const double value = any_double();
    return std::isfinite(value) ? value : 0;
  }
  [[nodiscard]] std::string text(std::size_t most) {
    std::string result;
    for (std::size_t n = byte() % (most + 1); n > 0 && !empty(); --n) result.push_back(static_cast<char>(byte()));
    return result;
  }

private:
  const std::uint8_t* data_;
  std::size_t size_;
  std::size_t at_ = 0;
};

}  // namespace slice2mesh_fuzz
