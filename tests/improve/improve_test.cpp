// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "../plc/chain.hpp"
#include "slice2mesh/harmonize/separation.hpp"
#include "slice2mesh/improve/improve.hpp"
#include "slice2mesh/plc/build_plc.hpp"
#include "slice2mesh/plc/verify_plc.hpp"
#include "slice2mesh/quality/certificate.hpp"
#include "slice2mesh/quality/quality.hpp"
#include "slice2mesh/tet/slab_filler.hpp"
#include "test_support.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;

namespace {

std::vector<NamedStack> generated_and_random_stacks(std::uint32_t random) {
  std::vector<NamedStack> stacks = generated_stacks();
  for (std::uint32_t seed = 1; seed <= random; ++seed)
    stacks.push_back({"random stack, seed " + std::to_string(seed), random_stack(seed)});
  return stacks;
}

struct Filled {
  Chain chain;
  PlaneStack stack;
  Plc plc;
  Mesh mesh;
};

Filled fill(const SliceStack& slices, const ChainOptions& options = {}) {
  Filled filled;
  filled.chain = run_chain(slices, options);
  filled.stack.meshes = filled.chain.planes;
  filled.stack.slab_planes = filled.chain.slab_planes;
  filled.plc = filled.chain.plc();
  filled.mesh = SlabFiller{}(filled.plc);
  return filled;
}

bool improve(Filled& filled, const ImproveOptions& options = {}) {
  return slice2mesh::improve(filled.chain.regions, filled.chain.contours, filled.stack, filled.plc, filled.mesh,
                             options);
}

std::string failures(const Certificate& certificate) {
  std::string text;
  for (const CertificateCheck& check : certificate.checks)
    if (!check.passed) text += check.name + ": " + check.detail + "; ";
  return text;
}

/// How many tets have a dihedral angle below so many degrees.
std::size_t sharper_than(double degrees, const Mesh& mesh) {
  std::size_t count = 0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    TetCorners corners;
    for (std::size_t i = 0; i < 4; ++i) corners[i] = mesh.vertices[std::size_t(mesh.tets[t][i])];
    const std::array<double, 6> angles = dihedral_angles(corners);
    count += *std::min_element(angles.begin(), angles.end()) < degrees;
  }
  return count;
}

/// Facets of a mesh that are no faces of its tets.
std::size_t facets_apart(const Mesh& mesh) {
  std::set<std::array<std::int32_t, 3>> faces;
  for (const auto& tet : mesh.tets)
    for (std::size_t i = 0; i < 4; ++i) {
      std::array<std::int32_t, 3> face{tet[(i + 1) % 4], tet[(i + 2) % 4], tet[(i + 3) % 4]};
      std::sort(face.begin(), face.end());
      faces.insert(face);
    }
  return std::size_t(std::count_if(mesh.facets.begin(), mesh.facets.end(), [&](const Facet& facet) {
    std::array<std::int32_t, 3> face = facet.vertices;
    std::sort(face.begin(), face.end());
    return faces.count(face) == 0;
  }));
}

/// Where contour edges of the slabs end, on both planes of the slab.
std::set<std::tuple<std::int32_t, std::int64_t, std::int64_t>> contour_ends(const PlaneStack& stack) {
  std::set<std::tuple<std::int32_t, std::int64_t, std::int64_t>> ends;
  for (std::size_t k = 0; k < stack.meshes.size(); ++k)
    for (const auto* chains : {&stack.meshes[k].below_chain, &stack.meshes[k].above_chain})
      for (const auto& chain : *chains)
        for (const std::int32_t v : {chain.front(), chain.back()}) {
          const GridPoint& p = stack.meshes[k].vertices[std::size_t(v)];
          ends.emplace(std::int32_t(k), p.x, p.y);
        }
  return ends;
}

