// SPDX-License-Identifier: MIT
#include "report_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "lengths.hpp"
#include "slice2mesh/version.hpp"

namespace slice2mesh_program {

namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json numbers(const std::vector<double>& values) {
  Json array = Json::array();
  for (const double value : values) array.push_back(number(value));
  return array;
}

Json options_json(const slice2mesh::Options& options) {
  using slice2mesh::LineCap;
  const auto cap = [](LineCap value) {
    return value == LineCap::Round ? "round" : value == LineCap::Square ? "square" : "flat";
  };
  Json part_radius = Json::object();
  for (const auto& [part, radius] : options.supports.part_radius) part_radius[std::to_string(part)] = to_text(radius);
  Json refined = Json::array();
  for (const slice2mesh::RefinedBall& ball : options.size.refined)
    refined.push_back({{"x", number(ball.x)},
                       {"y", number(ball.y)},
                       {"z", number(ball.z)},
                       {"radius", number(ball.radius)},
                       {"size", to_text(ball.size)}});
  return {
      {"slabs",
       {{"z_convention", to_string(options.slabs.z_convention)},
        {"lump", options.slabs.lump},
        {"lump_thickness", number(options.slabs.lump_thickness)},
        {"with_open_lines", options.slabs.with_open_lines}}},
      {"supports",
       {{"radius", to_text(options.supports.radius)},
        {"part_radius", part_radius},
        {"cap", cap(options.supports.cap)},
        {"join", options.supports.join == slice2mesh::LineJoin::Round ? "round" : "miter"},
        {"miter_limit", number(options.supports.miter_limit)},
        {"arc_tolerance", number(options.supports.arc_tolerance)},
        {"simplify", number(options.supports.simplify)}}},
      {"plate",
       {{"thickness", to_text(options.plate.thickness)},
        {"margin", to_text(options.plate.margin)},
        {"shape", options.plate.shape == slice2mesh::BasePlateShape::Box ? "box" : "offset"},
        {"slabs", options.plate.slabs}}},
      {"eps", to_text(options.eps)},
      {"size",
       {{"size", to_text(options.size.size)},
        {"coarsest", to_text(options.size.coarsest)},
        {"automatic_tets", number(options.size.automatic_tets)},
        {"contour_size", to_text(options.size.contour_size)},
        {"growth", number(options.size.growth)},
        {"refined", refined}}},
      {"improve",
       {{"rounds", options.improve.rounds},
        {"target", number(options.improve.target)},
        {"collapse_above", number(options.improve.collapse_above)},
        {"most_work", number(options.improve.most_work)},
        {"move_contours", options.improve.move_contours},
        {"keep_columns", options.improve.keep_columns}}},
      {"finer_slices", options.finer_slices},
      {"budget",
       {{"max_vertices", options.budget.max_vertices},
        {"max_tets", options.budget.max_tets},
        {"time_limit", number(options.budget.time_limit)}}},
  };
}

Json certificate_json(const slice2mesh::Certificate& certificate) {
  Json checks = Json::array();
  for (const slice2mesh::CertificateCheck& check : certificate.checks)
    checks.push_back({{"name", check.name}, {"passed", check.passed}, {"detail", check.detail}});
  return {{"passed", certificate.passed()},
          {"volume", number(certificate.volume)},
          {"expected_volume", number(certificate.expected_volume)},
          {"checks", checks}};
}

Json estimates_json(const slice2mesh::SlicingEstimates& estimates) {
  Json layers = Json::array();
  for (const slice2mesh::LayerEstimate& layer : estimates.layers)
    layers.push_back({{"area", number(layer.area)},
                      {"perimeter", number(layer.perimeter)},
                      {"step_area", number(layer.step_area)},
                      {"cusp", number(layer.cusp)},
                      {"staircase_volume", number(layer.staircase_volume)},
                      {"volume_loss", number(layer.volume_loss)},
                      {"measured", layer.measured}});
  return {{"volume", number(estimates.volume)},
          {"staircase_volume", number(estimates.staircase_volume)},
          {"volume_loss", number(estimates.volume_loss)},
          {"layers", layers}};
}

Json ratio_json(const slice2mesh::RatioFigures& figures) {
  return {{"mean", number(figures.mean)},
          {"median", number(figures.median)},
          {"p99", number(figures.p99)},
          {"p999", number(figures.p999)},
          {"worst", number(figures.worst)}};
}

// The upper edge of a last, open bin is null.
Json histogram_json(const slice2mesh::Histogram& histogram) {
  return {{"edges", numbers(histogram.edges)}, {"counts", histogram.counts}};
}

Json quality_json(const slice2mesh::QualityReport& quality) {
  Json json = {{"ratio", ratio_json(quality.ratio)}};
  if (quality.metric_ratio) {
    json["metric_ratio"] = ratio_json(*quality.metric_ratio);
    json["metric"] = {{"l", number(quality.metric_l)}, {"h", number(quality.metric_h)}};
  }
  json["min_dihedral"] = number(quality.min_dihedral);
  json["max_dihedral"] = number(quality.max_dihedral);
  json["not_positive"] = quality.not_positive;
  json["crossing"] = quality.crossing;
  json["mislabeled"] = quality.mislabeled;
  json["columns"] = quality.columns;
  json["column_share"] = number(quality.column_share);
  json["ratio_histogram"] = histogram_json(quality.ratio_histogram);
  json["dihedral_histogram"] = histogram_json(quality.dihedral_histogram);
  json["slab_volume"] = numbers(quality.slab_volume);
  json["region_volume"] = numbers(quality.region_volume);
  Json worst = Json::array();
  for (const slice2mesh::WorstTet& tet : quality.worst)
    worst.push_back({{"tet", tet.tet},
                     {"ratio", number(tet.ratio)},
                     {"slab", tet.slab},
                     {"region", tet.region},
                     {"min_dihedral", number(tet.min_dihedral)},
                     {"max_dihedral", number(tet.max_dihedral)},
                     {"shortest_edge", number(tet.shortest_edge)},
                     {"longest_edge", number(tet.longest_edge)},
                     {"centroid", {number(tet.centroid[0]), number(tet.centroid[1]), number(tet.centroid[2])}},
                     {"cause", to_string(tet.cause)}});
  json["worst"] = std::move(worst);
  json["forced"] = {{"above", number(quality.forced.above)}, {"elements", quality.forced.elements},
                    {"forced", quality.forced.forced()},     {"small_input_angle", quality.forced.small_input_angle},
                    {"thin_wall", quality.forced.thin_wall}, {"worst_other", number(quality.forced.worst_other)}};
  return json;
}

// Null where nothing was found.
Json minimum_json(const slice2mesh::SeparationMinimum& minimum) {
  if (!minimum.found()) return nullptr;
  return {{"size", number(minimum.size)},
          {"at", {number(minimum.at[0]), number(minimum.at[1]), number(minimum.at[2])}},
          {"plane", minimum.plane},
          {"slab_below", minimum.slab_below},
          {"slab_above", minimum.slab_above}};
}

Json separation_json(const slice2mesh::SeparationReport& separation) {
  const auto figures = [](const slice2mesh::SeparationFigures& f) -> Json {
    return {{"vertices", minimum_json(f.vertices)},     {"vertex_edge", minimum_json(f.vertex_edge)},
            {"angle", minimum_json(f.angle)},           {"close_vertices", f.close_vertices},
            {"close_vertex_edge", f.close_vertex_edge}, {"sharp", f.sharp}};
  };
  return {{"tolerance", number(separation.tolerance)},
          {"shares", slice2mesh::kSeparationShares},
          {"sharp_below", slice2mesh::kSeparationAngle},
          {"between", figures(separation.between)},
          {"within", figures(separation.within)}};
}

Json mesh_json(const slice2mesh::Result& result) {
  Json regions = Json::array();
  for (const slice2mesh::Region& region : result.mesh.regions)
    regions.push_back({{"part", region.part}, {"kind", to_string(region.kind)}, {"name", region.name}});
  Json slabs = Json::array();
  for (const slice2mesh::Slab& slab : result.mesh.slabs)
    slabs.push_back({{"z_low", number(slab.z_low)},
                     {"z_high", number(slab.z_high)},
                     {"first_layer", slab.first_layer},
                     {"last_layer", slab.last_layer},
                     {"slice", slab.slice}});
  return {{"vertices", result.mesh.vertices.size()},
          {"tets", result.mesh.tets.size()},
          {"facets", result.mesh.facets.size()},
          {"regions", regions},
          {"slabs", slabs}};
}

Json diagnostics_json(const slice2mesh::Diagnostics& diagnostics) {
  Json array = Json::array();
  for (const slice2mesh::Diagnostic& entry : diagnostics.entries()) {
    Json json = {{"severity", to_string(entry.severity)},
                 {"stage", to_string(entry.stage)},
                 {"code", entry.code},
                 {"message", entry.message},
                 {"count", entry.count}};
    if (entry.layer >= 0) json["layer"] = entry.layer;
    if (entry.polyline >= 0) json["polyline"] = entry.polyline;
    array.push_back(std::move(json));
  }
  return array;
}

Json layers_json(const slice2mesh::LayerReport& layers) {
  return {{"crossing", layers.crossing},
          {"crossing_share", number(layers.crossing_share)},
          {"volume", number(layers.volume)},
          {"exact_volume", number(layers.exact_volume)},
          {"volume_error", number(layers.volume_error)},
          {"slab_volume", numbers(layers.slab_volume)},
          {"exact_slab_volume", numbers(layers.exact_slab_volume)}};
}

Json volume_error_json(const slice2mesh::VolumeError& volume) {
  return {{"slices", number(volume.slices)},
          {"error", number(volume.error)},
          {"worst_slab", volume.worst_slab >= 0 ? Json(volume.worst_slab) : Json(nullptr)},
          {"per_slab", numbers(volume.slab_error)},
          {"shift_per_slab", numbers(volume.slab_shift)}};
}

}  // namespace

