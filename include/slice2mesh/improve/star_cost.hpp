// SPDX-License-Identifier: MIT
/// @file
/// @brief The cost of the tets around a vertex for any place of it, several tets at a time.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "slice2mesh/improve/tet_graph.hpp"

namespace slice2mesh::detail {

/// Ratings of the tets around one vertex, as TetGraph::rate() gives them up to rounding, with the vertex in other
/// places of its plane: several tets at once, by the vector units of the processor. Single precision would save a
/// tenth of the time of smoothing, and leaves worse what is nearly flat. TetGraph::rate(), for one tet, is written by
/// itself: the same code for one lane makes flips, and all of the improvement, 6 % slower.
class StarCost {
public:
  /// Begins with a vertex where it is.
  void take(const TetGraph& graph, std::int32_t v) {
    static constexpr std::size_t kOthers[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};  // even permutations
    const TetGraph::Vector& from = graph.xyz(v);
    const ShortLists::View star = graph.star(v);
    graph_ = &graph;
    size_ = star.size();
    packets_.resize((size_ + kLanes - 1) / kLanes);
    ratings_.resize(packets_.size());
    double shortest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < packets_.size() * kLanes; ++i) {
      // What is left of the last packet is filled with the last tet.
      const TetGraph::Tet& tet = graph[star[std::min(i, size_ - 1)]].v;
      const auto& others = kOthers[TetGraph::index_of(tet, v)];
      Packet& packet = packets_[i / kLanes];
      for (std::size_t k = 0; k < 3; ++k) {
        const TetGraph::Vector& p = graph.xyz(tet[others[k]]);
        const double x = p[0] - from[0], y = p[1] - from[1], z = p[2] - from[2];
        if (z == 0) shortest = std::min(shortest, x * x + y * y);
        packet[k][0][Eigen::Index(i % kLanes)] = x;
        packet[k][1][Eigen::Index(i % kLanes)] = y;
        packet[k][2][Eigen::Index(i % kLanes)] = z;
      }
    }
    shortest_ = std::sqrt(shortest);
  }
  /// Length of the shortest edge at the vertex that lies in its plane, pitches; infinite if there is none.
  [[nodiscard]] double shortest() const { return shortest_; }

  /// The sum of the costs of the tets if the vertex were (x, y) pitches from where it was; infinite if one is not
  /// positive, or as soon as it reaches `limit`. Else rating() has what they are made of.
  [[nodiscard]] double at(std::int64_t x, std::int64_t y, double limit) {
    const auto dx = double(x), dy = double(y);
    double sum = 0;
    for (std::size_t i = 0; i < packets_.size(); ++i) {
      graph_->count(kWork);
      Lane& r = ratings_[i];
      r = rate(packets_[i], dx, dy);
      // Those that are not positive have no rating, and such sums are no numbers.
      const Lane cube = r * r * r;
      const std::size_t count = std::min(kLanes, size_ - i * kLanes);
      sum += count == kLanes ? cube.sum() : cube.head(Eigen::Index(count)).sum();
      if (!(sum < limit)) return std::numeric_limits<double>::infinity();
    }
    return sum;
  }
  /// The rating of the tet number i of the star, by the last call of at().
  [[nodiscard]] double rating(std::size_t i) const { return ratings_[i / kLanes][Eigen::Index(i % kLanes)]; }

private:
  static constexpr std::size_t kLanes = 4;
  static constexpr std::int64_t kWork = 2;  // of a packet, in ratings one by one
  using Lane = Eigen::Array<double, int(kLanes), 1>;
  using Vectors = std::array<Lane, 3>;
  using Packet = std::array<Vectors, 3>;  // from the vertex to the other three

  [[nodiscard]] static Vectors cross(const Vectors& u, const Vectors& v) {
    return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  }
  [[nodiscard]] static Lane squared(const Vectors& v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; }
  [[nodiscard]] static Lane rate(const Packet& packet, double dx, double dy) {
    Vectors e[3], n[3];
    Lane square[3], area[3];
    for (std::size_t i = 0; i < 3; ++i) {
      e[i] = {packet[i][0] - dx, packet[i][1] - dy, packet[i][2]};
      square[i] = squared(e[i]);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      n[i] = cross(e[(i + 1) % 3], e[(i + 2) % 3]);
      area[i] = squared(n[i]);
    }
    Vectors sum, center;
    for (std::size_t k = 0; k < 3; ++k) {
      sum[k] = n[0][k] + n[1][k] + n[2][k];
      center[k] = square[0] * n[0][k] + square[1] * n[1][k] + square[2] * n[2][k];
    }
    const Lane det = e[0][0] * n[0][0] + e[0][1] * n[0][1] + e[0][2] * n[0][2];
    const Lane base = squared(sum);
    const Lane areas = area[0].sqrt() + area[1].sqrt() + area[2].sqrt() + base.sqrt();
    Lane r = squared(center).sqrt() * areas / (6.0 * det * det);
    if (!(r < kLookAtAngles).all()) {
      // Squared sines over the squared determinant.
      Lane least = Lane::Constant(std::numeric_limits<double>::infinity());
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
        const Vectors opposite{e[k][0] - e[j][0], e[k][1] - e[j][1], e[k][2] - e[j][2]};
        least = least.min(square[i] / (area[j] * area[k])).min(squared(opposite) / (base * area[i]));
      }
      const Lane by_angle = kAngleWeight / (least.sqrt() * det);
      r = (r < kLookAtAngles).select(r, r.max(by_angle));
    }
    return (det > 0.0).select(r, Lane::Constant(std::numeric_limits<double>::infinity()));
  }

  const TetGraph* graph_ = nullptr;
  std::size_t size_ = 0;
  double shortest_ = 0;
  std::vector<Packet, Eigen::aligned_allocator<Packet>> packets_;
  std::vector<Lane, Eigen::aligned_allocator<Lane>> ratings_;
};

}  // namespace slice2mesh::detail
