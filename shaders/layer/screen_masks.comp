// The pixels in which each place of the screen tiles' lists may show. One thread a place.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/screen_bounds.h"
#include "kit/pair_dispatch.glsl"
#include "kit/texels.glsl"

layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
DRAW_PARTICLES(1, draw_particles);
layout(scalar, set = 0, binding = 2) readonly buffer Counters { FrameCounters counters; };
WORDS(3, tiles);
WORDS(4, list);
WORDS(5, pixels);
layout(scalar, set = 0, binding = 6) writeonly buffer Masks { uvec2 masks[]; };
layout(push_constant) uniform Push { uint tile_columns; };

void main() {
  const uint place = pair_of_thread();
  if (place >= counters.screen_pair_count) return;
  const uint particle = word_at(list, place), tile = word_at(tiles, place);
  const DrawParticle p = draw_particle_at(draw_particles, particle);
  const uvec2 rectangle = two_words_at(pixels, particle), at = uvec2(tile % tile_columns, tile / tile_columns);
  const BaseBound above = bound_above_base(p.reference_from_render, p.center_m, p.base_m, frame.camera_grid_m.z);
  masks[place] = tile_mask(frame.clip_from_render, frame.render_from_clip, p.reference_from_render, p.center_m,
                           rectangle, at, frame.image_size_px, frame.scale, frame.layer_size_px) &
                 tile_mask(frame.clip_from_render, frame.render_from_clip, above.reference_from_render, above.center_m,
                           rectangle, at, frame.image_size_px, frame.scale, frame.layer_size_px);
}