/// Pairs of pieces of contours, on all planes, that have more in common than a vertex: by trying all pairs.
std::size_t meeting_pieces(const PlaneStack& stack) {
  std::size_t count = 0;
  for (const PlaneMesh& mesh : stack.meshes) {
    std::set<std::array<std::int32_t, 2>> pieces;
    for (const auto* chains : {&mesh.below_chain, &mesh.above_chain})
      for (const auto& chain : *chains)
        for (std::size_t i = 1; i < chain.size(); ++i)
          pieces.insert({std::min(chain[i - 1], chain[i]), std::max(chain[i - 1], chain[i])});
    const auto at = [&](std::int32_t v) { return mesh.vertices[std::size_t(v)]; };
    for (auto p = pieces.begin(); p != pieces.end(); ++p)
      for (auto q = std::next(p); q != pieces.end(); ++q) {
        std::array<std::int32_t, 2> a = *p, b = *q;
        if (a[0] == b[1] || a[1] == b[0]) std::swap(b[0], b[1]);
        if (a[0] != b[0] && a[1] != b[1]) {
          count += std::size_t(detail::segments_meet(at(a[0]), at(a[1]), at(b[0]), at(b[1])));
          continue;
        }
        if (a[0] != b[0]) {
          std::swap(a[0], a[1]);
          std::swap(b[0], b[1]);
        }
        if (detail::orientation(at(a[0]), at(a[1]), at(b[1])) == 0 && detail::dot(at(a[0]), at(a[1]), at(b[1])) > 0)
          ++count;
      }
  }
  return count;
}

/// Vertices of a plane, in one order.
std::set<std::pair<std::int64_t, std::int64_t>> places(const PlaneMesh& plane) {
  std::set<std::pair<std::int64_t, std::int64_t>> result;
  for (const GridPoint& p : plane.vertices) result.emplace(p.x, p.y);
  return result;
}
/// Edges of a mesh between vertices that stand above each other, by place and planes.
std::set<std::tuple<std::size_t, std::int64_t, std::int64_t>> vertical_edges(const Filled& filled) {
  std::vector<std::pair<std::size_t, GridPoint>> at;  // of the vertices of the complex: plane by plane
  for (std::size_t k = 0; k < filled.stack.meshes.size(); ++k)
    for (const GridPoint& p : filled.stack.meshes[k].vertices) at.emplace_back(k, p);
  REQUIRE(at.size() == filled.mesh.vertices.size());
  std::set<std::tuple<std::size_t, std::int64_t, std::int64_t>> result;
  for (const auto& tet : filled.mesh.tets)
    for (const auto& e : kTetEdgeVertices) {
      const auto &a = at[std::size_t(tet[e[0]])], &b = at[std::size_t(tet[e[1]])];
      if (a.first != b.first && a.second == b.second)
        result.emplace(std::min(a.first, b.first), a.second.x, a.second.y);
    }
  return result;
}

}  // namespace

TEST_CASE("improvement keeps the certificate, the complex and the contours, and makes the elements better") {
  std::vector<NamedStack> stacks = generated_and_random_stacks(times(30));
  ImproveOptions keep;
  keep.move_contours = false;
  std::size_t better = 0;
  for (const NamedStack& named : stacks) {
    INFO(named.name);
    Filled filled = fill(named.stack);
    const QualityReport before = measure_quality(filled.mesh);
    const auto ends = contour_ends(filled.stack);
    REQUIRE(improve(filled, keep));
    const Certificate certificate = certify(filled.mesh, filled.plc);
    INFO(failures(certificate));
    CHECK(certificate.passed());
    CHECK(verify_plc(filled.plc).passed());
    CHECK(contour_ends(filled.stack) == ends);
    const QualityReport after = measure_quality(filled.mesh);
    CHECK(after.ratio.mean <= before.ratio.mean);
    CHECK(after.crossing == 0);
    if (after.ratio.worst < before.ratio.worst) ++better;
  }
  CHECK(better > stacks.size() / 2);
}

