// SPDX-License-Identifier: MIT
/// @file
/// @brief Boundary and interface sets of a mesh, and the surface that is exposed while it grows layer by layer.
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

#include "slice2mesh/core/compensated_sum.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/progress.hpp"

namespace slice2mesh {

/// A face of a tet. Face f is opposite to vertex f of its tet.
struct TetFace {
  /// Index of the tet.
  std::int32_t tet = 0;
  std::int32_t face = 0;  ///< index of the face: 0 to 3
  friend bool operator==(const TetFace& a, const TetFace& b) { return a.tet == b.tet && a.face == b.face; }
  friend bool operator!=(const TetFace& a, const TetFace& b) { return !(a == b); }
  friend bool operator<(const TetFace& a, const TetFace& b) { return a.tet != b.tet ? a.tet < b.tet : a.face < b.face; }
};

/// 4 by 3: indices (0 to 3) of the vertices of face f, which is opposite to vertex f; the normal points out of a
/// positive tet.
inline constexpr std::array<std::array<std::size_t, 3>, 4> kTetFaceVertices = {
    {{{1, 2, 3}}, {{0, 3, 2}}, {{0, 1, 3}}, {{0, 2, 1}}}};

/// The named surface sets. The number plus one is the surface tag in files.
enum class BoundaryKind : std::uint8_t {
  Bottom = 0,            ///< down-facing, under the first slab
  Top = 1,               ///< up-facing, on the last slab
  Wall = 2,              ///< lateral
  Upskin = 3,            ///< up-facing, on any other slab (steps)
  Downskin = 4,          ///< down-facing, under any other slab (overhangs)
  SupportInterface = 5,  ///< inner faces between part and support, seen from the part
  PlateInterface = 6     ///< inner faces between the base plate and what stands on it, seen from what stands on it
};

/// Number of the named sets.
inline constexpr std::size_t kBoundaryKinds = 7;

/// The set's name, as it stands in files.
[[nodiscard]] constexpr const char* to_string(BoundaryKind kind) noexcept {
  switch (kind) {
    case BoundaryKind::Bottom: return "bottom";
    case BoundaryKind::Top: return "top";
    case BoundaryKind::Wall: return "wall";
    case BoundaryKind::Upskin: return "upskin";
    case BoundaryKind::Downskin: return "downskin";
    case BoundaryKind::SupportInterface: return "support_interface";
    case BoundaryKind::PlateInterface: return "plate_interface";
  }
  return "unknown";
}

/// A face that is exposed at some time of the print.
struct GrowthFace {
  TetFace face;                  ///< on the side of the earlier tet
  std::int32_t born = 0;         ///< index of the slab whose deposition exposes it
  std::int32_t covered = kNone;  ///< index of the slab whose deposition covers it again; kNone: exposed to the end
};

/// What `boundary_sets` finds. Every list is in ascending order of tet and face within its set or slab.
struct BoundarySets {
  std::array<std::vector<TetFace>, kBoundaryKinds> sets;  ///< 7 lists, by BoundaryKind: any number of faces
  std::vector<GrowthFace> growth;                         ///< #G: all faces ever exposed, ordered by `born`
  std::vector<std::size_t> born_begin;  ///< #S+1: faces born with slab k are growth[born_begin[k] .. born_begin[k+1])
  std::vector<std::size_t> covered;     ///< #C: indices into growth of the faces that get covered, ordered by slab
  std::vector<std::size_t> covered_begin;  ///< #S+1: slab k covers covered[covered_begin[k] .. covered_begin[k+1])
  std::vector<double> exposed_area;        ///< #S, mm^2: area exposed when slab k is the last one, bottom included
  std::vector<double> volume;              ///< #S, mm^3: volume of slabs 0..k

