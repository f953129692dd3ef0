// SPDX-License-Identifier: MIT
/// @file
/// @brief Options of the writers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

namespace slice2mesh {

/// A thermal job in which the layers come to life one after the other, each at the initial temperature. Units are those
/// of the solver; the mesh is in mm, and the defaults are those of a steel in mm, s, K, t (1e3 kg), mJ.
struct InpStepOptions {
  double time_per_layer = 10;               ///< s, > 0: length of a step
  double first_increment = 0.1;             ///< > 0: of a step, as a share of its length, at most 1
  double conductivity = 20;                 ///< mW/(mm K), > 0
  double density = 8e-9;                    ///< t/mm^3, > 0
  double specific_heat = 5e8;               ///< mJ/(t K), > 0
  double initial_temperature = 1500;        ///< K, of each layer when it comes to life
  double film_coefficient = 0.05;           ///< mW/(mm^2 K), >= 0, over the surface exposed in each step
  double sink_temperature = 300;            ///< K, of the surroundings
  std::optional<double> base_temperature;   ///< K; if set, the nodes of the bottom are held at it
  std::optional<double> plate_temperature;  ///< K, of the base plate at the beginning; unset: `sink_temperature`
};

/// What the mesh writers can be told. A field that a format has no use for is ignored by it.
struct WriteOptions {
  bool binary = false;       ///< MSH: binary instead of text
  bool compress = false;     ///< VTU, PVD: zlib; OptionError where the build has no zlib (SLICE2MESH_HAS_ZLIB)
  bool quadratic = false;    ///< VTU, PVD, MSH, INP, Exodus: tets of 10 nodes; edges stay straight
  bool surfaces = true;      ///< MSH, MEDIT, INP, MFEM, Exodus: write the boundary sets
  bool interfaces = true;    ///< with the inner faces between part, support and plate (some readers refuse inner faces)
  bool layer_faces = false;  ///< with the faces that each layer covers, and (INP, Exodus) those that it newly exposes
  bool mfem_names = false;   ///< MFEM: format v1.3 with named sets instead of v1.0
  /// s, >= 0; if > 0 (or `activation` is set) VTU has the cell array activation_time = layer * time_per_layer, and PVD
  /// uses it as the time of its steps
  double time_per_layer = 0;
  /// time (s) at which a tet comes to life, from its slab and index; used instead of time_per_layer if set
  std::function<double(std::int32_t slab, std::size_t tet)> activation;
  /// INP, `write_mesh` with a path: if set, `<stem>_steps.inp` is written as well, the job of `write_inp_steps`
  std::optional<InpStepOptions> inp_steps;
  /// every format: called now and then; what it throws ends the writing and goes on to the caller, and where a path was
  /// given no file is left
  std::function<void()> poll;
};

/// What the PLC writers can be told.
struct PlcWriteOptions {
  bool inner_faces = true;     ///< false: the outer skin alone, with the vertices it uses
  std::function<void()> poll;  ///< called now and then, see `WriteOptions::poll`
};

}  // namespace slice2mesh
