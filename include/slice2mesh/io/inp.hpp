// SPDX-License-Identifier: MIT
/// @file
/// @brief Abaqus/CalculiX INP: the mesh, and a second file with steps that let layer after layer come to life.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "slice2mesh/core/atomic_file.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/fem/activation.hpp"
#include "slice2mesh/io/element_groups.hpp"
#include "slice2mesh/io/output_buffer.hpp"
#include "slice2mesh/io/write_options.hpp"

namespace slice2mesh {

namespace detail {

/// Reals are read from the first 20 characters of a field, so no number may be longer.
inline constexpr std::size_t kInpRealWidth = 20;

/// Number (1 to 4) of a face in the format: 1-2-3, 1-4-2, 2-4-3, 3-4-1.
[[nodiscard]] inline int inp_face(std::int32_t face) {
  constexpr std::array<int, 4> kNumber = {3, 4, 2, 1};  // by opposite vertex
  return kNumber[static_cast<std::size_t>(face)];
}

[[nodiscard]] inline std::string inp_layer(const Mesh& mesh, std::size_t slab) {
  return "LAYER_" + padded(slab + 1, mesh.slabs.size());
}

[[nodiscard]] inline std::string upper_case(std::string text) {
  for (char& c : text)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return text;
}

/// Ascending numbers (from 0) as a set, counted from 1: "first, last, 1" if they are one run (readers agree on one such
/// line only), else 16 to a line, as many as the format allows.
inline void put_inp_set(OutputBuffer& buffer, const char* type, const std::string& name,
                        const std::vector<std::size_t>& numbers) {
  const bool one_run = numbers.back() - numbers.front() + 1 == numbers.size();
  buffer.text("*").text(type).text(", ").text(type).text("=").text(name).text(one_run ? ", GENERATE\n" : "\n");
  if (one_run) {
    buffer.integer(numbers.front() + 1).text(", ").integer(numbers.back() + 1).text(", 1\n");
    return;
  }
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    buffer.integer(numbers[i] + 1);
    if (i + 1 < numbers.size()) buffer.text((i + 1) % 16 == 0 ? ",\n" : ", ");
  }
  buffer.character('\n');
}

/// True if the slab has tets.
[[nodiscard]] inline std::vector<bool> filled_slabs(const Mesh& mesh) {
  std::vector<bool> filled(mesh.slabs.size(), false);
  for (const std::int32_t s : mesh.tet_slab) filled[static_cast<std::size_t>(s)] = true;
  return filled;
}

/// Nodes of tets of the base plate, and of no others; ascending.
[[nodiscard]] inline std::vector<std::size_t> plate_nodes(const Mesh& mesh, const FileNodes& nodes) {
  std::vector<std::size_t> members;
  if (plate_slabs(mesh) == 0) return members;
  std::vector<bool> plate(nodes.count(), false);
  std::vector<bool> other(nodes.count(), false);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const bool in_plate = mesh.slabs[static_cast<std::size_t>(mesh.tet_slab[t])].is_plate();
    for (std::size_t i = 0; i < nodes.per_tet(); ++i) (in_plate ? plate : other)[nodes.of_tet(t, i)] = true;
  }
  for (std::size_t v = 0; v < nodes.count(); ++v)
    if (plate[v] && !other[v]) members.push_back(v);
  return members;
}

}  // namespace detail

