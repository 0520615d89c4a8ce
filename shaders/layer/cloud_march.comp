// The ray marcher: a pixel's ray through the sum of the particles' own density, in steps. The baseline that users would
// pick instead of particles shaded whole; light, phase function and sky are theirs, so what differs is the integration.
//
// After: Jimenez de Parga and Gomez Palomo, Efficient Algorithms for Real-Time GPU Volumetric Cloud Rendering with
// Enhanced Geometry (2018): candidates of a tile sorted along the ray, no place traced twice, none in gaps; Kobak and
// Alda, Modeling and Rendering of Convective Cumulus Clouds for Real-Time Graphics Purposes (2017), 6.3.3: jittered
// steps, early end (march_reconstruct.comp takes their noise out). What the former keeps in a voxel grid, light traced
// once and not from each sample, is kept by particle here: its depth towards the sun and how that varies inside it
// (occlusion.comp).
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "kit/texels.glsl"
#include "shared/blend.h"
#include "shared/cloud_light.h"
#include "shared/ellipsoid.h"
#include "shared/flat_base.h"
#include "shared/light.h"
#include "shared/reference_particle.h"
#include "shared/screen_bounds.h"
#include "shared/world.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint kSteps = 64u;
layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
DRAW_PARTICLES(1, draw_particles);
layout(scalar, set = 0, binding = 2) readonly buffer Ranges { uvec2 ranges[]; };
WORDS(3, list);    // a tile's particles, nearest first
WORDS(4, near_m);  // no point of the particle is nearer
layout(set = 0, binding = 17) uniform sampler3D multiple_table;
layout(set = 0, binding = 18) uniform sampler3D structure_tile_volume;
layout(set = 0, binding = 19) uniform sampler3D particle_density;
layout(set = 0, binding = 7) uniform sampler2D layer_scene;  // metres to what stands behind
layout(scalar, set = 0, binding = 8) buffer Counters { FrameCounters counters; };
layout(set = 0, binding = 9, rgba32f) writeonly uniform image2D marched;    // premultiplied radiance, transmittance
layout(set = 0, binding = 10, r32f) writeonly uniform image2D layer_depth;  // metres to the first matter, +inf
layout(set = 0, binding = 12,
       rgba16f) writeonly uniform image2D marched_noise;  // deviations of transmittance and luminance
WORDS(11, pixels);                                        // that the particle may cover

#include "kit/camera_rays.glsl"
#include "layer/driver_limit.glsl"
#include "layer/march_noise.glsl"
#include "layer/field_light.glsl"
#include "layer/density_fetch.glsl"
#include "layer/particle_light.glsl"
#include "layer/structure_fetch.glsl"

// A ray takes kSteps steps across eight particle diameters. Steps grow with the particles, which double in size from
// ring to ring of the grid.
const float kStepsThroughDiameters = 8.0;

// A particle as one ray sees it.
struct Candidate {
  vec3 start, step;  // reference space: start + t * step
  float near_m, far_m;
  float extinction_per_m, base_m;
  float step_m;
  float structure_depth, soft_detail;
  bool homogeneous;
  vec3 to_sun;                           // unit, reference space
  float sun_radius_m;                    // of the ellipsoid along the sun's rays
  float tau_begin, tau_per_m, tau_mean;  // towards the sun through the others: linear along the ray
  float own_depth_share;                 // as in DrawParticle
  float multiple_per_sr;                 // light scattered more than once inside the particle, per unit irradiance
  vec3 sun_irradiance;                   // 0 where matter is emissive
  vec3 ambient;                          // radiance of sky and ground in it, or its own
  vec3 field_begin, field_per_m;         // the ray in the light field's volume
};

