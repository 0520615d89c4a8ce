// Volumes in files: round trips through every format, and damage of every kind is one line, whatever the library that
// reads the format does with it.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <memory>
#include <vector>

#include "engine/image_io.h"
#include "engine/npy.h"
#include "shared/hash.h"
#include "tests/support/support.h"
#include "tools/clouds/child_volume.h"
#include "tools/clouds/netcdf_file.h"
#include "tools/clouds/npy_volume.h"
#include "tools/clouds/open_volume.h"
#include "tools/clouds/particle_grid.h"
#include "tools/clouds/png_volume.h"
#include "tools/clouds/vdb_file.h"
#include "tools/clouds/volume_fit.h"

using namespace nephele;
using namespace nephele::clouds;
using nephele::test::TempDirectory;

namespace {

// A small cloud of three particles, 25 m a voxel.
std::vector<PlacedBody> three_bodies() {
  std::vector<PlacedBody> bodies(3);
  for (std::size_t i = 0; i < 3; ++i) {
    const double k = static_cast<double>(i);
    bodies[i].center_m = {60.0 * k + 500.0, 40.0 * k - 200.0, 30.0 * k + 900.0};
    bodies[i].shape_m = glm::dmat3(90.0, 10.0 * k, 0.0, 10.0 * k, 70.0, 0.0, 0.0, 0.0, 60.0 + 5.0 * k);
    bodies[i].extinction_per_m = 0.02 + 0.01 * k;
  }
  return bodies;
}

ParticleGrid small_grid(const std::array<int, 3>& axes, double voxel_m = 25.0) {
  const std::vector<PlacedBody> bodies = three_bodies();
  return ParticleGrid(bodies, grid_around(bodies, voxel_m), axes);
}

MemoryVolume loaded(VolumeReader& reader) {
  Result<MemoryVolume> volume = load_volume(reader, 1u << 24);
  if (!volume) FAIL(volume.error().message);
  return std::move(*volume);
}

MemoryVolume opened(const std::string& path, const VolumeOptions& options = {}) {
  Result<std::unique_ptr<VolumeReader>> reader = open_volume(path, options);
  if (!reader) FAIL(reader.error().message);
  return loaded(**reader);
}

std::string complaint(const std::string& path, const VolumeOptions& options = {}) {
  Result<std::unique_ptr<VolumeReader>> reader = open_volume(path, options);
  if (!reader) return reader.error().message;
  const Result<VolumeFit> fit = fit_volume(**reader, {});
  return fit ? "accepted" : fit.error().message;
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

struct Matter {
  double mass_m2 = 0.0;
  glm::dvec3 centroid_m{0.0}, variance_m2{0.0};
};

Matter matter_of(const MemoryVolume& volume) {
  Matter matter;
  const VolumeGrid& grid = volume.grid();
  glm::dvec3 first(0.0), second(0.0);
  for (std::size_t z = 0; z < grid.count(2); ++z)
    for (std::size_t y = 0; y < grid.count(1); ++y)
      for (std::size_t x = 0; x < grid.count(0); ++x) {
        const std::array<std::size_t, 3> voxel{x, y, z};
        glm::dvec3 place(0.0);
        double m = static_cast<double>(volume.at(x, y, z));
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const double low = grid.bounds_m[axis][voxel[axis]], high = grid.bounds_m[axis][voxel[axis] + 1];
          place[static_cast<int>(axis)] = 0.5 * (low + high) + grid.anchor_m[static_cast<int>(axis)];
          m *= high - low;
        }
        matter.mass_m2 += m;
        first += m * place;
        second += m * place * place;
      }
  matter.centroid_m = first / matter.mass_m2;
  matter.variance_m2 = second / matter.mass_m2 - matter.centroid_m * matter.centroid_m;
  return matter;
}

double mass_of(const MemoryVolume& volume) { return matter_of(volume).mass_m2; }

// As much matter, in the same place, spread as far along each axis: but for the width of a line of ParticleGrid, a
// third of a voxel, whose variance is (25 m / 3)^2 / 12, or 0.005 of the cloud's least.
void check_same(const MemoryVolume& a, const MemoryVolume& b, double slack) {
  const Matter first = matter_of(a), second = matter_of(b);
  CHECK(std::abs(first.mass_m2 / second.mass_m2 - 1.0) < slack);
  CHECK(glm::length(first.centroid_m - second.centroid_m) < 100.0 * slack);
  for (int axis = 0; axis < 3; ++axis)
    CHECK(std::abs(first.variance_m2[axis] / second.variance_m2[axis] - 1.0) < 2.0 * slack + 0.006);
}

void write_all_formats(const TempDirectory& dir) {
  ParticleGrid by_x = small_grid({2, 1, 0}), by_z = small_grid({0, 1, 2});
  REQUIRE(write_npy_volume(dir / "v.npy", by_x));
  REQUIRE(write_vdb_volume(dir / "v.vdb", by_x));
  REQUIRE(write_netcdf_volume(dir / "v.nc", by_z));
  REQUIRE(write_png_volume(dir / "slices", by_z));
}

// What a damaged file does: accepted, or one line that names it. OpenVDB may search a damaged grid for long: where that
// is not `late`, it fails the test.
void check_damaged(const std::string& path, int what, bool late) {
  const ChildLimits limits{.seconds = late ? 1.0 : 20.0};
  Result<std::unique_ptr<VolumeReader>> reader = Error{};
  if (path.ends_with(".vdb"))
    reader = open_in_child(
        path, [&] { return open_vdb_volume(path, "", 1.0); }, limits);
  else if (path.ends_with(".nc"))
    reader = open_in_child(
        path, [&] { return open_netcdf_volume(path, {}); }, limits);
  else
    reader = open_volume(path, {.voxel_m = glm::dvec3(25.0)});
  std::string line;
  if (!reader) {
    line = reader.error().message;
  } else {
    const Result<VolumeFit> fit = fit_volume(**reader, {});
    line = fit ? path : path + ": " + fit.error().message;
  }
  CHECK_MESSAGE(line.starts_with(path), what, ": ", line);
  if (!late) CHECK_MESSAGE(!contains(line, "longer than"), what, ": ", line);
}

void mutate(const std::string& path, int count) {
  const std::string whole = test::read_file(path);
  std::uint32_t state = 7;
  for (int i = 0; i < count; ++i) {
    std::string damaged = whole;
    const std::uint32_t changes = 1 + shared::hash_next(state) % 4;
    for (std::uint32_t k = 0; k < changes; ++k) {
      // Half of them among the first kilobyte, where what decides sizes stands.
      const std::size_t reach =
          shared::hash_next(state) % 2 == 0 ? std::min<std::size_t>(1024, damaged.size()) : damaged.size();
      const std::size_t at = shared::hash_next(state) % reach;
      const std::uint32_t value = shared::hash_next(state) % 4;
      damaged[at] = value == 0   ? '\xff'
                    : value == 1 ? '\0'
                                 : static_cast<char>(damaged[at] ^ (1 << shared::hash_next(state) % 8));
    }
    test::write_file(path, damaged);
    check_damaged(path, i, true);
  }
  test::write_file(path, whole);
}

}  // namespace

