// SPDX-License-Identifier: MIT
/// @file
/// @brief Local improvement of a filled stack: flips inside of slabs, moves and collapses of vertices in their planes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/harmonize/harmonize.hpp"
#include "slice2mesh/improve/cavities.hpp"
#include "slice2mesh/improve/contour_columns.hpp"
#include "slice2mesh/improve/flips.hpp"
#include "slice2mesh/improve/star_cost.hpp"
#include "slice2mesh/improve/tet_graph.hpp"
#include "slice2mesh/improve/wall_vertices.hpp"
#include "slice2mesh/pipeline/options.hpp"
#include "slice2mesh/triangulate/plane_stack.hpp"

namespace slice2mesh::detail {

/// Improves the tets of all slabs by local operations. All of them keep every tet in its slab and region and every wall
/// vertical (its diagonals may change); that new tets are positive is decided exactly. Tets are flipped, and joined
/// anew in larger cavities; at last vertices are added on edges of planes where that helps. Free vertices move in their
/// plane, vertices that split a contour edge along that edge, contour vertices as columns, within the tolerance
/// (contour_columns.hpp), or not at all.
class MeshOptimizer {
public:
  using Tet = TetGraph::Tet;

  /// `slices`: the regions that the contours were made from, for moves of contours; nullptr: contours stay.
  MeshOptimizer(const Contours& contours, const std::vector<Outline>* slices, PlaneStack& stack, Mesh& mesh,
                const ImproveOptions& options, const Progress& progress)
      : stack_(stack), mesh_(mesh), options_(options), progress_(progress),
        graph_(stack, mesh, contours.grid.pitch, Poll(to_listener_, kPollEvery)),
        walls_(stack, graph_.first(), graph_.points().size(), Poll(to_listener_, kPollEvery)), flips_(graph_, walls_),
        cavities_(graph_, walls_) {
    const std::size_t vertices = graph_.points().size();
    for (const PlaneMesh& plane : stack.meshes)
      for (const char fixed : plane.fixed) kind_.push_back(fixed ? Kind::Fixed : Kind::Free);
    to_listener_();
    find_sliding();
    to_listener_();
    gone_.assign(vertices, kNone);
    // Columns of long elements are worse than kBad, and nothing helps them. Where there is not enough work for all,
    // they would use it up before what can be helped has its turn.
    const double worse_than_column = kWorseThanColumn * kColumnRatio * stack.size / contours.thickness;
    if (options.most_work < kFullWork * double(graph_.size())) {
      bad_ = std::max(kBad, worse_than_column);
      very_bad_ = kVeryBad / kBad * bad_;
    }
    short_of_work_ = options.most_work < kWorkForContours * double(graph_.size());
    if (options.keep_columns) kept_ = std::max(bad_, worse_than_column);
    tried_smooth_.assign(vertices, 0);
    tried_pairs_.assign(vertices, 0);
    if (slices != nullptr) {
      columns_ = std::make_unique<ContourColumns>(contours, *slices, stack, graph_.first(), graph_.points(), gone_,
                                                  to_listener_);
      tried_column_.assign(columns_->size(), 0);
    }
  }
  MeshOptimizer(const MeshOptimizer&) = delete;
  MeshOptimizer& operator=(const MeshOptimizer&) = delete;

  /// All rounds: first for what is bad, then for the rest.
  void run() {
    std::int32_t round = 0;
    for (const bool polishing : {false, true}) {
      floor_ = polishing ? options_.target : std::max(bad_, options_.target);
      // While contours are moved apart, walls stay as they were filled: that leaves fewer small angles.
      flips_.turn_walls(polishing);
      if (polishing)  // what was tried in vain may have had an edge on a wall
        for (std::int32_t t = 0; t < std::int32_t(graph_.size()); ++t) graph_[t].tried_flip = 0;
      const std::int32_t first = round, last = polishing ? options_.rounds : (options_.rounds + 1) / 2;
      std::size_t most = 0;
      for (; round < last && !exhausted(); ++round) {
        share_ = double(round) / double(options_.rounds);
        report(progress_, Stage::Improve, share_);
        // At first only what gains most for its work is polished. Free vertices have their turn before contours, and
        // contours soon rest where nothing is bad.
        const bool begins = polishing && round == first;
        const double flip_floor = begins ? std::max(floor_, kFlippedFirst) : floor_;
        const bool contours = columns_ && round >= kFirstColumnRound && (polishing || !short_of_work_),
                   all = !begins && round < first + kColumnRounds + (polishing ? 1 : 0);
        const double column_floor = std::max({floor_, all ? 0 : bad_, kept_});
        // What is flat has to be flipped before its vertices can do anything; later, smoothing gains most for its work.
        std::size_t done = 0;  // one after the other: the operands of a sum have no order
        if (!polishing) done += flip_round(flip_floor);
        done += smooth_round();
        if (polishing) done += flip_round(flip_floor);
        if (contours) done += column_round(column_floor);
        done += collapse_round();
        // Cavities take most of the time, and gain least for it.
        if (polishing && (round - first) % kReconnectedEvery == 0)
          done += reconnect_round(begins ? kReconnectedFirst : options_.target);
        most = std::max(most, done);
        if (begins || (columns_ && round < kFirstColumnRound)) continue;
        if (double(done) < (polishing ? kPolished : kLittle) * double(most) || done == 0) break;
      }
    }
    rescue();
    share_ = 1;
    report(progress_, Stage::Improve, share_);
    write_back();
  }

