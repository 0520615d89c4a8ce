// The path tracer on closed cases, whose answers are known without it.
#include "tools/path_tracer/path_tracer.h"
#include "tools/path_tracer/extinction_field.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <tuple>

#include "engine/parallel.h"
#include "lut/oracles.h"
#include "shared/phase.h"
#include "tests/support/blend_oracle.h"
#include "tests/support/support.h"
#include "tests/support/truth_scene.h"
#include "tools/path_tracer/reference_image.h"

using namespace nephele;
using namespace nephele::test;
using glm::dvec3;
using glm::vec3;

namespace {

constexpr double kCircle = 3.14159265358979323846;

// A uniform sky of radiance 1, no sun.
Scene furnace_scene(double g) {
  Scene scene = truth_scene();
  scene.sun.irradiance = vec3(0.0f);
  scene.phase.g = g;
  return scene;
}

struct Band {
  MeanAndError traced, oracle, difference;  // over rays
};

// The image of a homogeneous sphere in 16 bands across, in the plane of sun and eye: radiance per unit irradiance by
// the path tracer and by the tables' Monte Carlo, at random places of each band.
class SphereBands {
 public:
  static constexpr int kPaths = 16;  // of both sides, for each ray

  // view_deg: between the ways to the eye and to the sun.
  SphereBands(double optical_diameter, double g, double view_deg)
      : problem_{.phase_function = shared::kPhaseHenyeyGreenstein, .g = g, .sigma = 0.5 * optical_diameter},
        view_rad_(view_deg * kCircle / 180),
        truth_(scene(g), {round_particle(dvec3(kCenter), kRadiusM, static_cast<float>(problem_.sigma / kRadiusM))},
               vec3(0.0f)) {}

  void add_rays(int band, int rays) {
    const dvec3 light(0, 1, 0), up(0, 0, 1);
    const dvec3 view(-std::sin(view_rad_), std::cos(view_rad_), 0), across(std::cos(view_rad_), std::sin(view_rad_), 0);
    Band& b = bands[band];
    const auto done = static_cast<int>(b.traced.count);
    UniformNumbers uniform(1000 * (done + 1) + band);
    for (int i = done; i < done + rays; ++i) {
      double x, y;
      do {
        x = (band + uniform()) / 8 - 1;
        y = 2 * uniform() - 1;
      } while (x * x + y * y >= 1);
      const dvec3 offset = x * across + y * up;
      double traced = 0;
      for (int k = 0; k < kPaths; ++k) {
        truth::Random random(20, band, kPaths * i + k);
        traced +=
            truth_.tracer.arriving(vec3(dvec3(kCenter) + kRadiusM * (offset - 2.0 * view)), vec3(view), random).g /
            kPaths;
      }
      const double h = std::sqrt(1 - x * x - y * y), sigma = problem_.sigma;
      const SphereRay ray{.c = glm::dot(offset - h * view, light), .h = h, .mu = glm::dot(-view, light)};
      const double oracle =
          exact_phase_per_sr(problem_.phase_function, ray.mu, problem_.g) * exact_single_scattering(ray, sigma) +
          monte_carlo_multiple(problem_, ray, kPaths, 1000003 * (band + 1) + i).mean;
      b.traced.add(traced);
      b.oracle.add(oracle);
      b.difference.add(traced - oracle);
    }
  }
  double mean() const {
    double sum = 0;
    for (const Band& band : bands) sum += band.oracle.mean() / static_cast<double>(bands.size());
    return sum;
  }

  std::vector<Band> bands = std::vector<Band>(16);

 private:
  static constexpr double kRadiusM = 100;
  static constexpr vec3 kCenter{0, 500, 0};
  static Scene scene(double g) {
    Scene scene = truth_scene();
    scene.sun = {.azimuth_rad = kCircle, .elevation_rad = 0, .irradiance = vec3(1.0f)};  // light travels north
    scene.phase.g = g;
    return scene;
  }
  SphereProblem problem_;
  double view_rad_;
  TruthScene truth_;
};

}  // namespace

