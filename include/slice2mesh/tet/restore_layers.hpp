// SPDX-License-Identifier: MIT
/// @file
/// @brief Layers restored after a mesher that knows nothing of them, and what was lost on the way.
///
/// A mesher gives vertices and tets. Which slab and region a tet belongs to is read off its place: heights give the
/// slab, the contours of the slab (its walls seen from above) give the region by winding numbers. Whether a place is in
/// the part at all is decided by the outer skin alone: inner faces bound material on both sides and would be counted by
/// a winding number of all facets (noted by Livesu, Cabiddu, Attene 2019).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/arrange/exact.hpp"
#include "slice2mesh/core/compensated_sum.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/fem/boundary_sets.hpp"
#include "slice2mesh/plc/plc_checks.hpp"
#include "slice2mesh/quality/certificate.hpp"
#include "slice2mesh/quality/quality.hpp"

namespace slice2mesh {

/// Tets as a mesher gives them.
struct RawTets {
  std::vector<std::array<double, 3>> vertices;    ///< #V by 3: x, y, z in mm
  std::vector<std::array<std::int32_t, 4>> tets;  ///< #T by 4: indices of vertices, in any orientation
  std::vector<Side> cells;  ///< #T or empty: slab and region where the mesher knows them; empty sides are looked up
};

/// What is done with tets outside of the part.
enum class OutsideTets : std::uint8_t {
  Drop,  ///< a tet whose centroid is outside of the outer skin is left out
  Keep   ///< nothing is left out; such a tet goes to the nearest cell: for meshers that remove the outside themselves
};

/// How layers are restored.
struct RestoreOptions {
  /// What becomes of tets outside of the skin.
  OutsideTets outside = OutsideTets::Drop;
  /// Vertices nearer than this to a plane, or to a vertex of the complex, are put there: what other programs rounded is
  /// made exact again. A share of the diagonal of the bounding box, in [0, 1e-3]; far below any feature of a complex.
  /// Vertices of tets that would become flat or turn over stay where they are.
  double snap = 1e-9;
};

/// What a mesh keeps of the layers.
struct LayerReport {
  /// Number of those of the mesh.
  std::size_t tets = 0;
  std::size_t crossing =
      0;  ///< number of tets that lie in no single slab; they are counted to the slab of their centroid
  /// `crossing` as a share of all tets.
  double crossing_share = 0;
  std::size_t outside = 0;          ///< number of tets that were left out, or kept although outside (`restore_layers`)
  std::vector<double> slab_volume;  ///< #S, mm^3, of the tets of each slab
  std::vector<double> exact_slab_volume;    ///< #S, mm^3, area x height
  double volume = 0;                        ///< mm^3, of all tets
  double exact_volume = 0;                  ///< mm^3, of all slabs, area x height
  double volume_error = 0;                  ///< relative, signed
  double largest_slab_error = 0;            ///< relative, of the slab where it is largest, without sign
  std::int32_t largest_error_slab = kNone;  ///< index of that slab
};

/// A mesh with the layers it has.
struct RestoredMesh {
  /// The mesh.
  Mesh mesh;
  /// What became of the layers.
  LayerReport report;
};

namespace detail {

/// Finds the cell (slab and region) of a point.
class CellLocator {
public:
  explicit CellLocator(const Plc& plc) : plc_(plc), sheets_(plc.slabs.size()), winding_(plc.regions.size(), 0) {
    for (const Facet& facet : plc.facets) {
      if (facet.label != FacetLabel::Wall && facet.label != FacetLabel::InnerWall) continue;
      const auto slab = static_cast<std::size_t>(facet.back.slab);
      const std::int32_t bottom = plc.slab_planes[slab][0];
      for (std::size_t i = 0; i < 3; ++i) {
        const auto u = static_cast<std::size_t>(facet.vertices[i]);
        const auto w = static_cast<std::size_t>(facet.vertices[(i + 1) % 3]);
        if (plc.vertex_plane[u] != bottom || plc.vertex_plane[w] != bottom) continue;
        // The normal of a wall points out of its back, so that the back is on the left of its bottom edge.
        sheets_[slab].edges.push_back({plc.grid.x_mm(plc.vertices[u]), plc.grid.y_mm(plc.vertices[u]),
                                       plc.grid.x_mm(plc.vertices[w]), plc.grid.y_mm(plc.vertices[w]),
                                       facet.back.region, facet.front.region});
      }
    }
    for (Sheet& sheet : sheets_) sheet.index();
  }