  /// The columns of the contours, nullptr where contours stay.
  [[nodiscard]] const ContourColumns* columns() const { return columns_.get(); }

private:
  enum class Kind : std::uint8_t { Fixed, Free, Sliding };
  struct Neighbors {
    std::int32_t previous, next;
  };

  [[nodiscard]] const GridPoint& point(std::int32_t v) const { return graph_.point(v); }

  /// The work is bounded by a count, not by time: the result does not depend on the machine.
  [[nodiscard]] bool exhausted() const { return double(graph_.work()) > most_work_; }
  /// Listens to the caller every so many ratings.
  void poll() {
    if (graph_.work() < next_poll_) return;
    next_poll_ = graph_.work() + kPollEvery;
    report(progress_, Stage::Improve, share_);
  }

  /// What is worse comes first, but by classes only: within a class neighbors in memory stay together.
  [[nodiscard]] int rank(double badness) const { return badness > very_bad_ ? 0 : (badness > bad_ ? 1 : 2); }
  /// Tets above `least` that something has changed at since they were tried in vain, the worst class first.
  /// `tried(t)`: the stamp of when that was.
  template <class Tried, class Try>
  std::size_t for_bad(double least, Tried&& tried, Try&& attempt) {
    std::vector<std::int32_t> bad[3];
    for (std::int32_t t = 0; t < std::int32_t(graph_.size()); ++t)
      if (graph_.badness(t) > least && (tried(t) == 0 || graph_.changed(graph_[t].v) > tried(t)))
        bad[rank(graph_.badness(t))].push_back(t);
    std::size_t done = 0;
    for (const std::vector<std::int32_t>& tets : bad)
      for (const std::int32_t t : tets) {
        poll();
        if (exhausted()) return done;
        if (!(graph_.badness(t) > least)) continue;
        if (attempt(t))
          ++done;
        else
          tried(t) = graph_.stamp();
      }
    return done;
  }
  /// The same with stamps apart from the tets: most tets are never tried that way. What has a number of a tet that is
  /// gone is younger than its stamp.
  template <class Try>
  std::size_t for_bad(double least, std::vector<std::uint32_t>& tried, Try&& attempt) {
    tried.resize(graph_.size(), 0);
    return for_bad(
        least, [&](std::int32_t t) -> std::uint32_t& { return tried[std::size_t(t)]; }, attempt);
  }
  std::size_t flip_round(double floor) {
    return for_bad(
        floor, [&](std::int32_t t) -> std::uint32_t& { return graph_[t].tried_flip; },
        [&](std::int32_t t) { return flips_.flip(t); });
  }

  std::size_t reconnect_round(double floor) {
    return for_bad(floor, tried_cavity_, [&](std::int32_t t) { return cavities_.reconnect(t); });
  }

  // --- moves

