// SPDX-License-Identifier: MIT
/// @file
/// @brief ExternalMesher: any program as a tetrahedralizer, by files and a command line.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <random>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/mesh.hpp"
#include "slice2mesh/core/plc.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/io/element_groups.hpp"
#include "slice2mesh/io/write_mesh.hpp"
#include "slice2mesh/tet/child_process.hpp"
#include "slice2mesh/tet/read_tets.hpp"
#include "slice2mesh/tet/restore_layers.hpp"
#include "slice2mesh/tet/tetrahedralizer.hpp"

namespace slice2mesh {

namespace detail {

/// A directory of its own, removed with all that is in it.
class ScratchDirectory {
public:
  ScratchDirectory() {
    std::error_code code;
    const std::filesystem::path base = std::filesystem::temp_directory_path(code);
    std::random_device random;
    constexpr int kAttempts = 100;
    for (int i = 0; !code && i < kAttempts; ++i) {
      path_ = base / ("slice2mesh_" + std::to_string(random()) + "_" + std::to_string(i));
      if (std::filesystem::create_directory(path_, code)) {
        std::filesystem::permissions(path_, std::filesystem::perms::owner_all, code);
        return;
      }
    }
    throw TetrahedralizationError(-1, "no directory for the files of a mesher can be made in " + base.string());
  }
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;
  ~ScratchDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

private:
  std::filesystem::path path_;
};

/// A word that the shell takes as it is.
[[nodiscard]] inline std::string shell_word(const std::string& text) {
  std::string word = "'";
  for (const char c : text) {
    if (c == '\'')
      word += "'\\''";
    else
      word += c;
  }
  return word + "'";
}

/// A command line with places for files: {in}, {in:FORMAT}, {skin}, {skin:FORMAT}, {out}, {out:FORMAT}, {dir}.
struct CommandTemplate {
  struct File {
    bool skin = false;
    std::string extension;
    [[nodiscard]] std::string name() const { return (skin ? "skin." : "in.") + extension; }
    friend bool operator==(const File& a, const File& b) { return a.skin == b.skin && a.extension == b.extension; }
  };
  std::string line;          // with the places filled
  std::vector<File> inputs;  // each once
  std::string output;        // file name; empty: whatever the command leaves
};

[[nodiscard]] inline CommandTemplate fill_command(const std::string& command, const std::string& directory) {
  CommandTemplate result;
  for (std::size_t i = 0; i < command.size();) {
    const std::size_t end = command[i] == '{' ? command.find('}', i) : std::string::npos;
    const std::string inner = end == std::string::npos ? std::string() : command.substr(i + 1, end - i - 1);
    const std::size_t colon = inner.find(':');
    const std::string what = inner.substr(0, colon);
    std::string format = colon == std::string::npos ? std::string() : inner.substr(colon + 1);
    const auto check = [&](const char* standard, std::initializer_list<const char*> formats) {
      if (format.empty()) format = standard;
      if (std::none_of(formats.begin(), formats.end(), [&](const char* f) { return format == f; }))
        throw OptionError("command", "{" + inner + "}: there is no such format");
    };
    if (what == "in" || what == "skin") {
      check("off", {"off", "obj", "ply", "stl", "poly"});
      const CommandTemplate::File file{what == "skin", format};
      if (std::find(result.inputs.begin(), result.inputs.end(), file) == result.inputs.end())
        result.inputs.push_back(file);
      result.line += shell_word(directory + "/" + file.name());
    } else if (what == "out") {
      check("msh", {"msh", "mesh", "node", "ele"});
      if (!result.output.empty() && result.output != "out." + format)
        throw OptionError("command", "there are two different {out}");
      result.output = "out." + format;
      result.line += shell_word(directory + "/" + result.output);
    } else if (inner == "dir") {
      result.line += shell_word(directory);
    } else {
      result.line += command[i++];  // braces of the shell
      continue;
    }
    i = end + 1;
  }
  if (result.inputs.empty()) throw OptionError("command", "names no input: {in} or {skin}");
  return result;
}

}  // namespace detail

/// Runs a program: the complex goes out as a file, tets come back as a file. The layers are restored afterwards, see
/// `restore_layers`.
///
/// `command` is a line for `/bin/sh`, run in a directory of its own. `{in}` stands for the file of the complex,
/// `{skin}` for that of its outer skin alone, `{in:FORMAT}` and `{skin:FORMAT}` name the format: off (the default),
/// obj, ply, stl, poly. `{out}` (or `{out:FORMAT}`: msh, mesh, node, ele) is the file that the program writes; without
/// it, the one such file that it leaves in the directory, `{dir}`, is taken. Names are quoted for the shell. Errors:
/// OptionError for a command without {in} or with an unknown format; TetrahedralizationError for a complex that is not
/// sound and where the command fails, ends without a file or is over its limits; Cancelled, and what `progress` throws.
struct ExternalMesher {
  /// For the shell, with the placeholders above.
  std::string command;
  /// For reports.
  std::string name = "external";
  FacetKeeping facets = FacetKeeping::No;  ///< what the program promises
  /// What becomes of tets outside of the skin.
  OutsideTets outside = OutsideTets::Drop;
  /// Of the child process.
  ChildLimits limits;
  /// Listener; may cancel.
  Progress progress;