  /// The slab that contains a range of heights up to a tolerance, or kNone.
  [[nodiscard]] std::int32_t slab_of(double low, double high, double tolerance) const {
    // Of two slabs that touch at a flat range the upper one is taken.
    const auto above = std::upper_bound(plc_.slabs.begin(), plc_.slabs.end(), low,
                                        [&](double z, const Slab& s) { return z < s.z_low - tolerance; });
    if (above == plc_.slabs.begin()) return kNone;
    const auto slab = above - plc_.slabs.begin() - 1;
    const auto fits = [&](std::ptrdiff_t s) {
      const Slab& range = plc_.slabs[static_cast<std::size_t>(s)];
      return range.z_low - tolerance <= low && high <= range.z_high + tolerance;
    };
    if (fits(slab)) return static_cast<std::int32_t>(slab);
    return slab > 0 && fits(slab - 1) ? static_cast<std::int32_t>(slab - 1) : kNone;
  }
  /// The slab at a height, or the nearest one. Precondition: there are slabs.
  [[nodiscard]] std::int32_t nearest_slab(double z) const {
    const auto above = std::upper_bound(plc_.slabs.begin(), plc_.slabs.end(), z,
                                        [](double height, const Slab& s) { return height < s.z_low; });
    if (above == plc_.slabs.begin()) return 0;
    const auto below = above - 1;
    const bool upper = above != plc_.slabs.end() && z > below->z_high && above->z_low - z < z - below->z_high;
    return static_cast<std::int32_t>((upper ? above : below) - plc_.slabs.begin());
  }

  /// The region of a slab at a place, or kNone outside of the outer skin.
  [[nodiscard]] std::int32_t region_at(std::int32_t slab, double x, double y) {
    const Sheet& sheet = sheets_[static_cast<std::size_t>(slab)];
    if (sheet.edges.empty()) return kNone;
    std::fill(winding_.begin(), winding_.end(), 0);
    int skin = 0;
    sheet.for_bucket(y, [&](const Edge& e) {
      if (e.y0 <= y ? e.y1 <= y : e.y1 > y) return;  // does not cross the line through the place
      const bool up = e.y0 <= y;
      const double side = (e.x1 - e.x0) * (y - e.y0) - (x - e.x0) * (e.y1 - e.y0);
      if (up ? side <= 0 : side >= 0) return;  // crosses on the other side of the place
      const int turn = up ? 1 : -1;
      winding_[static_cast<std::size_t>(e.back)] += turn;
      if (e.front != kNone)
        winding_[static_cast<std::size_t>(e.front)] -= turn;
      else
        skin += turn;
    });
    if (skin <= 0) return kNone;
    return static_cast<std::int32_t>(std::max_element(winding_.begin(), winding_.end()) - winding_.begin());
  }

