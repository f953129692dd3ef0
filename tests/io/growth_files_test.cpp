// SPDX-License-Identifier: MIT
// Quadratic tets, growing domains, sets of faces per layer, steps, streams, Exodus II.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#ifdef SLICE2MESH_HAS_NETCDF
#include <netcdf.h>
#endif

#include "io/file_readers.hpp"
#include "io/sample_mesh.hpp"
#include "slice2mesh/io/write_mesh.hpp"
#include "test_support.hpp"

namespace {

using slice2mesh::BoundarySets;
using slice2mesh::Mesh;
using slice2mesh::MeshFormat;
using slice2mesh::TetFace;
using slice2mesh::WriteOptions;
using slice2mesh_test::file_text;
using slice2mesh_test::text_of;
using slice2mesh_test::vtu_array;

using Point = std::array<double, 3>;
using EdgeTable = std::array<std::array<std::size_t, 2>, 6>;

// Which corners node 5, 6, ... of a tet lies between, as the formats define it.
constexpr EdgeTable kVtkEdges = {{{{0, 1}}, {{1, 2}}, {{2, 0}}, {{0, 3}}, {{1, 3}}, {{2, 3}}}};
constexpr EdgeTable kAbaqusEdges = kVtkEdges;
constexpr EdgeTable kGmshEdges = {{{{0, 1}}, {{1, 2}}, {{2, 0}}, {{3, 0}}, {{2, 3}}, {{1, 3}}}};

Mesh sample() {
  return slice2mesh_test::mesh_of(slice2mesh_test::stepped_sample());
}

std::string written(MeshFormat format, const Mesh& mesh, const WriteOptions& options = {}) {
  return text_of([&](std::ostream& out) { slice2mesh::write_mesh(out, format, mesh, options); });
}

// The corners are those of the mesh, every other node is in the middle of the edge that the format says.
// `node(i)` is the index of node i of the tet, `position(index)` its place.
template <class Node, class Position>
void check_quadratic_tet(const Mesh& mesh, std::size_t tet, const EdgeTable& edges, Node node, Position position) {
  std::array<Point, 10> p{};
  for (std::size_t i = 0; i < 10; ++i) p[i] = position(node(i));
  for (std::size_t i = 0; i < 4; ++i) REQUIRE(node(i) == static_cast<std::size_t>(mesh.tets[tet][i]));
  for (std::size_t e = 0; e < 6; ++e)
    for (std::size_t k = 0; k < 3; ++k) REQUIRE(p[4 + e][k] == (p[edges[e][0]][k] + p[edges[e][1]][k]) / 2);
}

struct InpFile {
  std::map<std::string, std::vector<std::vector<std::string>>> sections;  // rows of a keyword line

  explicit InpFile(const std::string& text) {
    std::istringstream file(text);
    std::string section;
    for (std::string line; std::getline(file, line);) {
      if (line.rfind("**", 0) == 0) continue;
      if (line[0] == '*') {
        section = line;
        sections[section];
        continue;
      }
      std::vector<std::string> fields;
      std::istringstream fields_of_line(line);
      for (std::string field; std::getline(fields_of_line, field, ',');)
        fields.push_back(field.substr(std::min(field.find_first_not_of(' '), field.size())));
      sections[section].push_back(fields);
    }
  }
  // Faces of a surface: tet and the format's number of the face.
  [[nodiscard]] std::set<std::pair<std::int32_t, std::string>> surface(const std::string& name) const {
    std::set<std::pair<std::int32_t, std::string>> result;
    const auto found = sections.find("*SURFACE, NAME=" + name + ", TYPE=ELEMENT");
    if (found == sections.end()) return result;
    for (const auto& row : found->second) result.insert({std::stoi(row.at(0)) - 1, row.at(1)});
    return result;
  }
};

std::set<std::pair<std::int32_t, std::string>> inp_faces(const std::vector<TetFace>& faces) {
  const std::array<const char*, 4> number = {"S3", "S4", "S2", "S1"};  // by opposite vertex
  std::set<std::pair<std::int32_t, std::string>> result;
  for (const TetFace& f : faces) result.insert({f.tet, number[static_cast<std::size_t>(f.face)]});
  return result;
}

}  // namespace

