// Small clouds for the path tracer's tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <random>
#include <vector>

#include "lut/tables.h"
#include "shared/ellipsoid.h"
#include "shared/listed_particles.h"
#include "tests/support/shapes.h"
#include "tools/path_tracer/extinction_field.h"
#include "tools/path_tracer/path_tracer.h"

namespace nephele::test {

inline constexpr float kTruthAltitudeM = 1000.0f;

inline shared::Particle round_particle(glm::vec3 center_m, float radius_m, float extinction_per_m) {
  shared::Particle particle{};
  particle.center_m = center_m;
  particle.shape = ball(radius_m);
  particle.extinction_per_m = extinction_per_m;
  particle.orientation = shared::kIdentityOrientation;
  particle.flags = shared::kParticleHomogeneous;
  particle.base_m = shared::kNoBaseM;
  return particle;
}

// Overlapping ellipsoids of all sorts about a point 500 m in front of the camera, turned every way.
inline std::vector<shared::Particle> heaped_particles(int count, std::uint32_t seed, float extinction_per_m,
                                                      bool homogeneous, bool cut = false) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  std::vector<shared::Particle> particles;
  for (int i = 0; i < count; ++i) {
    const auto u = [&] { return unit(random); };
    shared::Particle p = round_particle({200 * u() - 100, 500 + 200 * u() - 100, 100 * u() - 50}, 1, extinction_per_m);
    const glm::dvec3 radius_m(60 + 60 * u(), 60 + 60 * u(), 40 + 40 * u());
    p.shape = shape_along(random_axes(random), radius_m);
    p.extinction_per_m *= 0.5f + u();
    p.orientation = shared::pack_orientation(shared::random_rotation(u(), u(), u()));
    if (!homogeneous) p.flags = 0;
    if (cut) p.base_m = kTruthAltitudeM + p.center_m.z + (u() - 0.6f) * float(radius_m.z);
    particles.push_back(p);
  }
  return particles;
}

// Field, surroundings and tracer that belong together.
struct TruthScene {
  Scene scene;
  truth::Surroundings surroundings;
  truth::DensityLattice lattice;
  truth::ExtinctionField field;
  truth::Phase phase;
  truth::PathTracer tracer;

  TruthScene(const Scene& scene_in, const std::vector<shared::Particle>& particles,
             std::optional<glm::vec3> uniform_sky)
      : scene(scene_in),
        surroundings(scene, uniform_sky, 2000.0f),
        lattice(TableParameters{}.particle_seed),
        field(particles, glm::vec3(0.0f, 0.0f, static_cast<float>(scene.camera.position_m.z)),
              surroundings.sun_direction(), lattice),
        phase(scene.phase),
        tracer(field, surroundings, phase) {}
};

// Looking north, level; a sun, no ground.
inline Scene truth_scene() {
  Scene scene;
  scene.camera = {.position_m = {0, 0, kTruthAltitudeM}, .yaw_rad = 0, .pitch_rad = 0, .vertical_fov_rad = 0.6};
  scene.ground.enabled = false;
  scene.clouds.reset();
  return scene;
}

// A running mean with its standard error.
struct MeanAndError {
  double sum = 0, squares = 0, count = 0;
  void add(double x) {
    sum += x;
    squares += x * x;
    count += 1;
  }
  double mean() const { return sum / count; }
  double error() const { return std::sqrt(std::max(0.0, squares / count - mean() * mean()) / (count - 1)); }
};

}  // namespace nephele::test
