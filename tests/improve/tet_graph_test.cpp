// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "../plc/chain.hpp"
#include "slice2mesh/improve/cavities.hpp"
#include "slice2mesh/improve/flips.hpp"
#include "slice2mesh/improve/star_cost.hpp"
#include "slice2mesh/improve/tet_graph.hpp"
#include "slice2mesh/improve/wall_vertices.hpp"
#include "slice2mesh/quality/tet_figures.hpp"
#include "slice2mesh/tet/slab_filler.hpp"
#include "test_support.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;

namespace {

using detail::Int128;
using detail::Poll;
using detail::TetGraph;

const std::function<void()> kNobody;  // listens

/// What is wrong with neighbors, stars and ratings, each against all tets; empty if nothing.
std::string faults(const TetGraph& graph) {
  std::map<std::array<std::int32_t, 3>, std::vector<std::int32_t>> at_face;
  std::vector<std::vector<std::int32_t>> stars(graph.points().size());
  const auto face_of = [&](std::int32_t t, std::size_t i) {
    const TetGraph::Tet& v = graph[t].v;
    std::array<std::int32_t, 3> face{v[(i + 1) % 4], v[(i + 2) % 4], v[(i + 3) % 4]};
    std::sort(face.begin(), face.end());
    return face;
  };
  for (std::int32_t t = 0; t < std::int32_t(graph.size()); ++t) {
    if (!graph.alive(t)) continue;
    for (std::size_t i = 0; i < 4; ++i) at_face[face_of(t, i)].push_back(t);
    for (const std::int32_t v : graph[t].v) stars[std::size_t(v)].push_back(t);
  }
  for (std::int32_t t = 0; t < std::int32_t(graph.size()); ++t) {
    if (!graph.alive(t)) continue;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::vector<std::int32_t>& both = at_face[face_of(t, i)];
      if (both.size() > 2) return "a face with " + std::to_string(both.size()) + " tets";
      const std::int32_t other = both.size() < 2 ? kNone : both[0] == t ? both[1] : both[0];
      if (graph[t].across[i] != other) return "tet " + std::to_string(t) + " has a wrong neighbor";
    }
    if (graph.badness(t) != graph.rate(graph[t].v)) return "tet " + std::to_string(t) + " has a wrong rating";
    if (!(graph.volume(graph[t].v) > 0)) return "tet " + std::to_string(t) + " is not positive";
  }
  for (std::size_t v = 0; v < stars.size(); ++v) {
    std::vector<std::int32_t> star(graph.star(std::int32_t(v)).begin(), graph.star(std::int32_t(v)).end());
    std::sort(star.begin(), star.end());
    if (star != stars[v]) return "vertex " + std::to_string(v) + " has a wrong star";
  }
  return {};
}

/// Exact volume of each slab, over its height.
std::map<std::int32_t, Int128> volumes(const TetGraph& graph) {
  std::map<std::int32_t, Int128> sums;
  for (std::int32_t t = 0; t < std::int32_t(graph.size()); ++t)
    if (graph.alive(t)) sums[graph[t].slab] += graph.volume(graph[t].v);
  return sums;
}

/// The same by regions of slabs.
std::map<std::pair<std::int32_t, std::int32_t>, Int128> cell_volumes(const TetGraph& graph) {
  std::map<std::pair<std::int32_t, std::int32_t>, Int128> sums;
  for (std::int32_t t = 0; t < std::int32_t(graph.size()); ++t)
    if (graph.alive(t)) sums[{graph[t].slab, graph[t].region}] += graph.volume(graph[t].v);
  return sums;
}

/// Lengths of the walls of every slab, at the bottom and at the top, pitches.
std::map<std::int32_t, double> wall_lengths(const PlaneStack& stack) {
  std::map<std::int32_t, double> sums;
  for (std::size_t s = 0; s < stack.slab_planes.size(); ++s)
    for (const std::size_t top : {std::size_t(0), std::size_t(1)}) {
      const PlaneMesh& mesh = stack.meshes[std::size_t(stack.slab_planes[s][top])];
      for (const auto& chain : top != 0 ? mesh.below_chain : mesh.above_chain)
        for (std::size_t i = 1; i < chain.size(); ++i)
          sums[std::int32_t(s)] +=
              detail::distance(mesh.vertices[std::size_t(chain[i - 1])], mesh.vertices[std::size_t(chain[i])]);
    }
  return sums;
}