TEST_CASE("VTU, MSH and INP files of quadratic tets have their nodes in the order of the format") {
  const Mesh mesh = sample();
  const std::size_t edges = slice2mesh::quadratic_nodes(mesh).edges.size();
  const std::size_t node_count = mesh.vertices.size() + edges;
  WriteOptions options;
  options.quadratic = true;

  const std::string vtu = written(MeshFormat::Vtu, mesh, options);
  const auto points = vtu_array<double>(vtu, "Points");
  const auto connectivity = vtu_array<std::int32_t>(vtu, "connectivity");
  REQUIRE(points.size() == 3 * node_count);
  REQUIRE(connectivity.size() == 10 * mesh.tets.size());
  CHECK(vtu_array<std::uint8_t>(vtu, "types") == std::vector<std::uint8_t>(mesh.tets.size(), 24));
  CHECK(vtu_array<std::int32_t>(vtu, "offsets").back() == static_cast<std::int32_t>(10 * mesh.tets.size()));
  CHECK(vtu.find("Name=\"connectivity\" format") != std::string::npos);  // a plain list, no components
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    check_quadratic_tet(
        mesh, t, kVtkEdges, [&](std::size_t i) { return static_cast<std::size_t>(connectivity[10 * t + i]); },
        [&](std::size_t n) {
          return Point{points[3 * n], points[3 * n + 1], points[3 * n + 2]};
        });

  for (const bool binary : {false, true}) {
    options.binary = binary;
    const slice2mesh_test::MshContent msh = slice2mesh_test::read_msh(written(MeshFormat::Msh, mesh, options), binary);
    CHECK(msh.nodes.size() == node_count);
    std::size_t tets = 0;
    std::size_t triangles = 0;
    for (const auto& [entity, elements] : msh.elements)
      for (const std::vector<std::size_t>& element : elements) {
        if (entity[0] == 3) {
          REQUIRE(element.size() == 11);
          ++tets;
          check_quadratic_tet(
              mesh, element[0] - 1, kGmshEdges, [&](std::size_t i) { return element[i + 1] - 1; },
              [&](std::size_t n) { return msh.nodes.at(n + 1); });
          continue;
        }
        REQUIRE(element.size() == 7);
        ++triangles;
        for (std::size_t i = 0; i < 3; ++i)
          for (std::size_t k = 0; k < 3; ++k)
            REQUIRE(msh.nodes.at(element[4 + i])[k] ==
                    (msh.nodes.at(element[1 + i])[k] + msh.nodes.at(element[1 + (i + 1) % 3])[k]) / 2);
      }
    CHECK(tets == mesh.tets.size());
    CHECK(triangles > 100);
  }

  const InpFile inp(written(MeshFormat::Inp, mesh, options));
  const auto& nodes = inp.sections.at("*NODE, NSET=NALL");
  CHECK(nodes.size() == node_count);
  std::size_t tets = 0;
  for (int layer = 1; layer <= 4; ++layer)
    for (const auto& row : inp.sections.at("*ELEMENT, TYPE=C3D10, ELSET=LAYER_000" + std::to_string(layer))) {
      REQUIRE(row.size() == 11);
      ++tets;
      check_quadratic_tet(
          mesh, std::stoul(row[0]) - 1, kAbaqusEdges, [&](std::size_t i) { return std::stoul(row[i + 1]) - 1; },
          [&](std::size_t n) {
            return Point{std::stod(nodes[n][1]), std::stod(nodes[n][2]), std::stod(nodes[n][3])};
          });
    }
  CHECK(tets == mesh.tets.size());
}

