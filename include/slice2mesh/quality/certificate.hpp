// SPDX-License-Identifier: MIT
/// @file
/// @brief The certificate of a mesh: checks that it fills the slabs of its complex, exactly and once.
///
/// For every slab and region the tetrahedra are positive, every face is shared by two of them that lie on its two
/// sides, or by one whose outward face is a facet of the complex. So the boundary of their sum is the boundary of the
/// cell, and a sum of positive tetrahedra with that boundary covers every point of the cell once and no other point.
/// All of this is decided on the coordinates of the mesh, without rounding.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/plc/plane_cover.hpp"
#include "slice2mesh/plc/plc_checks.hpp"

namespace slice2mesh {

/// What `certify` found. The checks, in this order:
/// `complex`, `no_overlap`, `structure`, `positive`, `one_slab`, `volume`, `interface_triangles`, `faces`, `skin`,
/// `no_duplicates`, `no_orphans`; the later ones are left out where the complex itself is not usable.
struct Certificate {
  /// One per name above, in that order.
  std::vector<CertificateCheck> checks;
  double volume = 0;           ///< mm^3, sum of the tetrahedra
  double expected_volume = 0;  ///< mm^3, sum of area x height
  /// Number of those of the mesh.
  std::int64_t tets = 0;
  /// Number of those of the mesh.
  std::int64_t vertices = 0;
  std::int64_t facets = 0;  ///< number of those of the complex

  /// True if there are checks and all of them passed.
  [[nodiscard]] bool passed() const {
    return !checks.empty() &&
           std::all_of(checks.begin(), checks.end(), [](const CertificateCheck& c) { return c.passed; });
  }
  /// The check of that name, or nullptr.
  [[nodiscard]] const CertificateCheck* find(const std::string& name) const {
    for (const CertificateCheck& c : checks)
      if (c.name == name) return &c;
    return nullptr;
  }
};

/// Tolerances of `certify`.
struct CertifyOptions {
  /// Relative difference (a ratio) of volumes that is put down to rounding: of the whole mesh, and of cells with
  /// vertices off the grid. Volumes on the grid are compared as integers.
  double volume_tolerance = 1e-12;
  std::size_t max_offenders = 3;  ///< how many offenders of a check are named
};

namespace detail {

/// An exact sum of doubles: components that do not overlap, smallest first (Shewchuk, "Adaptive precision
/// floating-point arithmetic and fast robust geometric predicates", DCG 18 (1997) 305-363). Precondition: no overflow,
/// no underflow.
class Expansion {
public:
  Expansion() = default;
  explicit Expansion(double v) { add(v); }
  void add(double v) {
    std::vector<double> next;
    next.reserve(parts_.size() + 1);
    for (const double p : parts_) {
      const double sum = v + p;
      const double virtual_p = sum - v;
      const double error = (v - (sum - virtual_p)) + (p - virtual_p);
      if (error != 0) next.push_back(error);
      v = sum;
    }
    if (v != 0) next.push_back(v);
    parts_ = std::move(next);
  }
  void add(const Expansion& other) {
    for (const double p : other.parts_) add(p);
  }
  [[nodiscard]] Expansion times(const Expansion& other) const {
    Expansion result;
    for (const double p : parts_)
      for (const double q : other.parts_) {
        const double product = p * q;
        result.add(std::fma(p, q, -product));
        result.add(product);
      }
    return result;
  }
  [[nodiscard]] Expansion negated() const {
    Expansion result = *this;
    for (double& p : result.parts_) p = -p;
    return result;
  }
  [[nodiscard]] int sign() const { return parts_.empty() ? 0 : (parts_.back() > 0 ? 1 : -1); }

private:
  std::vector<double> parts_;
};

/// (b - a) x (c - a) . (d - a), rounded, and its exact sign. Precondition: finite coordinates whose differences, where
/// they are not zero, have absolute values between 1e-80 and 1e80.
struct ExactVolume {
  double value = 0;
  int sign = 0;
};
[[nodiscard]] inline ExactVolume exact_volume(const std::array<double, 3>& a, const std::array<double, 3>& b,
                                              const std::array<double, 3>& c, const std::array<double, 3>& d) {
  std::array<std::array<double, 3>, 3> m{};
  for (std::size_t k = 0; k < 3; ++k) m[0][k] = b[k] - a[k], m[1][k] = c[k] - a[k], m[2][k] = d[k] - a[k];
  const auto term = [&](std::size_t i, std::size_t j, std::size_t k) { return m[0][i] * (m[1][j] * m[2][k]); };
  const double value = term(0, 1, 2) - term(0, 2, 1) + term(1, 2, 0) - term(1, 0, 2) + term(2, 0, 1) - term(2, 1, 0);
  const double magnitude = std::fabs(term(0, 1, 2)) + std::fabs(term(0, 2, 1)) + std::fabs(term(1, 2, 0)) +
                           std::fabs(term(1, 0, 2)) + std::fabs(term(2, 0, 1)) + std::fabs(term(2, 1, 0));
  constexpr double kFilter =
      32 * 0x1p-53;  // relative: three differences, two products and five sums of one rounding each
  if (std::fabs(value) > kFilter * magnitude) return {value, value > 0 ? 1 : -1};
  std::array<std::array<Expansion, 3>, 3> e;
  for (std::size_t k = 0; k < 3; ++k) {
    std::size_t row = 0;
    for (const auto* p : {&b, &c, &d}) {
      e[row][k].add((*p)[k]);
      e[row++][k].add(-a[k]);
    }
  }
  Expansion sum;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    sum.add(e[0][i].times(e[1][j].times(e[2][k])));
    sum.add(e[0][i].times(e[1][k].times(e[2][j])).negated());
  }
  return {value, sum.sign()};
}

class Certifier {
public:
  Certifier(const Mesh& mesh, const Plc& plc, const CertifyOptions& options, const Progress& progress)
      : mesh_(mesh), plc_(plc), options_(options), progress_(progress) {}

