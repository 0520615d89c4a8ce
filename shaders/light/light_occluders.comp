#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/light.h"
#include "kit/texels.glsl"

// [Yusov14] 5.3 step 1, part 1: every particle as the sun sees it, its key in the order from the sun and the
// rectangle of tiles it covers.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
PARTICLES(1, particles);
layout(scalar, set = 0, binding = 2) readonly buffer Counters { FrameCounters counters; };
layout(scalar, set = 0, binding = 3) writeonly buffer Occluders { PackedOccluder occluders[]; };
layout(scalar, set = 0, binding = 4) writeonly buffer Rectangles { uvec2 rectangles[]; };
layout(scalar, set = 0, binding = 5) writeonly buffer Keys { uint keys[]; };
layout(scalar, set = 0, binding = 6) writeonly buffer Values { uint values[]; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= counters.particle_count) return;
  LightBounds bounds;
  const Occluder occluder =
      make_occluder(particle_at(particles, i), frame.light_from_render, frame.camera_grid_m.z, bounds);
  occluders[i] = pack_occluder(occluder);
  rectangles[i] = occluder.extinction_per_m > 0.0 ? light_rectangle(bounds, frame.view_distance_m) : kNoTiles;
  keys[i] = sun_key(occluder.top_m, frame.view_distance_m);
  values[i] = i;
}