/// Write a mesh as INP: nodes (set NALL), C3D4 elements (C3D10 with quadratic tets) in one set per layer (LAYER_0001,
/// ...), all of them (EALL), one set per region (REGION_<name>) and, with several regions, per layer and region
/// (LAYER_0001_<name>), the nodes of the bottom (BOTTOM_NODES) and those of the base plate alone (PLATE_NODES), and the
/// boundary sets as surfaces (BOTTOM, TOP, WALL, UPSKIN, DOWNSKIN, SUPPORT_INTERFACE, PLATE_INTERFACE), with
/// `layer_faces` also BORN_0001 (faces that layer 1 newly exposes) and COVERED_0002 (those that layer 2 covers).
/// Node and element numbers are those of the mesh plus one. Coordinates are the shortest text that reads back as the
/// same number where that fits into the 20 characters that solvers read, else rounded to fit (at least 13 digits).
/// Options used: quadratic, surfaces, interfaces, layer_faces.
/// Errors: Error (Stage::Write) for a mesh whose arrays do not fit together. The state of the stream tells whether
/// everything was taken. Cost: linear.
inline void write_inp(std::ostream& out, const Mesh& mesh, const WriteOptions& options = {}) {
  detail::check_writable(mesh, options.poll);
  const detail::ElementGroups elements = detail::group_elements(mesh, options.poll);
  const std::vector<std::string> names = detail::region_names(mesh);
  const std::vector<detail::SurfaceSet> surfaces = detail::wanted_surfaces(mesh, options, true);
  const detail::FileNodes nodes(mesh, options);
  detail::OutputBuffer buffer(out, options.poll);
  buffer.text("** slice2mesh: lengths in mm\n*NODE, NSET=NALL\n");
  for (std::size_t v = 0; v < nodes.count(); ++v) {
    buffer.integer(v + 1);
    for (const double x : nodes.position(v)) buffer.text(", ").real_within(x, detail::kInpRealWidth);
    buffer.character('\n');
  }
  const std::vector<detail::ElementGroup>& groups = elements.groups;
  std::vector<std::size_t> members;
  std::vector<std::size_t> layers;
  for (std::size_t g = 0; g < groups.size();) {
    std::size_t last = g + 1;
    while (last < groups.size() && groups[last].slab == groups[g].slab) ++last;
    members.assign(elements.order.begin() + static_cast<std::ptrdiff_t>(groups[g].begin),
                   elements.order.begin() + static_cast<std::ptrdiff_t>(groups[last - 1].end));
    std::sort(members.begin(), members.end());
    layers.push_back(static_cast<std::size_t>(groups[g].slab));
    buffer.text(options.quadratic ? "*ELEMENT, TYPE=C3D10, ELSET=" : "*ELEMENT, TYPE=C3D4, ELSET=");
    buffer.text(detail::inp_layer(mesh, layers.back())).character('\n');
    for (const std::size_t t : members) {
      buffer.integer(t + 1);
      for (std::size_t i = 0; i < nodes.per_tet(); ++i) buffer.text(", ").integer(nodes.of_tet(t, i) + 1);
      buffer.character('\n');
    }
    g = last;
  }
  if (!layers.empty()) {
    buffer.text("*ELSET, ELSET=EALL\n");
    for (const std::size_t s : layers) buffer.text(detail::inp_layer(mesh, s)).text(",\n");
  }
  for (std::size_t r = 0; r < names.size(); ++r) {
    members.clear();
    for (std::size_t t = 0; t < mesh.tets.size(); ++t)
      if (mesh.tet_region[t] == static_cast<std::int32_t>(r)) members.push_back(t);
    if (!members.empty()) detail::put_inp_set(buffer, "ELSET", "REGION_" + detail::upper_case(names[r]), members);
  }
  if (names.size() > 1)
    for (const detail::ElementGroup& group : groups) {
      members.assign(elements.order.begin() + static_cast<std::ptrdiff_t>(group.begin),
                     elements.order.begin() + static_cast<std::ptrdiff_t>(group.end));
      detail::put_inp_set(buffer, "ELSET", detail::upper_case(detail::group_name(mesh, names, group)), members);
    }
  if (!surfaces.empty() && surfaces[0].tag == static_cast<std::int32_t>(BoundaryKind::Bottom) + 1) {
    members.clear();
    for (const TetFace& f : surfaces[0].faces)
      for (std::size_t i = 0; i < nodes.per_face(); ++i) members.push_back(nodes.of_face(f, i));
    std::sort(members.begin(), members.end());
    members.erase(std::unique(members.begin(), members.end()), members.end());
    detail::put_inp_set(buffer, "NSET", "BOTTOM_NODES", members);
  }
  members = detail::plate_nodes(mesh, nodes);
  if (!members.empty()) detail::put_inp_set(buffer, "NSET", "PLATE_NODES", members);
  for (const detail::SurfaceSet& set : surfaces) {
    buffer.text("*SURFACE, NAME=").text(detail::upper_case(set.name)).text(", TYPE=ELEMENT\n");
    for (const TetFace& f : set.faces)
      buffer.integer(f.tet + 1).text(", S").integer(detail::inp_face(f.face)).character('\n');
  }
  buffer.flush();
}

/// Write a mesh as INP, whole or not at all. Errors: those of the stream version, FileError.
inline void write_inp(const std::string& path, const Mesh& mesh, const WriteOptions& options = {}) {
  write_file_atomically(path, Stage::Write, [&](std::ostream& out) { write_inp(out, mesh, options); });
}

