// The paper's 4D tables: their axes, what they hold against independent truth, and the device against the CPU. Not part
// of the suite: what their look-ups cost beside ours, the table in docs/tables.md.
//   test_gpu --no-skip --test-case="table cost study"
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "engine/frame.h"
#include "lut/gpu_tables.h"
#include "lut/oracles.h"
#include "lut/packed_optical_depth.h"
#include "lut/study/paper_tables.h"
#include "nephele_test_shaders.h"
#include "shared/paper_axes.h"
#include "shared/phase.h"
#include "tests/support/support.h"
#include "tests/support/test_device.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using shared::vec3;
using shared::vec4;

namespace {

struct Query {
  vec3 entry, exit, light;
  float sigma;
};

vec3 random_direction(UniformNumbers& uniform) {
  const double z = 2 * uniform() - 1, phi = 2 * std::acos(-1.0) * uniform(), s = std::sqrt(1 - z * z);
  return {s * std::cos(phi), s * std::sin(phi), z};
}

// Impact uniform in area, light from anywhere, optical radius log-uniform.
std::vector<Query> random_queries(std::size_t count, double low, double high) {
  UniformNumbers uniform(29);
  std::vector<Query> queries;
  while (queries.size() < count) {
    const vec3 along = random_direction(uniform), side = normalize(cross(along, random_direction(uniform)));
    const float b = static_cast<float>(std::sqrt(uniform())), h = std::sqrt(1 - b * b);
    queries.push_back({normalize(b * side - h * along), normalize(b * side + h * along), random_direction(uniform),
                       static_cast<float>(low * std::pow(high / low, uniform()))});
  }
  return queries;
}

// As the shader forms them.
SphereRay variables_of(const Query& q) {
  const glm::dvec3 entry(q.entry), exit(q.exit), light(q.light);
  const double span = length(exit - entry);
  return {dot(entry, light), span / 2, dot(entry - exit, light) / span};
}

// One look-up of everything with study_tables.comp: `what` as it counts them.
class Lookup {
 public:
  Lookup(std::uint32_t what, const Image& depth, const Image& single, const Image& multiple)
      : kernel_(test::test_device(), shaders::study_tables_comp, std::array{SpecConstant{0, what}}),
        depth_{2, depth, Access::sampled},
        single_(single),
        multiple_(multiple) {}
  Lookup(std::uint32_t what, const Buffer& packed_depth, std::uint32_t vertices, const Image& single,
         const Image& multiple)
      : kernel_(test::test_device(), shaders::study_tables_comp_packed,
                std::array{SpecConstant{0, what}, SpecConstant{10, vertices}}),
        depth_{2, packed_depth, Access::words},
        single_(single),
        multiple_(multiple) {}

  // Milliseconds.
  double run(FrameExecutor& executor, const Buffer& in, const Buffer& out, std::uint32_t count, float g,
             const PaperParameters& paper) const {
    const struct {
      std::uint32_t count;
      float g;
      vec4 depth_size, scattering_size;
    } push{count, g, as_vector(paper.optical_depth_size), as_vector(paper.scattering_size)};
    FrameBuilder frame(test::test_device());
    frame.compute({.name = "study",
                   .kernel = &kernel_,
                   .bindings = {{0, in, Access::storage_read},
                                {1, out, Access::storage_write},
                                depth_,
                                {3, single_, Access::sampled},
                                {4, multiple_, Access::sampled}},
                   .push = as_push(push),
                   .groups = {(count + 63) / 64, 1, 1},
                   .indirect = {}});
    executor.run(frame);
    return executor.pass_times().front().gpu_ms;
  }

 private:
  ComputeKernel kernel_;
  Binding depth_;
  const Image &single_, &multiple_;
};

}  // namespace

TEST_CASE("the paper's axes lead back to the chord they came from") {
  for (const Query& q : random_queries(2000, 1, 1)) {
    vec3 entry, exit;
    shared::paper_chord_from_axes(shared::paper_chord_axes(q.entry, q.exit), entry, exit);
    // Arc cosines in floats lose half the digits near the poles and for chords through the center.
    CHECK(length(entry - q.entry) < 2e-3f);
    CHECK(length(exit - q.exit) < 4e-3f);
  }
  CHECK(shared::paper_optical_radius_from_axis(shared::paper_scattering_axes(0, 0.5f, 0, 5.0f).w) ==
        doctest::Approx(5.0f).epsilon(1e-4));
}

