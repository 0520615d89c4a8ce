// Shades and blends one screen tile's particles: a thread a pixel, its state in registers, no shared memory.
// variants: volume=BLEND_VOLUME
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/screen_bounds.h"
#include "shared/types.h"

layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
layout(scalar, set = 0, binding = 1) readonly buffer DrawParticles { DrawParticle draw_particles[]; };
layout(set = 0, binding = 2) uniform sampler3D optical_depth_table;
layout(set = 0, binding = 3) uniform sampler3D multiple_table;
layout(set = 0, binding = 4) uniform sampler3D detail_noise;
layout(scalar, set = 0, binding = 5) readonly buffer Ranges { uvec2 ranges[]; };
layout(scalar, set = 0, binding = 6) readonly buffer List { uint list[]; };
layout(scalar, set = 0, binding = 7) readonly buffer Begins { float begins_m[]; };
layout(scalar, set = 0, binding = 8) buffer Counters { FrameCounters counters; };
layout(set = 0, binding = 9, rgba32f) writeonly uniform image2D layer_color;  // premultiplied radiance, transmittance
layout(set = 0, binding = 10, r32f) writeonly uniform image2D layer_depth;    // metres to the first matter, +inf

#include "cloud_shade.glsl"

struct LayerPixel {
  vec3 radiance;  // premultiplied
  float transmittance;
  float first_m;
};

bool meets(uint particle, vec3 direction) {
  const vec3 center_m = draw_particles[particle].center_m;
  const mat3 reference_from_render = draw_particles[particle].reference_from_render;
  float mid, half_chord;
  return intersect_unit_sphere(reference_from_render * (dot(center_m, direction) * direction - center_m), reference_from_render * direction, mid, half_chord);
}

// The first place from `at` on whose particle the ray meets.
uint next_met(uint at, uint end, vec3 direction) {
  while (at < end && !meets(list[at], direction)) ++at;
  return at;
}

#ifdef BLEND_VOLUME
// blend.h folds from back to front. So first the ray is followed forward, densities only, until it is opaque and
// nothing later in the list can begin in front of that point; then what was passed is shaded on the way back.
LayerPixel blend_list(uvec2 range, vec3 direction, float limit_m, inout uint shaded) {
  const float opaque_depth = -log(kOpaqueTransmittance);
  float depth = 0.0, opaque_m = 0.0;
  uint end = range.x;
  BlendSegment segment;
  for (uint i = next_met(range.x, range.y, direction); i < range.y; i = next_met(i + 1u, range.y, direction)) {
    if (depth >= opaque_depth && begins_m[i] >= opaque_m) break;
    end = i + 1u;
    if (shade_particle(draw_particles[list[i]], direction, limit_m, segment)) {
      if (depth < opaque_depth) opaque_m = max(opaque_m, segment.far_m);
      depth += segment.extinction_per_m * (segment.far_m - segment.near_m);
    }
  }
  BlendState state = blend_empty();
  for (uint i = end; i > range.x;) {
    do --i; while (i > range.x && !meets(list[i], direction));
    if (shade_particle(draw_particles[list[i]], direction, limit_m, segment)) {
      blend_add(state, segment);
      ++shaded;
    }
  }
  blend_finish(state);
  return LayerPixel(state.committed, state.transmittance, state.first_m);
}
#endif

void main() {
  const uint lane = gl_LocalInvocationID.x;
  const uvec2 in_tile = uvec2((lane & 3u) | ((lane >> 1u) & 4u), ((lane >> 2u) & 1u) | ((lane >> 3u) & 6u));
  const uvec2 pixel = gl_WorkGroupID.xy * kScreenTilePx + in_tile;
  const bool inside = all(lessThan(pixel, frame.layer_size_px));
  uvec2 range = ranges[gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x];
  if (!inside) range = uvec2(0u);
  const vec3 direction = pixel_direction((vec2(pixel) + 0.5) * float(frame.scale), frame.image_size_px);
  uint shaded = 0u;
  const LayerPixel result = blend_list(range, direction, ground_distance_m(direction), shaded);
  if (!inside) return;
  if (shaded > 0u) atomicAdd(counters.pairs_shaded, shaded);
  imageStore(layer_color, ivec2(pixel), vec4(result.radiance, result.transmittance));
  imageStore(layer_depth, ivec2(pixel), vec4(result.first_m < kNoMatterM ? result.first_m : uintBitsToFloat(0x7f800000u)));
}