TEST_CASE("path tracer: white furnace") {
  std::vector<shared::Particle> particles = heaped_particles(6, 21, 0.05f, false, true);
  const auto balls = heaped_particles(3, 22, 0.05f, true);
  particles.insert(particles.end(), balls.begin(), balls.end());
  for (const bool ground : {false, true}) {
    Scene scene = furnace_scene(0.85);
    scene.ground = {.enabled = ground, .albedo = vec3(1.0f)};
    const TruthScene t(scene, particles, vec3(1.0f));
    truth::ReferenceImage image(t.scene.camera, 16, 9, 1);
    image.add_samples(t.tracer, 8, 2);
    const ImageF picture = image.picture();
    const std::size_t transmittance = *picture.channel_index("T");
    int cloudy = 0;
    for (std::uint32_t y = 0; y < 9; ++y)
      for (std::uint32_t x = 0; x < 16; ++x) {
        // The ground's pattern varies about the albedo, which is then clamped to 1: a little less comes from where it
        // is seen by itself.
        const bool on_pattern = ground && picture.at(x, y, transmittance) > 0 && y >= 4;
        if (!on_pattern)
          for (std::size_t c = 0; c < 3; ++c) CHECK(picture.at(x, y, c) == doctest::Approx(1).epsilon(1e-5));
        cloudy += picture.at(x, y, transmittance) < 0.5f;
      }
    CHECK(cloudy > 20);
  }
}

TEST_CASE("path tracer: without particles there is the background alone") {
  Scene scene = truth_scene();
  scene.ground.enabled = true;
  const TruthScene t(scene, {}, std::nullopt);
  truth::ReferenceImage image(scene.camera, 8, 6, 1);
  image.add_samples(t.tracer, 16, 1);
  const ImageF picture = image.picture(), layers = image.layers(t.field, t.surroundings);
  for (std::uint32_t y = 0; y < 6; ++y)
    for (std::uint32_t x = 0; x < 8; ++x) {
      CHECK(picture.at(x, y, 3) == 1.0f);
      CHECK(picture.at(x, y, 2) > 0.0f);
      // The sky itself is no estimate: what varies is where in the pixel a sample looks.
      if (y < 2) CHECK(picture.at(x, y, 4) < 0.05f * picture.at(x, y, 2));
      for (std::size_t c = 0; c < 3; ++c) CHECK(layers.at(x, y, c) == 0.0f);
      CHECK(layers.at(x, y, 3) == 1.0f);
      CHECK(std::isinf(layers.at(x, y, 4)));
    }
}

TEST_CASE("path tracer: overlapping particles that glow show the emission-absorption integral") {
  auto particles = heaped_particles(8, 23, 0.006f, true);
  UniformNumbers uniform(24);
  for (shared::Particle& p : particles) {
    p.flags |= shared::kParticleEmissive;
    p.radiance_per_sr = {uniform(), uniform(), uniform()};
  }
  const TruthScene t(truth_scene(), particles, vec3(0.0f));
  for (int ray = 0; ray < 16; ++ray) {
    const dvec3 direction = glm::normalize(dvec3(0.4 * uniform() - 0.2, 1, 0.2 * uniform() - 0.1));
    const glm::dvec4 expected = integrate(chords(particles, direction)).color;
    MeanAndError traced;
    for (int i = 0; i < 8000; ++i) {
      truth::Random random(25, ray, i);
      traced.add(t.tracer.camera_ray(vec3(direction), 0.001f, random).cloud.r);
    }
    CHECK(std::abs(traced.mean() - expected.r) < 4 * traced.error() + 1e-4);  // standard errors
  }
}

