// SPDX-License-Identifier: MIT
/// @file
/// @brief Exodus II: MOOSE, ParaView. Needs netCDF; without it (SLICE2MESH_HAS_NETCDF not defined) writing is an error.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#ifdef SLICE2MESH_HAS_NETCDF
#include <netcdf.h>
#include <netcdf_mem.h>
#endif

#include "slice2mesh/core/atomic_file.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/fem/activation.hpp"
#include "slice2mesh/io/element_groups.hpp"
#include "slice2mesh/io/output_buffer.hpp"
#include "slice2mesh/io/write_options.hpp"

namespace slice2mesh {

#ifdef SLICE2MESH_HAS_NETCDF

/// Whether this build can write Exodus II.
inline constexpr bool kHasExodus = true;

namespace detail {

/// Number (1 to 4) of a face in the format: 1-2-4, 2-3-4, 1-4-3, 1-3-2.
[[nodiscard]] inline int exodus_face(std::int32_t face) {
  constexpr std::array<int, 4> kNumber = {2, 3, 1, 4};  // by opposite vertex
  return kNumber[static_cast<std::size_t>(face)];
}

/// A netCDF file in memory, as the library makes it.
class NetcdfInMemory {
public:
  NetcdfInMemory() {
    // The size given here would become the size of the file, with whatever is in memory behind what was written.
    check(nc_create_mem("slice2mesh", NC_64BIT_OFFSET, 0, &id_));
    open_ = true;
  }
  NetcdfInMemory(const NetcdfInMemory&) = delete;
  NetcdfInMemory& operator=(const NetcdfInMemory&) = delete;
  ~NetcdfInMemory() {
    NC_memio image{};
    if (open_ && nc_close_memio(id_, &image) == NC_NOERR) std::free(image.memory);
  }