std::string report_json(const MeshJob& job, const slice2mesh::Result& result) {
  const slice2mesh::Report& report = result.report;
  Json seconds = Json::object();
  for (const auto& [stage, time] : report.seconds) seconds[to_string(stage)] = number(time);
  const Json json = {
      {"program", "slice2mesh"},
      {"version", SLICE2MESH_VERSION},
      {"input", job.input},
      {"options", options_json(job.options)},
      {"z_convention", to_string(report.z_convention)},
      {"thickness", number(report.thickness)},
      {"eps", number(report.eps)},
      {"size", number(report.size)},
      {"deviation", {{"max", number(report.max_deviation)}, {"per_slab", numbers(report.deviation)}}},
      {"volume_error", volume_error_json(report.volume_error)},
      {"separation", separation_json(report.separation)},
      {"tetrahedralizer",
       {{"name", report.tetrahedralizer}, {"mesher", job.mesher.mesher}, {"arguments", job.mesher.arguments}}},
      {"layers", report.layers ? layers_json(*report.layers) : Json(nullptr)},
      {"certificate", certificate_json(report.certificate)},
      {"mesh", mesh_json(result)},
      {"quality", quality_json(report.quality)},
      {"estimates", estimates_json(report.estimates)},
      {"diagnostics", diagnostics_json(result.diagnostics)},
      {"seconds", seconds},
  };
  // File names and labels need not be UTF-8: what is not is replaced.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace slice2mesh_program
