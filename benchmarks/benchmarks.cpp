// SPDX-License-Identifier: MIT
// The time and memory of every stage and of the whole pipeline on generated slices (families.hpp), with Google
// Benchmark.
//
//   slice2mesh_benchmarks [--tiny] [options of Google Benchmark]
//   slice2mesh_benchmarks --write FOLDER      the slices as CLI files, for other programs
//
// Benchmarks are called stage/family:value. Counters: tets of the finished mesh, tets_per_s (of the finished mesh,
// whatever the stage does with them), bytes_per_tet: the most memory that the stage has in use at a time, on top of
// what it is given and including what it gives, per tet of the finished mesh.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

#include "families.hpp"
#include "memory_in_use.hpp"
#include "slice2mesh/slice2mesh.hpp"

namespace {

using namespace slice2mesh;
using slice2mesh_benchmarks::Member;

// Takes what is written and forgets it.
class NullBuffer : public std::streambuf {
protected:
  int overflow(int c) override { return traits_type::not_eof(c); }
  std::streamsize xsputn(const char*, std::streamsize count) override { return count; }
};

// What every stage takes and gives, of one member of a family.
struct Chain {
  explicit Chain(const Member& member) : name(member.name), stack(slices_of(member.ring)) {
    std::ostringstream text;
    write_cli(text, stack);
    file = text.str();
    plan = make_slabs(stack, options.slabs, diagnostics);
    regions = build_regions(stack, plan, options.supports, diagnostics);
    sizes = resolve_sizes(options.size, regions);
    harmonize_options.eps = options.eps.in_mm(plan.thickness);
    harmonize_options.contour_size = sizes.contour_size;
    contours = harmonize(regions, harmonize_options, diagnostics);
    planes = triangulate_planes(contours, sizes);
    plc = build_plc(contours, planes.meshes, planes.slab_planes);
    raw = SlabFiller{}(plc);
    improved_planes = planes;
    improved_plc = plc;
    mesh = raw;
    Contours moved = contours;
    improve(regions, moved, improved_planes, improved_plc, mesh, options.improve);
  }

  std::string name;
  Options options;
  HarmonizeOptions harmonize_options;
  Diagnostics diagnostics;
  SliceStack stack;
  std::string file;
  SlabPlan plan;
  LayerRegions regions;
  PlaneSizes sizes;
  Contours contours;
  PlaneStack planes, improved_planes;
  Plc plc, improved_plc;
  Mesh raw, mesh;
};

// The chain that was used last: benchmarks of one member follow each other.
const Chain& chain_of(const Member& member) {
  static std::unique_ptr<Chain> last;
  if (!last || last->name != member.name) {
    last.reset();
    last = std::make_unique<Chain>(member);
  }
  return *last;
}

// A stage gives its result back, so that its memory counts and nothing is optimized away.
struct StageBenchmark {
  const char* name;
  std::function<void(const Chain&)> run;
};

template <class Value>
void keep(Value&& value) {
  benchmark::DoNotOptimize(value);
}

std::vector<StageBenchmark> stages() {
  return {
      {"read", [](const Chain& c) { keep(parse_cli(c.file)); }},
      {"regions",
       [](const Chain& c) {
         Diagnostics diagnostics;
         keep(build_regions(c.stack, c.plan, c.options.supports, diagnostics));
       }},
      {"harmonize",
       [](const Chain& c) {
         Diagnostics diagnostics;
         keep(harmonize(c.regions, c.harmonize_options, diagnostics));
       }},
      {"triangulate", [](const Chain& c) { keep(triangulate_planes(c.contours, c.sizes)); }},
      {"plc", [](const Chain& c) { keep(build_plc(c.contours, c.planes.meshes, c.planes.slab_planes)); }},
      {"fill", [](const Chain& c) { keep(SlabFiller{}(c.plc)); }},
      {"improve",
       [](const Chain& c) {
         // The copies are part of the time: about a hundredth of it.
         Contours contours = c.contours;
         PlaneStack planes = c.planes;
         Plc plc = c.plc;
         Mesh mesh = c.raw;
         keep(improve(c.regions, contours, planes, plc, mesh, c.options.improve));
         keep(mesh);
       }},
      {"certify", [](const Chain& c) { keep(certify(c.mesh, c.improved_plc)); }},
      {"quality", [](const Chain& c) { keep(measure_quality(c.mesh)); }},
      {"write",
       [](const Chain& c) {
         NullBuffer nowhere;
         std::ostream out(&nowhere);
         write_mesh(out, MeshFormat::Vtu, c.mesh);
       }},
      {"whole", [](const Chain& c) { keep(slice_to_mesh(c.stack, c.options)); }},
  };
}

void measure(benchmark::State& state, const Member& member, const StageBenchmark& stage) {
  const Chain& chain = chain_of(member);
  const auto tets = static_cast<double>(chain.mesh.tets.size());
  const std::size_t before = slice2mesh_benchmarks::restart_memory_peak();
  stage.run(chain);  // not timed; also warms caches up
  state.counters["bytes_per_tet"] = static_cast<double>(slice2mesh_benchmarks::memory_peak() - before) / tets;
  for (auto iteration : state) {
    (void)iteration;
    stage.run(chain);
  }
  state.counters["tets"] = tets;
  state.counters["tets_per_s"] = benchmark::Counter(tets, benchmark::Counter::kIsIterationInvariantRate);
}

int write_slices(const std::string& folder) {
  std::filesystem::create_directories(folder);
  int written = 0;
  for (const Member& member : slice2mesh_benchmarks::members(false)) {
    std::string name = member.name;
    std::replace(name.begin(), name.end(), ':', '_');
    write_cli((std::filesystem::path(folder) / (name + ".cli")).string(), slices_of(member.ring));
    ++written;
  }
  std::printf("%d files in %s\n", written, folder.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  std::vector<char*> arguments;
  bool tiny = false;
  for (int i = 0; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--write" && i + 1 < argc) return write_slices(argv[i + 1]);
    if (argument == "--tiny")
      tiny = true;
    else
      arguments.push_back(argv[i]);
  }
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 1;
  for (const Member& member : slice2mesh_benchmarks::members(tiny))
    for (const StageBenchmark& stage : stages())
      benchmark::RegisterBenchmark((std::string(stage.name) + "/" + member.name).c_str(), [member, stage](
                                                                                              benchmark::State& state) {
        measure(state, member, stage);
      })->Unit(benchmark::kMillisecond);
  benchmark::AddCustomContext("slice2mesh", SLICE2MESH_VERSION);
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "slice2mesh_benchmarks: %s\n", error.what());
  return 1;
}
