// Shading of one particle along one ray: geometry, optical depth, light, as a segment to be blended.
// The including shader declares FrameConstants frame. Where it defines PACKED_TABLE it includes packed_table_fetch.glsl
// before, and the optical depth table is read as bytes.
#ifndef NEPHELE_CLOUD_SHADE_GLSL
#define NEPHELE_CLOUD_SHADE_GLSL

#include "shared/blend.h"
#include "shared/cloud_light.h"
#include "shared/ellipsoid.h"
#include "shared/flat_base.h"
#include "shared/light.h"
#include "shared/scattering.h"
#include "shared/screen_bounds.h"
#include "shared/types.h"
#include "shared/world.h"
#include "kit/camera_rays.glsl"
#include "layer/shading_inputs.glsl"
#include "layer/density_fetch.glsl"
#include "layer/particle_light.glsl"
#include "layer/structure_fetch.glsl"
#include "layer/table_fetch.glsl"

// Cuts [near_m, far_m] to what lies above the flat base and thins it near the base; false when nothing is left.
bool cut_at_base(float base_m, vec3 direction, inout float near_m, inout float far_m, inout float thinning) {
  float above_near = altitude_m(direction * near_m, frame.camera_grid_m.z) - base_m;
  float above_far = altitude_m(direction * far_m, frame.camera_grid_m.z) - base_m;
  if (max(above_near, above_far) <= 0.0) return false;
  float slope = (above_far - above_near) / max(far_m - near_m, 1e-3);
  if (above_near < 0.0) {
    near_m -= above_near / slope;
    above_near = 0.0;
  } else if (above_far < 0.0) {
    far_m = near_m - above_near / slope;
    above_far = 0.0;
  }
  thinning = mean_base_fade(above_near, above_far);
  return far_m > near_m;
}

// Optical depth towards the sun from a place in the particle, by the particle's own record: through the others as four
// places know it, and through itself by its mean profile.
float own_depth_to_sun(DrawParticle p, vec3 from_center_m) {
  const float others = linear_depth(p.tau_sun, dot(p.tau_gradient_per_m, from_center_m));
  const vec3 towards_sun = p.reference_from_render * frame.sun_direction, at = p.reference_from_render * from_center_m;
  const float sun_radius_m = 1.0 / length(towards_sun);
  const float along = sun_radius_m * dot(at, towards_sun), h2 = max(1.0 - dot(at, at) + along * along, 0.0);
  const float self = profile_integral(sqrt(h2), h2, p.flags) - profile_integral(along, h2, p.flags);
  return others + p.extinction_per_m * torn_matter(p.flags) * sun_radius_m * max(self, 0.0);
}

// Source radiance of a segment that is lit as it is at_m metres from the camera.
vec3 radiance_from_field(DrawParticle p, vec3 direction, float at_m) {
  const vec3 from_center_m = direction * at_m - p.center_m;
  const float mu = dot(frame.sun_direction, direction);
  const vec4 seen = textureLod(light_radiance, p.field_place + from_center_m * field_scale_per_m(p), 0.0);
  float tau = seen.a;
  // A loop of at most one round: unlike a branch a CPU leaves it out where none of eight threads needs it.
  for (float left = p.own_depth_share; left > 0.0; left = 0.0)
    tau = mix(tau, own_depth_to_sun(p, from_center_m), p.own_depth_share);
  const float once_per_sr = phase_per_sr(frame.phase_function, mu, frame.phase_g);
  return source_radiance_in_field(p.sun_irradiance, mu, once_per_sr, tau, seen.rgb);
}

// The same from the particle's tables: of a segment of optical depth tau_chord along the chord of half length h in the
// unit sphere.
vec3 radiance_from_tables(DrawParticle p, vec3 direction, float at_m, vec3 entry, float h, float mu_unit,
                          float tau_chord) {
  const float mu = dot(frame.sun_direction, direction);
  TableLight light;
  light.sun_irradiance = p.sun_irradiance;
  light.tau_sun = linear_depth(p.tau_sun, dot(p.tau_gradient_per_m, direction * at_m - p.center_m));
  // Scattered once: in a homogeneous sphere whose density gives this chord its depth.
  const float sigma_ray = tau_chord / max(2.0 * h, 1e-3);
  const float self =
      single_scattering(dot(entry, p.light_direction), h, mu_unit, sigma_ray) / max(opacity_of(tau_chord), 1e-6);
  light.once_per_sr =
      phase_per_sr(frame.phase_function, mu, frame.phase_g) * clamp(self, 1e-4, 1.0) * exp(-light.tau_sun);
  light.again_per_sr = multiple_inside_per_sr(p, entry, h, mu_unit);
  light.ambient_radiance = p.ambient_radiance;
  return table_source_radiance(light);
}