TEST_CASE("every facet of a mesh is a face of a tet, before improvement and after it, also on walls between regions") {
  std::vector<NamedStack> stacks = generated_and_random_stacks(times(30));
  for (NamedStack& stack : two_part_stacks()) stacks.push_back(std::move(stack));
  std::size_t walls = 0, inner = 0, turned = 0, turned_inner = 0;
  for (const NamedStack& named : stacks) {
    INFO(named.name);
    Filled filled = fill(named.stack);
    CHECK(facets_apart(filled.mesh) == 0);
    REQUIRE(improve(filled));
    CHECK(facets_apart(filled.mesh) == 0);
    // Those of the complex are the same ones, and they cut every wall once: verify_plc and the certificate say so.
    REQUIRE(filled.mesh.facets.size() == filled.plc.facets.size());
    const Plc usual = build_plc(filled.chain.contours, filled.stack.meshes, filled.stack.slab_planes);
    REQUIRE(usual.facets.size() == filled.plc.facets.size());
    for (std::size_t f = 0; f < usual.facets.size(); ++f) {
      const Facet &own = filled.mesh.facets[f], &other = usual.facets[f];
      CHECK(own.vertices == filled.plc.facets[f].vertices);
      CHECK((own.label == other.label && own.front == other.front && own.back == other.back && own.wall == other.wall));
      if (own.wall == kNone) continue;
      ++walls;
      inner += own.label == FacetLabel::InnerWall;
      turned += own.vertices != other.vertices;
      turned_inner += own.label == FacetLabel::InnerWall && own.vertices != other.vertices;
    }
    CHECK(verify_plc(filled.plc).passed());
    const Certificate certificate = certify(filled.mesh, filled.plc);
    INFO(failures(certificate));
    CHECK(certificate.passed());
    for (const CertificateCheck& check : certificate.checks)
      CHECK(check.detail.find("other diagonals") == std::string::npos);
  }
  CHECK(walls > 10000);
  CHECK(inner > 300);
  CHECK(turned > walls / 50);
  CHECK(turned_inner > 10);
}

TEST_CASE("with keep_columns planes between equal contours stay the same vertex for vertex, unless elements are bad") {
  ImproveOptions keep;
  keep.keep_columns = true;
  std::size_t good = 0, parted = 0, edges = 0;
  for (std::uint32_t seed = 1; seed <= times(16); ++seed) {
    INFO("seed " << seed);
    SliceStack slices = random_stack(seed, 5);
    for (Layer& layer : slices.layers) layer.polylines = slices.layers.front().polylines;
    Filled kept = fill(slices);
    const auto before = vertical_edges(kept);
    const QualityReport filled = measure_quality(kept.mesh);
    const double worst = filled.ratio.worst;
    Filled usual = kept;
    REQUIRE(improve(kept, keep));
    REQUIRE(improve(usual));
    CHECK(certify(kept.mesh, kept.plc).passed());
    const QualityReport quality = measure_quality(kept.mesh);
    CHECK(quality.column_share > 0.95);
    CHECK(quality.ratio.mean < 1.6);
    CHECK(quality.ratio.worst <= std::max(worst, 3.0));
    const auto after = vertical_edges(kept);
    std::size_t lost = 0;
    for (const auto& edge : before) lost += 1 - after.count(edge);
    CHECK(lost <= before.size() / 20);
    edges += before.size();
    parted += measure_quality(usual.mesh).column_share < 0.7;
    // Angles of less than 13.5 degrees are bad too.
    if (worst > 3 || filled.min_dihedral < 14 || filled.max_dihedral > 166) continue;
    ++good;
    CHECK(lost == 0);
    for (std::size_t k = 1; k < kept.stack.meshes.size(); ++k) {
      const bool same = places(kept.stack.meshes[k]) == places(kept.stack.meshes[0]);
      CHECK(same);
    }
  }
  CHECK(good >= times(16) / 2);
  CHECK(parted >= times(16) / 2);
  CHECK(edges > 200 * times(16));
}

