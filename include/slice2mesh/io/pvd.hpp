// SPDX-License-Identifier: MIT
/// @file
/// @brief PVD: the growing domains of a print as a time series of VTU files.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <ostream>
#include <random>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "slice2mesh/core/atomic_file.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/fem/activation.hpp"
#include "slice2mesh/io/element_groups.hpp"
#include "slice2mesh/io/output_buffer.hpp"
#include "slice2mesh/io/vtu.hpp"
#include "slice2mesh/io/write_options.hpp"

namespace slice2mesh {

/// One step of a time series: the print after the deposition of a layer.
struct PvdFrame {
  std::int32_t slab = 0;  ///< index of the last one deposited
  double time = 0;        ///< s, or the number of the layer where the options give no times
  std::string file;       ///< name of the VTU file, as the collection has it
};

/// The steps of the print: one per slab that has elements, from below; the base plate is part of the first one. The
/// time of a step is the latest at which an element of it comes to life: with `time_per_layer` the number of the layer
/// times that, with `activation` the largest of its values so far, with neither the number of the layer (from 0).
/// `folder` goes before the names of the files. Errors: Error (Stage::Fem) if the arrays of the mesh do not fit
/// together. Cost: linear.
[[nodiscard]] inline std::vector<PvdFrame> pvd_frames(const Mesh& mesh, const std::string& folder,
                                                      const WriteOptions& options = {}) {
  if (!(options.time_per_layer >= 0)) throw OptionError("time_per_layer", "must not be negative");
  const std::int32_t plate = plate_slabs(mesh);
  std::vector<PvdFrame> frames;
  double latest = 0;
  bool any = false;
  for (const GrowingDomain& domain : growing_domains(mesh)) {
    if (options.activation)
      for (const std::int32_t t : domain.born) {
        const double time = options.activation(domain.slab, static_cast<std::size_t>(t));
        latest = any ? std::max(latest, time) : time;
        any = true;
      }
    // Slabs of the plate alone are no step of the print, unless there is nothing else.
    const bool plate_only = domain.slab < plate && static_cast<std::size_t>(plate) < mesh.slabs.size();
    if (domain.born.empty() || plate_only) continue;
    const std::int32_t layer = std::max(0, domain.slab - plate);
    PvdFrame frame;
    frame.slab = domain.slab;
    frame.time = options.activation             ? latest
                 : (options.time_per_layer > 0) ? options.time_per_layer * layer
                                                : static_cast<double>(layer);
    frame.file =
        folder + "layer_" + detail::padded(static_cast<std::size_t>(domain.slab) + 1, mesh.slabs.size()) + ".vtu";
    frames.push_back(std::move(frame));
  }
  return frames;
}

/// Write the collection alone: the times and names of `frames`, one per step. The state of the stream tells whether
/// everything was taken.
inline void write_pvd(std::ostream& out, const std::vector<PvdFrame>& frames) {
  detail::OutputBuffer buffer(out);
  buffer.text("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"")
      .text(detail::is_little_endian() ? "LittleEndian" : "BigEndian")
      .text("\">\n<Collection>\n");
  for (const PvdFrame& frame : frames) {
    buffer.text("<DataSet timestep=\"").real(frame.time).text("\" part=\"0\" file=\"");
    for (const char c : frame.file) {
      if (c == '&')
        buffer.text("&amp;");
      else if (c == '<')
        buffer.text("&lt;");
      else if (c == '"')
        buffer.text("&quot;");
      else
        buffer.character(c);
    }
    buffer.text("\"/>\n");
  }
  buffer.text("</Collection>\n</VTKFile>\n");
  buffer.flush();
}

/// Write one step as VTU: the sub-mesh of the slabs up to that of the frame. Errors and options: those of `write_vtu`.
inline void write_pvd_frame(std::ostream& out, const Mesh& mesh, const PvdFrame& frame,
                            const WriteOptions& options = {}) {
  const SubMesh domain = layers_of(mesh, 0, frame.slab, options.poll);
  WriteOptions own = options;
  if (options.activation)
    own.activation = [&](std::int32_t slab, std::size_t tet) {
      return options.activation(slab, static_cast<std::size_t>(domain.tet_in_whole[tet]));
    };
  write_vtu(out, domain.mesh, own);
}

namespace detail {

/// A folder that takes the place of another one when it is complete, and is removed otherwise.
class AtomicFolder {
public:
  /// Errors: FileError if something else has the name, or the folder cannot be created.
  explicit AtomicFolder(std::filesystem::path target) : target_(std::move(target)) {
    namespace fs = std::filesystem;
    std::error_code code;
    if (fs::exists(fs::symlink_status(target_, code))) {
      if (!fs::is_directory(target_, code)) throw FileError(Stage::Write, target_.string(), "is not a folder");
      // It is going to be replaced: nothing of anyone else may be in it.
      for (const fs::directory_entry& entry : fs::directory_iterator(target_, code)) {
        const std::string name = entry.path().filename().string();
        if (name.rfind("layer_", 0) != 0 || entry.path().extension() != ".vtu")
          throw FileError(Stage::Write, target_.string(), "holds " + name + ", which is not a step of a PVD file");
      }
      if (code) throw FileError(Stage::Write, target_.string(), "cannot be read: " + code.message());
    }
    std::random_device random;
    temporary_ = target_;
    temporary_ += ".tmp" + std::to_string(random());
    if (!fs::create_directory(temporary_, code)) {
      const std::string reason = code ? code.message() : "exists";
      temporary_.clear();
      throw FileError(Stage::Write, target_.string(), "cannot be created: " + reason);
    }
  }
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;
  ~AtomicFolder() {
    std::error_code ignored;
    if (!temporary_.empty()) std::filesystem::remove_all(temporary_, ignored);
  }
  [[nodiscard]] const std::filesystem::path& path() const { return temporary_; }
  void commit() {
    namespace fs = std::filesystem;
    std::error_code code;
    std::error_code ignored;
    // The old folder steps aside, and comes back if the new one cannot take its place.
    fs::path old = temporary_;
    old += "_old";
    const bool replaces = fs::exists(target_, ignored);
    if (replaces) fs::rename(target_, old, code);
    if (!code) {
      fs::rename(temporary_, target_, code);
      if (code && replaces) fs::rename(old, target_, ignored);
    }
    if (code) throw FileError(Stage::Write, target_.string(), "cannot be replaced: " + code.message());
    temporary_.clear();
    if (replaces) fs::remove_all(old, ignored);
  }

private:
  std::filesystem::path target_;
  std::filesystem::path temporary_;
};

}  // namespace detail

/// Write the growing domains of a print: the collection at `path`, and the steps as VTU files in the folder
/// `<stem>_layers` beside it, which is replaced. Every step is a whole mesh: N layers take about N/2 times the space of
/// one VTU file, so that one VTU file with the cell array `layer` is the better choice for most uses. The folder
/// appears when all steps are complete, and the collection after it. Options: those of `write_vtu`. Errors: those of
/// `write_vtu`; FileError, also if the folder holds other files. Cost: #S times the cost of the mesh.
inline void write_pvd(const std::string& path, const Mesh& mesh, const WriteOptions& options = {}) {
  namespace fs = std::filesystem;
  const fs::path target(path);
  const std::string folder = target.stem().string() + "_layers";
  const std::vector<PvdFrame> frames = pvd_frames(mesh, folder + "/", options);
  AtomicFile collection(path, Stage::Write);
  write_pvd(collection.stream(), frames);
  detail::AtomicFolder steps(target.parent_path() / folder);
  for (const PvdFrame& frame : frames)
    write_file_atomically((steps.path() / frame.file.substr(folder.size() + 1)).string(), Stage::Write,
                          [&](std::ostream& out) { write_pvd_frame(out, mesh, frame, options); });
  steps.commit();
  collection.commit();
}

}  // namespace slice2mesh