TEST_CASE("volume files: every format keeps matter and place") {
  const TempDirectory dir;
  write_all_formats(dir);
  ParticleGrid grid = small_grid({0, 1, 2});
  const MemoryVolume truth = loaded(grid);
  const MemoryVolume array = opened(dir / "v.npy", {.voxel_m = glm::dvec3(25.0)});
  const MemoryVolume vdb = opened(dir / "v.vdb"), netcdf = opened(dir / "v.nc"), slices = opened(dir / "slices");
  CHECK(std::abs(mass_of(array) / mass_of(truth) - 1.0) < 1e-6);
  // Lines run along another axis in .vdb and .npy than in the others, three to a voxel.
  check_same(vdb, truth, 1e-3);
  check_same(netcdf, truth, 1e-5);
  check_same(slices, truth, 5e-3);  // 255 steps
  // No voxel's name is turned round: in an array x is the slowest.
  REQUIRE(array.grid().count(0) == truth.grid().count(0));
  for (std::size_t z = 0; z < truth.grid().count(2); ++z)
    for (std::size_t y = 0; y < truth.grid().count(1); ++y)
      for (std::size_t x = 0; x < truth.grid().count(0); ++x)
        CHECK(std::abs(array.at(x, y, z) - truth.at(x, y, z)) < 0.01f);  // of 0.05; the lines again
  CHECK(array.grid().bounds_m[0].front() == 0.0);
}