TEST_CASE("keep_columns keeps most columns where contours change, and still improves what is bad") {
  std::vector<NamedStack> stacks = generated_and_random_stacks(times(12));
  ImproveOptions keep;
  keep.keep_columns = true;
  double columns = 0, kept_columns = 0, usual_columns = 0;
  for (const NamedStack& named : stacks) {
    INFO(named.name);
    Filled kept = fill(named.stack);
    const QualityReport before = measure_quality(kept.mesh);
    Filled usual = kept;
    REQUIRE(improve(kept, keep));
    REQUIRE(improve(usual));
    const Certificate certificate = certify(kept.mesh, kept.plc);
    INFO(failures(certificate));
    CHECK(certificate.passed());
    CHECK(verify_plc(kept.plc).passed());
    const QualityReport after = measure_quality(kept.mesh), other = measure_quality(usual.mesh);
    CHECK(after.ratio.mean <= before.ratio.mean);
    CHECK(after.ratio.worst <= std::max(8.0, 1.5 * other.ratio.worst));
    columns += before.column_share;
    kept_columns += after.column_share;
    usual_columns += other.column_share;
  }
  INFO("columns before " << columns << ", kept " << kept_columns << ", usual " << usual_columns);
  CHECK(kept_columns > 0.97 * columns);
  CHECK(kept_columns > 1.7 * usual_columns);
}

TEST_CASE("improvement turns diagonals of walls, where there is nothing else to change") {
  // Square columns: every vertex is a corner that stays, and nothing splits an edge.
  for (const double height : {0.1, 0.4, 0.5, 0.6}) {
    const std::vector<std::vector<Polyline>> layers(6, {rectangle(0, 0, 1, 1)});
    ChainOptions options;
    options.size = 20;
    options.contour_size = 20;
    Filled filled = fill(stack_of(layers, height), options);
    const Plc before = filled.plc;
    const double mean = measure_quality(filled.mesh).ratio.mean;
    REQUIRE(filled.mesh.vertices.size() == 28);
    REQUIRE(improve(filled));
    REQUIRE(filled.plc.facets.size() == before.facets.size());
    std::size_t turned = 0;
    for (std::size_t f = 0; f < before.facets.size(); ++f)
      turned += filled.plc.facets[f].wall != kNone && filled.plc.facets[f].vertices != before.facets[f].vertices;
    INFO("height " << height << ", mean before " << mean);
    CHECK(turned > 0);
    CHECK(measure_quality(filled.mesh).ratio.mean < 0.97 * mean);
    CHECK(facets_apart(filled.mesh) == 0);
    CHECK(certify(filled.mesh, filled.plc).passed());
  }
}

TEST_CASE("contours that improvement moves stay within the tolerance, meet nothing, and make the elements better") {
  std::vector<NamedStack> stacks = generated_and_random_stacks(times(40));
  ImproveOptions keep, move;
  keep.move_contours = false;
  std::size_t changed = 0, better = 0;
  for (const NamedStack& named : stacks) {
    INFO(named.name);
    Filled filled = fill(named.stack), fixed = filled;
    const std::vector<Outline> before = filled.chain.contours.outlines;
    REQUIRE(improve(filled, move));
    REQUIRE(improve(fixed, keep));
    const Certificate certificate = certify(filled.mesh, filled.plc);
    INFO(failures(certificate));
    CHECK(certificate.passed());
    CHECK(verify_plc(filled.plc).passed());
    CHECK(meeting_pieces(filled.stack) == 0);
    const Contours& contours = filled.chain.contours;
    bool moved = false;
    for (std::size_t s = 0; s < contours.outlines.size(); ++s) {
      moved = moved || contours.outlines[s].vertices != before[s].vertices;
      const double eps = contours.tolerance / contours.grid.pitch;
      CHECK(detail::deviation(contours.outlines[s], filled.chain.regions.outlines[s], 1e-4 * eps) <= 1.0002 * eps);
      CHECK(contours.deviation[s] <= 1.0002 * contours.tolerance);
      // Walls stand on the contours: both planes of the slab have their vertices.
      for (const std::size_t top : {std::size_t(0), std::size_t(1)}) {
        const PlaneMesh& mesh = filled.stack.meshes[std::size_t(filled.stack.slab_planes[s][top])];
        for (std::size_t e = 0; e < contours.outlines[s].edges.size(); ++e) {
          const Outline::Edge& edge = contours.outlines[s].edges[e];
          const auto& chain = (top != 0 ? mesh.below_chain : mesh.above_chain)[e];
          CHECK(mesh.vertices[std::size_t(chain.front())] == contours.outlines[s].vertices[std::size_t(edge.a)]);
          CHECK(mesh.vertices[std::size_t(chain.back())] == contours.outlines[s].vertices[std::size_t(edge.b)]);
        }
      }
    }
    if (!moved) continue;
    ++changed;
    if (measure_quality(filled.mesh).ratio.mean <= measure_quality(fixed.mesh).ratio.mean) ++better;
  }
  CHECK(changed > stacks.size() / 2);
  CHECK(better > changed * 3 / 4);
}

