// SPDX-License-Identifier: MIT
#include "slice2mesh/tet/tetrahedralizer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "plc/chain.hpp"
#include "slice2mesh/quality/certificate.hpp"
#include "slice2mesh/tet/axioms.hpp"
#include "slice2mesh/tet/restore_layers.hpp"
#include "slice2mesh/tet/slab_filler.hpp"
#include "slice2mesh/tet/tetrahedralizer_archetype.hpp"
#include "test_support.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;

namespace {

struct Sample {
  Plc plc;
  Mesh mesh;
};

Sample sample_of(const SliceStack& stack) {
  Sample sample;
  sample.plc = run_chain(stack).plc();
  sample.mesh = SlabFiller{}(sample.plc);
  return sample;
}

/// Two regions, an overhang, a hole.
const Sample& sample() {
  static const Sample made = [] {
    Polyline line;
    line.direction = Direction::Open;
    line.points = {{4, 1.5}, {7, 1.5}};
    return sample_of(stack_of({{rectangle(0, 0, 5, 3), rectangle(1, 1, 2, 2, Direction::Inner), line},
                               {rectangle(0, 0, 5, 3), rectangle(1, 1, 2, 2, Direction::Inner), line},
                               {rectangle(0, 0, 7, 3)}}));
  }();
  return made;
}

const TetrahedralizerTraits kExact{"exact", FacetKeeping::Exactly, true, false};
const TetrahedralizerTraits kSubdivided{"subdivided", FacetKeeping::Subdivided, true, false};
const TetrahedralizerTraits kNothing{"nothing", FacetKeeping::No, false, false};

std::vector<std::string> failed(const AxiomReport& report) {
  std::vector<std::string> names;
  for (const Axiom& axiom : report.axioms)
    if (axiom.status == AxiomStatus::Failed) names.push_back(axiom.name);
  return names;
}
bool fails(const Mesh& mesh, const std::string& name, const TetrahedralizerTraits& traits) {
  const AxiomReport report = check_axioms(mesh, sample().plc, traits);
  INFO(report.text());
  const Axiom* axiom = report.find(name);
  const bool found = axiom != nullptr && axiom->status == AxiomStatus::Failed && !report.passed();
  if (!found) WARN(name << " does not fail:\n" << report.text());
  return found;
}

RawTets raw_of(const Mesh& mesh) {
  RawTets raw;
  raw.vertices = mesh.vertices;
  raw.tets = mesh.tets;
  return raw;
}

void erase_tet(Mesh& mesh, std::size_t t) {
  mesh.tets.erase(mesh.tets.begin() + std::ptrdiff_t(t));
  mesh.tet_slab.erase(mesh.tet_slab.begin() + std::ptrdiff_t(t));
  mesh.tet_region.erase(mesh.tet_region.begin() + std::ptrdiff_t(t));
}
void add_tet(Mesh& mesh, const std::array<std::int32_t, 4>& tet, std::size_t like) {
  mesh.tets.push_back(tet);
  mesh.tet_slab.push_back(mesh.tet_slab[like]);
  mesh.tet_region.push_back(mesh.tet_region[like]);
}

}  // namespace

TEST_CASE("a lambda, a function and the archetype are models with traits that promise nothing") {
  const AnyTetrahedralizer lambda = [](const Plc& plc) { return SlabFiller{}(plc); };
  CHECK(lambda.traits().name == "unnamed");
  CHECK(lambda.traits().facets == FacetKeeping::No);
  CHECK_FALSE(lambda.traits().deterministic);
  CHECK_FALSE(lambda.traits().needs_conforming_plc);
  CHECK(lambda(sample().plc).tets == sample().mesh.tets);
  Mesh (*function)(const Plc&) = [](const Plc& plc) { return SlabFiller{}(plc); };
  CHECK(AnyTetrahedralizer(function)(sample().plc).tets == sample().mesh.tets);
  const AnyTetrahedralizer archetype = TetrahedralizerArchetype(0);
  CHECK(archetype(sample().plc).tets.empty());
  CHECK(archetype.target<TetrahedralizerArchetype>() != nullptr);
  CHECK(archetype.target<SlabFiller>() == nullptr);
}

