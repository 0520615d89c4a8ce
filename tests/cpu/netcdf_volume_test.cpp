// NetCDF files as models of the weather write them: axes in any order, levels that are not even, water in any unit.
#include <doctest/doctest.h>
#include <netcdf.h>

#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/support.h"
#include "tools/clouds/open_volume.h"

using namespace nephele;
using namespace nephele::clouds;
using nephele::test::TempDirectory;

namespace {

struct Variable {
  const char* name;
  std::vector<const char*> axes;
  std::vector<double> values;
  std::vector<std::pair<const char*, const char*>> texts;
  std::vector<std::pair<const char*, double>> numbers;
};

void write(const std::string& path, const std::vector<std::pair<const char*, std::size_t>>& axes,
           const std::vector<Variable>& variables) {
  int file = -1;
  REQUIRE(nc_create(path.c_str(), NC_CLOBBER, &file) == NC_NOERR);
  for (const auto& [name, length] : axes) {
    int id = -1;
    REQUIRE(nc_def_dim(file, name, length, &id) == NC_NOERR);
  }
  std::vector<int> ids;
  for (const Variable& variable : variables) {
    std::vector<int> dimensions;
    for (const char* axis : variable.axes) REQUIRE(nc_inq_dimid(file, axis, &dimensions.emplace_back()) == NC_NOERR);
    REQUIRE(nc_def_var(file, variable.name, NC_FLOAT, static_cast<int>(dimensions.size()), dimensions.data(),
                       &ids.emplace_back()) == NC_NOERR);
    for (const auto& [name, text] : variable.texts)
      REQUIRE(nc_put_att_text(file, ids.back(), name, std::strlen(text), text) == NC_NOERR);
    for (const auto& [name, number] : variable.numbers)
      REQUIRE(nc_put_att_double(file, ids.back(), name, NC_FLOAT, 1, &number) == NC_NOERR);
  }
  REQUIRE(nc_enddef(file) == NC_NOERR);
  for (std::size_t i = 0; i < variables.size(); ++i)
    REQUIRE(nc_put_var_double(file, ids[i], variables[i].values.data()) == NC_NOERR);
  REQUIRE(nc_close(file) == NC_NOERR);
}

struct Opened {
  MemoryVolume volume;
  std::vector<std::string> assumptions;
  std::vector<double> times_s;
};

Opened opened(const std::string& path, const VolumeOptions& options = {}) {
  Result<std::unique_ptr<VolumeReader>> reader = open_volume(path, options);
  if (!reader) FAIL(reader.error().message);
  Result<MemoryVolume> volume = load_volume(**reader, 1u << 20);
  if (!volume) FAIL(volume.error().message);
  return {std::move(*volume), (*reader)->assumptions(), (*reader)->times_s()};
}

// 1.5 rho q / (1000 kg/m3 * 10 um)
constexpr double kPerDensity = 150.0;

bool near(float value, double expected) {
  return std::abs(static_cast<double>(value) - expected) < 1e-5 * std::abs(expected);
}

const std::vector<double> kX{0.0, 0.1, 0.2};               // km
const std::vector<double> kFallingZ{900.0, 300.0, 100.0};  // m, stretched

// q at (x, y, z) voxels is 1 + x + 10 y + 100 z, with z counted from below.
double water(std::size_t x, std::size_t y, std::size_t z) { return 1.0 + static_cast<double>(x + 10 * y + 100 * z); }

}  // namespace

TEST_CASE("netcdf: axes in another order, falling and stretched levels, packed g/kg with holes, density by level") {
  const TempDirectory dir;
  std::vector<double> packed;
  for (std::size_t time = 0; time < 2; ++time)  // (time, x, z falling, y), value = q / 2 - 5, doubled at time 1
    for (std::size_t x = 0; x < 3; ++x)
      for (std::size_t z = 3; z-- > 0;)
        for (std::size_t y = 0; y < 2; ++y)
          packed.push_back(0.5 * water(x, y, z) * static_cast<double>(time + 1) - 5.0);
  packed[0] = -99.0;  // (0, 0, 2) at time 0
  write(dir / "v.nc", {{"time", 2}, {"x", 3}, {"height", 3}, {"north", 2}},
        {{"time", {"time"}, {5.0, 6.5}, {{"units", "minutes since 2000-01-01"}}, {}},
         {"x", {"x"}, kX, {{"units", "km"}}, {}},
         {"height", {"height"}, kFallingZ, {{"units", "m"}, {"positive", "up"}}, {}},
         {"north", {"north"}, {50.0, 150.0}, {{"units", "m"}}, {}},
         {"rho", {"height"}, {0.8, 1.0, 1.2}, {{"units", "kg/m3"}}, {}},
         {"ql",
          {"time", "x", "height", "north"},
          packed,
          {{"units", "g/kg"}},
          {{"scale_factor", 2.0}, {"add_offset", 10.0}, {"_FillValue", -99.0}}}});
  const Opened first = opened(dir / "v.nc"), second = opened(dir / "v.nc", {.time = 1});
  CHECK(first.assumptions.empty());
  CHECK(first.times_s == std::vector<double>{0.0, 90.0});
  const VolumeGrid& grid = first.volume.grid();
  const std::array<double, 4> levels{0.0, 200.0, 600.0, 1200.0}, x_bounds{-50.0, 50.0, 150.0, 250.0};
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(std::abs(grid.bounds_m[2][i] - levels[i]) < 1e-3);
    CHECK(std::abs(grid.bounds_m[0][i] - x_bounds[i]) < 1e-3);
  }
  const std::array<double, 3> rho{1.2, 1.0, 0.8};
  for (std::size_t x = 0; x < 3; ++x)
    for (std::size_t y = 0; y < 2; ++y)
      for (std::size_t z = 0; z < 3; ++z) {
        const double extinction = kPerDensity * rho[z] * 1e-3 * water(x, y, z);
        CHECK(near(second.volume.at(x, y, z), 2.0 * extinction));
        if (x == 0 && y == 0 && z == 2)
          CHECK(first.volume.at(x, y, z) == 0.0f);  // a hole is clear air
        else
          CHECK(near(first.volume.at(x, y, z), extinction));
      }
}