TEST_CASE("improvement moves round contours, but no corners and straight walls of the slices, and areas stay") {
  std::size_t moved = 0, on_walls = 0, slid = 0, left = 0;
  for (std::uint32_t seed = 1; seed <= times(12); ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    const auto dice = [&](int low, int high) { return low + int(random() % std::uint32_t(high - low + 1)); };
    // A block whose walls stand on those below or 1 mm and more beside them, and a round part that is elsewhere in each
    // layer, so that its contours cross.
    std::vector<std::vector<Polyline>> layers;
    std::vector<std::array<int, 4>> blocks;
    for (int k = 0; k < 4; ++k) {
      const int x = dice(0, 3), y = dice(0, 3);
      blocks.push_back({x, y, x + dice(6, 9), y + dice(6, 9)});
      const auto& [x0, y0, x1, y1] = blocks.back();
      const double radius = 4 + 0.02 * dice(0, 9);  // one after the other: arguments have no order
      const double center = 20 + 0.02 * dice(0, 9);
      layers.push_back({rectangle(x0, y0, x1, y1), star(center, 5, radius, 40)});
    }
    Filled filled = fill(stack_of(layers));
    const std::vector<Outline> before = filled.chain.contours.outlines;
    REQUIRE(improve(filled));
    CHECK(certify(filled.mesh, filled.plc).passed());
    const Contours& contours = filled.chain.contours;
    for (std::size_t s = 0; s < blocks.size(); ++s) {
      const auto& [x0, y0, x1, y1] = blocks[s];
      const double step = 4 * double(kContourStep) * contours.grid.pitch;
      const auto is_near = [&](double x, int a, int b) { return std::min(std::fabs(x - a), std::fabs(x - b)) <= step; };
      for (std::size_t v = 0; v < before[s].vertices.size(); ++v) {
        const GridPoint &from = before[s].vertices[v], &to = contours.outlines[s].vertices[v];
        if (contours.grid.x_mm(to) > 14) {
          moved += std::size_t(!(from == to));
          continue;
        }
        const bool on_x = is_near(contours.grid.x_mm(from), x0, x1), on_y = is_near(contours.grid.y_mm(from), y0, y1);
        if (!on_x && !on_y) continue;  // harmonization has moved it
        ++on_walls;
        slid += std::size_t(!(from == to));
        const bool still =
            (!on_x || is_near(contours.grid.x_mm(to), x0, x1)) && (!on_y || is_near(contours.grid.y_mm(to), y0, y1));
        if (!still) ++left;
      }
      const double area = double(detail::doubled_area(before[s], kNone));
      // A quarter of what contours may gain or lose within eps.
      CHECK(double(detail::doubled_area(contours.outlines[s], kNone)) == Approx(area).epsilon(7.5e-3));
    }
  }
  // Where an element is very bad, they may.
  CAPTURE(moved, on_walls, slid, left);
  CHECK(moved > 100);
  CHECK(on_walls > times(1000));
  CHECK(slid > 100);
  CHECK(left < on_walls / 100);
}

