// SPDX-License-Identifier: MIT
/// @file
/// @brief Sliver removal: free vertices of bad tets are moved or removed in their planes.
///
/// The fill of a slab is a function of its two plane triangulations. So a change of one free vertex changes the fill
/// near it only, in the two slabs beside its plane. A round changes many vertices that are far from each other, fills
/// again, and takes back each change after which the elements around are not better. Every state is a valid fill;
/// nothing else is at stake.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/harmonize/harmonize.hpp"
#include "slice2mesh/pipeline/options.hpp"
#include "slice2mesh/plc/build_plc.hpp"
#include "slice2mesh/quality/tet_figures.hpp"
#include "slice2mesh/tet/slab_filler.hpp"
#include "slice2mesh/triangulate/plane_stack.hpp"

namespace slice2mesh {

namespace detail {

/// What a tet of the current fill costs, and where it is.
struct RatedTet {
  std::array<std::int32_t, 4> vertices;  // in their planes
  std::array<bool, 4> upper;             // in the upper plane of the slab
  double x, y;                           // centroid, in pitches
  double ratio;                          // R/3r
};

class Improver {
public:
  Improver(const Contours& contours, PlaneStack& stack, const ImproveOptions& options, const PlaneSizes& sizes,
           const Progress& progress)
      : contours_(contours), stack_(stack), options_(options), progress_(progress),
        size_(sizes.size / contours.grid.pitch), slabs_(contours.slabs.size()), dirty_(contours.slabs.size(), 1),
        buckets_(contours.slabs.size()) {}

  void run() {
    plane_slabs_.resize(stack_.meshes.size());
    for (std::size_t s = 0; s < slabs_.size(); ++s)
      for (const std::int32_t k : stack_.slab_planes[s]) plane_slabs_[std::size_t(k)].push_back(std::int32_t(s));
    for (std::size_t k = 0; k < stack_.meshers.size(); ++k) stack_.meshes[k] = stack_.meshers[k]->extract(false);
    fill();
    for (std::int32_t round = 0; round < options_.rounds; ++round) {
      report(progress_, Stage::Triangulate, double(round) / double(options_.rounds));
      // The work of all rounds is bounded by a number of tets, not by time: the result does not depend on the machine.
      if (work_ > options_.most_work) break;
      if (propose(round) == 0) {
        if (++idle_ == kKinds) break;
        continue;
      }
      fill();
      judge();
      fill();
    }
    for (std::size_t k = 0; k < stack_.meshers.size(); ++k) stack_.meshes[k] = stack_.meshers[k]->extract();
  }

private:
  static constexpr std::int32_t kKinds = 4;
  struct Change {
    std::size_t plane;
    GridPoint from;
    GridPoint to;
    std::int32_t added;  // vertex in the new place, or kNone for a removal
    double cost;         // before
  };

  [[nodiscard]] double reach() const { return 1.5 * size_; }  // how far a change is felt

