// SPDX-License-Identifier: MIT
/// @file
/// @brief Why an element is bad, from the complex that it fills.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/arrange/outline.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/quality/quality.hpp"

namespace slice2mesh {

/// Corners of a slice below this angle, in degrees, force bad elements.
inline constexpr double kSmallInputAngle = 20;

namespace detail {

/// Two features of a contour are neighbors if it leads from one to the other within so many tolerances.
inline constexpr double kNeighborReach = 4;

/// An element whose edges differ by more than this factor stands where sizes jump.
inline constexpr double kSizeJump = 8;

/// A point counts as one of a contour that passes it within this share of the tolerance: contours bend by less than
/// that between the planes of a slab.
inline constexpr double kOnContourShare = 0.01;

/// The contours of a complex as graphs, one per plane and slab, and what is sharp or thin about them.
class CauseFinder {
public:
  CauseFinder(const Plc& plc, double eps, const std::vector<Outline>* input, const std::function<void()>& poll)
      : grid_(plc.grid) {
    eps_ = eps / grid_.pitch;
    Poll listen(poll, 1 << 16);
    points_ = plc.vertices;
    start_.assign(plc.vertices.size() + 1, 0);
    const auto visit = [&](auto&& f) {
      for (const Facet& facet : plc.facets) {
        listen();
        if (facet.wall == kNone) continue;
        const std::int32_t slab = facet.back.empty() ? facet.front.slab : facet.back.slab;
        for (std::size_t i = 0; i < 3; ++i) {
          const std::int32_t u = facet.vertices[i], v = facet.vertices[(i + 1) % 3];
          if (plc.vertex_plane[std::size_t(u)] == plc.vertex_plane[std::size_t(v)]) f(slab, u, v);
        }
      }
    };
    visit([&](std::int32_t, std::int32_t u, std::int32_t v) {
      ++start_[std::size_t(u) + 1];
      ++start_[std::size_t(v) + 1];
    });
    for (std::size_t v = 1; v < start_.size(); ++v) start_[v] += start_[v - 1];
    links_.resize(start_.back());
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    visit([&](std::int32_t slab, std::int32_t u, std::int32_t v) {
      links_[next[std::size_t(u)]++] = {slab, v};
      links_[next[std::size_t(v)]++] = {slab, u};
    });
    around_.resize(links_.size());
    for (std::size_t v = 0; v < points_.size(); ++v) {
      listen();
      sort_listening(links_.begin() + std::ptrdiff_t(start_[v]), links_.begin() + std::ptrdiff_t(start_[v + 1]), listen,
                     [](const Link& a, const Link& b) { return a.slab != b.slab ? a.slab < b.slab : a.to < b.to; });
      for_each_contour(std::int32_t(v), [&](std::size_t first, std::size_t last) {
        listen(last - first);
        for (std::size_t i = first; i < last; ++i)
          around_[i] = direction(points_[v], points_[std::size_t(links_[i].to)]);
        sort_listening(around_.begin() + std::ptrdiff_t(first), around_.begin() + std::ptrdiff_t(last), listen);
      });
    }
    for (std::size_t v = 0; v < points_.size(); ++v) {
      listen();
      if (start_[v] != start_[v + 1]) by_position_.push_back({plc.position(v), std::int32_t(v)});
    }
    sort_listening(by_position_.begin(), by_position_.end(), listen);
    if (input != nullptr) find_input_corners(*input, listen);
  }

  [[nodiscard]] Cause operator()(const Mesh& mesh, const WorstTet& tet) const {
    std::array<std::int32_t, 4> at{};
    std::array<std::array<double, 3>, 4> position{};
    for (std::size_t i = 0; i < 4; ++i) {
      position[i] = mesh.vertices[std::size_t(mesh.tets[tet.tet][i])];
      at[i] = contour_vertex(mesh.vertices, mesh.tets[tet.tet][i]);
    }
    for (const std::int32_t v : at)
      if (v != kNone && in_sharp_corner(v, tet.centroid)) return Cause::SmallInputAngle;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < 4; ++j)
        if (i != j && at[i] != kNone && at[j] != kNone && is_thin(at[i], at[j], at)) return Cause::ThinWall;
    double shortest = HUGE_VAL, longest = 0;
    std::array<std::size_t, 2> ends{};
    for (const auto& e : kTetEdgeVertices) {
      double sum = 0;
      for (std::size_t k = 0; k < 3; ++k)
        sum += (position[e[0]][k] - position[e[1]][k]) * (position[e[0]][k] - position[e[1]][k]);
      longest = std::max(longest, sum);
      if (sum < shortest) {
        shortest = sum;
        ends = {e[0], e[1]};
      }
    }
    if (at[ends[0]] != kNone && at[ends[1]] != kNone && !have_common_contour(at[ends[0]], at[ends[1]]))
      return Cause::SizeJump;
    if (longest > kSizeJump * kSizeJump * shortest) return Cause::SizeJump;
    return tet.cause;
  }

private:
  struct Link {
    std::int32_t slab;  // whose contour
    std::int32_t to;    // vertex of the complex in the same plane
  };
  struct InputCorner {
    std::int32_t slab;
    GridPoint at;
  };

