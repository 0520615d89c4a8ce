#include "tools/clouds/child_volume.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include "engine/check.h"

namespace nephele::clouds {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostTextBytes = std::size_t{1} << 16;
constexpr std::size_t kMostTexts = 64, kMostTimes = std::size_t{1} << 20;

// One end of the connection. Any failure of the other side ends all further calls.
class Line {
 public:
  explicit Line(int socket) : socket_(socket) {}
  bool good() const { return good_; }
  bool late() const { return late_; }
  void allow(double seconds) {
    until_ = Clock::now() + std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * seconds));
  }

  void send(const void* data, std::size_t bytes) {
    const char* at = static_cast<const char*>(data);
    while (good_ && bytes > 0) {
      const ssize_t sent = ::send(socket_, at, bytes, MSG_NOSIGNAL);
      if (sent < 0 && errno == EINTR) continue;
      if (sent <= 0) good_ = false;
      at += std::max<ssize_t>(sent, 0);
      bytes -= static_cast<std::size_t>(std::max<ssize_t>(sent, 0));
    }
  }
  void receive(void* data, std::size_t bytes) {
    char* at = static_cast<char*>(data);
    while (good_ && bytes > 0) {
      if (until_ && !wait_for_data()) return;
      const ssize_t got = ::recv(socket_, at, bytes, 0);
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) good_ = false;
      at += std::max<ssize_t>(got, 0);
      bytes -= static_cast<std::size_t>(std::max<ssize_t>(got, 0));
    }
  }

  template <class T>
  void put(const T& value) {
    send(&value, sizeof value);
  }
  template <class T>
  T get() {
    T value{};
    receive(&value, sizeof value);
    return value;
  }
  void put_text(const std::string& text) {
    const std::size_t bytes = std::min(text.size(), kMostTextBytes);
    put(static_cast<std::uint64_t>(bytes));
    send(text.data(), bytes);
  }
  std::string get_text() {
    std::string text(get_count(kMostTextBytes), ' ');
    receive(text.data(), text.size());
    return good_ ? text : "";
  }
  void put_numbers(const std::vector<double>& numbers) {
    put(static_cast<std::uint64_t>(numbers.size()));
    send(numbers.data(), numbers.size() * sizeof(double));
  }
  std::vector<double> get_numbers(std::size_t most) {
    std::vector<double> numbers(get_count(most));
    receive(numbers.data(), numbers.size() * sizeof(double));
    return numbers;
  }
  std::size_t get_count(std::size_t most) {
    const auto count = get<std::uint64_t>();
    if (count > most) good_ = false;
    return good_ ? static_cast<std::size_t>(count) : 0;
  }

 private:
  bool wait_for_data() {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(*until_ - Clock::now()).count();
    pollfd watched{socket_, POLLIN, 0};
    const int ready = left > 0 ? ::poll(&watched, 1, static_cast<int>(std::min<std::int64_t>(left, 1000000))) : 0;
    if (ready < 0 && errno == EINTR) return true;
    if (ready <= 0) {
      good_ = false;
      late_ = ready == 0;
    }
    return good_;
  }

  int socket_;
  bool good_ = true, late_ = false;
  std::optional<Clock::time_point> until_;
};

void limit(int what, std::size_t value) {
  rlimit both{};
  ::getrlimit(static_cast<__rlimit_resource_t>(what), &both);
  both.rlim_cur = std::min<rlim_t>(value, both.rlim_max);
  ::setrlimit(static_cast<__rlimit_resource_t>(what), &both);
}

// In words: what an exception says, in one line.
template <class Body>
Result<void> guarded(Body&& body) {
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return Error{"reading it takes more memory than its size explains; it is damaged"};
  } catch (const std::exception& failure) {
    return Error{std::string("damaged, or not what its ending says: ") + failure.what()};
  } catch (...) {
    return Error{"damaged, or not what its ending says"};
  }
}

void answer(Line& line, const Result<void>& result) {
  line.put(static_cast<std::uint8_t>(result ? 1 : 0));
  if (!result) line.put_text(result.error().message);
}

[[noreturn]] void serve(int socket, const std::string& path,
                        const std::function<Result<std::unique_ptr<VolumeReader>>()>& open) {
  Line line(socket);
  std::unique_ptr<VolumeReader> reader;
  const auto named = [&](const Result<void>& result) {
    return result || result.error().message.starts_with(path)
               ? result
               : Result<void>(Error{path + ": " + result.error().message});
  };
  const Result<void> opened = named(guarded([&]() -> Result<void> {
    Result<std::unique_ptr<VolumeReader>> made = open();
    if (!made) return made.error();
    reader = std::move(*made);
    return check_grid(reader->grid());
  }));
  answer(line, opened);
  if (!opened) ::_exit(0);
  line.put(reader->axes());
  for (const std::vector<double>& bounds : reader->grid().bounds_m) line.put_numbers(bounds);
  line.put(reader->grid().anchor_m);
  const std::vector<std::string> assumptions = reader->assumptions();
  line.put(static_cast<std::uint64_t>(std::min(assumptions.size(), kMostTexts)));
  for (std::size_t i = 0; i < std::min(assumptions.size(), kMostTexts); ++i) line.put_text(assumptions[i]);
  line.put_numbers(reader->times_s());
  std::vector<float> values;
  while (line.good()) {
    const auto first = line.get<std::uint64_t>(), count = line.get<std::uint64_t>();
    if (!line.good() || count == 0) break;
    const Result<void> read = named(guarded([&]() -> Result<void> {
      values.resize(static_cast<std::size_t>(count) * reader->plane_voxels());
      return reader->read_planes(static_cast<std::size_t>(first), static_cast<std::size_t>(count), values);
    }));
    answer(line, read);
    if (read) line.send(values.data(), values.size() * sizeof(float));
  }
  ::_exit(0);  // nothing of the parent's is to be tidied up twice
}

