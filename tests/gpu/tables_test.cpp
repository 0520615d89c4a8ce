// The tables as the device fetches them: against the CPU's filtering of the same texels, against quadrature and a finer
// solution of the same physics, and for the energy that the default preset carries.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "engine/frame.h"
#include "engine/parallel.h"
#include "lut/bake.h"
#include "lut/cpu_fetch.h"
#include "lut/gpu_tables.h"
#include "lut/oracles.h"
#include "lut/packed_optical_depth.h"
#include "lut/sphere_solver.h"
#include "nephele_test_shaders.h"
#include "shared/reference_particle.h"
#include "shared/table_axes.h"
#include "tests/support/test_device.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using shared::vec2;
using shared::vec3;

namespace {

struct Query {
  vec3 entry, exit, light;
  float sigma, g;
};

struct Answer {
  vec2 optical_depth, packed_optical_depth;
  float single, multiple, phase, density, noise;
  std::uint32_t hash;
};

// As the shader forms them, in doubles.
SphereRay cosines(const Query& q) {
  const glm::dvec3 entry(q.entry), exit(q.exit), light(q.light);
  const double span = length(exit - entry);
  const glm::dvec3 omega = span > 1e-6 ? (entry - exit) / span : entry;
  return {dot(entry, light), 0.5 * span, dot(omega, light)};
}

std::vector<Answer> ask(const std::vector<Query>& queries, const Tables& baked = test::test_tables()) {
  Device& device = test::test_device();
  const GpuTables tables(device, baked);
  const std::vector<std::uint32_t> words = pack_optical_depth(baked.optical_depth);
  Buffer packed(device, "packed_optical_depth", words.size() * sizeof(std::uint32_t));
  packed.write_vector(words);
  const SpecConstant constants[] = {{10, baked.optical_depth.width()}};
  const ComputeKernel kernel(device, shaders::test_tables_comp, constants);
  Buffer in(device, "queries", queries.size() * sizeof(Query)), out(device, "answers", queries.size() * sizeof(Answer));
  in.write_vector(queries);
  const auto count = static_cast<std::uint32_t>(queries.size());
  FrameBuilder frame(device);
  frame.compute({.name = "test_tables",
                 .kernel = &kernel,
                 .bindings = {{0, in, Access::storage_read},
                              {1, out, Access::storage_write},
                              {2, tables.optical_depth(), Access::sampled},
                              {3, tables.multiple_scattering(), Access::sampled},
                              {4, packed, Access::words}},
                 .push = as_push(count),
                 .groups = {(count + 63) / 64, 1, 1},
                 .indirect = {}});
  FrameExecutor(device).run(frame);
  return out.read_vector<Answer>(queries.size());
}

vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<float> normal;
  return normalize(vec3(normal(random), normal(random), normal(random)));
}

// Impact uniform in area, light from anywhere.
std::vector<Query> random_queries(int count, double sigma_low, double sigma_high, float g) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Query> queries;
  for (int i = 0; i < count; ++i) {
    const vec3 along = random_direction(random);
    const vec3 side = normalize(cross(along, random_direction(random)));
    const float b = static_cast<float>(std::sqrt(unit(random))), h = std::sqrt(std::max(0.0f, 1 - b * b));
    queries.push_back({normalize(b * side - h * along), normalize(b * side + h * along), random_direction(random),
                       static_cast<float>(sigma_low * std::pow(sigma_high / sigma_low, unit(random))), g});
  }
  return queries;
}

// Poles and folds of every axis, light along the ray both ways, no chord, no density, too much of it.
std::vector<Query> edge_queries(float g) {
  std::vector<Query> queries;
  std::vector<vec3> corners;
  for (int axis = 0; axis < 3; ++axis)
    for (const float sign : {-1.0f, 1.0f}) corners.push_back(vec3(axis == 0, axis == 1, axis == 2) * sign);
  corners.push_back(normalize(vec3(1, 1, 0)));
  corners.push_back(normalize(vec3(1, 0, -1)));
  corners.push_back(normalize(vec3(-1e-4f, 1e-7f, -1)));
  for (const vec3& entry : corners)
    for (const vec3& exit : corners)
      for (const vec3& light : corners)
        for (const float sigma : {0.0f, 1e-6f, 0.3f, 60.0f, 1e4f}) queries.push_back({entry, exit, light, sigma, g});
  const vec3 entry(1, 0, 0), near_by = normalize(vec3(1, 1e-5f, 0));
  for (const vec3& light : {normalize(near_by - entry), normalize(entry - near_by), entry, -entry})
    for (const float sigma : {1e-6f, 1.0f, 1e4f}) queries.push_back({entry, near_by, light, sigma, g});
  return queries;
}

const float g_table = static_cast<float>(TableParameters{}.g_multiple);

}  // namespace