  [[nodiscard]] std::int32_t contour_vertex(const std::vector<std::array<double, 3>>& vertices, std::int32_t v) const {
    const std::pair<std::array<double, 3>, std::int32_t> key{vertices[std::size_t(v)], 0};
    const auto found = std::lower_bound(by_position_.begin(), by_position_.end(), key);
    return found != by_position_.end() && found->first == key.first ? found->second : kNone;
  }

  /// Calls f(first, last) for the ranges of links of one contour each.
  template <class F>
  void for_each_contour(std::int32_t v, F&& f) const {
    const std::size_t end = start_[std::size_t(v) + 1];
    for (std::size_t i = start_[std::size_t(v)]; i < end;) {
      std::size_t j = i;
      while (j < end && links_[j].slab == links_[i].slab) ++j;
      f(i, j);
      i = j;
    }
  }

  [[nodiscard]] double direction(const GridPoint& from, const GridPoint& to) const {
    return std::atan2(double(to.y - from.y), double(to.x - from.x));
  }

  /// Does a contour have a corner at v that is sharp, and sharp in the input, and is the place in it?
  [[nodiscard]] bool in_sharp_corner(std::int32_t v, const std::array<double, 3>& place) const {
    const GridPoint& p = points_[std::size_t(v)];
    const double toward = std::atan2(place[1] - grid_.y_mm(p), place[0] - grid_.x_mm(p));
    bool found = false;
    for_each_contour(v, [&](std::size_t first, std::size_t last) {
      if (found || last - first < 2) return;
      // The corner that the place is in lies between the last direction up to it and the next one.
      const auto begin = around_.begin() + std::ptrdiff_t(first), end = around_.begin() + std::ptrdiff_t(last);
      const auto next = std::upper_bound(begin, end, toward);
      const double low = next == begin ? *(end - 1) - kFullTurn : *(next - 1);
      const double high = next == end ? *begin + kFullTurn : *next;
      found = (high - low) * kDegrees < kSmallInputAngle && is_input_corner(links_[first].slab, p);
    });
    return found;
  }

  void find_input_corners(const std::vector<Outline>& input, Poll& listen) {
    check_input_ = true;
    for (std::size_t s = 0; s < input.size(); ++s) {
      const Outline& outline = input[s];
      std::vector<std::vector<double>> around(outline.vertices.size());
      for (const Outline::Edge& e : outline.edges) {
        listen(8);
        const GridPoint &a = outline.vertices[std::size_t(e.a)], &b = outline.vertices[std::size_t(e.b)];
        around[std::size_t(e.a)].push_back(direction(a, b));
        around[std::size_t(e.b)].push_back(direction(b, a));
      }
      for (std::size_t v = 0; v < around.size(); ++v) {
        listen();
        sort_listening(around[v].begin(), around[v].end(), listen);
        double smallest = kFullTurn;
        for (std::size_t i = 0; i < around[v].size(); ++i) {
          const bool end = i + 1 == around[v].size();
          smallest =
              std::min(smallest, end ? around[v][0] + kFullTurn - around[v][i] : around[v][i + 1] - around[v][i]);
        }
        if (smallest * kDegrees < kSmallInputAngle) corners_.push_back({std::int32_t(s), outline.vertices[v]});
      }
    }
    sort_listening(corners_.begin(), corners_.end(), listen, [](const InputCorner& a, const InputCorner& b) {
      return a.slab != b.slab ? a.slab < b.slab : a.at < b.at;
    });
  }

  [[nodiscard]] bool is_input_corner(std::int32_t slab, const GridPoint& p) const {
    if (!check_input_) return true;
    const auto first = std::lower_bound(
        corners_.begin(), corners_.end(), p.x - std::llround(eps_),
        [slab](const InputCorner& c, std::int64_t x) { return c.slab != slab ? c.slab < slab : c.at.x < x; });
    for (auto c = first; c != corners_.end() && c->slab == slab && double(c->at.x - p.x) <= eps_; ++c)
      if (distance(c->at, p) <= eps_) return true;
    return false;
  }

