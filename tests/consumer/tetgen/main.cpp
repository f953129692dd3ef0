// SPDX-License-Identifier: MIT
// TetGen fills a box of two slabs that is made by hand.
#include <slice2mesh/tet/axioms.hpp>
#include <slice2mesh/tet/external_model.hpp>
#include <slice2mesh/tet/tetgen_model.hpp>

#include <array>
#include <cstdint>
#include <iostream>

slice2mesh::AnyTetrahedralizer make_mesher();

namespace {

slice2mesh::Plc box() {
  using slice2mesh::FacetLabel;
  using slice2mesh::Side;
  slice2mesh::Plc plc;
  plc.planes = {0, 1, 2};
  plc.slabs = {{0, 1, 0, 0, 0}, {1, 2, 1, 1, 1}};
  plc.slab_planes = {{0, 1}, {1, 2}};
  plc.regions = {{0, slice2mesh::RegionKind::Part, "box"}};
  for (std::int32_t k = 0; k < 3; ++k)
    for (const std::array<std::int64_t, 2>& p : {std::array<std::int64_t, 2>{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
      plc.vertices.push_back({p[0], p[1]});
      plc.vertex_plane.push_back(k);
    }
  const Side outside, low{0, 0}, high{1, 0};
  const auto quad = [&plc](std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d, FacetLabel label,
                           const Side& front, const Side& back, std::int32_t wall) {
    plc.facets.push_back({{a, b, c}, label, front, back, wall});
    plc.facets.push_back({{a, c, d}, label, front, back, wall});
  };
  quad(3, 2, 1, 0, FacetLabel::Down, outside, low, slice2mesh::kNone);
  quad(4, 5, 6, 7, FacetLabel::Interface, high, low, slice2mesh::kNone);
  quad(8, 9, 10, 11, FacetLabel::Up, outside, high, slice2mesh::kNone);
  for (std::int32_t s = 0; s < 2; ++s)
    for (std::int32_t i = 0; i < 4; ++i) {
      const std::int32_t a = 4 * s + i, b = 4 * s + (i + 1) % 4;
      quad(a, b, b + 4, a + 4, FacetLabel::Wall, outside, s == 0 ? low : high, a);
    }
  return plc;
}

}  // namespace

int main() {
  const slice2mesh::AxiomReport report = slice2mesh::check_tetrahedralizer(make_mesher(), box());
  std::cout << report.text() << report.layers.tets << " tets\n";
  return report.passed() && report.layers.tets > 10 && report.layers.exact_volume == 2 ? 0 : 1;
}