TEST_CASE("a PVD file leads to one VTU file per layer, each the print after that layer") {
  Mesh mesh = sample();
  // Not in the order of the slabs.
  std::swap(mesh.tets.front(), mesh.tets.back());
  std::swap(mesh.tet_slab.front(), mesh.tet_slab.back());
  std::swap(mesh.tet_region.front(), mesh.tet_region.back());
  const slice2mesh_test::TemporaryDirectory directory;
  WriteOptions options;
  options.time_per_layer = 2.5;
  slice2mesh::write_mesh(directory.file("print.pvd"), mesh, options);
  const std::string collection = file_text(directory.file("print.pvd"));
  CHECK(collection.find("type=\"Collection\"") != std::string::npos);
  std::size_t at = 0;
  for (std::int32_t k = 0; k < 4; ++k) {
    const std::string name = "print_layers/layer_000" + std::to_string(k + 1) + ".vtu";
    const std::string times[] = {"0", "2.5", "5", "7.5"};
    at = collection.find("timestep=\"" + times[k] + "\" part=\"0\" file=\"" + name + "\"", at);
    REQUIRE(at != std::string::npos);
    const std::string step = file_text(directory.file(name));
    std::vector<std::int32_t> layers;
    for (const std::int32_t s : mesh.tet_slab)
      if (s <= k) layers.push_back(s);
    CHECK(vtu_array<std::int32_t>(step, "layer") == layers);
    const auto times_of_step = vtu_array<double>(step, "activation_time");
    CHECK(*std::max_element(times_of_step.begin(), times_of_step.end()) == 2.5 * k);
  }
  CHECK(collection.find("timestep", at + 10) == std::string::npos);

  // Written again, now with times of the user's own: numbers of tets are those of the whole mesh.
  options.activation = [](std::int32_t, std::size_t tet) { return static_cast<double>(tet); };
  slice2mesh::write_mesh(directory.file("print.pvd"), mesh, options);
  const auto times = vtu_array<double>(file_text(directory.file("print_layers/layer_0003.vtu")), "activation_time");
  const slice2mesh::SubMesh sub = slice2mesh::layers_of(mesh, 0, 2);
  REQUIRE(times.size() == sub.tet_in_whole.size());
  for (std::size_t t = 0; t < times.size(); ++t) REQUIRE(times[t] == sub.tet_in_whole[t]);
  const std::vector<slice2mesh::PvdFrame> frames = slice2mesh::pvd_frames(mesh, "", options);
  REQUIRE(frames.size() == 4);
  const slice2mesh::GrowingDomains domains = slice2mesh::growing_domains(mesh);
  for (std::size_t k = 0; k < 4; ++k) {
    const slice2mesh::TetRange all = domains[k].all;
    CHECK(frames[k].time == *std::max_element(all.begin(), all.end()));
  }
}

TEST_CASE("a PVD file is written whole or not at all, and nothing of anyone else is removed") {
  const Mesh mesh = sample();
  const slice2mesh_test::TemporaryDirectory directory;
  const auto entries = [&] {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(directory.path()))
      names.insert(entry.path().filename().string());
    return names;
  };
  std::filesystem::create_directory(directory.file("a_layers"));
  std::ofstream(directory.file("a_layers/mine.txt")) << "mine";
  CHECK_THROWS_AS(slice2mesh::write_mesh(directory.file("a.pvd"), mesh), slice2mesh::FileError);
  CHECK(entries() == std::set<std::string>{"a_layers", "mine.txt"});
  CHECK(file_text(directory.file("a_layers/mine.txt")) == "mine");
  Mesh bad = mesh;
  bad.tets[5][1] = -1;
  CHECK_THROWS_AS(slice2mesh::write_mesh(directory.file("b.pvd"), bad), slice2mesh::Error);
  WriteOptions options;
  options.activation = [calls = 0](std::int32_t, std::size_t) mutable -> double {
    if (++calls > 1000) throw std::runtime_error("no more");
    return 0;
  };
  CHECK_THROWS_AS(slice2mesh::write_mesh(directory.file("c.pvd"), mesh, options), std::runtime_error);
  CHECK(entries() == std::set<std::string>{"a_layers", "mine.txt"});
  CHECK_THROWS_AS(written(MeshFormat::Pvd, mesh), slice2mesh::OptionError);
}

