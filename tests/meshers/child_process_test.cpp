// SPDX-License-Identifier: MIT
#include "slice2mesh/tet/child_process.hpp"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "slice2mesh/tet/raw_tets_bytes.hpp"
#include "test_support.hpp"

// GCC has a macro for it, Clang a feature.
#ifdef __SANITIZE_ADDRESS__
#define SLICE2MESH_TEST_ADDRESS_SANITIZER
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SLICE2MESH_TEST_ADDRESS_SANITIZER
#endif
#endif

using namespace slice2mesh;

#if SLICE2MESH_HAS_CHILD_PROCESSES

namespace {

std::vector<char> bytes_of(const std::string& text) {
  return {text.begin(), text.end()};
}
std::string text_of(const ChildResult& result) {
  return {result.bytes.begin(), result.bytes.end()};
}
ChildLimits seconds(double time) {
  ChildLimits limits;
  limits.time = time;
  return limits;
}
[[noreturn]] void sleep_for_ever() {
  while (true) std::this_thread::sleep_for(std::chrono::seconds(1));
}
bool is_gone(const std::string& pid) {
  for (int i = 0; i < 200; ++i) {
    if (::kill(static_cast<pid_t>(std::stol(pid)), 0) != 0) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

}  // namespace

TEST_CASE("a child gives its bytes back, few, none or many, and changes nothing here") {
  int here = 1;
  CHECK(text_of(run_in_child("work", [&here] {
          here = 2;
          return bytes_of("done");
        })) == "done");
  CHECK(here == 1);
  CHECK(run_in_child("work", [] { return std::vector<char>(); }).bytes.empty());
  constexpr std::size_t many = 50'000'000;
  const ChildResult large = run_in_child("work", [] { return std::vector<char>(many, 'x'); });
  CHECK(large.bytes == std::vector<char>(many, 'x'));
  CHECK(large.peak_memory > static_cast<std::int64_t>(many));
}

TEST_CASE("what a child prints is not seen, and what it throws is told") {
  CHECK(text_of(run_in_child("work", [] {
          std::puts("noise");
          std::fflush(stdout);
          return bytes_of("quiet");
        })) == "quiet");
  CHECK_THROWS_WITH(run_in_child("work", []() -> std::vector<char> { throw std::runtime_error("no way"); }),
                    "tetrahedralize: work failed: no way");
  CHECK_THROWS_AS(run_in_child("work", []() -> std::vector<char> { throw 3; }), TetrahedralizationError);
  CHECK_THROWS_WITH(run_in_child("work", []() -> std::vector<char> { throw std::bad_alloc(); }),
                    "tetrahedralize: work failed: ran out of memory");
}

TEST_CASE("a child that crashes or exits is an error here") {
  const auto crash = []() -> std::vector<char> {
    std::signal(SIGSEGV, SIG_DFL);  // sanitizers have a handler of their own
    ::kill(::getpid(), SIGSEGV);
    sleep_for_ever();
  };
  CHECK_THROWS_WITH(run_in_child("work", crash), "tetrahedralize: work crashed with signal 11 (segmentation fault)");
  CHECK_THROWS_WITH(run_in_child("work", []() -> std::vector<char> { std::abort(); }),
                    "tetrahedralize: work crashed with signal 6 (abort)");
  CHECK_THROWS_AS(run_in_child("work", []() -> std::vector<char> { ::_exit(0); }), TetrahedralizationError);
  CHECK_THROWS_AS(run_in_child("work", []() -> std::vector<char> { ::_exit(7); }), TetrahedralizationError);
}

TEST_CASE("a child that does not end is ended at its time limit") {
  CHECK_THROWS_WITH(run_in_child(
                        "work", []() -> std::vector<char> { sleep_for_ever(); }, seconds(0.2)),
                    "tetrahedralize: work did not end within 0.2 s");
  CHECK_THROWS_WITH(run_command("work", "sleep 1000", ".", seconds(0.2)),
                    "tetrahedralize: work did not end within 0.2 s");
}

TEST_CASE("a child has no more memory than its limit") {
#ifdef SLICE2MESH_TEST_ADDRESS_SANITIZER
  WARN("not tested: the sanitizer needs the address space for itself");
#else
  ChildLimits limits;
  limits.memory = std::int64_t{1} << 32;
  CHECK_THROWS_AS(run_in_child(
                      "work", [] { return std::vector<char>(std::size_t{1} << 33, 'x'); }, limits),
                  TetrahedralizationError);
#endif
}

TEST_CASE("who listens can stop a child, which is then gone with its own children") {
  const slice2mesh_test::TemporaryDirectory directory;
  int calls = 0;
  CHECK_THROWS_AS(run_command("work", "sleep 1000 & echo $! > pid; sleep 1000", directory.path().string(), {},
                              [&](Stage stage, double) {
                                CHECK(stage == Stage::Tetrahedralize);
                                return ++calls < 20 || !std::filesystem::exists(directory.file("pid")) ||
                                       std::filesystem::file_size(directory.file("pid")) == 0;
                              }),
                  Cancelled);
  const std::string pid = text_of(run_command("read", "cat pid", directory.path().string()));
  REQUIRE_FALSE(pid.empty());
  CHECK(is_gone(pid));
}

TEST_CASE("a command runs in its directory, with its code and the end of its output") {
  const slice2mesh_test::TemporaryDirectory directory;
  ChildResult result =
      run_command("work", "echo hello > file; echo out; echo err >&2; exit 3", directory.path().string());
  CHECK(result.exit_code == 3);
  CHECK(text_of(result) == "out\nerr\n");
  CHECK(std::filesystem::exists(directory.file("file")));
  result = run_command("work", "i=0; while [ $i -lt 20000 ]; do echo line $i; i=$((i+1)); done", ".");
  CHECK(result.bytes.size() < 20000);
  CHECK(text_of(result).find("line 19999\n") != std::string::npos);
  CHECK(run_command("work", "no_such_program_at_all", ".").exit_code == 127);
  CHECK(run_command("work", "true", directory.file("no such place")).exit_code == 126);
  // What is left running does not keep the caller waiting.
  CHECK(run_command("work", "sleep 1000 & exit 0", ".", seconds(100)).exit_code == 0);
  CHECK_THROWS_AS(run_command("work", "kill -ABRT $$", "."), TetrahedralizationError);
}

TEST_CASE("limits that mean nothing are refused") {
  CHECK_THROWS_AS(run_command("work", "true", ".", seconds(-1)), OptionError);
  CHECK_THROWS_AS(run_command("work", "true", ".", seconds(std::nan(""))), OptionError);
  ChildLimits limits;
  limits.memory = -1;
  CHECK_THROWS_AS(run_command("work", "true", ".", limits), OptionError);
}

TEST_CASE("tets come through a child as they are") {
  const auto make = [] {
    RawTets tets;
    for (std::int32_t i = 0; i < 1000; ++i) {
      tets.vertices.push_back({i / 3.0, -i / 7.0, 1e300 * i});
      tets.tets.push_back({i, i + 1, i + 2, -i});
      tets.cells.push_back({i, -1});
    }
    return tets;
  };
  const RawTets here = make(), there = detail::raw_tets_from_child("work", make, {}, {});
  CHECK(there.vertices == here.vertices);
  CHECK(there.tets == here.tets);
  CHECK(there.cells == here.cells);
}

#endif
