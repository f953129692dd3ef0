// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "fuzz/byte_source.hpp"
#include "fuzz/targets.hpp"
#include "io/sample_mesh.hpp"
#include "slice2mesh/io/write_mesh.hpp"
#include "slice2mesh/tet/read_tets.hpp"

#if defined(__unix__) || defined(__APPLE__)
#include <unistd.h>
#endif

namespace slice2mesh_fuzz {

using namespace slice2mesh;

namespace {

/// A directory for the files of this process, removed when it ends; in memory where there is such a place.
class Scratch {
public:
  Scratch() {
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::path memory = "/dev/shm";
    const fs::path base = fs::is_directory(memory, error) ? memory : fs::temp_directory_path();
#if defined(__unix__) || defined(__APPLE__)
    const long process = getpid();
#else
    const long process = 0;
#endif
    path_ = base / ("slice2mesh_fuzz_" + std::to_string(process));
    fs::create_directories(path_);
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  [[nodiscard]] std::string file(const std::string& name) const {
    return (path_ / name).string();
  }

private:
  std::filesystem::path path_;
};

std::string scratch(const std::string& name) {
  static const Scratch kDirectory;
  return kDirectory.file(name);
}

void write_bytes(const std::string& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

// A solid of boxes with any of its squares filled, and vertices moved to any numbers: a writer must not care about
// shape.
Mesh mesh_from(ByteSource& bytes) {
  slice2mesh_test::BoxSolid solid;
  solid.nx = static_cast<std::size_t>(bytes.whole(1, 3));
  solid.ny = static_cast<std::size_t>(bytes.whole(1, 2));
  solid.region_count = static_cast<std::size_t>(bytes.whole(1, 4));
  for (int n = bytes.whole(1, 3); n > 0; --n) solid.thickness.push_back(bytes.flag() ? 0.25 : 1);
  std::vector<std::int32_t> filled(solid.nx * solid.ny * solid.thickness.size());
  for (std::int32_t& f : filled) {
    const int value = bytes.whole(0, 7);
    f = value < 3 ? 0 : value == 7 ? kNone : value % static_cast<int>(solid.region_count);
  }
  filled[0] = 0;
  solid.region = [&](std::size_t x, std::size_t y, std::size_t s) { return filled[(s * solid.ny + y) * solid.nx + x]; };
  Mesh mesh = slice2mesh_test::mesh_of(solid);
  for (Region& region : mesh.regions)
    if (bytes.flag()) region.name = bytes.text(12);
  const int kind = bytes.whole(0, 3);
  for (auto& v : mesh.vertices)
    for (double& x : v) {
      if (kind == 1) x += bytes.share();
      if (kind == 2 && bytes.flag()) x = bytes.any_double();
    }
  return mesh;
}

void check_same(const Mesh& mesh, const RawTets& tets, const std::string& format) {
  if (tets.tets.size() != mesh.tets.size()) throw Failure(format + ": another number of tets");
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    // Groups may change the order of tets: only where vertices keep theirs can tets be compared one by one.
    for (const std::int32_t v : tets.tets[t])
      if (v < 0 || static_cast<std::size_t>(v) >= tets.vertices.size()) throw Failure(format + ": no such vertex");
  }
  const auto sorted_corners = [](const auto& vertices, const auto& list) {
    std::vector<std::array<std::array<double, 3>, 4>> corners;
    for (const auto& tet : list) {
      corners.emplace_back();
      for (std::size_t k = 0; k < 4; ++k) corners.back()[k] = vertices[static_cast<std::size_t>(tet[k])];
    }
    std::sort(corners.begin(), corners.end());
    return corners;
  };
  if (sorted_corners(mesh.vertices, mesh.tets) != sorted_corners(tets.vertices, tets.tets))
    throw Failure(format + ": other tets");
}

// The values of an array of a VTU file without compression.
std::string vtu_bytes(const std::string& file, const std::string& name) {
  const std::size_t element = file.find("Name=\"" + name + "\"");
  const std::size_t data = file.find("<AppendedData encoding=\"raw\">\n_");
  if (element == std::string::npos || data == std::string::npos) throw Failure("vtu: no array " + name);
  const std::size_t text = file.find("offset=\"", element) + 8;
  std::size_t offset = 0;
  std::from_chars(file.data() + text, file.data() + file.size(), offset);
  offset += data + 31;
  std::uint64_t length = 0;
  if (offset + 8 > file.size()) throw Failure("vtu: offset");
  std::memcpy(&length, file.data() + offset, 8);
  if (length > file.size() - offset - 8) throw Failure("vtu: length");
  return file.substr(offset + 8, static_cast<std::size_t>(length));
}

}  // namespace

void mesh_files(const std::uint8_t* data, std::size_t size) {
  ByteSource bytes(data, size);
  WriteOptions options;
  options.binary = bytes.flag();
  options.surfaces = bytes.flag();
  options.interfaces = bytes.flag();
  options.layer_faces = bytes.flag();
  options.mfem_names = bytes.flag();
  options.time_per_layer = bytes.flag() ? 2.5 : 0;
  options.quadratic = bytes.whole(0, 3) == 3;
  const Mesh mesh = mesh_from(bytes);
  bool finite = true;
  for (const auto& v : mesh.vertices)
    for (const double x : v) finite = finite && std::isfinite(x);
  const MeshFormat formats[] = {MeshFormat::Vtu,  MeshFormat::Msh,         MeshFormat::Medit,         MeshFormat::Inp,
                                MeshFormat::Mfem, MeshFormat::TetgenNodes, MeshFormat::TetgenElements};
  std::string files[7];
  for (std::size_t f = 0; f < 7; ++f) {
    std::ostringstream out, again;
    bool refused = false;
    try {
      write_mesh(out, formats[f], mesh, options);
    } catch (const Error&) {
      refused = true;
    }
    if (refused != !finite && !(options.quadratic && finite))
      throw Failure("finite coordinates are written, others refused");
    if (refused) continue;
    write_mesh(again, formats[f], mesh, options);
    if (out.str() != again.str()) throw Failure("the same mesh gives other bytes");
    files[f] = out.str();
  }
  if (!finite) return;
  if (!files[0].empty() && !options.quadratic) {
    const std::string points = vtu_bytes(files[0], "Points");
    if (points.size() != mesh.vertices.size() * 24 ||
        std::memcmp(points.data(), mesh.vertices.data(), points.size()) != 0)
      throw Failure("vtu: other points");
    const std::string layers = vtu_bytes(files[0], "layer");
    if (layers.size() != mesh.tets.size() * 4) throw Failure("vtu: layers");
  }
  if (!options.binary && !options.quadratic) {
    write_bytes(scratch("a.msh"), files[1]);
    check_same(mesh, slice2mesh::read_tets(scratch("a.msh")), "msh");
  }
  write_bytes(scratch("a.mesh"), files[2]);
  check_same(mesh, slice2mesh::read_tets(scratch("a.mesh")), "medit");
  write_bytes(scratch("a.node"), files[5]);
  write_bytes(scratch("a.ele"), files[6]);
  check_same(mesh, slice2mesh::read_tets(scratch("a.ele")), "tetgen");
}

void read_tets(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  std::string path;
  switch (data[0] % 3) {
    case 0: path = scratch("b.msh"); break;
    case 1: path = scratch("b.mesh"); break;
    default: path = scratch("b.node");
  }
  if (data[0] % 3 == 2) {
    const std::size_t half = bytes.find("ELE\n");  // two files in one
    write_bytes(path, bytes.substr(0, half));
    write_bytes(scratch("b.ele"), half == std::string_view::npos ? "" : bytes.substr(half + 4));
  } else {
    write_bytes(path, bytes);
  }
  try {
    const RawTets tets = slice2mesh::read_tets(path);
    for (const auto& tet : tets.tets)
      for (const std::int32_t v : tet)
        if (v < 0 || static_cast<std::size_t>(v) >= tets.vertices.size()) throw Failure("a tet without vertex");
  } catch (const Error&) {  // what a file may be
  }
}

}  // namespace slice2mesh_fuzz