  /// Does a contour come nearer than eps to itself between v and the feature at w: w itself, or an edge of it that is
  /// an edge of the element?
  [[nodiscard]] bool is_thin(std::int32_t v, std::int32_t w, const std::array<std::int32_t, 4>& element) const {
    const GridPoint &p = points_[std::size_t(v)], &q = points_[std::size_t(w)];
    bool thin = false;
    for_each_contour(v, [&](std::size_t first, std::size_t) {
      const std::int32_t slab = links_[first].slab;
      bool on_contour = false;
      for (std::size_t i = start_[std::size_t(w)]; i < start_[std::size_t(w) + 1] && !thin; ++i) {
        if (links_[i].slab != slab) continue;
        on_contour = true;
        const std::int32_t x = links_[i].to;
        if (x == v || std::find(element.begin(), element.end(), x) == element.end()) continue;
        const GridPoint& r = points_[std::size_t(x)];
        // The point of the edge nearest to v, and the ways along the contour from there.
        const double length = distance(q, r), away = segment_distance(p, q, r);
        const double along = std::clamp(double(dot(q, p, r)) / length, 0.0, length);
        thin = away < eps_ && !passes_nearby(slab, {{x, w, along}, {w, x, length - along}}, p, away);
      }
      if (on_contour && !thin) {
        const double away = distance(p, q);
        thin = away < eps_ && !passes_nearby(slab, {{kNone, w, 0}}, p, away);
      }
    });
    return thin;
  }

  struct Step {
    std::int32_t from, at;
    double length;
    double least = 0;  // of a way to the target that begins so
    bool operator<(const Step& o) const { return least > o.least; }
  };
  /// Does the contour of the slab lead to p within kNeighborReach tolerances, from a point that is `away` from p?
  [[nodiscard]] bool passes_nearby(std::int32_t slab, std::vector<Step> steps, const GridPoint& p, double away) const {
    const double on = kOnContourShare * eps_, reach = kNeighborReach * eps_;
    if (away <= on) return true;
    // The shortest way first, counted with the distance that is left: where many contours touch in a point, it goes on
    // along those that lead to the target.
    for (Step& step : steps) step.least = step.length + distance(p, points_[std::size_t(step.at)]);
    std::make_heap(steps.begin(), steps.end());
    constexpr std::size_t kMostSteps = 1000;
    for (std::size_t n = 0; !steps.empty() && n < kMostSteps; ++n) {
      std::pop_heap(steps.begin(), steps.end());
      const Step step = steps.back();
      steps.pop_back();
      if (step.least > reach) break;
      const GridPoint& q = points_[std::size_t(step.at)];
      for (std::size_t i = start_[std::size_t(step.at)]; i < start_[std::size_t(step.at) + 1]; ++i) {
        if (links_[i].slab != slab || links_[i].to == step.from) continue;
        const GridPoint& r = points_[std::size_t(links_[i].to)];
        if (segment_distance(p, q, r) <= on) return true;
        const double length = step.length + distance(q, r), least = length + distance(p, r);
        if (least > reach) continue;
        steps.push_back({step.at, links_[i].to, length, least});
        std::push_heap(steps.begin(), steps.end());
      }
    }
    return false;
  }

  [[nodiscard]] bool have_common_contour(std::int32_t v, std::int32_t w) const {
    for (std::size_t i = start_[std::size_t(v)]; i < start_[std::size_t(v) + 1]; ++i)
      for (std::size_t j = start_[std::size_t(w)]; j < start_[std::size_t(w) + 1]; ++j)
        if (links_[i].slab == links_[j].slab) return true;
    return false;
  }

  static constexpr double kFullTurn = 2 * 3.14159265358979323846;
  Grid grid_;
  double eps_ = 0;                  // pitches
  std::vector<GridPoint> points_;   // #V of the complex
  std::vector<std::size_t> start_;  // #V + 1 offsets into links_
  std::vector<Link> links_;         // by slab and vertex
  std::vector<double> around_;      // the directions of the links of each contour at each vertex, ascending
  std::vector<std::pair<std::array<double, 3>, std::int32_t>> by_position_;  // contour vertices, sorted
  bool check_input_ = false;
  std::vector<InputCorner> corners_;  // by slab and place
};

}  // namespace detail

/// Says why an element is bad, for QualityOptions::classify, from the contours in the complex:
/// SmallInputAngle: it lies in a corner of a slab's contour below kSmallInputAngle;
/// ThinWall: two of its vertices, or a vertex and an edge, belong to parts of one contour that are nearer than `eps` to
/// each other, and not just because they follow each other;
/// SizeJump: its shortest edge leads from the contour of one layer to that of another, or its edges differ by more
/// than a factor of 8; else what its own shape tells.
/// `eps` in mm, above 0. With `input`, the outlines before harmonization (#S), a corner counts only if the input has
/// one below kSmallInputAngle within eps of it. The complex and the input need not outlive the call. `poll` is called
/// now and then; what it throws ends the work. Cost: O(n log n) once; per element about constant.
[[nodiscard]] inline std::function<Cause(const Mesh&, const WorstTet&)> default_cause(
    const Plc& plc, double eps, const std::vector<Outline>* input = nullptr, const std::function<void()>& poll = {}) {
  // Shared: a std::function is copied with its options.
  return [finder = std::make_shared<const detail::CauseFinder>(plc, eps, input, poll)](
             const Mesh& mesh, const WorstTet& tet) { return (*finder)(mesh, tet); };
}

}  // namespace slice2mesh
