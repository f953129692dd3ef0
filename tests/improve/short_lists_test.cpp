// SPDX-License-Identifier: MIT
#include "slice2mesh/improve/short_lists.hpp"

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include "test_support.hpp"

using namespace slice2mesh;

TEST_CASE("short lists hold what lists of their own would hold, in the same order") {
  std::size_t added = 0, removed = 0, longest = 0;
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    std::vector<std::int32_t> sizes(50);
    for (std::int32_t& size : sizes) size = std::int32_t(random() % 8);
    detail::ShortLists lists;
    lists.reset(sizes);
    REQUIRE(lists.size() == sizes.size());
    std::vector<std::vector<std::int32_t>> expected(sizes.size());
    for (std::int32_t number = 0; number < 5000; ++number) {
      // Some lists become long, and most stay short.
      const std::size_t i = std::min(random() % sizes.size(), random() % sizes.size());
      std::vector<std::int32_t>& list = expected[i];
      const std::uint32_t what = random() % 8;
      if (what == 0 && list.size() > 20) {
        list.clear();
        lists.clear(i);
      } else if (what < 4 && !list.empty()) {
        const std::size_t k = random() % list.size();
        lists.remove(i, list[k]);
        list[k] = list.back();
        list.pop_back();
        ++removed;
      } else {
        list.push_back(number);
        lists.add(i, number);
        ++added;
      }
      longest = std::max(longest, list.size());
      const auto now = lists[i];
      REQUIRE(std::equal(now.begin(), now.end(), list.begin(), list.end()));
      REQUIRE(now.empty() == list.empty());
    }
    for (std::size_t i = 0; i < expected.size(); ++i)
      REQUIRE(std::equal(lists[i].begin(), lists[i].end(), expected[i].begin(), expected[i].end()));
  }
  CHECK(added > 10000);
  CHECK(removed > 10000);
  CHECK(longest > 20);
}