  int dimension(const std::string& name, std::size_t size) {
    int result = 0;
    check(nc_def_dim(id_, name.c_str(), size, &result));
    return result;
  }
  int variable(const std::string& name, nc_type type, const std::vector<int>& dimensions) {
    int result = 0;
    check(nc_def_var(id_, name.c_str(), type, static_cast<int>(dimensions.size()), dimensions.data(), &result));
    return result;
  }
  void attribute(int variable, const char* name, const std::string& text) {
    check(nc_put_att_text(id_, variable, name, text.size(), text.c_str()));
  }
  void attribute(const char* name, int value) { check(nc_put_att_int(id_, NC_GLOBAL, name, NC_INT, 1, &value)); }
  void attribute(const char* name, float value) { check(nc_put_att_float(id_, NC_GLOBAL, name, NC_FLOAT, 1, &value)); }
  void end_definitions() { check(nc_enddef(id_)); }
  void put(int variable, const std::vector<double>& values) {
    if (!values.empty()) check(nc_put_var_double(id_, variable, values.data()));
  }
  void put(int variable, const std::vector<int>& values) {
    if (!values.empty()) check(nc_put_var_int(id_, variable, values.data()));
  }
  /// Names in rows of `width` characters, filled with zeros.
  void put(int variable, const std::vector<std::string>& names, std::size_t width) {
    std::string rows(names.size() * width, '\0');
    for (std::size_t i = 0; i < names.size(); ++i) names[i].copy(&rows[i * width], width - 1);
    if (!rows.empty()) check(nc_put_var_text(id_, variable, rows.data()));
  }
  /// The first record of a variable that has one per time step.
  void put_record(int variable, const std::vector<double>& values) {
    const std::array<std::size_t, 2> start = {0, 0};
    const std::array<std::size_t, 2> count = {1, values.size()};
    check(nc_put_vara_double(id_, variable, start.data(), count.data(), values.data()));
  }
  void close(OutputBuffer& out) {
    NC_memio image{};
    open_ = false;
    check(nc_close_memio(id_, &image));
    const std::unique_ptr<void, void (*)(void*)> memory(image.memory, std::free);
    out.bytes(image.memory, image.size);
    out.flush();
  }

private:
  static void check(int status) {
    if (status != NC_NOERR) throw Error(Stage::Write, std::string("netCDF: ") + nc_strerror(status));
  }
  int id_ = 0;
  bool open_ = false;
};

}  // namespace detail

/// Write a mesh as Exodus II (netCDF with 64-bit offsets; TETRA, with quadratic tets TETRA10). One element block per
/// slab and region, named "layer_0001_<region>", with ids 1, 2, ... by slab, then region; one side set per non-empty
/// boundary set, named, with the ids 1 bottom, 2 top, 3 wall, 4 upskin, 5 downskin, 6 support_interface,
/// 7 plate_interface; with `layer_faces` also covered_0002 (faces that layer 2 covers) and born_0001 (those that layer
/// 1 newly exposes). Node i of the mesh is node i + 1; elem_num_map has the numbers of the tets (from 1), which are
/// sorted by block. The element variable activation_time (s) is there where the options ask for it. Coordinates are
/// exact. Options used: quadratic, surfaces, interfaces, layer_faces, time_per_layer, activation. Errors: Error
/// (Stage::Write) for a mesh without tets or whose arrays do not fit together, or where netCDF fails. The state of the
/// stream tells whether everything was taken. Cost: linear; the file is made in memory. Two calls must not run at the
/// same time (netCDF cannot).
inline void write_exodus(std::ostream& out, const Mesh& mesh, const WriteOptions& options = {}) {
  detail::check_writable(mesh, options.poll);
  if (mesh.tets.empty()) throw Error(Stage::Write, "Exodus II cannot hold a mesh without elements");
  if (!(options.time_per_layer >= 0)) throw OptionError("time_per_layer", "must not be negative");
  const detail::ElementGroups elements = detail::group_elements(mesh, options.poll);
  const std::vector<std::string> regions = detail::region_names(mesh);
  const std::vector<detail::SurfaceSet> surfaces = detail::wanted_surfaces(mesh, options, true);
  const detail::FileNodes nodes(mesh, options);
  const bool with_times = options.activation || options.time_per_layer > 0;

  std::vector<std::string> block_names;
  std::vector<std::string> set_names;
  std::size_t longest = 32;
  for (const detail::ElementGroup& group : elements.groups) {
    block_names.push_back(detail::group_name(mesh, regions, group));
    longest = std::max(longest, block_names.back().size());
  }
  set_names.reserve(surfaces.size());
  for (const detail::SurfaceSet& set : surfaces) set_names.push_back(set.name);

  detail::NetcdfInMemory file;
  file.attribute("api_version", 5.14F);
  file.attribute("version", 5.14F);
  file.attribute("floating_point_word_size", 8);
  file.attribute("file_size", 1);
  file.attribute("maximum_name_length", static_cast<int>(longest));
  file.attribute("int64_status", 0);
  file.attribute(NC_GLOBAL, "title", "slice2mesh: lengths in mm");
  file.dimension("len_string", 33);
  file.dimension("len_line", 81);
  const int name_length = file.dimension("len_name", longest + 1);
  const int steps = file.dimension("time_step", NC_UNLIMITED);
  const int axes = file.dimension("num_dim", 3);
  const int node_dimension = file.dimension("num_nodes", nodes.count());
  const int element_dimension = file.dimension("num_elem", mesh.tets.size());
  const int block_dimension = file.dimension("num_el_blk", elements.groups.size());
  const int time_variable = file.variable("time_whole", NC_DOUBLE, {steps});
  const int axis_names = file.variable("coor_names", NC_CHAR, {axes, name_length});
  const std::array<int, 3> coordinates = {file.variable("coordx", NC_DOUBLE, {node_dimension}),
                                          file.variable("coordy", NC_DOUBLE, {node_dimension}),
                                          file.variable("coordz", NC_DOUBLE, {node_dimension})};
  const int element_map = file.variable("elem_num_map", NC_INT, {element_dimension});
  const int block_names_variable = file.variable("eb_names", NC_CHAR, {block_dimension, name_length});
  const int block_status = file.variable("eb_status", NC_INT, {block_dimension});
  const int block_ids = file.variable("eb_prop1", NC_INT, {block_dimension});
  file.attribute(block_ids, "name", "ID");
  std::vector<int> connectivity;
  std::vector<int> times;
  int variable_names = 0;
  if (with_times) {
    const int count = file.dimension("num_elem_var", 1);
    variable_names = file.variable("name_elem_var", NC_CHAR, {count, name_length});
  }
  for (std::size_t g = 0; g < elements.groups.size(); ++g) {
    const std::string number = std::to_string(g + 1);
    const int size = file.dimension("num_el_in_blk" + number, elements.groups[g].end - elements.groups[g].begin);
    const int corners = file.dimension("num_nod_per_el" + number, nodes.per_tet());
    connectivity.push_back(file.variable("connect" + number, NC_INT, {size, corners}));
    file.attribute(connectivity.back(), "elem_type", options.quadratic ? "TETRA10" : "TETRA");
    if (with_times) times.push_back(file.variable("vals_elem_var1eb" + number, NC_DOUBLE, {steps, size}));
  }
  int set_names_variable = 0;
  int set_status = 0;
  int set_ids = 0;
  std::vector<int> set_elements;
  std::vector<int> set_sides;
  if (!surfaces.empty()) {
    const int set_dimension = file.dimension("num_side_sets", surfaces.size());
    set_names_variable = file.variable("ss_names", NC_CHAR, {set_dimension, name_length});
    set_status = file.variable("ss_status", NC_INT, {set_dimension});
    set_ids = file.variable("ss_prop1", NC_INT, {set_dimension});
    file.attribute(set_ids, "name", "ID");
    for (std::size_t k = 0; k < surfaces.size(); ++k) {
      const std::string number = std::to_string(k + 1);
      const int size = file.dimension("num_side_ss" + number, surfaces[k].faces.size());
      set_elements.push_back(file.variable("elem_ss" + number, NC_INT, {size}));
      set_sides.push_back(file.variable("side_ss" + number, NC_INT, {size}));
    }
  }
  file.end_definitions();

  detail::Poll listen(options.poll, 1 << 16);
  file.put(axis_names, {"x", "y", "z"}, longest + 1);
  for (std::size_t i = 0; i < 3; ++i) {
    std::vector<double> values(nodes.count());
    for (std::size_t v = 0; v < values.size(); ++v) {
      listen();
      values[v] = nodes.position(v)[i];
    }
    file.put(coordinates[i], values);
  }
  std::vector<int> numbers(mesh.tets.size());
  std::vector<int> place(mesh.tets.size());  // of every tet in the file, from 1
  for (std::size_t i = 0; i < elements.order.size(); ++i) {
    listen();
    numbers[i] = static_cast<int>(elements.order[i]) + 1;
    place[elements.order[i]] = static_cast<int>(i) + 1;
  }
  file.put(element_map, numbers);
  file.put(block_names_variable, block_names, longest + 1);
  file.put(block_status, std::vector<int>(block_names.size(), 1));
  std::vector<int> ids;
  for (std::size_t g = 0; g < elements.groups.size(); ++g) ids.push_back(static_cast<int>(g) + 1);
  file.put(block_ids, ids);
  if (with_times) {
    file.put(variable_names, {"activation_time"}, longest + 1);
    file.put_record(time_variable, {0});
  }
  const std::int32_t plate = plate_slabs(mesh);
  for (std::size_t g = 0; g < elements.groups.size(); ++g) {
    const detail::ElementGroup& group = elements.groups[g];
    numbers.clear();
    std::vector<double> values;
    for (std::size_t i = group.begin; i < group.end; ++i) {
      listen();
      const std::size_t t = elements.order[i];
      for (std::size_t n = 0; n < nodes.per_tet(); ++n) numbers.push_back(static_cast<int>(nodes.of_tet(t, n)) + 1);
      if (with_times)
        values.push_back(options.activation ? options.activation(group.slab, t)
                                            : options.time_per_layer * std::max(0, group.slab - plate));
    }
    file.put(connectivity[g], numbers);
    if (with_times) file.put_record(times[g], values);
  }
  if (!surfaces.empty()) {
    file.put(set_names_variable, set_names, longest + 1);
    file.put(set_status, std::vector<int>(set_names.size(), 1));
    ids.clear();
    for (const detail::SurfaceSet& set : surfaces) ids.push_back(set.tag);
    file.put(set_ids, ids);
    for (std::size_t k = 0; k < surfaces.size(); ++k) {
      numbers.clear();
      std::vector<int> sides;
      for (const TetFace& f : surfaces[k].faces) {
        listen();
        numbers.push_back(place[static_cast<std::size_t>(f.tet)]);
        sides.push_back(detail::exodus_face(f.face));
      }
      file.put(set_elements[k], numbers);
      file.put(set_sides[k], sides);
    }
  }
  detail::OutputBuffer buffer(out, options.poll);
  file.close(buffer);
}

#else

/// Whether this build can write Exodus II.
inline constexpr bool kHasExodus = false;

/// Without netCDF: always throws Error (Stage::Write).
inline void write_exodus(std::ostream&, const Mesh&, const WriteOptions& = {}) {
  throw Error(Stage::Write, "this build cannot write Exodus II, which needs netCDF");
}

#endif

/// Write a mesh as Exodus II, whole or not at all. Errors: those of the stream version, FileError.
inline void write_exodus(const std::string& path, const Mesh& mesh, const WriteOptions& options = {}) {
  write_file_atomically(path, Stage::Write, [&](std::ostream& out) { write_exodus(out, mesh, options); });
}

}  // namespace slice2mesh
