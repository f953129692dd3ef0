// SPDX-License-Identifier: MIT
// Runs the pipeline over all classes of generators.hpp, every input in a process of its own, and prints a table.
//
//   torture_driver [--seeds N] [--first N] [--class NAME] [--case TEXT] [--limit SECONDS] [--memory MB] [--save
//   DIRECTORY]
//                  [--silence SECONDS] [--large] [--list]
//   torture_driver --file FILE.cli [--silence SECONDS] [--eps MM]
//
// "silence" is the longest time between two calls of the progress function, in processor time of the thread, so that
// other programs do not count; with --silence all that are longer are printed with their stage. --file does that for
// one slice file. Ends with 1 if any input ends otherwise than its class allows, crashes, or is over the limit.
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "slice2mesh/cli/read_cli.hpp"
#include "slice2mesh/cli/write_cli.hpp"
#include "slice2mesh/quality/quality.hpp"
#include "torture/generators.hpp"
#include "torture/pipeline_runner.hpp"

using namespace slice2mesh_test;

namespace {

struct Settings {
  std::uint32_t first = 1;
  std::uint32_t seeds = 1;
  std::string only_class;
  std::string only_case;
  unsigned limit = 60;       // seconds per input
  unsigned long memory = 0;  // MB of address space per input
  std::string save;
  double silence = 0;  // seconds; longer ones are printed; 0: none
  std::string file;
  double eps = -1;  // mm, for `file`; below 0: the default
  bool large = false;
  bool list = false;
};

struct Ended {
  std::string how;
  std::string message;
  double seconds = 0, silence = 0;
};

// How long the progress function is not called, in processor time.
class SilenceMeter {
public:
  explicit SilenceMeter(double printed) : printed_(printed), last_(now()) {}
  void call(const char* stage, double share) {
    const double time = now(), silence = time - last_;
    if (printed_ > 0 && silence > printed_) {
      std::printf("     %.2f s of silence between %s %.3f and %s %.3f\n", silence, stage_, share_, stage, share);
      std::fflush(stdout);
    }
    if (silence > longest_) longest_ = silence;
    stage_ = stage;
    share_ = share;
    last_ = time;
  }
  [[nodiscard]] double longest() const { return longest_; }

private:
  static double now() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }
  double printed_, last_, longest_ = 0, share_ = 0;
  const char* stage_ = "begin";
};

// The pipeline with a meter.
Outcome run_metered(const slice2mesh::SliceStack& stack, slice2mesh::Options options, SilenceMeter& meter) {
  options.progress = [&](slice2mesh::Stage stage, double share) {
    meter.call(to_string(stage), share);
    return true;
  };
  Outcome outcome = run_pipeline(stack, options);
  meter.call("end", 1);
  return outcome;
}

// One input in a child process: what it ends with, crashes and time-outs included.
Ended run_apart(const TortureCase& input, const Settings& settings) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) return {"no pipe", "", 0};
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    alarm(settings.limit);
    if (settings.memory > 0) {
      const rlimit limit{settings.memory << 20, settings.memory << 20};
      setrlimit(RLIMIT_AS, &limit);
    }
    SilenceMeter meter(settings.silence);
    const Outcome outcome = run_metered(input.stack, input.options, meter);
    const std::string text =
        std::string(to_string(outcome.ending)) + "\n" + std::to_string(meter.longest()) + "\n" + outcome.message;
    const ssize_t written = write(ends[1], text.data(), std::min<std::size_t>(text.size(), 4000));
    _exit(written > 0 ? 0 : 1);
  }
  close(ends[1]);
  std::string text;
  std::array<char, 4096> buffer{};
  for (ssize_t n = 0; (n = read(ends[0], buffer.data(), buffer.size())) > 0;)
    text.append(buffer.data(), static_cast<std::size_t>(n));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  Ended ended;
  ended.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (WIFSIGNALED(status)) {
    ended.how =
        WTERMSIG(status) == SIGALRM ? "OVER THE LIMIT" : "CRASH (signal " + std::to_string(WTERMSIG(status)) + ")";
  } else {
    const std::size_t line = text.find('\n');
    ended.how = text.empty() ? "CRASH" : text.substr(0, line);
    const std::size_t next = line == std::string::npos ? line : text.find('\n', line + 1);
    if (next != std::string::npos) {
      std::from_chars(text.data() + line + 1, text.data() + next, ended.silence);
      ended.message = text.substr(next + 1);
    }
  }
  return ended;
}

void save(const TortureCase& input, const Settings& settings, const std::string& name) {
  if (settings.save.empty()) return;
  std::string file = name;
  for (char& c : file)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  try {
    std::filesystem::create_directories(settings.save);
    slice2mesh::write_cli(settings.save + "/" + file + ".cli", input.stack);
  } catch (const std::exception& error) {
    std::printf("    not saved: %s\n", error.what());
  }
}

