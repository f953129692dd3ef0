// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstddef>
#include <functional>
#include <random>
#include <vector>

#include "slice2mesh/core/listening_sort.hpp"
#include "test_support.hpp"

using slice2mesh::detail::Poll;
using slice2mesh::detail::sort_listening;

TEST_CASE("a sort that listens gives the order of std::sort, also of equal elements, and ends when told to") {
  struct Stop {};
  struct Item {
    int key, id;
    bool operator==(const Item& o) const { return key == o.key && id == o.id; }
  };
  const auto less = [](const Item& a, const Item& b) { return a.key < b.key; };
  std::mt19937 random(3);
  for (const std::size_t count : {std::size_t(0), std::size_t(1), std::size_t(4096), std::size_t(50000)}) {
    std::vector<Item> items;
    for (std::size_t i = 0; i < count; ++i) items.push_back({int(random() % 1000), int(i)});
    std::vector<Item> expected = items;
    std::sort(expected.begin(), expected.end(), less);
    std::size_t calls = 0, stop = std::size_t(-1);
    const std::function<void()> poll = [&] {
      if (calls++ == stop) throw Stop();
    };
    std::vector<Item> sorted = items;
    Poll listen(poll, 1000);
    sort_listening(sorted.begin(), sorted.end(), listen, less);
    CHECK(sorted == expected);
    CHECK(calls >= (count < 1000 ? 0 : count < 5000 ? 1 : 500));
    const std::size_t most = calls;
    for (stop = 0; stop < most; stop += 1 + most / 7) {
      calls = 0;
      sorted = items;
      Poll impatient(poll, 1000);
      CHECK_THROWS_AS(sort_listening(sorted.begin(), sorted.end(), impatient, less), Stop);
      CHECK(calls == stop + 1);
    }
  }
}
