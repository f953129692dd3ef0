// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "io/sample_mesh.hpp"
#include "slice2mesh/io/write_mesh.hpp"
#include "test_support.hpp"

namespace {

using slice2mesh::Facet;
using slice2mesh::FacetLabel;
using slice2mesh::Plc;
using slice2mesh::PlcWriteOptions;
using slice2mesh_test::BoxSolid;

/// The sample on a grid whose coordinates need many digits.
Plc sample() {
  Plc plc = slice2mesh_test::plc_of(slice2mesh_test::stepped_sample());
  for (slice2mesh::GridPoint& p : plc.vertices) {
    p.x = p.x * 111'111'111 - 7;
    p.y = p.y * 99'999'999 + 5;
  }
  plc.grid.pitch = 1.0 / (1 << 27);
  return plc;
}

double solid_volume(const BoxSolid& solid) {
  double volume = 0;
  for (std::size_t s = 0; s < solid.thickness.size(); ++s) volume += solid.area(s) * solid.thickness[s];
  return volume;
}

struct Surface {
  std::vector<std::array<double, 3>> points;
  std::vector<std::array<std::int32_t, 3>> faces;
};

double volume_of(const Surface& surface) {
  double sum = 0;
  for (const std::array<std::int32_t, 3>& f : surface.faces) {
    const auto& a = surface.points.at(static_cast<std::size_t>(f[0]));
    const auto& b = surface.points.at(static_cast<std::size_t>(f[1]));
    const auto& c = surface.points.at(static_cast<std::size_t>(f[2]));
    sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
  }
  return sum / 6;
}

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line);
  return {std::istream_iterator<std::string>(stream), {}};
}

template <class T>
T number(const std::string& word) {
  T value{};
  const auto result = std::from_chars(word.data(), word.data() + word.size(), value);
  if (result.ec != std::errc() || result.ptr != word.data() + word.size())
    throw std::runtime_error("not a number: " + word);
  return value;
}

Surface read_off(const std::string& text) {
  const std::vector<std::string> words = words_of(text);
  REQUIRE(words.at(0) == "OFF");
  Surface surface;
  surface.points.resize(number<std::size_t>(words.at(1)));
  surface.faces.resize(number<std::size_t>(words.at(2)));
  std::size_t at = 4;
  for (auto& p : surface.points)
    for (double& x : p) x = number<double>(words.at(at++));
  for (auto& f : surface.faces) {
    REQUIRE(words.at(at++) == "3");
    for (std::int32_t& v : f) v = number<std::int32_t>(words.at(at++));
  }
  CHECK(at == words.size());
  return surface;
}

std::string file_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

template <class T>
T take(const std::string& data, std::size_t& at) {
  T value;
  REQUIRE(at + sizeof(T) <= data.size());
  std::memcpy(&value, data.data() + at, sizeof(T));
  at += sizeof(T);
  return value;
}

std::string written(const std::string& extension, const Plc& plc, const PlcWriteOptions& options = {}) {
  const slice2mesh_test::TemporaryDirectory directory;
  slice2mesh::write_plc(directory.file("part." + extension), plc, options);
  return file_text(directory.file("part." + extension));
}

bool is_skin(const Facet& facet) {
  return facet.front.empty() || facet.back.empty();
}

}  // namespace

TEST_CASE("an OFF file with inner faces is the complex, number for number") {
  const Plc plc = sample();
  const Surface surface = read_off(written("off", plc));
  REQUIRE(surface.points.size() == plc.vertices.size());
  for (std::size_t v = 0; v < plc.vertices.size(); ++v) REQUIRE(surface.points[v] == plc.position(v));
  REQUIRE(surface.faces.size() == plc.facets.size());
  for (std::size_t f = 0; f < plc.facets.size(); ++f) REQUIRE(surface.faces[f] == plc.facets[f].vertices);
}

TEST_CASE("the outer skin alone is closed, encloses the volume of the solid and has no unused vertex") {
  const BoxSolid solid = slice2mesh_test::stepped_sample();
  PlcWriteOptions skin;
  skin.inner_faces = false;
  const Surface surface = read_off(written("off", slice2mesh_test::plc_of(solid), skin));
  CHECK(volume_of(surface) == Approx(solid_volume(solid)).epsilon(1e-13));
  std::map<std::array<std::int32_t, 2>, int> sides;
  std::vector<int> used(surface.points.size(), 0);
  for (const auto& f : surface.faces)
    for (std::size_t i = 0; i < 3; ++i) {
      used[static_cast<std::size_t>(f[i])] = 1;
      ++sides[{f[i], f[(i + 1) % 3]}];
    }
  CHECK(used == std::vector<int>(surface.points.size(), 1));
  for (const auto& side : sides) REQUIRE(side.second == sides[{side.first[1], side.first[0]}]);
}

