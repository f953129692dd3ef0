// SPDX-License-Identifier: MIT
/// @file
/// @brief OutputBuffer: fast, locale-free text and binary output to a stream.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <ostream>
#include <string_view>
#include <utility>
#include <vector>

namespace slice2mesh::detail {

/// True on a machine that stores the lowest byte first.
[[nodiscard]] inline bool is_little_endian() noexcept {
  const std::uint16_t one = 1;
  unsigned char first = 0;
  std::memcpy(&first, &one, 1);
  return first == 1;
}

/// Collects output in a large block and hands it to the stream. A stream that fails is written to no more; its state
/// tells so, as with any stream. `flush` must be called at the end. `poll` is called for every block; what it throws
/// ends the output.
class OutputBuffer {
public:
  explicit OutputBuffer(std::ostream& out, std::function<void()> poll = {})
      : out_(out), poll_(std::move(poll)), block_(kBlockBytes) {}
  OutputBuffer(const OutputBuffer&) = delete;
  OutputBuffer& operator=(const OutputBuffer&) = delete;

  OutputBuffer& text(std::string_view s) {
    bytes(s.data(), s.size());
    return *this;
  }
  OutputBuffer& character(char c) {
    if (used_ == block_.size()) flush();
    block_[used_++] = c;
    return *this;
  }
  template <class Integer>
  OutputBuffer& integer(Integer value) {
    char* const end = room(kNumberBytes) + kNumberBytes;
    used_ = static_cast<std::size_t>(std::to_chars(block_.data() + used_, end, value).ptr - block_.data());
    return *this;
  }
  /// Shortest decimal text that reads back as the same number.
  OutputBuffer& real(double value) {
    char* const end = room(kNumberBytes) + kNumberBytes;
    used_ = static_cast<std::size_t>(std::to_chars(block_.data() + used_, end, value).ptr - block_.data());
    return *this;
  }
  /// The same, with as few digits left out as needed to fit into `width` characters (at least 10).
  OutputBuffer& real_within(double value, std::size_t width) {
    char digits[kNumberBytes];
    char* end = std::to_chars(digits, digits + kNumberBytes, value).ptr;
    for (int precision = 16; static_cast<std::size_t>(end - digits) > width && precision > 0; --precision)
      end = std::to_chars(digits, digits + kNumberBytes, value, std::chars_format::scientific, precision).ptr;
    return text({digits, static_cast<std::size_t>(end - digits)});
  }
  /// The bytes of values as they are in memory.
  template <class T>
  OutputBuffer& native(const T& value) {
    char* const place = room(sizeof(T));
    std::memcpy(place, &value, sizeof(T));
    used_ += sizeof(T);
    return *this;
  }
  /// The bytes of a number, lowest first.
  template <class T>
  OutputBuffer& little_endian(T value) {
    char* const place = room(sizeof(T));
    std::memcpy(place, &value, sizeof(T));
    if (!is_little_endian()) std::reverse(place, place + sizeof(T));
    used_ += sizeof(T);
    return *this;
  }
  void bytes(const void* data, std::size_t count) {
    if (count == 0) return;
    const char* from = static_cast<const char*>(data);
    if (count > block_.size() - used_) {
      flush();
      for (std::size_t piece = 0; count >= block_.size(); from += piece, count -= piece) {
        piece = std::min(count, kPieceBytes);
        if (out_) out_.write(from, static_cast<std::streamsize>(piece));
        if (poll_) poll_();
      }
    }
    std::memcpy(block_.data() + used_, from, count);
    used_ += count;
  }
  void flush() {
    if (out_ && used_ > 0) out_.write(block_.data(), static_cast<std::streamsize>(used_));
    used_ = 0;
    if (poll_) poll_();
  }

private:
  static constexpr std::size_t kBlockBytes = std::size_t{1} << 20;
  static constexpr std::size_t kPieceBytes = 16 * kBlockBytes;  // of what is written as it is, between two polls
  static constexpr std::size_t kNumberBytes = 32;               // the longest shortest double has 24 characters

  char* room(std::size_t count) {
    if (count > block_.size() - used_) flush();
    return block_.data() + used_;
  }

  std::ostream& out_;
  std::function<void()> poll_;
  std::vector<char> block_;
  std::size_t used_ = 0;
};

}  // namespace slice2mesh::detail
