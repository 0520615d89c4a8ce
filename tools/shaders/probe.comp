// nephele probe: rays through the unit sphere, evaluated by the functions that shading uses, one ray a thread.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "kit/near_beam_fetch.glsl"
#include "layer/table_fetch.glsl"

layout(local_size_x = 64) in;

struct ProbeRay {
  vec3 entry;      // unit vector
  vec3 direction;  // unit vector, going in
  vec3 light;      // unit vector, the way sunlight travels
  float optical_radius;
};

const uint kProbeSingle = 0u;
const uint kProbeMultiple = 1u;
const uint kProbeNearBeam = 3u;  // at optical_radius as the depth towards the sun

layout(scalar, set = 0, binding = 0) readonly buffer Rays { ProbeRay rays[]; };
// Radiance per unit irradiance, per sr; or mean extinction / peak and the fraction of the chord before the first
// matter.
layout(scalar, set = 0, binding = 1) writeonly buffer Values { vec2 values[]; };
layout(set = 0, binding = 2) uniform sampler3D optical_depth_table;
layout(set = 0, binding = 3) uniform sampler3D multiple_scattering_table;
layout(set = 0, binding = 4) uniform sampler2D near_beam_table;

layout(push_constant, scalar) uniform Push {
  uint count;
  uint quantity;
  uint phase_function;
  float g;
}
push;

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= push.count) return;
  ProbeRay ray = rays[i];
  float c = dot(ray.entry, ray.light);
  float h = clamp(-dot(ray.entry, ray.direction), 0.0, 1.0);
  float mu = -dot(ray.direction, ray.light);
  if (push.quantity == kProbeSingle) {
    float phase = phase_per_sr(push.phase_function, mu, push.g);
    values[i] = vec2(phase * single_scattering(c, h, mu, ray.optical_radius), 0.0);
  } else if (push.quantity == kProbeMultiple) {
    values[i] = vec2(fetch_multiple(multiple_scattering_table, c, h, mu, ray.optical_radius, push.g), 0.0);
  } else if (push.quantity == kProbeNearBeam) {
    values[i] = vec2(fetch_near_beam(near_beam_table, ray.optical_radius, mu), 0.0);
  } else {
    vec3 exit = normalize(ray.entry + 2.0 * h * ray.direction);
    values[i] = fetch_optical_depth(optical_depth_table, ray.entry, exit);
  }
}
