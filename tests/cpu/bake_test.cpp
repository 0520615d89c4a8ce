// The bakes against independent truth: Monte Carlo in doubles, conservation of energy, closed forms, plain marching.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <span>
#include <vector>

#include "lut/bake.h"
#include "lut/cpu_fetch.h"
#include "lut/gmres.h"
#include "lut/oracles.h"
#include "lut/quadrature.h"
#include "lut/sphere_diffusion.h"
#include "lut/sphere_solver.h"
#include "shared/reference_particle.h"
#include "shared/table_axes.h"

using namespace nephele;

namespace {

double scattering_cosine(double c, double h, double x) { return c * h + std::sqrt((1 - c * c) * (1 - h * h)) * x; }

double single_power(double sigma, double g) {
  return exit_power(64, [&](const SphereRay& ray) {
    return exact_phase_per_sr(shared::kPhaseHenyeyGreenstein, ray.mu, g) * exact_single_scattering(ray, sigma);
  });
}

}  // namespace

TEST_CASE("Gauss rules integrate what they promise") {
  const QuadratureRule legendre = gauss_legendre(5);
  for (int power_of_x = 0; power_of_x < 10; ++power_of_x) {
    double sum = 0;
    for (int i = 0; i < 5; ++i) sum += legendre.weights[i] * std::pow(legendre.nodes[i], power_of_x);
    CHECK(sum == doctest::Approx(1.0 / (power_of_x + 1)).epsilon(1e-12));
  }
  // Weight exp(-t) on [0, T]: mean of t and of t^2 in closed form, through the interpolated table of rules.
  const ExponentialRules rules(6);
  for (const double length : {1e-9, 0.01, 0.7, 3.0, 20.0, 1e4}) {
    CAPTURE(length);
    double t[6], w[6], total = 0, mean = 0;
    rules.evaluate(length, t, w);
    for (int i = 0; i < 6; ++i) {
      total += w[i];
      mean += w[i] * t[i];
      CHECK(t[i] <= length);
    }
    const double expected = length < 1e-3 ? length / 2 : 1 - length * std::exp(-length) / -std::expm1(-length);
    CHECK(total == doctest::Approx(1.0).epsilon(1e-6));
    CHECK(mean == doctest::Approx(expected).epsilon(1e-4));
  }
}

TEST_CASE("GMRES solves what it is given, restarted or not") {
  // x - K x = b with K = tridiagonal, 200 unknowns.
  const int n = 200;
  const auto apply = [&](const float* in, float* out) {
    for (int i = 0; i < n; ++i)
      out[i] = 0.45f * ((i > 0 ? in[i - 1] : 0) + (i + 1 < n ? in[i + 1] : 0)) + 0.05f * in[i];
  };
  std::vector<float> b(n);
  for (int i = 0; i < n; ++i) b[i] = std::sin(0.37f * i) + 1;
  for (const int restart : {100, 12}) {
    const GmresResult result = gmres(apply, b, 1e-5, restart, 1000);
    std::vector<float> image(n);
    apply(result.x.data(), image.data());
    double residual = 0, norm = 0;
    for (int i = 0; i < n; ++i) {
      residual += std::pow(b[i] - result.x[i] + image[i], 2);
      norm += b[i] * b[i];
    }
    CHECK(std::sqrt(residual / norm) < 2e-5);
    CHECK(result.residual <= 1e-5);
  }
  CHECK(gmres(apply, std::vector<float>(n, 0.0f), 1e-5, 10, 10).applications == 0);
}

TEST_CASE("diffusion of a uniform source in a sphere has its closed form") {
  // -D laplace(flux) = sigma q: flux = sigma q (1 - r^2) / 6 D + 2 sigma q / 3, from an outward current of flux / 2.
  const double sigma = 9, transport = 4, q = 0.7;
  const RadialAxis radial(40, sigma);
  const SphereDiffusion diffusion(radial, 40, 12, sigma, transport);
  const std::vector<double> flux = diffusion.solve(std::vector<double>(40 * 12, q));
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 12; ++j) {
      const double r = radial.radius(i);
      CHECK(flux[i * 12 + j] == doctest::Approx(sigma * q * ((1 - r * r) * 3 * transport / 6 + 2.0 / 3)).epsilon(0.01));
    }
  }
}