/// Write the job that goes with `write_inp` (called with surfaces): it includes `mesh_file`, and has one transient heat
/// transfer step per layer. The first step removes all layers but the first (and the base plate, which has its own
/// initial temperature), every other one adds a layer; convection
/// acts in each step on the faces that are then exposed (element sets `KEPT_<layer>_F<face>`: exposed from that layer
/// on; `OPEN_<layer>_F<face>`: exposed until the next layer covers them). Precondition: every tet lies in its slab (the
/// certificate checks it). `poll` is called now and then, see `WriteOptions::poll`. Errors: OptionError for a value out
/// of its range, Error (Stage::Write, Stage::Fem). Cost:
/// linear in the mesh, and a few lines per pair of layers (convection is listed anew in every step).
inline void write_inp_steps(std::ostream& out, const Mesh& mesh, const std::string& mesh_file,
                            const InpStepOptions& options = {}, const std::function<void()>& poll = {}) {
  const auto require = [](bool good, const char* name, const char* range) {
    if (!good) throw OptionError(name, range);
  };
  require(options.time_per_layer > 0 && std::isfinite(options.time_per_layer), "time_per_layer", "must be > 0");
  require(options.first_increment > 0 && options.first_increment <= 1, "first_increment", "must be in (0, 1]");
  require(options.conductivity > 0 && std::isfinite(options.conductivity), "conductivity", "must be > 0");
  require(options.density > 0 && std::isfinite(options.density), "density", "must be > 0");
  require(options.specific_heat > 0 && std::isfinite(options.specific_heat), "specific_heat", "must be > 0");
  require(options.film_coefficient >= 0 && std::isfinite(options.film_coefficient), "film_coefficient", "must be >= 0");
  require(std::isfinite(options.initial_temperature), "initial_temperature", "must be finite");
  require(std::isfinite(options.sink_temperature), "sink_temperature", "must be finite");
  require(!options.base_temperature || std::isfinite(*options.base_temperature), "base_temperature", "must be finite");
  require(!options.plate_temperature || std::isfinite(*options.plate_temperature), "plate_temperature",
          "must be finite");
  if (mesh_file.find_first_of("\r\n") != std::string::npos)
    throw Error(Stage::Write, "the name of the mesh file has a line end");
  detail::check_writable(mesh, poll);
  const BoundarySets sets = boundary_sets(mesh, poll);
  const std::vector<bool> filled = detail::filled_slabs(mesh);
  const std::size_t slab_count = mesh.slabs.size();
  detail::OutputBuffer buffer(out, poll);
  const auto put_real = [&](double value) { buffer.real_within(value, detail::kInpRealWidth); };
  buffer.text("** slice2mesh: layers come to life one after the other\n*INCLUDE, INPUT=").text(mesh_file);
  buffer.text("\n*MATERIAL, NAME=PRINTED\n*CONDUCTIVITY\n");
  put_real(options.conductivity);
  buffer.text("\n*SPECIFIC HEAT\n");
  put_real(options.specific_heat);
  buffer.text("\n*DENSITY\n");
  put_real(options.density);
  buffer.text("\n*SOLID SECTION, ELSET=EALL, MATERIAL=PRINTED\n*INITIAL CONDITIONS, TYPE=TEMPERATURE\nNALL, ");
  put_real(options.initial_temperature);
  buffer.character('\n');
  const auto plate = static_cast<std::size_t>(plate_slabs(mesh));
  if (std::find(filled.begin(), filled.begin() + static_cast<std::ptrdiff_t>(plate), true) !=
      filled.begin() + static_cast<std::ptrdiff_t>(plate)) {
    buffer.text("PLATE_NODES, ");
    put_real(options.plate_temperature.value_or(options.sink_temperature));
    buffer.character('\n');
  }

  // Faces by the slab that exposes them, whether a later one covers them, and their number.
  struct FilmSet {
    std::string name;
    int face;
  };
  std::vector<std::vector<FilmSet>> kept(slab_count);
  std::vector<std::vector<FilmSet>> open(slab_count);  // covered by the next slab
  for (std::size_t k = 0; k < slab_count; ++k) {
    std::array<std::vector<std::size_t>, 4> kept_faces;
    std::array<std::vector<std::size_t>, 4> open_faces;
    for (std::size_t i = sets.born_begin[k]; i < sets.born_begin[k + 1]; ++i) {
      const GrowthFace& f = sets.growth[i];
      auto& lists = f.covered == kNone ? kept_faces : open_faces;
      lists[static_cast<std::size_t>(detail::inp_face(f.face.face)) - 1].push_back(
          static_cast<std::size_t>(f.face.tet));
    }
    for (std::size_t f = 0; f < 4; ++f) {
      const std::string suffix = detail::padded(k + 1, slab_count) + "_F" + std::to_string(f + 1);
      const int face = static_cast<int>(f) + 1;
      if (!kept_faces[f].empty()) {
        kept[k].push_back({"KEPT_" + suffix, face});
        detail::put_inp_set(buffer, "ELSET", kept[k].back().name, kept_faces[f]);
      }
      if (!open_faces[f].empty()) {
        open[k].push_back({"OPEN_" + suffix, face});
        detail::put_inp_set(buffer, "ELSET", open[k].back().name, open_faces[f]);
      }
    }
  }

  bool first = true;
  for (std::size_t k = 0; k < slab_count; ++k) {
    if (!filled[k] || (k < plate && plate < slab_count)) continue;
    buffer.text("** layer ").integer(k + 1).text("\n*STEP, INC=100000\n*HEAT TRANSFER\n");
    put_real(options.first_increment * options.time_per_layer);
    buffer.text(", ");
    put_real(options.time_per_layer);
    buffer.character('\n');
    if (first) {
      bool others = false;
      for (std::size_t j = k + 1; j < slab_count; ++j) {
        if (!filled[j]) continue;
        if (!others) buffer.text("*MODEL CHANGE, TYPE=ELEMENT, REMOVE\n");
        others = true;
        buffer.text(detail::inp_layer(mesh, j)).character('\n');
      }
      if (options.base_temperature) {
        buffer.text("*BOUNDARY\nBOTTOM_NODES, 11, 11, ");
        put_real(*options.base_temperature);
        buffer.character('\n');
      }
    } else {
      buffer.text("*MODEL CHANGE, TYPE=ELEMENT, ADD\n").text(detail::inp_layer(mesh, k)).character('\n');
    }
    first = false;
    buffer.text("*FILM, OP=NEW\n");
    const auto put_film = [&](const FilmSet& set) {
      buffer.text(set.name).text(", F").integer(set.face).text(", ");
      put_real(options.sink_temperature);
      buffer.text(", ");
      put_real(options.film_coefficient);
      buffer.character('\n');
    };
    for (std::size_t j = 0; j <= k; ++j)
      for (const FilmSet& set : kept[j]) put_film(set);
    for (const FilmSet& set : open[k]) put_film(set);
    buffer.text("*NODE FILE\nNT\n*END STEP\n");
  }
  buffer.flush();
}