// Fills in what the particle's light is on this ray; what of it varies along the ray, add_candidate finds at each
// place.
void light_candidate(DrawParticle p, vec3 direction, vec3 closest, float half_chord, inout Candidate c) {
  c.sun_irradiance = vec3(0.0);
  c.multiple_per_sr = 0.0;
  c.tau_mean = 0.0;
  c.own_depth_share = 0.0;
  c.field_begin = c.field_per_m = vec3(0.0);
  c.ambient = p.radiance_per_sr;
  if ((p.flags & kParticleEmissive) != 0u) return;

  const vec3 towards_sun = p.reference_from_render * frame.sun_direction;
  c.sun_radius_m = 1.0 / length(towards_sun);
  c.to_sun = towards_sun * c.sun_radius_m;
  c.sun_irradiance = p.sun_irradiance;
  c.tau_mean = p.tau_sun;
  c.tau_per_m = dot(p.tau_gradient_per_m, direction);
  c.tau_begin = p.tau_sun - dot(p.tau_gradient_per_m, p.center_m);
  c.ambient = p.ambient_radiance;
  if (kLightField) {
    c.own_depth_share = p.own_depth_share;
    c.field_begin = p.field_place - p.center_m * field_scale_per_m(p);
    c.field_per_m = direction * field_scale_per_m(p);
  } else {
    const vec3 entry = normalize(closest - half_chord * c.step);
    c.multiple_per_sr = multiple_inside_per_sr(p, entry, min(half_chord * length(c.step), 1.0),
                                               dot(p.light_direction, -normalize(c.step)));
  }
}

// False where the ray misses the particle, or has it all behind `from_m` or beyond `limit_m`.
bool make_candidate(uint particle, vec3 direction, float from_m, float limit_m, out Candidate c) {
  const DrawParticle p = draw_particle_at(draw_particles, particle);
  const float along = dot(p.center_m, direction);
  c.step = p.reference_from_render * direction;
  const vec3 nearest = p.reference_from_render * (along * direction - p.center_m);
  float mid, half_chord;
  if (!intersect_unit_sphere(nearest, c.step, mid, half_chord)) return false;
  c.near_m = max(along + mid - half_chord, 0.0);
  c.far_m = min(along + mid + half_chord, limit_m);
  if (c.far_m <= max(from_m, c.near_m)) return false;
  c.start = nearest - along * c.step;
  c.extinction_per_m = p.extinction_per_m;
  c.base_m = p.base_m;
  c.structure_depth = p.structure_depth;
  c.soft_detail = p.soft_detail;
  c.homogeneous = (p.flags & kParticleHomogeneous) != 0u;
  c.step_m = kStepsThroughDiameters * 2.0 / (float(kSteps) * length(c.step));
  light_candidate(p, direction, nearest + mid * c.step, half_chord, c);
  return true;
}

// The sums over all particles at one place of the ray.
struct Sample {
  float extinction_per_m, lit_per_m;                        // of all particles; of those that are not emissive
  float varying_per_m;                                      // of the particles that are not homogeneous
  float tau, tau_inside, own_depth_share, multiple_per_sr;  // weighted by lit extinction
  vec3 sun_irradiance, ambient;                             // weighted by extinction
  vec3 field_place;                                         // in the light field's volume
  bool matter;
};

// noise: the air's structure there, and its broad form.
void add_candidate(Candidate c, float at_m, float altitude, vec2 noise, inout Sample s) {
  if (at_m < c.near_m || at_m > c.far_m) return;
  const vec3 p = c.start + at_m * c.step;
  float density =
      c.homogeneous          ? 1.0
      : c.soft_detail >= 0.0 ? particle_profile(max(1.0 - dot(p, p), 0.0), 0u) * soft_variation(c.soft_detail, noise.x)
      : c.structure_depth > 0.0 ? structured_density(dot(p, p), displaced_radius(c.structure_depth, noise.x, noise.y),
                                                     structure_skin(c.structure_depth))
                                : density_in_particle(p);
  if (has_base(c.base_m)) density *= base_fade(altitude - c.base_m);
  if (density <= 0.0) return;
  s.matter = s.matter || density > kFirstMatterDensity;
  const float w = density * c.extinction_per_m;
  s.extinction_per_m += w;
  if (!c.homogeneous) s.varying_per_m += w;
  s.ambient += w * c.ambient;
  const bool lit = kLightField ? c.field_per_m != vec3(0.0) : c.sun_irradiance != vec3(0.0);
  if (!lit) return;
  s.lit_per_m += w;
  s.sun_irradiance += w * c.sun_irradiance;
  s.multiple_per_sr += w * c.multiple_per_sr;
  s.field_place = c.field_begin + at_m * c.field_per_m;
  s.own_depth_share += w * c.own_depth_share;
  s.tau += w * linear_depth(c.tau_mean, c.tau_begin + c.tau_per_m * at_m - c.tau_mean);
  // The particle's own depth from here towards the sun, by its mean profile.
  const float along = dot(p, c.to_sun), h2 = max(1.0 - dot(p, p) + along * along, 0.0);
  const uint flags = c.homogeneous ? kParticleHomogeneous : 0u;
  s.tau_inside += w * c.extinction_per_m * c.sun_radius_m *
                  max(profile_integral(sqrt(h2), h2, flags) - profile_integral(along, h2, flags), 0.0);
}

