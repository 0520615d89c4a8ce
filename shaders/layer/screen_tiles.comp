// Every drawn particle as the screen sees it: the pixels and tiles it may cover, how near it can come, and its place in
// the lists, which run from front to back.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/screen_bounds.h"
#include "kit/texels.glsl"

layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
DRAW_PARTICLES(1, draw_particles);
layout(scalar, set = 0, binding = 2) readonly buffer Counters { FrameCounters counters; };
layout(scalar, set = 0, binding = 3) writeonly buffer Rectangles { uvec2 rectangles[]; };
layout(scalar, set = 0, binding = 4) writeonly buffer Nears { float near_m[]; };
layout(scalar, set = 0, binding = 5) writeonly buffer Order { uint order[]; };
layout(scalar, set = 0, binding = 6) writeonly buffer Pixels { uvec2 pixels[]; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= counters.visible_count) return;
  const DrawParticle p = draw_particle_at(draw_particles, i);
  const vec3 center_m = p.center_m;
  const mat3 render_from_reference = inverse(p.reference_from_render);
  const BaseBound above = bound_above_base(p.reference_from_render, center_m, p.base_m, frame.camera_grid_m.z);
  const uvec2 covered =
      rectangle_both(screen_pixels(frame.clip_from_render, render_from_reference, center_m, frame.image_size_px,
                                   frame.scale, frame.layer_size_px),
                     screen_pixels(frame.clip_from_render, inverse(above.reference_from_render), above.center_m,
                                   frame.image_size_px, frame.scale, frame.layer_size_px));
  pixels[i] = covered;
  rectangles[i] = tiles_of_pixels(covered);
  const vec3 towards = center_m / max(length(center_m), 1e-6);
  near_m[i] = near_bound_m(center_m, length(transpose(render_from_reference) * towards));
  order[counters.visible_count - 1u - i] = i;
}
