// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <locale>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "io/file_readers.hpp"
#include "io/sample_mesh.hpp"
#include "slice2mesh/io/write_mesh.hpp"
#include "test_support.hpp"

namespace {

using slice2mesh::BoundaryKind;
using slice2mesh::BoundarySets;
using slice2mesh::Mesh;
using slice2mesh::WriteOptions;
using slice2mesh_test::bytes_at;
using slice2mesh_test::file_text;
using slice2mesh_test::MshContent;
using slice2mesh_test::read_msh;
using slice2mesh_test::Reader;
using slice2mesh_test::text_of;
using slice2mesh_test::vtu_array;

/// The sample with coordinates that need all 17 digits, exponents and signs.
Mesh sample() {
  Mesh mesh = slice2mesh_test::mesh_of(slice2mesh_test::stepped_sample());
  for (std::array<double, 3>& p : mesh.vertices) {
    p[0] = (p[0] - 2) / 3;
    p[1] = p[1] * 1e-7 / 7;
  }
  return mesh;
}

}  // namespace

TEST_CASE("a VTU file holds vertices, tets and labels bit for bit") {
  const Mesh mesh = sample();
  WriteOptions options;
  options.time_per_layer = 2.5;
  const std::string file = text_of([&](std::ostream& out) { slice2mesh::write_vtu(out, mesh, options); });
  const std::vector<double> points = vtu_array<double>(file, "Points");
  REQUIRE(points.size() == 3 * mesh.vertices.size());
  CHECK(std::memcmp(points.data(), mesh.vertices.data(), points.size() * sizeof(double)) == 0);
  const std::vector<std::int32_t> connectivity = vtu_array<std::int32_t>(file, "connectivity");
  REQUIRE(connectivity.size() == 4 * mesh.tets.size());
  CHECK(std::memcmp(connectivity.data(), mesh.tets.data(), connectivity.size() * sizeof(std::int32_t)) == 0);
  CHECK(vtu_array<std::int32_t>(file, "layer") == mesh.tet_slab);
  CHECK(vtu_array<std::int32_t>(file, "region") == mesh.tet_region);
  const auto part = vtu_array<std::int32_t>(file, "part");
  const auto material = vtu_array<std::uint8_t>(file, "material");
  const auto bundle = vtu_array<std::int32_t>(file, "bundle");
  const auto slice = vtu_array<std::int32_t>(file, "slice");
  const auto time = vtu_array<double>(file, "activation_time");
  const auto offsets = vtu_array<std::int32_t>(file, "offsets");
  const auto types = vtu_array<std::uint8_t>(file, "types");
  REQUIRE(part.size() == mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const slice2mesh::Region& region = mesh.regions[static_cast<std::size_t>(mesh.tet_region[t])];
    REQUIRE(part[t] == region.part);
    REQUIRE(bundle[2 * t] == 3 * mesh.tet_slab[t]);
    REQUIRE(bundle[2 * t + 1] == 3 * mesh.tet_slab[t] + 2);
    REQUIRE(material[t] == (region.kind == slice2mesh::RegionKind::Support ? 1 : 0));
    REQUIRE(slice[t] == 3 * mesh.tet_slab[t] + 1);
    REQUIRE(time[t] == 2.5 * mesh.tet_slab[t]);
    REQUIRE(offsets[t] == static_cast<std::int32_t>(4 * (t + 1)));
    REQUIRE(types[t] == 10);
  }
  CHECK(vtu_array<double>(file, "slab_z_low") == std::vector<double>{0, 0.25, 0.5, 1});
  CHECK(vtu_array<double>(file, "slab_z_high") == std::vector<double>{0.25, 0.5, 1, 1.125});
  CHECK(vtu_array<std::int32_t>(file, "region_part") == std::vector<std::int32_t>{7, 7, 9});
  CHECK(file.find("version=\"1.0\"") != std::string::npos);
  CHECK(file.find("header_type=\"UInt64\"") != std::string::npos);
  CHECK(file.rfind("</VTKFile>\n") == file.size() - 11);
}