TEST_CASE("successive scattering of a thick sphere converges within a few dozen steps") {
  const SphereSolution solution = solve_sphere({0, 0.85, 200}, sphere_grid(200, true), 3e-5);
  CHECK(solution.residual() <= 3e-5);
  CHECK(solution.applications() < 80);  // 180 without the diffusion preconditioner
}

TEST_CASE("direct, single and multiple scattering add up to the incident power") {
  for (const auto& [sigma, g] :
       std::vector<std::pair<double, double>>{{0.1, 0.7}, {1, 0.0}, {3, 0.85}, {8, 0.7}, {2, -0.6}, {50, 0.85}}) {
    CAPTURE(sigma);
    CAPTURE(g);
    const SphereSolution solution = solve_sphere({0, g, sigma}, sphere_grid(sigma, false), 1e-4);
    CHECK(solution.residual() <= 1e-4);
    const double multiple = exit_power(24, [&](const SphereRay& ray) {
      const float x = shared::azimuth_cosine(float(ray.c), float(ray.h), float(ray.mu));
      return solution.chord_source(ray.c, ray.h, x) * -std::expm1(-2 * sigma * ray.h);
    });
    // Measured 0.1 % at these grids.
    CHECK(direct_power(sigma) + single_power(sigma, g) + multiple == doctest::Approx(1.0).epsilon(0.004));
  }
}

TEST_CASE("multiple scattering agrees with Monte Carlo on lit, dark, grazing and forward rays") {
  struct Ray {
    double c, h, x;
  };
  for (const auto& [sigma, g] : std::vector<std::pair<double, double>>{{1, 0.7}, {4, 0.85}, {10, 0.0}}) {
    CAPTURE(sigma);
    CAPTURE(g);
    const SphereSolution solution = solve_sphere({0, g, sigma}, sphere_grid(sigma, false), 1e-5);
    for (const Ray ray :
         {Ray{-0.8, 0.9, 0.2}, Ray{0.7, 0.8, 0.6}, Ray{0.05, 0.3, -0.9}, Ray{0.9, 0.95, 1.0}, Ray{-0.3, 0.15, 0.98}}) {
      CAPTURE(ray.c);
      const SphereRay at{ray.c, ray.h, scattering_cosine(ray.c, ray.h, ray.x)};
      const Estimate truth = monte_carlo_multiple({0, g, sigma}, at, 160000, 1000);
      const double value = solution.chord_source(ray.c, ray.h, ray.x) * -std::expm1(-2 * sigma * ray.h);
      CAPTURE(truth.mean);
      CAPTURE(truth.standard_error);
      // Four standard errors, and 2 % for the grid: 14 radii x 16 polar angles below sigma 5.
      CHECK(std::abs(value - truth.mean) < 4 * truth.standard_error + 0.02 * truth.mean);
    }
  }
}

