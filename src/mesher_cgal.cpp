// SPDX-License-Identifier: MIT
// The models of CGAL, in a translation unit of their own: Mesh_3 takes long to compile.
#ifdef SLICE2MESH_PROGRAM_MESH3
#include "slice2mesh/tet/mesh3_model.hpp"  // first: so it is known to need no other header (tests/headers)
#endif

#include <optional>
#include <sstream>
#include <string>

#include "exit_codes.hpp"
#include "lengths.hpp"
#include "mesher.hpp"
#include "slice2mesh/tet/cdt3_model.hpp"

namespace slice2mesh_program {

#ifdef SLICE2MESH_PROGRAM_MESH3

namespace {

double number_of(const std::string& name, const std::string& text) {
  const std::optional<double> value = parse_number(text);
  if (!value) throw UsageError("--mesher-args: " + name + " is not followed by a number");
  return *value;
}

slice2mesh::Length length_of(const std::string& name, const std::string& text) {
  const std::optional<slice2mesh::Length> value = parse_length(text);
  if (!value) throw UsageError("--mesher-args: " + name + " is not followed by a length");
  return *value;
}

bool answer_of(const std::string& name, const std::string& text) {
  if (text != "yes" && text != "no") throw UsageError("--mesher-args: " + name + " is not followed by yes or no");
  return text == "yes";
}

}  // namespace

slice2mesh::AnyTetrahedralizer make_mesh3(const MesherChoice& choice) {
  slice2mesh::Mesh3Mesher mesher;
  slice2mesh::Mesh3Options& options = mesher.options;
  if (choice.size.value > 0) options.size = choice.size;
  if (choice.eps.value > 0) options.distance = choice.eps;
  std::istringstream words(choice.arguments);
  for (std::string word; words >> word;) {
    const std::size_t equal = word.find('=');
    const std::string name = word.substr(0, equal);
    const std::string value = equal == std::string::npos ? std::string() : word.substr(equal + 1);
    if (name == "size")
      options.size = length_of(name, value);
    else if (name == "edge")
      options.edge_size = length_of(name, value);
    else if (name == "distance")
      options.distance = length_of(name, value);
    else if (name == "angle")
      options.facet_angle = number_of(name, value);
    else if (name == "ratio")
      options.radius_edge = number_of(name, value);
    else if (name == "features")
      options.feature_angle = number_of(name, value);
    else if (name == "perturb")
      options.perturb = answer_of(name, value);
    else if (name == "exude")
      options.exude = answer_of(name, value);
    else
      throw UsageError("--mesher-args: mesh3 knows no '" + name + "', but " + kMesh3Arguments);
  }
  if (choice.time_limit > 0) mesher.limits.time = choice.time_limit;
  return mesher;
}

#else

slice2mesh::AnyTetrahedralizer make_mesh3(const MesherChoice&) {
  throw UsageError("--mesher mesh3: this program was built without it (SLICE2MESH_PROGRAM_MESH3)");
}

#endif

slice2mesh::AnyTetrahedralizer make_cdt3(const MesherChoice& choice) {
#if SLICE2MESH_HAS_CDT3
  slice2mesh::Cdt3Mesher mesher;
  if (choice.time_limit > 0) mesher.limits.time = choice.time_limit;
  return mesher;
#else
  (void)choice;
  throw UsageError("--mesher cdt3: this program was built with a CGAL before 6.1, which does not have it");
#endif
}

}  // namespace slice2mesh_program