class ChildVolume : public VolumeReader {
 public:
  ChildVolume(std::string path, pid_t child, int socket, const ChildLimits& limits)
      : path_(std::move(path)), child_(child), socket_(socket), limits_(limits), line_(socket) {}
  ~ChildVolume() override {
    ::close(socket_);
    ::kill(child_, SIGKILL);
    ::waitpid(child_, nullptr, 0);
  }
  ChildVolume(const ChildVolume&) = delete;
  ChildVolume& operator=(const ChildVolume&) = delete;

  Result<void> start() {
    line_.allow(limits_.seconds);
    if (auto ok = outcome(); !ok) return ok;
    axes_ = line_.get<std::array<int, 3>>();
    for (std::vector<double>& bounds : grid_.bounds_m) bounds = line_.get_numbers(kMaxVoxelsAlongAxis + 1);
    grid_.anchor_m = line_.get<glm::dvec3>();
    assumptions_.resize(line_.get_count(kMostTexts));
    for (std::string& text : assumptions_) text = line_.get_text();
    times_s_ = line_.get_numbers(kMostTimes);
    std::array<int, 3> sorted = axes_;
    std::sort(sorted.begin(), sorted.end());
    if (!line_.good() || sorted != std::array{0, 1, 2}) return broken();
    if (auto ok = check_grid(grid_); !ok) return Error{path_ + ": " + ok.error().message};
    return {};
  }

  const VolumeGrid& grid() const override { return grid_; }
  std::array<int, 3> axes() const override { return axes_; }
  std::vector<std::string> assumptions() const override { return assumptions_; }
  std::vector<double> times_s() const override { return times_s_; }

  Result<void> read_planes(std::size_t first, std::size_t count, std::span<float> values) override {
    NEPHELE_CHECK(values.size() == count * plane_voxels() && first + count <= planes() && count > 0);
    line_.allow(limits_.seconds);
    line_.put(static_cast<std::uint64_t>(first));
    line_.put(static_cast<std::uint64_t>(count));
    if (auto ok = outcome(); !ok) return ok;
    line_.receive(values.data(), values.size_bytes());
    if (!line_.good()) return broken();
    return {};
  }

 private:
  Result<void> outcome() {
    const auto good = line_.get<std::uint8_t>();
    if (!line_.good()) return broken();
    if (good == 1) return {};
    const std::string text = line_.get_text();
    if (text.empty()) return broken();
    return Error{text};
  }
  Error broken() const {
    if (line_.late())
      return Error{concat(path_, ": reading it takes longer than ", limits_.seconds,
                          " s at once; it is damaged or on a "
                          "device that does not answer")};
    return Error{path_ + ": the library that reads it failed without a word; it is damaged"};
  }

  std::string path_;
  pid_t child_;
  int socket_;
  ChildLimits limits_;
  Line line_;
  VolumeGrid grid_;
  std::array<int, 3> axes_{0, 1, 2};
  std::vector<std::string> assumptions_;
  std::vector<double> times_s_;
};

}  // namespace

Result<std::unique_ptr<VolumeReader>> open_in_child(const std::string& path,
                                                    std::function<Result<std::unique_ptr<VolumeReader>>()> open,
                                                    const ChildLimits& limits) {
  std::error_code failure;
  const std::uintmax_t bytes = std::filesystem::file_size(path, failure);
  if (failure) return Error{path + ": cannot be opened for reading: " + failure.message()};
  const std::size_t memory =
      limits.memory_bytes > 0 ? limits.memory_bytes : (std::size_t{4} << 30) + 8 * static_cast<std::size_t>(bytes);
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    return Error{path + ": cannot be read: no connection to a process that would"};
  const pid_t child = ::fork();
  if (child < 0) {
    ::close(ends[0]);
    ::close(ends[1]);
    return Error{path + ": cannot be read: no process can be started"};
  }
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    std::signal(SIGABRT, SIG_DFL);
    const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    ::dup2(nowhere, STDOUT_FILENO);
    ::dup2(nowhere, STDERR_FILENO);  // the libraries' own words
    ::close(ends[0]);
    limit(RLIMIT_CORE, 0);
#ifndef __SANITIZE_ADDRESS__  // which reserves far more than it uses
    limit(RLIMIT_AS, memory);
#endif
    serve(ends[1], path, open);
  }
  ::close(ends[1]);
  auto volume = std::make_unique<ChildVolume>(path, child, ends[0], limits);
  if (auto ok = volume->start(); !ok) return ok.error();
  return std::unique_ptr<VolumeReader>(std::move(volume));
}

}  // namespace nephele::clouds
