// Takes the noise of jittered steps out of a marched layer (Kobak and Alda 2017, 6.3.3): a Gaussian over 3 x 3 pixels,
// whose nine jitters cover a step evenly. Deviates from the paper: a neighbour's weight falls as its difference exceeds
// the noise to be expected from both rays' steps. So edges and texture stay, the blur shrinks with the steps, and the
// result converges to the integral.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/types.h"
#include "layer/march_noise.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
layout(set = 0, binding = 1) uniform sampler2D marched;        // premultiplied radiance, transmittance
layout(set = 0, binding = 2) uniform sampler2D marched_noise;  // deviations of transmittance and luminance
layout(set = 0, binding = 3, rgba32f) writeonly uniform image2D layer_color;

// The two of a pixel that are compared: transmittance and luminance.
vec2 noisy_value(vec4 color) { return vec2(color.a, luminance_of(color.rgb)); }

void main() {
  const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), last = ivec2(frame.layer_size_px) - 1;
  if (any(greaterThan(pixel, last))) return;
  const vec4 own = texelFetch(marched, pixel, 0);
  const vec2 own_noise = texelFetch(marched_noise, pixel, 0).xy, own_value = noisy_value(own);
  vec4 sum = vec4(0.0);
  float weights = 0.0;
  for (int i = 0; i < 9; ++i) {
    const ivec2 offset = ivec2(i % 3 - 1, i / 3 - 1), at = clamp(pixel + offset, ivec2(0), last);
    const vec4 other = texelFetch(marched, at, 0);
    const vec2 apart = noisy_value(other) - own_value;
    const vec2 other_noise = texelFetch(marched_noise, at, 0).xy;
    const vec2 variance = own_noise * own_noise + other_noise * other_noise + 1e-14;
    const float weight =
        exp2(-float(abs(offset.x) + abs(offset.y))) * exp(-min(dot(apart * apart, 1.0 / variance), 80.0));
    sum += weight * other;
    weights += weight;
  }
  imageStore(layer_color, pixel, sum / weights);
}