  [[nodiscard]] Certificate run() {
    Certificate result;
    result.tets = static_cast<std::int64_t>(mesh_.tets.size());
    result.vertices = static_cast<std::int64_t>(mesh_.vertices.size());
    result.facets = static_cast<std::int64_t>(plc_.facets.size());
    CheckNotes complex = notes();
    check_complex(plc_, complex, poll_);
    if (!plc_.has_inner_faces) complex.offend([] { return std::string("the complex is its outer skin alone"); });
    result.checks.push_back(complex.check("complex", "indices, labels and sides of the complex are sound", "defects"));
    if (complex.count() > 0) return result;
    poll_();
    CheckNotes overlap = notes();
    Poll listen(poll_, 1 << 16);
    check_no_overlap(plc_, overlap, listen);
    result.checks.push_back(
        overlap.check("no_overlap", "facets of one plane do not overlap or cross", "planes with overlaps"));
    poll_();
    check_structure();
    poll_();
    read_vertices();
    poll_();
    match_vertices();
    poll_();
    const SlabFacets facets = facets_by_slab(plc_, poll_);
    local_.assign(mesh_.vertices.size(), kNone);
    used_.assign(mesh_.vertices.size(), 0);
    for (std::size_t s = 0; s < plc_.slabs.size(); ++s) {
      share_ = double(s) / double(plc_.slabs.size());
      poll_();
      certify_slab(static_cast<std::int32_t>(s), facets.facets.data() + facets.start[s],
                   facets.facets.data() + facets.start[s + 1]);
    }
    for (std::size_t v = 0; v < used_.size(); ++v)
      if (!used_[v]) orphans_.offend([v] { return "vertex " + std::to_string(v); });
    result.volume = volume_.value();
    result.expected_volume = expected_.value();
    finish(result);
    return result;
  }

private:
  [[nodiscard]] CheckNotes notes() const { return CheckNotes(options_.max_offenders); }
  [[nodiscard]] static std::string place(std::int32_t slab, std::int64_t tet) {
    return "slab " + std::to_string(slab) + " tet " + std::to_string(tet);
  }

