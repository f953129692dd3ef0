// SPDX-License-Identifier: MIT

#include "slice2mesh/tet/tetrahedralizer.hpp"

using namespace slice2mesh;

#include "slice2mesh/tet/slab_filler.hpp"
#include "slice2mesh/tet/tetrahedralizer_archetype.hpp"

Mesh fill(const Plc&);

struct Everything {
  Progress progress;
  Mesh operator()(const Plc&) const { return {}; }
  TetrahedralizerTraits traits() const { return {}; }
};

void check() {
  const auto lambda = [](const auto&) { return Mesh{}; };
  require_tetrahedralizer<std::decay_t<decltype(lambda)>>();
  require_tetrahedralizer<SlabFiller>();
  require_tetrahedralizer<TetrahedralizerArchetype>();
  require_tetrahedralizer<AnyTetrahedralizer>();
  require_tetrahedralizer<Everything>();
  require_tetrahedralizer<Mesh (*)(const Plc&)>();
  static_assert(is_tetrahedralizer_v<SlabFiller> && is_tetrahedralizer_v<TetrahedralizerArchetype>);
  static_assert(!is_tetrahedralizer_v<int> && !is_tetrahedralizer_v<void> && !is_tetrahedralizer_v<const SlabFiller&>);
  // What takes any model takes the archetype.
  const TetrahedralizerArchetype archetype(0);
  (void)traits_of(archetype);
  (void)with_traits(archetype, {});
  const AnyTetrahedralizer any = archetype;
  (void)any.with_progress({}).copy().traits();
  (void)any.target<TetrahedralizerArchetype>();
}