TEST_CASE("what a lambda does can be said") {
  const AnyTetrahedralizer model = with_traits([](const Plc& plc) { return SlabFiller{}(plc); }, kExact);
  CHECK(model.traits().name == "exact");
  CHECK(model.traits().facets == FacetKeeping::Exactly);
  const AxiomReport report = check_tetrahedralizer(model, sample().plc);
  INFO(report.text());
  CHECK(report.passed());
}

TEST_CASE("a handle listens with what its model listens with, in a copy") {
  int calls = 0;
  const Progress progress = [&calls](Stage, double) { return ++calls > 0; };
  const AnyTetrahedralizer silent = SlabFiller{};
  const AnyTetrahedralizer heard = silent.with_progress(progress);
  (void)silent(sample().plc);
  CHECK(calls == 0);
  (void)heard(sample().plc);
  CHECK(calls > 0);
  const int before = calls;
  // A model that has a listener keeps it; one without the member is as it was.
  int others = 0;
  (void)heard.with_progress([&others](Stage, double) { return ++others > 0; })(sample().plc);
  CHECK(calls > before);
  CHECK(others == 0);
  (void)AnyTetrahedralizer(TetrahedralizerArchetype(0)).with_progress(progress)(sample().plc);
  const AnyTetrahedralizer stopped = silent.with_progress([](Stage, double) { return false; });
  CHECK_THROWS_AS(stopped(sample().plc), Cancelled);
}

TEST_CASE("the slab filler meets the axioms on every generated stack") {
  std::size_t seen = 0;
  for (const NamedStack& named : generated_stacks()) {
    const AxiomReport report = check_tetrahedralizer(SlabFiller{}, run_chain(named.stack).plc());
    INFO(named.name << "\n" << report.text());
    CHECK(report.passed());
    CHECK(report.traits.name == "slab");
    CHECK(report.layers.crossing == 0);
    CHECK(std::all_of(report.axioms.begin(), report.axioms.end(),
                      [](const Axiom& a) { return a.status == AxiomStatus::Passed; }));
    CHECK(report.axioms.size() == 11);
    ++seen;
  }
  CHECK(seen >= 9);
}

TEST_CASE("the slab filler meets the axioms on the small files", "[corpus]") {
  for (const auto& path : small_corpus_files()) {
    const AxiomReport report = check_tetrahedralizer(SlabFiller{}, run_chain(read_cli(path.string())).plc());
    INFO(path << "\n" << report.text());
    CHECK(report.passed());
  }
}

TEST_CASE("layers are restored from tets without labels, in any order and orientation") {
  std::vector<NamedStack> stacks = generated_stacks();
  for (std::uint32_t seed = 1; seed <= 4; ++seed)
    stacks.push_back({"random, seed " + std::to_string(seed), random_stack(seed)});
  std::mt19937 random(3);
  for (const NamedStack& named : stacks) {
    INFO(named.name);
    const Sample good = sample_of(named.stack);
    RawTets raw = raw_of(good.mesh);
    for (auto& tet : raw.tets) std::shuffle(tet.begin(), tet.end(), random);
    raw.vertices.push_back({1e3, 0, 0});  // used by no tet
    const RestoredMesh restored = restore_layers(raw, good.plc);
    CHECK(restored.mesh.tets.size() == good.mesh.tets.size());
    CHECK(restored.mesh.tet_slab == good.mesh.tet_slab);
    CHECK(restored.mesh.tet_region == good.mesh.tet_region);
    CHECK(restored.report.crossing == 0);
    CHECK(restored.report.outside == 0);
    CHECK(std::fabs(restored.report.volume_error) < 1e-12);
    CHECK(restored.report.largest_slab_error < 1e-9);
    const AxiomReport report = check_axioms(restored.mesh, good.plc, kSubdivided);
    INFO(report.text());
    CHECK(report.passed());
    // The same facets, found from the cells alone.
    std::array<std::size_t, 5> wanted{}, given{};
    for (const Facet& facet : good.plc.facets) ++wanted[std::size_t(facet.label)];
    for (const Facet& facet : restored.mesh.facets) ++given[std::size_t(facet.label)];
    CHECK(given == wanted);
  }
}