TEST_CASE("what contours gain and lose as they move keeps the volume of the part") {
  // Balls: at the equator contours are less than eps apart, and share their ways for the better or worse of some.
  std::size_t moved = 0;
  for (std::uint32_t seed = 1; seed <= times(6); ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    std::vector<std::vector<Polyline>> layers;
    const double radius = 4 + 0.01 * double(random() % 100), first = 0.25 + 0.01 * double(random() % 25);
    for (double z = first - radius; z < radius - 0.2; z += 0.5)
      layers.push_back({star(0, 0, std::sqrt(radius * radius - z * z), 60)});
    Filled filled = fill(stack_of(layers));
    const auto error = [&](const std::vector<Outline>& outlines) {
      double wanted = 0, there = 0;
      for (std::size_t s = 0; s < outlines.size(); ++s) {
        wanted += double(detail::doubled_area(filled.chain.regions.outlines[s], kNone));
        there += double(detail::doubled_area(outlines[s], kNone));
      }
      return std::fabs(there / wanted - 1);
    };
    const std::vector<Outline> before = filled.chain.contours.outlines;
    REQUIRE(improve(filled));
    const std::vector<Outline>& after = filled.chain.contours.outlines;
    CAPTURE(error(before), error(after));
    CHECK(error(after) <= std::max(error(before), 3e-4) + 1e-9);
    moved += std::size_t(after != before);
  }
  CHECK(2 * moved > times(6));  // so there was something to keep
}

TEST_CASE("a narrow band along a straight wall gets wider where one of its walls is in few slabs") {
  // The foot of a fillet on a wall through many slabs. What is 1.05 and 2.3 eps off gets one contour, 1.7 eps from the
  // wall: over bands below 1.75 eps dihedral angles are below 10 degrees.
  std::vector<std::vector<Polyline>> slices(8, {rectangle(0, 0, 8, 6)});
  const double eps = 0.05;
  for (const double step : {0.27, 1.05, 2.3, 4.7, 7.6}) slices.push_back({rectangle(0, 0, 8 - step * eps, 6)});
  Filled filled = fill(stack_of(slices));
  const std::vector<Outline> before = filled.chain.contours.outlines;
  REQUIRE(improve(filled));
  CHECK(certify(filled.mesh, filled.plc).passed());
  CHECK(measure_quality(filled.mesh).min_dihedral > 11);
  const Contours& contours = filled.chain.contours;
  std::size_t on_wall = 0, bent = 0;
  for (std::size_t s = 0; s < 8; ++s) {
    std::int64_t wall = 0;  // where harmonization left it
    for (const GridPoint& p : before[s].vertices) wall = std::max(wall, p.x);
    for (std::size_t v = 0; v < before[s].vertices.size(); ++v) {
      if (before[s].vertices[v].x != wall) continue;
      ++on_wall;
      bent += contours.outlines[s].vertices[v].x != wall;
    }
  }
  CHECK(on_wall > 8 * 10);
  CHECK(bent == 0);
  for (std::size_t s = 0; s < before.size(); ++s) {
    const double area = double(detail::doubled_area(filled.chain.regions.outlines[s], kNone)),
                 now = double(detail::doubled_area(contours.outlines[s], kNone));
    // A share of eps times the length of the contour.
    CHECK(std::fabs(now - area) * contours.grid.pitch * contours.grid.pitch / 2 <= 0.15 * eps * 28);
  }
}

TEST_CASE("improvement leaves no sliver where vertices are free to move") {
  // A block over a smaller one: interior freedom everywhere, and columns of different lattices in between.
  Filled filled = fill(stack_of({{rectangle(0, 0, 9.3, 8.1)}, {rectangle(0.9, 0.7, 8.2, 7.4)}, {star(4.5, 4, 3, 24)}}));
  REQUIRE(improve(filled));
  const QualityReport report = measure_quality(filled.mesh);
  CHECK(report.ratio.worst < 6);
  CHECK(report.min_dihedral > 8);
  CHECK(report.max_dihedral < 165);
}