  void fill() {
    if (std::none_of(dirty_.begin(), dirty_.end(), [](char d) { return d != 0; })) return;
    const Plc plc = build_plc(contours_, stack_.meshes, stack_.slab_planes, true, dirty_);
    std::vector<std::int32_t> first(stack_.meshes.size() + 1, 0);
    for (std::size_t k = 0; k < stack_.meshes.size(); ++k)
      first[k + 1] = first[k] + std::int32_t(stack_.meshes[k].vertices.size());
    Sheets sheets(plc);
    for (std::size_t s = 0; s < slabs_.size(); ++s) {
      if (!dirty_[s]) continue;
      dirty_[s] = 0;
      slabs_[s].clear();
      const Sheet bottom = sheets.make(std::int32_t(s), false), top = sheets.make(std::int32_t(s), true);
      const std::int32_t low = first[std::size_t(stack_.slab_planes[s][0])],
                         high = first[std::size_t(stack_.slab_planes[s][1])];
      SlabFill(std::int32_t(s), bottom, top).run([&](const std::array<std::int32_t, 4>& tet, std::int32_t) {
        RatedTet rated{};
        TetCorners corners;
        for (std::size_t i = 0; i < 4; ++i) {
          const bool upper = plc.vertex_plane[std::size_t(tet[i])] == stack_.slab_planes[s][1];
          rated.upper[i] = upper;
          rated.vertices[i] = tet[i] - (upper ? high : low);
          corners[i] = plc.position(std::size_t(tet[i]));
          rated.x += double(plc.vertices[std::size_t(tet[i])].x) / 4;
          rated.y += double(plc.vertices[std::size_t(tet[i])].y) / 4;
        }
        rated.ratio = radius_ratio(corners);
        slabs_[s].push_back(rated);
      });
      index(s);
      work_ += double(slabs_[s].size());
    }
  }
  /// Bad tets of a slab by place; only they count in costs.
  void index(std::size_t s) {
    buckets_[s].clear();
    for (std::size_t t = 0; t < slabs_[s].size(); ++t)
      if (slabs_[s][t].ratio > kCounts) buckets_[s][key(slabs_[s][t].x, slabs_[s][t].y)].push_back(std::int32_t(t));
  }
  static constexpr double kCounts = 2.5;  // tets better than this cost nothing
  [[nodiscard]] std::uint64_t key(double x, double y) const {
    return std::uint64_t(std::int64_t(std::floor(x / reach()))) * 0x9E3779B97F4A7C15ULL ^
           (std::uint64_t(std::int64_t(std::floor(y / reach()))) + 0x7F4A7C15ULL) * 0xC2B2AE3D27D4EB4FULL;
  }
  /// What the tets around a point of a plane cost: the fourth powers of their R/3r.
  [[nodiscard]] double cost(std::size_t plane, const GridPoint& p) const {
    double sum = 0;
    for (const std::int32_t slab : plane_slabs_[plane]) {
      const auto s = std::size_t(slab);
      for (int i = -1; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j) {
          const auto it = buckets_[s].find(key(double(p.x) + i * reach(), double(p.y) + j * reach()));
          if (it == buckets_[s].end()) continue;
          for (const std::int32_t t : it->second) {
            const RatedTet& tet = slabs_[s][std::size_t(t)];
            if (std::hypot(tet.x - double(p.x), tet.y - double(p.y)) < reach())
              sum += std::pow(std::min(tet.ratio, 1e6), 4);
          }
        }
    }
    return sum;
  }
  static std::uint64_t mix(std::uint64_t v) {
    v = (v ^ (v >> 30)) * 0xBF58476D1CE4E5B9ULL;
    v = (v ^ (v >> 27)) * 0x94D049BB133111EBULL;
    return v ^ (v >> 31);
  }