  void check_structure() {
    const std::size_t count = mesh_.tets.size();
    const auto text = [](const char* what) { return [what] { return std::string(what); }; };
    if (count == 0) structure_.offend(text("no tets"));
    if (mesh_.tet_slab.size() != count) structure_.offend(text("#tet_slab is not #tets"));
    if (mesh_.tet_region.size() != count) structure_.offend(text("#tet_region is not #tets"));
    if (mesh_.regions.size() != plc_.regions.size()) structure_.offend(text("#regions is not that of the complex"));
    bool slabs = mesh_.slabs.size() == plc_.slabs.size();
    for (std::size_t s = 0; slabs && s < plc_.slabs.size(); ++s)
      slabs = mesh_.slabs[s].z_low == plc_.slabs[s].z_low && mesh_.slabs[s].z_high == plc_.slabs[s].z_high;
    if (!slabs) structure_.offend(text("slabs are not those of the complex"));
    Poll listen(poll_, 1 << 16);
    for (std::size_t v = 0; v < mesh_.vertices.size(); ++v) {
      listen();
      for (const double c : mesh_.vertices[v])
        if (!std::isfinite(c)) {
          structure_.offend([v] { return "vertex " + std::to_string(v) + " is not finite"; });
          break;
        }
    }
    for (std::size_t f = 0; f < mesh_.facets.size(); ++f) {
      listen();
      for (const std::int32_t v : mesh_.facets[f].vertices)
        if (!in_range(v, mesh_.vertices.size())) {
          structure_.offend([f] { return "facet " + std::to_string(f); });
          break;
        }
    }
    // Sound tets by slab, in their order.
    start_.assign(plc_.slabs.size() + 1, 0);
    const auto sound = [&](std::size_t t) {
      if (t >= mesh_.tet_slab.size() || t >= mesh_.tet_region.size()) return false;
      const auto& tet = mesh_.tets[t];
      for (std::size_t i = 0; i < 4; ++i) {
        if (!in_range(tet[i], mesh_.vertices.size())) return false;
        for (std::size_t j = 0; j < i; ++j)
          if (tet[i] == tet[j]) return false;
      }
      return in_range(mesh_.tet_slab[t], plc_.slabs.size()) && in_range(mesh_.tet_region[t], plc_.regions.size());
    };
    for (std::size_t t = 0; t < count; ++t) {
      listen();
      if (sound(t))
        ++start_[static_cast<std::size_t>(mesh_.tet_slab[t]) + 1];
      else
        structure_.offend([t] { return "tet " + std::to_string(t); });
    }
    for (std::size_t s = 0; s < plc_.slabs.size(); ++s) start_[s + 1] += start_[s];
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    order_.resize(start_.back());
    for (std::size_t t = 0; t < count; ++t) {
      listen();
      if (structure_.count() == 0 || sound(t))
        order_[next[static_cast<std::size_t>(mesh_.tet_slab[t])]++] = static_cast<std::int32_t>(t);
    }
  }

  /// Positions on the grid and planes, where vertices lie on them exactly.
  void read_vertices() {
    points_.resize(mesh_.vertices.size());
    plane_.assign(mesh_.vertices.size(), kNone);
    std::size_t hint = 0;
    Poll listen(poll_, 1 << 16);
    for (std::size_t v = 0; v < mesh_.vertices.size(); ++v) {
      listen();
      const auto& p = mesh_.vertices[v];
      const double x = p[0] / plc_.grid.pitch, y = p[1] / plc_.grid.pitch;  // exact: the pitch is a power of two
      constexpr double kExact = 0x1p53;
      bool on_grid = std::fabs(x) <= kExact && std::fabs(y) <= kExact && x == std::floor(x) && y == std::floor(y) &&
                     x * plc_.grid.pitch == p[0] && y * plc_.grid.pitch == p[1];
      if (on_grid) {
        const GridPoint g{static_cast<std::int64_t>(x) - plc_.grid.origin_x,
                          static_cast<std::int64_t>(y) - plc_.grid.origin_y};
        on_grid = is_on_grid(g);
        points_[v] = g;
      }
      if (!(hint < plc_.planes.size() && plc_.planes[hint] == p[2]))
        hint = static_cast<std::size_t>(std::lower_bound(plc_.planes.begin(), plc_.planes.end(), p[2]) -
                                        plc_.planes.begin());
      const bool on_plane = hint < plc_.planes.size() && plc_.planes[hint] == p[2];
      if (on_grid && on_plane)
        plane_[v] = static_cast<std::int32_t>(hint);
      else
        ++off_grid_;
    }
  }

  /// Which vertex of the complex is which of the mesh: the same index, or the same position.
  void match_vertices() {
    const auto same = [&](std::size_t mesh, std::size_t plc) {
      return plane_[mesh] != kNone && plane_[mesh] == plc_.vertex_plane[plc] && points_[mesh] == plc_.vertices[plc];
    };
    mesh_of_.assign(plc_.vertices.size(), kNone);
    plc_of_.assign(mesh_.vertices.size(), kNone);
    Poll listen(poll_, 1 << 16);
    std::vector<std::size_t> left;
    for (std::size_t v = 0; v < plc_.vertices.size(); ++v) {
      listen();
      if (v < mesh_.vertices.size() && same(v, v))
        mesh_of_[v] = plc_of_[v] = static_cast<std::int32_t>(v);
      else
        left.push_back(v);
    }
    if (left.empty()) return;
    struct Place {
      std::int32_t plane;
      GridPoint p;
      std::int32_t vertex;
      bool operator<(const Place& o) const {
        return plane != o.plane ? plane < o.plane : (p != o.p ? p < o.p : vertex < o.vertex);
      }
    };
    std::vector<Place> places;
    for (std::size_t v = 0; v < plc_of_.size(); ++v)
      if (plc_of_[v] == kNone && plane_[v] != kNone)
        places.push_back({plane_[v], points_[v], static_cast<std::int32_t>(v)});
    sort_listening(places.begin(), places.end(), listen);
    for (const std::size_t v : left) {
      listen(16);
      const Place wanted{plc_.vertex_plane[v], plc_.vertices[v], kNone};
      const auto it = std::lower_bound(places.begin(), places.end(), wanted);
      if (it == places.end() || it->plane != wanted.plane || it->p != wanted.p) continue;
      mesh_of_[v] = it->vertex;
      plc_of_[static_cast<std::size_t>(it->vertex)] = static_cast<std::int32_t>(v);
    }
  }

