// SPDX-License-Identifier: MIT
#include "mesh.hpp"

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <ostream>
#include <string>

#include "exit_codes.hpp"
#include "interrupt.hpp"
#include "progress_line.hpp"
#include "report_json.hpp"
#include "slice2mesh/core/atomic_file.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/io/write_mesh.hpp"
#include "slice2mesh/pipeline/slice_to_mesh.hpp"
#include "slice2mesh/quality/format_quality.hpp"
#include "slice2mesh/quality/quality_svg.hpp"
#include "text.hpp"

namespace slice2mesh_program {

namespace {

// What a mesher that does not keep the facets of the complex has made of the layers.
void print_layers(const std::string& name, const slice2mesh::LayerReport& layers) {
  print_line(stdout, "tetrahedralizer", name);
  print_line(stdout, "tets that cross",
             std::to_string(layers.crossing) + " (" + slice2mesh::detail::short_number(100 * layers.crossing_share, 3) +
                 " %) lie in more than one layer");
  print_line(stdout, "volume of layers",
             "off by " + short_text(100 * layers.volume_error) + " %, largest of a layer " +
                 short_text(100 * layers.largest_slab_error) + " % (layer " +
                 std::to_string(layers.largest_error_slab + 1) + ")");
  std::fputs("\n", stdout);
}

// What the mesh gains and loses against its slices.
std::string volume_error_text(const slice2mesh::VolumeError& volume, double eps) {
  std::string text = short_text(100 * volume.error) + " % of the slices, " + short_text(volume.slices) + " mm^3";
  if (volume.worst_slab >= 0) {
    const auto worst = static_cast<std::size_t>(volume.worst_slab);
    text += "; largest of a layer " + short_text(100 * volume.slab_error[worst]) + " % (layer " +
            std::to_string(worst + 1) + ", " + short_text(volume.slab_shift[worst] / eps) +
            " eps outside of its slice on average)";
  }
  return text;
}

// How near contours come, in shares of eps.
std::string separation_text(const slice2mesh::SeparationFigures& figures, double tolerance) {
  const auto share = [tolerance](const slice2mesh::SeparationMinimum& minimum) {
    return minimum.found() ? short_text(minimum.size / tolerance) + " eps" : std::string("1 eps or more");
  };
  return "vertices " + share(figures.vertices) + ", vertex and edge " + share(figures.vertex_edge) + ", angle " +
         (figures.angle.found() ? short_text(figures.angle.size) + " degrees" : std::string("none")) + "; " +
         std::to_string(figures.close_vertices.back() + figures.close_vertex_edge.back()) + " pairs below " +
         short_text(slice2mesh::kSeparationShare) + " eps, " + std::to_string(figures.sharp) + " angles below " +
         short_text(slice2mesh::kSeparationAngle) + " degrees";
}

void print_report(const slice2mesh::Result& result) {
  const slice2mesh::Report& report = result.report;
  const slice2mesh::Certificate& certificate = report.certificate;
  print_line(stdout, "z convention", to_string(report.z_convention));
  print_line(stdout, "slabs", std::to_string(result.mesh.slabs.size()));
  print_line(stdout, "thickness", short_text(report.thickness) + " mm (median)");
  print_line(stdout, "size", short_text(report.size) + " mm");
  print_line(stdout, "eps", short_text(report.eps) + " mm");
  print_line(stdout, "largest deviation", short_text(report.max_deviation) + " mm");
  print_line(stdout, "volume error", volume_error_text(report.volume_error, report.eps));
  print_line(stdout, "between contours", separation_text(report.separation.between, report.separation.tolerance));
  print_line(stdout, "within contours", separation_text(report.separation.within, report.separation.tolerance));
  const slice2mesh::SlicingEstimates& estimates = report.estimates;
  const auto share = [&estimates](double volume) {
    const std::string percent = estimates.volume > 0 ? short_text(100 * volume / estimates.volume) : "-";
    return short_text(volume) + " mm^3 (" + percent + " % of the part)";
  };
  print_line(stdout, "staircase error", share(estimates.staircase_volume));
  print_line(stdout, "volume loss", share(estimates.volume_loss) + " against finer slices");
  std::fputs(slice2mesh::format_quality(report.quality).c_str(), stdout);
  std::fputs("\n", stdout);
  if (report.layers) print_layers(report.tetrahedralizer, *report.layers);
  print_line(stdout, "certificate", certificate.passed() ? "passed" : "FAILED");
  for (const slice2mesh::CertificateCheck& check : certificate.checks)
    std::fprintf(stdout, "  %-6s %s%s%s\n", check.passed ? "ok" : "FAILED", check.name.c_str(),
                 check.detail.empty() ? "" : ": ", check.detail.c_str());
}

// What is wrong with the names of the outputs is said before any work is done.
void check_outputs(const MeshJob& job) {
  try {
    for (const std::string& path : job.outputs) slice2mesh::check_mesh_path(path);
    if (!job.plc.empty()) slice2mesh::check_plc_path(job.plc);
  } catch (const slice2mesh::FileError& error) {
    const std::string text = error.what();
    const std::size_t name = text.find(error.path());  // without the stage before it
    throw UsageError(name == std::string::npos ? text : text.substr(name));
  }
}

}  // namespace

int mesh_file(const MeshJob& job) {
  check_outputs(job);
  const auto start = std::chrono::steady_clock::now();
  const auto log = [&job, &start](const std::string& text) {
    if (job.quiet) return;
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    std::fprintf(stderr, "[%7.2f s] %s\n", time.count(), text.c_str());
  };

  MesherChoice choice = job.mesher;
  choice.size = job.options.size.size;
  choice.eps = job.options.eps;
  choice.time_limit = job.options.budget.time_limit;
  choice.max_tets = job.options.budget.max_tets;
  const slice2mesh::AnyTetrahedralizer mesher = make_mesher(choice);

  slice2mesh::Diagnostics reading;
  slice2mesh::CliReadOptions read = job.read;
  read.poll = [] { stop_if_interrupted(slice2mesh::Stage::Read); };
  const slice2mesh::SliceStack stack = slice2mesh::read_cli(job.input, read, &reading);
  log("read " + job.input + ": " + std::to_string(stack.layers.size()) + " layers");
  if (!job.quiet) print_diagnostics(stderr, "  ", reading);

  slice2mesh::Result result;
  {
    ProgressLine progress(!job.quiet);
    slice2mesh::Options options = job.options;
    options.progress = [show = progress.callback()](slice2mesh::Stage stage, double share) {
      return !interrupted() && (!show || show(stage, share));
    };
    result = slice2mesh::slice_to_mesh(stack, options, mesher);
  }
  log("meshed: " + std::to_string(result.mesh.tets.size()) + " tets in " + std::to_string(result.mesh.slabs.size()) +
      " slabs");
  if (!job.quiet) {
    print_diagnostics(stderr, "  ", result.diagnostics);
    for (const auto& [stage, seconds] : result.report.seconds)
      std::fprintf(stderr, "  %-16s%8.2f s\n", to_string(stage), seconds);
  }
  slice2mesh::Diagnostics all = reading;
  all.append(result.diagnostics);
  result.diagnostics = all;

  const bool passed = result.report.certificate.passed();
  slice2mesh::WriteOptions write = job.write;
  write.poll = [] { stop_if_interrupted(slice2mesh::Stage::Write); };
  if (passed) {
    for (const std::string& path : job.outputs) {
      slice2mesh::write_mesh(path, result.mesh, write);
      log("wrote " + path);
    }
  }
  if (!job.plc.empty()) {
    slice2mesh::PlcWriteOptions plc_options;
    plc_options.inner_faces = !job.plc_skin;
    plc_options.poll = write.poll;
    slice2mesh::write_plc(job.plc, result.plc, plc_options);
    log("wrote " + job.plc);
  }
  if (!job.report.empty()) {
    const std::string text = report_json(job, result);
    slice2mesh::write_file_atomically(job.report, slice2mesh::Stage::Write,
                                      [&text](std::ostream& out) { out << text; });
    log("wrote " + job.report);
  }
  if (!job.quality_svg.empty()) {
    slice2mesh::write_quality_svg(job.quality_svg, result.report.quality, job.input);
    log("wrote " + job.quality_svg);
  }
  print_report(result);
  if (passed) return kExitOk;
  std::fputs("slice2mesh: a check of the certificate failed; no mesh was written\n", stderr);
  return kExitCertificate;
}

}  // namespace slice2mesh_program
