// SPDX-License-Identifier: MIT
// All models that are present, under the axioms. What this build or machine does not have is said.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "exit_codes.hpp"
#include "mesher.hpp"
#include "plc/chain.hpp"
#include "slice2mesh/pipeline/slice_to_mesh.hpp"
#include "slice2mesh/tet/axioms.hpp"
#include "slice2mesh/tet/external_model.hpp"
#include "slice2mesh/tet/slab_filler.hpp"
#include "test_support.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;
using slice2mesh_program::make_mesher;
using slice2mesh_program::MesherChoice;

namespace {

/// The model with that name, or nothing where this build does not have it, which is said.
std::optional<AnyTetrahedralizer> present(const std::string& mesher, const std::string& arguments = "") {
  try {
    MesherChoice choice;
    choice.mesher = mesher;
    choice.arguments = arguments;
    choice.time_limit = 300;
    return make_mesher(choice);
  } catch (const slice2mesh_program::UsageError& error) {
    WARN("not tested: " << error.what());
    return std::nullopt;
  }
}

bool has_program(const std::string& name) {
  try {
    if (run_command("which", "command -v " + name, ".").exit_code == 0) return true;
  } catch (const Error&) {
  }
  WARN("not tested: there is no program " << name);
  return false;
}

AnyTetrahedralizer external(const std::string& command, FacetKeeping facets = FacetKeeping::No) {
  ExternalMesher mesher;
  mesher.command = command;
  mesher.name = command.substr(0, command.find(' '));
  mesher.facets = facets;
  mesher.limits.time = 300;
  return mesher;
}

// Gmsh fills a closed surface when a script says so. It reads the skin as STL, in single precision.
const std::string kGmsh =
    "printf 'Merge \"skin.stl\";\\nSurface Loop(1) = {1};\\nVolume(1) = {1};\\n' > part.geo; : {skin:stl}; gmsh -3 "
    "part.geo ";

std::string names(const AxiomReport& report, AxiomStatus status) {
  std::string text;
  for (const Axiom& axiom : report.axioms)
    if (axiom.status == status) text += axiom.name + " ";
  return text;
}

/// The shared files of these names, or none, which `corpus_files` says.
std::vector<std::filesystem::path> named_files() {
  std::vector<std::filesystem::path> result;
  for (const auto& path : corpus_files())
    for (const char* name : {"T_supported", "pyramid", "torus_coarse", "joint", "nugear_coarse"})
      if (path.filename().string().rfind(name, 0) == 0) result.push_back(path);
  if (shared_data()) REQUIRE(result.size() >= 5);
  return result;
}

/// The complex that a model gets from slices.
Plc complex_of(const SliceStack& stack, std::int32_t lump = 1) {
  Options options;
  options.supports.radius = Length::mm(0.1);
  options.slabs.lump = lump;
  options.improve.rounds = 0;
  return slice_to_mesh(stack, options).plc;
}

/// A model that keeps facets: every axiom holds, and nothing crosses. Once: it is not run again to compare.
void check_keeper(const AnyTetrahedralizer& model, const Plc& plc, bool once = false) {
  const AxiomReport report = once ? check_axioms(model(plc), plc, model.traits()) : check_tetrahedralizer(model, plc);
  INFO(report.text());
  CHECK(report.passed());
  CHECK(names(report, AxiomStatus::NotPromised).empty());
  CHECK(report.layers.crossing == 0);
}

}  // namespace

