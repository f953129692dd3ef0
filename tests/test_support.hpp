// SPDX-License-Identifier: MIT
/// @file
/// @brief What every test includes: Catch2 (version 2 or 3) and the place of the shared data files.
#pragma once

#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
using Catch::Approx;
#else
#include <catch2/catch.hpp>
#endif

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace slice2mesh_test {

/// How often a loop over random inputs runs: under sanitizers, where each takes ten times as long, a quarter of that.
[[nodiscard]] constexpr std::uint32_t times(std::uint32_t usual) {
#ifdef SLICE2MESH_TEST_FEWER
  return (usual + 3) / 4;
#else
  return usual;
#endif
}

/// Directory with the slice files that are not part of the repository (subdirectories `reference` and `machine`), or
/// nothing where there is none. The environment variable SLICE2MESH_SHARED_DATA comes before the path given to CMake.
[[nodiscard]] inline std::optional<std::filesystem::path> shared_data() {
  std::filesystem::path directory;
  if (const char* given = std::getenv("SLICE2MESH_SHARED_DATA"); given != nullptr && *given != '\0') directory = given;
#ifdef SLICE2MESH_SHARED_DATA_DIR
  else
    directory = SLICE2MESH_SHARED_DATA_DIR;
#endif
  std::error_code ignored;
  if (directory.empty() || !std::filesystem::is_directory(directory, ignored)) return std::nullopt;
  return directory;
}

/// A directory of its own for the files of one test, removed with all its files when the test ends.
class TemporaryDirectory {
public:
  TemporaryDirectory() {
    const std::filesystem::path base = std::filesystem::temp_directory_path();
    for (int attempt = 0;; ++attempt) {
      path_ = base / ("slice2mesh_test_" + std::to_string(counter()++) + "_" +
                      std::to_string(reinterpret_cast<std::uintptr_t>(this)) + "_" + std::to_string(attempt));
      if (std::filesystem::create_directory(path_)) return;
    }
  }
  ~TemporaryDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }
  [[nodiscard]] std::string file(const std::string& name) const { return (path_ / name).string(); }

private:
  static int& counter() {
    static int value = 0;
    return value;
  }
  std::filesystem::path path_;
};

}  // namespace slice2mesh_test
