// SPDX-License-Identifier: MIT
// Files that other programs read: the scripts beside this file say what these find. A script whose program is not
// installed ends with 77, and the test says so. Two samples: one of boxes, whose figures are counted, and one from
// slices through the whole pipeline, on a base plate. Both have a hole, an overhang, supports and two part ids.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#ifndef _WIN32
#include <sys/wait.h>
#endif

#include "io/sample_mesh.hpp"
#include "slice2mesh/io/write_mesh.hpp"
#include "slice2mesh/pipeline/slice_to_mesh.hpp"
#include "test_support.hpp"

namespace {

using namespace slice2mesh;

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
  template <class Map>
  void object(const std::string& key, const Map& values) {
    value(key, "");
    const char* separator = "{";
    for (const auto& entry : values) {
      text_ << separator << '"' << entry.first << "\": " << entry.second;
      separator = ", ";
    }
    text_ << (values.empty() ? "{}" : "}");
  }
  [[nodiscard]] std::string text() const { return text_.str() + "}\n"; }

private:
  std::ostringstream text_;
  bool first_ = true;
};

// What is written, and the figures of it that have another source than the mesh.
struct Sample {
  Mesh mesh;
  Plc plc;
  std::vector<double> layer_volumes;          // mm^3
  std::vector<double> region_volumes;         // mm^3
  std::map<std::string, double> layer_areas;  // mm^2, of sets that are easily counted
  double tolerance = 0;                       // relative, of these figures
};

Sample box_sample() {
  const slice2mesh_test::BoxSolid solid = slice2mesh_test::stepped_sample();
  Sample sample;
  sample.mesh = slice2mesh_test::mesh_of(solid);
  sample.plc = slice2mesh_test::plc_of(solid);
  sample.tolerance = 1e-14;
  sample.region_volumes.assign(solid.region_count, 0);
  for (std::size_t s = 0; s < solid.thickness.size(); ++s) {
    sample.layer_volumes.push_back(solid.area(s) * solid.thickness[s]);
    for (std::size_t x = 0; x < solid.nx; ++x)
      for (std::size_t y = 0; y < solid.ny; ++y)
        if (solid.filled(x, y, s))
          sample.region_volumes[static_cast<std::size_t>(solid.at(x, y, s))] +=
              solid.dx * solid.dy * solid.thickness[s];
  }
  sample.layer_areas = {{"bottom", solid.area(0)}, {"top", solid.area(3)}};
  return sample;
}