  /// Chooses changes that are far from each other, and makes them. Returns their number.
  std::size_t propose(std::int32_t round) {
    changes_.clear();
    struct Bad {
      double ratio;
      std::int32_t slab, tet;
    };
    std::vector<Bad> bad;
    for (std::size_t s = 0; s < slabs_.size(); ++s)
      for (std::size_t t = 0; t < slabs_[s].size(); ++t)
        if (slabs_[s][t].ratio > options_.target) bad.push_back({slabs_[s][t].ratio, std::int32_t(s), std::int32_t(t)});
    std::sort(bad.begin(), bad.end(), [](const Bad& a, const Bad& b) {
      if (a.ratio != b.ratio) return a.ratio > b.ratio;
      return a.slab != b.slab ? a.slab < b.slab : a.tet < b.tet;
    });
    // Places taken, per slab: two changes in one slab are at least two reaches apart.
    std::vector<SpacedPoints> taken(slabs_.size(), SpacedPoints(2 * reach()));
    std::vector<std::vector<std::int32_t>> removed(stack_.meshers.size());
    for (const Bad& b : bad) {
      const RatedTet& tet = slabs_[std::size_t(b.slab)][std::size_t(b.tet)];
      for (std::int32_t attempt = 0; attempt < 4; ++attempt) {
        const std::uint64_t random =
            mix(std::uint64_t(round) * 7919 + std::uint64_t(b.tet) * 31 + std::uint64_t(b.slab) * 1000003);
        const auto i = std::size_t((random + std::uint64_t(attempt)) % 4);
        const auto plane = std::size_t(stack_.slab_planes[std::size_t(b.slab)][tet.upper[i] ? 1 : 0]);
        const PlaneMesh& mesh = stack_.meshes[plane];
        const auto v = std::size_t(tet.vertices[i]);
        if (mesh.fixed[v]) continue;
        const GridPoint from = mesh.vertices[v];
        bool clear = true;
        for (const std::int32_t s : plane_slabs_[plane])
          clear = clear && taken[std::size_t(s)].clear(from, 2 * reach());
        if (!clear) break;
        GridPoint to = from;
        const std::int32_t kind = (round + std::int32_t(random >> 60)) % kKinds;
        if (kind == 0) {
          // Onto the nearest corner on the other plane: a column instead of nearly one.
          double nearest = size_;
          for (std::size_t j = 0; j < 4; ++j) {
            if (tet.upper[j] == tet.upper[i]) continue;
            const auto other = std::size_t(stack_.slab_planes[std::size_t(b.slab)][tet.upper[j] ? 1 : 0]);
            const GridPoint p = stack_.meshes[other].vertices[std::size_t(tet.vertices[j])];
            const double d = distance(p, from);
            if (d > 0 && d < nearest) {
              nearest = d;
              to = p;
            }
          }
          if (to == from) continue;
        } else if (kind >= 2) {
          const double angle = double(random % 6283) / 1000;
          const double length = size_ * (0.05 + 0.35 * double((random >> 20) % 1000) / 1000);
          to = {round_to_step(from.x + std::llround(length * std::cos(angle))),
                round_to_step(from.y + std::llround(length * std::sin(angle)))};
        }
        Change change{plane, from, to, kNone, cost(plane, from)};
        if (kind != 1) {
          change.added = stack_.meshers[plane]->insert(to);
          if (change.added == kNone) continue;
        }
        removed[plane].push_back(std::int32_t(v));
        for (const std::int32_t s : plane_slabs_[plane]) taken[std::size_t(s)].add(from);
        changes_.push_back(change);
        break;
      }
    }
    apply(removed);
    return changes_.size();
  }
  void apply(const std::vector<std::vector<std::int32_t>>& removed) {
    for (std::size_t k = 0; k < removed.size(); ++k) {
      if (removed[k].empty()) continue;
      for (const std::int32_t v : removed[k]) stack_.meshers[k]->remove(v);
      stack_.meshers[k]->relabel();
      stack_.meshes[k] = stack_.meshers[k]->extract(false);
      for (const std::int32_t s : plane_slabs_[k]) dirty_[std::size_t(s)] = 1;
    }
  }
  /// Takes back what has not helped.
  void judge() {
    std::vector<std::vector<std::int32_t>> removed(stack_.meshers.size());
    std::vector<char> changed(stack_.meshers.size(), 0);
    std::size_t kept = 0;
    constexpr double kGain = 0.999;
    for (const Change& c : changes_) {
      if (cost(c.plane, c.from) < kGain * c.cost) {
        ++kept;
        continue;
      }
      if (stack_.meshers[c.plane]->insert(c.from) == kNone) continue;
      changed[c.plane] = 1;
      if (c.added != kNone) removed[c.plane].push_back(c.added);
    }
    apply(removed);
    for (std::size_t k = 0; k < changed.size(); ++k)
      if (changed[k] && removed[k].empty()) {
        stack_.meshes[k] = stack_.meshers[k]->extract(false);
        for (const std::int32_t s : plane_slabs_[k]) dirty_[std::size_t(s)] = 1;
      }
    idle_ = kept > 0 ? 0 : idle_;
  }

  const Contours& contours_;
  PlaneStack& stack_;
  const ImproveOptions& options_;
  const Progress& progress_;
  double size_;
  std::vector<std::vector<RatedTet>> slabs_;
  std::vector<char> dirty_;
  std::vector<std::unordered_map<std::uint64_t, std::vector<std::int32_t>>> buckets_;
  std::vector<Change> changes_;
  std::int32_t idle_ = 0;
  std::vector<std::vector<std::int32_t>> plane_slabs_;  // slabs beside each plane
  double work_ = 0;                                     // tets filled so far
};

}  // namespace detail

/// Improves the triangulations of planes so that the fill of the slabs between them has fewer bad tets: free vertices
/// of tets with R/3r above the target move onto vertices of the next plane, away, or go, as long as the elements around
/// get better. Deterministic. Errors: OptionError, Cancelled. Cost: two fills per round.
inline void improve_planes(const Contours& contours, PlaneStack& stack, const ImproveOptions& options,
                           const PlaneSizes& sizes, const Progress& progress = {}) {
  if (options.rounds < 0) throw OptionError("improve.rounds", "must be 0 or more");
  if (!(options.target >= 1)) throw OptionError("improve.target", "must be at least 1");
  if (options.rounds == 0 || contours.eps == 0) return;  // exact mode promises no quality, and has none to gain
  // A slab has about three tets for each triangle of a plane. What could not be gone through three times stays as it
  // is.
  double tets = 0;
  for (const PlaneMesh& mesh : stack.meshes) tets += 3 * double(mesh.triangles.size());
  if (3 * tets > options.most_work) return;
  detail::Improver(contours, stack, options, sizes, progress).run();
}

}  // namespace slice2mesh