TEST_CASE("a baked table carries the sphere's energy at and between its densities") {
  ScatteringBake bake;
  bake.g = 0.7;
  bake.cosines = 24;
  bake.chords = 12;
  bake.densities = 8;
  bake.coarse_solver = true;
  int calls = 0;
  Table table;
  table.name = "multiple_scattering";
  table.array = bake_multiple_scattering_array(bake, [&](double) { ++calls; });
  CHECK(calls == 8);
  REQUIRE(table.array.shape == std::vector<std::size_t>{8, 12, 24, 4});
  const FloatTexture texture(table);
  const float g = static_cast<float>(bake.g);
  // Coarse solver and eight densities: 1 % at the densities solved, 2 % half way.
  for (const auto& [sigma, tolerance] :
       std::vector<std::pair<double, double>>{{1.0, 0.01}, {4.5, 0.01}, {8.0, 0.015}, {2.5, 0.02}}) {
    CAPTURE(sigma);
    const double multiple = exit_power(24, [&](const SphereRay& ray) {
      return double{fetch_multiple(texture, float(ray.c), float(ray.h), float(ray.mu), float(sigma), g)};
    });
    CHECK(direct_power(sigma) + single_power(sigma, g) + multiple == doctest::Approx(1.0).epsilon(tolerance));
  }
  // Any density, any ray: finite and never negative.
  for (const float sigma : {0.0f, 1e-6f, 1e-3f, 30.0f, 1e4f}) {
    for (const float h : {0.0f, 1e-6f, 0.5f, 1.0f}) {
      for (const float c : {-1.0f, -0.3f, 0.0f, 1.0f}) {
        const float value = fetch_multiple(texture, c, h, c * h, sigma, g);
        CHECK(value >= 0.0f);
        CHECK(value < 5.0f);
      }
    }
  }
}

namespace {

shared::vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<float> normal;
  return normalize(shared::vec3(normal(random), normal(random), normal(random)));
}

}  // namespace

TEST_CASE("chords of the tabulated particle are those of its density, marched") {
  const std::uint32_t seed = 5;
  const ReferenceParticle particle(seed);
  std::mt19937 random(3);
  double worst = 0, fill = 0;
  for (int i = 0; i < 300; ++i) {
    const shared::vec3 entry = random_direction(random), exit = random_direction(random);
    double sum = 0;
    const int steps = 1000;
    for (int k = 0; k < steps; ++k)
      sum += shared::reference_particle_density(entry + (exit - entry) * ((float(k) + 0.5f) / steps), seed);
    worst = std::max(worst, std::abs(particle.chord(entry, exit).mean - sum / steps));
  }
  CHECK(worst < 2.5e-3);  // linear interpolation between vertices 1/64 apart, edges a tenth of a radius: second order
  // The mean over uniform places equals that over vertices of the density's grid.
  std::uniform_real_distribution<float> cube(-1, 1);
  int inside = 0;
  while (inside < 20000) {
    const shared::vec3 p(cube(random), cube(random), cube(random));
    if (dot(p, p) >= 1) continue;
    fill += shared::reference_particle_density(p, seed);
    ++inside;
  }
  CHECK(particle.mean_fill() == doctest::Approx(fill / inside).epsilon(0.03));  // standard error 0.8 %
}

TEST_CASE(
    "fitted vertices err less than plain ones under linear filtering, seams included, and leave constants alone") {
  const int n = 16, vertices = n * n;
  const std::vector<float> constant(std::size_t{vertices} * vertices, 0.5f);
  for (float x : least_squares_vertices(constant, n)) REQUIRE(x == 0.5f);

  const shared::vec3 a(1.1f, -0.7f, 1.3f), b(-0.9f, 1.2f, 0.8f);
  const auto value = [&](const shared::vec3& entry, const shared::vec3& exit) {
    return 0.4f + 0.2f * std::sin(dot(a, entry)) + 0.15f * std::cos(dot(b, exit));
  };
  const auto vertex = [&](int i) {
    const int column = i % n, row = i / n;
    return shared::octahedral_decode(shared::vec2(float(column), float(row)) / float(n - 1));
  };
  std::vector<float> values(constant.size());
  for (int s = 0; s < vertices; ++s)
    for (int e = 0; e < vertices; ++e) values[std::size_t(s) * vertices + e] = value(vertex(s), vertex(e));
  const auto rms = [&](const std::vector<float>& at_vertices) {
    Table table;
    table.array = {ElementType::float32, {std::size_t(vertices), n, n, 1}, {}};
    const auto bytes = std::as_bytes(std::span(at_vertices));
    table.array.data.assign(bytes.begin(), bytes.end());
    const FloatTexture texture(table);
    std::mt19937 random(4);
    double squares = 0;
    for (int i = 0; i < 20000; ++i) {
      const shared::vec3 entry = random_direction(random), exit = random_direction(random);
      const double root = std::sqrt(fetch_optical_depth(texture, entry, exit).x);
      squares += (root - value(entry, exit)) * (root - value(entry, exit)) / 20000;
    }
    return std::sqrt(squares);
  };
  // On a plain grid at most 1 / sqrt 6 would be left; the maps' creases, where a second difference is no curvature,
  // leave 0.59.
  CHECK(rms(least_squares_vertices(values, n)) < 0.65 * rms(values));
}