double cost(const TetGraph& graph) {
  double sum = 0;
  for (std::int32_t t = 0; t < std::int32_t(graph.size()); ++t)
    if (graph.alive(t)) sum += detail::improvement_cost(graph.badness(t));
  return sum;
}

/// Twice the area of the triangles that tets above and below have in common, by planes.
std::map<std::int32_t, Int128> shared_areas(const TetGraph& graph) {
  std::map<std::int32_t, Int128> sums;
  for (std::int32_t t = 0; t < std::int32_t(graph.size()); ++t) {
    if (!graph.alive(t)) continue;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::int32_t other = graph[t].across[i];
      if (other < t || graph[other].slab == graph[t].slab) continue;
      const TetGraph::Tet& v = graph[t].v;
      const Int128 area =
          detail::cross(graph.point(v[(i + 1) % 4]), graph.point(v[(i + 2) % 4]), graph.point(v[(i + 3) % 4]));
      sums[graph.plane(v[(i + 1) % 4])] += area < 0 ? -area : area;
    }
  }
  return sums;
}

/// Pieces of contour edges that are no edge of a tet in the slab of the contour.
std::size_t lost_edges(const TetGraph& graph, const PlaneStack& stack) {
  std::size_t lost = 0;
  for (std::size_t s = 0; s < stack.slab_planes.size(); ++s)
    for (const std::size_t top : {std::size_t(0), std::size_t(1)}) {
      const auto plane = std::size_t(stack.slab_planes[s][top]);
      const PlaneMesh& mesh = stack.meshes[plane];
      for (const auto& chain : top != 0 ? mesh.below_chain : mesh.above_chain)
        for (std::size_t i = 1; i < chain.size(); ++i) {
          const std::int32_t a = graph.first()[plane] + chain[i - 1], b = graph.first()[plane] + chain[i];
          const auto star = graph.star(a);
          lost += std::size_t(std::none_of(star.begin(), star.end(), [&](std::int32_t t) {
            return std::size_t(graph[t].slab) == s && TetGraph::has(graph[t].v, b);
          }));
        }
    }
  return lost;
}

struct Made {
  PlaneStack stack;
  Mesh mesh;
  double pitch = 0;
};

Made make(const SliceStack& slices) {
  const Chain chain = run_chain(slices);
  Made made;
  made.stack.meshes = chain.planes;
  made.stack.slab_planes = chain.slab_planes;
  made.mesh = SlabFiller{}(chain.plc());
  made.pitch = chain.contours.grid.pitch;
  return made;
}

/// A filled stack with what changes its tets.
struct Bench {
  explicit Bench(const SliceStack& slices) : made(make(slices)) {}
  Made made;
  TetGraph graph{made.stack, made.mesh, made.pitch, Poll(kNobody, 1)};
  detail::WallVertices on_walls{made.stack, graph.first(), graph.points().size(), Poll(kNobody, 1)};
  detail::Flips flipper{graph, on_walls};
  detail::Cavities joiner{graph, on_walls};
};

std::vector<NamedStack> stacks() {
  std::vector<NamedStack> result = generated_stacks();
  for (std::uint32_t seed = 1; seed <= times(12); ++seed)
    result.push_back({"random stack, seed " + std::to_string(seed), random_stack(seed)});
  for (NamedStack& stack : two_part_stacks()) result.push_back(std::move(stack));
  return result;
}

}  // namespace

