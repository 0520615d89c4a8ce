// The pixels in which each place of the screen tiles' lists may show. One thread a place.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/screen_bounds.h"
#include "shared/types.h"

layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
layout(scalar, set = 0, binding = 1) readonly buffer DrawParticles { DrawParticle draw_particles[]; };
layout(scalar, set = 0, binding = 2) readonly buffer Counters { FrameCounters counters; };
layout(scalar, set = 0, binding = 3) readonly buffer Tiles { uint tiles[]; };
layout(scalar, set = 0, binding = 4) readonly buffer List { uint list[]; };
layout(scalar, set = 0, binding = 5) readonly buffer Pixels { uvec2 pixels[]; };
layout(scalar, set = 0, binding = 6) writeonly buffer Masks { uvec2 masks[]; };
layout(push_constant) uniform Push { uint tile_columns; };

void main() {
  const uint place = gl_GlobalInvocationID.x;
  if (place >= counters.screen_pair_count) return;
  const uint particle = list[place];
  const vec3 center_m = draw_particles[particle].center_m;
  const mat3 reference_from_render = draw_particles[particle].reference_from_render;
  const float shown = shown_radius((draw_particles[particle].flags & kParticleDetail) != 0u, reference_from_render * center_m);
  masks[place] = tile_mask(frame.clip_from_render, frame.render_from_clip, reference_from_render / shown, center_m, pixels[particle],
                           uvec2(tiles[place] % tile_columns, tiles[place] / tile_columns), frame.image_size_px, frame.scale, frame.layer_size_px);
}