  /// Distance of a place to the nearest wall of a slab, mm, and the region at the wall's back. Cost: linear.
  struct NearestWall {
    double distance = std::numeric_limits<double>::infinity();
    std::int32_t back = kNone;
  };
  [[nodiscard]] NearestWall nearest_wall(std::int32_t slab, double x, double y) const {
    NearestWall nearest;
    for (const Edge& e : sheets_[static_cast<std::size_t>(slab)].edges) {
      const double d = e.distance(x, y);
      if (d < nearest.distance) nearest = {d, e.back};
    }
    return nearest;
  }
  /// Is there a wall between two regions of a slab (kNone: outside) within a distance of a place?
  [[nodiscard]] bool near_wall(std::int32_t slab, std::int32_t back, std::int32_t front, double x, double y,
                               double distance) const {
    bool found = false;
    const Sheet& sheet = sheets_[static_cast<std::size_t>(slab)];
    const auto look = [&](const Edge& e) {
      found = found || (e.back == back && e.front == front && e.distance(x, y) <= distance);
    };
    for (const double at : {y, y - distance, y + distance})
      if (!found) sheet.for_bucket(at, look);
    return found;
  }

private:
  struct Edge {
    double x0, y0, x1, y1;  // mm
    std::int32_t back, front;
    [[nodiscard]] double distance(double x, double y) const {
      const double dx = x1 - x0, dy = y1 - y0, length = dx * dx + dy * dy;
      const double t = length > 0 ? std::clamp(((x - x0) * dx + (y - y0) * dy) / length, 0.0, 1.0) : 0.0;
      return std::hypot(x - x0 - t * dx, y - y0 - t * dy);
    }
  };
  /// The walls of one slab from above, in buckets by y.
  struct Sheet {
    std::vector<Edge> edges;
    std::vector<std::size_t> start;   // #B + 1
    std::vector<std::uint32_t> list;  // edges by bucket
    double low = 0, high = 0;

    void index() {
      if (edges.empty()) return;
      low = high = edges[0].y0;
      for (const Edge& e : edges) {
        low = std::min({low, e.y0, e.y1});
        high = std::max({high, e.y0, e.y1});
      }
      start.assign(edges.size() / 2 + 2, 0);
      const auto for_each = [&](auto&& f) {
        for (std::size_t e = 0; e < edges.size(); ++e) {
          const std::size_t last = bucket(std::max(edges[e].y0, edges[e].y1));
          for (std::size_t b = bucket(std::min(edges[e].y0, edges[e].y1)); b <= last; ++b) f(b, e);
        }
      };
      for_each([&](std::size_t b, std::size_t) { ++start[b + 1]; });
      for (std::size_t b = 1; b < start.size(); ++b) start[b] += start[b - 1];
      list.resize(start.back());
      std::vector<std::size_t> next(start.begin(), start.end() - 1);
      for_each([&](std::size_t b, std::size_t e) { list[next[b]++] = static_cast<std::uint32_t>(e); });
    }
    [[nodiscard]] std::size_t bucket(double y) const {
      const std::size_t count = start.size() - 1;
      if (!(y > low) || !(high > low)) return 0;
      if (y >= high) return count - 1;
      return std::min(count - 1, static_cast<std::size_t>((y - low) / (high - low) * static_cast<double>(count)));
    }
    template <class Visit>
    void for_bucket(double y, Visit&& visit) const {
      if (edges.empty()) return;
      const std::size_t b = bucket(y);
      for (std::size_t i = start[b]; i < start[b + 1]; ++i) visit(edges[list[i]]);
    }
  };