TEST_CASE(
    "tets know their neighbors, stars and ratings, before and after flips; flips keep volumes and lower the cost") {
  constexpr double kResolved = 1e15;
  std::size_t flips = 0, several_slabs = 0, lower = 0;
  for (const NamedStack& named : stacks()) {
    INFO(named.name);
    Made made = make(named.stack);
    const std::size_t tets = made.mesh.tets.size();
    TetGraph graph(made.stack, made.mesh, made.pitch, Poll(kNobody, 1));
    REQUIRE(graph.size() == tets);
    REQUIRE(tets > 0);
    CHECK(faults(graph).empty());
    const auto before = volumes(graph);
    several_slabs += std::size_t(before.size() > 1);
    const detail::WallVertices on_walls(made.stack, graph.first(), graph.points().size(), Poll(kNobody, 1));
    detail::Flips flipper(graph, on_walls);
    flipper.turn_walls(true);
    const std::map<std::int32_t, double> walls = wall_lengths(made.stack);
    double last = cost(graph);
    std::size_t done = 0;
    for (std::int32_t t = 0; t < std::int32_t(graph.size()); ++t) {
      if (!graph.alive(t) || !flipper.flip(t)) continue;
      ++flips;
      if (++done % 64 != 0) continue;
      const std::string fault = faults(graph);
      INFO(fault);
      REQUIRE(fault.empty());
    }
    const std::string fault = faults(graph);
    INFO(fault);
    CHECK(fault.empty());
    // A wall is bent by the rounding of what splits its edges, by less than a pitch: other diagonals hold more or less.
    const auto after = volumes(graph);
    REQUIRE(after.size() == before.size());
    for (const auto& [slab, volume] : before) CHECK(std::fabs(double(after.at(slab) - volume)) <= 2 * walls.at(slab));
    CHECK(cost(graph) <= last);
    // One tet that is nearly flat may cost so much that the sum does not show what the others gain.
    if (done > 0 && last < kResolved) {
      CHECK(cost(graph) < last);
      ++lower;
    }
    // All of it comes back, by slabs with the same volumes.
    std::size_t alive = 0;
    for (std::int32_t t = 0; t < std::int32_t(graph.size()); ++t) alive += std::size_t(graph.alive(t));
    std::vector<std::int32_t> same(graph.points().size());
    std::iota(same.begin(), same.end(), 0);
    Poll listen(kNobody, 1);
    graph.give_back(made.mesh, same, listen);
    CHECK(made.mesh.tets.size() == alive);
    CHECK(made.mesh.tet_slab.size() == alive);
    CHECK(made.mesh.tet_region.size() == alive);
  }
  CHECK(flips > 100);
  CHECK(several_slabs > 5);
  CHECK(lower > 5);
}

TEST_CASE("a vertex that goes into its neighbor leaves neighbors, stars and ratings that are right") {
  std::size_t collapses = 0;
  for (const NamedStack& named : stacks()) {
    INFO(named.name);
    Made made = make(named.stack);
    std::vector<char> fixed;
    for (const PlaneMesh& plane : made.stack.meshes) fixed.insert(fixed.end(), plane.fixed.begin(), plane.fixed.end());
    TetGraph graph(made.stack, made.mesh, made.pitch, Poll(kNobody, 1));
    const auto before = volumes(graph);
    std::size_t done = 0;
    for (std::int32_t v = 0; v < std::int32_t(fixed.size()) && done < 40; ++v) {
      if (fixed[std::size_t(v)] != 0) continue;
      std::vector<std::int32_t> neighbors;
      for (const std::int32_t t : graph.star(v))
        for (const std::int32_t u : graph[t].v)
          if (u != v && graph.plane(u) == graph.plane(v)) neighbors.push_back(u);
      std::sort(neighbors.begin(), neighbors.end());
      neighbors.erase(std::unique(neighbors.begin(), neighbors.end()), neighbors.end());
      for (const std::int32_t u : neighbors) {
        Int128 sum = 0;
        bool positive = true;
        for (const std::int32_t t : graph.star(v)) {
          TetGraph::Tet tet = graph[t].v;
          sum -= graph.volume(tet);
          if (TetGraph::has(tet, u)) continue;
          tet[TetGraph::index_of(tet, v)] = u;
          sum += graph.volume(tet);
          positive = positive && graph.volume(tet) > 0;
        }
        if (!positive || sum != 0) continue;
        graph.collapse(v, u);
        ++done;
        CHECK(graph.star(v).empty());
        break;
      }
    }
    collapses += done;
    const std::string fault = faults(graph);
    INFO(fault);
    CHECK(fault.empty());
    CHECK((volumes(graph) == before));
  }
  CHECK(collapses > 100);
}