TEST_CASE("activation times of a VTU file come from the user's function, and are left out when not asked for") {
  const Mesh mesh = sample();
  const std::string plain = text_of([&](std::ostream& out) { slice2mesh::write_vtu(out, mesh); });
  CHECK(plain.find("activation_time") == std::string::npos);
  WriteOptions options;
  options.activation = [](std::int32_t slab, std::size_t tet) { return 100.0 * slab + static_cast<double>(tet); };
  const std::string file = text_of([&](std::ostream& out) { slice2mesh::write_vtu(out, mesh, options); });
  const auto time = vtu_array<double>(file, "activation_time");
  REQUIRE(time.size() == mesh.tets.size());
  for (std::size_t t = 0; t < time.size(); ++t) REQUIRE(time[t] == 100.0 * mesh.tet_slab[t] + static_cast<double>(t));
  options.activation = nullptr;
  options.time_per_layer = -1;
  CHECK_THROWS_AS(text_of([&](std::ostream& out) { slice2mesh::write_vtu(out, mesh, options); }),
                  slice2mesh::OptionError);
#ifndef SLICE2MESH_HAS_ZLIB
  options = {};
  options.compress = true;
  CHECK_THROWS_AS(text_of([&](std::ostream& out) { slice2mesh::write_vtu(out, mesh, options); }),
                  slice2mesh::OptionError);
#endif
}

TEST_CASE("an MSH file, text or binary, holds the mesh with one named group per layer and region and per surface") {
  const Mesh mesh = sample();
  const BoundarySets sets = slice2mesh::boundary_sets(mesh);
  for (const bool binary : {false, true}) {
    WriteOptions options;
    options.binary = binary;
    const MshContent content =
        read_msh(text_of([&](std::ostream& out) { slice2mesh::write_msh(out, mesh, options); }), binary);
    REQUIRE(content.nodes.size() == mesh.vertices.size());
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) REQUIRE(content.nodes.at(v + 1) == mesh.vertices[v]);
    std::set<std::string> names;
    std::size_t tets = 0;
    std::map<std::array<std::int32_t, 2>, int> group_of;
    for (const auto& entity : content.entities) {
      REQUIRE(entity.second.size() == 1);
      const std::array<int, 2> physical = {entity.first[0], entity.second[0]};
      REQUIRE(content.names.count(physical) == 1);
      names.insert(content.names.at(physical));
      REQUIRE(content.elements.count(entity.first) == 1);
      if (entity.first[0] == 2) {
        const std::vector<slice2mesh::TetFace>& set = sets.sets[static_cast<std::size_t>(entity.first[1] - 1)];
        const auto& triangles = content.elements.at(entity.first);
        REQUIRE(triangles.size() == set.size());
        for (std::size_t i = 0; i < set.size(); ++i)
          for (std::size_t k = 0; k < 3; ++k)
            REQUIRE(triangles[i][k + 1] == static_cast<std::size_t>(slice2mesh::face_vertices(mesh, set[i])[k]) + 1);
        continue;
      }
      for (const std::vector<std::size_t>& element : content.elements.at(entity.first)) {
        const std::size_t t = element[0] - 1;
        ++tets;
        for (std::size_t k = 0; k < 4; ++k) REQUIRE(element[k + 1] == static_cast<std::size_t>(mesh.tets[t][k]) + 1);
        const auto placed = group_of.insert({{mesh.tet_slab[t], mesh.tet_region[t]}, entity.first[1]});
        REQUIRE(placed.first->second == entity.first[1]);
      }
    }
    CHECK(tets == mesh.tets.size());
    CHECK(content.names.size() == content.entities.size());
    CHECK(names.size() == content.entities.size());
    CHECK(group_of.size() == 9);  // slabs 0 and 1 with three regions, 2 with two, 3 with one
    for (const char* const name :
         {"\"bottom\"", "\"top\"", "\"wall\"", "\"upskin\"", "\"downskin\"", "\"support_interface\"",
          "\"layer_0001_bracket\"", "\"layer_0002_support_7\"", "\"layer_0003_second__part_\""})
      CHECK(names.count(name) == 1);
  }
}

TEST_CASE("surfaces and inner interfaces are left out on request") {
  const Mesh mesh = sample();
  WriteOptions options;
  options.interfaces = false;
  MshContent content = read_msh(text_of([&](std::ostream& out) { slice2mesh::write_msh(out, mesh, options); }), false);
  CHECK(content.entities.count({2, 5}) == 1);
  CHECK(content.entities.count({2, 6}) == 0);
  options.surfaces = false;
  content = read_msh(text_of([&](std::ostream& out) { slice2mesh::write_msh(out, mesh, options); }), false);
  CHECK(content.entities.count({2, 1}) == 0);
  CHECK(content.entities.size() == 9);
}