TEST_CASE("tets outside of the skin are dropped or kept, and counted") {
  const Sample& good = sample();
  RawTets raw = raw_of(good.mesh);
  const auto add = [&raw](double x, double y, double z) {
    const auto v = static_cast<std::int32_t>(raw.vertices.size());
    for (const std::array<double, 3>& d : {std::array<double, 3>{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}})
      raw.vertices.push_back({x + d[0], y + d[1], z + d[2]});
    raw.tets.push_back({v, v + 1, v + 2, v + 3});
  };
  const double z = good.plc.planes.front();
  add(1.4, 1.4, z + 0.1);  // in the hole, where the outer skin winds twice
  add(6, 0.2, z + 0.1);    // under the overhang
  add(-3, 0, z + 0.1);     // beside the part
  add(1, 1, z - 1);        // below it
  const RestoredMesh dropped = restore_layers(raw, good.plc);
  CHECK(dropped.report.outside == 4);
  CHECK(dropped.mesh.tets == good.mesh.tets);
  CHECK(dropped.mesh.vertices.size() == good.mesh.vertices.size());
  CHECK(std::fabs(dropped.report.volume_error) < 1e-12);
  RestoreOptions keep;
  keep.outside = OutsideTets::Keep;
  const RestoredMesh kept = restore_layers(raw, good.plc, keep);
  CHECK(kept.report.outside == 4);
  CHECK(kept.mesh.tets.size() == good.mesh.tets.size() + 4);
  CHECK(kept.report.volume_error > 0);
}

TEST_CASE("the gap between slabs is outside") {
  const Sample good = sample_of(generated_stacks().back().stack);
  REQUIRE(generated_stacks().back().name == "gap");
  RawTets raw = raw_of(good.mesh);
  double low = 0, high = 0;
  for (std::size_t s = 1; s < good.plc.slabs.size(); ++s)
    if (good.plc.slabs[s].z_low > good.plc.slabs[s - 1].z_high) {
      low = good.plc.slabs[s - 1].z_high;
      high = good.plc.slabs[s].z_low;
    }
  REQUIRE(high > low);
  const auto v = static_cast<std::int32_t>(raw.vertices.size());
  for (const double z : {low + 0.4 * (high - low), low + 0.6 * (high - low)})
    for (const double x : {1.0, 1.5}) raw.vertices.push_back({x, 1 + z, z});
  raw.tets.push_back({v, v + 1, v + 2, v + 3});
  CHECK(restore_layers(raw, good.plc).report.outside == 1);
}

TEST_CASE("tets that cross layers are counted, and what their slabs lose is measured") {
  const Sample& good = sample();
  RawTets raw = raw_of(good.mesh);
  // Vertices inside of the interfaces move up a little, as with a mesher that has a tolerance.
  std::vector<char> on_wall(raw.vertices.size(), 0);
  for (const Facet& facet : good.plc.facets)
    if (facet.label != FacetLabel::Interface)
      for (const std::int32_t v : facet.vertices) on_wall[std::size_t(v)] = 1;
  std::size_t moved = 0;
  for (std::size_t v = 0; v < raw.vertices.size(); ++v)
    if (on_wall[v] == 0) {
      raw.vertices[v][2] += 0.02;
      ++moved;
    }
  REQUIRE(moved > 0);
  const RestoredMesh restored = restore_layers(raw, good.plc);
  CHECK(restored.report.crossing > 0);
  CHECK(restored.report.crossing < restored.report.tets);
  CHECK(restored.report.crossing_share ==
        Approx(double(restored.report.crossing) / double(restored.report.tets)).epsilon(1e-12));
  CHECK(std::fabs(restored.report.volume_error) < 1e-12);
  CHECK(restored.report.largest_slab_error > 1e-3);
  CHECK(restored.report.slab_volume[0] > restored.report.exact_slab_volume[0]);
  // Such a mesh is one of a model that promises nothing, and not of one that promises to keep facets.
  const AxiomReport nothing = check_axioms(restored.mesh, good.plc, kNothing);
  INFO(nothing.text());
  CHECK(nothing.passed());
  for (const char* name : {"cell_volumes", "one_slab", "facets"})
    CHECK(nothing.find(name)->status == AxiomStatus::NotPromised);
  const std::vector<std::string> broken = failed(check_axioms(restored.mesh, good.plc, kSubdivided));
  for (const char* name : {"cell_volumes", "one_slab", "facets"})
    CHECK(std::count(broken.begin(), broken.end(), name) == 1);
}

