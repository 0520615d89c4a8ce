#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// How open the window's cells lie towards a height over the horizon: of what comes from there, the share that nothing
// scatters on the way. A thread takes the cells of one column and a slice of layers, each in another azimuth. Columns
// stand as far apart as a window steps, so that all but those at a border are the same ones after a step; but not in
// the coarsest window, which steps by fewer of its cells.
#include "light/light_lattice_buffer.glsl"
#include "light/light_openness.glsl"
#include "kit/texels.glsl"

layout(local_size_x = 64) in;
WORDS(1, index_of);
layout(set = 0, binding = 2) uniform sampler3D extinction;
layout(scalar, set = 0, binding = 3) writeonly buffer Parts { vec2 parts[]; };  // sum and count, of each workgroup
layout(push_constant, scalar) uniform Push { uint level; };

#include "light/light_depth_walk.glsl"

const uint kLayersASlice = 32u;  // some 600 steps a cell: a driver's limit is 65 535 rounds (layer/driver_limit.glsl)

shared vec2 of_threads[gl_WorkGroupSize.x];

void main() {
  const uint ring = gl_WorkGroupID.y, thread = gl_LocalInvocationID.x, column = gl_GlobalInvocationID.x;
  const uint across = lattice.side / kLightWindowStep;
  const float z = openness_cosine(ring), across_z = sqrt(1.0 - z * z);
  vec2 sum = vec2(0.0);
  const uint first = kLayersASlice * gl_WorkGroupID.z, end = min(first + kLayersASlice, lattice.height);
  for (uint layer = first; layer < end && column < across * across; ++layer) {
    const uvec3 place = uvec3(kLightWindowStep * uvec2(column % across, column / across), layer);
    if (word_at(index_of, (place.z * lattice.side + place.y) * lattice.side + place.x) == 0u) continue;
    const float azimuth = 2.0 * kPi * fract(0.618034 * float(layer) + 0.381966 * float(ring));
    const vec3 direction = vec3(across_z * cos(azimuth), across_z * sin(azimuth), z);
    const float depth = depth_along(direction, level, light_cell_middle(level, ivec3(place)));
    sum += vec2(exp(-(1.0 - lattice.forward) * depth), 1.0);
  }
  of_threads[thread] = sum;
  barrier();
  if (thread != 0u) return;
  for (uint i = 1u; i < gl_WorkGroupSize.x; ++i) sum += of_threads[i];
  parts[(ring * gl_NumWorkGroups.z + gl_WorkGroupID.z) * gl_NumWorkGroups.x + gl_WorkGroupID.x] = sum;
}