TEST_CASE("the one call with a model gives what the chain of stages gives") {
  const SliceStack stack = generated_stacks()[1].stack;
  Options options;
  options.improve.rounds = 0;
  const Result by_default = slice_to_mesh(stack, options);
  const Result by_model = slice_to_mesh(stack, options, SlabFiller{});
  CHECK(by_default.report.certificate.passed());
  CHECK(by_default.report.tetrahedralizer == "slab");
  CHECK_FALSE(by_default.report.layers);
  CHECK(detail::same_mesh(by_default.mesh, by_model.mesh));
  CHECK(detail::same_mesh(SlabFiller{}(by_default.plc), by_default.mesh));
  // A lambda promises nothing, so that axioms take the place of the certificate, and layers are reported.
  const Result by_lambda = slice_to_mesh(stack, options, [](const Plc& plc) { return SlabFiller{}(plc); });
  CHECK(detail::same_mesh(by_lambda.mesh, by_default.mesh));
  CHECK(by_lambda.report.certificate.passed());
  CHECK(by_lambda.report.certificate.find("one_slab") != nullptr);
  REQUIRE(by_lambda.report.layers);
  CHECK(by_lambda.report.layers->crossing == 0);
}

TEST_CASE("the one call reports a model that breaks what it promises, and a budget that it exceeds") {
  const SliceStack stack = generated_stacks()[0].stack;
  const auto liar = [](const Plc& plc) {
    Mesh mesh = SlabFiller{}(plc);
    mesh.tets.pop_back();
    mesh.tet_slab.pop_back();
    mesh.tet_region.pop_back();
    return mesh;
  };
  for (const FacetKeeping facets : {FacetKeeping::Exactly, FacetKeeping::Subdivided}) {
    const Result result = slice_to_mesh(stack, {}, with_traits(liar, {"liar", facets, true, false}));
    CHECK_FALSE(result.report.certificate.passed());
  }
  Options options;
  options.budget.max_tets = 5;
  CHECK_THROWS_AS(slice_to_mesh(stack, options, [](const Plc& plc) { return SlabFiller{}(plc); }), BudgetError);
  options = {};
  options.budget.time_limit = 1.5;
  if (has_program("sleep")) CHECK_THROWS_AS(slice_to_mesh(stack, options, external("sleep 100 # {in}")), BudgetError);
}

TEST_CASE("TetGen keeps facets on every generated stack, with and without quality") {
  for (const char* arguments : {"", "pq1.6T1e-13"}) {
    const auto model = present("tetgen", arguments);
    if (!model) return;
    std::size_t seen = 0;
    for (const NamedStack& named : generated_stacks()) {
      INFO(named.name << " " << arguments);
      check_keeper(*model, complex_of(named.stack));
      ++seen;
    }
    CHECK(seen >= 9);
  }
}

TEST_CASE("TetGen keeps facets on the shared files, with and without quality", "[corpus]") {
  for (const char* arguments : {"", "pq1.6T1e-13"}) {
    const auto model = present("tetgen", arguments);
    if (!model) return;
    for (const auto& path : named_files()) {
      INFO(path << " " << arguments);
      check_keeper(*model, complex_of(read_cli(path.string())), true);
    }
  }
}

TEST_CASE("CGAL's constrained Delaunay triangulation keeps facets", "[corpus]") {
  const auto model = present("cdt3");
  if (!model) return;
  for (const NamedStack& named : generated_stacks()) {
    INFO(named.name);
    check_keeper(*model, complex_of(named.stack));
  }
  for (const auto& path : named_files()) {
    INFO(path);
    check_keeper(*model, complex_of(read_cli(path.string())), true);
  }
}

TEST_CASE("Mesh_3 meets the axioms of a model that approximates, and keeps the layers", "[slow]") {
  const auto model = present("mesh3", "exude=no perturb=no");
  if (!model) return;
  std::size_t seen = 0;
  for (const NamedStack& named : generated_stacks()) {
    INFO(named.name);
    const Plc plc = complex_of(named.stack);
    const AxiomReport report = check_axioms((*model)(plc), plc, model->traits());
    INFO(report.text());
    CHECK(report.passed());
    CHECK(report.layers.crossing == 0);
    ++seen;
  }
  CHECK(seen >= 9);
}