TEST_CASE("coordinates that another program rounded are made exact again") {
  const Sample& good = sample();
  RawTets raw = raw_of(good.mesh);
  const std::uint32_t seed = 17;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  for (auto& p : raw.vertices)
    for (double& c : p) c += 1e-11 * (double(random()) / 4294967296.0 - 0.5);
  CHECK(restore_layers(raw, good.plc).mesh.vertices == good.mesh.vertices);
  RestoreOptions as_is;
  as_is.snap = 0;
  CHECK(restore_layers(raw, good.plc, as_is).mesh.vertices != good.mesh.vertices);
}

TEST_CASE("a sliver that a mesher leaves next to a plane is not made flat") {
  const Sample& good = sample();
  RawTets raw = raw_of(good.mesh);
  // Four vertices of one plane, one of them lifted by less than the snap, and a tet of the mesh that moves with it.
  std::vector<std::int32_t> level;
  for (std::size_t v = 0; v < raw.vertices.size() && level.size() < 4; ++v) {
    if (raw.vertices[v][2] != raw.vertices[0][2]) continue;
    level.push_back(std::int32_t(v));
    if (level.size() < 3) continue;
    const auto at = [&](std::size_t k) { return raw.vertices[std::size_t(level[k])]; };
    const std::array<double, 3> a = at(0), b = at(1), c = at(level.size() - 1);
    if ((b[0] - a[0]) * (c[1] - a[1]) == (b[1] - a[1]) * (c[0] - a[0])) level.pop_back();  // collinear
  }
  REQUIRE(level.size() == 4);
  raw.vertices[std::size_t(level[3])][2] += 1e-12;
  raw.tets.push_back({level[0], level[1], level[2], level[3]});
  const auto flat = [](const RawTets& from, const RestoreOptions& options, const Plc& plc) {
    const Mesh mesh = restore_layers(from, plc, options).mesh;
    std::size_t count = 0;
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      const auto corner = [&](std::size_t k) { return mesh.vertices[std::size_t(mesh.tets[t][k])]; };
      if (detail::exact_volume(corner(0), corner(1), corner(2), corner(3)).sign <= 0) ++count;
    }
    return count;
  };
  RestoreOptions options;
  options.outside = OutsideTets::Keep;
  CHECK(flat(raw, options, good.plc) == 0);
}

TEST_CASE("tets that are not sound are refused with a typed error") {
  const Sample& good = sample();
  RawTets raw = raw_of(good.mesh);
  raw.tets[3][2] = std::int32_t(raw.vertices.size());
  CHECK_THROWS_AS(restore_layers(raw, good.plc), TetrahedralizationError);
  raw = raw_of(good.mesh);
  raw.vertices[5][1] = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(restore_layers(raw, good.plc), TetrahedralizationError);
  raw = raw_of(good.mesh);
  raw.cells.resize(3);
  CHECK_THROWS_AS(restore_layers(raw, good.plc), TetrahedralizationError);
  raw.cells.assign(raw.tets.size(), {0, 99});
  CHECK_THROWS_AS(restore_layers(raw, good.plc), TetrahedralizationError);
  CHECK_THROWS_AS(restore_layers({}, good.plc), TetrahedralizationError);
  RestoreOptions options;
  options.snap = -1;
  CHECK_THROWS_AS(restore_layers(raw_of(good.mesh), good.plc, options), OptionError);
  Plc broken = good.plc;
  broken.vertex_plane.pop_back();
  CHECK_THROWS_AS(restore_layers(raw_of(good.mesh), broken), TetrahedralizationError);
}

