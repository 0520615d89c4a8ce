// nephele probe and bake --verify as a user runs them: values against oracles, rows kept as typed, faults named.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "lut/cpu_fetch.h"
#include "lut/oracles.h"
#include "shared/phase.h"
#include "tests/support/test_tables.h"
#include "tests/tool/program.h"

using namespace nephele;
using namespace nephele::test;
using glm::dvec3;

namespace {

const std::string kHeader = "entry_x,entry_y,entry_z,dir_x,dir_y,dir_z,light_x,light_y,light_z,optical_radius";

struct Ray {
  dvec3 entry, dir, light;
  double optical_radius;
};

dvec3 on_sphere(UniformNumbers& uniform) {
  const double z = 2 * uniform() - 1, phi = 2 * std::acos(-1.0) * uniform(), s = std::sqrt(1 - z * z);
  return {s * std::cos(phi), s * std::sin(phi), z};
}

std::vector<Ray> random_rays(int count) {
  UniformNumbers uniform(3);
  std::vector<Ray> rays;
  for (int i = 0; i < count; ++i) {
    Ray ray{on_sphere(uniform), on_sphere(uniform), on_sphere(uniform), 0.05 * std::pow(1000.0, uniform())};
    if (dot(ray.entry, ray.dir) > 0) ray.dir = -ray.dir;
    rays.push_back(ray);
  }
  return rays;
}

std::string ray_line(const Ray& ray) {
  std::string line;
  char number[32];
  for (const dvec3& v : {ray.entry, ray.dir, ray.light})
    for (int k = 0; k < 3; ++k) {
      std::snprintf(number, sizeof number, "%.9f,", v[k]);
      line += number;
    }
  std::snprintf(number, sizeof number, "%.9g", ray.optical_radius);
  return line + number;
}

std::vector<std::string> probe(const std::string& table, const std::string& in, const std::string& out) {
  return {"probe", "--table", table, "--rays", in, "--out", out, "--tables", small_tables()};
}

std::vector<std::string> lines_of(const std::string& path) {
  std::istringstream text(read_file(path));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

double last_number(const std::string& line) { return std::stod(line.substr(line.rfind(',') + 1)); }

}  // namespace

TEST_CASE("probe: single scattering is quadrature times the phase function, every row kept as typed") {
  const TempDirectory directory;
  const std::vector<Ray> rays = random_rays(500);
  std::string text = kHeader + "\n";
  for (const Ray& ray : rays) text += ray_line(ray) + "\n";
  write_file(directory / "in.csv", text);
  const ProgramResult result = run_program(probe("single", directory / "in.csv", directory / "out.csv"));
  REQUIRE_MESSAGE(result.status == 0, result.err);
  CHECK(result.err.empty());
  const std::vector<std::string> lines = lines_of(directory / "out.csv");
  REQUIRE(lines.size() == rays.size() + 1);
  CHECK(lines[0] == kHeader + ",value");
  double error2 = 0, value2 = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Ray& ray = rays[i];
    CHECK(lines[i + 1].starts_with(ray_line(ray) + ","));
    const SphereRay cosines{dot(ray.entry, ray.light), -dot(ray.entry, ray.dir), -dot(ray.dir, ray.light)};
    const double truth = exact_phase_per_sr(shared::kPhaseHenyeyGreenstein, cosines.mu, 0.85) *
                         exact_single_scattering(cosines, ray.optical_radius);
    error2 += std::pow(last_number(lines[i + 1]) - truth, 2);
    value2 += truth * truth;
  }
  CHECK(std::sqrt(error2 / value2) < 0.01);
}