TEST_CASE("a MEDIT file holds the mesh with layer + 1 as reference") {
  const Mesh mesh = sample();
  const BoundarySets sets = slice2mesh::boundary_sets(mesh);
  Reader text(text_of([&](std::ostream& out) { slice2mesh::write_medit(out, mesh); }));
  text.find("MeshVersionFormatted");
  CHECK(text.count() == 2);
  text.find("Dimension");
  CHECK(text.count() == 3);
  text.find("Vertices");
  REQUIRE(text.count() == mesh.vertices.size());
  for (const std::array<double, 3>& p : mesh.vertices) {
    for (const double x : p) REQUIRE(text.real() == x);
    text.count();
  }
  text.find("Triangles");
  std::size_t triangles = text.count();
  for (std::size_t k = 0; k < slice2mesh::kBoundaryKinds; ++k)
    for (const slice2mesh::TetFace& f : sets.sets[k]) {
      for (const std::int32_t v : slice2mesh::face_vertices(mesh, f)) REQUIRE(text.number<std::int32_t>() == v + 1);
      REQUIRE(text.count() == k + 1);
      --triangles;
    }
  CHECK(triangles == 0);
  text.find("Tetrahedra");
  REQUIRE(text.count() == mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (const std::int32_t v : mesh.tets[t]) REQUIRE(text.number<std::int32_t>() == v + 1);
    REQUIRE(text.number<std::int32_t>() == mesh.tet_slab[t] + 1);
  }
  CHECK(text.word() == "End");
  CHECK(text.finished());
}

TEST_CASE("MFEM files hold the mesh; v1.3 names every attribute that v1.0 has as a number") {
  const Mesh mesh = sample();
  const BoundarySets sets = slice2mesh::boundary_sets(mesh);
  for (const bool named : {false, true}) {
    WriteOptions options;
    options.mfem_names = named;
    const std::string file = text_of([&](std::ostream& out) { slice2mesh::write_mfem(out, mesh, options); });
    CHECK(file.rfind(named ? "MFEM mesh v1.3\n" : "MFEM mesh v1.0\n", 0) == 0);
    Reader text(file);
    text.find("\ndimension");
    CHECK(text.count() == 3);
    text.find("\nelements");
    REQUIRE(text.count() == mesh.tets.size());
    std::set<std::size_t> attributes;
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      const std::size_t attribute = text.count();
      attributes.insert(attribute);
      REQUIRE(attribute == static_cast<std::size_t>(mesh.tet_region[t] * 4 + mesh.tet_slab[t] + 1));
      REQUIRE(text.count() == 4);
      for (const std::int32_t v : mesh.tets[t]) REQUIRE(text.number<std::int32_t>() == v);
    }
    std::map<std::string, std::vector<std::size_t>> named_sets;
    const auto read_sets = [&](const char* section) {
      text.find(section);
      for (std::size_t n = text.count(); n > 0; --n) {
        const std::string name(text.word());
        CHECK(named_sets.count(name) == 0);
        for (std::size_t m = text.count(); m > 0; --m) named_sets[name].push_back(text.count());
      }
    };
    if (named) {
      read_sets("\nattribute_sets");
      std::set<std::size_t> covered;
      for (const auto& set : named_sets) covered.insert(set.second.begin(), set.second.end());
      CHECK(covered == attributes);
      CHECK(named_sets.at("\"layer_0002\"") == std::vector<std::size_t>{2, 6, 10});
      CHECK(named_sets.at("\"region_support_7\"") == std::vector<std::size_t>{5, 6});
      CHECK(named_sets.at("\"layer_0001_bracket\"") == std::vector<std::size_t>{1});
    }
    text.find("\nboundary");
    std::size_t triangles = text.count();
    for (std::size_t k = 0; k < slice2mesh::kBoundaryKinds; ++k)
      for (const slice2mesh::TetFace& f : sets.sets[k]) {
        REQUIRE(text.count() == k + 1);
        REQUIRE(text.count() == 2);
        for (const std::int32_t v : slice2mesh::face_vertices(mesh, f)) REQUIRE(text.number<std::int32_t>() == v);
        --triangles;
      }
    CHECK(triangles == 0);
    if (named) {
      read_sets("\nbdr_attribute_sets");
      CHECK(named_sets.at("\"support_interface\"") == std::vector<std::size_t>{6});
    }
    text.find("\nvertices");
    REQUIRE(text.count() == mesh.vertices.size());
    CHECK(text.count() == 3);
    for (const std::array<double, 3>& p : mesh.vertices)
      for (const double x : p) REQUIRE(text.real() == x);
    if (named) CHECK(text.word() == "mfem_mesh_end");
    CHECK(text.finished());
  }
}