  /// A face of a tet, or a facet of the complex, in local vertex numbers.
  struct Face {
    std::int32_t mid, high;  // the lowest is the bucket
    std::int32_t owner;      // tet >= 0: that tet of the mesh; else facet -1 - owner of the complex
    std::int32_t odd;        // orientation: is (low, mid, high) the reverse of the outward one?
  };
  [[nodiscard]] static bool sort_three(std::int32_t& a, std::int32_t& b, std::int32_t& c) {
    bool odd = false;
    if (b < a) std::swap(a, b), odd = !odd;
    if (c < b) std::swap(b, c), odd = !odd;
    if (b < a) std::swap(a, b), odd = !odd;
    return odd;
  }
  static constexpr std::array<std::array<std::size_t, 3>, 4> kOutward{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

  void certify_slab(std::int32_t slab, const std::int32_t* facets_begin, const std::int32_t* facets_end) {
    const auto s = static_cast<std::size_t>(slab);
    const Slab& range = plc_.slabs[s];
    const double height = range.z_high - range.z_low;
    const std::int32_t low_plane = plc_.slab_planes[s][0], high_plane = plc_.slab_planes[s][1];
    Poll listen(poll_, 1 << 13);
    SlabWalls walls(plc_, facets_begin, facets_end, listen);

    // Local numbers, volumes.
    std::vector<std::int32_t> global;
    const auto local = [&](std::int32_t v) {
      std::int32_t& index = local_[static_cast<std::size_t>(v)];
      if (index == kNone) {
        index = static_cast<std::int32_t>(global.size());
        global.push_back(v);
        used_[static_cast<std::size_t>(v)] = 1;
      }
      return index;
    };
    std::vector<Int128> exact(plc_.regions.size(), 0);         // 6 V / height in squared pitches
    std::vector<CompensatedSum> rounded(plc_.regions.size());  // 6 V in mm^3, of tets off the grid
    std::vector<char> off_grid(plc_.regions.size(), 0);
    const std::size_t first = start_[s], last = start_[s + 1];
    for (std::size_t i = first; i < last; ++i) {
      listen();
      const auto t = static_cast<std::size_t>(order_[i]);
      const auto& tet = mesh_.tets[t];
      const auto region = static_cast<std::size_t>(mesh_.tet_region[t]);
      std::array<bool, 4> top{};
      bool on_planes = true;
      std::size_t tops = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        (void)local(tet[k]);
        const std::int32_t plane = plane_[static_cast<std::size_t>(tet[k])];
        top[k] = plane == high_plane;
        tops += top[k] ? 1U : 0U;
        on_planes = on_planes && (plane == low_plane || top[k]);
      }
      if (on_planes) {
        const Int128 value = two_plane_volume(tet, top, tops);
        if (value <= 0)
          positive_.offend([&] { return place(slab, std::int64_t(t)) + (value == 0 ? " is flat" : " is inverted"); });
        exact[region] += value;
        continue;
      }
      bool inside = true;
      for (std::size_t k = 0; k < 4; ++k) {
        const double z = mesh_.vertices[static_cast<std::size_t>(tet[k])][2];
        inside = inside && z >= range.z_low && z <= range.z_high;
      }
      if (!inside) one_slab_.offend([&] { return place(slab, std::int64_t(t)); });
      off_grid[region] = 1;
      const auto corner = [&](std::size_t k) -> const std::array<double, 3>& {
        return mesh_.vertices[static_cast<std::size_t>(tet[k])];
      };
      const ExactVolume value = exact_volume(corner(0), corner(1), corner(2), corner(3));
      if (value.sign <= 0)
        positive_.offend(
            [&] { return place(slab, std::int64_t(t)) + (value.sign == 0 ? " is flat" : " is inverted"); });
      rounded[region].add(value.value);
    }
    compare_volumes(slab, height, cell_areas(plc_, slab, facets_begin, facets_end, walls), exact, rounded, off_grid);

    // Faces by their lowest vertex: those of the tets, and the facets of the complex.
    const auto for_each_face = [&](auto&& f) {
      for (std::size_t i = first; i < last; ++i) {
        listen();
        const auto& tet = mesh_.tets[static_cast<std::size_t>(order_[i])];
        std::array<std::int32_t, 4> v{};
        for (std::size_t k = 0; k < 4; ++k) v[k] = local_[static_cast<std::size_t>(tet[k])];
        for (const auto& face : kOutward) {
          std::int32_t a = v[face[0]], b = v[face[1]], c = v[face[2]];
          const bool odd = sort_three(a, b, c);
          f(a, Face{b, c, order_[i], odd ? 1 : 0});
        }
      }
      for (const std::int32_t* it = facets_begin; it != facets_end; ++it) {
        listen();
        const Facet& facet = plc_.facets[static_cast<std::size_t>(*it)];
        std::array<std::int32_t, 3> v{};
        bool known = true;
        for (std::size_t k = 0; k < 3; ++k) {
          const std::int32_t m = mesh_of_[static_cast<std::size_t>(facet.vertices[k])];
          v[k] = m == kNone ? kNone : local_[static_cast<std::size_t>(m)];
          known = known && v[k] != kNone;
        }
        if (!known) continue;
        bool odd = sort_three(v[0], v[1], v[2]);
        // From above its front is a slab's bottom.
        if (facet.label == FacetLabel::Interface && facet.front.slab == slab) odd = !odd;
        f(v[0], Face{v[1], v[2], -1 - *it, odd ? 1 : 0});
      }
    };
    std::vector<std::size_t> start(global.size() + 1, 0);
    for_each_face([&](std::int32_t low, const Face&) { ++start[static_cast<std::size_t>(low) + 1]; });
    for (std::size_t v = 0; v < global.size(); ++v) start[v + 1] += start[v];
    faces_.resize(start.back());
    {
      std::vector<std::size_t> next(start.begin(), start.end() - 1);
      for_each_face([&](std::int32_t low, const Face& face) { faces_[next[static_cast<std::size_t>(low)]++] = face; });
    }
    for (const std::int32_t* it = facets_begin; it != facets_end; ++it) {
      listen();
      // Facets with a vertex that no tet of the slab has cannot be faces.
      const Facet& facet = plc_.facets[static_cast<std::size_t>(*it)];
      bool known = true;
      for (const std::int32_t v : facet.vertices) {
        const std::int32_t m = mesh_of_[static_cast<std::size_t>(v)];
        known = known && m != kNone && local_[static_cast<std::size_t>(m)] != kNone;
      }
      if (!known) missing_facet(slab, *it);
    }
    for (std::size_t v = 0; v < global.size(); ++v) {
      const auto begin = faces_.begin() + std::ptrdiff_t(start[v]), end = faces_.begin() + std::ptrdiff_t(start[v + 1]);
      sort_listening(begin, end, listen, [](const Face& f, const Face& g) {
        if (f.mid != g.mid) return f.mid < g.mid;
        return f.high != g.high ? f.high < g.high : f.owner > g.owner;
      });
      for (auto i = begin; i != end;) {
        auto j = i;
        while (j != end && j->mid == i->mid && j->high == i->high) ++j;
        const std::array<std::int32_t, 3> vertices{global[v], global[static_cast<std::size_t>(i->mid)],
                                                   global[static_cast<std::size_t>(i->high)]};
        check_face(slab, vertices, &*i, &*i + (j - i), walls);
        i = j;
      }
    }
    for (const SlabWalls::Wall& wall : walls.walls()) {
      const std::int64_t wanted = wall.facets * (wall.front.empty() ? 1 : 2);
      if (wall.faces != wanted)
        skin_.offend([&] {
          return "slab " + std::to_string(slab) + " wall " + std::to_string(wall.id) + " has " +
                 std::to_string(wall.faces) + " faces instead of " + std::to_string(wanted);
        });
    }
    for (const std::int32_t v : global) local_[static_cast<std::size_t>(v)] = kNone;
  }