TEST_CASE("probe: multiple scattering and optical depth are in range; columns in any order, more are carried along") {
  const TempDirectory directory;
  std::string text = "name,optical_radius,dir_x,dir_y,dir_z,entry_x,entry_y,entry_z,light_x,light_y,light_z\r\n";
  text += "core,4,0,0,-1,0,0,1,0,0,-1\r\n\r\ngraze,4,1,0,0,0,0,1,0.6,0.8,0\r\nempty,0,0,0,-1,0,0,1,1,0,0";
  write_file(directory / "in.csv", text);
  REQUIRE(run_program(probe("multiple", directory / "in.csv", directory / "multiple.csv")).status == 0);
  const std::vector<std::string> multiple = lines_of(directory / "multiple.csv");
  REQUIRE(multiple.size() == 4);
  CHECK(multiple[0].starts_with("name,"));
  CHECK(multiple[1].starts_with("core,4,0,0,-1,"));
  CHECK(last_number(multiple[1]) > 0.01);
  CHECK(last_number(multiple[1]) < 1.0);
  CHECK(last_number(multiple[2]) == 0.0);  // no chord
  CHECK(last_number(multiple[3]) == 0.0);  // no density

  REQUIRE(run_program(probe("optical_depth", directory / "in.csv", directory / "depth.csv")).status == 0);
  const std::vector<std::string> depth = lines_of(directory / "depth.csv");
  REQUIRE(depth.size() == 4);
  CHECK(depth[0].ends_with(",value,first_matter"));
  const std::string& core = depth[1];
  const double mean = std::stod(core.substr(std::string("core,4,0,0,-1,0,0,1,0,0,-1,").size()));
  // Four vertices a side are too few for the particle itself: the truth is the table, filtered on the CPU. Devices may
  // filter with 8 bits.
  const Result<Tables> tables = load_tables(small_tables());
  REQUIRE(tables);
  const float fetched = fetch_optical_depth(FloatTexture(tables->optical_depth), {0, 0, 1}, {0, 0, -1}).x;
  CHECK(fetched > 0.1f);
  CHECK(mean == doctest::Approx(fetched).scale(1).epsilon(0.006));
  CHECK(last_number(core) >= 0.0);
  CHECK(last_number(core) < 0.6);

  write_file(directory / "none.csv", "\xef\xbb\xbf" + kHeader + "\n");  // with a byte order mark, as spreadsheets write
  REQUIRE(run_program(probe("single", directory / "none.csv", directory / "none_out.csv")).status == 0);
  CHECK(read_file(directory / "none_out.csv") == kHeader + ",value\n");
}

TEST_CASE("probe: optical depth of the default tables against quadrature of the particle's density") {
  const TempDirectory directory;
  const std::uint32_t seed = test_tables().parameters.particle_seed;  // bakes them if need be
  const std::vector<Ray> rays = random_rays(500);
  std::string text = kHeader + "\n";
  for (const Ray& ray : rays) text += ray_line(ray) + "\n";
  write_file(directory / "in.csv", text);
  REQUIRE(
      run_program({"probe", "--table", "optical_depth", "--rays", directory / "in.csv", "--out", directory / "out.csv"})
          .status == 0);
  const std::vector<std::string> lines = lines_of(directory / "out.csv");
  REQUIRE(lines.size() == rays.size() + 1);
  double error2 = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const double half_chord = -dot(rays[i].entry, rays[i].dir);
    const double mean = std::stod(lines[i + 1].substr(ray_line(rays[i]).size() + 1));
    const double truth = exact_mean_density(shared::vec3(rays[i].entry),
                                            shared::vec3(rays[i].entry + 2 * half_chord * rays[i].dir), seed);
    error2 += std::pow(std::exp(-16 * half_chord * mean) - std::exp(-16 * half_chord * truth), 2);
  }
  // 0.0036 over 20 000 rays by the CPU's filter (docs/tables.md); 500 rays and a device's filter may add half of it.
  CHECK(std::sqrt(error2 / double(rays.size())) < 0.0054);
}