TEST_CASE("improvement makes no corners between contours sharp") {
  // Disks that get smaller and drift: contours of neighboring slabs cross, and leave each other slowly.
  std::size_t corners = 0, moved = 0;
  for (const double drift : {0.05, 0.12, 0.2}) {
    INFO("drift " << drift);
    std::vector<std::vector<Polyline>> layers;
    for (int k = 0; k < 6; ++k) layers.push_back({star(4 + k * drift, 4, 3 - 0.03 * k, 64)});
    ChainOptions options;
    options.eps = 0.1;
    options.contour_size = 1;
    Filled filled = fill(stack_of(layers), options);
    const std::vector<Outline> before = filled.chain.contours.outlines;
    const SeparationReport report = measure_separation(filled.chain.contours);
    REQUIRE(improve(filled));
    const SeparationReport after = measure_separation(filled.chain.contours);
    CHECK(after.between.sharp <= report.between.sharp);
    CHECK(after.between.close_vertices.back() <= report.between.close_vertices.back());
    CHECK(after.between.close_vertex_edge.back() <= report.between.close_vertex_edge.back());
    if (after.between.angle.found()) ++corners;
    for (std::size_t s = 0; s < before.size(); ++s)
      if (!(before[s] == filled.chain.contours.outlines[s])) ++moved;
  }
  CHECK(corners == 3);
  CHECK(moved > 6);
}

TEST_CASE("contours move at the worst elements at last, however few rounds there were") {
  // Contours move from the third round on.
  ImproveOptions options;
  options.rounds = 1;
  std::size_t moved = 0;
  double with = 0, without = 0;  // what the worst element of each stack amounts to
  const auto worst = [](const Mesh& mesh) {
    const QualityReport report = measure_quality(mesh);
    return std::max(report.ratio.worst, 0.6 / std::sin(report.min_dihedral / detail::kDegrees));
  };
  for (std::uint32_t seed = 1; seed <= times(12); ++seed) {
    INFO("seed " << seed);
    Filled one = fill(random_stack(seed)), two = one;
    const std::vector<Outline> before = one.chain.contours.outlines;
    options.move_contours = true;
    REQUIRE(improve(one, options));
    options.move_contours = false;
    REQUIRE(improve(two, options));
    CHECK(two.chain.contours.outlines == before);
    const std::string failed = failures(certify(one.mesh, one.plc));
    CHECK(failed == "");
    if (one.chain.contours.outlines == before) continue;
    ++moved;
    with += worst(one.mesh);
    without += worst(two.mesh);
    CHECK(worst(one.mesh) <= worst(two.mesh));
  }
  CHECK(4 * moved > times(12));
  CHECK(with < 0.9 * without);
}

TEST_CASE("places of contours are searched all around what is worst at last") {
  // Spikes that turn or wander from slab to slab: contours of neighboring slabs cross, or lie side by side.
  std::vector<std::vector<Polyline>> turning, wandering;
  for (int k = 0; k < 16; ++k) {
    turning.push_back({star(0, 0, 4, 10, 0.4, 0.03 * k)});
    wandering.push_back({star(0.03 * k, 0, 5 - 0.08 * k, 5, 0.45, 0.01 * k)});
  }
  Filled one = fill(stack_of(turning)), two = fill(stack_of(wandering));
  for (Filled* filled : {&one, &two}) {
    REQUIRE(improve(*filled));
    const Certificate certificate = certify(filled->mesh, filled->plc);
    INFO(failures(certificate));
    CHECK(certificate.passed());
  }
  // With steps in one direction only: 9.54 degrees and 8 elements.
  CHECK(measure_quality(one.mesh).min_dihedral > 10.05);
  CHECK(sharper_than(11, one.mesh) <= 6);
  CHECK(measure_quality(two.mesh).min_dihedral > 8.7);
}

TEST_CASE("improving twice from the same start gives the same mesh") {
  for (const bool move : {false, true}) {
    ImproveOptions options;
    options.move_contours = move;
    Filled one = fill(random_stack(7)), two = fill(random_stack(7));
    improve(one, options);
    improve(two, options);
    CHECK(one.mesh.vertices == two.mesh.vertices);
    CHECK(one.mesh.tets == two.mesh.tets);
    CHECK(one.plc.facets.size() == two.plc.facets.size());
  }
}