  /// Vertices in the interior of contour edges, with the vertices they slide between.
  void find_sliding() {
    Poll listen(to_listener_, kPollEvery);
    for (std::size_t k = 0; k < stack_.meshes.size(); ++k) {
      const PlaneMesh& mesh = stack_.meshes[k];
      const std::int32_t first = graph_.first()[k];
      std::vector<char> state(mesh.vertices.size(), 0);  // 1: seen inside of one chain, 2: fixed
      std::vector<Neighbors> between(mesh.vertices.size(), {kNone, kNone});
      for (const auto* all : {&mesh.below_chain, &mesh.above_chain})
        for (const auto& chain : *all)
          for (std::size_t i = 0; i < chain.size(); ++i) {
            listen();
            const auto v = std::size_t(chain[i]);
            if (i == 0 || i + 1 == chain.size()) {
              state[v] = 2;
              continue;
            }
            const Neighbors n{std::min(chain[i - 1], chain[i + 1]), std::max(chain[i - 1], chain[i + 1])};
            if (state[v] == 0) {
              state[v] = 1;
              between[v] = n;
            } else if (state[v] == 1 && (between[v].previous != n.previous || between[v].next != n.next)) {
              state[v] = 2;
            }
          }
      for (std::size_t v = 0; v < state.size(); ++v) {
        listen();
        if (state[v] != 1) continue;
        kind_[std::size_t(first) + v] = Kind::Sliding;
        slide_[first + std::int32_t(v)] = {first + between[v].previous, first + between[v].next};
      }
    }
  }
  /// Whether a step down a slope gains enough: of a convex cost, at most its length times the slope. Most vertices that
  /// are where they should be have no other sign of it.
  [[nodiscard]] static bool can_gain(double step, double slope, double current) {
    return step * slope > kLeastGain * current;
  }
  /// Is the vertex part of a column that is kept, as no tet around is bad?
  [[nodiscard]] bool stays_in_column(std::int32_t v) const {
    if (!options_.keep_columns) return false;
    const ShortLists::View star = graph_.star(v);
    return std::all_of(star.begin(), star.end(), [&](std::int32_t t) { return graph_.badness(t) <= kept_; }) &&
           graph_.is_in_column(v);
  }
  /// Looks for a better place: along the contour by pattern search, else down the gradient.
  bool smooth(std::int32_t v) {
    if (kind_[std::size_t(v)] == Kind::Fixed || graph_.star(v).empty()) return false;
    if (stays_in_column(v)) return false;
    double current = 0;
    for (const std::int32_t t : graph_.star(v)) current += improvement_cost(graph_.badness(t));
    const double least = (1 - kLeastGain) * current;
    const GridPoint start = point(v);
    star_.take(graph_, v);
    GridPoint best = start;
    if (kind_[std::size_t(v)] == Kind::Sliding) {
      const Neighbors n = slide_.at(v);
      const GridPoint a = point(resolve(n.previous)), b = point(resolve(n.next));
      const double length = distance(a, b);
      if (!(length > 4)) return false;
      const double dx = double(b.x - a.x) / length, dy = double(b.y - a.y) / length;
      double at = (double(start.x - a.x) * dx + double(start.y - a.y) * dy);
      double step = 0.4 * std::min(at, length - at);
      for (int i = 0; i < 8; ++i) {
        bool better = false;
        for (const double s : {step, -step}) {
          const double next = at + s;
          if (!(next > 1) || !(next < length - 1)) continue;
          const GridPoint p{a.x + std::llround(next * dx), a.y + std::llround(next * dy)};
          const double c = star_.at(p.x - start.x, p.y - start.y, current);
          if (!(c < current)) continue;
          current = c;
          best = p;
          at = next;
          better = true;
          break;
        }
        if (!better) step /= 2;
      }
      if (!(current < least)) return false;
      (void)star_.at(best.x - start.x, best.y - start.y, std::numeric_limits<double>::infinity());
    } else {
      // One step down the gradient (forward differences), at first a third of the way to the nearest neighbor. More of
      // them before the neighbors, flips and collapses have their turn take longer and gain less.
      const std::int64_t delta = std::llround(std::max(1.0, kDifference * star_.shortest()));
      const double limit = std::numeric_limits<double>::infinity();
      const double gx = star_.at(delta, 0, limit) - current, gy = star_.at(0, delta, limit) - current;
      const double g = std::hypot(gx, gy);
      if (!std::isfinite(g) || g == 0) return false;
      double step = 0.3 * star_.shortest();
      for (int k = 0; k < kStepSizes && best == start && can_gain(step, g / double(delta), current); ++k, step *= 0.4) {
        const std::int64_t x = -std::llround(step * gx / g), y = -std::llround(step * gy / g);
        if (star_.at(x, y, least) < least) best = {start.x + x, start.y + y};
      }
      if (best == start) return false;
    }
    graph_.set_point(v, best);
    if (!graph_.all_positive(graph_.star(v))) {
      graph_.set_point(v, start);
      return false;
    }
    graph_.new_stamp();
    for (std::size_t i = 0; i < graph_.star(v).size(); ++i) graph_.rated(graph_.star(v)[i], star_.rating(i));
    return true;
  }
  /// Tries moves by class, the worst first, and marks when.
  template <class Try>
  std::size_t try_all(const std::array<std::vector<std::int32_t>, 3>& order, std::vector<std::uint32_t>& tried,
                      Try&& attempt) {
    std::size_t done = 0;
    for (const std::vector<std::int32_t>& rank : order)
      for (const std::int32_t i : rank) {
        poll();
        if (exhausted()) return done;
        if (attempt(i)) ++done;
        tried[std::size_t(i)] = graph_.stamp();
      }
    return done;
  }
  std::size_t smooth_round() {
    // Movable vertices of bad tets; when these had their turn, of almost all: that gains most for its time.
    const double floor = floor_ < kBad ? kSmoothed : floor_;
    std::vector<std::uint8_t> worst(kind_.size(), 3);
    for (std::int32_t t = 0; t < std::int32_t(graph_.size()); ++t)
      if (graph_.badness(t) > floor)
        for (const std::int32_t v : graph_[t].v)
          worst[std::size_t(v)] = std::min(worst[std::size_t(v)], std::uint8_t(rank(graph_.badness(t))));
    std::array<std::vector<std::int32_t>, 3> order;
    for (std::size_t v = 0; v < worst.size(); ++v)
      if (worst[v] < 3 && kind_[v] != Kind::Fixed && graph_.changed(std::int32_t(v)) > tried_smooth_[v])
        order[worst[v]].push_back(std::int32_t(v));
    return try_all(order, tried_smooth_, [&](std::int32_t v) { return smooth(v); });
  }

  // --- moves of contours

  /// What a tet counts when a column moves.
  [[nodiscard]] double cost(double badness) const {
    return at_last_ ? Cavities::sharp_cost(badness) : improvement_cost(badness);
  }

