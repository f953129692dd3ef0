// SPDX-License-Identifier: MIT
/// @file
/// @brief TetGenMesher: TetGen (Si, "TetGen, a Delaunay-based quality tetrahedral mesh generator", ACM TOMS 41 (2015))
/// as a tetrahedralizer.
///
/// TetGen is under the AGPL: so is, when it is distributed, a program that includes this header and links to the
/// library. The CMake target slice2mesh::tetgen does the linking. Where tetgen.h is not found this header defines
/// nothing but SLICE2MESH_HAS_TETGEN as 0.
#pragma once

#if __has_include(<tetgen.h>)
#define SLICE2MESH_HAS_TETGEN 1
#else
/// 1 where tetgen.h is found, else 0.
#define SLICE2MESH_HAS_TETGEN 0
#endif

#if SLICE2MESH_HAS_TETGEN

#ifndef TETLIBRARY
/// What tetgen.h asks for: TetGen as a library.
#define TETLIBRARY
#endif
#include <tetgen.h>
#undef REAL  // a macro of tetgen.h

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/io/tetgen_files.hpp"
#include "slice2mesh/tet/child_process.hpp"
#include "slice2mesh/tet/raw_tets_bytes.hpp"
#include "slice2mesh/tet/restore_layers.hpp"
#include "slice2mesh/tet/tetrahedralizer.hpp"

namespace slice2mesh {

namespace detail {

[[nodiscard]] inline std::string tetgen_error_text(int code) {
  switch (code) {
    case 1: return "TetGen ran out of memory";
    case 2: return "TetGen met an internal error";
    case 3: return "TetGen found a self-intersection of the complex";
    case 4: return "TetGen found an input feature that is too small for its tolerance";
    case 5: return "TetGen found two facets that are too close";
    case 10: return "TetGen refused its input";
    default: return "TetGen failed with code " + std::to_string(code);
  }
}

/// Fills `in` with a complex. Arrays are made with new[], as tetgenio frees them with delete[].
inline void fill_tetgen(tetgenio& in, const Plc& plc) {
  in.firstnumber = 0;
  in.numberofpoints = static_cast<int>(plc.vertices.size());
  in.pointlist = new double[plc.vertices.size() * 3];
  for (std::size_t v = 0; v < plc.vertices.size(); ++v) {
    const std::array<double, 3> p = plc.position(v);
    std::copy(p.begin(), p.end(), in.pointlist + 3 * v);
  }
  in.facetlist = new tetgenio::facet[plc.facets.size()];
  for (std::size_t f = 0; f < plc.facets.size(); ++f) tetgenio::init(&in.facetlist[f]);
  in.numberoffacets = static_cast<int>(plc.facets.size());
  for (std::size_t f = 0; f < plc.facets.size(); ++f) {
    tetgenio::facet& facet = in.facetlist[f];
    facet.polygonlist = new tetgenio::polygon[1];
    tetgenio::init(facet.polygonlist);
    facet.numberofpolygons = 1;
    facet.polygonlist[0].vertexlist = new int[3];
    facet.polygonlist[0].numberofvertices = 3;
    for (std::size_t k = 0; k < 3; ++k) facet.polygonlist[0].vertexlist[k] = plc.facets[f].vertices[k];
  }
  const std::vector<std::array<double, 3>> holes = void_points(plc);
  in.holelist = new double[holes.size() * 3 + 1];
  in.numberofholes = static_cast<int>(holes.size());
  for (std::size_t h = 0; h < holes.size(); ++h) std::copy(holes[h].begin(), holes[h].end(), in.holelist + 3 * h);
}

[[nodiscard]] inline RawTets run_tetgen(const Plc& plc, const std::string& switches) {
  RawTets tets;
  try {
    tetgenio in, out;
    fill_tetgen(in, plc);
    std::vector<char> text(switches.begin(), switches.end());
    text.push_back('\0');
    tetrahedralize(text.data(), &in, &out);
    if (out.numberoftetrahedra <= 0 || out.numberofcorners < 4)
      throw TetrahedralizationError(-1, "TetGen gave no tets");
    for (int v = 0; v < out.numberofpoints; ++v) {
      const double* p = out.pointlist + 3 * static_cast<std::size_t>(v);
      tets.vertices.push_back({p[0], p[1], p[2]});
    }
    for (int t = 0; t < out.numberoftetrahedra; ++t) {
      const int* v = out.tetrahedronlist + static_cast<std::size_t>(t) * static_cast<std::size_t>(out.numberofcorners);
      tets.tets.push_back(
          {v[0] - out.firstnumber, v[1] - out.firstnumber, v[2] - out.firstnumber, v[3] - out.firstnumber});
    }
  } catch (const int code) {  // so TetGen reports its errors
    throw TetrahedralizationError(-1, tetgen_error_text(code));
  }
  return tets;
}

}  // namespace detail

/// TetGen as a tetrahedralizer. Without quality it keeps the vertices of the complex and adds points only where facets
/// cannot be recovered without; with quality it adds points inside and on facets. Facets are kept as unions of faces.
///
/// TetGen can crash, loop or take all memory: it runs in a child process with limits unless `child_process` is false.
/// Errors: TetrahedralizationError for each of these, for what TetGen itself reports and for a complex that is not
/// sound; OptionError; Cancelled, and what `progress` throws.
struct TetGenMesher {
  double radius_edge = 0;  ///< -q: largest ratio of circumradius to shortest edge, > 1; 0: no quality
  double min_dihedral =
      0;                  ///< -q, with `radius_edge`: smallest dihedral angle in degrees, below 90; 0: TetGen's choice
  double max_volume = 0;  ///< -a: largest volume of a tet, mm^3; 0: none
  double tolerance = 1e-13;  ///< -T: for coplanar facets, relative; 0: that of TetGen, 1e-8
  /// -p: facets that meet at a larger angle (degrees) count as one plane. With TetGen's own 179.9 new points would be
  /// put off contours that are nearly straight; this is nearly what the grid bends walls by.
  double facet_angle = 179.99999;
  bool keep_boundary = false;  ///< -Y: no new points on facets
  /// If not empty: taken instead of all these ("pq1.4/10a0.5"). Switches p, z and Q are added; p gets `facet_angle`
  /// where it has no number.
  std::string switches;
  /// False: in this process, without limits.
  bool child_process = true;
  /// Of the child process.
  ChildLimits limits;
  /// Listener; may cancel.
  Progress progress;

