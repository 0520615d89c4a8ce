#include "tools/clouds/mesh_reader.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <system_error>

#ifdef NEPHELE_IMPORT
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <assimp/Importer.hpp>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <exception>
#include <fstream>
#include <iterator>
#include <span>
#endif

namespace nephele::clouds {

#ifdef NEPHELE_IMPORT
namespace {

// What the child sends first; after readable come the triangles' corners as floats.
struct Reply {
  std::uint32_t readable = 0;
  std::uint32_t triangles = 0;  // may be above kMaxTriangles: then none follow
};
constexpr std::uint32_t kReadable = 0x4d455348;
constexpr std::size_t kFloatsPerTriangle = 9;

// Far more than a whole file of that size takes, of processor time: 200 000 triangles take 0.2 s.
std::size_t seconds_for(std::size_t bytes) { return 1 + (bytes >> 20); }
std::size_t memory_for(std::size_t bytes) { return (std::size_t{1} << 29) + 48 * bytes; }

bool write_all(int file, std::span<const char> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

// Reads until `bytes` is full; false at the end of the file or of the time.
bool read_all(int file, std::span<char> bytes, std::chrono::steady_clock::time_point deadline) {
  while (!bytes.empty()) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now()).count();
    pollfd waited{file, POLLIN, 0};
    const int ready = left > 0 ? poll(&waited, 1, static_cast<int>(left)) : 0;
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return false;
    const ssize_t got = read(file, bytes.data(), bytes.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

// Damaged files end here: silent, without a core file, and with bounds on time and memory.
void limit_this_process(std::size_t bytes) {
  const rlimit no_core{0, 0}, seconds{seconds_for(bytes), seconds_for(bytes)};
  setrlimit(RLIMIT_CORE, &no_core);
  setrlimit(RLIMIT_CPU, &seconds);
#ifndef __SANITIZE_ADDRESS__  // which maps far more than it uses
  const rlimit memory{memory_for(bytes), memory_for(bytes)};
  setrlimit(RLIMIT_DATA, &memory);
#endif
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
}

// The child's whole life: status 0 once everything is sent.
int send_triangles(int pipe_end, const std::string& bytes, const char* ending) try {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(),
                                                     aiProcess_Triangulate | aiProcess_PreTransformVertices, ending);
  if (!scene) return 1;
  std::vector<float> corners;
  std::uint64_t count = 0;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;  // points and lines
      if (++count > kMaxTriangles) continue;
      for (unsigned corner = 0; corner < 3; ++corner) {
        if (face.mIndices[corner] >= mesh.mNumVertices) return 1;
        const aiVector3D& vertex = mesh.mVertices[face.mIndices[corner]];
        for (const ai_real value : {vertex.x, vertex.y, vertex.z}) corners.push_back(static_cast<float>(value));
      }
    }
  }
  const Reply reply{kReadable, static_cast<std::uint32_t>(std::min<std::uint64_t>(count, 0xffffffffu))};
  if (!write_all(pipe_end, {reinterpret_cast<const char*>(&reply), sizeof reply})) return 1;
  if (count > kMaxTriangles) return 0;
  return write_all(pipe_end, {reinterpret_cast<const char*>(corners.data()), corners.size() * sizeof(float)}) ? 0 : 1;
} catch (const std::exception&) {
  return 1;
}

Result<std::vector<float>> corners_of(const std::string& path, const std::string& bytes, const char* ending) {
  const Error unreadable{path + ": is no mesh that can be read, or it is damaged"};
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return Error{path + ": no pipe to read it through: " + std::strerror(errno)};
  const pid_t child = fork();
  if (child < 0) {
    close(ends[0]);
    close(ends[1]);
    return Error{path + ": no process to read it in: " + std::strerror(errno)};
  }
  if (child == 0) {
    for (const int fault : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL}) std::signal(fault, SIG_DFL);
    std::signal(SIGPIPE, SIG_IGN);
    limit_this_process(bytes.size());
    _exit(send_triangles(ends[1], bytes, ending));
  }
  close(ends[1]);
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10 * seconds_for(bytes.size()));
  Reply reply;
  std::vector<float> corners;
  bool whole =
      read_all(ends[0], {reinterpret_cast<char*>(&reply), sizeof reply}, deadline) && reply.readable == kReadable;
  if (whole && reply.triangles <= kMaxTriangles) {
    corners.resize(reply.triangles * kFloatsPerTriangle);
    whole = read_all(ends[0], {reinterpret_cast<char*>(corners.data()), corners.size() * sizeof(float)}, deadline);
  }
  close(ends[0]);
  if (!whole) kill(child, SIGKILL);
  while (waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
  }
  if (!whole) return unreadable;
  if (reply.triangles > kMaxTriangles)
    return Error{path + ": " + std::to_string(reply.triangles) + " triangles; accepted: at most " +
                 std::to_string(kMaxTriangles)};
  return corners;
}

}  // namespace

Result<std::vector<Triangle>> read_mesh(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (ending != ".obj" && ending != ".ply") return Error{path + ": accepted: a mesh named .obj or .ply"};
  std::error_code failure;
  if (std::filesystem::is_directory(path, failure)) return Error{path + ": is a directory, not a file"};
  const std::uintmax_t size = std::filesystem::file_size(path, failure);
  if (failure) return Error{path + ": can't be opened: " + failure.message()};
  if (size > kMaxMeshBytes)
    return Error{path + ": " + std::to_string(size) + " bytes; accepted: at most " + std::to_string(kMaxMeshBytes)};
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{path + ": can't be opened: " + std::strerror(errno)};
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const Result<std::vector<float>> corners = corners_of(path, bytes, ending.c_str() + 1);
  if (!corners) return corners.error();
  std::vector<Triangle> triangles;
  for (std::size_t i = 0; i < corners->size(); i += kFloatsPerTriangle) {
    const float* c = corners->data() + i;
    for (std::size_t k = 0; k < kFloatsPerTriangle; ++k)
      if (!(std::abs(c[k]) <= 1e9f))
        return Error{path + ": triangle " + std::to_string(i / kFloatsPerTriangle) +
                     " has a corner that is not finite or beyond 1e9"};
    const Triangle triangle{glm::dvec3(c[0], c[1], c[2]), glm::dvec3(c[3], c[4], c[5]), glm::dvec3(c[6], c[7], c[8])};
    if (glm::length(glm::cross(triangle[1] - triangle[0], triangle[2] - triangle[0])) > 0.0)
      triangles.push_back(triangle);
  }
  if (triangles.empty()) return Error{path + ": has no triangle with an area"};
  return triangles;
}

#else

Result<std::vector<Triangle>> read_mesh(const std::string& path) {
  return Error{path + ": this build reads no meshes; it needs Debian's package libassimp-dev and NEPHELE_IMPORT=ON"};
}

#endif

}  // namespace nephele::clouds