TEST_CASE("small tables of the paper: fetched alike on both sides, right at the vertices, read back from disk") {
  PaperParameters parameters;
  parameters.optical_depth_size = {8, 5, 8, 5};
  parameters.scattering_size = {9, 12, 5, 3};
  PaperTables tables = bake_paper_tables(parameters);
  const test::TempDirectory directory;
  REQUIRE(save_paper_tables(directory / "paper", tables));
  const Result<PaperTables> loaded = load_paper_tables(directory / "paper");
  if (!loaded) FAIL(loaded.error().message);
  CHECK(loaded->multiple_scattering.array.data == tables.multiple_scattering.array.data);
  CHECK(loaded->parameters.scattering_size == parameters.scattering_size);

  const FloatTexture depth(tables.optical_depth), single(tables.single_scattering),
      multiple(tables.multiple_scattering);
  const vec4 depth_size = as_vector(parameters.optical_depth_size), size = as_vector(parameters.scattering_size);
  // A vertex in the middle of every axis: theta = pi/2 (c = 0), phi = 4/11 turn, zenith pi/4, sigma = 12.88 / sqrt(2).
  const double sigma = shared::paper_optical_radius_from_axis(0.5f), h = std::sqrt(0.5);
  const SphereRay ray{0, h, h * std::cos(2 * std::acos(-1.0) * 4 / 11)};
  const vec4 at = shared::paper_scattering_axes(0, float(h), float(ray.mu), float(sigma));
  CHECK(fetch_paper(single, at, size).x == doctest::Approx(exact_single_scattering(ray, sigma)).epsilon(2e-3));

  Device& device = test::test_device();
  const Image depth_image = upload_table(device, tables.optical_depth, VK_FORMAT_R8G8_UNORM),
              single_image = upload_table(device, tables.single_scattering, VK_FORMAT_R16_SFLOAT),
              multiple_image = upload_table(device, tables.multiple_scattering, VK_FORMAT_R16_SFLOAT);
  const std::vector<Query> queries = random_queries(4096, 0.1, 200);
  Buffer in(device, "queries", queries.size() * sizeof(Query)), out(device, "answers", queries.size() * sizeof(vec3));
  in.write_vector(queries);
  FrameExecutor executor(device);
  const auto count = static_cast<std::uint32_t>(queries.size());
  const auto ask = [&](std::uint32_t what) {
    Lookup(what, depth_image, single_image, multiple_image).run(executor, in, out, count, 0.7f, parameters);
    return out.read_vector<vec3>(count);
  };
  const std::vector<vec3> chords = ask(3), spheres = ask(5);
  float worst = 0;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const Query& q = queries[i];
    const SphereRay r = variables_of(q);
    const vec4 axes = shared::paper_scattering_axes(float(r.c), float(r.h), float(r.mu), q.sigma);
    worst = std::max(
        {worst, std::abs(chords[i].x - fetch_paper(depth, shared::paper_chord_axes(q.entry, q.exit), depth_size).x),
         std::abs(spheres[i].y - fetch_paper(single, axes, size).x),
         std::abs(spheres[i].z - fetch_paper(multiple, axes, size).x)});
  }
  // Filtering weights may have 8 bits: 1/256 of a step between texels of at most 1, along each of four axes.
  CHECK(worst < 0.016f);
}

TEST_CASE("orders 2 to 18 of the solver carry the power that Monte Carlo finds in them") {
  for (const double sigma : {0.8, 12.9}) {
    CAPTURE(sigma);
    const SphereProblem problem{shared::kPhaseHenyeyGreenstein, 0.7, sigma, 0.9};
    const SphereSolution orders = sum_orders(problem, sphere_grid(sigma, false), 18);
    const double power = exit_power(64, [&](const SphereRay& ray) {
      return orders.chord_source(ray.c, ray.h, shared::azimuth_cosine(float(ray.c), float(ray.h), float(ray.mu))) *
             -std::expm1(-2 * sigma * ray.h);
    });
    const Estimate truth = monte_carlo_orders(problem, 0.9, 100000, 7).between(2, 18);
    // The solver's own energy is good to half a percent.
    CHECK(std::abs(power - truth.mean) < 0.005 + 4 * truth.standard_error);
  }
}

