#include "lut/study/verification.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <nlohmann/json.hpp>

#include "engine/parallel.h"
#include "lut/bake.h"
#include "lut/cpu_fetch.h"
#include "lut/oracles.h"
#include "lut/quadrature.h"
#include "lut/study/chord_maps.h"
#include "lut/table_errors.h"
#include "shared/paper_axes.h"
#include "shared/table_axes.h"

namespace nephele {

using json = nlohmann::ordered_json;
using shared::vec3;
using shared::vec4;

namespace {

constexpr double kHalfTurn = 3.14159265358979323846;

struct Medium {
  std::uint32_t phase_function;
  double g;
};

float single_radiance(const Medium& medium, const SphereRay& ray, double sigma) {
  const float mu = static_cast<float>(ray.mu);
  return shared::phase_per_sr(medium.phase_function, mu, static_cast<float>(medium.g)) *
         shared::single_scattering(static_cast<float>(ray.c), static_cast<float>(ray.h), mu, static_cast<float>(sigma));
}

float multiple_radiance(const FloatTexture& table, const Medium& medium, const SphereRay& ray, double sigma) {
  return fetch_multiple(table, static_cast<float>(ray.c), static_cast<float>(ray.h), static_cast<float>(ray.mu),
                        static_cast<float>(sigma), static_cast<float>(medium.g));
}

// The same table of particles with coarser and finer billows than the one there is.
json measure_other_particles(const TableParameters& parameters, int chords) {
  json rows;
  for (const float billows : {0.9f, shared::kBillowsPerRadius, 3.6f, 7.2f}) {
    const ReferenceParticle particle(parameters.particle_seed, billows);
    Table table;
    table.name = "optical depth of another particle";
    table.array = bake_optical_depth_array(particle, static_cast<int>(parameters.optical_depth_size), {});
    const TransmittanceError error =
        transmittance_error(FloatTexture(table), chords,
                            [&](const vec3& entry, const vec3& exit) { return particle.chord(entry, exit).mean; });
    rows.push_back({{"billows_per_radius", billows}, {"transmittance_rms", error.rms}});
  }
  return rows;
}

double sum_of(const std::vector<double>& values) {
  double sum = 0;
  for (double value : values) sum += value;
  return sum;
}

// Of the radiance with its phase function, for a ray and an optical radius.
using Radiance = std::function<double(const SphereRay& ray, double sigma)>;

json verify_single(const Medium& medium, const Radiance& radiance, double effort) {
  const int count = static_cast<int>(20000 * effort);
  json result{{"truth", "adaptive quadrature in doubles"}, {"rays_per_row", count}};
  for (const auto& [low, high] : std::vector<std::pair<double, double>>{
           {1e-6, 0.01}, {0.01, 0.05}, {0.05, 0.1}, {0.1, 1}, {1, 10}, {10, 100}, {100, 1000}, {1000, 10000}}) {
    std::vector<double> errors(count), squares(count);
    parallel_for(count, [&, from = low, to = high](int i) {
      UniformNumbers uniform(static_cast<std::uint64_t>(i));
      const double sigma = from * std::pow(to / from, uniform());
      const SphereRay ray = random_sphere_ray(uniform);
      const double truth =
          exact_phase_per_sr(medium.phase_function, ray.mu, medium.g) * exact_single_scattering(ray, sigma);
      errors[i] = std::abs(radiance(ray, sigma) - truth);
      squares[i] = truth * truth;
    });
    double error2 = 0;
    for (double error : errors) error2 += error * error;
    const double rms = std::sqrt(sum_of(squares) / count);
    std::nth_element(errors.begin(), errors.begin() + count * 99 / 100, errors.end());
    result["rows"].push_back({{"optical_radius", {low, high}},
                              {"relative_rmse", std::sqrt(error2 / count) / rms},
                              {"p99_over_rms", errors[count * 99 / 100] / rms}});
  }
  return result;
}

// Two independent estimates of the truth a ray: the mean product of the deviations from both is the mean square error
// without the noise of either.
json verify_all_orders(const FloatTexture& table, const Medium& medium, double effort,
                       const std::function<void(double)>& progress) {
  // At a given cost, the uncertainty of the noise-free error grows like the root of the number of rays.
  constexpr int kRays = 256, kMaxPaths = 16000;
  constexpr double kScatterings = 1e8;  // followed for one row: what it may cost
  const std::vector<double> radii{0.25, 1, 4, 16, 50, 100};
  json result{
      {"truth", "single scattering by adaptive quadrature, orders >= 2 by two independent Monte Carlo estimates"},
      {"rays_per_row", kRays}};
  for (std::size_t row = 0; row < radii.size(); ++row) {
    const double sigma = radii[row];
    const int paths =
        static_cast<int>(std::min<double>(kMaxPaths, effort * kScatterings / (2 * kRays * (3 + 4 * sigma / 3))));
    std::vector<double> truth(kRays), products(kRays), deviations(kRays), noise(kRays);
    parallel_for(kRays, [&](int i) {
      UniformNumbers uniform(static_cast<std::uint64_t>(i));
      const SphereRay ray = random_sphere_ray(uniform);
      const SphereProblem problem{medium.phase_function, medium.g, sigma};
      const auto seed = static_cast<std::uint64_t>(2 * i + 2 * kRays);
      const Estimate a = monte_carlo_multiple(problem, ray, paths, seed * 977),
                     b = monte_carlo_multiple(problem, ray, paths, (seed + 1) * 977);
      const double single =
          exact_phase_per_sr(medium.phase_function, ray.mu, medium.g) * exact_single_scattering(ray, sigma);
      const double value = double{single_radiance(medium, ray, sigma)} + multiple_radiance(table, medium, ray, sigma);
      truth[i] = single + (a.mean + b.mean) / 2;
      products[i] = (value - single - a.mean) * (value - single - b.mean);
      deviations[i] = value - truth[i];
      noise[i] = (a.standard_error * a.standard_error + b.standard_error * b.standard_error) / 4;
    });
    double mean_square = 0, product_squares = 0;
    for (int i = 0; i < kRays; ++i) {
      mean_square += (truth[i] * truth[i] - noise[i]) / kRays;
      product_squares += products[i] * products[i] / kRays;
    }
    const double error2 = sum_of(products) / kRays;
    const double uncertainty2 = std::sqrt(std::max(0.0, product_squares - error2 * error2) / kRays);
    const double mean = sum_of(truth) / kRays;
    result["rows"].push_back(
        {{"optical_radius", sigma},
         {"paths_per_ray", 2 * paths},
         {"relative_rmse", std::sqrt(std::max(0.0, error2) / mean_square)},
         {"relative_rmse_at_most", std::sqrt(std::max(0.0, error2 + 2 * uncertainty2) / mean_square)},
         {"monte_carlo_noise", std::sqrt(sum_of(noise) / kRays / mean_square)},
         {"relative_bias", sum_of(deviations) / kRays / mean},
         {"relative_bias_noise", std::sqrt(sum_of(noise)) / kRays / mean}});
    progress((row + 1.0) / static_cast<double>(radii.size()));
  }
  return result;
}

// Under uniform light of radiance 1 from everywhere, every ray leaving the sphere carries radiance 1: the largest
// deviation over chords.
double furnace_error(const FloatTexture& table, const Medium& medium, double sigma) {
  constexpr int kChords = 24, kCosines = 64, kAzimuths = 256;
  const QuadratureRule cosines = gauss_legendre(kCosines);
  std::vector<double> deviations(kChords);
  parallel_for(kChords, [&](int j) {
    const double h = (j + 0.5) / kChords, sin_h = std::sqrt(1 - h * h);
    double sum = std::exp(-2 * sigma * h);
    // Directions of light around the view ray, graded towards its forward peak: mu = 1 - 2 t^3.
    for (int i = 0; i < kCosines; ++i) {
      const double t = cosines.nodes[i], mu = 1 - 2 * t * t * t;
      for (int k = 0; k < kAzimuths; ++k) {
        const double c = mu * h + std::sqrt(1 - mu * mu) * sin_h * std::cos(kHalfTurn * (k + 0.5) / kAzimuths);
        const SphereRay ray{c, h, mu};
        sum += cosines.weights[i] * 6 * t * t * 2 * kHalfTurn / kAzimuths *
               (double{single_radiance(medium, ray, sigma)} + multiple_radiance(table, medium, ray, sigma));
      }
    }
    deviations[j] = std::abs(sum - 1);
  });
  return *std::max_element(deviations.begin(), deviations.end());
}

json verify_identities(const FloatTexture& table, const Medium& medium) {
  json rows;
  for (const double sigma : {0.05, 0.25, 1.0, 4.0, 8.0, 16.0, 50.0, 100.0})
    rows.push_back({{"optical_radius", sigma},
                    {"energy", energy_error(table, medium.phase_function, medium.g, sigma)},
                    {"furnace", furnace_error(table, medium, sigma)}});
  return {{"energy", "direct + single + multiple power over incident power, minus 1"},
          {"furnace", "largest deviation from 1 of the radiance leaving under uniform light, over chords"},
          {"rows", rows}};
}

json measure_orders(const Medium& medium, double g_first, double effort) {
  const int photons = static_cast<int>(200000 * effort);
  json result{{"truth", "Monte Carlo: light followed through the sphere"},
              {"photons", photons},
              {"g_first", g_first},
              {"g_later", medium.g}};
  std::uint64_t seed = 1;
  for (const double sigma : {0.8, 3.22, 12.9, 103.0}) {
    const OrderPowers powers = monte_carlo_orders({medium.phase_function, medium.g, sigma}, g_first, photons, seed++);
    const int all = static_cast<int>(powers.share.size());
    result["rows"].push_back({{"optical_radius", sigma},
                              {"direct", powers.between(0, 0).mean},
                              {"direct_exact", direct_power(sigma)},
                              {"single", powers.between(1, 1).mean},
                              {"orders_2_to_18", powers.between(2, 18).mean},
                              {"orders_over_18", powers.between(19, all).mean},
                              {"largest_standard_error", 0.5 / std::sqrt(powers.photons)},
                              {"scatterings_over_4_3_optical_radius", powers.scatterings.mean / (4 * sigma / 3)},
                              {"scatterings_standard_error", powers.scatterings.standard_error / (4 * sigma / 3)}});
  }
  return result;
}

void add_verification(Table& table, const json& verification) {
  json metadata = json::parse(table.metadata);
  metadata["verification"] = verification;
  table.metadata = metadata.dump(2) + "\n";
}

}  // namespace

void verify_tables(Tables& tables, const ProgressCallback& progress, double effort) {
  const auto show = [&](double fraction) {
    if (progress) progress("verifying", fraction);
  };
  show(0);
  const int chords = static_cast<int>(20000 * effort);
  const std::uint32_t seed = tables.parameters.particle_seed;
  const TransmittanceError depth =
      transmittance_error(FloatTexture(tables.optical_depth), chords,
                          [&](const vec3& entry, const vec3& exit) { return exact_mean_density(entry, exit, seed); });
  json optical_depth{{"truth", "adaptive quadrature of the density itself"},
                     {"chords", chords},
                     {"peak_optical_radius", 8},
                     {"transmittance_rms", depth.rms},
                     {"transmittance_bias", depth.bias},
                     {"transmittance_p99", depth.p99},
                     {"mean_density_rms", depth.mean_density_rms}};
  const int compared_chords = static_cast<int>(512 * effort);
  json maps{{"chords", compared_chords}};
  for (const ChordMapError& error : compare_chord_maps(seed, compared_chords))
    maps["maps"].push_back(
        {{"axes", error.name}, {"size", error.size}, {"transmittance_rms", error.transmittance_rms}});
  optical_depth["other_axes"] = maps;
  optical_depth["other_particles"] = measure_other_particles(tables.parameters, chords);
  add_verification(tables.optical_depth, optical_depth);

  const FloatTexture table(tables.multiple_scattering);
  const Medium medium{tables.parameters.phase_function, tables.parameters.g_multiple};
  show(0.05);
  json verification{{"g", medium.g}};
  verification["single_scattering"] = verify_single(
      medium, [&](const SphereRay& ray, double sigma) { return single_radiance(medium, ray, sigma); }, effort);
  show(0.1);
  verification["all_orders"] =
      verify_all_orders(table, medium, effort, [&](double fraction) { show(0.1 + 0.75 * fraction); });
  verification["identities"] = verify_identities(table, medium);
  show(0.9);
  verification["power_per_order"] = measure_orders(medium, tables.parameters.g_single, effort);
  add_verification(tables.multiple_scattering, verification);
  show(1);
}

void verify_tables(PaperTables& tables, const ProgressCallback& progress, double effort) {
  const auto show = [&](double fraction) {
    if (progress) progress("verifying", fraction);
  };
  show(0);
  const PaperParameters& parameters = tables.parameters;
  const FloatTexture depth_table(tables.optical_depth), single_table(tables.single_scattering),
      multiple_table(tables.multiple_scattering);
  const vec4 depth_size = as_vector(parameters.optical_depth_size), size = as_vector(parameters.scattering_size);
  const int chords = static_cast<int>(20000 * effort);
  const TransmittanceError depth = transmittance_error(
      [&](const vec3& entry, const vec3& exit) {
        return double{fetch_paper(depth_table, shared::paper_chord_axes(entry, exit), depth_size).x};
      },
      chords,
      [&](const vec3& entry, const vec3& exit) { return exact_mean_density(entry, exit, parameters.particle_seed); });
  add_verification(tables.optical_depth, {{"truth", "adaptive quadrature of the density itself"},
                                          {"chords", chords},
                                          {"peak_optical_radius", 8},
                                          {"transmittance_rms", depth.rms},
                                          {"transmittance_bias", depth.bias},
                                          {"transmittance_p99", depth.p99}});
  show(0.3);

  const Medium first{parameters.phase_function, double{shared::kPaperGFirst}},
      later{parameters.phase_function, double{shared::kPaperGLater}};
  const auto fetch = [&](const FloatTexture& table, const SphereRay& ray, double sigma) {
    return double{fetch_paper(table,
                              shared::paper_scattering_axes(static_cast<float>(ray.c), static_cast<float>(ray.h),
                                                            static_cast<float>(ray.mu), static_cast<float>(sigma)),
                              size)
                      .x};
  };
  const Radiance single = [&](const SphereRay& ray, double sigma) {
    return exact_phase_per_sr(first.phase_function, ray.mu, first.g) * fetch(single_table, ray, sigma);
  };
  add_verification(tables.single_scattering,
                   {{"g", first.g}, {"single_scattering", verify_single(first, single, effort)}});
  show(0.5);

  json verification{{"g", later.g}}, energy, orders;
  const auto scattered_once = [&](double sigma) {
    return exit_power(256, [&](const SphereRay& ray) { return single(ray, sigma); });
  };
  const auto scattered_again = [&](double sigma) {
    return exit_power(256, [&](const SphereRay& ray) { return fetch(multiple_table, ray, sigma); });
  };
  for (const double sigma : {0.1, 1.0, 4.0, 16.0, 100.0})
    energy.push_back({{"optical_radius", sigma},
                      {"relative", direct_power(sigma) + scattered_once(sigma) + scattered_again(sigma) - 1}});
  verification["energy"] = energy;
  verification["power_per_order"] = measure_orders(later, first.g, effort);
  for (json& row : verification["power_per_order"]["rows"])
    row["fetched_orders_2_to_18"] = scattered_again(row.at("optical_radius"));
  add_verification(tables.multiple_scattering, verification);
  show(1);
}

}  // namespace nephele