TEST_CASE("a base plate is part of the first step of a series") {
  const std::vector<slice2mesh::PvdFrame> frames =
      slice2mesh::pvd_frames(slice2mesh_test::mesh_of(slice2mesh_test::plated_sample()), "");
  REQUIRE(frames.size() == 4);
  for (std::size_t k = 0; k < 4; ++k) {
    CHECK(frames[k].slab == static_cast<std::int32_t>(k) + 2);
    CHECK(frames[k].time == static_cast<double>(k));
  }
}

TEST_CASE("a stream gets the same bytes as a file, in every format") {
  const Mesh mesh = sample();
  const slice2mesh_test::TemporaryDirectory directory;
  std::vector<std::pair<std::string, MeshFormat>> formats = {
      {"a.vtu", MeshFormat::Vtu},           {"a.msh", MeshFormat::Msh},   {"a.mesh", MeshFormat::Medit},
      {"a.inp", MeshFormat::Inp},           {"a.mfem", MeshFormat::Mfem}, {"a.node", MeshFormat::TetgenNodes},
      {"a.ele", MeshFormat::TetgenElements}};
  if (slice2mesh::kHasExodus) {
    formats.emplace_back("a.exo", MeshFormat::Exodus);
    formats.emplace_back("b.e", MeshFormat::Exodus);
  }
  for (const auto& [name, format] : formats) {
    CHECK(slice2mesh::check_mesh_path(name) == format);
    slice2mesh::write_mesh(directory.file(name), mesh);
    const std::string text = written(format, mesh);
    CHECK(text.size() > 1000);
    CHECK(file_text(directory.file(name)) == text);
    std::ostringstream full;
    full.setstate(std::ios::badbit);
    slice2mesh::write_mesh(full, format, mesh);
    CHECK(full.str().empty());
  }
  CHECK(slice2mesh::format_of_extension(".VTU") == MeshFormat::Vtu);
  CHECK(slice2mesh::check_mesh_path("a.PVD") == MeshFormat::Pvd);
  CHECK_FALSE(slice2mesh::format_of_extension("vt"));
  if (!slice2mesh::kHasExodus) {
    CHECK_THROWS_AS(slice2mesh::check_mesh_path("a.exo"), slice2mesh::FileError);
    CHECK_THROWS_AS(written(MeshFormat::Exodus, mesh), slice2mesh::Error);
  }
}

TEST_CASE("INP files have the faces that each layer newly exposes and covers, on request") {
  const Mesh mesh = sample();
  const BoundarySets sets = slice2mesh::boundary_sets(mesh);
  WriteOptions options;
  CHECK(InpFile(written(MeshFormat::Inp, mesh, options)).surface("BORN_0001").empty());
  options.layer_faces = true;
  const InpFile inp(written(MeshFormat::Inp, mesh, options));
  for (std::int32_t k = 0; k < 4; ++k) {
    const std::string number = "000" + std::to_string(k + 1);
    CHECK(inp.surface("BORN_" + number) == inp_faces(slice2mesh::born_faces(sets, k)));
    CHECK(inp.surface("COVERED_" + number) == inp_faces(slice2mesh::covered_faces(sets, k)));
    CHECK_FALSE(inp.surface("BORN_" + number).empty());
    CHECK(inp.surface("COVERED_" + number).empty() == (k == 0));
  }
}