  /// Finds all that moves with a column, and the tets around it.
  void take_column(std::size_t index) {
    columns_->take(index, before_);
    around_.clear();
    for (const auto& [v, p] : before_) around_.insert(around_.end(), graph_.star(v).begin(), graph_.star(v).end());
    std::sort(around_.begin(), around_.end());
    around_.erase(std::unique(around_.begin(), around_.end()), around_.end());
    ratings_.resize(around_.size());
  }
  /// The cost of the tets around the column where it is.
  [[nodiscard]] double cost_around() const {
    double sum = 0;
    for (const std::int32_t t : around_) sum += cost(graph_.badness(t));
    return sum;
  }
  void put(const std::vector<ContourColumns::Place>& places) {
    for (const auto& [v, p] : places) graph_.set_point(v, p);
  }
  /// The cost of the tets around the column if it were at p; infinite if it cannot be there, one is not positive, or it
  /// reaches `limit`. All stays at its new place; else ratings_ has the ratings.
  double column_cost_at(const GridPoint& p, double limit) {
    if (!columns_->places(p, after_)) return std::numeric_limits<double>::infinity();
    put(after_);
    double sum = 0;
    for (std::size_t i = 0; i < around_.size(); ++i) {
      poll();  // a column may stand in any number of slabs
      ratings_[i] = graph_.rate(graph_[around_[i]].v);
      sum += cost(ratings_[i]);
      if (!std::isfinite(ratings_[i]) || !(sum < limit)) return std::numeric_limits<double>::infinity();
    }
    return sum;
  }
  /// The length of the shortest edge of a plane at a column.
  [[nodiscard]] double shortest_edge_at(std::size_t index) const {
    double shortest = std::numeric_limits<double>::infinity();
    for (const std::int32_t v : columns_->vertices(index))
      for (const std::int32_t t : graph_.star(v))
        for (const std::int32_t u : graph_[t].v)
          if (u != v && graph_.plane(u) == graph_.plane(v)) shortest = std::min(shortest, distance(point(v), point(u)));
    return shortest;
  }
  /// Moves a column down the gradient of the cost, or else along its contour.
  bool smooth_column(std::size_t index, ContourColumns::Keep keep) {
    take_column(index);
    const GridPoint from = columns_->place(index);
    const double current = cost_around();
    const double shortest = shortest_edge_at(index);
    const double limit = std::numeric_limits<double>::infinity();
    const double delta = std::max(4 * double(kContourStep), kDifference * shortest);
    const GridPoint along = columns_->along(index);
    double tx = double(along.x), ty = double(along.y);
    const double t = std::hypot(tx, ty);
    if (t > 0) tx /= t, ty /= t;
    double slope = 0;  // along the contour
    if (columns_->on_edge(index)) {
      slope =
          (column_cost_at({from.x + std::llround(delta * tx), from.y + std::llround(delta * ty)}, limit) - current) /
          delta;
      put(before_);
      if (!std::isfinite(slope) || slope == 0) return false;
    } else {
      const double gx = (column_cost_at({from.x + std::llround(delta), from.y}, limit) - current) / delta,
                   gy = (column_cost_at({from.x, from.y + std::llround(delta)}, limit) - current) / delta;
      const double g = std::hypot(gx, gy);
      put(before_);
      if (!std::isfinite(g) || g == 0) return false;
      if (column_descends(index, -gx / g, -gy / g, g, shortest, current, keep)) return true;
      // What must not go down the gradient may go beside it; to look there is worth its time at the worst only.
      if (at_last_ && keep <= ContourColumns::Keep::RoughAreas)
        for (const auto& [c, s] : kBesideGradient)
          for (const double side : {s, -s})
            if (column_descends(index, (side * gy - c * gx) / g, -(side * gx + c * gy) / g, c * g, shortest, current,
                                keep))
              return true;
      slope = gx * tx + gy * ty;
      if (!(std::fabs(slope) > kLeastSlope * g)) return false;
    }
    return column_descends(index, -std::copysign(tx, slope), -std::copysign(ty, slope), std::fabs(slope), shortest,
                           current, keep);
  }
  /// Tries steps in one direction, down a slope, the longest first.
  bool column_descends(std::size_t index, double dx, double dy, double slope, double shortest, double current,
                       ContourColumns::Keep keep) {
    const GridPoint from = columns_->place(index);
    const double least = (1 - kLeastGain) * current;
    double step = std::min(0.3 * shortest, columns_->reach());
    for (int k = 0; k < kStepSizes && can_gain(step, slope, current); ++k, step *= 0.4)
      if (column_goes_to({from.x + std::llround(step * dx), from.y + std::llround(step * dy)}, least, keep))
        return true;
    return false;
  }
  /// Moves the column that was taken to p if that is allowed and its cost is then below `limit`.
  bool column_goes_to(const GridPoint& p, double limit, ContourColumns::Keep keep) {
    if (!(column_cost_at(p, limit) < limit) || !graph_.all_positive(around_) || !columns_->may_move(keep)) {
      put(before_);
      return false;
    }
    columns_->moved();
    graph_.new_stamp();
    for (std::size_t i = 0; i < around_.size(); ++i) graph_.rated(around_[i], ratings_[i]);
    return true;
  }
  /// Looks for a better place all around a column. That takes long, and finds what no step in one direction does: where
  /// the tolerance ends beside it, or the worst element is not the one that steps are made for.
  bool search_column(std::size_t index, ContourColumns::Keep keep) {
    take_column(index);
    const GridPoint from = columns_->place(index);
    const double current = cost_around();
    const double least = (1 - kLeastGain) * current;
    offers_.clear();
    double radius = kFirstRing * columns_->reach();
    for (int ring = 0; ring < kRings; ++ring, radius *= kNextRing)
      for (const auto& [c, s] : kQuadrant) {
        std::array<double, 2> d{c, s};
        for (int quarter = 0; quarter < 4; ++quarter) {
          const GridPoint q{from.x + std::llround(radius * d[0]), from.y + std::llround(radius * d[1])};
          const double reached = column_cost_at(q, least);
          put(before_);
          if (reached < least) offers_.emplace_back(reached, q);
          d = {-d[1], d[0]};
        }
      }
    std::sort(offers_.begin(), offers_.end());
    return std::any_of(offers_.begin(), offers_.end(),
                       [&](const auto& offer) { return column_goes_to(offer.second, least, keep); });
  }
  /// What a move of a column has to keep where the worst element at it is so bad.
  [[nodiscard]] ContourColumns::Keep keep_of(std::size_t column, double badness) const {
    using Keep = ContourColumns::Keep;
    if (badness > very_bad_) return Keep::Angles;
    if (at_last_ && badness > kSharp / kVeryBad * very_bad_ && columns_->slab_count(column) <= kFewSlabs &&
        shortest_edge_at(column) < kBandShare * columns_->reach())
      return Keep::RoughAreas;
    return badness > bad_ ? Keep::Walls : Keep::Areas;
  }
  /// Contours move only where elements are bad after other means had their turn: elsewhere they stay what they are.
  std::size_t column_round(double floor) {
    std::vector<double> worst(columns_->size(), 0);
    for (std::int32_t t = 0; t < std::int32_t(graph_.size()); ++t)
      if (graph_.badness(t) > floor)
        for (const std::int32_t v : graph_[t].v)
          if (columns_->of(v) != kNone) {
            double& w = worst[std::size_t(columns_->of(v))];
            w = std::max(w, graph_.badness(t));
          }
    std::array<std::vector<std::int32_t>, 3> order;
    for (std::size_t i = 0; i < worst.size(); ++i) {
      if (!(worst[i] > 0) || !columns_->movable(i, keep_of(i, worst[i]))) continue;
      std::uint32_t last = 0;
      for (const std::int32_t v : columns_->vertices(i)) last = std::max(last, graph_.changed(v));
      if (last > tried_column_[i]) order[std::size_t(rank(worst[i]))].push_back(std::int32_t(i));
    }
    return try_all(order, tried_column_, [&](std::int32_t i) {
      const auto keep = keep_of(std::size_t(i), worst[std::size_t(i)]);  // what is around may have changed
      return columns_->movable(std::size_t(i), keep) &&
             (smooth_column(std::size_t(i), keep) || (searching_ && search_column(std::size_t(i), keep)));
    });
  }

