// SPDX-License-Identifier: MIT
// The inputs that fuzzing found (corpus/<target>/), and random bytes, once more, without a fuzzer.
#include <algorithm>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "fuzz/byte_source.hpp"
#include "fuzz/targets.hpp"
#include "test_support.hpp"

using namespace slice2mesh_fuzz;

namespace {

void replay(const Target& target, const std::vector<std::uint8_t>& bytes) {
  std::string failure;
  try {
    target.run(bytes.data(), bytes.size());
  } catch (const std::exception& error) {
    failure = error.what();
  }
  CHECK(failure == "");
}

}  // namespace

TEST_CASE("what fuzzing found is handled: reader, writers, and the whole pipeline") {
  for (const Target& target : kTargets) {
    std::vector<std::filesystem::path> files;
    for (const auto& entry :
         std::filesystem::directory_iterator(std::filesystem::path(SLICE2MESH_FUZZ_CORPUS) / target.name))
      files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    CAPTURE(target.name);
    REQUIRE(files.size() >= 5);
    for (const std::filesystem::path& path : files) {
      INFO(path.filename().string());
      std::ifstream file(path, std::ios::binary);
      const std::vector<char> text(std::istreambuf_iterator<char>(file), {});
      CHECK(text.size() < 1024);
      replay(target, std::vector<std::uint8_t>(text.begin(), text.end()));
    }
  }
}

TEST_CASE("random bytes are handled by every target") {
  std::mt19937 random(20240607);
  for (const Target& target : kTargets) {
    const int inputs = std::string(target.name) == "pipeline" ? 60 : 300;
    for (int i = 0; i < inputs; ++i) {
      std::vector<std::uint8_t> bytes(random() % 200);
      for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(random() & 255);
      CAPTURE(target.name, i);
      replay(target, bytes);
    }
  }
}

TEST_CASE("a target that finds a fault says so") {
  const Target broken{"broken", [](const std::uint8_t*, std::size_t size) {
                        if (size == 3) throw Failure("three");
                      }};
  CHECK_THROWS_AS(broken.run(nullptr, 3), Failure);
  replay(broken, {1, 2});
}