// Ten layers of 0.5 mm: a bracket of 8 x 6 mm with a hole of 24 corners; its upper four layers reach 4 mm further, over
// two support lines; a second part of 3 x 3 mm beside it, eight layers high. On a plate of 2 mm, 3 mm wider.
Sample printed_sample() {
  SliceStack stack;
  stack.labels[1] = "bracket";
  stack.labels[4] = "post";
  const auto line_of = [](std::int32_t part, Direction direction, std::vector<Point2> points) {
    Polyline line;
    line.part = part;
    line.direction = direction;
    line.points = std::move(points);
    return line;
  };
  Polyline hole = line_of(1, Direction::Inner, {});
  const double turn = 2 * std::acos(-1.0) / 24;
  for (int i = 0; i < 24; ++i) hole.points.push_back({4 + 1.5 * std::cos(-turn * i), 3 + 1.5 * std::sin(-turn * i)});
  const double hole_area = 24 * 1.5 * 1.5 * std::sin(turn) / 2;
  Sample sample;
  sample.tolerance = 1e-8;  // points are rounded to 2^-36 of the extent, lines to one support radius of 0.2 mm
  sample.region_volumes.assign(4, 0);
  const double plate_area = (15 + 6.0) * (6 + 6.0);
  sample.layer_volumes.assign(2, plate_area);
  sample.region_volumes[3] = plate_area * 2;
  stack.layers.emplace_back();
  for (int i = 0; i < 10; ++i) {
    Layer layer;
    layer.z = 0.5 * (i + 1);
    const double right = i < 6 ? 8 : 12;
    layer.polylines = {line_of(1, Direction::Outer, {{0, 0}, {right, 0}, {right, 6}, {0, 6}}), hole};
    if (i < 8) layer.polylines.push_back(line_of(4, Direction::Outer, {{13, 0}, {15, 0}, {15, 3}, {13, 3}}));
    if (i < 6)
      for (const double y : {1.5, 4.5}) layer.polylines.push_back(line_of(1, Direction::Open, {{9, y}, {11, y}}));
    stack.layers.push_back(layer);
    const std::array<double, 3> areas = {right * 6 - hole_area, i < 8 ? 2 * 3.0 : 0, i < 6 ? 2 * 2.4 * 0.4 : 0};
    sample.layer_volumes.push_back((areas[0] + areas[1] + areas[2]) * 0.5);
    for (std::size_t r = 0; r < 3; ++r) sample.region_volumes[r] += areas[r] * 0.5;
  }
  Options options;
  options.improve.move_contours = false;  // or volumes would be those of the slices up to eps only
  options.supports.radius = Length::mm(0.2);
  options.plate.thickness = Length::mm(2);
  options.plate.margin = Length::mm(3);
  options.plate.slabs = 2;
  options.size.size = Length::mm(1.5);
  options.improve.rounds = 4;
  Result result = slice_to_mesh(stack, options);
  REQUIRE(result.report.certificate.passed());
  sample.mesh = std::move(result.mesh);
  sample.plc = std::move(result.plc);
  const double first = 8 * 6 - hole_area + 6 + 2 * 2.4 * 0.4;
  sample.layer_areas = {{"bottom", plate_area},
                        {"top", 12 * 6 - hole_area},
                        {"plate_interface", first},
                        {"support_interface", 2 * 2.4 * 0.4},
                        {"downskin", 4 * 6 - 2 * 2.4 * 0.4},
                        {"upskin", plate_area - first + 6}};
  return sample;
}

// Area of all facets of a complex, mm^2.
double complex_area(const Plc& plc) {
  slice2mesh::detail::CompensatedSum sum;
  for (const Facet& facet : plc.facets) {
    std::array<std::array<double, 3>, 3> p;
    for (std::size_t i = 0; i < 3; ++i) p[i] = plc.position(static_cast<std::size_t>(facet.vertices[i]));
    std::array<double, 3> u, v;
    for (std::size_t k = 0; k < 3; ++k) u[k] = p[1][k] - p[0][k], v[k] = p[2][k] - p[0][k];
    sum.add(std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 2);
  }
  return sum.value();
}