TEST_CASE("table cost study" * doctest::skip()) {
  Device& device = test::test_device();
  const Tables& ours = test::test_tables();
  const PaperTables paper = bake_paper_tables({});
  const Image paper_depth = upload_table(device, paper.optical_depth, VK_FORMAT_R8G8_UNORM),
              paper_single = upload_table(device, paper.single_scattering, VK_FORMAT_R16_SFLOAT),
              paper_multiple = upload_table(device, paper.multiple_scattering, VK_FORMAT_R16_SFLOAT);
  const GpuTables textures(device, ours);
  // The same optical depth in bytes.
  Table bytes = ours.optical_depth;
  bytes.array.type = ElementType::uint8;
  bytes.array.data.resize(bytes.array.count());
  for (std::size_t i = 0; i < bytes.array.count(); ++i) {
    std::uint16_t half = 0;
    std::memcpy(&half, &ours.optical_depth.array.data[2 * i], 2);
    bytes.array.data[i] = static_cast<std::byte>(std::lround(255 * glm::unpackHalf2x16(half).x));
  }
  const std::vector<std::uint32_t> words = pack_optical_depth(ours.optical_depth);
  Buffer packed(device, "packed_optical_depth", words.size() * sizeof(std::uint32_t));
  packed.write_vector(words);
  const auto of_packed = [&](std::uint32_t what) {
    return Lookup(what, packed, ours.optical_depth.width(), paper_single, textures.multiple_scattering());
  };
  const Image byte_depth = upload_table(device, bytes, VK_FORMAT_R8G8_UNORM);

  struct Row {
    const char* name;
    Lookup lookup;
    std::vector<double> ms;
  };
  const auto of_paper = [&](std::uint32_t what) { return Lookup(what, paper_depth, paper_single, paper_multiple); };
  const auto of_ours = [&](std::uint32_t what, const Image& depth) {
    return Lookup(what, depth, paper_single, textures.multiple_scattering());
  };
  std::vector<Row> rows;
  rows.push_back({"nothing (rays in, values out)", of_ours(0, textures.optical_depth()), {}});
  rows.push_back({"paper: all three 4D fetches", of_paper(1), {}});
  rows.push_back({"ours: all three", of_ours(2, textures.optical_depth()), {}});
  rows.push_back({"ours: all three, optical depth packed", of_packed(2), {}});
  rows.push_back({"paper: optical depth, RG8", of_paper(3), {}});
  rows.push_back({"ours: optical depth, RG16F", of_ours(4, textures.optical_depth()), {}});
  rows.push_back({"ours: optical depth, RG8 copy", of_ours(4, byte_depth), {}});
  rows.push_back({"ours: optical depth, packed", of_packed(4), {}});
  rows.push_back({"paper: single and multiple scattering", of_paper(5), {}});
  rows.push_back({"ours: single scattering, formula", of_ours(6, textures.optical_depth()), {}});
  rows.push_back({"ours: multiple scattering, one fetch", of_ours(7, textures.optical_depth()), {}});

  constexpr std::uint32_t kCount = 1u << 18;
  constexpr int kRounds = 15;
  const std::vector<Query> queries = random_queries(kCount, 0.8, 100);
  Buffer in(device, "queries", kCount * sizeof(Query)), out(device, "answers", kCount * sizeof(vec3));
  in.write_vector(queries);
  FrameExecutor executor(device);
  for (int round = -1; round < kRounds; ++round)  // the first one compiles
    for (Row& row : rows) {
      const double ms = row.lookup.run(executor, in, out, kCount, float(ours.parameters.g_multiple), paper.parameters);
      if (round >= 0) row.ms.push_back(ms);
    }
  for (Row& row : rows) std::sort(row.ms.begin(), row.ms.end());
  const auto ns = [&](const Row& row, std::size_t at) { return row.ms[at] * 1e6 / kCount; };
  const double nothing = ns(rows[0], kRounds / 2);
  for (const Row& row : rows)
    std::printf("| %s | %.1f | %.1f | %.1f |\n", row.name, ns(row, kRounds / 2), ns(row, 0),
                ns(row, kRounds / 2) - nothing);
}