  /// 6 V / height of a tet with its vertices on the two planes of its slab, in squared pitches; exact.
  [[nodiscard]] Int128 two_plane_volume(const std::array<std::int32_t, 4>& tet, const std::array<bool, 4>& top,
                                        std::size_t tops) const {
    const auto point = [&](std::size_t k) -> const GridPoint& { return points_[static_cast<std::size_t>(tet[k])]; };
    if (tops == 1 || tops == 3) {
      // The face opposite to the lone vertex; outward is down if that vertex is on top.
      std::size_t lone = 0;
      while (top[lone] != (tops == 1)) ++lone;
      const auto& face = kOutward[lone];
      const Int128 area = cross(point(face[0]), point(face[1]), point(face[2]));
      return tops == 1 ? -area : area;
    }
    if (tops != 2) return 0;
    std::array<std::size_t, 4> k{};
    std::size_t lows = 0, highs = 2;
    for (std::size_t i = 0; i < 4; ++i) k[top[i] ? highs++ : lows++] = i;
    const GridPoint &a = point(k[0]), &b = point(k[1]), &c = point(k[2]), &d = point(k[3]);
    const Int128 value = Int128(d.x - c.x) * (b.y - a.y) - Int128(d.y - c.y) * (b.x - a.x);
    std::size_t inversions = 0;
    for (std::size_t i = 0; i < 2; ++i)
      for (std::size_t j = 2; j < 4; ++j) inversions += k[i] > k[j] ? 1U : 0U;
    return inversions % 2 == 0 ? value : -value;
  }