TEST_CASE("an INP file holds the mesh in fields that solvers can read, with sets and surfaces") {
  const Mesh mesh = sample();
  const BoundarySets sets = slice2mesh::boundary_sets(mesh);
  std::istringstream file(text_of([&](std::ostream& out) { slice2mesh::write_inp(out, mesh); }));
  std::string section;
  std::map<std::string, std::vector<std::vector<std::string>>> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("**", 0) == 0) continue;
    if (line[0] == '*') {
      section = line;
      CHECK(rows.count(section) == 0);
      rows[section];
      continue;
    }
    std::vector<std::string> fields;
    std::istringstream fields_of_line(line);
    for (std::string field; std::getline(fields_of_line, field, ',');)
      fields.push_back(field.substr(std::min(field.find_first_not_of(' '), field.size())));
    REQUIRE(fields.size() <= 16);
    for (const std::string& field : fields) REQUIRE(field.size() <= 20);
    rows[section].push_back(fields);
  }
  const auto real = [](const std::string& s) {
    double value = 0;
    std::from_chars(s.data(), s.data() + s.size(), value);
    return value;
  };
  const auto& nodes = rows.at("*NODE, NSET=NALL");
  REQUIRE(nodes.size() == mesh.vertices.size());
  std::size_t exact = 0;
  for (std::size_t v = 0; v < nodes.size(); ++v) {
    REQUIRE(nodes[v].at(0) == std::to_string(v + 1));
    for (std::size_t i = 0; i < 3; ++i) {
      const double x = mesh.vertices[v][i];
      REQUIRE(std::fabs(real(nodes[v].at(i + 1)) - x) <= 1e-13 * std::fabs(x));
      if (real(nodes[v].at(i + 1)) == x) ++exact;
    }
  }
  CHECK(exact > 2 * nodes.size());
  std::size_t tets = 0;
  for (std::int32_t s = 0; s < 4; ++s)
    for (const std::vector<std::string>& row :
         rows.at("*ELEMENT, TYPE=C3D4, ELSET=LAYER_000" + std::to_string(s + 1))) {
      const auto t = static_cast<std::size_t>(std::stoul(row.at(0))) - 1;
      REQUIRE(mesh.tet_slab.at(t) == s);
      for (std::size_t i = 0; i < 4; ++i) REQUIRE(row.at(i + 1) == std::to_string(mesh.tets[t][i] + 1));
      ++tets;
    }
  CHECK(tets == mesh.tets.size());
  const auto members = [&](const std::string& name) {
    std::set<std::size_t> result;
    const auto run = rows.find(name + ", GENERATE");
    if (run != rows.end()) {
      REQUIRE(run->second.size() == 1);
      const std::vector<std::string>& row = run->second[0];
      REQUIRE(row.size() == 3);
      for (std::size_t i = std::stoul(row[0]); i <= std::stoul(row[1]); i += std::stoul(row[2])) result.insert(i - 1);
      return result;
    }
    for (const std::vector<std::string>& row : rows.at(name))
      for (const std::string& field : row) CHECK(result.insert(std::stoul(field) - 1).second);
    return result;
  };
  const std::array<const char*, 3> regions = {"BRACKET", "SUPPORT_7", "SECOND__PART_"};
  for (std::int32_t r = 0; r < 3; ++r) {
    const std::string name = regions[static_cast<std::size_t>(r)];
    std::set<std::size_t> all;
    for (std::size_t t = 0; t < mesh.tets.size(); ++t)
      if (mesh.tet_region[t] == r) all.insert(t);
    CHECK(members("*ELSET, ELSET=REGION_" + name) == all);
    std::set<std::size_t> first_layer;
    for (const std::size_t t : all)
      if (mesh.tet_slab[t] == 0) first_layer.insert(t);
    CHECK(members("*ELSET, ELSET=LAYER_0001_" + name) == first_layer);
  }
  CHECK(rows.at("*ELSET, ELSET=EALL").size() == 4);
  // The format's numbering of faces: S1 1-2-3, S2 1-4-2, S3 2-4-3, S4 3-4-1.
  const std::array<std::array<std::size_t, 3>, 4> corners = {{{{0, 1, 2}}, {{0, 3, 1}}, {{1, 3, 2}}, {{2, 3, 0}}}};
  const std::array<const char*, 6> surfaces = {"BOTTOM", "TOP", "WALL", "UPSKIN", "DOWNSKIN", "SUPPORT_INTERFACE"};
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    const auto& faces = rows.at(std::string("*SURFACE, NAME=") + surfaces[k] + ", TYPE=ELEMENT");
    REQUIRE(faces.size() == sets.sets[k].size());
    for (std::size_t i = 0; i < faces.size(); ++i) {
      const std::array<std::int32_t, 3> expected = slice2mesh::face_vertices(mesh, sets.sets[k][i]);
      const std::array<std::int32_t, 4>& tet = mesh.tets[static_cast<std::size_t>(std::stoul(faces[i].at(0))) - 1];
      std::set<std::int32_t> found;
      for (const std::size_t c : corners.at(static_cast<std::size_t>(faces[i].at(1).at(1) - '1'))) found.insert(tet[c]);
      REQUIRE(found == std::set<std::int32_t>(expected.begin(), expected.end()));
    }
  }
}

