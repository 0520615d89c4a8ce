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
#include "layer/table_fetch.glsl"

// Fine structure at the first matter: tiling noise in the air's frame, two periods that never line up. It gives the
// smooth particles of the optical depth table their ragged outlines.
NEPHELE_CONST(float, kDetailMean, 0.5);  // mean of the noise
NEPHELE_CONST(float, kErosion, 0.1);     // mean of Detail.erosion

struct Detail {
  float erosion;  // chords of a lower mean density (over the peak) are empty
  float relief;   // factor of the radiance: bumps that face the sun are brighter
};

NEPHELE_CONST(float, kDetailCoarse, 589.0 / 94208.0);  // tiles per metre: a whole number a grid unit (world.h)
NEPHELE_CONST(float, kDetailFine, 1812.0 / 94208.0);
NEPHELE_CONST(float, kRelief, 147.0 / 94208.0);
NEPHELE_CONST(float, kReliefStepM, 45.0);

Detail detail_at(vec3 p_render, float distance_m) {
  vec3 p = vec3(frame.camera_grid_m.xy, frame.camera_grid_m.z) + p_render;
  vec3 fine_p = vec3(p.y, p.z, p.x) * kDetailFine;
  // A pixel wider than the structure would see it alias: it fades to its mean first.
  float pixel_m =
      distance_m * 2.0 /
      (length(vec3(frame.clip_from_render[0][1], frame.clip_from_render[1][1], frame.clip_from_render[2][1])) *
       float(frame.layer_size_px.y));
  // From within, a cloud is plain fog: structure at arm's length would be contour lines of the particles' tables.
  float beyond = smoothstep(40.0, 300.0, distance_m);
  float coarse_share = beyond * (1.0 - smoothstep(6.0, 24.0, pixel_m));
  float fine_share = beyond * (1.0 - smoothstep(2.0, 8.0, pixel_m));
  float lump_share = beyond * (1.0 - smoothstep(25.0, 100.0, pixel_m));
  Detail detail = Detail(kErosion, 1.0);
  if (lump_share > 0.0) {
    float lump = textureLod(detail_noise, p * kRelief, 0.0).x;
    float sunward = textureLod(detail_noise, (p + kReliefStepM * frame.sun_direction) * kRelief, 0.0).x;
    float coarse = coarse_share > 0.0 ? textureLod(detail_noise, p * kDetailCoarse, 0.0).x - kDetailMean : 0.0;
    float fine = fine_share > 0.0 ? textureLod(detail_noise, fine_p, 0.0).x - kDetailMean : 0.0;
    float noise = 0.5 * lump_share * (lump - kDetailMean) + 0.35 * coarse_share * coarse + 0.15 * fine_share * fine;
    detail.relief = clamp(1.0 + lump_share * 0.45 * (lump - sunward) + 0.2 * coarse_share * coarse, 0.6, 1.4);
    detail.erosion = kErosion * clamp(1.0 - 7.0 * noise, 0.1, 2.5);
  }
  return detail;
}

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
  return others + p.extinction_per_m * sun_radius_m * max(self, 0.0);
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

// Samples of the density along a chord of which the eye or a base hides a part. From within they show the noise between
// the eye and the far side at its true size; three more than three along a cut chord took overcast skies' relMSE from
// .0151 to .0141 and a tenth more of the layer's time.
const uint kInsideSamples = 12u, kCutSamples = 3u;

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

  vec3 closest = start + mid * step;
  vec3 entry = normalize(closest - half_chord * step);
  vec3 exit = normalize(closest + half_chord * step);
  float h = min(half_chord * length(step), 1.0);
  if ((p.flags & kParticleDetail) != 0u && h < kRimFrom) return false;  // the detail erodes what little is there
  bool homogeneous = (p.flags & kParticleHomogeneous) != 0u;
  vec2 matter = homogeneous ? vec2(1.0, 0.0) : fetch_matter(entry, exit);
  float tau_chord = matter.x * p.extinction_per_m * 2.0 * half_chord;
  float matter_near = chord_near + matter.y * 2.0 * half_chord;
  float density = tau_chord / max(chord_far - matter_near, 1e-3 * half_chord);
  near_m = max(near_m, matter_near);
  float thinning = 1.0;
  if (far_m <= near_m || density <= 0.0) return false;
  if (has_base(p.base_m) && !cut_at_base(p.base_m, direction, near_m, far_m, thinning)) return false;
  if (homogeneous) {
    density *= thinning;
  } else {
    // A chord of which a part is hidden has not that part's share of its matter: what is left is measured. (A loop of
    // no round where the whole chord is seen: a CPU leaves it out for eight threads.)
    const bool whole = chord_near >= 0.0 && far_m >= chord_far && thinning > 0.9999;
    const uint samples = whole ? 0u : (chord_near < 0.0 ? kInsideSamples : kCutSamples);
    float sum = 0.0;
    for (uint i = 0u; i < samples; ++i) {
      const float at_m = mix(near_m, far_m, (float(i) + 0.5) / float(samples));
      const float above_base_m = altitude_m(direction * at_m, frame.camera_grid_m.z) - p.base_m;
      sum += base_fade(above_base_m) * density_in_particle(start + step * (at_m - along));
    }
    density = whole ? density : p.extinction_per_m * sum / float(samples);
  }
  if (density <= 0.0) return false;

  float relief = 1.0;
  if ((p.flags & kParticleDetail) != 0u) {
    float at_m = near_m + min(1.0 / density, 0.5 * (far_m - near_m));
    Detail detail = detail_at(direction * at_m, at_m);
    density *= smoothstep(0.5 * detail.erosion, 1.5 * detail.erosion, matter.x);
    relief = detail.relief;
    if (density <= 0.0) return false;
  }
  segment.extinction_per_m = density;
  segment.near_m = near_m;
  segment.far_m = far_m;
  if ((p.flags & kParticleEmissive) != 0u) {
    segment.radiance = p.radiance_per_sr;
    return true;
  }
  if (density * (far_m - near_m) < 1e-4) return false;  // not worth its light
  float at_m = near_m + min(1.0 / density, 0.5 * (far_m - near_m));
  segment.radiance = relief * (kLightField ? radiance_from_field(p, direction, at_m)
                                           : radiance_from_tables(p, direction, at_m, entry, h,
                                                                  dot(p.light_direction, -normalize(step)),
                                                                  density * 2.0 * half_chord));
  return true;
}

#endif