  void compare_volumes(std::int32_t slab, double height, const CellAreas& areas, const std::vector<Int128>& exact,
                       const std::vector<CompensatedSum>& rounded, const std::vector<char>& off_grid) {
    const double unit = plc_.grid.pitch * plc_.grid.pitch * height / 6;
    for (std::size_t r = 0; r < exact.size(); ++r) {
      // 6 V / height = 3 x (twice the area), the mean of bottom and top; doubled once more to stay whole.
      const Int128 wanted = 3 * (areas.bottom[r] + areas.top[r]);
      const double wanted_mm = double(wanted) / 2 * unit;
      double volume_mm = double(exact[r]) * unit;
      expected_.add(wanted_mm);
      bool good = false;
      if (off_grid[r] == 0) {
        const Int128 difference = 2 * exact[r] - wanted;
        good = (difference < 0 ? -difference : difference) <= 12 * areas.bend[r];
      } else {
        volume_mm += rounded[r].value() / 6;
        good = std::fabs(volume_mm - wanted_mm) <=
               options_.volume_tolerance * wanted_mm + 6 * double(areas.bend[r]) * unit;
      }
      volume_.add(volume_mm);
      bend_ += 6 * double(areas.bend[r]) * unit;
      if (!good)
        cells_.offend([&] {
          return "slab " + std::to_string(slab) + " region " + std::to_string(r) + ": " + number_text(volume_mm) +
                 " mm^3 instead of " + number_text(wanted_mm);
        });
    }
  }

  void missing_facet(std::int32_t slab, std::int32_t f) {
    const Facet& facet = plc_.facets[static_cast<std::size_t>(f)];
    if (facet.label == FacetLabel::Wall || facet.label == FacetLabel::InnerWall) return;  // counted per wall
    interface_.offend([&] {
      return "facet " + std::to_string(f) + " (" + to_string(facet.label) + ") is no face in slab " +
             std::to_string(slab);
    });
  }

  [[nodiscard]] bool same_tet(std::int32_t t, std::int32_t u) const {
    auto a = mesh_.tets[static_cast<std::size_t>(t)], b = mesh_.tets[static_cast<std::size_t>(u)];
    std::sort(a.begin(), a.end());
    std::sort(b.begin(), b.end());
    return a == b;
  }

