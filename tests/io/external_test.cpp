// SPDX-License-Identifier: MIT
// Files that other programs read: the scripts of tests/external say what these find. A script whose program is not
// installed ends with 77, and the test says so.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#ifndef _WIN32
#include <sys/wait.h>
#endif

#include "io/sample_mesh.hpp"
#include "slice2mesh/io/write_mesh.hpp"
#include "slice2mesh/quality/quality.hpp"
#include "test_support.hpp"

namespace {

using slice2mesh::Mesh;

class Json {
public:
  Json() { text_.precision(std::numeric_limits<double>::max_digits10); }
  template <class T>
  void value(const std::string& key, const T& v) {
    text_ << (first_ ? "{" : ",\n") << '"' << key << "\": " << v;
    first_ = false;
  }
  void list(const std::string& key, const std::vector<double>& values) {
    value(key, "[");
    for (std::size_t i = 0; i < values.size(); ++i) text_ << (i > 0 ? ", " : "") << values[i];
    text_ << "]";
  }
  void object(const std::string& key, const std::map<std::string, double>& values) {
    value(key, "");
    const char* separator = "{";
    for (const auto& entry : values) {
      text_ << separator << '"' << entry.first << "\": " << entry.second;
      separator = ", ";
    }
    text_ << "}";
  }
  [[nodiscard]] std::string text() const { return text_.str() + "}\n"; }

private:
  std::ostringstream text_;
  bool first_ = true;
};

slice2mesh_test::BoxSolid tower(std::size_t layers) {
  slice2mesh_test::BoxSolid solid = slice2mesh_test::single_box();
  solid.thickness.assign(layers, 1);
  return solid;
}

void write_sample_files(const slice2mesh_test::TemporaryDirectory& directory) {
  const slice2mesh_test::BoxSolid solid = slice2mesh_test::stepped_sample();
  const Mesh mesh = slice2mesh_test::mesh_of(solid);
  const slice2mesh::Plc plc = slice2mesh_test::plc_of(solid);
  slice2mesh::WriteOptions options;
  options.time_per_layer = 2.5;
  for (const char* const name : {"sample.vtu", "sample.msh", "sample.mesh", "sample.inp", "sample.mfem", "sample.ele"})
    slice2mesh::write_mesh(directory.file(name), mesh, options);
  options.binary = true;
  slice2mesh::write_mesh(directory.file("sample_binary.msh"), mesh, options);
#ifdef SLICE2MESH_HAS_ZLIB
  options.compress = true;
  slice2mesh::write_mesh(directory.file("sample_compressed.vtu"), mesh, options);
#endif
  slice2mesh::PlcWriteOptions skin;
  skin.inner_faces = false;
  for (const char* const name : {"skin.ply", "skin.stl"}) slice2mesh::write_plc(directory.file(name), plc, skin);
  for (const char* const name : {"complex.off", "complex.poly"}) slice2mesh::write_plc(directory.file(name), plc);

  Json json;
  json.value("vertices", mesh.vertices.size());
  json.value("tets", mesh.tets.size());
  json.value("time_per_layer", options.time_per_layer);
  json.value("complex_triangles", plc.facets.size());
  json.value("skin_triangles", std::count_if(plc.facets.begin(), plc.facets.end(), [](const slice2mesh::Facet& f) {
               return f.front.empty() || f.back.empty();
             }));
  std::vector<double> layer_volumes;
  std::vector<double> region_volumes(solid.region_count, 0);
  std::map<std::string, double> group_volumes;
  const std::array<std::string, 3> names = {"bracket", "support_7", "second__part_"};
  for (std::size_t s = 0; s < solid.thickness.size(); ++s) {
    layer_volumes.push_back(solid.area(s) * solid.thickness[s]);
    for (std::size_t x = 0; x < solid.nx; ++x)
      for (std::size_t y = 0; y < solid.ny; ++y) {
        if (!solid.filled(x, y, s)) continue;
        const auto region = static_cast<std::size_t>(solid.at(x, y, s));
        const double volume = solid.dx * solid.dy * solid.thickness[s];
        region_volumes[region] += volume;
        group_volumes["layer_000" + std::to_string(s + 1) + "_" + names[region]] += volume;
      }
  }
  json.list("layer_volumes", layer_volumes);
  json.list("region_volumes", region_volumes);
  json.object("group_volumes", group_volumes);
  const slice2mesh::BoundarySets sets = slice2mesh::boundary_sets(mesh);
  std::map<std::string, double> areas;
  std::string surface_names;
  for (std::size_t k = 0; k < slice2mesh::kBoundaryKinds; ++k) {
    const char* const name = to_string(static_cast<slice2mesh::BoundaryKind>(k));
    if (!sets.sets[k].empty()) areas[name] = slice2mesh::area_of(mesh, sets.sets[k]);
    surface_names += std::string(k > 0 ? ", \"" : "[\"") + name + "\"";
  }
  json.object("surface_areas", areas);
  json.value("surface_names", surface_names + "]");

  // Jobs of 2 and 10 cubes of 1 mm on top of each other.
  slice2mesh::InpStepOptions steps;
  steps.time_per_layer = 10;
  steps.first_increment = 0.01;
  steps.conductivity = 1e4;
  steps.film_coefficient = 1.0 / 150;
  steps.initial_temperature = 1500;
  steps.sink_temperature = 300;
  for (const bool tall : {false, true}) {
    const Mesh job = slice2mesh_test::mesh_of(tower(tall ? 10 : 2));
    const std::string name = tall ? "ten_layers" : "two_layers";
    slice2mesh::write_mesh(directory.file(name + ".inp"), job);
    slice2mesh::write_inp_steps(directory.file(name + "_steps.inp"), job, name + ".inp", steps);
    if (tall) json.value("ten_layers_nodes", job.vertices.size());
  }
  Json calculix;
  calculix.value("time_per_layer", steps.time_per_layer);
  calculix.value("density", steps.density);
  calculix.value("specific_heat", steps.specific_heat);
  calculix.value("film", steps.film_coefficient);
  calculix.value("initial", steps.initial_temperature);
  calculix.value("sink", steps.sink_temperature);
  calculix.list("exposed_area", {6, 10});
  calculix.list("volume", {1, 2});
  json.value("calculix", calculix.text());
  std::ofstream(directory.file("expected.json")) << json.text();
}

void run_script(const std::string& script) {
  const slice2mesh_test::TemporaryDirectory directory;
  write_sample_files(directory);
  const std::filesystem::path scripts = std::filesystem::path(__FILE__).parent_path().parent_path() / "external";
  REQUIRE(std::filesystem::is_regular_file(scripts / script));
  // The packages of a distribution belong to its own Python.
  std::string python = "python3";
  if (const char* given = std::getenv("SLICE2MESH_PYTHON"); given != nullptr && *given != '\0')
    python = given;
  else if (std::filesystem::exists("/usr/bin/python3"))
    python = "/usr/bin/python3";
  const std::string command =
      "\"" + python + "\" -B \"" + (scripts / script).string() + "\" \"" + directory.path().string() + "\"";
  int code = std::system(command.c_str());
#ifndef _WIN32
  REQUIRE(WIFEXITED(code));
  code = WEXITSTATUS(code);
#endif
  if (code == 77) {
    WARN(script << " was skipped: what it needs is not installed");
    return;
  }
  CHECK(code == 0);
}

}  // namespace

TEST_CASE("VTK reads the VTU, PLY and STL files and finds the same figures", "[external]") {
  run_script("check_vtk.py");
}
TEST_CASE("meshio reads the MSH, MEDIT, VTU, INP, TetGen and OFF files and finds the same figures", "[external]") {
  run_script("check_meshio.py");
}
TEST_CASE("Gmsh reads the MSH and MEDIT files and finds the same figures", "[external]") {
  run_script("check_gmsh.py");
}
TEST_CASE("CalculiX solves jobs in which layers come to life", "[external]") {
  run_script("check_calculix.py");
}