  /// What the model promises.
  [[nodiscard]] TetrahedralizerTraits traits() const { return {"tetgen", FacetKeeping::Subdivided, true, false}; }
  /// The mesh. Errors: see above.
  [[nodiscard]] Mesh operator()(const Plc& plc) const { return restored(plc).mesh; }

  /// The mesh with what became of the layers. Errors: see above.
  [[nodiscard]] RestoredMesh restored(const Plc& plc) const {
    const std::string text = switch_text();
    detail::require_sound(plc);
    const auto work = [&plc, &text] { return detail::run_tetgen(plc, text); };
    return restore_layers(child_process ? detail::raw_tets_from_child("TetGen", work, limits, progress) : work(), plc);
  }

  /// The switches that TetGen gets.
  [[nodiscard]] std::string switch_text() const {
    std::string text;
    if (!switches.empty()) {
      text = switches;
    } else {
      const auto number = [](double v) { return detail::fixed_text(v); };
      const auto check = [](const char* option, double value, bool good) {
        if (!good || !std::isfinite(value)) throw OptionError(option, detail::number_text(value) + " is not in range");
      };
      check("radius_edge", radius_edge, radius_edge == 0 || radius_edge > 1);
      check("min_dihedral", min_dihedral, min_dihedral >= 0 && min_dihedral < 90);
      check("max_volume", max_volume, max_volume >= 0);
      check("tolerance", tolerance, tolerance >= 0 && tolerance < 1);
      check("facet_angle", facet_angle, facet_angle > 90 && facet_angle <= 180);
      text = "p";
      if (radius_edge > 0) text += "q" + number(radius_edge) + (min_dihedral > 0 ? "/" + number(min_dihedral) : "");
      if (max_volume > 0) text += "a" + number(max_volume);
      if (tolerance > 0) text += "T" + detail::number_text(tolerance);
      if (keep_boundary) text += "Y";
    }
    // From a complex, vertices counted from 0, nothing printed.
    for (const char needed : {'p', 'z', 'Q'})
      if (text.find(needed) == std::string::npos) text += needed;
    const std::size_t after_p = text.find('p') + 1;
    if (after_p == text.size() || (text[after_p] != '.' && (text[after_p] < '0' || text[after_p] > '9')))
      text.insert(after_p, detail::fixed_text(facet_angle));
    return text;
  }
};

}  // namespace slice2mesh

#endif
