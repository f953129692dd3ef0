// SPDX-License-Identifier: MIT
// The program slice2mesh: the command line.
#include <CLI/CLI.hpp>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <functional>
#include <limits>
#include <map>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "exit_codes.hpp"
#include "info.hpp"
#include "interrupt.hpp"
#include "lengths.hpp"
#include "mesh.hpp"
#include "mesher.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/version.hpp"

namespace slice2mesh_program {

namespace {

using slice2mesh::Length;

// What `parse` makes of the text given to an option; it gives nothing where the text is wrong.
template <class Parse>
auto value_of(const std::string& name, const std::string& given, Parse parse, const std::string& type) {
  const auto parsed = parse(given);
  if (!parsed) throw CLI::ValidationError(name, "'" + given + "' is not a " + type);
  return *parsed;
}

// An option whose text is turned into a value by `parse`.
template <class Value, class Parse>
CLI::Option* add_parsed(CLI::App& app, const std::string& name, Value& value, Parse parse, const std::string& type,
                        const std::string& text, const std::string& standard) {
  const auto set = [&value, parse, name, type](const std::string& given) {
    value = static_cast<Value>(value_of(name, given, parse, type));
  };
  CLI::Option* option = app.add_option_function<std::string>(name, set, text)->type_name(type);
  if (!standard.empty()) option->default_str(standard);
  return option;
}

// The same for an option that may be given several times: `take` gets each of the values.
template <class Parse, class Take>
CLI::Option* add_each(CLI::App& app, const std::string& name, Parse parse, Take take, const std::string& type,
                      const std::string& text) {
  const auto take_all = [parse, take, name, type](const std::vector<std::string>& given) {
    for (const std::string& one : given) take(value_of(name, one, parse, type));
  };
  return app.add_option_function<std::vector<std::string>>(name, take_all, text)
      ->type_name(type)
      ->allow_extra_args(false);
}

CLI::Option* add_length(CLI::App& app, const std::string& name, Length& value, const std::string& text) {
  return add_parsed(app, name, value, parse_length, "LENGTH", text, to_text(value));
}

CLI::Option* add_number(CLI::App& app, const std::string& name, double& value, const std::string& text) {
  return add_parsed(app, name, value, parse_number, "NUMBER", text, to_text(Length::mm(value)));
}

template <class Integer>
CLI::Option* add_count(CLI::App& app, const std::string& name, Integer& value, const std::string& text) {
  const auto parse = [](const std::string& given) {
    const auto count = parse_count(given);
    return count && *count <= std::numeric_limits<Integer>::max() ? count : std::nullopt;
  };
  return add_parsed(app, name, value, parse, "COUNT", text, std::to_string(value));
}

// An option with one of several words.
template <class Enumeration>
CLI::Option* add_choice(CLI::App& app, const std::string& name, Enumeration& value,
                        const std::vector<std::pair<std::string, Enumeration>>& choices, const std::string& text) {
  std::string type;
  std::string standard;
  for (const auto& [word, meaning] : choices) {
    type += (type.empty() ? "" : "|") + word;
    if (meaning == value) standard = word;
  }
  const auto parse = [choices](const std::string& given) -> std::optional<Enumeration> {
    for (const auto& [word, meaning] : choices)
      if (word == given) return meaning;
    return std::nullopt;
  };
  return add_parsed(app, name, value, parse, type, text, standard);
}

void add_reading_options(CLI::App& app, slice2mesh::CliReadOptions& read, slice2mesh::SlabOptions& slabs) {
  using slice2mesh::CliCloseLines;
  using slice2mesh::CliOrientation;
  using slice2mesh::CliShortCoordinates;
  using slice2mesh::CliZUnit;
  using slice2mesh::ZConvention;
  std::vector<std::pair<std::string, ZConvention>> conventions;
  for (const ZConvention convention :
       {ZConvention::Auto, ZConvention::Top, ZConvention::Bottom, ZConvention::Middle, ZConvention::Paper})
    conventions.emplace_back(to_string(convention), convention);
  add_choice(app, "--z-convention", slabs.z_convention, conventions,
             "Where the z of a slice lies in its layer; paper: extrude upward from z and drop the last slice");

  const std::string reading = "Reading";
  add_choice<CliOrientation>(app, "--orientation", read.orientation,
                             {{"auto", CliOrientation::Auto},
                              {"dir", CliOrientation::Dir},
                              {"winding", CliOrientation::Winding},
                              {"nesting", CliOrientation::Nesting}},
                             "What decides whether a contour bounds a hole")
      ->group(reading);
  add_choice<CliCloseLines>(
      app, "--close-lines", read.close_lines,
      {{"auto", CliCloseLines::Auto}, {"never", CliCloseLines::Never}, {"always", CliCloseLines::Always}},
      "Whether an open line that ends where it began is a contour")
      ->group(reading);
  add_choice<CliZUnit>(app, "--z-unit", read.z_unit,
                       {{"auto", CliZUnit::Auto}, {"units", CliZUnit::Units}, {"mm", CliZUnit::Millimeters}},
                       "What the heights of the file count")
      ->group(reading);
  add_choice<CliShortCoordinates>(app, "--short-coordinates", read.short_coordinates,
                                  {{"auto", CliShortCoordinates::Auto},
                                   {"unsigned", CliShortCoordinates::Unsigned},
                                   {"signed", CliShortCoordinates::Signed}},
                                  "How 16-bit coordinates of binary files are read")
      ->group(reading);
  add_number(app, "--unit", read.unit, "mm per unit of the file, instead of what it says; 0: what it says")
      ->group(reading);
}

void add_meshing_options(CLI::App& app, slice2mesh::Options& options) {
  using slice2mesh::LineCap;
  using slice2mesh::LineJoin;
  app.add_option_function<std::string>(
         "--lump",
         [&options](const std::string& given) {
           const std::optional<Lump> lump = parse_lump(given);
           if (!lump) throw CLI::ValidationError("--lump", "'" + given + "' is neither a COUNT nor a thickness in mm");
           options.slabs.lump = lump->count;
           options.slabs.lump_thickness = lump->thickness;
         },
         "Slices that make one slab together: so many (4), or up to a thickness (0.2mm)")
      ->type_name("COUNT|THICKNESS")
      ->default_str("1");
  app.add_flag_callback(
      "--no-open-line-layers", [&options] { options.slabs.with_open_lines = false; },
      "Layers that have only open lines count as empty");

  const std::string supports = "Supports (open lines)";
  add_length(app, "--support-radius", options.supports.radius, "Half the width of a line; 0: left out")
      ->group(supports);
  add_each(
      app, "--support-radius-of", parse_part_length,
      [&options](const auto& of_part) { options.supports.part_radius[of_part.first] = of_part.second; }, "PART:LENGTH",
      "The same for the lines of one part id (7:0.2), in place of --support-radius; repeatable")
      ->group(supports);
  add_choice<LineCap>(app, "--support-cap", options.supports.cap,
                      {{"round", LineCap::Round}, {"square", LineCap::Square}, {"flat", LineCap::Flat}},
                      "Ends of a line")
      ->group(supports);
  add_choice<LineJoin>(app, "--support-join", options.supports.join,
                       {{"round", LineJoin::Round}, {"miter", LineJoin::Miter}}, "Corners of a line")
      ->group(supports);
  add_number(app, "--support-miter-limit", options.supports.miter_limit,
             "Longest miter, in radii; longer ones are beveled")
      ->group(supports);
  add_number(app, "--support-arc-tolerance", options.supports.arc_tolerance,
             "Largest distance from a true arc, in radii")
      ->group(supports);
  add_number(app, "--support-simplify", options.supports.simplify,
             "Tolerance of the simplification of a line, in radii")
      ->group(supports);

  using slice2mesh::BasePlateShape;
  const std::string plate = "Base plate";
  add_length(app, "--plate-thickness", options.plate.thickness, "Thickness of a plate under the part; 0: none")
      ->group(plate);
  add_length(app, "--plate-margin", options.plate.margin, "How far the plate reaches beyond the part")->group(plate);
  add_choice<BasePlateShape>(app, "--plate-shape", options.plate.shape,
                             {{"box", BasePlateShape::Box}, {"offset", BasePlateShape::Offset}},
                             "Box around the part, or what is within the margin of its first slice")
      ->group(plate);
  add_count(app, "--plate-slabs", options.plate.slabs,
            "Slabs of equal height that the plate is made of; 0: higher ones the deeper they lie")
      ->group(plate);

  const std::string elements = "Elements";
  add_length(app, "--eps", options.eps,
             "A layer differs from the one below only where the difference is at least this wide; 0: exact")
      ->group(elements);
  add_length(app, "--size", options.size.size,
             "Edge length in the interior; 0: twice the layer thickness, or more for "
             "very large parts")
      ->group(elements);
  add_length(app, "--coarsest", options.size.coarsest, "Largest automatic size")->group(elements);
  add_number(app, "--automatic-tets", options.size.automatic_tets,
             "Elements that the automatic size aims to stay below")
      ->group(elements);
  add_length(app, "--contour-size", options.size.contour_size, "Longest edge of a contour; 0: chosen from --size")
      ->group(elements);
  add_count(app, "--improve-rounds", options.improve.rounds, "Rounds of improvement; 0: the raw fill")->group(elements);
  add_number(app, "--improve-target", options.improve.target,
             "Elements with a worse R/3r are flipped, and contours moved at them")
      ->group(elements);
  add_number(app, "--collapse-above", options.improve.collapse_above,
             "Vertices of elements with a worse R/3r are taken out where that gains")
      ->group(elements);
  add_number(app, "--improve-work", options.improve.most_work, "The rounds end when so many elements have been rated")
      ->group(elements);

  add_number(app, "--growth", options.size.growth,
             "Growth of sizes with the distance from contours and from --refine, over that distance")
      ->group(elements);
  add_each(
      app, "--refine", parse_ball,
      [&options](const slice2mesh::RefinedBall& ball) { options.size.refined.push_back(ball); }, "X,Y,Z,RADIUS:LENGTH",
      "Edge length in a ball, in mm (10,5,2,3:0.5h); repeatable")
      ->group(elements);

  app.add_flag_callback(
         "--keep-contours", [&options] { options.improve.move_contours = false; },
         "Improvement moves no contour vertex (else within --eps, where elements gain)")
      ->group(elements);

  app.add_flag("--keep-columns", options.improve.keep_columns,
               "Improvement keeps vertical edges where no element at them is bad: prisms, where contours stay the same")
      ->group(elements);

  app.add_flag_callback(
      "--no-finer-slices", [&options] { options.finer_slices = false; },
      "Do not measure what bundles (--lump) lose against all their slices");

  const std::string limits = "Limits (0: none)";
  add_count(app, "--max-vertices", options.budget.max_vertices, "Vertices of the mesh")->group(limits);
  add_count(app, "--max-tets", options.budget.max_tets, "Elements of the mesh")->group(limits);
  add_number(app, "--time-limit", options.budget.time_limit, "Seconds of wall-clock time")->group(limits);
}

void add_format_options(CLI::App& app, slice2mesh::WriteOptions& write) {
  const std::string formats = "Formats";
  app.add_flag("--quadratic", write.quadratic, "Elements of ten nodes (VTU, PVD, MSH, INP, Exodus)")->group(formats);
  app.add_flag("--binary", write.binary, "Write MSH files binary instead of as text")->group(formats);
  app.add_flag("--compress", write.compress, "Compress VTU files (where the program was built with zlib)")
      ->group(formats);
  app.add_flag("--mfem-names", write.mfem_names, "Write MFEM files with named sets (version 1.3)")->group(formats);
  app.add_flag_callback(
         "--no-interfaces", [&write] { write.interfaces = false; },
         "Leave out the inner faces between part, supports and plate, which some programs refuse (deal.II)")
      ->group(formats);
  app.add_flag_callback(
         "--no-surfaces", [&write] { write.surfaces = false; }, "Leave out all sets of faces")
      ->group(formats);
  app.add_flag("--layer-faces", write.layer_faces, "Write the faces that each layer covers and newly exposes")
      ->group(formats);
  add_number(app, "--time-per-layer", write.time_per_layer,
             "Seconds from layer to layer: activation times in VTU, PVD and Exodus, steps of INP; 0: not given")
      ->group(formats);
}

void add_step_options(CLI::App& app, bool& wanted, slice2mesh::InpStepOptions& steps) {
  const std::string group = "Steps of INP files (mm, s, K, t, mW)";
  app.add_flag("--steps", wanted, "Write, with every x.inp, x_steps.inp: a thermal job that adds layer after layer")
      ->group(group);
  add_number(app, "--first-increment", steps.first_increment, "First increment of a step, as a share of it")
      ->group(group);
  add_number(app, "--conductivity", steps.conductivity, "Conductivity")->group(group);
  add_number(app, "--density", steps.density, "Density")->group(group);
  add_number(app, "--specific-heat", steps.specific_heat, "Specific heat")->group(group);
  add_number(app, "--initial-temperature", steps.initial_temperature, "Temperature of a layer when it comes to life")
      ->group(group);
  add_number(app, "--film", steps.film_coefficient, "Film coefficient of the exposed surface")->group(group);
  add_number(app, "--sink-temperature", steps.sink_temperature, "Temperature of the surroundings")->group(group);
  add_parsed(app, "--base-temperature", steps.base_temperature, parse_number, "NUMBER",
             "Temperature at which the bottom is held", "free")
      ->group(group);
  add_parsed(app, "--plate-temperature", steps.plate_temperature, parse_number, "NUMBER",
             "Temperature of the base plate at the beginning", "that of the surroundings")
      ->group(group);
}

// Errors are printed in one place, here, once.
int fail(int code, const std::string& message) {
  std::fprintf(stderr, "slice2mesh: %s\n", message.c_str());
  return code;
}

int exit_code(const slice2mesh::Error& error) {
  if (dynamic_cast<const slice2mesh::OptionError*>(&error) != nullptr) return kExitUsage;
  if (error.stage() == slice2mesh::Stage::Read || error.stage() == slice2mesh::Stage::Write) return kExitInput;
  return kExitMeshing;
}

int run(int argc, char** argv) {
  CLI::App app(
      "Makes a tetrahedral mesh of the slices of a 3D print in which every element lies in one layer.\n"
      "A LENGTH is in mm (0.1) or in layer thicknesses (0.1h).",
      "slice2mesh");
  app.set_version_flag("--version", "slice2mesh " SLICE2MESH_VERSION);
  app.footer(
      "Exit codes: 0 ok, 1 usage, 2 a file cannot be read or written, 3 no mesh can be made, 4 a check of the mesh "
      "failed.\n");

  MeshJob job;
  app.add_option("file", job.input, "Slice file (CLI, text or binary)")->type_name("FILE");
  app.add_option(
         "-o,--output", job.outputs,
         "Mesh to write, format by extension (.vtu, .pvd, .msh, .mesh, .inp, .mfem, .node, .ele, and .exo or .e "
         "where the program was built with netCDF); repeatable")
      ->type_name("FILE")
      ->allow_extra_args(false);
  app.add_option("--plc", job.plc,
                 "Piecewise linear complex to write, format by extension (.off, .obj, .ply, .stl, .poly)")
      ->type_name("FILE");
  app.add_flag("--plc-skin", job.plc_skin, "Write the outer skin of the complex alone");
  const std::string filling = "Tetrahedralizer";
  app.add_option(
         "--mesher", job.mesher.mesher,
         "slab, mesh3, tetgen, cdt3 (where the program was built with them) or a command: {in} stands for the "
         "file of the complex, {skin} for that of its outer skin, {out} for the mesh that it writes; {in:poly}, "
         "{out:mesh} name other formats than OFF and MSH")
      ->type_name("NAME|COMMAND")
      ->default_str("slab")
      ->group(filling);
  app.add_option("--mesher-args", job.mesher.arguments,
                 std::string("For tetgen its switches, for mesh3 words like size=0.4 (") + kMesh3Arguments +
                     "), for a command what is appended to it")
      ->type_name("TEXT")
      ->group(filling);
  app.add_option("--report", job.report, "Report to write as JSON")->type_name("FILE");
  app.add_option("--quality-svg", job.quality_svg, "Picture of the element quality to write as SVG")->type_name("FILE");
  app.add_flag("-q,--quiet", job.quiet, "No log and no progress on the standard error stream");
  add_reading_options(app, job.read, job.options.slabs);
  add_meshing_options(app, job.options);
  bool with_steps = false;
  slice2mesh::InpStepOptions steps;
  add_format_options(app, job.write);
  add_step_options(app, with_steps, steps);

  std::string info_file;
  slice2mesh::CliReadOptions info_read;
  slice2mesh::SlabOptions info_slabs;
  CLI::App* info = app.add_subcommand("info", "Print what a slice file holds");
  info->add_option("file", info_file, "Slice file (CLI, text or binary)")->type_name("FILE")->required();
  add_reading_options(*info, info_read, info_slabs);
  app.require_subcommand(0, 1);

  try {
    app.parse(argc, argv);
    if (info->parsed()) {
      if (!job.input.empty()) throw CLI::ValidationError("info", "takes its file after the word info");
      return print_info(info_file, info_read, info_slabs);
    }
    if (job.input.empty()) throw CLI::RequiredError("file");
    if (with_steps) {
      if (job.write.time_per_layer > 0) steps.time_per_layer = job.write.time_per_layer;
      job.write.inp_steps = steps;
    }
    return mesh_file(job);
  } catch (const CLI::Success& help_or_version) {
    return app.exit(help_or_version);
  } catch (const CLI::ParseError& error) {
    return fail(kExitUsage, std::string(error.what()) + " (see slice2mesh --help)");
  } catch (const UsageError& error) {
    return fail(kExitUsage, error.what());
  } catch (const slice2mesh::Cancelled& error) {
    return fail(kExitMeshing, error.what());
  } catch (const slice2mesh::Error& error) {
    return fail(exit_code(error), error.what());
  } catch (const std::bad_alloc&) {
    return fail(kExitMeshing, "out of memory");
  } catch (const std::exception& error) {
    return fail(kExitMeshing, error.what());
  }
}

}  // namespace

}  // namespace slice2mesh_program

int main(int argc, char** argv) {
  slice2mesh_program::note_signals();
  return slice2mesh_program::run(argc, argv);
}