TEST_CASE("an OBJ file has the complex in one group per label") {
  const Plc plc = sample();
  std::istringstream file(written("obj", plc));
  std::vector<std::array<double, 3>> points;
  std::map<std::string, std::vector<std::array<std::int32_t, 3>>> groups;
  std::string group;
  for (std::string line; std::getline(file, line);) {
    const std::vector<std::string> words = words_of(line);
    if (words.at(0) == "v") {
      points.push_back({number<double>(words.at(1)), number<double>(words.at(2)), number<double>(words.at(3))});
    } else if (words.at(0) == "g") {
      group = words.at(1);
      CHECK(groups.count(group) == 0);
    } else {
      REQUIRE(words.at(0) == "f");
      groups[group].push_back({number<std::int32_t>(words.at(1)) - 1, number<std::int32_t>(words.at(2)) - 1,
                               number<std::int32_t>(words.at(3)) - 1});
    }
  }
  REQUIRE(points.size() == plc.vertices.size());
  for (std::size_t v = 0; v < points.size(); ++v) REQUIRE(points[v] == plc.position(v));
  std::map<std::string, std::vector<std::array<std::int32_t, 3>>> expected;
  for (const Facet& f : plc.facets) expected[slice2mesh::to_string(f.label)].push_back(f.vertices);
  CHECK(expected.size() == 4);
  CHECK(groups == expected);
}

TEST_CASE("a PLY file holds coordinates bit for bit, labels and both sides of every facet") {
  const Plc plc = sample();
  const std::string file = written("ply", plc);
  CHECK(file.rfind("ply\nformat binary_little_endian 1.0\n", 0) == 0);
  CHECK(file.find("element vertex " + std::to_string(plc.vertices.size()) + "\n") != std::string::npos);
  CHECK(file.find("element face " + std::to_string(plc.facets.size()) + "\n") != std::string::npos);
  std::size_t at = file.find("end_header\n") + 11;
  REQUIRE(file.size() == at + plc.vertices.size() * 24 + plc.facets.size() * (1 + 12 + 1 + 16));
  for (std::size_t v = 0; v < plc.vertices.size(); ++v)
    for (const double x : plc.position(v)) REQUIRE(take<double>(file, at) == x);
  for (const Facet& f : plc.facets) {
    REQUIRE(take<std::uint8_t>(file, at) == 3);
    for (const std::int32_t v : f.vertices) REQUIRE(take<std::int32_t>(file, at) == v);
    REQUIRE(take<std::uint8_t>(file, at) == static_cast<std::uint8_t>(f.label));
    REQUIRE(take<std::int32_t>(file, at) == f.front.slab);
    REQUIRE(take<std::int32_t>(file, at) == f.front.region);
    REQUIRE(take<std::int32_t>(file, at) == f.back.slab);
    REQUIRE(take<std::int32_t>(file, at) == f.back.region);
  }
}

TEST_CASE("an STL file has the triangles in single precision, with unit normals that point outward") {
  const BoxSolid solid = slice2mesh_test::stepped_sample();
  const Plc plc = slice2mesh_test::plc_of(solid);
  PlcWriteOptions skin;
  skin.inner_faces = false;
  const std::string file = written("stl", plc, skin);
  CHECK(file.rfind("solid", 0) == std::string::npos);
  std::size_t at = 80;
  const auto count = take<std::uint32_t>(file, at);
  CHECK(count == static_cast<std::uint32_t>(std::count_if(plc.facets.begin(), plc.facets.end(), is_skin)));
  REQUIRE(file.size() == 84 + 50 * std::size_t{count});
  double volume = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    std::array<std::array<float, 3>, 4> v{};
    for (auto& p : v)
      for (float& x : p) x = take<float>(file, at);
    at += 2;
    const double length = std::sqrt(static_cast<double>(v[0][0] * v[0][0] + v[0][1] * v[0][1] + v[0][2] * v[0][2]));
    REQUIRE(length == Approx(1).epsilon(1e-6));
    std::array<std::array<double, 3>, 3> p{};
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t k = 0; k < 3; ++k) p[c][k] = static_cast<double>(v[c + 1][k]);
    Surface one{{p[0], p[1], p[2]}, {{0, 1, 2}}};
    volume += volume_of(one);
    const auto n = slice2mesh::detail::cross(slice2mesh::detail::difference(p[1], p[0]),
                                             slice2mesh::detail::difference(p[2], p[0]));
    REQUIRE(slice2mesh::detail::dot(
                n, {static_cast<double>(v[0][0]), static_cast<double>(v[0][1]), static_cast<double>(v[0][2])}) > 0);
  }
  CHECK(volume == Approx(solid_volume(solid)).epsilon(1e-6));
}