  // --- insertions

  /// There is always one vertex without tets, the last one, for the next insertion.
  void add_vertex() {
    spare_ = graph_.add_vertex();
    kind_.push_back(Kind::Free);
    gone_.push_back(kNone);
    tried_smooth_.push_back(0);
    tried_pairs_.push_back(0);
    walls_.add_vertex();
    flips_.add_vertex();
    if (columns_) columns_->add_vertex();
  }
  /// Tries to put a vertex on an edge near a tet: what is around is flipped and joined anew after that, and all of it
  /// is taken back if it does not gain.
  bool insert(std::int32_t t) {
    if (spare_ == kNone) add_vertex();
    const std::vector<Cavities::Filling>& offers = cavities_.insertions(t, spare_);
    for (std::size_t i = 0; i < std::min(offers.size(), kInsertionTrials); ++i) {
      const Cavities::Filling& offer = offers[i];
      const bool on_contour = offer.walls[0] != kNone || offer.walls[1] != kNone;
      if (on_contour && !splits_contours(offer)) continue;
      graph_.set_point(spare_, offer.point);
      graph_.put_on_plane_of(spare_, offer.a);
      walls_.put_last(offer.walls);
      kind_.back() = on_contour ? Kind::Sliding : Kind::Free;
      if (on_contour) slide_[spare_] = {offer.a, offer.b};
      graph_.begin_trial();
      graph_.replace(offer.old, offer.tets, offer.cells, offer.badnesses);
      repair();
      double after = 0;
      for (const std::int32_t n : graph_.put()) after += Cavities::sharp_cost(graph_.badness(n));
      const bool gains = after < (1 - kInsertionGain) * graph_.sum_of_taken(Cavities::sharp_cost);
      graph_.end_trial(gains);
      if (!gains) continue;
      if (on_contour) split_contour(offer);
      add_vertex();
      return true;
    }
    return false;
  }
  std::size_t insertion_round(double floor) {
    return for_bad(floor, tried_insertion_, [&](std::int32_t t) { return insert(t); });
  }
  /// Improves what a trial has put there.
  void repair() {
    for (int pass = 0; pass < kRepairPasses; ++pass) {
      bool done = smooth(spare_);
      const std::vector<std::int32_t> tets = graph_.put();
      for (const std::int32_t t : tets)
        if (graph_.badness(t) > kRepaired && (flips_.flip(t) || cavities_.reconnect(t))) done = true;
      if (!done) return;
    }
  }
  /// The vertices of the edge of a plane that runs along a wall.
  [[nodiscard]] std::vector<std::int32_t>& chain_of(std::size_t plane, WallVertices::Side side, std::int32_t wall) {
    PlaneMesh& mesh = stack_.meshes[plane];
    return (side == WallVertices::Above ? mesh.above_chain : mesh.below_chain)[std::size_t(wall)];
  }
  /// Where in a chain the new vertex belongs, between a and b; 0 if these do not follow each other there, as they need
  /// not where a wall is bent.
  [[nodiscard]] std::size_t place_in_chain(const std::vector<std::int32_t>& chain, std::int32_t first,
                                           const Cavities::Filling& at) const {
    for (std::size_t i = 1; i < chain.size(); ++i) {
      const std::int32_t p = resolve(first + chain[i - 1]), q = resolve(first + chain[i]);
      if ((p == at.a && q == at.b) || (p == at.b && q == at.a)) return i;
    }
    return 0;
  }
  [[nodiscard]] bool splits_contours(const Cavities::Filling& at) {
    const auto plane = std::size_t(graph_.plane(at.a));
    for (const WallVertices::Side side : {WallVertices::Below, WallVertices::Above})
      if (at.walls[side] != kNone &&
          place_in_chain(chain_of(plane, side, at.walls[side]), graph_.first()[plane], at) == 0)
        return false;
    return true;
  }
  /// The last vertex is on an edge of contours from now on.
  void split_contour(const Cavities::Filling& at) {
    for (const auto& [end, far] : {std::pair{at.a, at.b}, std::pair{at.b, at.a}})
      if (kind_[std::size_t(end)] == Kind::Sliding) {
        Neighbors& n = slide_.at(end);
        (resolve(n.previous) == far ? n.previous : n.next) = spare_;
      }
    const auto plane = std::size_t(graph_.plane(spare_));
    const std::int32_t first = graph_.first()[plane];
    bool known = !columns_;  // to the columns
    for (const WallVertices::Side side : {WallVertices::Below, WallVertices::Above}) {
      if (at.walls[side] == kNone) continue;
      std::vector<std::int32_t>& chain = chain_of(plane, side, at.walls[side]);
      const std::size_t i = place_in_chain(chain, first, at);
      chain.insert(chain.begin() + std::ptrdiff_t(i), spare_ - first);
      if (std::exchange(known, true)) continue;
      std::size_t from = i - 1, to = i + 1;
      while (columns_->of(first + chain[from]) == kNone) --from;
      while (columns_->of(first + chain[to]) == kNone) ++to;
      columns_->add_split(first + chain[from], first + chain[to]);
    }
  }

