// SPDX-License-Identifier: MIT
#include "lengths.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <string>

#include "test_support.hpp"

using slice2mesh::Length;
using namespace slice2mesh_program;

TEST_CASE("a length without a unit or with mm is absolute, with h it counts layers") {
  for (const char* text : {"0.1", "0.1mm", ".1", "1e-1"}) {
    INFO(text);
    const auto length = parse_length(text);
    REQUIRE(length);
    CHECK(length->value == 0.1);
    CHECK_FALSE(length->relative);
  }
  const auto layers = parse_length("2h");
  REQUIRE(layers);
  CHECK(layers->value == 2);
  CHECK(layers->relative);
}

TEST_CASE("what is not exactly a length is refused") {
  for (const char* text : {"",    " ",   "h",   "mm",  "-1",  "+1",    " 1",   "1 ",    "1 h", "1H",
                           "1hh", "1cm", "0,1", "nan", "inf", "1e999", "0x10", "1.2.3", "--1", "1e"}) {
    INFO("'" << text << "'");
    CHECK_FALSE(parse_length(text));
  }
}

TEST_CASE("a zero with a minus sign is zero") {
  const auto length = parse_length("-0");
  REQUIRE(length);
  CHECK_FALSE(std::signbit(length->value));
}

TEST_CASE("the length of a part has its id before it") {
  const auto radius = parse_part_length("7:0.2h");
  REQUIRE(radius);
  CHECK(radius->first == 7);
  CHECK(radius->second.value == 0.2);
  CHECK(radius->second.relative);
  CHECK(parse_part_length("-1:0")->first == -1);
  for (const char* text : {"", ":", "7", "7:", ":0.2", "7=0.2", " 7:0.2", "7 :0.2", "7: 0.2", "7:0.2:1", "0.5:1",
                           "7:-1", "99999999999:1", "+7:1"}) {
    INFO("'" << text << "'");
    CHECK_FALSE(parse_part_length(text));
  }
}

TEST_CASE("a ball is a center, a radius and a length") {
  const auto ball = parse_ball("1.5,-2,3,0.5:0.2h");
  REQUIRE(ball);
  CHECK((ball->x == 1.5 && ball->y == -2 && ball->z == 3 && ball->radius == 0.5));
  CHECK(ball->size.value == 0.2);
  CHECK(ball->size.relative);
  CHECK(parse_ball("0,0,0,0:1")->size.value == 1);
  for (const char* text :
       {"", ":", "1,2,3:1", "1,2,3,4", "1,2,3,4:", "1,2,3,-4:1", "1,2,3,4:0", "1,2,3,4:-1", "1,2,3,4,5:1", "1;2,3,4:1",
        "1,2,3,4:1,2", " 1,2,3,4:1", "1,,3,4:1", "1,--2,3,4:1", "1,2,3,4:1 "}) {
    INFO("'" << text << "'");
    CHECK_FALSE(parse_ball(text));
  }
}

TEST_CASE("the text of a length gives the same length again") {
  constexpr std::uint64_t kSeed = 20240611;
  INFO("seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::size_t seen = 0;
  for (int i = 0; i < 2000; ++i) {
    const std::uint64_t bits = random() >> 1;  // not negative
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    if (!std::isfinite(value)) continue;
    ++seen;
    for (const Length length : {Length::mm(value), Length::layers(value)}) {
      const auto again = parse_length(to_text(length));
      REQUIRE(again);
      CHECK(again->value == value);
      CHECK(again->relative == length.relative);
    }
  }
  CHECK(seen > 1000);
}

TEST_CASE("a lump is a positive number of slices or a positive thickness in mm") {
  const auto count = parse_lump("4");
  REQUIRE(count);
  CHECK(count->count == 4);
  CHECK(count->thickness == 0);
  const auto thickness = parse_lump("0.2mm");
  REQUIRE(thickness);
  CHECK(thickness->thickness == 0.2);
  CHECK(thickness->count == 1);
  const auto whole = parse_lump("2mm");
  REQUIRE(whole);
  CHECK(whole->thickness == 2);
  for (const char* text : {"", "0", "-1", "1.5", "4h", "0mm", "mm", "4 ", "99999999999", "inf", "infmm"}) {
    INFO("'" << text << "'");
    CHECK_FALSE(parse_lump(text));
  }
}

TEST_CASE("counts are whole numbers that are not negative") {
  CHECK(parse_count("0") == std::int64_t{0});
  CHECK(parse_count("9223372036854775807") == std::numeric_limits<std::int64_t>::max());
  for (const char* text : {"", "-1", "1.0", "9223372036854775808", "1k", " 1"}) {
    INFO("'" << text << "'");
    CHECK_FALSE(parse_count(text));
  }
}