TEST_CASE("MSH, MEDIT and MFEM files have every covered face once, with the number of the layer") {
  for (const bool plate : {false, true}) {
    const Mesh mesh =
        slice2mesh_test::mesh_of(plate ? slice2mesh_test::plated_sample() : slice2mesh_test::stepped_sample());
    const BoundarySets sets = slice2mesh::boundary_sets(mesh);
    WriteOptions options;
    options.layer_faces = true;
    const slice2mesh_test::MshContent msh = slice2mesh_test::read_msh(written(MeshFormat::Msh, mesh, options), false);
    std::set<std::array<std::size_t, 3>> seen;
    std::map<int, std::set<std::array<std::size_t, 3>>> by_tag;
    for (const auto& [entity, elements] : msh.elements)
      if (entity[0] == 2)
        for (const std::vector<std::size_t>& element : elements) {
          std::array<std::size_t, 3> corners = {element[1], element[2], element[3]};
          std::sort(corners.begin(), corners.end());
          REQUIRE(seen.insert(corners).second);
          by_tag[entity[1]].insert(corners);
        }
    std::size_t covered = 0;
    for (std::size_t k = 0; k < mesh.slabs.size(); ++k)
      for (const TetFace& f : slice2mesh::covered_faces(sets, static_cast<std::int32_t>(k))) {
        std::array<std::size_t, 3> corners{};
        for (std::size_t i = 0; i < 3; ++i)
          corners[i] = static_cast<std::size_t>(slice2mesh::face_vertices(mesh, f)[i]) + 1;
        std::sort(corners.begin(), corners.end());
        const bool by_layer = by_tag[static_cast<int>(8 + k)].count(corners) > 0;
        REQUIRE(by_layer != (by_tag[6].count(corners) + by_tag[7].count(corners) > 0));
        covered += by_layer ? 1 : 0;
      }
    CHECK(covered > 100);
    CHECK(msh.names.at({2, 9}) == "\"covered_0002\"");
    // The other two have the same triangles under the same numbers.
    std::map<int, std::size_t> counts;
    slice2mesh_test::Reader medit(written(MeshFormat::Medit, mesh, options));
    medit.find("Triangles");
    for (std::size_t n = medit.count(); n > 0; --n) {
      for (int i = 0; i < 3; ++i) medit.count();
      ++counts[medit.number<int>()];
    }
    slice2mesh_test::Reader mfem(written(MeshFormat::Mfem, mesh, options));
    std::map<int, std::size_t> mfem_counts;
    mfem.find("\nboundary");
    for (std::size_t n = mfem.count(); n > 0; --n) {
      ++mfem_counts[mfem.number<int>()];
      for (int i = 0; i < 4; ++i) mfem.count();
    }
    for (const auto& [tag, faces] : by_tag)
      if (!faces.empty()) {
        CHECK(counts[tag] == faces.size());
        CHECK(mfem_counts[tag] == faces.size());
      }
  }
}

TEST_CASE("with steps, an INP file comes with its job; a base plate is alive from the first step on") {
  const Mesh mesh = slice2mesh_test::mesh_of(slice2mesh_test::plated_sample());
  const slice2mesh_test::TemporaryDirectory directory;
  WriteOptions options;
  options.inp_steps = slice2mesh::InpStepOptions{};
  options.inp_steps->sink_temperature = 293;
  options.inp_steps->base_temperature = 400;
  slice2mesh::write_mesh(directory.file("part.inp"), mesh, options);
  const std::string job = file_text(directory.file("part_steps.inp"));
  CHECK(job.find("*INCLUDE, INPUT=part.inp\n") != std::string::npos);
  CHECK(job.find("NALL, 1500\nPLATE_NODES, 293\n") != std::string::npos);
  CHECK(job.find("REMOVE\nLAYER_0004\nLAYER_0005\nLAYER_0006\n") != std::string::npos);
  std::size_t steps = 0;
  for (std::size_t at = job.find("*STEP"); at != std::string::npos; at = job.find("*STEP", at + 1)) ++steps;
  CHECK(steps == 4);
  CHECK(job.find("ADD\nLAYER_0003\n") == std::string::npos);
  CHECK(job.find("ADD\nLAYER_0006\n") != std::string::npos);
  // The nodes of the plate alone: all below its top.
  const InpFile inp(file_text(directory.file("part.inp")));
  std::set<std::size_t> expected;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (mesh.vertices[v][2] < 1.5) expected.insert(v + 1);
  std::set<std::size_t> found;
  const auto run = inp.sections.find("*NSET, NSET=PLATE_NODES, GENERATE");
  if (run != inp.sections.end()) {
    for (std::size_t v = std::stoul(run->second[0][0]); v <= std::stoul(run->second[0][1]); ++v) found.insert(v);
  } else {
    for (const auto& row : inp.sections.at("*NSET, NSET=PLATE_NODES"))
      for (const std::string& field : row) found.insert(std::stoul(field));
  }
  for (const std::size_t v : expected) CHECK(found.count(v) == 1);
  for (const std::size_t v : found) CHECK(mesh.vertices[v - 1][2] <= 1.5);
  options.surfaces = false;
  CHECK_THROWS_AS(slice2mesh::write_mesh(directory.file("other.inp"), mesh, options), slice2mesh::OptionError);
  CHECK_FALSE(std::filesystem::exists(directory.file("other.inp")));
}

