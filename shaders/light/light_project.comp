#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// What each listed cell of a level scatters towards the camera of the light that has left the beam, as the radiance of
// matter that is opaque, in units of frame.light_unit; and the optical depth towards the sun. Towards its reach a level
// turns into the coarser one.
#include "light/light_lattice_buffer.glsl"
#include "light/light_source.glsl"
#include "kit/texels.glsl"

layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 1) readonly buffer Count {
  uvec3 groups;
  uint listed_count;
};
WORDS(2, listed);
TEXELS(3, moments);
layout(set = 0, binding = 5) uniform sampler3D coarser;
layout(set = 0, binding = 6, rgba16f) writeonly uniform image3D radiance;
WORDS(7, depths);
layout(push_constant, scalar) uniform Push {
  uint level;
  float eye_altitude_m;
};

#include "kit/light_lattice.glsl"
#include "light/light_carried.glsl"

const float kFadeCells = 4.0;
const float kLeastDepth = 1e-6;  // 0 marks cells that are not listed

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= listed_count) return;
  const ivec3 place = light_cell_place(word_at(listed, i));
  const vec3 middle_m = light_cell_middle(level, place);
  const vec3 to_eye = normalize(vec3(-middle_m.xy, eye_altitude_m - middle_m.z));
  vec4 value = vec4(carried_towards(i, to_eye), max(float_at(depths, i), kLeastDepth));
  if (level + 1u < lattice.level_count) {
    const float distance_m = max(abs(middle_m.x), abs(middle_m.y));
    const float share =
        clamp((lattice.levels[level].reach_m - distance_m) / (kFadeCells * lattice.levels[level].cell_m), 0.0, 1.0);
    const vec3 uvw =
        light_volume_coordinates(light_cell_position(level + 1u, middle_m), lattice.levels[level + 1u].radiance_plane,
                                 float(textureSize(coarser, 0).z));
    const vec4 other = textureLod(coarser, uvw, 0.0);
    if (other.a > 0.0) value = mix(other, value, share);
  }
  imageStore(radiance, ivec3(place.xy, int(lattice.levels[level].radiance_plane) + place.z), value);
}
