#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "kit/cloud_shadow_lookup.glsl"

// Looks the clouds' shadow up at given points, just as the ground and the shafts do; for tests.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
layout(set = 0, binding = 1) uniform sampler2D shadow;
layout(scalar, set = 0, binding = 2) readonly buffer Points { vec3 points_m[]; };
layout(scalar, set = 0, binding = 3) writeonly buffer Transmittances { float transmittances[]; };
layout(push_constant) uniform Push { uint count; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i < count)
    transmittances[i] =
        cloud_shadow(shadow, frame.light_from_render, light_uv_scale(frame.view_distance_m), points_m[i]);
}