// Source radiance of all matter at the place. Emissive matter counts as lit by its own light alone.
vec3 sample_radiance(Sample s, float mu) {
  const vec3 ambient_radiance = s.ambient / s.extinction_per_m;
  if (!(s.lit_per_m > 0.0)) return ambient_radiance;
  const float once_per_sr = phase_per_sr(frame.phase_function, mu, frame.phase_g);
  const float own_depth = (s.tau + s.tau_inside) / s.lit_per_m;
  if (kLightField) {
    const vec4 seen = textureLod(light_radiance, s.field_place, 0.0);
    const float tau = mix(seen.a, own_depth, s.own_depth_share / s.lit_per_m);
    return ambient_radiance +
           s.lit_per_m / s.extinction_per_m *
               source_radiance_in_field(s.sun_irradiance / s.lit_per_m, mu, once_per_sr, tau, seen.rgb);
  }
  TableLight light;
  light.sun_irradiance = s.sun_irradiance / s.extinction_per_m;
  light.ambient_radiance = ambient_radiance;
  light.tau_sun = s.tau / s.lit_per_m;
  light.once_per_sr = once_per_sr * exp(-own_depth);
  light.again_per_sr = s.multiple_per_sr / s.lit_per_m;
  return table_source_radiance(light);
}

// Interleaved gradient noise (Jimenez, Next Generation Post Processing in Call of Duty: Advanced Warfare, 2014): nine
// neighbouring pixels have nine well spread values.
float jitter_of(uvec2 pixel) { return fract(52.9829189 * fract(dot(vec2(pixel), vec2(0.06711056, 0.00583715)))); }

// The first place from `at` on whose particle may cover the pixel, or may begin beyond until_m: cheap loads only, so
// that the threads of a batch meet their candidates together.
uint next_place(uint at, uint end, float until_m, uvec2 pixel) {
  for (; at < end && float_at(near_m, word_at(list, at)) <= until_m; ++at) {
    const uvec2 covered = two_words_at(pixels, word_at(list, at)), low = rectangle_low(covered);
    if (all(greaterThanEqual(pixel, low)) && all(lessThan(pixel, rectangle_high(covered)))) break;
  }
  return at;
}

const uint kOpen = 24u;