  /// All tets of the slab (first) and facets (then) on one triangle, given by mesh vertices in the order of `odd`.
  void check_face(std::int32_t slab, const std::array<std::int32_t, 3>& vertices, const Face* begin, const Face* end,
                  SlabWalls& walls) {
    const Face* tets_end = begin;
    while (tets_end != end && tets_end->owner >= 0) ++tets_end;
    const auto tets = tets_end - begin;
    const auto facets = end - tets_end;
    if (tets == 2 && facets == 0 && begin[0].odd != begin[1].odd && region(begin[0].owner) == region(begin[1].owner)) {
      ++inner_;  // nearly all of them
      return;
    }
    const std::int32_t facet_index = facets > 0 ? -1 - tets_end->owner : kNone;
    if (tets == 0) {
      for (const Face* f = tets_end; f != end; ++f) missing_facet(slab, -1 - f->owner);
      return;
    }
    const std::int32_t t = begin->owner;
    if (tets > 2 || (tets == 2 && begin[0].odd == begin[1].odd)) {
      for (const Face* f = begin; f != tets_end; ++f)
        for (const Face* g = f + 1; g != tets_end; ++g)
          if (same_tet(f->owner, g->owner)) {
            duplicates_.offend([&] { return place(slab, f->owner) + " and " + std::to_string(g->owner); });
          }
      faces_bad_.offend(
          [&] { return place(slab, t) + " overlaps tet " + std::to_string(begin[1].owner) + " at a face"; });
      return;
    }
    if (facets > 1) {
      faces_bad_.offend(
          [&] { return place(slab, t) + ": " + std::to_string(facets) + " facets of the complex on one face"; });
      return;
    }
    const Facet* facet = facets == 1 ? &plc_.facets[static_cast<std::size_t>(facet_index)] : nullptr;
    const bool wall = facet != nullptr && (facet->label == FacetLabel::Wall || facet->label == FacetLabel::InnerWall);
    if (tets == 2) {
      check_inner_wall(slab, vertices, begin, tets_end, facet, walls);
      return;
    }
    // One tet: a horizontal facet or a wall.
    const Side side{slab, region(t)};
    if (facet != nullptr && !wall) {
      const Side& wanted =
          facet->label == FacetLabel::Interface && facet->front.slab == slab ? facet->front : facet->back;
      if (wanted == side && begin->odd == tets_end->odd)
        ++horizontal_;
      else
        interface_.offend(
            [&] { return place(slab, t) + " is on the wrong side of facet " + std::to_string(facet_index); });
      return;
    }
    const std::int32_t p0 = plane_[static_cast<std::size_t>(vertices[0])],
                       p1 = plane_[static_cast<std::size_t>(vertices[1])],
                       p2 = plane_[static_cast<std::size_t>(vertices[2])];
    if (facet == nullptr && p0 != kNone && p0 == p1 && p1 == p2) {
      interface_.offend([&] { return place(slab, t) + " has a horizontal face that is no facet of the complex"; });
      return;
    }
    if (facet != nullptr && facet->label == FacetLabel::Wall) {
      if (facet->back == side && begin->odd == tets_end->odd) {
        ++wall_faces_;
        ++walls.find(facet->wall)->faces;
      } else {
        skin_.offend([&] { return place(slab, t) + " is on the wrong side of facet " + std::to_string(facet_index); });
      }
      return;
    }
    if (facet == nullptr && on_wall(vertices, begin->odd, side, {}, walls)) {
      ++wall_faces_;
      ++other_diagonals_;
      return;
    }
    if (facet != nullptr)
      faces_bad_.offend([&] { return place(slab, t) + " has no neighbor across an inner wall"; });
    else
      faces_bad_.offend([&] { return place(slab, t) + " has a face without neighbor that is not on the skin"; });
  }

  void check_inner_wall(std::int32_t slab, const std::array<std::int32_t, 3>& vertices, const Face* begin,
                        const Face* tets_end, const Facet* facet, SlabWalls& walls) {
    const std::int32_t r0 = region(begin[0].owner), r1 = region(begin[1].owner);
    if (facet == nullptr) {
      // Two regions (one was dealt with): on an inner wall with another diagonal.
      if (on_wall(vertices, begin[0].odd, {slab, r0}, {slab, r1}, walls) &&
          on_wall(vertices, begin[1].odd, {slab, r1}, {slab, r0}, walls)) {
        ++inner_;
        ++other_diagonals_;
        return;
      }
      faces_bad_.offend([&] {
        return place(slab, begin[0].owner) + " and " + std::to_string(begin[1].owner) +
               " of different regions touch off the inner walls";
      });
      return;
    }
    const Face& back = begin[0].odd == tets_end->odd ? begin[0] : begin[1];
    const Face& front = begin[0].odd == tets_end->odd ? begin[1] : begin[0];
    if (facet->label == FacetLabel::InnerWall && facet->back == Side{slab, region(back.owner)} &&
        facet->front == Side{slab, region(front.owner)}) {
      ++inner_;
      walls.find(facet->wall)->faces += 2;
      return;
    }
    faces_bad_.offend([&] {
      return place(slab, begin[0].owner) + " and " + std::to_string(begin[1].owner) + " lie on both sides of facet " +
             std::to_string(-1 - tets_end->owner) + " (" + to_string(facet->label) + ")";
    });
  }

  /// Is the outward face of a tet of the cell `own` a triangle of one wall between these cells, the right way round?
  [[nodiscard]] bool on_wall(const std::array<std::int32_t, 3>& vertices, std::int32_t odd, const Side& own,
                             const Side& beyond, SlabWalls& walls) const {
    std::array<std::int32_t, 3> v{};
    for (std::size_t k = 0; k < 3; ++k) v[k] = plc_of_[static_cast<std::size_t>(vertices[k])];
    if (v[0] == kNone || v[1] == kNone || v[2] == kNone) return false;
    if (odd != 0) std::swap(v[1], v[2]);
    SlabWalls::Wall* wall = walls.on_one_wall(v, own, beyond);
    if (wall == nullptr) return false;
    const int turn = walls.turn_of(*wall, v);
    if (turn == 0 || turn != (wall->back == own ? wall->turn : -wall->turn)) return false;
    ++wall->faces;
    return true;
  }

