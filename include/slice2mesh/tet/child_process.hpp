// SPDX-License-Identifier: MIT
/// @file
/// @brief Work in a child process: what crashes, loops or takes all memory there ends there.
///
/// POSIX only; elsewhere the functions throw. A child made by `run_in_child` is a copy of the calling thread alone, so
/// its work must not wait for other threads of the program.
#pragma once

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <functional>
#include <new>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/progress.hpp"

#if defined(__unix__) || defined(__APPLE__)
#define SLICE2MESH_HAS_CHILD_PROCESSES 1
#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>
#if defined(__linux__)
#include <sys/prctl.h>
#endif
#else
/// 1 on systems with fork, else 0.
#define SLICE2MESH_HAS_CHILD_PROCESSES 0
#endif

namespace slice2mesh {

/// What a child process may use.
struct ChildLimits {
  double time = 600;        ///< s of wall-clock time, >= 0; 0: no limit
  std::int64_t memory = 0;  ///< bytes of address space, what it has from its parent included; 0: no limit
};

/// What came of a child process.
struct ChildResult {
  std::vector<char> bytes;       ///< the bytes that its work returned, or the last of what a command printed
  int exit_code = 0;             ///< of a command: the number that it ended with
  double seconds = 0;            ///< s of wall-clock time
  std::int64_t peak_memory = 0;  ///< bytes, largest resident size
};

namespace detail {

[[nodiscard]] inline std::string seconds_text(double seconds) {
  const auto tenths = static_cast<long long>(std::llround(seconds * 10));
  return std::to_string(tenths / 10) + (tenths % 10 == 0 ? "" : "." + std::to_string(tenths % 10)) + " s";
}

inline void check_limits(const ChildLimits& limits) {
  if (!(limits.time >= 0) || std::isinf(limits.time)) throw OptionError("limits.time", "must be a number of seconds");
  if (limits.memory < 0) throw OptionError("limits.memory", "must be a number of bytes");
}

#if SLICE2MESH_HAS_CHILD_PROCESSES

/// A file descriptor that is closed once.
class Descriptor {
public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(); }
  void reset(int fd) {
    close();
    fd_ = fd;
  }
  void close() {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }
  [[nodiscard]] int get() const { return fd_; }

private:
  int fd_;
};

/// A child process with a pipe from it. It is killed, with the processes that it started, and waited for when this
/// object goes.
class Child {
public:
  /// `run(fd)` is called in the child, with the writing end of the pipe; the child ends with the code that it returns.
  template <class Run>
  Child(const std::string& name, const ChildLimits& limits, Run&& run)
      : name_(name), limits_(limits), start_(Clock::now()) {
    int ends[2];
    if (::pipe(ends) != 0) fail("has no pipe: " + error_text());
    read_.reset(ends[0]);
    Descriptor write(ends[1]);
    ::fcntl(ends[0], F_SETFD, FD_CLOEXEC);
    ::fcntl(ends[1], F_SETFD, FD_CLOEXEC);
    const pid_t parent = ::getpid();
    pid_ = ::fork();
    if (pid_ < 0) fail("cannot be started: " + error_text());
    if (pid_ == 0) {
      prepare(parent, limits);
      int code = 1;
      try {
        code = run(write.get());
      } catch (...) {
      }
      ::_exit(code);
    }
    // Also here: whoever of the two comes first, the group exists before it is needed.
    (void)::setpgid(pid_, pid_);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    if (pid_ > 0) {
      end();
      int status = 0;
      while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
      }
    }
  }

  /// Reads what the child writes until it ends. `keep` > 0: only the last so many bytes.
  [[nodiscard]] ChildResult wait(const Progress& progress, std::size_t keep) {
    ChildResult result;
    bool open = true;
    std::vector<char> block(std::size_t{1} << 16);
    while (true) {
      // The end of the process counts, not that of the pipe, which a process left behind may hold open.
      const bool ended = try_reap(result);
      if (open) open = read_some(result.bytes, block, keep, ended ? 0 : kPollMilliseconds, ended);
      if (ended) break;
      if (!open) ::poll(nullptr, 0, kReapMilliseconds);
      report(progress, Stage::Tetrahedralize, 0);
      if (limits_.time > 0 && elapsed() > limits_.time) {
        end();
        fail("did not end within " + seconds_text(limits_.time));
      }
    }
    result.seconds = elapsed();
    return result;
  }

  [[noreturn]] void fail(const std::string& what) const { throw TetrahedralizationError(-1, name_ + " " + what); }
  /// Throws if the child was ended by a signal.
  void check_signal() const {
    if (!WIFSIGNALED(status_)) return;
    const int signal = WTERMSIG(status_);
    const char* text = signal == SIGSEGV   ? " (segmentation fault)"
                       : signal == SIGABRT ? " (abort)"
                       : signal == SIGKILL ? " (killed; out of memory?)"
                       : signal == SIGFPE  ? " (arithmetic)"
                       : signal == SIGBUS  ? " (bus error)"
                                           : "";
    fail("crashed with signal " + std::to_string(signal) + text);
  }

private:
  using Clock = std::chrono::steady_clock;
  static constexpr int kPollMilliseconds = 20;  // how long a cancellation may wait
  static constexpr int kReapMilliseconds = 2;

  [[nodiscard]] double elapsed() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  [[nodiscard]] static std::string error_text() { return std::generic_category().message(errno); }