TEST_CASE("how bad a tet is does not depend on the vertex it is rated from, and is R/3r where angles are not small") {
  Made made = make(random_stack(3));
  const TetGraph graph(made.stack, made.mesh, made.pitch, Poll(kNobody, 1));
  std::size_t plain = 0, sharp = 0;
  for (std::int32_t t = 0; t < std::int32_t(graph.size()); ++t) {
    const TetGraph::Tet& v = graph[t].v;
    TetCorners corners;
    for (std::size_t i = 0; i < 4; ++i) corners[i] = graph.xyz(v[i]);
    const double ratio = radius_ratio(corners), rated = graph.badness(t);
    for (const TetGraph::Tet& other : {TetGraph::Tet{v[1], v[0], v[3], v[2]}, TetGraph::Tet{v[2], v[0], v[1], v[3]},
                                       TetGraph::Tet{v[3], v[0], v[2], v[1]}})
      CHECK(graph.rate(other) == Approx(rated).epsilon(1e-6));
    CHECK(rated >= ratio * (1 - 1e-6));
    if (ratio < detail::kLookAtAngles) {
      ++plain;
      CHECK(rated == Approx(ratio).epsilon(1e-6));
    } else {
      ++sharp;
    }
    CHECK(graph.rate(TetGraph::Tet{v[1], v[0], v[2], v[3]}) == std::numeric_limits<double>::infinity());
  }
  CHECK(plain > 100);
  CHECK(sharp > 0);
}

TEST_CASE(
    "the cost of a star for any place of its vertex is that of its tets, rated one by one with the vertex there") {
  std::size_t valid = 0, invalid = 0, cut = 0, sharp = 0;
  std::mt19937 random(1711);
  for (const NamedStack& named : stacks()) {
    INFO(named.name);
    Made made = make(named.stack);
    TetGraph graph(made.stack, made.mesh, made.pitch, Poll(kNobody, 1));
    detail::StarCost star;
    for (std::int32_t v = 0; v < std::int32_t(graph.points().size()); v += 1 + v / 40) {
      if (graph.star(v).empty()) continue;
      const GridPoint start = graph.point(v);
      star.take(graph, v);
      double shortest = std::numeric_limits<double>::infinity();
      for (const std::int32_t t : graph.star(v))
        for (const std::int32_t u : graph[t].v)
          if (u != v && graph.plane(u) == graph.plane(v))
            shortest = std::min(shortest, detail::distance(start, graph.point(u)));
      CHECK(star.shortest() == Approx(shortest).epsilon(1e-12));
      for (const double share : {0.0, 0.1, 0.5, 2.0}) {
        const double angle = double(random()) / 6.8e8;
        const std::int64_t x = std::llround(share * shortest * std::cos(angle)),
                           y = std::llround(share * shortest * std::sin(angle));
        graph.set_point(v, {start.x + x, start.y + y});
        double sum = 0;
        std::vector<double> ratings;
        for (const std::int32_t t : graph.star(v)) {
          ratings.push_back(graph.rate(graph[t].v));
          sum += std::isfinite(ratings.back()) ? detail::improvement_cost(ratings.back()) : ratings.back();
        }
        graph.set_point(v, start);
        const double cost = star.at(x, y, std::numeric_limits<double>::infinity());
        if (!std::isfinite(sum)) {
          ++invalid;
          CHECK_FALSE(std::isfinite(cost));
          continue;
        }
        // Nearly flat tets have ratings of few digits, whatever the order of the terms.
        if (*std::max_element(ratings.begin(), ratings.end()) > 1e4) continue;
        ++valid;
        CHECK(cost == Approx(sum).epsilon(1e-6));
        for (std::size_t i = 0; i < ratings.size(); ++i) {
          CHECK(star.rating(i) == Approx(ratings[i]).epsilon(1e-6));
          sharp += std::size_t(ratings[i] > 3.5);
        }
        CHECK_FALSE(std::isfinite(star.at(x, y, 0.9 * sum)));
        ++cut;
      }
    }
  }
  CHECK(valid > 500);
  CHECK(invalid > 500);
  CHECK(cut > 500);
  CHECK(sharp > 500);
}