  const Plc& plc_;
  std::vector<Sheet> sheets_;
  std::vector<int> winding_;  // #R, scratch
};

/// Diagonal of the bounding box of points, mm.
[[nodiscard]] inline double diagonal_of(const std::vector<std::array<double, 3>>& points) {
  if (points.empty()) return 0;
  std::array<double, 3> low = points[0], high = points[0];
  for (const std::array<double, 3>& p : points)
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  return std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
}

/// Diagonal of the bounding box of a complex, mm.
[[nodiscard]] inline double diagonal_of(const Plc& plc) {
  std::vector<std::array<double, 3>> points;
  points.reserve(plc.vertices.size());
  for (std::size_t v = 0; v < plc.vertices.size(); ++v) points.push_back(plc.position(v));
  return diagonal_of(points);
}

/// Throws TetrahedralizationError unless the complex can be looked at: sizes, indices, labels, sides.
inline void require_sound(const Plc& plc) {
  CheckNotes notes(3);
  check_complex(plc, notes);
  if (plc.slabs.empty() || plc.regions.empty()) notes.offend([] { return std::string("no slabs or no regions"); });
  if (notes.count() > 0)
    throw TetrahedralizationError(-1, "the complex is not sound: " + notes.check("complex", "", "defects").detail);
}

/// Volumes of the cells of a complex, mm^3, slab by slab: #S times #R. Area x height from the walls, which the outer
/// skin alone has as well; without inner faces the regions of one slab cannot be told apart by their inner walls.
[[nodiscard]] inline std::vector<double> exact_cell_volumes(const Plc& plc) {
  const std::size_t regions = plc.regions.size();
  std::vector<Int128> doubled(plc.slabs.size() * regions, 0);  // 4 times the mean area, squared pitches
  for (const Facet& facet : plc.facets) {
    if (facet.label != FacetLabel::Wall && facet.label != FacetLabel::InnerWall) continue;
    const auto slab = static_cast<std::size_t>(facet.back.slab);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto u = static_cast<std::size_t>(facet.vertices[i]);
      const auto w = static_cast<std::size_t>(facet.vertices[(i + 1) % 3]);
      if (plc.vertex_plane[u] != plc.vertex_plane[w]) continue;
      const GridPoint &a = plc.vertices[u], &b = plc.vertices[w];
      Int128 area = Int128(a.x) * b.y - Int128(a.y) * b.x;
      if (plc.vertex_plane[u] != plc.slab_planes[slab][0]) area = -area;  // edges of the top run the other way
      doubled[slab * regions + static_cast<std::size_t>(facet.back.region)] += area;
      if (!facet.front.empty()) doubled[slab * regions + static_cast<std::size_t>(facet.front.region)] -= area;
    }
  }
  std::vector<double> volumes(doubled.size());
  for (std::size_t i = 0; i < doubled.size(); ++i) {
    const Slab& slab = plc.slabs[i / regions];
    volumes[i] = double(doubled[i]) / 4 * plc.grid.pitch * plc.grid.pitch * (slab.z_high - slab.z_low);
  }
  return volumes;
}

/// Six times the volume of a tet, mm^3, positive if it is.
[[nodiscard]] inline double sixfold_volume(const std::vector<std::array<double, 3>>& vertices,
                                           const std::array<std::int32_t, 4>& tet) {
  const auto& a = vertices[static_cast<std::size_t>(tet[0])];
  const auto& b = vertices[static_cast<std::size_t>(tet[1])];
  const auto& c = vertices[static_cast<std::size_t>(tet[2])];
  const auto& d = vertices[static_cast<std::size_t>(tet[3])];
  return dot(cross(difference(b, a), difference(c, a)), difference(d, a));
}

/// A face of a tet by its vertices in ascending order.
struct TriangleOfTet {
  std::array<std::int32_t, 3> key;
  std::int32_t tet;
  std::int32_t face;
  friend bool operator<(const TriangleOfTet& s, const TriangleOfTet& t) {
    return s.key != t.key ? s.key < t.key : s.tet < t.tet;
  }
};

/// All faces of all tets, those on the same triangle side by side.
[[nodiscard]] inline std::vector<TriangleOfTet> sorted_triangles(const std::vector<std::array<std::int32_t, 4>>& tets) {
  std::vector<TriangleOfTet> triangles;
  triangles.reserve(tets.size() * 4);
  for (std::size_t t = 0; t < tets.size(); ++t)
    for (std::size_t f = 0; f < 4; ++f) {
      std::array<std::int32_t, 3> key{};
      for (std::size_t k = 0; k < 3; ++k) key[k] = tets[t][kTetFaceVertices[f][k]];
      std::sort(key.begin(), key.end());
      triangles.push_back({key, static_cast<std::int32_t>(t), static_cast<std::int32_t>(f)});
    }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

/// Puts vertices that are nearly on planes and on vertices of the complex there.
inline void snap_vertices(std::vector<std::array<double, 3>>& vertices, const Plc& plc, double tolerance) {
  struct Place {
    std::int32_t plane;
    double x, y;
    bool operator<(const Place& o) const { return plane != o.plane ? plane < o.plane : x < o.x; }
  };
  std::vector<Place> places;
  places.reserve(plc.vertices.size());
  for (std::size_t v = 0; v < plc.vertices.size(); ++v)
    places.push_back({plc.vertex_plane[v], plc.grid.x_mm(plc.vertices[v]), plc.grid.y_mm(plc.vertices[v])});
  std::sort(places.begin(), places.end());
  for (std::array<double, 3>& p : vertices) {
    auto plane = std::lower_bound(plc.planes.begin(), plc.planes.end(), p[2]);
    if (plane == plc.planes.end() || (plane != plc.planes.begin() && p[2] - *(plane - 1) < *plane - p[2])) --plane;
    if (!(std::fabs(*plane - p[2]) <= tolerance)) continue;
    p[2] = *plane;
    const auto index = static_cast<std::int32_t>(plane - plc.planes.begin());
    for (auto it = std::lower_bound(places.begin(), places.end(), Place{index, p[0] - tolerance, 0});
         it != places.end() && it->plane == index && it->x <= p[0] + tolerance; ++it)
      if (std::fabs(it->y - p[1]) <= tolerance) {
        p[0] = it->x;
        p[1] = it->y;
        break;
      }
  }
}

/// Takes back what made a tet flat or turned it over: four vertices near one plane, which some meshers leave as a
/// sliver there, lie in it once they are put on it. `before`: the vertices as the mesher gave them. Ends, as every
/// round takes back a move; cost: linear where little is taken back.
inline void unsnap_flat_tets(std::vector<std::array<double, 3>>& vertices,
                             const std::vector<std::array<double, 3>>& before,
                             const std::vector<std::array<std::int32_t, 4>>& tets) {
  const auto sign = [&tets](const std::vector<std::array<double, 3>>& points, std::size_t t) {
    const auto corner = [&](std::size_t k) { return points[static_cast<std::size_t>(tets[t][k])]; };
    return exact_volume(corner(0), corner(1), corner(2), corner(3)).sign;
  };
  bool again = true;
  while (again) {
    again = false;
    for (std::size_t t = 0; t < tets.size(); ++t) {
      const auto moved = [&](std::int32_t v) {
        return vertices[static_cast<std::size_t>(v)] != before[static_cast<std::size_t>(v)];
      };
      if (std::none_of(tets[t].begin(), tets[t].end(), moved)) continue;
      const int was = sign(before, t);
      if (was == 0 || sign(vertices, t) == was) continue;
      for (const std::int32_t v : tets[t]) vertices[static_cast<std::size_t>(v)] = before[static_cast<std::size_t>(v)];
      again = true;
    }
  }
}

/// A normal this near to the vertical (cosine) makes a face of an approximated skin one that faces up or down.
inline constexpr double kHorizontalCosine = 0.70710678118654752;

/// The facets of a mesh that has its slabs and regions: every face between two cells, or between a cell and the
/// outside, with the label that follows from its sides and its place. `wall` is kNone: walls of the complex are not
/// looked for. Cost: n log n.
[[nodiscard]] inline std::vector<Facet> facets_between_cells(const Mesh& mesh) {
  std::vector<Facet> facets;
  const std::vector<TriangleOfTet> triangles = sorted_triangles(mesh.tets);
  const auto side = [&](std::int32_t t) {
    return Side{mesh.tet_slab[static_cast<std::size_t>(t)], mesh.tet_region[static_cast<std::size_t>(t)]};
  };
  for (std::size_t i = 0; i < triangles.size();) {
    std::size_t j = i + 1;
    while (j < triangles.size() && triangles[j].key == triangles[i].key) ++j;
    const std::size_t count = j - i;
    const TriangleOfTet* back = &triangles[i];
    const TriangleOfTet* front = count == 2 ? &triangles[i + 1] : nullptr;
    i = j;
    if (count > 2) continue;  // overlapping tets: the axioms say so
    Facet facet;
    facet.back = side(back->tet);
    if (front != nullptr) {
      facet.front = side(front->tet);
      if (facet.back == facet.front) continue;
      const bool swap = facet.front.slab != facet.back.slab ? facet.front.slab < facet.back.slab
                                                            : facet.front.region < facet.back.region;
      if (swap) {
        std::swap(back, front);
        std::swap(facet.back, facet.front);
      }
      facet.label = facet.back.slab == facet.front.slab ? FacetLabel::InnerWall : FacetLabel::Interface;
    }
    facet.vertices = face_vertices(mesh, {back->tet, back->face});
    if (front == nullptr) {
      const auto& a = mesh.vertices[static_cast<std::size_t>(facet.vertices[0])];
      const auto& b = mesh.vertices[static_cast<std::size_t>(facet.vertices[1])];
      const auto& c = mesh.vertices[static_cast<std::size_t>(facet.vertices[2])];
      const std::array<double, 3> n = cross(difference(b, a), difference(c, a));
      const double length = std::sqrt(dot(n, n));
      if (std::fabs(n[2]) < kHorizontalCosine * length)
        facet.label = FacetLabel::Wall;
      else
        facet.label = n[2] > 0 ? FacetLabel::Up : FacetLabel::Down;
    }
    facets.push_back(facet);
  }
  return facets;
}

}  // namespace detail

/// What a mesh keeps of the layers of its complex. `outside` is 0: see `restore_layers`.
/// Errors: TetrahedralizationError if the complex is not sound, Error if the arrays of the mesh do not fit together or
/// to the complex. Cost: linear.
[[nodiscard]] inline LayerReport measure_layers(const Mesh& mesh, const Plc& plc) {
  detail::require_sound(plc);
  detail::check_mesh_arrays(mesh, Stage::Tetrahedralize);
  if (mesh.slabs.size() != plc.slabs.size())
    throw Error(Stage::Tetrahedralize, "the mesh has not the slabs of the complex");
  LayerReport report;
  report.tets = mesh.tets.size();
  const double tolerance = detail::kCrossingTolerance * detail::diagonal_of(plc);
  const detail::SlabFinder slabs(plc.slabs, tolerance);
  std::vector<detail::CompensatedSum> volumes(plc.slabs.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t k = 0; k < 4; ++k) {
      const double z = detail::vertex_of(mesh, t, k)[2];
      low = std::min(low, z);
      high = std::max(high, z);
    }
    if (!slabs.in_one(low, high)) ++report.crossing;
    volumes[static_cast<std::size_t>(mesh.tet_slab[t])].add(detail::sixfold_volume(mesh.vertices, mesh.tets[t]) / 6);
  }
  if (report.tets > 0) report.crossing_share = static_cast<double>(report.crossing) / static_cast<double>(report.tets);
  const std::vector<double> exact = detail::exact_cell_volumes(plc);
  detail::CompensatedSum volume, exact_volume;
  for (std::size_t s = 0; s < plc.slabs.size(); ++s) {
    detail::CompensatedSum slab;
    for (std::size_t r = 0; r < plc.regions.size(); ++r) slab.add(exact[s * plc.regions.size() + r]);
    report.slab_volume.push_back(volumes[s].value());
    report.exact_slab_volume.push_back(slab.value());
    volume.add(volumes[s]);
    exact_volume.add(slab);
    const double error = slab.value() > 0 ? std::fabs(volumes[s].value() - slab.value()) / slab.value() : 0;
    if (report.largest_error_slab == kNone || error > report.largest_slab_error) {
      report.largest_slab_error = error;
      report.largest_error_slab = static_cast<std::int32_t>(s);
    }
  }
  report.volume = volume.value();
  report.exact_volume = exact_volume.value();
  if (report.exact_volume > 0) report.volume_error = report.volume / report.exact_volume - 1;
  return report;
}

