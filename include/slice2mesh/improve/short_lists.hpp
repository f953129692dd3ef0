// SPDX-License-Identifier: MIT
/// @file
/// @brief Many short lists of numbers in one array.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace slice2mesh::detail {

/// Lists that change, all in one array: one allocation, and what is made one after the other is near in memory. The
/// stars of a mesh of two million tets are half a million lists.
class ShortLists {
public:
  /// A list as it is now. Valid until something is added to any list.
  class View {
  public:
    View(const std::int32_t* begin, const std::int32_t* end) : begin_(begin), end_(end) {}
    [[nodiscard]] const std::int32_t* begin() const { return begin_; }
    [[nodiscard]] const std::int32_t* end() const { return end_; }
    [[nodiscard]] std::size_t size() const { return std::size_t(end_ - begin_); }
    [[nodiscard]] bool empty() const { return begin_ == end_; }
    [[nodiscard]] std::int32_t front() const { return *begin_; }
    [[nodiscard]] std::int32_t operator[](std::size_t i) const { return begin_[i]; }

  private:
    const std::int32_t *begin_, *end_;
  };

  /// Begins with empty lists, with room for so many numbers each, and some more.
  void reset(const std::vector<std::int32_t>& sizes) {
    std::size_t all = 0;
    lists_.clear();
    lists_.reserve(sizes.size());
    for (const std::int32_t size : sizes) {
      lists_.push_back({all, 0, size + kRoom});
      all += std::size_t(size + kRoom);
    }
    // Lists that need more room go to the end.
    numbers_ = {};
    numbers_.reserve(all + all / 8);
    numbers_.resize(all);
  }
  [[nodiscard]] std::size_t size() const { return lists_.size(); }
  [[nodiscard]] View operator[](std::size_t i) const {
    const std::int32_t* begin = numbers_.data() + lists_[i].begin;
    return {begin, begin + lists_[i].size};
  }
  /// Adds an empty list.
  void add_list() { lists_.push_back({numbers_.size(), 0, 0}); }
  /// Adds a number at the end of a list.
  void add(std::size_t i, std::int32_t number) {
    List& list = lists_[i];
    if (list.size == list.room) {
      const std::size_t begin = numbers_.size(), old = list.begin;
      list.room = 2 * list.room + kRoom;
      numbers_.resize(begin + std::size_t(list.room));
      std::copy_n(numbers_.begin() + std::ptrdiff_t(old), list.size, numbers_.begin() + std::ptrdiff_t(begin));
      list.begin = begin;
    }
    numbers_[list.begin + std::size_t(list.size++)] = number;
  }
  /// Takes a number out of a list that has it; the last one gets its place.
  void remove(std::size_t i, std::int32_t number) {
    List& list = lists_[i];
    const auto begin = numbers_.begin() + std::ptrdiff_t(list.begin), last = begin + --list.size;
    *std::find(begin, last, number) = *last;
  }
  void clear(std::size_t i) { lists_[i].size = 0; }

private:
  static constexpr std::int32_t kRoom = 4;

  struct List {
    std::size_t begin;
    std::int32_t size, room;
  };
  std::vector<List> lists_;
  std::vector<std::int32_t> numbers_;
};

}  // namespace slice2mesh::detail