int run(const Settings& settings) {
  struct Row {
    int inputs = 0;
    std::map<std::string, int> endings;
    int failures = 0;
    double seconds = 0, slowest = 0, silence = 0;
    std::string what;
  };
  std::vector<std::pair<std::string, Row>> rows;
  int failures = 0;
  for (const TortureClass& kind : torture_classes()) {
    if (settings.list) std::printf("%-24s%s%s\n", kind.name.c_str(), kind.what.c_str(), kind.large ? " (large)" : "");
    if (settings.list || (!settings.only_class.empty() && kind.name != settings.only_class)) continue;
    if (kind.large && !settings.large && settings.only_class.empty()) continue;
    Row row;
    row.what = kind.what;
    for (std::uint32_t seed = settings.first; seed < settings.first + settings.seeds; ++seed)
      for (const TortureCase& input : kind.make(seed)) {
        if (!settings.only_case.empty() && input.name.find(settings.only_case) == std::string::npos) continue;
        const Ended ended = run_apart(input, settings);
        ++row.inputs;
        ++row.endings[ended.how];
        row.seconds += ended.seconds;
        row.slowest = std::max(row.slowest, ended.seconds);
        row.silence = std::max(row.silence, ended.silence);
        const bool good =
            is_allowed(input.allowed, ended.how) || (ended.how == to_string(Ending::TetrahedralizationError) &&
                                                     exact_neighbors_nearly_coincide(input.stack, input.options));
        if (!good || !settings.only_case.empty()) {
          std::printf("%s %s, seed %u: %s: %s: %s (%.2f s, silence %.2f s)\n", good ? "ok  " : "FAIL",
                      kind.name.c_str(), seed, input.name.c_str(), ended.how.c_str(), ended.message.c_str(),
                      ended.seconds, ended.silence);
          std::fflush(stdout);
        }
        if (good) continue;
        ++row.failures;
        save(input, settings, kind.name + "_" + std::to_string(seed) + "_" + input.name);
      }
    failures += row.failures;
    rows.emplace_back(kind.name, row);
  }
  if (settings.list) return 0;
  std::printf(
      "\n| class | inputs | certified | typed errors | failures | seconds | slowest | silence | what |\n"
      "|---|---|---|---|---|---|---|---|---|\n");
  Row all;
  const auto print = [](const std::string& name, const Row& row) {
    const auto found = row.endings.find("certified");
    const int certified = found == row.endings.end() ? 0 : found->second;
    std::printf("| %s | %d | %d | %d | %d | %.1f | %.2f | %.2f | %s |\n", name.c_str(), row.inputs, certified,
                row.inputs - certified - row.failures, row.failures, row.seconds, row.slowest, row.silence,
                row.what.c_str());
  };
  for (const auto& [name, row] : rows) {
    print(name, row);
    all.inputs += row.inputs;
    all.failures += row.failures;
    all.seconds += row.seconds;
    all.slowest = std::max(all.slowest, row.slowest);
    all.silence = std::max(all.silence, row.silence);
    for (const auto& [how, count] : row.endings) all.endings[how] += count;
  }
  print("all", all);
  std::printf("\n");
  for (const auto& [how, count] : all.endings) std::printf("%8d %s\n", count, how.c_str());
  return failures == 0 ? 0 : 1;
}

// One slice file, here and now.
int run_file(const Settings& settings) {
  slice2mesh::Options options;
  if (settings.eps >= 0) options.eps = slice2mesh::Length::mm(settings.eps);
  const slice2mesh::SliceStack stack = slice2mesh::read_cli(settings.file);
  SilenceMeter meter(settings.silence);
  const auto start = std::chrono::steady_clock::now();
  const Outcome outcome = run_metered(stack, options, meter);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("%s %s: %zu tets (%.2f s, silence %.2f s)\n", to_string(outcome.ending), outcome.message.c_str(),
              outcome.mesh.tets.size(), seconds, meter.longest());
  if (outcome.certified()) {
    const slice2mesh::QualityReport quality = slice2mesh::measure_quality(outcome.mesh);
    std::printf("     R/3r: mean %.4f, worst %.2f\n", quality.ratio.mean, quality.ratio.worst);
  }
  for (const auto& [stage, time] : outcome.seconds) std::printf("     %s %.2f s\n", to_string(stage), time);
  return outcome.certified() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--large") {
      settings.large = true;
    } else if (option == "--list") {
      settings.list = true;
    } else if (i + 1 < argc) {
      const std::string value = argv[++i];
      const unsigned long number = std::strtoul(value.c_str(), nullptr, 10);
      if (option == "--seeds") settings.seeds = static_cast<std::uint32_t>(number);
      if (option == "--first") settings.first = static_cast<std::uint32_t>(number);
      if (option == "--limit") settings.limit = static_cast<unsigned>(number);
      if (option == "--memory") settings.memory = number;
      if (option == "--class") settings.only_class = value;
      if (option == "--case") settings.only_case = value;
      if (option == "--save") settings.save = value;
      if (option == "--file") settings.file = value;
      if (option == "--silence") std::from_chars(value.data(), value.data() + value.size(), settings.silence);
      if (option == "--eps") std::from_chars(value.data(), value.data() + value.size(), settings.eps);
    }
  }
  try {
    return settings.file.empty() ? run(settings) : run_file(settings);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "torture_driver: %s\n", error.what());
    return 2;
  }
}