TEST_CASE("volume files: arrays of bytes and of halves, scaled") {
  const TempDirectory dir;
  NpyArray bytes{ElementType::uint8, {2, 3, 4}, {}};
  for (int i = 0; i < 24; ++i) bytes.data.push_back(static_cast<std::byte>(i));
  REQUIRE(write_npy(dir / "b.npy", bytes));
  const MemoryVolume volume = opened(dir / "b.npy", {.voxel_m = glm::dvec3(10.0, 20.0, 30.0), .scale_per_m = 0.01});
  CHECK(volume.grid().bounds_m[2].back() == 120.0);
  for (std::size_t x = 0; x < 2; ++x)
    for (std::size_t y = 0; y < 3; ++y)
      for (std::size_t z = 0; z < 4; ++z)
        CHECK(std::abs(volume.at(x, y, z) - 0.01f * static_cast<float>((x * 3 + y) * 4 + z)) < 1e-7f);
  NpyArray halves{ElementType::float16, {1, 1, 2}, {}};
  for (const int byte : {0x00, 0x3c, 0x00, 0x40}) halves.data.push_back(static_cast<std::byte>(byte));  // 1, 2
  REQUIRE(write_npy(dir / "h.npy", halves));
  const MemoryVolume half = opened(dir / "h.npy", {.voxel_m = glm::dvec3(10.0)});
  CHECK(half.at(0, 0, 0) == 1.0f);
  CHECK(half.at(0, 0, 1) == 2.0f);
}

TEST_CASE("volume files: a strip of slices is read as FlightGear keeps its clouds: blue is density") {
  const TempDirectory dir;
  std::vector<std::uint8_t> rgba(4 * 6 * 2, 0);  // three slices of 2 x 2
  for (std::size_t i = 0; i < 12; ++i) rgba[4 * i + 2] = static_cast<std::uint8_t>(20 * i);
  REQUIRE(write_png(dir / "strip.png", 6, 2, rgba));
  const MemoryVolume volume = opened(dir / "strip.png", {.voxel_m = glm::dvec3(10.0), .scale_per_m = 0.255});
  REQUIRE(volume.grid().count(2) == 3);
  CHECK(std::abs(volume.at(0, 1, 0) - 0.0f) < 1e-6f);   // the upper row is the northern one
  CHECK(std::abs(volume.at(1, 1, 2) - 0.1f) < 1e-6f);   // column 5
  CHECK(std::abs(volume.at(0, 0, 1) - 0.16f) < 1e-6f);  // row 1, column 2
  CHECK(contains(complaint(dir / "strip.png"), "--voxel-m is missing"));
}