/// Gives tets their slabs, regions and labelled facets, and counts what does not fit.
///
/// A tet that lies in one slab (up to 1e-9 of the bounding box diagonal) belongs to it; one that crosses belongs to the
/// slab of its centroid and is counted. The region is that at the centroid. Tets are turned to be positive; flat ones
/// stay as they are, for the axioms to find. Vertices that no tet uses are left out.
/// Errors: TetrahedralizationError if the complex or the tets are not sound, or nothing is left; OptionError for
/// `snap`. Cost: n log n.
[[nodiscard]] inline RestoredMesh restore_layers(RawTets raw, const Plc& plc, const RestoreOptions& options = {}) {
  if (!(options.snap >= 0 && options.snap <= 1e-3)) throw OptionError("snap", "must be a share from 0 to 1e-3");
  detail::require_sound(plc);
  if (!raw.cells.empty() && raw.cells.size() != raw.tets.size())
    throw TetrahedralizationError(-1, "the cells of the mesher are not as many as its tets");
  for (std::size_t v = 0; v < raw.vertices.size(); ++v)
    for (const double c : raw.vertices[v])
      if (!std::isfinite(c))
        throw TetrahedralizationError(-1, "vertex " + std::to_string(v) + " of the mesher is not finite");
  for (std::size_t t = 0; t < raw.tets.size(); ++t)
    for (const std::int32_t v : raw.tets[t])
      if (!detail::in_range(v, raw.vertices.size()))
        throw TetrahedralizationError(-1, "tet " + std::to_string(t) + " of the mesher names a vertex that it has not");

  const double diagonal = detail::diagonal_of(plc);
  const double tolerance = detail::kCrossingTolerance * diagonal;
  if (options.snap > 0) {
    const std::vector<std::array<double, 3>> before = raw.vertices;
    detail::snap_vertices(raw.vertices, plc, options.snap * diagonal);
    detail::unsnap_flat_tets(raw.vertices, before, raw.tets);
  }
  detail::CellLocator cells(plc);
  RestoredMesh result;
  Mesh& mesh = result.mesh;
  mesh.slabs = plc.slabs;
  mesh.regions = plc.regions;
  mesh.tets.reserve(raw.tets.size());
  std::size_t outside = 0;
  for (std::size_t t = 0; t < raw.tets.size(); ++t) {
    std::array<std::int32_t, 4> tet = raw.tets[t];
    std::array<double, 3> centroid{};
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const std::int32_t v : tet) {
      const auto& p = raw.vertices[static_cast<std::size_t>(v)];
      for (std::size_t k = 0; k < 3; ++k) centroid[k] += p[k] / 4;
      low = std::min(low, p[2]);
      high = std::max(high, p[2]);
    }
    Side cell = raw.cells.empty() ? Side{} : raw.cells[t];
    if (cell.empty()) {
      cell.slab = cells.slab_of(low, high, tolerance);
      if (cell.slab == kNone) cell.slab = cells.slab_of(centroid[2], centroid[2], 0);
      const bool in_gap = cell.slab == kNone;
      if (in_gap) cell.slab = cells.nearest_slab(centroid[2]);
      cell.region = in_gap ? kNone : cells.region_at(cell.slab, centroid[0], centroid[1]);
      if (cell.region == kNone) {
        ++outside;
        if (options.outside == OutsideTets::Drop) continue;
        cell.region = std::max(0, cells.nearest_wall(cell.slab, centroid[0], centroid[1]).back);
      }
    } else if (!detail::in_range(cell.slab, plc.slabs.size()) || !detail::in_range(cell.region, plc.regions.size())) {
      throw TetrahedralizationError(-1, "tet " + std::to_string(t) + " of the mesher names a cell that does not exist");
    }
    if (detail::sixfold_volume(raw.vertices, tet) < 0) std::swap(tet[2], tet[3]);
    mesh.tets.push_back(tet);
    mesh.tet_slab.push_back(cell.slab);
    mesh.tet_region.push_back(cell.region);
  }
  if (mesh.tets.empty()) throw TetrahedralizationError(-1, "the mesher gave no tet inside of the part");
  std::vector<std::int32_t> number(raw.vertices.size(), kNone);
  for (const std::array<std::int32_t, 4>& tet : mesh.tets)
    for (const std::int32_t v : tet) number[static_cast<std::size_t>(v)] = 0;
  for (std::size_t v = 0; v < number.size(); ++v)
    if (number[v] != kNone) {
      number[v] = static_cast<std::int32_t>(mesh.vertices.size());
      mesh.vertices.push_back(raw.vertices[v]);
    }
  for (std::array<std::int32_t, 4>& tet : mesh.tets)
    for (std::int32_t& v : tet) v = number[static_cast<std::size_t>(v)];
  mesh.facets = detail::facets_between_cells(mesh);
  result.report = measure_layers(mesh, plc);
  result.report.outside = outside;
  return result;
}

}  // namespace slice2mesh
