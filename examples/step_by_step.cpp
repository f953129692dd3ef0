// SPDX-License-Identifier: MIT
// The chain of stages that slice_to_mesh runs, each called on its own: what one stage gives is what the next one takes,
// and may be looked at, kept or changed in between.
#include <slice2mesh/slice2mesh.hpp>

#include <iostream>

int main(int argc, char* argv[]) try {
  using namespace slice2mesh;
  if (argc != 2) throw std::runtime_error("usage: step_by_step part.cli");
  Options options;
  options.slabs.lump = 6;
  options.supports.radius = Length::mm(0.1);
  Diagnostics diagnostics;  // what was repaired, by all stages

  const SliceStack stack = read_cli(argv[1], {}, &diagnostics);
  std::cout << "read: " << stack.layers.size() << " layers\n";

  const SlabPlan plan = make_slabs(stack, options.slabs, diagnostics);  // which slices fill which heights
  std::cout << "slabs: " << plan.slabs.size() << " of " << plan.thickness << " mm, z is " << to_string(plan.convention)
            << '\n';

  const LayerRegions regions = build_regions(stack, plan, options.supports, diagnostics);  // part and supports, united
  std::cout << "regions: " << regions.regions.size() << '\n';

  const PlaneSizes sizes = resolve_sizes(options.size, regions);  // lengths in mm
  HarmonizeOptions harmonize_options;
  harmonize_options.eps = options.eps.in_mm(plan.thickness);
  harmonize_options.contour_size = sizes.contour_size;
  Contours contours = harmonize(regions, harmonize_options, diagnostics);  // alike where they nearly were
  std::cout << "harmonize: tolerance " << contours.tolerance << " mm\n";

  PlaneStack planes = triangulate_planes(contours, sizes, options.budget);  // both contours of every interface
  std::cout << "triangulate: " << planes.meshes.size() << " planes\n";

  Plc plc = build_plc(contours, planes.meshes, planes.slab_planes);
  std::cout << "complex: " << plc.facets.size() << " facets, " << (verify_plc(plc).passed() ? "sound" : "NOT sound")
            << '\n';

  Mesh mesh = SlabFiller{}(plc);
  std::cout << "fill: " << mesh.tets.size() << " tets\n";

  improve(regions, contours, planes, plc, mesh, options.improve);  // changes all but the regions together
  const Certificate certificate = certify(mesh, plc);              // does not throw: look at passed()
  const QualityReport quality = measure_quality(mesh);
  std::cout << "improve: " << mesh.tets.size() << " tets, " << (certificate.passed() ? "certified" : "NOT certified")
            << ", median R/3r " << quality.ratio.median << '\n';

  const Result result = slice_to_mesh(stack, options);
  const bool same = result.mesh.vertices == mesh.vertices && result.mesh.tets == mesh.tets;
  std::cout << (same ? "identical to" : "DIFFERENT from") << " the one call\n";
  return same && certificate.passed() ? 0 : 1;
} catch (const slice2mesh::ParseError& error) {  // what the errors know; the special ones come first
  std::cerr << error.what() << " (byte " << error.byte() << " of " << error.file() << ")\n";
  return 2;
} catch (const slice2mesh::GeometryError& error) {
  std::cerr << error.what() << " (layer " << error.layer() << ")\n";
  return 3;
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