// Light that a cloud takes from the sun's beam leaves it again, in whatever direction: the mean radiance over all lines
// that meet a sphere about the cloud, times 4 pi, is the mean of what the sphere's cross-section loses.
TEST_CASE("path tracer: the cloud sends out all the sunlight it scatters") {
  Scene scene = truth_scene();
  const TruthScene t(scene, heaped_particles(6, 26, 0.04f, false, true), vec3(0.0f));
  const dvec3 center(0, 500, 0), sun(t.surroundings.sun_direction());
  constexpr double kReachM = 300;
  UniformNumbers uniform(27);
  const auto place_across = [&](const dvec3& w) {
    const double r = kReachM * std::sqrt(uniform()), angle = 2 * kCircle * uniform();
    return center + dvec3(truth::about(vec3(w), static_cast<float>(r * std::cos(angle)),
                                       static_cast<float>(r * std::sin(angle)), 0.0f));
  };
  MeanAndError out, lost;
  for (int i = 0; i < 800000; ++i) {
    const double z = 2 * uniform() - 1, angle = 2 * kCircle * uniform(), r = std::sqrt(1 - z * z);
    const dvec3 w(r * std::cos(angle), r * std::sin(angle), z);
    truth::Random random(28, 0, i);
    out.add(4 * kCircle * t.tracer.arriving(vec3(place_across(w) - 1000.0 * w), vec3(w), random).g);
    lost.add(1 - t.field.transmittance(vec3(place_across(sun) - 1000.0 * sun), vec3(sun),
                                       truth::ExtinctionField::kNever, random));
  }
  MESSAGE("sent out " << out.mean() << " +- " << out.error() << ", lost " << lost.mean() << " +- " << lost.error());
  CHECK(out.error() < 0.02 * out.mean());
  CHECK(std::abs(out.mean() - lost.mean()) < 4 * std::hypot(out.error(), lost.error()));  // standard errors
}

TEST_CASE("path tracer: a homogeneous sphere is as the tables' Monte Carlo says") {
  for (const auto& [diameter, g, view_deg] : {std::tuple{2.0, 0.7, 45.0}, std::tuple{32.0, 0.0, 90.0}}) {
    SphereBands sphere(diameter, g, view_deg);
    parallel_for(16, [&](int band) { sphere.add_rays(band, 2500); });
    double difference = 0, variance = 0;
    for (const Band& band : sphere.bands) {
      difference += band.difference.mean() / 16;
      variance += std::pow(band.difference.error() / 16, 2);
      CHECK(std::abs(band.difference.mean()) < 4 * band.difference.error());  // standard errors
    }
    CHECK(std::sqrt(variance) < 0.01 * sphere.mean());
    CHECK(std::abs(difference) < 4 * std::sqrt(variance));
  }
}

// Asked: every band within 2 %. A band darker than a tenth of the sphere's mean is held to 2 % of that tenth: there
// both sides are noise. Sampled until the comparison's standard error is a quarter of what is allowed.
TEST_CASE("path tracer study: homogeneous spheres in 16 bands" * doctest::skip()) {
  for (const double diameter : {2.0, 32.0})
    for (const double g : {0.0, 0.7})
      for (const double view_deg : {0.0, 45.0, 90.0, 135.0}) {
        SphereBands sphere(diameter, g, view_deg);
        parallel_for(16, [&](int band) { sphere.add_rays(band, 2000); });
        const double tenth = 0.1 * sphere.mean();
        const auto scale = [&](const Band& band) { return std::max(band.oracle.mean(), tenth); };
        parallel_for(16, [&](int band) {
          const Band& b = sphere.bands[band];
          while (b.difference.error() > 0.005 * scale(b)) sphere.add_rays(band, 2000);
        });
        double worst = 0, worst_error = 0, squares = 0;
        for (const Band& band : sphere.bands) {
          const double off = band.difference.mean() / scale(band), error = band.difference.error();
          CHECK(std::abs(off) < 0.02);
          if (std::abs(off) > std::abs(worst)) worst = off;
          worst_error = std::max(worst_error, error / scale(band));
          squares += std::pow(band.difference.mean() / error, 2);
        }
        std::printf("| %g | %g | %g | %.2f | %.2f | %.2f |\n", diameter, g, view_deg, 100 * worst, 100 * worst_error,
                    squares / 16);
        std::fflush(stdout);
      }
}