  /// What the model promises.
  [[nodiscard]] TetrahedralizerTraits traits() const { return {name, facets, false, false}; }
  /// The mesh. Errors: see above.
  [[nodiscard]] Mesh operator()(const Plc& plc) const { return restored(plc).mesh; }

  /// The mesh with what became of the layers. Errors: see above.
  [[nodiscard]] RestoredMesh restored(const Plc& plc) const {
    detail::require_sound(plc);
    const detail::ScratchDirectory directory;
    const detail::CommandTemplate filled = detail::fill_command(command, directory.path().string());
    RawTets tets;
    try {
      for (const detail::CommandTemplate::File& file : filled.inputs) {
        PlcWriteOptions options;
        options.inner_faces = !file.skin;
        write_plc((directory.path() / file.name()).string(), plc, options);
      }
      const ChildResult run = run_command(name, filled.line, directory.path().string(), limits, progress);
      if (run.exit_code != 0)
        throw TetrahedralizationError(-1, name + " ended with code " + std::to_string(run.exit_code) + last_words(run));
      tets = read_tets(output_of(directory.path(), filled, run));
    } catch (const FileError& error) {
      throw TetrahedralizationError(-1, name + ": " + error.what());
    }
    RestoreOptions restore;
    restore.outside = outside;
    return restore_layers(std::move(tets), plc, restore);
  }

private:
  /// The last line that the program printed.
  [[nodiscard]] static std::string last_words(const ChildResult& run) {
    std::string text(run.bytes.begin(), run.bytes.end());
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r' || text.back() == ' ')) text.pop_back();
    const std::size_t line = text.find_last_of('\n');
    if (line != std::string::npos) text.erase(0, line + 1);
    constexpr std::size_t kLongest = 200;
    return text.empty() ? std::string() : ": " + text.substr(0, kLongest);
  }

  [[nodiscard]] std::string output_of(const std::filesystem::path& directory, const detail::CommandTemplate& filled,
                                      const ChildResult& run) const {
    std::vector<std::string> found;
    std::error_code code;  // a directory that the program took away has no mesh either
    if (!filled.output.empty()) {
      if (std::filesystem::exists(directory / filled.output, code))
        found.push_back((directory / filled.output).string());
    } else {
      std::filesystem::directory_iterator entry(directory, code);
      for (; !code && entry != std::filesystem::directory_iterator(); entry.increment(code)) {
        const std::string path = entry->path().string();
        const std::string extension = detail::extension(path);
        if (extension == "msh" || extension == "mesh" || extension == "ele") found.push_back(path);
      }
    }
    if (found.empty()) throw TetrahedralizationError(-1, name + " left no mesh" + last_words(run));
    if (found.size() > 1)
      throw TetrahedralizationError(
          -1, name + " left " + std::to_string(found.size()) + " meshes: say with {out} which one it is");
    return found.front();
  }
};

}  // namespace slice2mesh