TEST_CASE("exact volumes need the outer skin alone") {
  const Plc with = run_chain(generated_stacks()[2].stack).plc(true);
  const Plc without = run_chain(generated_stacks()[2].stack).plc(false);
  REQUIRE_FALSE(without.has_inner_faces);
  const Mesh mesh = SlabFiller{}(with);
  const LayerReport full = measure_layers(mesh, with), skin = measure_layers(mesh, without);
  CHECK(skin.exact_slab_volume == full.exact_slab_volume);
  CHECK(full.exact_volume == Approx(certify(mesh, with).expected_volume).epsilon(1e-14));
  const RestoredMesh restored = restore_layers(raw_of(mesh), without);
  CHECK(restored.mesh.tet_slab == mesh.tet_slab);
  CHECK(check_axioms(restored.mesh, without, kSubdivided).passed());
}

TEST_CASE("each axiom fails for meshes that break it") {
  // Both lists of facets: that of the complex, and that found from the cells.
  const Mesh of_complex = sample().mesh;
  const Mesh of_cells = restore_layers(raw_of(of_complex), sample().plc).mesh;
  const std::uint32_t seed = 23;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  for (const auto& [good, traits] : {std::make_pair(&of_complex, kExact), std::make_pair(&of_cells, kSubdivided)}) {
    INFO(traits.name);
    REQUIRE(failed(check_axioms(*good, sample().plc, traits)).empty());
    for (int i = 0; i < 12; ++i) {
      const std::size_t t = random() % good->tets.size();
      INFO("tet " << t);
      Mesh mesh = *good;
      mesh.tets[t][1] = i % 2 == 0 ? -1 : std::int32_t(mesh.vertices.size());
      CHECK(fails(mesh, "structure", traits));
      mesh = *good;
      mesh.tets[t][1] = mesh.tets[t][3];
      CHECK(fails(mesh, "structure", traits));
      mesh = *good;
      mesh.tet_slab[t] = 3;
      CHECK(fails(mesh, "structure", traits));

      mesh = *good;
      std::swap(mesh.tets[t][0], mesh.tets[t][1]);
      CHECK(fails(mesh, "positive", traits));
      CHECK(fails(mesh, "faces", traits));
      CHECK(fails(mesh, "total_volume", traits));

      mesh = *good;
      add_tet(mesh, {mesh.tets[t][1], mesh.tets[t][2], mesh.tets[t][0], mesh.tets[t][3]}, t);
      CHECK(fails(mesh, "faces", traits));
      CHECK(fails(mesh, "cell_volumes", traits));

      mesh = *good;
      erase_tet(mesh, t);
      CHECK(fails(mesh, "total_volume", traits));
      CHECK(fails(mesh, "cell_volumes", traits));
      CHECK(fails(mesh, "facets", traits));

      mesh = *good;
      mesh.tet_slab[t] = (mesh.tet_slab[t] + 1) % 3;
      CHECK(fails(mesh, "one_slab", traits));
      CHECK(fails(mesh, "cell_labels", traits));
      CHECK(fails(mesh, "cell_volumes", traits));
      CHECK(fails(mesh, "facets", traits));
      CHECK(fails(mesh, "cell_labels", kNothing));  // it lies in a slab, and says another one

      mesh = *good;
      mesh.tet_region[t] = 1 - mesh.tet_region[t];
      CHECK(fails(mesh, "cell_labels", traits));
      CHECK(fails(mesh, "cell_volumes", traits));
      CHECK(fails(mesh, "facets", traits));

      const std::size_t f = random() % good->facets.size();
      INFO("facet " << f);
      mesh = *good;
      mesh.facets.erase(mesh.facets.begin() + std::ptrdiff_t(f));
      CHECK(fails(mesh, "facets", traits));
      mesh = *good;
      mesh.facets.push_back(mesh.facets[f]);
      CHECK(fails(mesh, "facets", traits));
      mesh = *good;
      mesh.facets[f].label = FacetLabel((int(mesh.facets[f].label) + 1) % 5);
      CHECK(fails(mesh, "facets", traits));
      mesh = *good;
      std::swap(mesh.facets[f].vertices[0], mesh.facets[f].vertices[1]);
      CHECK(fails(mesh, "facets", traits));
      mesh = *good;
      mesh.facets[f].back.slab = (mesh.facets[f].back.slab + 1) % 3;
      CHECK(fails(mesh, "facets", traits));
      mesh = *good;
      mesh.facets[f].vertices[0] = -1;
      CHECK(fails(mesh, "structure", traits));
    }
    Mesh mesh = *good;
    mesh.vertices.push_back({1, 1, 0.25});
    CHECK(fails(mesh, "no_orphans", traits));
    mesh = *good;
    mesh.vertices[7][2] = std::numeric_limits<double>::infinity();
    CHECK(fails(mesh, "structure", traits));
    mesh = *good;
    mesh.tet_region.pop_back();
    CHECK(fails(mesh, "structure", traits));
    mesh = *good;
    mesh.slabs[1].z_high += 0.01;
    CHECK(fails(mesh, "structure", traits));
    mesh = *good;
    mesh.regions.pop_back();
    CHECK(fails(mesh, "structure", traits));
    CHECK(fails({}, "structure", traits));
    // A flat tet on a facet of a plane changes no volume.
    mesh = *good;
    const Facet* floor = nullptr;
    for (const Facet& facet : mesh.facets)
      if (facet.label == FacetLabel::Down) floor = &facet;
    REQUIRE(floor != nullptr);
    std::int32_t fourth = kNone;
    for (const Facet& facet : mesh.facets)
      for (const std::int32_t v : facet.vertices)
        if (facet.label == FacetLabel::Down && std::count(floor->vertices.begin(), floor->vertices.end(), v) == 0)
          fourth = v;
    add_tet(mesh, {floor->vertices[0], floor->vertices[1], floor->vertices[2], fourth}, 0);
    CHECK(fails(mesh, "positive", traits));
  }
}