TEST_CASE("the device fetches what the CPU fetches, everywhere") {
  std::vector<Query> queries = random_queries(20000, 1e-3, 1e4, g_table);
  const std::vector<Query> edges = edge_queries(g_table);
  queries.insert(queries.end(), edges.begin(), edges.end());
  const std::vector<Answer> answers = ask(queries);
  const FloatTexture optical_depth(test::test_tables().optical_depth),
      multiple(test::test_tables().multiple_scattering);
  double worst_depth = 0, worst_packed = 0, worst_single = 0, worst_multiple = 0, worst_noise = 0;
  int bad = 0, hashes = 0;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const Query& q = queries[i];
    const Answer& a = answers[i];
    const SphereRay t = cosines(q);
    const float c = float(t.c), h = float(t.h), mu = float(t.mu);
    if (!(std::isfinite(a.single) && std::isfinite(a.multiple) && a.single >= 0 && a.multiple >= 0)) ++bad;
    const vec2 depth = fetch_optical_depth(optical_depth, q.entry, q.exit);
    worst_depth =
        std::max<double>({worst_depth, std::abs(depth.x - a.optical_depth.x), std::abs(depth.y - a.optical_depth.y)});
    worst_packed = std::max<double>(
        {worst_packed, std::abs(depth.x - a.packed_optical_depth.x), std::abs(depth.y - a.packed_optical_depth.y)});
    const float single = shared::single_scattering(c, h, mu, q.sigma);
    worst_single = std::max<double>(worst_single, std::abs(single - a.single));
    const float radiance = fetch_multiple(multiple, c, h, mu, q.sigma, q.g);
    worst_multiple = std::max<double>(worst_multiple, std::abs(radiance - a.multiple) / (0.02 + radiance));
    const vec3 middle = 0.5f * (q.entry + q.exit);
    worst_noise =
        std::max<double>({worst_noise, std::abs(shared::reference_particle_density(middle, 5u) - a.density),
                          std::abs(shared::fbm3(10.0f * q.entry, shared::uvec3(0xfffffffeu, 3u, i), 9u, 3) - a.noise)});
    const auto expected = shared::hash_ivec3(shared::ivec3(floor(100.0f * q.entry)), static_cast<std::uint32_t>(i));
    hashes += expected == a.hash;
  }
  CHECK(bad == 0);
  // Filtering weights may have 8 bits: 1/256 of the step between texels, which is at most 1 in either table. Lavapipe
  // is far better.
  CHECK(worst_depth < 0.006);
  // Every vertex is there exactly, but what lies between the coarse ones has 11 bits in the texture. Weights are
  // floats.
  CHECK(worst_packed < 3e-4);
  // Grazing chords amplify the rounding of the cosines by sigma.
  CHECK(worst_single < 0.002);
  CHECK(worst_multiple < 0.02);
  CHECK(worst_noise < 1e-4);
  CHECK(hashes == static_cast<int>(queries.size()));
}

TEST_CASE("a packed table of any size gives what the texture gives") {
  std::vector<Query> queries = random_queries(4000, 1, 1, g_table);
  const std::vector<Query> edges = edge_queries(g_table);
  queries.insert(queries.end(), edges.begin(), edges.end());
  const ReferenceParticle particle(5);
  for (const int n : {4, 5, 6, 7, 9, 12}) {
    CAPTURE(n);
    Tables tables = test::test_tables();
    tables.optical_depth.array = bake_optical_depth_array(particle, n, {});
    const FloatTexture texture(tables.optical_depth);
    const std::vector<Answer> answers = ask(queries, tables);
    double worst = 0;
    for (std::size_t i = 0; i < queries.size(); ++i) {
      const vec2 depth = fetch_optical_depth(texture, queries[i].entry, queries[i].exit);
      worst = std::max<double>({worst, std::abs(depth.x - answers[i].packed_optical_depth.x),
                                std::abs(depth.y - answers[i].packed_optical_depth.y)});
    }
    CHECK(worst < 3e-4);
  }
}

TEST_CASE("single plus multiple scattering on the device is within 2 % of a finer solution") {
  for (const double sigma : {0.4, 1.7, 6.5, 14.0}) {
    CAPTURE(sigma);
    const std::vector<Query> queries = random_queries(2000, sigma, sigma, g_table);
    const std::vector<Answer> answers = ask(queries);
    // More directions and, when thin, more places than the bake uses; single scattering by quadrature.
    const SphereSolution fine = solve_sphere({0, g_table, sigma}, {22, 26, 24, 16, 10}, 1e-5);
    std::vector<double> errors(queries.size()), values(queries.size());
    parallel_for(static_cast<int>(queries.size()), [&](int i) {
      const SphereRay t = cosines(queries[i]);
      const double single =
          exact_phase_per_sr(shared::kPhaseHenyeyGreenstein, t.mu, g_table) * exact_single_scattering(t, sigma);
      const double x = shared::azimuth_cosine(float(t.c), float(t.h), float(t.mu));
      values[i] = single + fine.chord_source(t.c, t.h, x) * -std::expm1(-2 * sigma * t.h);
      errors[i] = answers[i].phase * answers[i].single + answers[i].multiple - values[i];
    });
    double error2 = 0, value2 = 0, error = 0, value = 0;
    for (std::size_t i = 0; i < errors.size(); ++i) {
      error2 += errors[i] * errors[i];
      value2 += values[i] * values[i];
      error += errors[i];
      value += values[i];
    }
    CHECK(std::sqrt(error2 / value2) < 0.02);  // measured 0.2 to 1.3 %
    CHECK(std::abs(error / value) < 0.005);    // measured at most 0.2 %
  }
}

TEST_CASE("the default table's energy is the incident power") {
  const FloatTexture multiple(test::test_tables().multiple_scattering);
  for (const double sigma : {0.05, 0.5, 2.0, 8.0, 16.0, 100.0}) {
    CAPTURE(sigma);
    const double scattered = exit_power(192, [&](const SphereRay& ray) {
      const float c = float(ray.c), h = float(ray.h), mu = float(ray.mu), radius = float(sigma);
      return double{shared::phase_henyey_greenstein(mu, g_table) * shared::single_scattering(c, h, mu, radius) +
                    fetch_multiple(multiple, c, h, mu, radius, g_table)};
    });
    CHECK(direct_power(sigma) + scattered == doctest::Approx(1.0).epsilon(sigma > 16 ? 0.015 : 0.005));
  }
}