/// Write the job, whole or not at all. `mesh_file` is the name under which the solver finds the mesh.
/// Errors: those of the stream version, FileError.
inline void write_inp_steps(const std::string& path, const Mesh& mesh, const std::string& mesh_file,
                            const InpStepOptions& options = {}, const std::function<void()>& poll = {}) {
  write_file_atomically(path, Stage::Write,
                        [&](std::ostream& out) { write_inp_steps(out, mesh, mesh_file, options, poll); });
}

/// Write a mesh and its job: the mesh at `path` (which ends in .inp), the steps at `<stem>_steps.inp` beside it, which
/// include the mesh by its name without folder. Both are complete before the first takes its place.
/// Errors: those of `write_inp` and `write_inp_steps`; OptionError if `surfaces` is off where the
/// steps need the nodes of the bottom; FileError.
inline void write_inp_job(const std::string& path, const Mesh& mesh, const InpStepOptions& steps,
                          const WriteOptions& options = {}) {
  if (!options.surfaces && steps.base_temperature)
    throw OptionError("surfaces", "must be on where the bottom is held at a temperature");
  const std::string stem = path.substr(0, path.size() - std::min(path.size(), detail::extension(path).size() + 1));
  const std::size_t slash = path.find_last_of("/\\");
  AtomicFile mesh_file(path, Stage::Write);
  AtomicFile step_file(stem + "_steps.inp", Stage::Write);
  write_inp(mesh_file.stream(), mesh, options);
  write_inp_steps(step_file.stream(), mesh, slash == std::string::npos ? path : path.substr(slash + 1), steps,
                  options.poll);
  mesh_file.commit();
  step_file.commit();
}

}  // namespace slice2mesh
