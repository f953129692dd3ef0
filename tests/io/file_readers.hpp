// SPDX-License-Identifier: MIT
/// @file
/// @brief Simple readers of the formats, for the tests of the writers.
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "test_support.hpp"

namespace slice2mesh_test {

/// Numbers and words of a text, one after the other; numbers are read without a locale.
class Reader {
public:
  explicit Reader(const std::string& text, const char* separators = " \t\r\n") : text_(text), separators_(separators) {}
  std::string_view word() {
    at_ = std::min(text_.find_first_not_of(separators_, at_), text_.size());
    const std::size_t end = std::min(text_.find_first_of(separators_, at_), text_.size());
    const std::string_view result = std::string_view(text_).substr(at_, end - at_);
    at_ = end;
    return result;
  }
  template <class T>
  T number() {
    const std::string_view w = word();
    T value{};
    const auto result = std::from_chars(w.data(), w.data() + w.size(), value);
    if (result.ec != std::errc() || result.ptr != w.data() + w.size())
      throw std::runtime_error("not a number: " + std::string(w));
    return value;
  }
  double real() { return number<double>(); }
  std::size_t count() { return number<std::size_t>(); }
  void find(std::string_view word) {
    at_ = text_.find(word, at_);
    if (at_ == std::string::npos) throw std::runtime_error("missing: " + std::string(word));
    at_ += word.size();
  }
  [[nodiscard]] bool finished() const { return text_.find_first_not_of(separators_, at_) == std::string::npos; }

private:
  std::string text_;
  const char* separators_;
  std::size_t at_ = 0;
};

template <class Write>
[[nodiscard]] std::string text_of(Write write) {
  std::ostringstream out;
  write(static_cast<std::ostream&>(out));
  REQUIRE(out);
  return out.str();
}

template <class T>
[[nodiscard]] T bytes_at(const std::string& data, std::size_t at) {
  REQUIRE(at + sizeof(T) <= data.size());
  T value;
  std::memcpy(&value, data.data() + at, sizeof(T));
  return value;
}

[[nodiscard]] inline std::string file_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The values of an array of a VTU file without compression.
template <class T>
[[nodiscard]] std::vector<T> vtu_array(const std::string& file, const std::string& name) {
  const std::size_t element = file.find("Name=\"" + name + "\"");
  REQUIRE(element != std::string::npos);
  const std::size_t offset_text = file.find("offset=\"", element) + 8;
  std::size_t offset = 0;
  std::from_chars(file.data() + offset_text, file.data() + file.size(), offset);
  const std::size_t data = file.find("<AppendedData encoding=\"raw\">\n_") + 31;
  const auto bytes = bytes_at<std::uint64_t>(file, data + offset);
  std::vector<T> values(bytes / sizeof(T));
  REQUIRE(data + offset + 8 + bytes <= file.size());
  if (bytes > 0) std::memcpy(values.data(), file.data() + data + offset + 8, bytes);
  return values;
}

/// What a reader of MSH 4.1 keeps.
struct MshContent {
  std::map<std::array<int, 2>, std::string> names;                               // dimension and physical tag
  std::map<std::array<int, 2>, std::vector<int>> entities;                       // dimension and tag: physical tags
  std::map<std::size_t, std::array<double, 3>> nodes;                            // by tag
  std::map<std::array<int, 2>, std::vector<std::vector<std::size_t>>> elements;  // entity: tag and nodes
};

/// Reads both kinds of MSH 4.1, section by section.
[[nodiscard]] inline MshContent read_msh(const std::string& file, bool binary) {
  const std::map<std::array<int, 2>, std::size_t> node_counts = {{{2, 2}, 3}, {{3, 4}, 4}, {{2, 9}, 6}, {{3, 11}, 10}};
  MshContent content;
  std::size_t at = 0;
  Reader text(file);
  const auto find = [&](const std::string& section) {
    at = file.find(section + "\n");
    REQUIRE(at != std::string::npos);
    at += section.size() + 1;
    text.find(section + "\n");
  };
  const auto take = [&](auto example) {
    using T = decltype(example);
    if (!binary) return text.number<T>();
    const T value = bytes_at<T>(file, at);
    at += sizeof(T);
    return value;
  };
  const auto take_int = [&] { return take(std::int32_t{}); };
  const auto take_size = [&] { return static_cast<std::size_t>(take(std::uint64_t{})); };
  const auto take_real = [&] { return take(double{}); };
  find("$MeshFormat");
  CHECK(text.word() == "4.1");
  CHECK(text.word() == (binary ? "1" : "0"));
  CHECK(text.word() == "8");
  find("$PhysicalNames");
  const std::size_t names = text.count();
  for (std::size_t i = 0; i < names; ++i) {
    const int dimension = text.number<int>();
    const int tag = text.number<int>();
    content.names[{dimension, tag}] = std::string(text.word());
  }
  CHECK(text.word() == "$EndPhysicalNames");
  find("$Entities");
  CHECK(take_size() == 0);
  CHECK(take_size() == 0);
  const std::size_t surfaces = take_size();
  const std::size_t volumes = take_size();
  for (std::size_t i = 0; i < surfaces + volumes; ++i) {
    const int tag = take_int();
    std::array<double, 6> box{};
    for (double& x : box) x = take_real();
    for (std::size_t k = 0; k < 3; ++k) CHECK(box[k] <= box[k + 3]);
    std::vector<int>& physical = content.entities[{i < surfaces ? 2 : 3, tag}];
    for (std::size_t n = take_size(); n > 0; --n) physical.push_back(take_int());
    CHECK(take_size() == 0);
  }
  find("$Nodes");
  std::size_t blocks = take_size();
  const std::size_t node_count = take_size();
  take_size();
  CHECK(take_size() == node_count);
  for (; blocks > 0; --blocks) {
    const int dimension = take_int();
    const int entity = take_int();
    CHECK(content.entities.count({dimension, entity}) == 1);
    CHECK(take_int() == 0);
    std::vector<std::size_t> tags(take_size());
    for (std::size_t& tag : tags) tag = take_size();
    for (const std::size_t tag : tags)
      for (double& x : content.nodes[tag]) x = take_real();
  }
  CHECK(content.nodes.size() == node_count);
  find("$Elements");
  blocks = take_size();
  const std::size_t element_count = take_size();
  CHECK(take_size() == 1);
  CHECK(take_size() == element_count);
  std::set<std::size_t> tags;
  for (; blocks > 0; --blocks) {
    const int dimension = take_int();
    const int entity = take_int();
    const int type = take_int();
    const auto found = node_counts.find({dimension, type});
    REQUIRE(found != node_counts.end());
    for (std::size_t n = take_size(); n > 0; --n) {
      std::vector<std::size_t> element(found->second + 1);
      for (std::size_t& value : element) value = take_size();
      tags.insert(element[0]);
      content.elements[{dimension, entity}].push_back(element);
    }
  }
  CHECK(tags.size() == element_count);
  CHECK(*tags.begin() == 1);
  CHECK(*tags.rbegin() == element_count);
  return content;
}

}  // namespace slice2mesh_test