TEST_CASE("path tracer: other seeds give the same picture within the stated errors") {
  Scene scene = truth_scene();
  scene.ground.enabled = true;
  const TruthScene t(scene, heaped_particles(6, 29, 0.02f, false, true), std::nullopt);
  truth::ReferenceImage a(scene.camera, 16, 9, 1), b(scene.camera, 16, 9, 2);
  a.add_samples(t.tracer, 512, 2);
  b.add_samples(t.tracer, 512, 2);
  const ImageF one = a.picture(), two = b.picture();
  const auto luminance = [](const ImageF& image, std::uint32_t x, std::uint32_t y) {
    return 0.2126 * image.at(x, y, 0) + 0.7152 * image.at(x, y, 1) + 0.0722 * image.at(x, y, 2);
  };
  double squares = 0;
  int count = 0;
  for (std::uint32_t y = 0; y < 9; ++y)
    for (std::uint32_t x = 0; x < 16; ++x) {
      const double error = std::hypot(one.at(x, y, 4), two.at(x, y, 4));
      if (error < 1e-7) continue;
      const double z = (luminance(one, x, y) - luminance(two, x, y)) / error;
      squares += z * z;
      ++count;
    }
  REQUIRE(count > 30);
  // A chi-square of `count` degrees of freedom over their number: 1, with deviation sqrt(2 / count). Skewed paths make
  // its tail a little longer, hence five deviations.
  CHECK(squares / count < 1 + 5 * std::sqrt(2.0 / count));
  CHECK(squares / count > 1 - 5 * std::sqrt(2.0 / count));
  CHECK(a.mean_relative_error() > 0);
  CHECK(a.mean_relative_error() < 0.2);
}

TEST_CASE("reference image: the same sums whatever the threads and however often it was interrupted") {
  const TempDirectory directory;
  const TruthScene t(truth_scene(), heaped_particles(4, 30, 0.03f, false), std::nullopt);
  const auto image = [&](std::uint64_t seed) { return truth::ReferenceImage(t.scene.camera, 16, 9, seed); };
  truth::ReferenceImage whole = image(1), first = image(1), rest = image(1);
  whole.add_samples(t.tracer, 16, 1);
  first.add_samples(t.tracer, 5, 3);
  REQUIRE(first.save(directory / "state", 77));
  REQUIRE(rest.load(directory / "state", 77));
  CHECK(rest.samples() == 5);
  rest.add_samples(t.tracer, 11, 2);
  CHECK(rest.picture().data == whole.picture().data);
  CHECK(rest.layers(t.field, t.surroundings).data == whole.layers(t.field, t.surroundings).data);

  const auto refused = [&](truth::ReferenceImage target, std::uint64_t key, const char* why) {
    const Result<void> loaded = target.load(directory / "state", key);
    REQUIRE_FALSE(loaded);
    CHECK(loaded.error().message.find(why) != std::string::npos);
    CHECK(target.samples() == 0);
  };
  refused(image(1), 78, "another scene");
  refused(image(2), 77, "another scene");
  refused(truth::ReferenceImage(t.scene.camera, 9, 16, 1), 77, "another scene");
  const std::string state = read_file(directory / "state");
  for (const std::string& bad : {state.substr(0, state.size() - 1), state + "x"}) {
    write_file(directory / "state", bad);
    refused(image(1), 77, "damaged");
  }
  for (const std::string& bad : {std::string(), std::string("not a state"), state.substr(0, 20)}) {
    write_file(directory / "state", bad);
    refused(image(1), 77, "not the state");
  }
}