TEST_CASE("the steps of an INP job remove all layers but the first, add one per step, and film what is exposed") {
  const Mesh mesh = slice2mesh_test::mesh_of(slice2mesh_test::stepped_sample());
  const BoundarySets sets = slice2mesh::boundary_sets(mesh);
  std::istringstream file(text_of([&](std::ostream& out) { slice2mesh::write_inp_steps(out, mesh, "part.inp"); }));
  std::map<std::string, std::set<std::size_t>> elsets;
  std::vector<std::map<std::string, std::string>> films(1);  // per step: set and face
  std::vector<std::vector<std::string>> changes(1);
  std::string section;
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("**", 0) == 0) continue;
    if (line[0] == '*') {
      section = line;
      if (line.rfind("*STEP", 0) == 0) {
        films.emplace_back();
        changes.emplace_back();
      }
      continue;
    }
    if (section.rfind("*ELSET, ELSET=", 0) == 0) {
      const std::string name = section.substr(14, std::min(section.find(',', 14), section.size()) - 14);
      Reader row(line, " ,");
      if (section.find(", GENERATE") != std::string::npos) {
        const std::size_t first = row.count();
        const std::size_t last = row.count();
        for (std::size_t i = first; i <= last; ++i) CHECK(elsets[name].insert(i - 1).second);
      } else {
        while (!row.finished()) CHECK(elsets[name].insert(row.count() - 1).second);
      }
    } else if (section == "*FILM, OP=NEW") {
      Reader row(line, " ,");
      const std::string name(row.word());
      CHECK(films.back().emplace(name, std::string(row.word())).second);
    } else if (section.rfind("*MODEL CHANGE", 0) == 0) {
      changes.back().push_back((section.find("REMOVE") != std::string::npos ? "-" : "+") + line);
    }
  }
  REQUIRE(films.size() == 5);
  CHECK(changes[1] == std::vector<std::string>{"-LAYER_0002", "-LAYER_0003", "-LAYER_0004"});
  for (std::size_t k = 1; k < 4; ++k)
    CHECK(changes[k + 1] == std::vector<std::string>{"+LAYER_000" + std::to_string(k + 1)});
  constexpr std::array<std::int32_t, 4> kOpposite = {3, 2, 0, 1};  // vertex that face F1..F4 leaves out
  for (std::int32_t k = 0; k < 4; ++k) {
    std::set<slice2mesh::TetFace> filmed;
    for (const auto& film : films[static_cast<std::size_t>(k) + 1])
      for (const std::size_t t : elsets.at(film.first))
        CHECK(
            filmed.insert({static_cast<std::int32_t>(t), kOpposite.at(static_cast<std::size_t>(film.second[1] - '1'))})
                .second);
    const std::vector<slice2mesh::TetFace> exposed = slice2mesh::exposed_faces(sets, k);
    CHECK(filmed == std::set<slice2mesh::TetFace>(exposed.begin(), exposed.end()));
  }
  slice2mesh::InpStepOptions options;
  options.density = 0;
  CHECK_THROWS_AS(text_of([&](std::ostream& out) { slice2mesh::write_inp_steps(out, mesh, "part.inp", options); }),
                  slice2mesh::OptionError);
}