  /// Everything once more at the worst elements, each of which counts nearly alone where columns move: a little work,
  /// which is there even where the rounds have used up all. Then places of contours are searched for what is left.
  void rescue() {
    at_last_ = true;
    cavities_.sharpen(true);
    tried_cavity_.clear();
    allow_more(kRescueShare);
    for (const double rescued : {kRescued, kSharp, kLastRescued}) rescue_above(rescued);
    searching_ = true;
    allow_more(kSearchShare);
    rescue_above(kSearched);
  }
  /// Columns have their turn with a new share of the work.
  void allow_more(double share) {
    most_work_ = double(graph_.work()) + (short_of_work_ ? kShareIfShort : 1) * share * options_.most_work;
    std::fill(tried_column_.begin(), tried_column_.end(), 0);
  }
  void rescue_above(double rescued) {
    floor_ = rescued / kVeryBad * very_bad_;
    std::size_t most = 0;
    for (int round = 0; round < kRescueRounds; ++round) {
      std::size_t done = columns_ ? column_round(std::max(floor_, kept_)) : 0;
      done += flip_round(floor_);
      done += reconnect_round(floor_);
      done += smooth_round();
      done += collapse_round();
      // Insertions take long: they come when all else has had its turn, and only for what is worst.
      most = std::max(most, done);
      if (double(done) > kLittle * double(most)) continue;
      done += insertion_round(std::max(floor_, kSharp / kVeryBad * very_bad_));
      if (double(done) <= kDone * double(most)) break;
    }
  }

  // --- collapses

  [[nodiscard]] std::int32_t resolve(std::int32_t v) const {
    while (gone_[std::size_t(v)] != kNone) v = gone_[std::size_t(v)];
    return v;
  }
  /// Moves v into its neighbor u in the plane if that makes the worst tet around better.
  bool collapse(std::int32_t v, std::int32_t u) {
    if (stays_in_column(v)) return false;
    double worst = 0, sum_before = 0, sum_after = 0;
    for (const std::int32_t t : graph_.star(v)) {
      worst = std::max(worst, graph_.badness(t));
      sum_before += graph_.badness(t) - kGoodRatio;
    }
    const double limit = at_last_ ? worst : std::max(worst, kTolerable);
    for (const std::int32_t t : graph_.star(v)) {
      Tet tet = graph_[t].v;
      if (TetGraph::has(tet, u)) continue;
      tet[TetGraph::index_of(tet, v)] = u;
      const double r = graph_.rate(tet);
      sum_after += r - kGoodRatio;
      if (!(r <= limit)) return false;
    }
    if (!(sum_after < sum_before - kCollapseGain)) return false;
    // Positive tets, and volumes balance below and above: nothing is left out or covered twice.
    std::array<Int128, 2> balance{};
    const std::int32_t first = graph_[graph_.star(v).front()].slab;
    for (const std::int32_t t : graph_.star(v)) {
      Tet tet = graph_[t].v;
      Int128& sum = balance[graph_[t].slab == first ? 0 : 1];
      sum -= graph_.volume(tet);
      if (TetGraph::has(tet, u)) continue;
      tet[TetGraph::index_of(tet, v)] = u;
      const Int128 volume = graph_.volume(tet);
      if (volume <= 0) return false;
      sum += volume;
    }
    if (kind_[std::size_t(v)] == Kind::Free && (balance[0] != 0 || balance[1] != 0)) return false;
    graph_.collapse(v, u);
    gone_[std::size_t(v)] = u;
    return true;
  }
  /// Tries the vertices of a tet, the nearest pairs first.
  bool collapse_any(std::int32_t t) {
    const Tet tet = graph_[t].v;
    pairs_.clear();
    for (const std::int32_t v : tet) {
      // All that a collapse of v depends on is around v.
      if (kind_[std::size_t(v)] == Kind::Fixed || graph_.changed(v) <= tried_pairs_[std::size_t(v)]) continue;
      neighbors_.clear();
      if (kind_[std::size_t(v)] == Kind::Sliding) {
        const Neighbors n = slide_.at(v);
        neighbors_ = {resolve(n.previous), resolve(n.next)};
      } else {
        for (const std::int32_t s : graph_.star(v))
          for (const std::int32_t u : graph_[s].v)
            if (u != v && graph_.plane(u) == graph_.plane(v)) neighbors_.push_back(u);
        std::sort(neighbors_.begin(), neighbors_.end());
        neighbors_.erase(std::unique(neighbors_.begin(), neighbors_.end()), neighbors_.end());
      }
      for (const std::int32_t u : neighbors_)
        if (u != v) pairs_.push_back({distance(point(v), point(u)), {v, u}});
    }
    std::sort(pairs_.begin(), pairs_.end());
    for (const auto& [d, vu] : pairs_)
      if (collapse(vu.first, vu.second)) return true;
    for (const std::int32_t v : tet) tried_pairs_[std::size_t(v)] = graph_.stamp();
    return false;
  }
  std::size_t collapse_round() {
    return for_bad(
        std::max(floor_, options_.collapse_above),
        [&](std::int32_t t) -> std::uint32_t& { return graph_[t].tried_collapse; },
        [&](std::int32_t t) { return collapse_any(t); });
  }

