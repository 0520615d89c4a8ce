#include "engine/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

namespace nephele {
namespace {

namespace fs = std::filesystem;

Error cannot_write(const std::string& path, const std::string& reason) {
  return Error{path + ": can't be written: " + reason};
}

// Where the bytes really go: a symbolic link stays a link. Devices and directories are refused, because the
// rename would replace them.
Result<fs::path> resolve_target(const std::string& path) {
  if (path.empty()) return Error{"an output path is empty"};
  std::error_code failure;
  const fs::file_status status = fs::status(path, failure);
  if (status.type() == fs::file_type::directory) return cannot_write(path, "it is a directory");
  if (fs::exists(status) && status.type() != fs::file_type::regular)
    return cannot_write(path, "it is not a plain file");
  if (!fs::exists(status)) return fs::path(path);
  const fs::path target = fs::canonical(path, failure);
  if (failure) return cannot_write(path, failure.message());
  return target;
}

// The temporary file; removed unless renamed.
class TemporaryFile {
 public:
  explicit TemporaryFile(const fs::path& target) {
    static std::atomic<unsigned> counter{0};
    name_ = target.parent_path() /
            ('.' + target.filename().string() + ".tmp" + std::to_string(::getpid()) + '-' + std::to_string(counter++));
    descriptor_ = ::open(name_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  }
  ~TemporaryFile() {
    if (descriptor_ < 0) return;
    ::close(descriptor_);
    if (!renamed_) ::unlink(name_.c_str());
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  bool is_open() const { return descriptor_ >= 0; }
  bool write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return false;
      bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
    return true;
  }
  bool rename_to(const fs::path& target) {
    renamed_ = std::rename(name_.c_str(), target.c_str()) == 0;
    return renamed_;
  }

 private:
  fs::path name_;
  int descriptor_ = -1;
  bool renamed_ = false;
};

}  // namespace

Result<void> write_file_atomically(const std::string& path, std::span<const std::byte> bytes) {
  const Result<fs::path> target = resolve_target(path);
  if (!target) return target.error();
  TemporaryFile file(*target);
  if (!file.is_open() || !file.write(bytes) || !file.rename_to(*target))
    return cannot_write(path, std::strerror(errno));
  return {};
}

Result<void> write_file_atomically(const std::string& path, std::string_view text) {
  return write_file_atomically(path, std::as_bytes(std::span(text.data(), text.size())));
}

Result<void> check_writable(const std::string& path) {
  const Result<fs::path> target = resolve_target(path);
  if (!target) return target.error();
  if (!TemporaryFile(*target).is_open()) return cannot_write(path, std::strerror(errno));
  return {};
}

}  // namespace nephele