TEST_CASE("the optical depth table holds mean density and first matter, the same both ways") {
  const std::uint32_t seed = 5;
  const int n = 24;
  Table table;
  const ReferenceParticle particle(seed);
  table.array = bake_optical_depth_array(particle, n, {});
  const FloatTexture texture(table);
  std::mt19937 random(3);
  double squares = 0, first_squares = 0;
  int dense = 0;
  for (int i = 0; i < 500; ++i) {
    const shared::vec3 entry = random_direction(random), exit = random_direction(random);
    const shared::vec2 there = fetch_optical_depth(texture, entry, exit),
                       back = fetch_optical_depth(texture, exit, entry);
    const double mean = exact_mean_density(entry, exit, seed);
    squares += (there.x - mean) * (there.x - mean) / 500;
    CHECK(there.x == doctest::Approx(back.x).epsilon(1e-4).scale(1));
    CHECK(there.y >= 0.0f);
    CHECK(there.y <= 1.00001f);
    if (mean < 0.05) continue;
    CHECK(there.y + back.y < 1.0 - 0.6 * mean);  // no denser than 1, matter takes its share of the chord at least
    first_squares += std::pow(there.y - particle.chord(entry, exit).first, 2);
    ++dense;
  }
  // As the packed table can hold them: whole 256ths, the first matter linear between coarse vertices.
  const auto texel = [&](int entry, int exit, int channel) {
    std::uint16_t half = 0;
    std::memcpy(&half, &table.array.data[2 * (2 * (std::size_t(entry) * n * n + exit) + channel)], 2);
    return glm::unpackHalf2x16(half).x;
  };
  const int exit = 8 * n + 10;
  for (const int entry : {6, 2 * n + 6, 4 * n + 6, 6 * n + 6}) {
    CAPTURE(entry);
    for (const int channel : {0, 1})
      CHECK(texel(entry, exit, channel) * 256 == std::round(texel(entry, exit, channel) * 256));
    const auto first_between = [&](int a, int b) {
      return doctest::Approx(0.5 * (texel(entry, exit, 1) + texel(a, b, 1))).epsilon(1e-3);
    };
    CHECK(texel(entry, exit + 1, 1) == first_between(entry, exit + 2));
    CHECK(texel(entry + n, exit, 1) == first_between(entry + 2 * n, exit));
  }
  CHECK(std::sqrt(first_squares / dense) < 0.05);  // of the chord; 0.038 measured, 0.025 at the default size
  CHECK(std::sqrt(squares) < 0.008);               // 0.004 measured; plain interpolation without the fit errs by 0.011
}

TEST_CASE("a chord that meets nothing is empty, one through the core is not") {
  const ReferenceParticle particle(5);
  const ChordStatistics graze = particle.chord(shared::vec3(1, 0, 0), normalize(shared::vec3(1, 0.05f, 0)));
  CHECK(graze.mean < 0.01f);
  CHECK(graze.first == 1.0f);
  CHECK(graze.last == 0.0f);
  const ChordStatistics core = particle.chord(shared::vec3(1, 0, 0), shared::vec3(-1, 0, 0));
  CHECK(core.mean > 0.1f);
  CHECK(core.first < core.last);
  const ChordStatistics back = particle.chord(shared::vec3(-1, 0, 0), shared::vec3(1, 0, 0));
  CHECK(back.mean == doctest::Approx(core.mean).epsilon(1e-3));
  CHECK(back.first == doctest::Approx(1 - core.last).epsilon(0.02).scale(1));
}
