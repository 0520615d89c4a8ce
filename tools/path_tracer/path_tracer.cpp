#include "tools/path_tracer/path_tracer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nephele::truth {

using glm::vec3;

namespace {

constexpr float kNever = Medium::kNever;

// The sun is always looked for where it is expected to add this much per unit of irradiance, elsewhere less often in
// proportion. A sphere's mean phase function is 0.08.
constexpr float kFullEffort = 0.03f;
constexpr float kLeastGuess = 0.01f;  // of the transmittance: the guess may be wrong, and then weights must stay small
constexpr float kFullGuess = 0.3f;    // from here on the sunward way is always tried

}  // namespace

struct PathTracer::Path {
  vec3 p_m, direction;
  vec3 weight{1.0f}, light{0.0f};
  float share = 1.0f;        // of the sun's light at the next collision that is this path's to count, see look_sunward
  bool from_ground = false;  // the last event
};

// Past the terrain, to a random place of the sun's disc. Without terrain no random number is used up.
bool PathTracer::sun_in_sight(const vec3& p_m, Random& random) const {
  if (!surroundings_.has_terrain()) return true;
  const float r = std::sqrt(random()), angle = 2 * std::numbers::pi_v<float> * random();
  return surroundings_.sun_in_sight(p_m, {r * std::cos(angle), r * std::sin(angle)});
}

// Sunlight at p per unit of phase function, in the mean over `effort` of all calls.
vec3 PathTracer::sunlight(const vec3& p_m, float effort, Random& random) const {
  if (random() >= effort) return vec3(0.0f);
  if (!sun_in_sight(p_m, random)) return vec3(0.0f);
  const float left = field_.transmittance(p_m, surroundings_.sun_direction(), kNever, random);
  return left > 0.0f ? surroundings_.sun_irradiance(p_m) * (left / effort) : vec3(0.0f);
}

// A phase function with a peak makes the last scattering but one a poor guide to the last: few paths turn into the peak
// about the sun, and those few are bright. So light that scatters here and once more is looked for twice: by the path
// itself, and by a direction chosen from the peak about the sun; each counts the share that its density has in the sum
// of both (the balance heuristic, Veach 1997). This is the second way.
vec3 PathTracer::look_sunward(const Path& path, Random& random) const {
  const float effort = std::min(1.0f, std::max(field_.sun_guess(path.p_m), kLeastGuess) / kFullGuess);
  if (random() >= effort) return vec3(0.0f);
  const vec3 direction = phase_.scatter(surroundings_.sun_direction(), random);
  const float here = phase_(glm::dot(path.direction, direction));
  const float there = phase_(glm::dot(direction, surroundings_.sun_direction()));
  const float collision_m = field_.collide(path.p_m, direction, surroundings_.ground_m(path.p_m, direction), random);
  if (collision_m == kNever) return vec3(0.0f);
  const vec3 p_m = path.p_m + collision_m * direction;
  const float both = here * there / (here + there) * (field_.emits() ? 1 - field_.emission(p_m).share : 1.0f);
  return sunlight(p_m, sun_effort(both, p_m), random) * (both / effort);
}

float PathTracer::sun_effort(float phase, const vec3& p_m) const {
  return std::min(1.0f, phase * std::max(field_.sun_guess(p_m), kLeastGuess) / kFullEffort);
}

// False where the path ends: in a particle that emits and does not scatter.
bool PathTracer::scatter_in_cloud(Path& path, Random& random) const {
  if (field_.emits()) {
    const Medium::Emission emission = field_.emission(path.p_m);
    if (random() < emission.share) {
      path.light += path.weight * emission.radiance_per_sr;
      return false;
    }
  }
  const vec3 direction = phase_.scatter(path.direction, random);
  if (surroundings_.sun_shines()) {
    const float phase = path.share * phase_(glm::dot(path.direction, surroundings_.sun_direction()));
    path.light += path.weight * phase * sunlight(path.p_m, sun_effort(phase, path.p_m), random);
    path.light += path.weight * look_sunward(path, random);
    const float here = phase_(glm::dot(path.direction, direction));
    path.share = here / (here + phase_(glm::dot(direction, surroundings_.sun_direction())));
  }
  path.direction = direction;
  path.from_ground = false;
  return true;
}