TEST_CASE("a POLY file has the complex, a point in every cell, and a point in every closed void") {
  // A block of 5 by 3 squares and 3 slabs with two closed voids in the middle slab and a notch that is open.
  BoxSolid solid;
  solid.nx = 5;
  solid.ny = 3;
  solid.thickness = {1, 1, 1};
  solid.region = [](std::size_t x, std::size_t y, std::size_t s) {
    const bool closed = s == 1 && y == 1 && (x == 1 || x == 3);
    const bool notch = s == 2 && y == 0 && x == 2;
    return closed || notch ? slice2mesh::kNone : 0;
  };
  const Plc plc = slice2mesh_test::plc_of(solid);
  for (const bool inner : {true, false}) {
    PlcWriteOptions options;
    options.inner_faces = inner;
    const std::vector<std::string> words = words_of(written("poly", plc, options));
    std::size_t at = 0;
    const auto count = [&] { return number<std::size_t>(words.at(at++)); };
    const auto real = [&] { return number<double>(words.at(at++)); };
    const std::size_t nodes = count();
    at += 3;
    Surface surface;
    for (std::size_t v = 0; v < nodes; ++v) {
      REQUIRE(count() == v);
      const double x = real();
      const double y = real();
      surface.points.push_back({x, y, real()});
    }
    const std::size_t faces = count();
    CHECK(faces == (inner ? plc.facets.size()
                          : static_cast<std::size_t>(std::count_if(plc.facets.begin(), plc.facets.end(), is_skin))));
    CHECK(count() == 1);
    for (std::size_t f = 0; f < faces; ++f) {
      CHECK(count() == 1);
      CHECK(count() == 0);
      const std::size_t marker = count();
      REQUIRE((marker >= 1 && marker <= 5));
      CHECK(count() == 3);
      surface.faces.push_back({number<std::int32_t>(words.at(at)), number<std::int32_t>(words.at(at + 1)),
                               number<std::int32_t>(words.at(at + 2))});
      at += 3;
    }
    if (inner) {
      for (std::size_t f = 0; f < faces; ++f) REQUIRE(surface.faces[f] == plc.facets[f].vertices);
    } else {
      CHECK(volume_of(surface) == Approx(solid_volume(solid)).epsilon(1e-13));
    }
    const std::size_t holes = count();
    REQUIRE(holes == 2);
    std::vector<std::array<double, 3>> points;
    for (std::size_t i = 0; i < holes; ++i) {
      CHECK(count() == i);
      const double x = real();
      const double y = real();
      points.push_back({x, y, real()});
    }
    std::sort(points.begin(), points.end());
    for (std::size_t i = 0; i < 2; ++i) {
      const double left = i == 0 ? 1 : 3;
      CHECK((points[i][0] > left && points[i][0] < left + 1));
      CHECK((points[i][1] > 1 && points[i][1] < 2));
      CHECK((points[i][2] > 1 && points[i][2] < 2));
    }
    const std::size_t cells = count();
    CHECK(cells == (inner ? 3U : 0U));
    for (std::size_t i = 0; i < cells; ++i) {
      count();
      real();
      real();
      const double z = real();
      const std::size_t attribute = count();
      CHECK((z > static_cast<double>(attribute - 1) && z < static_cast<double>(attribute)));
      CHECK(words.at(at++) == "-1");
    }
    CHECK(at == words.size());
  }
}

TEST_CASE("a complex whose arrays do not fit is refused, and so is an unknown extension") {
  const slice2mesh_test::TemporaryDirectory directory;
  for (const char* const name : {"a.off", "a.obj", "a.ply", "a.stl", "a.poly"}) {
    Plc plc = sample();
    slice2mesh::write_plc(directory.file(name), Plc{});
    const std::string old = file_text(directory.file(name));
    plc.facets[3].vertices[0] = -1;
    CHECK_THROWS_AS(slice2mesh::write_plc(directory.file(name), plc), slice2mesh::Error);
    plc = sample();
    plc.vertex_plane[0] = 100;
    CHECK_THROWS_AS(slice2mesh::write_plc(directory.file(name), plc), slice2mesh::Error);
    plc = sample();
    plc.vertex_plane.pop_back();
    CHECK_THROWS_AS(slice2mesh::write_plc(directory.file(name), plc), slice2mesh::Error);
    CHECK(file_text(directory.file(name)) == old);
  }
  for (const char* const name : {"part.vtu", "part", "part."}) {
    CHECK_THROWS_AS(slice2mesh::check_plc_path(name), slice2mesh::FileError);
    try {
      slice2mesh::write_plc(name, sample());
      FAIL("written: " << name);
    } catch (const slice2mesh::FileError& error) {
      CHECK(std::string(error.what()).find(".off, .obj, .ply, .stl, .poly") != std::string::npos);
    }
  }
}
