#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/light.h"

// [Yusov14] 5.3 step 3: light diffuses in the body of the cloud, so the depth it has passed is averaged over the
// neighbourhood, weighted by the extinction there: clear air has no say.
// Deviates from the paper: the neighbourhood is sampled at four points around the particle instead of at other
// particles' centres. Only visible particles carry a depth, so averages over particles change, and flicker, where
// neighbours enter or leave the view; these points do not depend on the view.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
layout(scalar, set = 0, binding = 1) readonly buffer Particles { Particle particles[]; };
layout(scalar, set = 0, binding = 2) readonly buffer Visible { uint visible[]; };
layout(scalar, set = 0, binding = 3) readonly buffer Counters { FrameCounters counters; };
layout(scalar, set = 0, binding = 4) readonly buffer Occluders { Occluder occluders[]; };
layout(scalar, set = 0, binding = 5) readonly buffer Ranges { uvec2 ranges[]; };
layout(scalar, set = 0, binding = 6) readonly buffer List { uint list[]; };
layout(scalar, set = 0, binding = 7) buffer Lights { ParticleLight lights[]; };

#include "occlusion.glsl"

void main() {
  const uint slot = gl_GlobalInvocationID.x;
  if (slot >= counters.visible_count) return;
  const Particle particle = particles[visible[slot]];
  const vec3 sun = lights[slot].sun_irradiance;
  if (!any(greaterThan(sun, vec3(0.0)))) return;

  vec3 points_m[4];
  for (uint j = 0u; j < 4u; ++j) points_m[j] = particle_point(particle, -kNeighbourRadius * tetrahedron_corner(j));
  float depths[4], extinctions[4];
  sun_depths(points_m, kNoParticle, depths, extinctions);

  // The particle itself stands for its whole inside, the points for their surroundings.
  float weight = particle.extinction_per_m;
  float sum = weight * lights[slot].tau_sun;
  for (uint j = 0u; j < 4u; ++j) {
    const float w = kNeighbourWeight * extinctions[j];
    sum += w * depths[j];
    weight += w;
  }
  lights[slot].tau_smooth = sum / weight;
}