TEST_CASE("tets joined anew to a vertex fill the place of the old ones, on walls and planes the same from both sides") {
  std::size_t cavities = 0, shared = 0, sharp = 0, regions = 0;
  for (const NamedStack& named : stacks())
    for (const bool sharpen : {false, true}) {
      INFO(named.name);
      Bench bench(named.stack);
      auto& [made, graph, on_walls, flipper, joiner] = bench;
      joiner.sharpen(sharpen);
      const auto before = cell_volumes(graph);
      const auto areas = shared_areas(graph);
      shared += areas.size();
      regions += std::size_t(before.size() > volumes(graph).size());
      REQUIRE(lost_edges(graph, made.stack) == 0);
      const std::map<std::int32_t, double> walls = wall_lengths(made.stack);
      std::size_t done = 0;
      double last = cost(graph);
      for (std::int32_t t = 0; t < std::int32_t(graph.size()); ++t) {
        if (!graph.alive(t) || !(graph.badness(t) > 1.2) || !joiner.reconnect(t)) continue;
        sharp += std::size_t(sharpen);
        if (++done % 64 != 0) continue;
        const std::string fault = faults(graph);
        INFO(fault);
        REQUIRE(fault.empty());
        REQUIRE((shared_areas(graph) == areas));
        const double now = cost(graph);
        if (!sharpen && last < 1e15) CHECK(now < last);
        last = now;
      }
      cavities += done;
      const std::string fault = faults(graph);
      INFO(fault);
      CHECK(fault.empty());
      CHECK(lost_edges(graph, made.stack) == 0);
      CHECK((shared_areas(graph) == areas));
      const auto after = cell_volumes(graph);
      REQUIRE(after.size() == before.size());
      for (const auto& [cell, volume] : before)
        CHECK(std::fabs(double(after.at(cell) - volume)) <= 2 * walls.at(cell.first));
    }
  CHECK(cavities > 500);
  CHECK(sharp > 100);
  CHECK(shared > 20);
  CHECK(regions > 3);
}

TEST_CASE("a vertex is put on an edge of a plane, and on the walls that the edge is on") {
  std::size_t inside = 0, on_contours = 0;
  for (const NamedStack& named : stacks()) {
    INFO(named.name);
    Bench bench(named.stack);
    auto& [made, graph, on_walls, flipper, joiner] = bench;
    joiner.sharpen(true);
    const auto before = cell_volumes(graph);
    const auto areas = shared_areas(graph);
    const std::map<std::int32_t, double> walls = wall_lengths(made.stack);
    double length = 0;
    for (const auto& [slab, sum] : walls) length += sum;
    std::size_t done = 0;
    for (std::int32_t t = 0; t < std::int32_t(graph.size()) && done < 20; t += 7) {
      if (!graph.alive(t)) continue;
      const std::int32_t v = graph.add_vertex();
      on_walls.add_vertex();
      const std::vector<detail::Cavities::Filling>& offers = joiner.insertions(t, v);
      for (std::size_t i = 1; i < offers.size(); ++i) CHECK(offers[i - 1].gain >= offers[i].gain);
      if (offers.empty()) continue;
      const detail::Cavities::Filling& offer = offers[done % offers.size()];
      CHECK(std::find(offer.old.begin(), offer.old.end(), t) != offer.old.end());
      graph.set_point(v, offer.point);
      graph.put_on_plane_of(v, offer.a);
      on_walls.put_last(offer.walls);
      graph.replace(offer.old, offer.tets, offer.cells, offer.badnesses);
      ++done;
      CHECK_FALSE(graph.star(v).empty());
      bool on_contour = false;
      for (const std::size_t side : {std::size_t(0), std::size_t(1)}) {
        if (offer.walls[side] == kNone) continue;
        on_contour = true;
        PlaneMesh& mesh = made.stack.meshes[std::size_t(graph.plane(v))];
        auto& chain = (side == 0 ? mesh.below_chain : mesh.above_chain)[std::size_t(offer.walls[side])];
        const std::int32_t first = graph.first()[std::size_t(graph.plane(v))];
        std::size_t at = 1;
        const auto is_edge = [&](std::size_t k) {
          return std::minmax(chain[k - 1], chain[k]) == std::minmax(offer.a - first, offer.b - first);
        };
        while (at < chain.size() && !is_edge(at)) ++at;
        REQUIRE(at < chain.size());
        chain.insert(chain.begin() + std::ptrdiff_t(at), v - first);
      }
      ++(on_contour ? on_contours : inside);
      const std::string fault = faults(graph);
      INFO(fault);
      REQUIRE(fault.empty());
    }
    CHECK(lost_edges(graph, made.stack) == 0);
    const auto after = cell_volumes(graph);
    REQUIRE(after.size() == before.size());
    // A vertex on a contour is rounded: by less than a pitch, and what is beside the edge gains or loses that.
    for (const auto& [cell, volume] : before)
      CHECK(std::fabs(double(after.at(cell) - volume)) <= 4 * walls.at(cell.first));
    for (const auto& [plane, area] : areas) CHECK(std::fabs(double(shared_areas(graph)[plane] - area)) <= 4 * length);
  }
  CHECK(inside > 50);
  CHECK(on_contours > times(20));
}