void PathTracer::reflect_from_ground(Path& path, const vec3& albedo, Random& random) const {
  const vec3 normal = surroundings_.ground_normal(path.p_m), sun = surroundings_.sun_direction();
  path.p_m = surroundings_.off_ground(path.p_m);
  if (const float cosine = glm::dot(normal, sun);
      cosine > 0 && surroundings_.sun_shines() && sun_in_sight(path.p_m, random))
    path.light += path.weight * albedo * surroundings_.sun_irradiance(path.p_m) *
                  (cosine * std::numbers::inv_pi_v<float> * field_.transmittance(path.p_m, sun, kNever, random));
  path.weight *= albedo;
  path.direction = diffuse_direction(normal, random);
  path.share = 1.0f;
  path.from_ground = true;
}

// From the last event, whose light has been counted, to the path's end.
vec3 PathTracer::follow(Path path, Random& random) const {
  for (;;) {
    const float ground_m =
        path.from_ground && !surroundings_.has_terrain() ? kNever : surroundings_.ground_m(path.p_m, path.direction);
    const float cloud_m = field_.collide(path.p_m, path.direction, ground_m, random);
    const vec3 start_m = path.p_m;
    if (cloud_m < kNever) {
      path.p_m += cloud_m * path.direction;
      if (path.from_ground) {
        const Air air = surroundings_.air_from_ground(start_m, path.p_m, path.direction);
        path.light += path.weight * air.light;
        path.weight *= air.transmittance;
      }
      if (!scatter_in_cloud(path, random)) return path.light;
    } else if (ground_m < kNever) {
      const Air air = surroundings_.air_to_ground(path.p_m, path.direction, ground_m);
      path.light += path.weight * air.light;
      path.p_m += ground_m * path.direction;
      vec3 albedo = surroundings_.ground_albedo(path.p_m) * air.transmittance;
      const float most = std::max({albedo.r, albedo.g, albedo.b});
      if (random() >= most) return path.light;
      reflect_from_ground(path, albedo / most, random);
    } else {
      return path.light + path.weight * surroundings_.sky(path.p_m, path.direction);
    }
  }
}

vec3 PathTracer::from_cloud(const vec3& p_m, const vec3& direction, Random& random) const {
  Path path{.p_m = p_m, .direction = direction};
  return scatter_in_cloud(path, random) ? follow(path, random) : path.light;
}

vec3 PathTracer::from_ground(const vec3& p_m, const vec3& albedo, Random& random) const {
  Path path{.p_m = p_m, .direction = vec3(0.0f)};
  reflect_from_ground(path, albedo, random);
  return follow(path, random);
}

vec3 PathTracer::arriving(const vec3& p_m, const vec3& direction, Random& random) const {
  return follow({.p_m = p_m, .direction = direction}, random);
}

PathSample PathTracer::camera_ray(const vec3& direction, float pixel_rad, Random& random) const {
  const vec3 eye(0.0f);
  const float ground_m = surroundings_.ground_m(eye, direction);
  PathSample sample;
  const float cloud_m = field_.collide(eye, direction, ground_m, random);
  if (cloud_m < kNever) {
    sample.cloud = from_cloud(cloud_m * direction, direction, random);
    const Air air = surroundings_.air_from_camera(direction, cloud_m);
    sample.radiance = air.light + air.transmittance * sample.cloud;
  } else if (ground_m < kNever) {
    const Air air = surroundings_.air_to_ground(eye, direction, ground_m);
    const vec3 albedo = surroundings_.seen_ground_albedo(direction, ground_m, pixel_rad);
    sample.radiance = air.light + air.transmittance * from_ground(ground_m * direction, albedo, random);
  } else {
    sample.radiance = surroundings_.sky(eye, direction);
  }
  sample.transmittance = field_.transmittance(eye, direction, ground_m, random);
  return sample;
}

}  // namespace nephele::truth
