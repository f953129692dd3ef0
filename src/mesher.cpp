// SPDX-License-Identifier: MIT
#include "mesher.hpp"

#include <filesystem>
#include <string>

#include "exit_codes.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/tet/external_model.hpp"
#include "slice2mesh/tet/slab_filler.hpp"

#ifdef SLICE2MESH_PROGRAM_TETGEN
#include "slice2mesh/tet/tetgen_model.hpp"
#endif

namespace slice2mesh_program {

namespace {

void refuse_arguments(const MesherChoice& choice) {
  if (!choice.arguments.empty()) throw UsageError("--mesher-args: the mesher " + choice.mesher + " takes none");
}

slice2mesh::AnyTetrahedralizer make_tetgen(const MesherChoice& choice) {
#ifdef SLICE2MESH_PROGRAM_TETGEN
  slice2mesh::TetGenMesher tetgen;
  tetgen.switches = choice.arguments;
  if (choice.time_limit > 0) tetgen.limits.time = choice.time_limit;
  return tetgen;
#else
  (void)choice;
  throw UsageError(
      "--mesher tetgen: this program was built without TetGen (SLICE2MESH_WITH_TETGEN); its own program will do: "
      "--mesher \"tetgen -pQ {in:poly}\"");
#endif
}

// The program alone, as a name for reports.
std::string first_word(const std::string& command) {
  const std::size_t begin = command.find_first_not_of(' ');
  const std::string word = command.substr(begin, command.find(' ', begin) - begin);
  return std::filesystem::path(word).filename().string();
}

}  // namespace

slice2mesh::AnyTetrahedralizer make_mesher(const MesherChoice& choice) {
  if (choice.mesher == "slab") {
    refuse_arguments(choice);
    slice2mesh::SlabFiller filler;
    filler.max_tets = choice.max_tets;
    return filler;
  }
  if (choice.mesher == "tetgen") return make_tetgen(choice);
  if (choice.mesher == "mesh3") return make_mesh3(choice);
  if (choice.mesher == "cdt3") {
    refuse_arguments(choice);
    return make_cdt3(choice);
  }
  slice2mesh::ExternalMesher external;
  external.command = choice.mesher + (choice.arguments.empty() ? "" : " " + choice.arguments);
  try {
    (void)slice2mesh::detail::fill_command(external.command, ".");
  } catch (const slice2mesh::OptionError& error) {
    throw UsageError("--mesher '" + choice.mesher +
                     "' is neither slab, mesh3, tetgen, cdt3 nor a command: " + error.what());
  }
  external.name = first_word(external.command);
  if (choice.time_limit > 0) external.limits.time = choice.time_limit;
  return external;
}

}  // namespace slice2mesh_program