  // --- result
  // ---------------------------------------------------------------------------------------------------------
  void write_back() {
    std::vector<std::int32_t> index(kind_.size(), kNone);
    std::int32_t next = 0;
    Poll listen(to_listener_, kPollEvery);
    std::vector<std::vector<std::int32_t>> added(stack_.meshes.size());
    for (std::int32_t v = graph_.first().back(); v < std::int32_t(kind_.size()); ++v)
      if (!graph_.star(v).empty()) added[std::size_t(graph_.plane(v))].push_back(v);
    for (std::size_t k = 0; k < stack_.meshes.size(); ++k) {
      report(progress_, Stage::Improve, 1);
      PlaneMesh& mesh = stack_.meshes[k];
      const std::int32_t first = graph_.first()[k], new_first = next;
      std::vector<GridPoint> vertices;
      std::vector<char> fixed;
      for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        listen();
        const std::size_t global = std::size_t(first) + v;
        if (gone_[global] != kNone) continue;
        index[global] = next++;
        vertices.push_back(graph_.points()[global]);
        fixed.push_back(mesh.fixed[v]);
      }
      for (const std::int32_t v : added[k]) {
        index[std::size_t(v)] = next++;
        vertices.push_back(graph_.point(v));
        fixed.push_back(kind_[std::size_t(v)] == Kind::Free ? 0 : 1);
      }
      mesh.vertices = std::move(vertices);
      mesh.fixed = std::move(fixed);
      const auto local = [&](std::int32_t v) { return index[std::size_t(resolve(first + v))] - new_first; };
      mesh.triangles.clear();
      mesh.sides.clear();
      for (auto* all : {&mesh.below_chain, &mesh.above_chain})
        for (auto& chain : *all) {
          listen(chain.size());
          for (std::int32_t& v : chain) v = local(v);
          chain.erase(std::unique(chain.begin(), chain.end()), chain.end());
        }
    }
    collect_triangles(index);
    graph_.give_back(mesh_, index, listen);
  }
  /// The triangles of the planes are the horizontal faces of tets.
  void collect_triangles(const std::vector<std::int32_t>& index) {
    std::vector<std::int32_t> start(stack_.meshes.size(), 0);
    for (std::size_t k = 1; k < start.size(); ++k)
      start[k] = start[k - 1] + std::int32_t(stack_.meshes[k - 1].vertices.size());
    Poll listen(to_listener_, kPollEvery);
    for (std::int32_t t = 0; t < std::int32_t(graph_.size()); ++t) {
      listen();
      if (!graph_.alive(t)) continue;
      const TetGraph::Element& e = graph_[t];
      for (std::size_t i = 0; i < 4; ++i) {
        const std::int32_t a = e.v[(i + 1) % 4], b = e.v[(i + 2) % 4], c = e.v[(i + 3) % 4];
        if (graph_.plane(a) != graph_.plane(b) || graph_.plane(a) != graph_.plane(c)) continue;
        // Once for both tets at it: for the one below, where there is one.
        const bool above = graph_.plane(e.v[i]) > graph_.plane(a);
        const std::int32_t other = e.across[i];
        if (above && other != kNone) continue;
        std::array<std::int32_t, 3> triangle{index[std::size_t(a)], index[std::size_t(b)], index[std::size_t(c)]};
        for (std::int32_t& v : triangle) v -= start[std::size_t(graph_.plane(a))];
        if (orientation(point(a), point(b), point(c)) < 0) std::swap(triangle[1], triangle[2]);
        std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()), triangle.end());
        PlaneMesh& mesh = stack_.meshes[std::size_t(graph_.plane(a))];
        mesh.triangles.push_back(triangle);
        mesh.sides.emplace_back();
        const Side cell{e.slab, e.region};
        mesh.sides.back()[above ? 1 : 0] = cell;
        if (other != kNone) mesh.sides.back()[1] = {graph_[other].slab, graph_[other].region};
      }
    }
  }

  static constexpr std::int64_t kPollEvery = 1 << 16;  ///< ratings
  static constexpr double kVeryBad = 8;                ///< R/3r
  static constexpr double kBad = 3;                    ///< R/3r; what is above is worked on first; see bad_
  static constexpr double kSmoothed = 1.4;  ///< R/3r; all above is smoothed at last: a little more than that of columns
  static constexpr double kFlippedFirst = 1.9;          ///< R/3r above which tets are flipped when polishing begins
  static constexpr double kReconnectedFirst = 4;        ///< R/3r above which cavities are tried when polishing begins
  static constexpr std::int32_t kReconnectedEvery = 2;  ///< rounds of polishing
  static constexpr double kRescued = 6;                 ///< R/3r above which all have their turn once more at last ...
  static constexpr double kSharp = 3.4;        ///< ... then what is above this, that of an angle of 12 degrees ...
  static constexpr double kLastRescued = 2.2;  ///< ... and this, ...
  static constexpr double kRescueShare = 0.1;  ///< ... with this share of the work allowed, ...
  static constexpr double kDone = 0.05;        ///< of the operations of the best round: there is no more to do
  static constexpr int kRescueRounds = 8;      ///< ... so often at most
  static constexpr std::size_t kInsertionTrials = 3;  ///< at a tet
  static constexpr double kInsertionGain = 0.05;      ///< share of the sharp cost that an insertion has to gain
  static constexpr int kRepairPasses = 3;             ///< after an insertion
  static constexpr double kRepaired = 2;              ///< R/3r above which tets are worked on there
  static constexpr double kShareIfShort = 0.3;        ///< of both shares of work, where there is not enough for all
  static constexpr double kSearched = 3.6;      ///< R/3r, and an angle of 11 degrees: places are searched at last ...
  static constexpr double kSearchShare = 0.15;  ///< ... with this share of the work allowed, ...
  static constexpr int kRings = 7;              ///< ... on so many circles, ...
  static constexpr double kFirstRing = 0.5;     ///< ... the first with this radius, as a share of the reach, ...
  static constexpr double kNextRing = 0.6;      ///< ... the next ones smaller by this, ...
  /// ... in these directions (cosines and sines of 0, 15, ... 75 degrees), and those at right angles to them.
  static constexpr std::array<std::array<double, 2>, 6> kQuadrant{{{1, 0},
                                                                   {0.9659258262890683, 0.25881904510252074},
                                                                   {0.8660254037844387, 0.5},
                                                                   {0.7071067811865476, 0.7071067811865476},
                                                                   {0.5, 0.8660254037844387},
                                                                   {0.25881904510252074, 0.9659258262890683}}};
  static constexpr double kFullWork = 10;         ///< ratings per tet: all have their turn
  static constexpr double kWorkForContours = 25;  ///< ratings per tet: contours have theirs before the polish, too
  static constexpr double kColumnRatio = 0.39;    ///< R/3r of a column over its length in thicknesses, for long ones
  /// Times the R/3r of a column: what is worse, by its angles too, may be helped.
  static constexpr double kWorseThanColumn = 1.75;
  /// Of what contours may move: walls are not bent for what is sharp where no edge is shorter, as that makes no
  /// difference.
  static constexpr double kBandShare = 2.5;
  static constexpr std::size_t kFewSlabs = 4;           ///< walls that go through more are not bent for what is sharp
  static constexpr std::int32_t kFirstColumnRound = 2;  ///< from 0; flips and free vertices have their turn before
  static constexpr std::int32_t kColumnRounds = 2;      ///< of those for all tets in which all contours move
  static constexpr double kLittle = 0.4;       ///< of the operations of the best round: what is bad has had its turn
  static constexpr double kPolished = 0.05;    ///< the same where all is polished
  static constexpr double kDifference = 1e-5;  ///< of the shortest edge: step of forward differences
  static constexpr int kStepSizes = 4;         ///< of a move, each 0.4 of the one before
  /// Cosines and sines of 28, 53 and 74 degrees: directions of columns beside the gradient.
  static constexpr std::array<std::array<double, 2>, 3> kBesideGradient{
      {{15 / 17.0, 8 / 17.0}, {3 / 5.0, 4 / 5.0}, {7 / 25.0, 24 / 25.0}}};
  static constexpr double kLeastSlope = 0.1;    ///< share of the gradient that a move along a contour has to have
  static constexpr double kCollapseGain = 0.1;  ///< what a collapse has to gain in the sum of R/3r ...
  static constexpr double kGoodRatio = 1.3;     ///< ... above this: that of a column
  static constexpr double kTolerable = 6;       ///< R/3r; a collapse may make a tet worse than the worst up to this

  PlaneStack& stack_;
  Mesh& mesh_;
  const ImproveOptions& options_;
  const Progress& progress_;
  double share_ = 0;  // of the rounds
  const std::function<void()> to_listener_ = [this] { report(progress_, Stage::Improve, share_); };
  TetGraph graph_;
  WallVertices walls_;
  Flips flips_;
  Cavities cavities_;
  std::vector<Kind> kind_;  // #V
  std::unordered_map<std::int32_t, Neighbors> slide_;
  std::vector<std::int32_t> gone_;  // #V, the vertex it went into
  std::unique_ptr<ContourColumns> columns_;
  double bad_ = kBad, very_bad_ = kVeryBad;  // R/3r
  bool short_of_work_ = false;               // contours move only once everything has been smoothed
  double kept_ = 0;                          // R/3r; where none is worse, vertices of vertical edges stay
  double floor_ = kBad;                      // R/3r, of what is worked on
  double most_work_ = options_.most_work;    // see exhausted()
  std::int32_t spare_ = kNone;               // a vertex without tets, see add_vertex()
  bool at_last_ = false;                     // what is worst counts alone, nearly; see rescue()
  bool searching_ = false;                   // places of columns; see rescue()
  std::int64_t next_poll_ = 0;
  std::vector<std::uint32_t> tried_smooth_, tried_pairs_, tried_column_;  // stamps
  std::vector<std::uint32_t> tried_cavity_, tried_insertion_;             // #T, the same
  StarCost star_;                                                         // of the vertex in question
  std::vector<std::int32_t> neighbors_;
  std::vector<std::pair<double, std::pair<std::int32_t, std::int32_t>>> pairs_;
  std::vector<std::int32_t> around_;                   // tets around the column in question ...
  std::vector<double> ratings_;                        // ... and their ratings
  std::vector<std::pair<double, GridPoint>> offers_;   // places for it, with their costs
  std::vector<ContourColumns::Place> before_, after_;  // where what moves with it was, and where it would go
};

}  // namespace slice2mesh::detail
