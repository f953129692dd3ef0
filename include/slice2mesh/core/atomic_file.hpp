// SPDX-License-Identifier: MIT
/// @file
/// @brief Files that are written whole or not at all.
#pragma once

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <locale>
#include <random>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "slice2mesh/core/error.hpp"

namespace slice2mesh {

/// A file that appears under its name only when it is complete. What is written to `stream()` goes to a temporary file
/// in the same folder; `commit()` renames it to `path`, and the destructor removes it when `commit()` was not reached.
/// An existing file keeps its old content until then, and its permissions. A symbolic link is followed. A `path` that
/// is not a regular file (a device, a pipe) is written directly, since there is nothing to rename.
///
/// Errors: FileError with the given stage when the file cannot be created, written (full disk) or renamed.
class AtomicFile {
public:
  /// Opens the temporary file; `stage` is that of the errors. Errors: FileError.
  AtomicFile(std::string path, Stage stage) : path_(std::move(path)), stage_(stage), buffer_(kBufferBytes) {
    namespace fs = std::filesystem;
    std::error_code ignored;
    target_ = fs::path(path_);
    if (path_.empty()) throw FileError(stage_, path_, "the file name is empty");
    if (fs::is_symlink(fs::symlink_status(target_, ignored))) {
      fs::path resolved = fs::weakly_canonical(target_, ignored);
      if (!ignored && !resolved.empty()) target_ = std::move(resolved);
    }
    const fs::file_status status = fs::status(target_, ignored);
    if (fs::is_directory(status)) throw FileError(stage_, path_, "is a folder");
    // /dev/stdout may lead to a regular file; the one who opened it wants the text there, not in a new file.
    direct_ = (fs::exists(status) && !fs::is_regular_file(status)) || path_.rfind("/dev/", 0) == 0;
    if (direct_) {
      temporary_ = target_;
    } else {
      reserve_temporary();
      if (fs::exists(status)) fs::permissions(temporary_, status.permissions(), ignored);
    }
    stream_.rdbuf()->pubsetbuf(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    errno = 0;
    stream_.open(temporary_, std::ios::binary | std::ios::out | std::ios::trunc);
    if (!stream_) {
      const std::string reason = last_error("cannot be opened for writing");
      discard();
      throw FileError(stage_, path_, reason);
    }
    stream_.imbue(std::locale::classic());
  }
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile() { discard(); }

  /// The stream to write to: binary, classic locale.
  [[nodiscard]] std::ostream& stream() noexcept { return stream_; }

  /// Flush, close, check, rename. Throws FileError (and leaves no partial file) when anything was not written.
  void commit() {
    if (done_) return;
    if (stream_) {  // else errno may still say why an earlier write failed
      errno = 0;
      stream_.flush();
    }
    bool good = static_cast<bool>(stream_);
    std::string reason = good ? std::string() : last_error("cannot be written");
    stream_.close();
    if (good && !stream_) {
      good = false;
      reason = last_error("cannot be written");
    }
    if (!good) {
      discard();
      throw FileError(stage_, path_, reason);
    }
    if (!direct_) {
      std::error_code code;
      std::filesystem::rename(temporary_, target_, code);
      if (code) {
        discard();
        throw FileError(stage_, path_, "cannot be replaced: " + code.message());
      }
    }
    done_ = true;
  }

private:
  static constexpr std::size_t kBufferBytes = std::size_t{1} << 16;
  static constexpr int kNameAttempts = 100;

  static std::string last_error(const std::string& what) {
    const int code = errno;
    return code == 0 ? what : what + ": " + std::generic_category().message(code);
  }

  /// Create an empty file under a name that nobody else has.
  void reserve_temporary() {
    static std::atomic<std::uint64_t> counter{0};
    std::random_device random;
    for (int attempt = 0; attempt < kNameAttempts; ++attempt) {
      std::filesystem::path name = target_;
      name += ".tmp" + std::to_string(random()) + "_" + std::to_string(counter.fetch_add(1));
      errno = 0;
      if (std::FILE* file = std::fopen(name.string().c_str(), "wbx")) {
        std::fclose(file);
        temporary_ = std::move(name);
        return;
      }
      if (errno != EEXIST) break;
    }
    done_ = true;  // nothing to remove
    throw FileError(stage_, path_, last_error("cannot be created"));
  }

  void discard() noexcept {
    if (done_) return;
    done_ = true;
    if (stream_.is_open()) stream_.close();
    if (!direct_) {
      std::error_code ignored;
      std::filesystem::remove(temporary_, ignored);
    }
  }

  std::string path_;
  Stage stage_;
  std::filesystem::path target_;
  std::filesystem::path temporary_;
  std::vector<char> buffer_;
  std::ofstream stream_;
  bool direct_ = false;
  bool done_ = false;
};

/// Write a file whole or not at all: `write(std::ostream&)` fills a temporary file that then takes the place of `path`.
/// If `write` throws, or anything cannot be written, the temporary file is removed, an existing file stays as it was
/// and the exception goes on.
/// Errors: FileError with `stage`, and whatever `write` throws.
template <class Write>
void write_file_atomically(const std::string& path, Stage stage, Write&& write) {
  AtomicFile file(path, stage);
  std::forward<Write>(write)(file.stream());
  file.commit();
}

}  // namespace slice2mesh