#ifdef SLICE2MESH_HAS_NETCDF

namespace {

// What the netCDF library reads.
class Netcdf {
public:
  explicit Netcdf(const std::string& path) { REQUIRE(nc_open(path.c_str(), NC_NOWRITE, &id_) == NC_NOERR); }
  Netcdf(const Netcdf&) = delete;
  Netcdf& operator=(const Netcdf&) = delete;
  ~Netcdf() { nc_close(id_); }
  [[nodiscard]] std::size_t dimension(const std::string& name) const {
    int dimension = 0;
    std::size_t size = 0;
    REQUIRE(nc_inq_dimid(id_, name.c_str(), &dimension) == NC_NOERR);
    REQUIRE(nc_inq_dimlen(id_, dimension, &size) == NC_NOERR);
    return size;
  }
  [[nodiscard]] std::vector<int> integers(const std::string& name, std::size_t size) const {
    std::vector<int> values(size);
    REQUIRE(nc_get_var_int(id_, variable(name), values.data()) == NC_NOERR);
    return values;
  }
  [[nodiscard]] std::vector<double> reals(const std::string& name, std::size_t size) const {
    std::vector<double> values(size);
    REQUIRE(nc_get_var_double(id_, variable(name), values.data()) == NC_NOERR);
    return values;
  }
  [[nodiscard]] std::vector<std::string> names(const std::string& name, std::size_t size) const {
    const std::size_t width = dimension("len_name");
    std::vector<char> text(width * size);
    REQUIRE(nc_get_var_text(id_, variable(name), text.data()) == NC_NOERR);
    std::vector<std::string> result;
    for (std::size_t i = 0; i < size; ++i) result.emplace_back(&text[i * width]);
    return result;
  }

private:
  [[nodiscard]] int variable(const std::string& name) const {
    int result = 0;
    REQUIRE(nc_inq_varid(id_, name.c_str(), &result) == NC_NOERR);
    return result;
  }
  int id_ = 0;
};

}  // namespace