void main() {
  const uvec2 pixel = gl_GlobalInvocationID.xy;
  if (any(greaterThanEqual(pixel, frame.layer_size_px))) return;
  const uvec2 range = ranges[gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x];
  const vec3 direction = pixel_direction((vec2(pixel) + 0.5) * float(frame.scale), frame.image_size_px);
  const float limit_m = texelFetch(layer_scene, ivec2(pixel), 0).x;
  const float mu = dot(frame.sun_direction, direction), jitter = jitter_of(pixel);

  // A sample stands for its step, in which it lies anywhere: between two samples apart by d that is off by d / sqrt(12)
  // or so. Homogeneous matter alone has no noise, for steps end at its borders.
  const float kVariance = 1.0 / 12.0;
  float before_per_m = 0.0,
        before_luminance = -1.0;  // of the sample before: varying extinction, source luminance; below 0: none
  float depth_variance = 0.0, luminance_variance = 0.0;
  vec3 radiance = vec3(0.0);
  float transmittance = 1.0, first_m = kNoMatterM, t = 0.0;
  Candidate open[kOpen];  // met, and not yet left behind
  uint open_count = 0u, place = range.x, lookups = 0u;
  while (transmittance > kOpaqueTransmittance && t < limit_m) {
    uint kept = 0u;
    for (uint i = 0u; i < open_count; ++i)
      if (open[i].far_m > t) {
        if (kept != i) open[kept] = open[i];
        ++kept;
      }
    open_count = kept;
    while (open_count < kOpen) {
      place = next_place(place, range.y, t, pixel);
      if (place == range.y || float_at(near_m, word_at(list, place)) > t) break;
      Candidate c;
      if (make_candidate(word_at(list, place++), direction, t, limit_m, c)) open[open_count++] = c;
    }

    // The step: as fine as the finest particle here needs, and up to the borders of homogeneous ones, where matter
    // jumps. Others begin with next to nothing.
    float next_m = place < range.y ? float_at(near_m, word_at(list, place)) : kNoMatterM;
    float end_m = kNoMatterM;
    bool inside = open_count == kOpen;  // then also of what has found no slot
    for (uint i = 0u; i < open_count; ++i) {
      next_m = open[i].near_m > t ? min(next_m, open[i].near_m) : next_m;
      inside = inside || open[i].near_m <= t;
      if (open[i].near_m <= t || open_count == kOpen) end_m = min(end_m, t + open[i].step_m);
      if (open[i].homogeneous) end_m = min(end_m, open[i].near_m > t ? open[i].near_m : open[i].far_m);
    }
    if (!inside) {
      if (next_m >= kNoMatterM) break;
      t = next_m;
      before_per_m = 0.0;
      before_luminance = -1.0;
      continue;
    }
    while (open_count < kOpen) {
      place = next_place(place, range.y, end_m, pixel);
      if (place == range.y || float_at(near_m, word_at(list, place)) > end_m) break;
      Candidate c;
      if (!make_candidate(word_at(list, place++), direction, t, limit_m, c)) continue;
      open[open_count++] = c;
      if (c.homogeneous && c.near_m > t) end_m = min(end_m, c.near_m);
    }
    end_m = max(min(end_m, limit_m), t + max(1e-6, 2e-7 * t));  // never without moving on
    const float at_m = mix(t, end_m, jitter);
    const float altitude = altitude_m(direction * at_m, frame.camera_grid_m.z);
    const StructureRay structure = structure_ray(direction, at_m, at_m);
    const vec2 noise = vec2(structure_on(structure, at_m), broad_structure_on(structure, at_m, 1.0));
    Sample s = Sample(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, vec3(0.0), vec3(0.0), vec3(0.0), false);
    for (uint i = 0u; i < open_count; ++i) add_candidate(open[i], at_m, altitude, noise, s);
    lookups += open_count;
    // What has begun without finding a slot is met anew at every sample: slow, and complete.
    for (uint i = place; i < range.y && float_at(near_m, word_at(list, i)) <= at_m; ++i) {
      Candidate c;
      if (make_candidate(word_at(list, i), direction, t, limit_m, c)) add_candidate(c, at_m, altitude, noise, s);
      ++lookups;
    }
    if (s.extinction_per_m > 0.0) {
      const float opacity = opacity_of(s.extinction_per_m * (end_m - t));
      const vec3 source = sample_radiance(s, mu);
      const float luminance = luminance_of(source);
      const float apart = (s.varying_per_m - before_per_m) * (end_m - t);
      const float changes = before_luminance >= 0.0 && max(s.varying_per_m, before_per_m) > 0.0 ? 1.0 : 0.0;
      const vec2 luminance_apart =
          transmittance * vec2((1.0 - opacity) * luminance * apart, changes * opacity * (luminance - before_luminance));
      depth_variance += kVariance * apart * apart;
      luminance_variance += kVariance * dot(luminance_apart, luminance_apart);
      before_luminance = luminance;
      radiance += transmittance * opacity * source;
      transmittance *= 1.0 - opacity;
      if (s.matter) first_m = min(first_m, at_m);
    }
    before_per_m = s.varying_per_m;
    t = end_m;
  }
  imageStore(marched_noise, ivec2(pixel),
             vec4(transmittance * sqrt(depth_variance), sqrt(luminance_variance), 0.0, 0.0));
  imageStore(marched, ivec2(pixel), vec4(radiance, transmittance));
  imageStore(layer_depth, ivec2(pixel), vec4(first_m < kNoMatterM ? first_m : uintBitsToFloat(0x7f800000u)));
  if (lookups > 0u) atomicAdd(counters.pairs_shaded, lookups);
  if (loops_were_ended(1u + frame.scale)) atomicAdd(counters.rays_cut_short, 1u);
}