// Files of a sample, and expected.json: the figures of the mesh, which are compared with those of another source here
// and with those of other programs there.
void write_sample_files(const Sample& sample, const slice2mesh_test::TemporaryDirectory& directory) {
  const Mesh& mesh = sample.mesh;
  WriteOptions options;
  options.time_per_layer = 2.5;
  for (const char* const name :
       {"sample.vtu", "sample.pvd", "sample.msh", "sample.mesh", "sample.inp", "sample.mfem", "sample.ele"})
    write_mesh(directory.file(name), mesh, options);
  if (kHasExodus) write_mesh(directory.file("sample.exo"), mesh, options);
  options.mfem_names = true;
  write_mesh(directory.file("sample_names.mfem"), mesh, options);
  options.mfem_names = false;
  options.interfaces = false;
  write_mesh(directory.file("sample_skin.msh"), mesh, options);
  options.interfaces = true;
  options.quadratic = true;
  for (const char* const name : {"quadratic.vtu", "quadratic.msh", "quadratic.inp"})
    write_mesh(directory.file(name), mesh, options);
  if (kHasExodus) write_mesh(directory.file("quadratic.exo"), mesh, options);
  options.quadratic = false;
  options.binary = true;
  write_mesh(directory.file("sample_binary.msh"), mesh, options);
#ifdef SLICE2MESH_HAS_ZLIB
  options.compress = true;
  write_mesh(directory.file("sample_compressed.vtu"), mesh, options);
#endif
  PlcWriteOptions skin;
  skin.inner_faces = false;
  for (const char* const name : {"skin.ply", "skin.stl", "skin.obj"}) write_plc(directory.file(name), sample.plc, skin);
  for (const char* const name : {"complex.off", "complex.obj", "complex.poly"})
    write_plc(directory.file(name), sample.plc);

  const std::size_t slabs = mesh.slabs.size();
  const std::vector<std::string> regions = slice2mesh::detail::region_names(mesh);
  std::vector<slice2mesh::detail::CompensatedSum> by_layer(slabs);
  std::vector<slice2mesh::detail::CompensatedSum> by_region(regions.size());
  std::map<std::string, slice2mesh::detail::CompensatedSum> by_group;
  std::map<std::string, std::size_t> tets_of_group;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const double volume = tet_volume(mesh, t);
    const auto slab = static_cast<std::size_t>(mesh.tet_slab[t]);
    const auto region = static_cast<std::size_t>(mesh.tet_region[t]);
    const std::string group =
        "layer_" + std::string(slab < 9 ? "000" : "00") + std::to_string(slab + 1) + "_" + regions[region];
    by_layer[slab].add(volume);
    by_region[region].add(volume);
    by_group[group].add(volume);
    ++tets_of_group[group];
  }
  std::vector<double> layer_volumes;
  std::vector<double> region_volumes;
  std::map<std::string, double> group_volumes;
  for (const auto& sum : by_layer) layer_volumes.push_back(sum.value());
  for (const auto& sum : by_region) region_volumes.push_back(sum.value());
  for (const auto& [name, sum] : by_group) group_volumes[name] = sum.value();
  REQUIRE(layer_volumes.size() == sample.layer_volumes.size());
  REQUIRE(region_volumes.size() == sample.region_volumes.size());
  for (std::size_t s = 0; s < slabs; ++s)
    CHECK(layer_volumes[s] == Approx(sample.layer_volumes[s]).epsilon(sample.tolerance));
  for (std::size_t r = 0; r < regions.size(); ++r)
    CHECK(region_volumes[r] == Approx(sample.region_volumes[r]).epsilon(sample.tolerance));

  const BoundarySets sets = boundary_sets(mesh);
  std::map<std::string, double> areas;
  std::map<std::string, std::size_t> triangles;
  std::string surface_names;
  for (std::size_t k = 0; k < kBoundaryKinds; ++k) {
    const std::string name = to_string(static_cast<BoundaryKind>(k));
    if (!sets.sets[k].empty()) {
      areas[name] = area_of(mesh, sets.sets[k]);
      triangles[name] = sets.sets[k].size();
    }
    surface_names += (k > 0 ? ", \"" : "[\"") + name + "\"";
  }
  for (const auto& [name, area] : sample.layer_areas) {
    INFO(name);
    CHECK(areas[name] == Approx(area).epsilon(sample.tolerance));
  }
  REQUIRE(areas.count("support_interface") == 1);
  REQUIRE(areas.count("downskin") == 1);
  REQUIRE(std::set<std::int32_t>{mesh.regions[0].part, mesh.regions[1].part, mesh.regions[2].part}.size() == 2);

  Json json;
  json.value("vertices", mesh.vertices.size());
  json.value("tets", mesh.tets.size());
  json.value("quadratic_nodes", mesh.vertices.size() + quadratic_nodes(mesh).edges.size());
  json.value("time_per_layer", options.time_per_layer);
  json.value("plate_slabs", plate_slabs(mesh));
  json.value("exodus", kHasExodus ? "true" : "false");
  json.value("complex_triangles", sample.plc.facets.size());
  json.value("complex_area", complex_area(sample.plc));
  json.value("skin_triangles", std::count_if(sample.plc.facets.begin(), sample.plc.facets.end(),
                                             [](const Facet& f) { return f.front.empty() || f.back.empty(); }));
  json.list("layer_volumes", layer_volumes);
  json.list("region_volumes", region_volumes);
  json.object("group_volumes", group_volumes);
  json.object("group_tets", tets_of_group);
  json.object("surface_areas", areas);
  json.object("surface_triangles", triangles);
  json.value("surface_names", surface_names + "]");

  // Jobs of 2 and 10 cubes of 1 mm on top of each other, and of the sample itself.
  WriteOptions with_steps;
  with_steps.inp_steps = InpStepOptions{};
  with_steps.inp_steps->base_temperature = 400;
  with_steps.inp_steps->first_increment = 0.5;
  write_mesh(directory.file("print.inp"), mesh, with_steps);
  with_steps.quadratic = true;
  write_mesh(directory.file("print_quadratic.inp"), mesh, with_steps);
  InpStepOptions steps;
  steps.time_per_layer = 10;
  steps.first_increment = 0.01;
  steps.conductivity = 1e4;
  steps.film_coefficient = 1.0 / 150;
  steps.initial_temperature = 1500;
  steps.sink_temperature = 300;
  with_steps.inp_steps = steps;
  for (const std::size_t layers : {std::size_t{2}, std::size_t{10}})
    for (const bool quadratic : {false, true}) {
      slice2mesh_test::BoxSolid tower = slice2mesh_test::single_box();
      tower.thickness.assign(layers, 1);
      const Mesh job = slice2mesh_test::mesh_of(tower);
      with_steps.quadratic = quadratic;
      const std::string name = std::string(layers == 2 ? "two" : "ten") + (quadratic ? "_quadratic" : "_linear");
      write_mesh(directory.file(name + ".inp"), job, with_steps);
      json.value(name + "_nodes", job.vertices.size() + (quadratic ? quadratic_nodes(job).edges.size() : 0));
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
  const std::filesystem::path scripts = std::filesystem::path(__FILE__).parent_path();
  REQUIRE(std::filesystem::is_regular_file(scripts / script));
  // The packages of a distribution belong to its own Python.
  std::string python = "python3";
  if (const char* given = std::getenv("SLICE2MESH_PYTHON"); given != nullptr && *given != '\0')
    python = given;
  else if (std::filesystem::exists("/usr/bin/python3"))
    python = "/usr/bin/python3";
  for (const bool printed : {false, true}) {
    INFO((printed ? "the printed sample" : "the sample of boxes"));
    static const std::array<Sample, 2> samples = {box_sample(), printed_sample()};
    const slice2mesh_test::TemporaryDirectory directory;
    write_sample_files(samples[printed ? 1 : 0], directory);
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
}

}  // namespace