  [[nodiscard]] std::int32_t region(std::int32_t t) const { return mesh_.tet_region[static_cast<std::size_t>(t)]; }

  void finish(Certificate& result) const {
    auto& checks = result.checks;
    checks.push_back(structure_.check("structure", "sizes, indices and coordinates are sound", "defects"));
    checks.push_back(positive_.check(
        "positive",
        "every tet is positive (exact" +
            (off_grid_ > 0 ? "; " + std::to_string(off_grid_) + " vertices are off the grid or between planes"
                           : std::string()) +
            ")",
        "tets are not positive"));
    checks.push_back(
        one_slab_.check("one_slab", "every tet lies in the slab it is labeled with", "tets leave their slab"));
    const double difference = std::fabs(result.volume - result.expected_volume);
    const double relative = result.expected_volume > 0 ? difference / result.expected_volume : difference;
    CertificateCheck volume = cells_.check(
        "volume", "volume is area x height: relative difference " + number_text(relative), "cells have a wrong volume");
    if (volume.passed) {
      volume.passed = difference <= options_.volume_tolerance * result.expected_volume + bend_;
      if (bend_ > 0 && result.expected_volume > 0)
        volume.detail +=
            " (bends of walls by rounded split points allow for " + number_text(bend_ / result.expected_volume) + ")";
    }
    checks.push_back(std::move(volume));
    checks.push_back(
        interface_.check("interface_triangles",
                         "all " + std::to_string(horizontal_) +
                             " triangles of the planes, each from its sides, are faces; no other horizontal faces",
                         "horizontal triangles differ"));
    checks.push_back(
        faces_bad_.check("faces",
                         std::to_string(inner_) +
                             " faces inside of slabs are shared by two tets of one region, or stand on an inner wall",
                         "bad faces"));
    checks.push_back(skin_.check("skin",
                                 std::to_string(wall_faces_) + " vertical faces are on the walls" +
                                     (other_diagonals_ > 0 ? ", " + std::to_string(other_diagonals_) +
                                                                 " of them with other diagonals than the complex"
                                                           : std::string()),
                                 "defects of the skin"));
    checks.push_back(duplicates_.check("no_duplicates", "no tet stands twice", "faces of duplicate tets"));
    checks.push_back(orphans_.check("no_orphans", "every vertex belongs to a tet", "vertices without tet"));
  }

  const Mesh& mesh_;
  const Plc& plc_;
  const CertifyOptions& options_;
  const Progress& progress_;
  double share_ = 0;
  std::function<void()> poll_ = [this] { report(progress_, Stage::Certify, share_); };
  std::vector<std::size_t> start_;     // #S + 1 offsets into order_
  std::vector<std::int32_t> order_;    // sound tets by slab
  std::vector<GridPoint> points_;      // #V, where plane_ is not kNone
  std::vector<std::int32_t> plane_;    // #V, kNone off the grid or between planes
  std::vector<std::int32_t> mesh_of_;  // vertex of the mesh for each one of the complex
  std::vector<std::int32_t> plc_of_;   // and the other way round
  std::vector<std::int32_t> local_;    // #V, number in the slab at hand
  std::vector<char> used_;             // #V
  std::vector<Face> faces_;
  std::int64_t off_grid_ = 0, inner_ = 0, horizontal_ = 0, wall_faces_ = 0;
  std::int64_t other_diagonals_ = 0;
  CompensatedSum volume_, expected_;
  double bend_ = 0;  // mm^3
  CheckNotes structure_ = notes(), positive_ = notes(), one_slab_ = notes(), cells_ = notes(), interface_ = notes(),
             faces_bad_ = notes(), skin_ = notes(), duplicates_ = notes(), orphans_ = notes();
};

}  // namespace detail

/// Checks a mesh against the complex that it was made from; nothing is taken on trust from the tetrahedralizer.
///
/// Vertices of the mesh are matched to those of the complex by index, or else by position. Tets with all vertices on
/// the grid and on the two planes of their slab are judged in integer arithmetic, others by exact expansions of
/// doubles. Walls: a vertical face must be a facet of the complex or, where a wall has other diagonals, a triangle of
/// vertices of one wall, as many as the wall has facets. Precondition: a complex with inner faces; `verify_plc` says
/// whether the complex itself is sound. Errors: Cancelled, by the listener; whatever is wrong with the mesh is in the
/// checks. Cost: linear.
[[nodiscard]] inline Certificate certify(const Mesh& mesh, const Plc& plc, const CertifyOptions& options = {},
                                         const Progress& progress = {}) {
  return detail::Certifier(mesh, plc, options, progress).run();
}

}  // namespace slice2mesh