TEST_CASE("TetGen files hold the mesh, counted from 0, and come in pairs") {
  const Mesh mesh = sample();
  const slice2mesh_test::TemporaryDirectory directory;
  slice2mesh::write_mesh(directory.file("part.ELE"), mesh);
  Reader nodes(file_text(directory.file("part.node")));
  REQUIRE(nodes.count() == mesh.vertices.size());
  for (const std::size_t expected : {3U, 0U, 0U}) CHECK(nodes.count() == expected);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    REQUIRE(nodes.count() == v);
    for (const double x : mesh.vertices[v]) REQUIRE(nodes.real() == x);
  }
  CHECK(nodes.finished());
  Reader elements(file_text(directory.file("part.ele")));
  REQUIRE(elements.count() == mesh.tets.size());
  CHECK(elements.count() == 4);
  CHECK(elements.count() == 1);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    REQUIRE(elements.count() == t);
    for (const std::int32_t v : mesh.tets[t]) REQUIRE(elements.number<std::int32_t>() == v);
    REQUIRE(elements.number<std::int32_t>() == mesh.tet_slab[t] + 1);
  }
  CHECK(elements.finished());
}

TEST_CASE("the format follows from the extension, whatever its case, and an unknown one names the known ones") {
  const Mesh mesh = sample();
  const slice2mesh_test::TemporaryDirectory directory;
  const std::map<std::string, std::string> beginnings = {{"a.VTU", "<?xml"},           {"a.msh", "$MeshFormat"},
                                                         {"a.mesh", "MeshVersion"},    {"a.inp", "** slice2mesh"},
                                                         {"a.mfem", "MFEM mesh v1.0"}, {"a.node", "228 3 0 0"}};
  for (const auto& entry : beginnings) {
    slice2mesh::check_mesh_path(directory.file(entry.first));
    slice2mesh::write_mesh(directory.file(entry.first), mesh);
    CHECK(file_text(directory.file(entry.first)).rfind(entry.second, 0) == 0);
  }
  for (const char* const name : {"part.xyz", "part", "part.vtu.d/part", ""}) {
    CHECK_THROWS_AS(slice2mesh::check_mesh_path(name), slice2mesh::FileError);
    try {
      slice2mesh::write_mesh(name, mesh);
      FAIL("written: " << name);
    } catch (const slice2mesh::FileError& error) {
      CHECK(error.stage() == slice2mesh::Stage::Write);
      CHECK(std::string(error.what()).find(".vtu, .msh, .mesh") != std::string::npos);
    }
  }
  CHECK_THROWS_AS(slice2mesh::write_mesh(directory.file("none/part.vtu"), mesh), slice2mesh::FileError);
}

TEST_CASE("a mesh that cannot be written leaves the old file alone and no other behind") {
  Mesh mesh = sample();
  const slice2mesh_test::TemporaryDirectory directory;
  const std::vector<std::string> names = {"a.vtu", "a.msh", "a.mesh", "a.inp", "a.mfem", "a.node"};
  for (const std::string& name : names) std::ofstream(directory.file(name)) << "old";
  const auto attempt_all = [&](const Mesh& bad) {
    for (const std::string& name : names) {
      CHECK_THROWS_AS(slice2mesh::write_mesh(directory.file(name), bad), slice2mesh::Error);
      CHECK(file_text(directory.file(name)) == "old");
    }
    std::size_t files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(directory.path())) {
      static_cast<void>(entry);
      ++files;
    }
    CHECK(files == names.size());
  };
  Mesh bad = mesh;
  bad.tets[5][1] = static_cast<std::int32_t>(mesh.vertices.size());
  attempt_all(bad);
  bad = mesh;
  bad.vertices[3][2] = std::numeric_limits<double>::quiet_NaN();
  attempt_all(bad);
  bad = mesh;
  bad.tet_region.pop_back();
  attempt_all(bad);
  bad = mesh;
  bad.tet_slab[0] = -1;
  attempt_all(bad);
}