// The reference particle along the chord between two points of the unit sphere, as fetch_optical_depth gives it.
vec2 fetch_matter(vec3 entry, vec3 exit) {
#ifdef PACKED_TABLE
  return fetch_packed_optical_depth(entry, exit);
#else
  return fetch_optical_depth(optical_depth_table, entry, exit);
#endif
}

// Samples of the density along a visible chord are this far apart, and so many at most and at least; where the eye is
// in a smooth particle, or a base hides a part of one, so many. Numbers are real: the last sample stands for what is
// left, so that nothing jumps as a chord grows.
const float kStepM = 30.0, kMostSamples = 8.0, kFewestSamples = 3.0, kInsideSamples = 12.0, kCutSamples = 3.0;
const float kNearM = 1600.0, kNearStepM = 14.0, kMostNearSamples = 36.0;  // nearer than this they are denser
const float kPixelPoint = 0.29;                                           // of a pixel, from its middle
const float kOpaqueDepth = 5.0;  // the rest of a chord behind it is not asked for

// The chord of a ray through a particle's unit sphere: start + (t - along_m) * step at t metres, closest to the centre
// at mid_m, where the squared distance is b2.
struct UnitChord {
  vec3 start, step;
  float along_m, mid_m, b2;
};

// The particle's matter between two places of a ray, measured: the stretch becomes the one over which matter of the
// same optical depth would have the same middle and spread if it were even, and its mean extinction is returned.
//
// A pixel sees the mean over its area. Across an outline that is by two points, Gauss's: the opacity of a ball with
// structure is the mean of that of a slightly smaller and a slightly larger one.
float measured_extinction(DrawParticle p, UnitChord chord, vec3 direction, float step_m, inout float near_m,
                          inout float far_m) {
  const float step2 = dot(chord.step, chord.step);
  const float base_near_m = altitude_m(direction * near_m, frame.camera_grid_m.z) - p.base_m;
  const float climb =
      (altitude_m(direction * far_m, frame.camera_grid_m.z) - p.base_m - base_near_m) / (far_m - near_m);
  const StructureRay structure = structure_ray(direction, 0.5 * (near_m + far_m), near_m);
  const float aside = min(kPixelPoint * structure.pixel_m * sqrt(step2), 0.25);  // in radii
  const float skin = structure_skin(p.structure_depth), broad_depth = structure_broad_depth(p.structure_depth);
  float sum = 0.0, first = 0.0, second = 0.0;  // moments of matter along the ray, from near_m
  float difference = 0.0;                      // of the larger ball's and the smaller one's
  for (float t = 0.0; t < far_m - near_m && sum * p.extinction_per_m < kOpaqueDepth; t += step_m) {
    const float length_m = min(step_m, far_m - near_m - t), at = t + 0.5 * length_m;
    const float at_m = near_m + at, from_mid_m = at_m - chord.mid_m;
    float density = 0.0;
    const float r2 = chord.b2 + from_mid_m * from_mid_m * step2;
    const bool soft = kSoftParticles && p.soft_detail >= 0.0;
    if (p.structure_depth > 0.0) {
      const float radius = displaced_radius(p.structure_depth, structure_on(structure, at_m),
                                            broad_structure_on(structure, at_m, broad_depth));
      const float larger = structured_density(r2, min(radius + aside, 1.0), skin);
      const float smaller = structured_density(r2, max(radius - aside, 0.05), skin);
      density = 0.5 * (larger + smaller);
      difference += (larger - smaller) * base_fade(base_near_m + climb * at) * length_m;
    }
    if (soft)
      density = particle_profile(max(1.0 - r2, 0.0), 0u) * soft_variation(p.soft_detail, structure_on(structure, at_m));
    if (kSmoothParticles && p.structure_depth <= 0.0 && !soft)
      density = density_in_particle(chord.start + (at_m - chord.along_m) * chord.step);
    const float matter = density * base_fade(base_near_m + climb * at) * length_m;
    sum += matter;
    first += matter * at;
    second += matter * (at * at + length_m * length_m * (1.0 / 12.0));
  }
  if (sum <= 0.0) return 0.0;
  const float middle = first / sum, half_m = sqrt(max(3.0 * (second / sum - middle * middle), 1e-4));
  far_m = min(near_m + middle + half_m, far_m);
  near_m = max(near_m + middle - half_m, near_m);
  const float half_apart = 0.5 * p.extinction_per_m * abs(difference), depth = p.extinction_per_m * sum;
  // depth - log(cosh(half_apart)), whose cosh is too large for a float in dense matter.
  return (depth - half_apart - log(0.5 + 0.5 * exp(-2.0 * half_apart))) / (far_m - near_m);
}

