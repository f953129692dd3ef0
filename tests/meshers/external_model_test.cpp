// SPDX-License-Identifier: MIT
#include "slice2mesh/tet/external_model.hpp"

#include <array>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "io/sample_mesh.hpp"
#include "slice2mesh/tet/axioms.hpp"
#include "slice2mesh/tet/read_tets.hpp"
#include "test_support.hpp"

using namespace slice2mesh;
using slice2mesh_test::TemporaryDirectory;

namespace {

/// The stepped sample as one region: its complex has no inner walls.
slice2mesh_test::BoxSolid solid() {
  slice2mesh_test::BoxSolid made = slice2mesh_test::stepped_sample();
  made.region_count = 1;
  made.region = [of = made.region](std::size_t x, std::size_t y, std::size_t s) {
    return of(x, y, s) == kNone ? kNone : 0;
  };
  return made;
}
const Mesh& solid_mesh() {
  static const Mesh mesh = slice2mesh_test::mesh_of(solid());
  return mesh;
}
const Plc& solid_plc() {
  static const Plc plc = [] {
    Plc made = slice2mesh_test::plc_of(solid());
    std::int32_t wall = 0;  // any number: which quad a facet is a part of matters to nobody here
    for (Facet& facet : made.facets)
      if (facet.label == FacetLabel::Wall || facet.label == FacetLabel::InnerWall) facet.wall = wall++;
    return made;
  }();
  return plc;
}

void write_text(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}
std::string read_text(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Volumes of tets, whatever their numbers and order.
double volume_of(const RawTets& raw) {
  double volume = 0;
  for (const auto& tet : raw.tets) volume += std::fabs(detail::sixfold_volume(raw.vertices, tet)) / 6;
  return volume;
}

}  // namespace

TEST_CASE("meshes that we write are read back exactly, in every format that other meshers write") {
  const TemporaryDirectory directory;
  for (const char* name : {"a.msh", "a.mesh", "a.ele", "b.node"}) {
    INFO(name);
    write_mesh(directory.file(name), solid_mesh());
    const RawTets raw = read_tets(directory.file(name));
    CHECK(raw.vertices == solid_mesh().vertices);
    CHECK(raw.tets.size() == solid_mesh().tets.size());
    CHECK(volume_of(raw) == Approx(volume_of({solid_mesh().vertices, solid_mesh().tets, {}})).epsilon(1e-14));
  }
}

TEST_CASE("files of version 2.2 with other elements, tags and numbers are read") {
  const TemporaryDirectory directory;
  const std::string text =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"all\"\n$EndPhysicalNames\n$Nodes\n5\n7 0 0 0\n9 "
      "1 0 "
      "0\n11 0 1 0\n13 0 0 1e0\n100 +1 1 1\n$EndNodes\n$Elements\n3\n1 2 2 0 1 7 9 11\n2 4 2 0 1 7 9 11 13\n3 4 0 9 11 "
      "13 "
      "100\n$EndElements\n";
  write_text(directory.file("a.msh"), text);
  const RawTets raw = read_tets(directory.file("a.msh"));
  CHECK(raw.vertices.size() == 5);
  REQUIRE(raw.tets.size() == 2);
  CHECK(raw.tets[0] == std::array<std::int32_t, 4>{0, 1, 2, 3});
  CHECK(raw.tets[1] == std::array<std::int32_t, 4>{1, 2, 3, 4});

  std::string binary = "$MeshFormat\n2.2 1 8\n";
  const auto put = [&binary](const auto& value) { binary.append(reinterpret_cast<const char*>(&value), sizeof value); };
  put(std::int32_t{1});
  binary += "\n$EndMeshFormat\n$Nodes\n4\n";
  for (std::int32_t i = 0; i < 4; ++i) {
    put(i + 10);
    for (std::int32_t k = 0; k < 3; ++k) put(i == k + 1 ? 1.0 : 0.0);
  }
  binary += "\n$EndNodes\n$Elements\n2\n";
  for (const std::int32_t v : {2, 1, 2, 1, 0, 5, 10, 11, 12}) put(v);  // a triangle with two tags
  for (const std::int32_t v : {4, 1, 0, 2, 10, 11, 12, 13}) put(v);
  binary += "\n$EndElements\n";
  write_text(directory.file("b.msh"), binary);
  const RawTets other = read_tets(directory.file("b.msh"));
  REQUIRE(other.tets.size() == 1);
  CHECK(volume_of(other) == Approx(1.0 / 6));
}

TEST_CASE("files that are not whole or not right are refused") {
  const TemporaryDirectory directory;
  slice2mesh_test::BoxSolid box = slice2mesh_test::single_box();
  const Mesh mesh = slice2mesh_test::mesh_of(box);
  std::size_t refused = 0, read = 0;
  for (const char* name : {"a.msh", "a.mesh", "a.ele", "a.node"}) {
    write_mesh(directory.file(name), mesh);
    const std::string text = read_text(directory.file(name));
    for (std::size_t length = 0; length < text.size(); length += 7) {
      write_text(directory.file(name), text.substr(0, length));
      try {
        (void)read_tets(directory.file(name));
        ++read;  // cut behind the last tet, or within the last digits
      } catch (const FileError& error) {
        CHECK(error.stage() == Stage::Tetrahedralize);
        ++refused;
      }
    }
    write_text(directory.file(name), text);
  }
  CHECK(refused > 50);
  CHECK(read < refused);
  const auto refuses = [&directory](const std::string& name, const std::string& text) {
    write_text(directory.file(name), text);
    CHECK_THROWS_AS(read_tets(directory.file(name)), FileError);
  };
  refuses("x.msh", "$MeshFormat\n4.1 1 8\n");
  refuses("x.msh", "$MeshFormat\n3.0 0 8\n$Nodes\n");
  refuses("x.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n99999999999\n1 0 0 0\n$EndNodes\n");
  refuses("x.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n-1\n");
  refuses("x.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n2\n1 0 0 0\n1 0 0 0\n$EndNodes\n");
  refuses("x.msh",
          "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n$EndNodes\n$Elements\n1\n1 4 0 1 1 1 2\n");
  refuses("x.mesh", "MeshVersionFormatted 2\nDimension 2\n");
  refuses("x.mesh", "MeshVersionFormatted 2\nDimension 3\nVertices 1\n0 0 0 0\nTetrahedra 1\n1 1 1 2 0\nEnd\n");
  refuses("x.mesh", "MeshVersionFormatted 2\nDimension 3\nVertices 1\n0 0 0 0\nEnd\n");
  refuses("x.vtk", "");
  CHECK_THROWS_AS(read_tets(directory.file("absent.msh")), FileError);
}

TEST_CASE("a command gets its files and its places are quoted") {
  const auto filled =
      detail::fill_command("run {in} '{skin:stl}' {in:poly} {in} -o {out:mesh} ${x} {} {dir}", "/a b/c'd");
  CHECK(filled.line ==
        "run '/a b/c'\\''d/in.off' ''/a b/c'\\''d/skin.stl'' '/a b/c'\\''d/in.poly' '/a b/c'\\''d/in.off' -o '/a "
        "b/c'\\''d/out.mesh' ${x} {} '/a b/c'\\''d'");
  CHECK(filled.inputs.size() == 3);
  CHECK(filled.output == "out.mesh");
  for (const char* command : {"run", "run {out}", "run {in:xyz}", "run {in} {out:xyz}", "run {in} {out} {out:ele}"})
    CHECK_THROWS_AS(detail::fill_command(command, "."), OptionError);
}

#if SLICE2MESH_HAS_CHILD_PROCESSES

TEST_CASE("a program that answers with the mesh is a tetrahedralizer") {
  const TemporaryDirectory directory;
  for (const char* extension : {"msh", "mesh", "ele"}) {
    const std::string ready = directory.file(std::string("ready.") + extension);
    write_mesh(ready, solid_mesh());
    const std::string stem = directory.file("ready.");
    ExternalMesher mesher;
    mesher.facets = FacetKeeping::Subdivided;
    mesher.command = std::string(extension) == "ele" ? "test -s {in:off} && cp '" + stem + "node' '" + stem + "ele' ."
                                                     : "test -s {in:off} && cp '" + ready + "' {out:" + extension + "}";
    const AxiomReport report = check_tetrahedralizer(mesher, solid_plc());
    INFO(extension << "\n" << report.text());
    CHECK(report.passed());
    CHECK(report.layers.crossing == 0);
  }
}

TEST_CASE("a program that fails is a typed error with its last words, and leaves no files") {
  const auto run = [](const std::string& command, double limit = 100) {
    ExternalMesher mesher;
    mesher.name = "mesher";
    mesher.command = command;
    mesher.limits.time = limit;
    (void)mesher(solid_plc());
  };
  CHECK_THROWS_WITH(run("echo one; echo two; exit 5 # {in}"), "tetrahedralize: mesher ended with code 5: two");
  CHECK_THROWS_WITH(run(": {in}"), "tetrahedralize: mesher left no mesh");
  CHECK_THROWS_WITH(run(": {in} {out}"), "tetrahedralize: mesher left no mesh");
  CHECK_THROWS_WITH(run(": {in}; rm -r {dir}"), "tetrahedralize: mesher left no mesh");
  CHECK_THROWS_WITH(run(": {in} {out}; rm -r {dir}"), "tetrahedralize: mesher left no mesh");
  CHECK_THROWS_WITH(run(": {in}; touch a.msh b.msh"),
                    "tetrahedralize: mesher left 2 meshes: say with {out} which one it is");
  CHECK_THROWS_AS(run(": {in}; echo nonsense > {out}"), TetrahedralizationError);
  CHECK_THROWS_WITH(run("sleep 1000 # {in}", 0.2), "tetrahedralize: mesher did not end within 0.2 s");
  CHECK_THROWS_AS(run("kill -SEGV $$ # {in}"), TetrahedralizationError);
  CHECK_THROWS_AS(run("no placeholder"), OptionError);
  // The directory of the command is gone afterwards.
  const TemporaryDirectory directory;
  CHECK_THROWS_AS(run("echo {dir} > '" + directory.file("where") + "'; exit 1 # {in}"), TetrahedralizationError);
  std::string where = read_text(directory.file("where"));
  REQUIRE(where.size() > 3);
  where.pop_back();
  CHECK_FALSE(std::filesystem::exists(where));
}

#endif