TEST_CASE("a listener of a writer changes nothing, and one that throws leaves the old file alone and no other behind") {
  struct Stop {};
  const Mesh mesh = sample();
  std::vector<std::string> names = {"a.vtu", "a.msh", "a.mesh", "a.inp", "a.mfem", "a.node", "a.pvd"};
  if (slice2mesh::kHasExodus) names.emplace_back("a.exo");
  for (const std::string& name : names) {
    CAPTURE(name);
    const slice2mesh_test::TemporaryDirectory directory;
    slice2mesh::write_mesh(directory.file(name), mesh);
    const std::string whole = file_text(directory.file(name));
    const auto files = [&] {
      std::set<std::string> found;
      for (const auto& entry : std::filesystem::directory_iterator(directory.path()))
        found.insert(entry.path().filename().string());
      return found;
    };
    const std::set<std::string> before = files();
    std::size_t calls = 0, stop = std::size_t(-1);
    WriteOptions options;
    options.poll = [&] {
      if (calls++ == stop) throw Stop();
    };
    slice2mesh::write_mesh(directory.file(name), mesh, options);
    CHECK(file_text(directory.file(name)) == whole);
    REQUIRE(calls >= 1);
    const std::size_t most = calls;
    Mesh other = mesh;
    other.vertices[0][0] -= 1;
    for (stop = 0; stop < most; ++stop) {
      calls = 0;
      CHECK_THROWS_AS(slice2mesh::write_mesh(directory.file(name), other, options), Stop);
      CHECK(calls == stop + 1);
      CHECK(file_text(directory.file(name)) == whole);
      CHECK(files() == before);
    }
  }
}

TEST_CASE("a writer listens within large blocks and between small ones") {
  std::string data(40'000'000, '.');
  for (std::size_t i = 0; i < data.size(); i += 1001) data[i] = static_cast<char>('a' + i % 26);
  std::size_t calls = 0;
  std::ostringstream out;
  slice2mesh::detail::OutputBuffer buffer(out, [&] { ++calls; });
  buffer.text("head").text(data);
  CHECK(calls >= 3);
  calls = 0;
  for (const char c : std::string_view(data).substr(0, 5'000'000)) buffer.character(c);
  CHECK(calls >= 4);
  buffer.flush();
  CHECK(out.str() == "head" + data + data.substr(0, 5'000'000));
}

TEST_CASE("files do not depend on the global locale, and the same mesh gives the same bytes") {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const Mesh mesh = sample();
  const slice2mesh_test::TemporaryDirectory directory;
  const std::vector<std::string> names = {"a.vtu", "a.msh", "a.mesh", "a.inp", "a.mfem", "a.node"};
  std::map<std::string, std::string> before;
  for (const std::string& name : names) {
    slice2mesh::write_mesh(directory.file(name), mesh);
    before[name] = file_text(directory.file(name));
  }
  const std::locale old = std::locale::global(std::locale(std::locale::classic(), new Comma));
  for (const std::string& name : names) slice2mesh::write_mesh(directory.file(name), mesh);
  std::locale::global(old);
  for (const std::string& name : names) CHECK(file_text(directory.file(name)) == before[name]);
}

TEST_CASE("an empty mesh gives files of every format") {
  const slice2mesh_test::TemporaryDirectory directory;
  for (const char* const name : {"a.vtu", "a.msh", "a.mesh", "a.inp", "a.mfem", "a.node"}) {
    slice2mesh::write_mesh(directory.file(name), Mesh{});
    CHECK(std::filesystem::file_size(directory.file(name)) > 0);
  }
}

TEST_CASE("region names in files are plain and different even if those of the regions are not") {
  Mesh mesh;
  for (const char* const name : {"gear", "GEAR", "a b", "a_b", "", "\"quoted\"\n", "region"})
    mesh.regions.push_back({0, slice2mesh::RegionKind::Part, name});
  mesh.regions.push_back({0, slice2mesh::RegionKind::Part, std::string(500, 'x')});
  const std::vector<std::string> names = slice2mesh::detail::region_names(mesh);
  std::set<std::string> folded;
  for (const std::string& name : names) {
    CHECK(name.size() <= 70);
    CHECK(name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_") ==
          std::string::npos);
    folded.insert(slice2mesh::detail::upper_case(name));
  }
  CHECK(folded.size() == mesh.regions.size());
}