TEST_CASE("a trial that is taken back leaves tets, neighbors, stars, ratings and stamps as they were") {
  std::size_t trials = 0, changes = 0;
  for (const NamedStack& named : stacks()) {
    INFO(named.name);
    Bench bench(named.stack);
    auto& [made, graph, on_walls, flipper, joiner] = bench;
    flipper.turn_walls(true);
    const std::vector<double> ratings = [&] {
      std::vector<double> result;
      for (std::int32_t t = 0; t < std::int32_t(bench.graph.size()); ++t) result.push_back(bench.graph.badness(t));
      return result;
    }();
    std::vector<TetGraph::Element> elements;
    for (std::int32_t t = 0; t < std::int32_t(graph.size()); ++t) elements.push_back(graph[t]);
    std::vector<std::uint32_t> stamps;
    for (std::int32_t v = 0; v < std::int32_t(graph.points().size()); ++v) stamps.push_back(graph.changed(v));
    for (int trial = 0; trial < 3; ++trial) {
      const double all = cost(graph);
      graph.begin_trial();
      std::size_t done = 0;
      for (std::int32_t t = trial; t < std::int32_t(elements.size()) && done < 60; t += 3)
        if (graph.alive(t) && (trial == 1 ? joiner.reconnect(t) : flipper.flip(t) || joiner.reconnect(t))) ++done;
      changes += done;
      // What the trial says of the costs is what all tets say.
      double put = 0;
      for (const std::int32_t t : graph.put()) put += detail::improvement_cost(graph.badness(t));
      if (all < 1e15)
        CHECK(cost(graph) - all == Approx(put - graph.sum_of_taken(detail::improvement_cost)).margin(1e-6 * all));
      graph.end_trial(false);
      ++trials;
      const std::string fault = faults(graph);
      INFO(fault);
      REQUIRE(fault.empty());
      for (std::int32_t t = 0; t < std::int32_t(graph.size()); ++t) {
        if (std::size_t(t) >= elements.size()) {
          REQUIRE_FALSE(graph.alive(t));
          continue;
        }
        const TetGraph::Element &now = graph[t], &then = elements[std::size_t(t)];
        REQUIRE((now.v == then.v && now.across == then.across && now.slab == then.slab && now.region == then.region));
        REQUIRE(graph.badness(t) == ratings[std::size_t(t)]);
      }
      for (std::int32_t v = 0; v < std::int32_t(stamps.size()); ++v)
        REQUIRE(graph.changed(v) == stamps[std::size_t(v)]);
    }
    // And one that is kept stays.
    graph.begin_trial();
    bool any = false;
    for (std::int32_t t = 0; t < std::int32_t(elements.size()) && !any; ++t) any = joiner.reconnect(t);
    const std::vector<std::int32_t> put = graph.put();
    graph.end_trial(true);
    for (const std::int32_t t : put) CHECK(graph.alive(t));
    CHECK(faults(graph).empty());
  }
  CHECK(trials > times(50));
  CHECK(changes > 500);
}