  // In the child: its own group, so that it can be ended with all its children; no terminal; limits.
  static void prepare(pid_t parent, const ChildLimits& limits) {
    (void)::setpgid(0, 0);
#if defined(__linux__)
    (void)::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(1);
#else
    (void)parent;
#endif
    for (const int signal : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGINT, SIGTERM, SIGPIPE}) std::signal(signal, SIG_DFL);
    const int null = ::open("/dev/null", O_RDWR);
    if (null >= 0)
      for (int fd = 0; fd <= 2; ++fd) (void)::dup2(null, fd);
    const struct rlimit no_core = {0, 0};
    (void)::setrlimit(RLIMIT_CORE, &no_core);
    if (limits.memory > 0) {
      const struct rlimit memory = {static_cast<rlim_t>(limits.memory), static_cast<rlim_t>(limits.memory)};
      (void)::setrlimit(RLIMIT_AS, &memory);
    }
  }

  void end() const {
    (void)::kill(-pid_, SIGKILL);
    (void)::kill(pid_, SIGKILL);
  }

  [[nodiscard]] bool try_reap(ChildResult& result) {
    struct rusage usage;
    const pid_t ended = ::wait4(pid_, &status_, WNOHANG, &usage);
    if (ended == 0 || (ended < 0 && errno == EINTR)) return false;
    if (ended == pid_) {
#if defined(__APPLE__)
      result.peak_memory = usage.ru_maxrss;
#else
      result.peak_memory = std::int64_t{usage.ru_maxrss} * 1024;
#endif
      result.exit_code = WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
      (void)::kill(-pid_, SIGKILL);  // what it left behind
    }
    pid_ = -1;
    return true;
  }

  // Reads what there is; waits for the first bytes only. Returns false at the end of the pipe.
  [[nodiscard]] bool read_some(std::vector<char>& bytes, std::vector<char>& block, std::size_t keep, int milliseconds,
                               bool all) const {
    struct pollfd waiting = {read_.get(), POLLIN, 0};
    while (::poll(&waiting, 1, milliseconds) > 0) {
      const ssize_t got = ::read(read_.get(), block.data(), block.size());
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return false;
      bytes.insert(bytes.end(), block.begin(), block.begin() + got);
      if (keep > 0 && bytes.size() > 2 * keep) bytes.erase(bytes.begin(), bytes.end() - std::ptrdiff_t(keep));
      if (!all) break;
      milliseconds = 0;
    }
    return true;
  }

  std::string name_;
  ChildLimits limits_;
  Clock::time_point start_;
  Descriptor read_;
  pid_t pid_ = -1;
  int status_ = 0;
};

/// Writes all bytes to a pipe; false if that cannot be done.
[[nodiscard]] inline bool write_all(int fd, const char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t written = ::write(fd, data, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    data += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

#endif

}  // namespace detail

/// Runs `work` in a copy of this process and returns the bytes that it returns. What it prints is lost.
/// Errors: TetrahedralizationError, which begins with `name`: what `work` threw, a crash, the time limit; Cancelled (or
/// whatever `progress` throws) while waiting, after which the child is no more; OptionError.
[[nodiscard]] inline ChildResult run_in_child(const std::string& name, const std::function<std::vector<char>()>& work,
                                              const ChildLimits& limits = {}, const Progress& progress = {}) {
  detail::check_limits(limits);
#if SLICE2MESH_HAS_CHILD_PROCESSES
  // The first byte says what follows: the result, or the message of an error.
  detail::Child child(name, limits, [&](int fd) {
    std::vector<char> bytes;
    char kind = 'r';
    try {
      bytes = work();
    } catch (const std::bad_alloc&) {
      const std::string text = "ran out of memory";
      bytes.assign(text.begin(), text.end());
      kind = 'e';
    } catch (const std::exception& error) {
      const std::string text = error.what();
      bytes.assign(text.begin(), text.end());
      kind = 'e';
    } catch (...) {
      const std::string text = "threw what is no exception";
      bytes.assign(text.begin(), text.end());
      kind = 'e';
    }
    return detail::write_all(fd, &kind, 1) && detail::write_all(fd, bytes.data(), bytes.size()) ? 0 : 1;
  });
  ChildResult result = child.wait(progress, 0);
  child.check_signal();
  if (result.exit_code != 0 || result.bytes.empty())
    child.fail("ended with code " + std::to_string(result.exit_code) + " and without a result");
  const bool good = result.bytes.front() == 'r';
  result.bytes.erase(result.bytes.begin());
  if (!good) child.fail("failed: " + std::string(result.bytes.begin(), result.bytes.end()));
  return result;
#else
  (void)work;
  (void)progress;
  throw TetrahedralizationError(-1, name + ": no child processes on this system");
#endif
}

/// Runs a command with `/bin/sh` in a directory. `bytes` of the result is the last part of what it printed. A command
/// that ends with another code than 0 is no error.
/// Errors: TetrahedralizationError, which begins with `name`: a crash, the time limit, no such directory; Cancelled (or
/// whatever `progress` throws) while waiting, after which the command is no more; OptionError.
[[nodiscard]] inline ChildResult run_command(const std::string& name, const std::string& command,
                                             const std::string& directory, const ChildLimits& limits = {},
                                             const Progress& progress = {}) {
  detail::check_limits(limits);
#if SLICE2MESH_HAS_CHILD_PROCESSES
  constexpr std::size_t kLastOutput = 4000;  // bytes: enough for the message of an error
  detail::Child child(name, limits, [&](int fd) {
    if (::chdir(directory.c_str()) != 0) return 126;
    (void)::dup2(fd, 1);
    (void)::dup2(fd, 2);
    ::execl("/bin/sh", "sh", "-c", command.c_str(), static_cast<char*>(nullptr));
    return 127;
  });
  ChildResult result = child.wait(progress, kLastOutput);
  child.check_signal();
  return result;
#else
  (void)command;
  (void)directory;
  (void)progress;
  throw TetrahedralizationError(-1, name + ": no child processes on this system");
#endif
}

}  // namespace slice2mesh
