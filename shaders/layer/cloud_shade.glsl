// Shading of one particle along one ray: geometry, optical depth, light, as a segment to be blended.
// The including shader declares: FrameConstants frame, sampler3D multiple_table, detail_noise, and either sampler3D
// optical_depth_table or, packed_table_fetch.glsl.
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
  thinning = base_fade(0.5 * (above_near + above_far));
  return far_m > near_m;
}

// Source radiance of the segment of optical depth tau_chord, lit as it is at_m metres from the camera, along the chord
// of half length h in the unit sphere.
vec3 segment_radiance(DrawParticle p, vec3 direction, float at_m, vec3 entry, float h, float mu_unit, float tau_chord) {
  const vec3 from_center_m = direction * at_m - p.center_m;
  const float mu = dot(frame.sun_direction, direction);
  const float c = dot(entry, p.light_direction);
  PlaceLight light;
  light.sun_irradiance = p.sun_irradiance;
  // The depth through the others varies linearly; the cloud around has its share in it everywhere.
  light.tau_sun = linear_depth(p.tau_sun, dot(p.tau_gradient_per_m, from_center_m));
  light.tau_near = p.tau_near * (light.tau_sun / max(p.tau_sun, 1e-6));
  light.tau_cloud = light.tau_near + p.tau_behind + kMeanChord * p.optical_radius;
  light.outward = p.outward;
  // Scattered once: in a homogeneous sphere whose density gives this chord its depth.
  const float sigma_ray = tau_chord / max(2.0 * h, 1e-3);
  const float self = single_scattering(c, h, mu_unit, sigma_ray) / max(opacity_of(tau_chord), 1e-6);
  light.tau_self = -log(clamp(self, 1e-4, 1.0));
  light.once_per_sr = phase_per_sr(frame.phase_function, mu, frame.phase_g) * self * exp(-light.tau_sun);
  light.again_share = kAgainShare;
  light.again_per_sr = multiple_inside_per_sr(p, entry, h, mu_unit);
  light.ambient_radiance = ambient_radiance(p, from_center_m.z, direction.z);
  return source_radiance(light, mu, frame.phase_g);
}

// The reference particle along the chord between two points of the unit sphere, as fetch_optical_depth gives it.
vec2 fetch_matter(vec3 entry, vec3 exit) {
#ifdef PACKED_TABLE
  return fetch_packed_optical_depth(entry, exit);
#else
  return fetch_optical_depth(optical_depth_table, entry, exit);
#endif
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
  if (chord_near < 0.0 || far_m < chord_far) {  // from within, or cut by what stands behind
    vec3 at = (vec3(matter_near, near_m, far_m) - (along + mid)) * length(step);
    density = tau_chord * chord_share(at.x, at.y, at.z, h * h, p.flags) / (far_m - near_m);
    if (density <= 0.0) return false;
  }
  if (has_base(p.base_m) && !cut_at_base(p.base_m, direction, near_m, far_m, thinning)) return false;
  density *= thinning;

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
  float mu_unit = dot(p.light_direction, -normalize(step));
  segment.radiance = relief * segment_radiance(p, direction, at_m, entry, h, mu_unit, density * 2.0 * half_chord);
  return true;
}

#endif