TEST_CASE("a vertex that left a plane or a wall breaks what is promised about facets") {
  const Mesh good = restore_layers(raw_of(sample().mesh), sample().plc).mesh;
  std::size_t tested = 0;
  for (std::size_t v = 0; v < good.vertices.size(); v += 7) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Mesh mesh = good;
      mesh.vertices[v][axis] += 1e-3;
      const AxiomReport report = check_axioms(mesh, sample().plc, kSubdivided);
      INFO("vertex " << v << " axis " << axis << "\n" << report.text());
      // Inside of a plane a vertex may move in the plane: that is another mesh, and a good one.
      if (axis == 2) CHECK_FALSE(report.passed());
      tested += report.passed() ? 0U : 1U;
    }
  }
  CHECK(tested > 20);
}

TEST_CASE("a model that gives another mesh the second time is found out") {
  const auto calls = std::make_shared<int>(0);
  const auto model = [calls](const Plc& plc) {
    Mesh mesh = SlabFiller{}(plc);
    if (++*calls % 2 == 0) std::rotate(mesh.tets[0].begin(), mesh.tets[0].begin() + 1, mesh.tets[0].begin() + 3);
    return mesh;
  };
  const AxiomReport promised = check_tetrahedralizer(with_traits(model, kExact), sample().plc);
  CHECK(failed(promised) == std::vector<std::string>{"same_twice"});
  const AxiomReport not_promised = check_tetrahedralizer(model, sample().plc);
  CHECK(not_promised.passed());
  CHECK(not_promised.find("same_twice")->status == AxiomStatus::NotPromised);
}

TEST_CASE("a model fails with errors of the library, others break an axiom") {
  const auto typed = [](const Plc&) -> Mesh { throw TetrahedralizationError(2, "cannot"); };
  CHECK_THROWS_AS(check_tetrahedralizer(typed, sample().plc), TetrahedralizationError);
  const auto untyped = [](const Plc&) -> Mesh { throw std::runtime_error("cannot"); };
  const AxiomReport report = check_tetrahedralizer(untyped, sample().plc);
  CHECK(failed(report) == std::vector<std::string>{"typed_errors"});
}