TEST_CASE("VTK reads the VTU, PVD, Exodus, PLY, STL and OBJ files and finds the same figures", "[external]") {
  run_script("check_vtk.py");
}
TEST_CASE("meshio reads the MSH, MEDIT, VTU, INP, Exodus, TetGen, OFF and OBJ files and finds the same figures",
          "[external]") {
  run_script("check_meshio.py");
}
TEST_CASE("Gmsh reads the MSH and MEDIT files, and INP and VTU files through meshio, and finds the same figures",
          "[external]") {
  run_script("check_gmsh.py");
}
TEST_CASE("MFEM reads the files of its format, v1.0 and v1.3, and finds the same figures", "[external]") {
  run_script("check_mfem.py");
}
TEST_CASE("CalculiX solves jobs in which layers come to life", "[external]") {
  run_script("check_calculix.py");
}
TEST_CASE("FreeFEM reads the MEDIT file and integrates the same volumes and areas", "[external]") {
  run_script("check_freefem.py");
}
TEST_CASE("netCDF reads the Exodus file and finds the same blocks and side sets", "[external]") {
  run_script("check_netcdf.py");
}
TEST_CASE("deal.II reads the MSH file and finds the same material and boundary ids", "[external]") {
#ifdef SLICE2MESH_DEAL_II_READER
  REQUIRE(setenv("SLICE2MESH_DEAL_II_READER", SLICE2MESH_DEAL_II_READER, 1) == 0);
#endif
  run_script("check_deal_ii.py");
}