TEST_CASE("netcdf: density from pressure and temperature, or the standard atmosphere's, which is said") {
  const TempDirectory dir;
  const std::vector<std::pair<const char*, std::size_t>> axes{{"z", 2}, {"y", 2}, {"x", 2}};
  const std::vector<double> at{0.0, 1000.0};
  std::vector<Variable> variables{{"x", {"x"}, at, {{"units", "m"}}, {}},
                                  {"y", {"y"}, at, {{"units", "m"}}, {}},
                                  {"z", {"z"}, at, {{"units", "m"}}, {}},
                                  {"QN", {"z", "y", "x"}, std::vector<double>(8, 1e-3), {{"units", "kg kg-1"}}, {}}};
  write(dir / "standard.nc", axes, variables);
  const Opened standard = opened(dir / "standard.nc");
  REQUIRE(standard.assumptions.size() == 1);
  CHECK(standard.assumptions[0].find("standard atmosphere") != std::string::npos);
  // Of the table of 1976, at 1000 m: 1.1117 kg/m3.
  CHECK(std::abs(static_cast<double>(standard.volume.at(0, 0, 1)) / (kPerDensity * 1e-3 * 1.1117) - 1.0) < 1e-3);
  variables.push_back({"p", {"z"}, {1000.0, 900.0}, {{"units", "hPa"}}, {}});
  variables.push_back({"TABS", {"z", "y", "x"}, std::vector<double>(8, 280.0), {{"units", "K"}}, {}});
  write(dir / "own.nc", axes, variables);
  const Opened own = opened(dir / "own.nc", {.effective_radius_m = 5e-6});
  CHECK(own.assumptions.empty());
  CHECK(near(own.volume.at(1, 0, 1), 2.0 * kPerDensity * 1e-3 * 90000.0 / (287.05 * 280.0)));
}

TEST_CASE("netcdf: what cannot be placed or converted is told by name") {
  const TempDirectory dir;
  const auto complaint = [&](const std::vector<Variable>& variables) {
    write(dir / "v.nc", {{"z", 2}, {"y", 2}, {"x", 2}}, variables);
    const auto reader = open_volume(dir / "v.nc", {});
    return reader ? std::string("accepted") : reader.error().message;
  };
  const auto contains = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  const std::vector<double> at{0.0, 100.0}, q(8, 1e-3);
  const Variable x{"x", {"x"}, at, {{"units", "m"}}, {}}, y{"y", {"y"}, at, {{"units", "m"}}, {}};
  const Variable z{"z", {"z"}, at, {{"units", "m"}}, {}}, pascal{"z", {"z"}, at, {{"units", "hPa"}}, {}};
  const Variable water{"ql", {"z", "y", "x"}, q, {{"units", "kg/kg"}}, {}};
  CHECK(complaint({x, y, z, water}) == "accepted");
  CHECK(contains(complaint({x, y, pascal, water}), "coordinate \"z\" is in \"hpa\"; accepted: m or km"));
  CHECK(contains(complaint({x, y, water}), "\"z\" has no coordinates; --voxel-m must say"));
  CHECK(
      contains(complaint({x, y, z, {"ql", {"z", "y", "x"}, q, {{"units", "K"}}, {}}}), "variable \"ql\" is in \"k\""));
  CHECK(contains(complaint({x, y, z, {"speed", {"z", "y", "x"}, q, {}, {}}}), "it has x, y, z, speed"));
  CHECK(contains(complaint({x, y, {"z", {"z"}, {5.0, 5.0}, {{"units", "m"}}, {}}, water}), "neither rises nor falls"));
  CHECK(contains(complaint({x, y, z, {"ql", {"y", "x", "y"}, q, {}, {}}}), "are the same of x, y, z and time"));
}