TEST_CASE("no rounds, exact mode and meshes with other vertices are left as they are") {
  Filled filled = fill(random_stack(3));
  const auto tets = filled.mesh.tets;
  ImproveOptions none;
  none.rounds = 0;
  CHECK_FALSE(improve(filled, none));
  CHECK(filled.mesh.tets == tets);
  filled.mesh.vertices.push_back({0, 0, 0});
  CHECK_FALSE(improve(filled));
  CHECK(filled.mesh.tets == tets);
  ChainOptions exact;
  exact.eps = 0;
  exact.radius_edge_ratio = 0;
  Filled conforming = fill(random_stack(3), exact);
  CHECK_FALSE(improve(conforming));
}

TEST_CASE("the work of improvement is bounded by a count, and the mesh is valid wherever it ends") {
  for (const double most : {0.0, 1e4, 1e5, 3e5}) {
    Filled filled = fill(random_stack(5));
    ImproveOptions options;
    options.most_work = most;
    REQUIRE(improve(filled, options));
    const Certificate certificate = certify(filled.mesh, filled.plc);
    INFO("most_work " << most << ": " << failures(certificate));
    CHECK(certificate.passed());
  }
}

TEST_CASE("where there is not enough work for all, what can be helped has its turn before columns of long elements") {
  // The same with the size unknown, where what is worse than 3 has its turn, as columns are.
  double with = 0, without = 0;
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    INFO("seed " << seed);
    ChainOptions options;
    options.size = 20;
    options.contour_size = 10;
    std::vector<std::vector<Polyline>> slices;
    std::mt19937 random(seed);
    for (int l = 0; l < 6; ++l) {
      std::vector<Point2> points;
      for (int i = 0; i < 40; ++i) {
        const double angle = 2 * 3.14159265358979 * i / 40,
                     r = 60 + l + std::uniform_real_distribution<double>(0, 1)(random);
        points.push_back({r * std::cos(angle), r * std::sin(angle)});
      }
      slices.push_back({loop(points)});
    }
    for (const bool known : {true, false}) {
      Filled filled = fill(stack_of(slices), options);
      const double thickness = filled.chain.contours.thickness;
      filled.stack.size = known ? options.size * thickness : 0;
      ImproveOptions improvement;
      improvement.most_work = 6 * double(filled.mesh.tets.size());
      REQUIRE(improve(filled, improvement));
      CHECK(certify(filled.mesh, filled.plc).passed());
      const double worst = measure_quality(filled.mesh).ratio.p999;
      UNSCOPED_INFO((known ? "known " : "unknown ") << worst << " of " << filled.mesh.tets.size());
      (known ? with : without) += worst;
    }
  }
  CAPTURE(with, without);
  CHECK(with < 0.9 * without);
}

TEST_CASE("improvement can be cancelled and refuses options without sense") {
  Filled filled = fill(random_stack(2));
  const Progress stop = [](Stage stage, double) { return stage != Stage::Improve; };
  CHECK_THROWS_AS(
      slice2mesh::improve(filled.chain.regions, filled.chain.contours, filled.stack, filled.plc, filled.mesh, {}, stop),
      Cancelled);
  const auto option_of = [&](auto&& change) -> std::string {
    ImproveOptions options;
    change(options);
    try {
      improve(filled, options);
    } catch (const OptionError& error) {
      return error.option();
    }
    return {};
  };
  CHECK(option_of([](ImproveOptions& o) { o.rounds = -1; }) == "improve.rounds");
  CHECK(option_of([](ImproveOptions& o) { o.target = 0.5; }) == "improve.target");
  CHECK(option_of([](ImproveOptions& o) { o.collapse_above = 0; }) == "improve.collapse_above");
  CHECK(option_of([](ImproveOptions& o) { o.most_work = -1; }) == "improve.most_work");
}
