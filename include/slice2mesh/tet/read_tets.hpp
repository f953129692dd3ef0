// SPDX-License-Identifier: MIT
/// @file
/// @brief Tets from the files of other meshers: Gmsh MSH 2.2 and 4.1, MEDIT, TetGen .node and .ele.
///
/// Only vertices and linear tets are taken; everything else in the files is skipped. Numbers of nodes need not be dense
/// and may begin anywhere.
#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <ios>
#include <string>
#include <string_view>
#include <system_error>
#include <unordered_map>
#include <vector>

#include "slice2mesh/core/error.hpp"
#include "slice2mesh/io/element_groups.hpp"
#include "slice2mesh/tet/restore_layers.hpp"

namespace slice2mesh {

namespace detail {

/// A whole file, read token by token or line by line.
class TetFile {
public:
  explicit TetFile(const std::string& path) : path_(path) {
    std::ifstream in(path, std::ios::binary);
    if (!in) fail("cannot be opened");
    text_.assign(std::istreambuf_iterator<char>(in), {});
    if (in.bad()) fail("cannot be read");
  }

  [[noreturn]] void fail(const std::string& what) const { throw FileError(Stage::Tetrahedralize, path_, what); }
  [[noreturn]] void fail_here(const std::string& what) const { fail("byte " + std::to_string(at_) + ": " + what); }