// The particle's visible segment along the ray up to limit_m; false when there is none.
bool shade_particle(DrawParticle p, vec3 direction, float limit_m, out BlendSegment segment) {
  segment = blend_no_segment();
  float along = dot(p.center_m, direction);
  vec3 start = p.reference_from_render * (along * direction - p.center_m);
  vec3 step = p.reference_from_render * direction;
  float mid, half_chord;
  if (!intersect_unit_sphere(start, step, mid, half_chord)) return false;
  float chord_near = along + mid - half_chord;
  float chord_far = along + mid + half_chord;
  float near_m = max(chord_near, 0.0);
  float far_m = min(chord_far, limit_m);
  if (far_m <= near_m) return false;

  const vec3 closest = start + mid * step;
  const vec3 entry = normalize(closest - half_chord * step), exit = normalize(closest + half_chord * step);
  const float h = min(half_chord * length(step), 1.0);
  const bool homogeneous = (p.flags & kParticleHomogeneous) != 0u;
  // Particles that the air's structure varies are sampled along the chord.
  const bool structured = p.structure_depth > 0.0 || (kSoftParticles && p.soft_detail >= 0.0);
  // What the table knows of the chord.
  float density = p.extinction_per_m;
  if (kSmoothParticles && !homogeneous && !structured) {
    const vec2 matter = fetch_matter(entry, exit);
    const float matter_near = chord_near + matter.y * 2.0 * half_chord;
    density = matter.x * p.extinction_per_m * 2.0 * half_chord / max(chord_far - matter_near, 1e-3 * half_chord);
    near_m = max(near_m, matter_near);
  }
  float thinning = 1.0;
  if (far_m <= near_m || density <= 0.0) return false;
  if (has_base(p.base_m) && !cut_at_base(p.base_m, direction, near_m, far_m, thinning)) return false;
  if (homogeneous) {
    density *= thinning;
  } else {
    // A chord of which a part is hidden has not that part's share of its matter: what is left is measured, and so is
    // what has structure.
    const bool whole = chord_near >= 0.0 && far_m >= chord_far && thinning > 0.9999;
    const float length_m = far_m - near_m;
    const float away = smoothstep(0.0, kNearM, near_m);
    const float step_m = structured
                             ? clamp(mix(kNearStepM, kStepM, away),
                                     length_m / mix(kMostNearSamples, kMostSamples, away), length_m / kFewestSamples)
                             : length_m / (chord_near < 0.0 ? kInsideSamples : kCutSamples) + 1e-6 * far_m;
    if (structured || !whole)
      density = measured_extinction(p, UnitChord(start, step, along, along + mid, dot(closest, closest)), direction,
                                    step_m, near_m, far_m);
  }
  if (density <= 0.0) return false;

  segment.extinction_per_m = density;
  segment.near_m = near_m;
  segment.far_m = far_m;
  if ((p.flags & kParticleEmissive) != 0u) {
    segment.radiance = p.radiance_per_sr;
    return true;
  }
  if (density * (far_m - near_m) < 1e-4) return false;  // not worth its light
  float at_m = near_m + min(1.0 / density, 0.5 * (far_m - near_m));
  segment.radiance = kLightField
                         ? radiance_from_field(p, direction, at_m)
                         : radiance_from_tables(p, direction, at_m, entry, h, dot(p.light_direction, -normalize(step)),
                                                density * 2.0 * half_chord);
  return true;
}

#endif