TEST_CASE("an Exodus file has a named block per layer and region and a named side set per surface") {
  const Mesh mesh = slice2mesh_test::mesh_of(slice2mesh_test::plated_sample());
  const BoundarySets sets = slice2mesh::boundary_sets(mesh);
  const slice2mesh_test::TemporaryDirectory directory;
  for (const bool quadratic : {false, true}) {
    WriteOptions options;
    options.quadratic = quadratic;
    options.layer_faces = true;
    options.time_per_layer = 2;
    slice2mesh::write_mesh(directory.file("a.exo"), mesh, options);
    slice2mesh::write_mesh(directory.file("b.exo"), mesh, options);
    CHECK(file_text(directory.file("a.exo")) == file_text(directory.file("b.exo")));
    const Netcdf file(directory.file("a.exo"));
    const std::size_t nodes = file.dimension("num_nodes");
    REQUIRE(file.dimension("num_elem") == mesh.tets.size());
    REQUIRE(nodes >= mesh.vertices.size());
    const std::array<const char*, 3> axes = {"coordx", "coordy", "coordz"};
    std::array<std::vector<double>, 3> coordinates;
    for (std::size_t i = 0; i < 3; ++i) {
      coordinates[i] = file.reals(axes[i], nodes);
      for (std::size_t v = 0; v < mesh.vertices.size(); ++v) REQUIRE(coordinates[i][v] == mesh.vertices[v][i]);
    }
    const std::vector<int> map = file.integers("elem_num_map", mesh.tets.size());
    const std::size_t blocks = file.dimension("num_el_blk");
    REQUIRE(blocks == 11);
    const std::vector<std::string> block_names = file.names("eb_names", blocks);
    std::size_t element = 0;
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::string number = std::to_string(b + 1);
      const std::size_t size = file.dimension("num_el_in_blk" + number);
      const std::size_t per_tet = file.dimension("num_nod_per_el" + number);
      REQUIRE(per_tet == (quadratic ? 10 : 4));
      const std::vector<int> connect = file.integers("connect" + number, size * per_tet);
      const std::vector<double> times = file.reals("vals_elem_var1eb" + number, size);
      for (std::size_t i = 0; i < size; ++i, ++element) {
        const auto t = static_cast<std::size_t>(map[element]) - 1;
        REQUIRE(times[i] == 2.0 * std::max(0, mesh.tet_slab[t] - 2));
        REQUIRE(block_names[b].rfind("layer_000" + std::to_string(mesh.tet_slab[t] + 1), 0) == 0);
        if (quadratic)
          check_quadratic_tet(
              mesh, t, kVtkEdges, [&](std::size_t n) { return static_cast<std::size_t>(connect[10 * i + n]) - 1; },
              [&](std::size_t n) {
                return Point{coordinates[0][n], coordinates[1][n], coordinates[2][n]};
              });
        else
          for (std::size_t n = 0; n < 4; ++n) REQUIRE(connect[4 * i + n] == mesh.tets[t][n] + 1);
      }
    }
    CHECK(element == mesh.tets.size());
    CHECK(block_names[0] == "layer_0001_base_plate");
    // Sides of the format by their corners: 1-2-4, 2-3-4, 1-4-3, 1-3-2.
    const std::array<std::array<std::size_t, 3>, 4> side_corners = {
        {{{0, 1, 3}}, {{1, 2, 3}}, {{0, 3, 2}}, {{0, 2, 1}}}};
    const std::size_t set_count = file.dimension("num_side_sets");
    const std::vector<std::string> set_names = file.names("ss_names", set_count);
    std::map<std::string, std::vector<TetFace>> expected;
    for (std::size_t k = 0; k < slice2mesh::kBoundaryKinds; ++k)
      expected[to_string(static_cast<slice2mesh::BoundaryKind>(k))] = sets.sets[k];
    for (std::int32_t k = 0; k < 6; ++k) {
      const std::string number = "000" + std::to_string(k + 1);
      expected["born_" + number] = slice2mesh::born_faces(sets, k);
      if (k > 0) expected["covered_" + number] = slice2mesh::covered_faces(sets, k);
    }
    CHECK(set_count == expected.size());
    for (std::size_t s = 0; s < set_count; ++s) {
      const std::string number = std::to_string(s + 1);
      const std::vector<TetFace>& faces = expected.at(set_names[s]);
      const std::size_t size = file.dimension("num_side_ss" + number);
      REQUIRE(size == faces.size());
      const std::vector<int> elements = file.integers("elem_ss" + number, size);
      const std::vector<int> sides = file.integers("side_ss" + number, size);
      for (std::size_t i = 0; i < size; ++i) {
        const int tet = map[static_cast<std::size_t>(elements[i]) - 1] - 1;
        REQUIRE(tet == faces[i].tet);
        std::array<std::int32_t, 3> corners{};
        for (std::size_t n = 0; n < 3; ++n)
          corners[n] =
              mesh.tets[static_cast<std::size_t>(tet)][side_corners[static_cast<std::size_t>(sides[i]) - 1][n]];
        std::array<std::int32_t, 3> wanted = slice2mesh::face_vertices(mesh, faces[i]);
        std::sort(corners.begin(), corners.end());
        std::sort(wanted.begin(), wanted.end());
        REQUIRE(corners == wanted);
      }
    }
  }
}

TEST_CASE("an Exodus file has room for more blocks than a print has layers") {
  slice2mesh_test::BoxSolid tower = slice2mesh_test::single_box();
  tower.thickness.assign(3000, 0.03125);
  const slice2mesh_test::TemporaryDirectory directory;
  slice2mesh::write_mesh(directory.file("a.exo"), slice2mesh_test::mesh_of(tower));
  const Netcdf file(directory.file("a.exo"));
  CHECK(file.dimension("num_el_blk") == 3000);
  CHECK(file.names("eb_names", 3000).back() == "layer_3000_bracket");
}

#endif