  /// The next token, or nothing at the end. Comments begin with '#'.
  [[nodiscard]] std::string_view token() {
    while (at_ < text_.size()) {
      if (text_[at_] == '#')
        skip_line();
      else if (is_space(text_[at_]))
        ++at_;
      else
        break;
    }
    const std::size_t begin = at_;
    while (at_ < text_.size() && !is_space(text_[at_]) && text_[at_] != '#') ++at_;
    return std::string_view(text_).substr(begin, at_ - begin);
  }
  [[nodiscard]] double real() { return number<double>(token()); }
  [[nodiscard]] std::int64_t integer() { return number<std::int64_t>(token()); }
  /// A number of things to come, each of which takes at least `bytes` bytes: nothing is allocated that cannot be there.
  [[nodiscard]] std::size_t count(std::size_t bytes) { return checked_count(integer(), bytes); }
  [[nodiscard]] std::size_t checked_count(std::int64_t value, std::size_t bytes) const {
    if (value < 0 || static_cast<std::uint64_t>(value) > (text_.size() - at_) / bytes + 1)
      fail_here("a count of " + std::to_string(value) + " is not possible");
    return static_cast<std::size_t>(value);
  }
  void skip_line() {
    while (at_ < text_.size() && text_[at_] != '\n') ++at_;
    if (at_ < text_.size()) ++at_;
  }
  /// Goes behind the next place where `word` begins a line; false if there is none.
  [[nodiscard]] bool find_line(std::string_view word) {
    for (std::size_t place = text_.find(word, at_); place != std::string::npos; place = text_.find(word, place + 1))
      if (place == 0 || text_[place - 1] == '\n') {
        at_ = place + word.size();
        return true;
      }
    return false;
  }
  void rewind() { at_ = 0; }
  /// The bytes of a value as they are in the file.
  template <class T>
  [[nodiscard]] T binary() {
    if (text_.size() - at_ < sizeof(T)) fail_here("ends too early");
    T value;
    std::memcpy(&value, text_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }

private:
  [[nodiscard]] static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
  template <class T>
  [[nodiscard]] T number(std::string_view text) const {
    T value{};
    if (!text.empty() && text.front() == '+') text.remove_prefix(1);
    const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
    if (result.ec != std::errc() || result.ptr != text.data() + text.size())
      fail_here(text.empty() ? "ends where a number is expected"
                             : "'" + std::string(text.substr(0, 40)) + "' is not the number that is expected");
    return value;
  }

  std::string path_;
  std::string text_;
  std::size_t at_ = 0;
};

/// Vertices by the numbers that a file gives them.
class NodeNumbers {
public:
  void add(std::int64_t number, const std::array<double, 3>& p, RawTets& tets, const TetFile& file) {
    if (!index_.emplace(number, static_cast<std::int32_t>(tets.vertices.size())).second)
      file.fail_here("node " + std::to_string(number) + " comes twice");
    tets.vertices.push_back(p);
  }
  [[nodiscard]] std::int32_t at(std::int64_t number, const TetFile& file) const {
    const auto it = index_.find(number);
    if (it == index_.end()) file.fail_here("node " + std::to_string(number) + " does not exist");
    return it->second;
  }

private:
  std::unordered_map<std::int64_t, std::int32_t> index_;
};

inline constexpr std::int64_t kGmshTet = 4;

/// Nodes of the element types of Gmsh by number; 0: not known. Binary files cannot be read without.
[[nodiscard]] inline std::size_t gmsh_nodes(std::int64_t type) {
  constexpr std::array<std::size_t, 20> kNodes = {0, 2, 3, 4, 4, 8, 6, 5, 3, 6, 9, 10, 27, 18, 14, 1, 8, 20, 15, 13};
  return type >= 0 && static_cast<std::size_t>(type) < kNodes.size() ? kNodes[static_cast<std::size_t>(type)] : 0;
}

[[nodiscard]] inline RawTets read_msh(const std::string& path) {
  TetFile file(path);
  RawTets tets;
  NodeNumbers nodes;
  if (!file.find_line("$MeshFormat")) file.fail("has no $MeshFormat");
  const double version = file.real();
  const bool binary = file.integer() != 0;
  const std::int64_t size = file.integer();
  if (version != 2.2 && !(version == 4.1 && !binary))
    file.fail_here("only MSH 2.2 and MSH 4.1 as text are read, not version " + number_text(version) +
                   (binary ? " binary" : ""));
  if (binary) {
    file.skip_line();
    if (size != 8 || file.binary<std::int32_t>() != 1) file.fail_here("was written on another kind of machine");
  }
  const auto point = [&]() -> std::array<double, 3> {
    const double x = file.real(), y = file.real(), z = file.real();
    return {x, y, z};
  };
  if (!file.find_line("$Nodes")) file.fail("has no $Nodes");
  if (version == 2.2) {
    const std::size_t count = file.count(binary ? 28 : 8);
    if (binary) file.skip_line();
    for (std::size_t i = 0; i < count; ++i) {
      if (binary) {
        const auto number = file.binary<std::int32_t>();
        const double x = file.binary<double>(), y = file.binary<double>(), z = file.binary<double>();
        nodes.add(number, {x, y, z}, tets, file);
      } else {
        const std::int64_t number = file.integer();
        nodes.add(number, point(), tets, file);
      }
    }
  } else {
    const std::size_t blocks = file.count(8);
    file.skip_line();
    for (std::size_t b = 0; b < blocks; ++b) {
      (void)file.integer();
      (void)file.integer();
      if (file.integer() != 0) file.fail_here("parametric nodes are not read");
      const std::size_t count = file.count(2);
      std::vector<std::int64_t> numbers(count);
      for (std::int64_t& number : numbers) number = file.integer();
      for (const std::int64_t number : numbers) nodes.add(number, point(), tets, file);
    }
  }
  if (!file.find_line("$Elements")) file.fail("has no $Elements");
  if (version == 2.2) {
    const std::size_t count = file.count(binary ? 4 : 8);
    if (binary) file.skip_line();
    for (std::size_t i = 0; i < count;) {
      if (binary) {
        const std::int64_t type = file.binary<std::int32_t>();
        const std::size_t some = file.checked_count(file.binary<std::int32_t>(), 8);
        const std::size_t tags = file.checked_count(file.binary<std::int32_t>(), 4);
        const std::size_t corners = gmsh_nodes(type);
        if (corners == 0 || some == 0) file.fail_here("elements of type " + std::to_string(type) + " are not read");
        for (std::size_t e = 0; e < some; ++e) {
          for (std::size_t k = 0; k < tags + 1; ++k) (void)file.binary<std::int32_t>();
          std::array<std::int32_t, 4> tet{};
          for (std::size_t k = 0; k < corners; ++k) {
            const std::int64_t number = file.binary<std::int32_t>();
            if (type == kGmshTet) tet[k] = nodes.at(number, file);
          }
          if (type == kGmshTet) tets.tets.push_back(tet);
        }
        i += some;
      } else {
        (void)file.integer();
        if (file.integer() == kGmshTet) {
          const std::size_t tags = file.count(1);
          for (std::size_t k = 0; k < tags; ++k) (void)file.integer();
          std::array<std::int32_t, 4> tet{};
          for (std::int32_t& v : tet) v = nodes.at(file.integer(), file);
          tets.tets.push_back(tet);
        } else {
          file.skip_line();
        }
        ++i;
      }
    }
  } else {
    const std::size_t blocks = file.count(8);
    file.skip_line();
    for (std::size_t b = 0; b < blocks; ++b) {
      (void)file.integer();
      (void)file.integer();
      const bool is_tet = file.integer() == kGmshTet;
      const std::size_t count = file.count(2);
      file.skip_line();
      for (std::size_t e = 0; e < count; ++e) {
        if (is_tet) {
          (void)file.integer();
          std::array<std::int32_t, 4> tet{};
          for (std::int32_t& v : tet) v = nodes.at(file.integer(), file);
          tets.tets.push_back(tet);
        } else {
          file.skip_line();
        }
      }
    }
  }
  return tets;
}

[[nodiscard]] inline RawTets read_medit(const std::string& path) {
  TetFile file(path);
  RawTets tets;
  std::vector<std::array<std::int64_t, 4>> numbers;
  bool with_vertices = false, with_tets = false;
  std::int64_t dimension = 3;
  for (std::string_view word = file.token(); !word.empty() && word != "End"; word = file.token()) {
    if (word == "Dimension") {
      dimension = file.integer();
      if (dimension != 3) file.fail_here("is not three-dimensional");
    } else if (word == "Vertices") {
      const std::size_t count = file.count(8);
      for (std::size_t v = 0; v < count; ++v) {
        const double x = file.real(), y = file.real(), z = file.real();
        (void)file.token();  // reference
        tets.vertices.push_back({x, y, z});
      }
      with_vertices = true;
    } else if (word == "Tetrahedra") {
      const std::size_t count = file.count(10);
      for (std::size_t t = 0; t < count; ++t) {
        std::array<std::int64_t, 4> tet{};
        for (std::int64_t& v : tet) v = file.integer();
        (void)file.token();  // reference
        numbers.push_back(tet);
      }
      with_tets = true;
    }
  }
  if (!with_vertices || !with_tets) file.fail("has no Vertices or no Tetrahedra");
  for (const std::array<std::int64_t, 4>& given : numbers) {
    std::array<std::int32_t, 4> tet{};
    for (std::size_t k = 0; k < 4; ++k) {
      if (!in_range(given[k] - 1, tets.vertices.size()))
        file.fail("vertex " + std::to_string(given[k]) + " does not exist");
      tet[k] = static_cast<std::int32_t>(given[k] - 1);
    }
    tets.tets.push_back(tet);
  }
  return tets;
}

[[nodiscard]] inline RawTets read_node_ele(const std::string& path) {
  const std::string stem = path.substr(0, path.size() - extension(path).size());
  RawTets tets;
  NodeNumbers nodes;
  TetFile node(stem + "node");
  const std::size_t vertices = node.count(8);
  if (node.integer() != 3) node.fail_here("is not three-dimensional");
  node.skip_line();
  for (std::size_t v = 0; v < vertices; ++v) {
    const std::int64_t number = node.integer();
    const double x = node.real(), y = node.real(), z = node.real();
    nodes.add(number, {x, y, z}, tets, node);
    node.skip_line();  // attributes, marker
  }
  TetFile ele(stem + "ele");
  const std::size_t count = ele.count(10);
  const std::int64_t corners = ele.integer();
  if (corners != 4 && corners != 10) ele.fail_here("has elements with " + std::to_string(corners) + " nodes");
  ele.skip_line();
  for (std::size_t t = 0; t < count; ++t) {
    (void)ele.integer();
    std::array<std::int32_t, 4> tet{};
    for (std::int32_t& v : tet) v = nodes.at(ele.integer(), ele);
    tets.tets.push_back(tet);
    ele.skip_line();
  }
  return tets;
}

}  // namespace detail

/// Reads vertices and linear tets; the format follows from the extension: .msh (Gmsh 2.2 as text or binary, 4.1 as
/// text), .mesh (MEDIT as text), .node or .ele (TetGen: both files of the same stem). Does not depend on the locale.
/// Errors: FileError (Stage::Tetrahedralize) that names the byte. Cost: linear.
[[nodiscard]] inline RawTets read_tets(const std::string& path) {
  const std::string extension = detail::extension(path);
  if (extension == "msh") return detail::read_msh(path);
  if (extension == "mesh") return detail::read_medit(path);
  if (extension == "node" || extension == "ele") return detail::read_node_ele(path);
  throw FileError(Stage::Tetrahedralize, path, "must end in .msh, .mesh, .node or .ele");
}

}  // namespace slice2mesh