  /// The faces of one set: any number.
  [[nodiscard]] const std::vector<TetFace>& of(BoundaryKind kind) const { return sets[static_cast<std::size_t>(kind)]; }
};

namespace detail {

/// Throws unless the arrays of the mesh fit together: lengths, and every index in range.
/// `poll` is called now and then.
inline void check_mesh_arrays(const Mesh& mesh, Stage stage, const std::function<void()>& poll = {}) {
  if (mesh.tet_slab.size() != mesh.tets.size() || mesh.tet_region.size() != mesh.tets.size())
    throw Error(stage, "tet_slab and tet_region must be as long as tets");
  const auto vertices = static_cast<std::int64_t>(mesh.vertices.size());
  const auto slabs = static_cast<std::int64_t>(mesh.slabs.size());
  const auto regions = static_cast<std::int64_t>(mesh.regions.size());
  Poll listen(poll, 1 << 16);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    listen();
    bool good =
        mesh.tet_slab[t] >= 0 && mesh.tet_slab[t] < slabs && mesh.tet_region[t] >= 0 && mesh.tet_region[t] < regions;
    for (const std::int32_t v : mesh.tets[t]) good = good && v >= 0 && v < vertices;
    if (!good) throw Error(stage, "tet " + std::to_string(t) + " names a vertex, slab or region that does not exist");
  }
}

[[nodiscard]] inline std::array<double, 3> cross(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
[[nodiscard]] inline std::array<double, 3> difference(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
[[nodiscard]] inline double dot(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
[[nodiscard]] inline const std::array<double, 3>& vertex_of(const Mesh& mesh, std::size_t tet, std::size_t corner) {
  return mesh.vertices[static_cast<std::size_t>(mesh.tets[tet][corner])];
}

}  // namespace detail

/// Indices of the three vertices of a face; the normal (right-hand rule) points out of its tet. Precondition: the face
/// is one of the mesh (not checked, as with the next three functions).
[[nodiscard]] inline std::array<std::int32_t, 3> face_vertices(const Mesh& mesh, const TetFace& f) {
  const std::array<std::int32_t, 4>& tet = mesh.tets[static_cast<std::size_t>(f.tet)];
  const std::array<std::size_t, 3>& local = kTetFaceVertices[static_cast<std::size_t>(f.face)];
  return {tet[local[0]], tet[local[1]], tet[local[2]]};
}

/// Area of a face, mm^2.
[[nodiscard]] inline double face_area(const Mesh& mesh, const TetFace& f) {
  const std::array<std::int32_t, 3> v = face_vertices(mesh, f);
  const std::array<double, 3>& a = mesh.vertices[static_cast<std::size_t>(v[0])];
  const std::array<double, 3>& b = mesh.vertices[static_cast<std::size_t>(v[1])];
  const std::array<double, 3>& c = mesh.vertices[static_cast<std::size_t>(v[2])];
  const std::array<double, 3> n = detail::cross(detail::difference(b, a), detail::difference(c, a));
  return std::sqrt(detail::dot(n, n)) / 2;
}

/// Volume of the tet of index `tet`, mm^3, positive for a positive tet.
[[nodiscard]] inline double tet_volume(const Mesh& mesh, std::size_t tet) {
  const std::array<double, 3>& o = detail::vertex_of(mesh, tet, 0);
  return detail::dot(detail::cross(detail::difference(detail::vertex_of(mesh, tet, 1), o),
                                   detail::difference(detail::vertex_of(mesh, tet, 2), o)),
                     detail::difference(detail::vertex_of(mesh, tet, 3), o)) /
         6;
}

/// Total area of `faces` (any number), mm^2. Cost: linear.
[[nodiscard]] inline double area_of(const Mesh& mesh, const std::vector<TetFace>& faces) {
  detail::CompensatedSum sum;
  for (const TetFace& f : faces) sum.add(face_area(mesh, f));
  return sum.value();
}

/// Neighbors of all tets, #T by 4: index of the tet beyond face f (opposite to vertex f), or kNone on the boundary.
/// Errors: Error (Stage::Fem) if a face has more than two tets or an array of the mesh does not fit.
/// `poll` is called now and then; what it throws ends the work. Cost: linear in #T; 64 bytes per tet while it runs.
[[nodiscard]] inline std::vector<std::array<std::int32_t, 4>> tet_neighbors(const Mesh& mesh,
                                                                            const std::function<void()>& poll = {}) {
  detail::check_mesh_arrays(mesh, Stage::Fem, poll);
  detail::Poll listen(poll, 1 << 14);
  if (mesh.tets.size() >= (std::size_t{1} << 30)) throw Error(Stage::Fem, "more than 2^30 tets");
  struct Entry {
    std::int32_t middle;
    std::int32_t largest;
    std::uint32_t code;  // 4 * tet + face
    bool operator<(const Entry& b) const {
      if (middle != b.middle) return middle < b.middle;
      return largest != b.largest ? largest < b.largest : code < b.code;
    }
  };
  const auto sorted_face = [&mesh](std::size_t t, std::size_t f) {
    const std::array<std::int32_t, 4>& tet = mesh.tets[t];
    std::array<std::int32_t, 3> v = {tet[kTetFaceVertices[f][0]], tet[kTetFaceVertices[f][1]],
                                     tet[kTetFaceVertices[f][2]]};
    if (v[0] > v[1]) std::swap(v[0], v[1]);
    if (v[1] > v[2]) std::swap(v[1], v[2]);
    if (v[0] > v[1]) std::swap(v[0], v[1]);
    return v;
  };
  // Faces are put into buckets by their smallest vertex; a bucket holds a few faces, whatever the size of the mesh.
  std::vector<std::uint32_t> begin(mesh.vertices.size() + 1, 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    listen();
    for (std::size_t f = 0; f < 4; ++f) ++begin[static_cast<std::size_t>(sorted_face(t, f)[0]) + 1];
  }
  for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
  std::vector<Entry> entries(4 * mesh.tets.size());
  {
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      listen();
      for (std::size_t f = 0; f < 4; ++f) {
        const std::array<std::int32_t, 3> v = sorted_face(t, f);
        entries[next[static_cast<std::size_t>(v[0])]++] = {v[1], v[2], static_cast<std::uint32_t>(4 * t + f)};
      }
    }
  }
  std::vector<std::array<std::int32_t, 4>> neighbors(mesh.tets.size(), {kNone, kNone, kNone, kNone});
  for (std::size_t v = 0; v + 1 < begin.size(); ++v) {
    Entry* const first = entries.data() + begin[v];
    Entry* const last = entries.data() + begin[v + 1];
    detail::sort_listening(first, last, listen);
    for (Entry* a = first; a != last;) {
      Entry* b = a + 1;
      while (b != last && b->middle == a->middle && b->largest == a->largest) ++b;
      if (b - a > 2)
        throw Error(Stage::Fem, "the face of vertices " + std::to_string(v) + ", " + std::to_string(a->middle) + ", " +
                                    std::to_string(a->largest) + " has " + std::to_string(b - a) + " tets");
      if (b - a == 2) {
        neighbors[a->code / 4][a->code % 4] = static_cast<std::int32_t>((a + 1)->code / 4);
        neighbors[(a + 1)->code / 4][(a + 1)->code % 4] = static_cast<std::int32_t>(a->code / 4);
      }
      a = b;
    }
  }
  return neighbors;
}

/// Boundary sets, interfaces, and the exposed surface of the growing part, from the tets and their labels alone.
///
/// A face with material on one side belongs to bottom, top, wall, upskin or downskin; an inner face between a part and
/// a support region to support_interface, one between the base plate and another region to plate_interface. A face is
/// horizontal if its three heights are equal (they are heights of planes, so equality is exact). The face between slabs
/// j < k is exposed from the deposition of j to that of k.
///
/// Precondition: every tet is positive and lies in its slab (the certificate checks it).
/// Errors: Error (Stage::Fem) if the arrays of the mesh do not fit together or a face has more than two tets.
/// `poll` is called now and then; what it throws ends the work. Cost: linear in #T.
[[nodiscard]] inline BoundarySets boundary_sets(const Mesh& mesh, const std::function<void()>& poll = {}) {
  const std::vector<std::array<std::int32_t, 4>> neighbors = tet_neighbors(mesh, poll);
  detail::Poll listen(poll, 1 << 14);
  const std::size_t slab_count = mesh.slabs.size();
  BoundarySets result;
  std::vector<GrowthFace> found;
  std::vector<detail::CompensatedSum> volume(slab_count);
  std::vector<detail::CompensatedSum> lasting(slab_count);  // area born with a slab that stays exposed
  std::vector<detail::CompensatedSum> passing(slab_count);  // area exposed at a slab that is covered later
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    listen();
    const std::int32_t slab = mesh.tet_slab[t];
    const auto slab_index = static_cast<std::size_t>(slab);
    volume[slab_index].add(tet_volume(mesh, t));
    for (std::size_t f = 0; f < 4; ++f) {
      const TetFace face{static_cast<std::int32_t>(t), static_cast<std::int32_t>(f)};
      const std::int32_t other = neighbors[t][f];
      if (other == kNone) {
        const double z = detail::vertex_of(mesh, t, kTetFaceVertices[f][0])[2];
        const bool horizontal = detail::vertex_of(mesh, t, kTetFaceVertices[f][1])[2] == z &&
                                detail::vertex_of(mesh, t, kTetFaceVertices[f][2])[2] == z;
        BoundaryKind kind = BoundaryKind::Wall;
        if (horizontal && detail::vertex_of(mesh, t, f)[2] > z)
          kind = slab == 0 ? BoundaryKind::Bottom : BoundaryKind::Downskin;
        else if (horizontal)
          kind = slab_index + 1 == slab_count ? BoundaryKind::Top : BoundaryKind::Upskin;
        result.sets[static_cast<std::size_t>(kind)].push_back(face);
        found.push_back({face, slab, kNone});
        lasting[slab_index].add(face_area(mesh, face));
        continue;
      }
      const auto beyond = static_cast<std::size_t>(other);
      const RegionKind here = mesh.regions[static_cast<std::size_t>(mesh.tet_region[t])].kind;
      const RegionKind there = mesh.regions[static_cast<std::size_t>(mesh.tet_region[beyond])].kind;
      if (here == RegionKind::Part && there == RegionKind::Support)
        result.sets[static_cast<std::size_t>(BoundaryKind::SupportInterface)].push_back(face);
      if (here != RegionKind::Plate && there == RegionKind::Plate)
        result.sets[static_cast<std::size_t>(BoundaryKind::PlateInterface)].push_back(face);
      if (mesh.tet_slab[beyond] > slab) {
        found.push_back({face, slab, mesh.tet_slab[beyond]});
        const double area = face_area(mesh, face);
        for (std::int32_t k = slab; k < mesh.tet_slab[beyond]; ++k) passing[static_cast<std::size_t>(k)].add(area);
      }
    }
  }

  result.born_begin.assign(slab_count + 1, 0);
  result.covered_begin.assign(slab_count + 1, 0);
  for (const GrowthFace& f : found) {
    ++result.born_begin[static_cast<std::size_t>(f.born) + 1];
    if (f.covered != kNone) ++result.covered_begin[static_cast<std::size_t>(f.covered) + 1];
  }
  for (std::size_t k = 1; k <= slab_count; ++k) {
    result.born_begin[k] += result.born_begin[k - 1];
    result.covered_begin[k] += result.covered_begin[k - 1];
  }
  result.growth.resize(found.size());
  result.covered.resize(result.covered_begin.back());
  std::vector<std::size_t> next_born(result.born_begin);
  std::vector<std::size_t> next_covered(result.covered_begin);
  for (const GrowthFace& f : found) {
    const std::size_t place = next_born[static_cast<std::size_t>(f.born)]++;
    result.growth[place] = f;
    if (f.covered != kNone) result.covered[next_covered[static_cast<std::size_t>(f.covered)]++] = place;
  }

  detail::CompensatedSum area_so_far;
  detail::CompensatedSum volume_so_far;
  result.exposed_area.resize(slab_count);
  result.volume.resize(slab_count);
  for (std::size_t k = 0; k < slab_count; ++k) {
    area_so_far.add(lasting[k]);
    volume_so_far.add(volume[k]);
    detail::CompensatedSum area = area_so_far;
    area.add(passing[k]);
    result.exposed_area[k] = area.value();
    result.volume[k] = volume_so_far.value();
  }
  return result;
}

/// Faces exposed when the slab of index `k` is the last one deposited (the moving surface for convection and
/// radiation): any number, by the slab that exposes them. Errors: Error (Stage::Fem) if there is no such slab. Cost:
/// linear in the faces born up to k.
[[nodiscard]] inline std::vector<TetFace> exposed_faces(const BoundarySets& sets, std::int32_t k) {
  if (k < 0 || static_cast<std::size_t>(k) + 1 >= sets.born_begin.size())
    throw Error(Stage::Fem, "there is no slab " + std::to_string(k));
  std::vector<TetFace> faces;
  for (std::size_t i = 0; i < sets.born_begin[static_cast<std::size_t>(k) + 1]; ++i)
    if (sets.growth[i].covered == kNone || sets.growth[i].covered > k) faces.push_back(sets.growth[i].face);
  return faces;
}

/// Faces that the deposition of the slab of index `k` covers, seen from below: any number.
/// Errors: Error (Stage::Fem) if there is no such slab. Cost: linear in the result.
[[nodiscard]] inline std::vector<TetFace> covered_faces(const BoundarySets& sets, std::int32_t k) {
  if (k < 0 || static_cast<std::size_t>(k) + 1 >= sets.covered_begin.size())
    throw Error(Stage::Fem, "there is no slab " + std::to_string(k));
  std::vector<TetFace> faces;
  for (std::size_t i = sets.covered_begin[static_cast<std::size_t>(k)];
       i < sets.covered_begin[static_cast<std::size_t>(k) + 1]; ++i)
    faces.push_back(sets.growth[sets.covered[i]].face);
  return faces;
}

/// Faces that the deposition of the slab of index `k` newly exposes (part of them until the next slab covers them): any
/// number. Errors: Error (Stage::Fem) if there is no such slab. Cost: linear in the result.
[[nodiscard]] inline std::vector<TetFace> born_faces(const BoundarySets& sets, std::int32_t k) {
  if (k < 0 || static_cast<std::size_t>(k) + 1 >= sets.born_begin.size())
    throw Error(Stage::Fem, "there is no slab " + std::to_string(k));
  std::vector<TetFace> faces;
  for (std::size_t i = sets.born_begin[static_cast<std::size_t>(k)];
       i < sets.born_begin[static_cast<std::size_t>(k) + 1]; ++i)
    faces.push_back(sets.growth[i].face);
  return faces;
}

}  // namespace slice2mesh