TEST_CASE("probe: rays beyond one batch come back in order") {
  const TempDirectory directory;
  const std::vector<Ray> rays = random_rays(1000);
  std::string text = kHeader + "\n";
  for (int i = 0; i < 140000; ++i) text += ray_line(rays[i % 1000]) + "\n";
  write_file(directory / "in.csv", text);
  REQUIRE(run_program(probe("multiple", directory / "in.csv", directory / "out.csv")).status == 0);
  const std::vector<std::string> lines = lines_of(directory / "out.csv");
  REQUIRE(lines.size() == 140001);
  int different = 0;
  for (std::size_t i = 1001; i < lines.size(); ++i) different += lines[i] != lines[i - 1000];
  CHECK(different == 0);
}

TEST_CASE("probe: bad input names file, line, column and what is accepted, and leaves nothing behind") {
  const TempDirectory directory;
  const std::string in = directory / "in.csv", out = directory / "out.csv";
  const auto refuse = [&](const std::vector<std::string>& arguments, const std::vector<std::string>& mentions) {
    const ProgramResult result = run_program(arguments);
    CAPTURE(result.err);
    CHECK(result.status == 2);
    CHECK(result.out.empty());
    CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
    for (const std::string& mention : mentions) CHECK_MESSAGE(result.err.find(mention) != std::string::npos, mention);
  };
  const auto refuse_text = [&](const std::string& text, std::vector<std::string> mentions) {
    write_file(in, text);
    mentions.push_back(in);
    refuse(probe("single", in, out), mentions);
  };
  const std::string good = "0,0,1,0,0,-1,1,0,0,2\n";
  refuse(probe("single", directory / "none.csv", out), {directory / "none.csv"});
  refuse_text("", {"line 1", "entry_x"});
  refuse_text("entry_x,entry_y\n", {"line 1", "entry_z"});
  refuse_text(kHeader + ",dir_x\n" + good, {"line 1", "dir_x", "twice"});
  refuse_text(kHeader + "\n" + good + "0,0,1\n", {"line 3", "3 values", "10"});
  refuse_text(kHeader + "\n" + good + good + "0,0,1,0,x,-1,1,0,0,2\n", {"line 4", "dir_y", "\"x\"", "-1.001 to 1.001"});
  for (const char* radius : {"-1", "nan", "inf", "1e5", "", "2 m"})
    refuse_text(kHeader + "\n0,0,1,0,0,-1,1,0,0," + radius + "\n", {"line 2", "optical_radius", radius, "0 to 10000"});
  write_file(in, kHeader + "\n0,0,1,0,0,-1,1,0,0,201\n");
  refuse(probe("multiple", in, out), {"line 2", "optical_radius", "201", "0 to 200"});
  refuse_text(kHeader + "\n0,0,0.5,0,0,-1,1,0,0,2\n", {"line 2", "entry_x", "0.999 to 1.001"});
  refuse_text(kHeader + "\n0,0,1,0,0,-1,0,0,0,2\n", {"line 2", "light_x", "0.999 to 1.001"});
  refuse_text(kHeader + "\n0,0,1,0,0,1,1,0,0,2\n", {"line 2", "dir_x", "out of the sphere"});

  write_file(in, kHeader + "\n" + good);
  refuse({"probe", "--rays", in, "--out", out}, {"--table"});
  refuse({"probe", "--table", "triple", "--rays", in, "--out", out}, {"--table", "triple", "optical_depth"});
  refuse({"probe", "--table", "single", "--rays", in, "--out", out, "--g", "1"}, {"--g", "0.95"});
  refuse(probe("single", in, directory / "none/out.csv"), {directory / "none/out.csv"});
  auto other_g = probe("multiple", in, out);
  other_g.insert(other_g.end(), {"--g", "0.3"});
  refuse(other_g, {"--g", "0.3", "0.85"});
  auto other_phase = probe("multiple", in, out);
  other_phase.insert(other_phase.end(), {"--phase", "cs"});
  refuse(other_phase, {"--phase", "cs"});
  CHECK(directory.entries() == std::vector<std::string>{"in.csv"});
}