TEST_CASE("Mesh_3 meets the axioms on the shared files, in bundles of eight slices", "[corpus][slow]") {
  const auto model = present("mesh3", "exude=no perturb=no");
  if (!model) return;
  for (const auto& path : named_files()) {
    const Plc plc = complex_of(read_cli(path.string()), 8);
    const AxiomReport report = check_axioms((*model)(plc), plc, model->traits());
    INFO(path << "\n" << report.text());
    CHECK(report.passed());
    CHECK(report.layers.crossing == 0);
  }
}

TEST_CASE("Mesh_3 ends at its time limit and says so") {
  MesherChoice choice;
  choice.mesher = "mesh3";
  choice.arguments = "size=0.004";
  choice.time_limit = 0.3;
  if (!present("mesh3")) return;
  CHECK_THROWS_WITH(make_mesher(choice)(complex_of(generated_stacks()[0].stack)),
                    Catch::Matchers::Contains("Mesh_3 did not end within 0.3 s"));
}

TEST_CASE("the program tetgen gives the same as the library", "[external]") {
  if (!has_program("tetgen")) return;
  for (const char* command :
       {"tetgen -p179.99999T1e-13Q {in:poly}", "cp {in:poly} a.poly && tetgen -p179.99999T1e-13Q a.poly"}) {
    const AnyTetrahedralizer model = external(command, FacetKeeping::Subdivided);
    for (const NamedStack& named : generated_stacks()) {
      INFO(named.name);
      const Plc plc = complex_of(named.stack);
      const AxiomReport report = check_tetrahedralizer(model, plc);
      INFO(report.text());
      CHECK(report.passed());
      CHECK(report.layers.crossing == 0);
    }
  }
}

TEST_CASE("the program tetgen meets the axioms on the shared files", "[corpus][external]") {
  if (!has_program("tetgen")) return;
  for (const auto& path : named_files()) {
    INFO(path);
    check_keeper(external("tetgen -p179.99999T1e-13Q {in:poly}", FacetKeeping::Subdivided),
                 complex_of(read_cli(path.string())), true);
  }
}

TEST_CASE("Gmsh fills the skin, loses the layers, and that is measured", "[corpus][external]") {
  if (!has_program("gmsh")) return;
  for (const char* out : {"-o {out}", "-format msh22 -o {out}", "-format msh22 -bin -o {out}", "-o {out:mesh}"}) {
    const AxiomReport report = check_tetrahedralizer(external(kGmsh + out), complex_of(generated_stacks()[1].stack));
    INFO(out << "\n" << report.text());
    CHECK(report.passed());
    CHECK(report.find("same_twice")->status == AxiomStatus::Passed);
    CHECK(report.layers.crossing > 0);
    CHECK(report.layers.largest_slab_error > 1e-3);
    CHECK(std::fabs(report.layers.volume_error) < 1e-6);
  }
  for (const auto& path : named_files()) {
    const Plc plc = complex_of(read_cli(path.string()));
    const AnyTetrahedralizer model = external(kGmsh + "-o {out}");
    const AxiomReport report = check_axioms(model(plc), plc, model.traits());
    INFO(path << "\n" << report.text());
    CHECK(report.passed());
    CHECK(report.layers.crossing_share > 0.1);
  }
}

TEST_CASE("words that name no mesher are refused") {
  for (const auto& [mesher, arguments] : {std::make_pair("", ""),
                                          {"slob", ""},
                                          {"slab", "x"},
                                          {"my_mesher in out", ""},
                                          {"x {in:step}", ""},
                                          {"x {in} {out:vtk}", ""},
                                          {"x {in} {out} {out:mesh}", ""},
                                          {"mesh3", "size"},
                                          {"mesh3", "size=big"},
                                          {"mesh3", "exude=maybe"},
                                          {"mesh3", "color=red"},
                                          {"cdt3", "x"}}) {
    INFO(mesher << " | " << arguments);
    MesherChoice choice;
    choice.mesher = mesher;
    choice.arguments = arguments;
    CHECK_THROWS_AS(make_mesher(choice), slice2mesh_program::UsageError);
  }
}