TEST_CASE("volume files: what is wrong is told by name") {
  const TempDirectory dir;
  write_all_formats(dir);
  CHECK(contains(complaint(dir / "absent.npy"), "absent.npy: there is no such file"));
  CHECK(contains(complaint(dir / "v.npy"), "--voxel-m is missing"));
  test::write_file(dir / "v.txt", "words");
  CHECK(contains(complaint(dir / "v.txt"), "not a volume; accepted: .npy"));
  CHECK(contains(complaint(dir / "v.vdb", {.grid = "colour"}),
                 "--grid is \"colour\"; it has no such grid of numbers, but \"density\""));
  CHECK(contains(complaint(dir / "v.nc", {.variable = "rain"}), "rain"));
  CHECK(contains(complaint(dir / "v.nc", {.time = 3}), "--time is 3; accepted: a whole number from 0 to 0"));
  CHECK(contains(complaint(dir / "v.npy", {.voxel_m = glm::dvec3(1.0), .grid = "x"}),
                 "--grid is accepted for .vdb alone"));
  std::filesystem::copy_file(dir / "v.nc", dir / "not.vdb");
  CHECK(contains(complaint(dir / "not.vdb"), "not.vdb: not an OpenVDB file"));
  std::filesystem::copy_file(dir / "v.vdb", dir / "not.nc");
  CHECK(contains(complaint(dir / "not.nc"), "not.nc: not a NetCDF file"));
  std::filesystem::remove(std::filesystem::path(dir / "slices") / "slice_0003.png");
  CHECK(contains(complaint(dir / "slices"), "numbered without a gap"));
}

TEST_CASE("volume files: a library that crashes, hangs or takes all memory makes one line of it") {
  const TempDirectory dir;
  test::write_file(dir / "x.vdb", "x");
  using Opened = Result<std::unique_ptr<VolumeReader>>;
  const auto told = [&](const std::function<Opened()>& open) {
    const Opened reader = open_in_child(dir / "x.vdb", open, {.seconds = 0.3});
    return reader ? std::string("accepted") : reader.error().message;
  };
  CHECK(contains(told([]() -> Opened {
                   std::raise(SIGKILL);
                   return Error{""};
                 }),
                 "failed without a word; it is damaged"));
  CHECK(contains(told([]() -> Opened {
                   for (;;) std::raise(0);
                 }),
                 "longer than 0.3 s"));
  CHECK(contains(told([]() -> Opened { throw std::bad_alloc(); }), "more memory than its size explains"));
  CHECK(contains(told([]() -> Opened { throw std::runtime_error("no good"); }), "no good"));
}

TEST_CASE("volume files: cut at any length they are refused by name") {
  const TempDirectory dir;
  ParticleGrid by_x = small_grid({2, 1, 0}, 150.0), by_z = small_grid({0, 1, 2}, 150.0);
  REQUIRE(write_npy_volume(dir / "v.npy", by_x));
  REQUIRE(write_vdb_volume(dir / "v.vdb", by_x));
  REQUIRE(write_netcdf_volume(dir / "v.nc", by_z));
  for (const char* name : {"v.npy", "v.vdb", "v.nc"}) {
    const std::string path = dir / name, whole = test::read_file(path);
    // Every length of a short file; of a longer one those near its ends and a hundred between.
    const std::size_t step = std::max<std::size_t>(1, whole.size() / 100);
    for (std::size_t n = 0; n < whole.size(); n += n < 400 || n + 32 > whole.size() ? 1 : step) {
      test::write_file(path, whole.substr(0, n));
      check_damaged(path, static_cast<int>(n), false);
    }
    // The library's file formats may do without their last bytes; an array may not.
    if (std::string(name) == "v.npy") CHECK(contains(complaint(path, {.voxel_m = glm::dvec3(1.0)}), "bytes"));
  }
}

TEST_CASE("volume files: changed bytes never end the program") {
  const TempDirectory dir;
  write_all_formats(dir);
  for (const char* name : {"v.npy", "v.vdb", "v.nc"}) mutate(dir / name, 500);
}

TEST_CASE("volume files: changed bytes never end the program, at length" * doctest::skip()) {
  const TempDirectory dir;
  write_all_formats(dir);
  for (const char* name : {"v.npy", "v.vdb", "v.nc"}) mutate(dir / name, 10000);
}
