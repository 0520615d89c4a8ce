#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Light at places that a host names: sunlight's transmittance through the clouds, and the radiance that comes along
// each ordinate, gathered back through the finest window around the place to what stands at the window's border. Places
// of other levels are left to their own dispatch.
#include "light/light_lattice_buffer.glsl"
#include "light/light_line.glsl"
#include "kit/texels.glsl"
#include "shared/blend.h"
#include "shared/cloud_light.h"
#include "shared/scattering.h"
#include "shared/types.h"

layout(local_size_x = 64) in;
layout(constant_id = 0) const bool kAir = true;  // false: a dummy is bound as the table
layout(scalar, set = 0, binding = 1) readonly buffer Pairs { LightPair pairs[]; };
layout(scalar, set = 0, binding = 2) readonly buffer Places { vec3 places[]; };  // xy from the camera; z = altitude
struct LightAt {
  float sun_transmittance;
  vec3 harmonics[kLightMoments];
};
layout(scalar, set = 0, binding = 3) writeonly buffer Light { LightAt light[]; };  // of the dispatch's y parts
WORDS(4, index_of);
TEXELS(5, moments);
WORDS(6, depths);
layout(scalar, set = 0, binding = 7) readonly buffer Boundary { vec4 boundary[]; };
layout(scalar, set = 0, binding = 8) uniform Frame { FrameConstants frame; };
layout(set = 0, binding = 9) uniform sampler3D extinction;
layout(set = 0, binding = 10) uniform sampler2D near_beam;
layout(set = 0, binding = 11) uniform sampler2D transmittance;
layout(push_constant, scalar) uniform Push {
  uint level;
  uint count;
};

#include "kit/near_beam_fetch.glsl"
#include "light/light_carried.glsl"
#include "light/light_depth_walk.glsl"
#include "light/light_sun.glsl"

const uint kDirections = 160u;  // that light is gathered from
const uint kNoCell = 0xffffffffu;
const float kOpaque = 1e-3;  // transmittance at which a way ends

// The listed cell at a place in cells, or kNoCell.
uint cell_at(ivec3 place) {
  const ivec3 size = ivec3(lattice.side, lattice.side, lattice.height);
  if (any(lessThan(place, ivec3(0))) || any(greaterThanEqual(place, size))) return kNoCell;
  const uint index = word_at(index_of, uint((place.z * size.y + place.y) * size.x + place.x));
  return index == 0u ? kNoCell : (index & ~kWithoutMatter) - 1u;
}

// What a cell's matter sends along `travel`, as the radiance of matter that is opaque.
vec3 source_radiance(uint cell, vec3 travel, vec3 sun) {
  const float mu = -dot(travel, frame.sun_direction), tau = float_at(depths, cell);
  return field_source_radiance(sun, phase_per_sr(frame.phase_function, mu, frame.phase_g), tau,
                               fetch_near_beam(near_beam, tau, mu), frame.light_unit * carried_towards(cell, travel));
}

// What comes into the window along the ordinate nearest to a direction.
vec4 entering(vec3 travel) {
  uint nearest = 0u;
  float most = -1.0;
  for (uint pair = 0u; pair < kLightPairs; ++pair) {
    const float along = dot(pairs[pair].direction, travel);
    nearest = abs(along) > most ? 2u * pair + (along > 0.0 ? 0u : 1u) : nearest;
    most = max(most, abs(along));
  }
  return boundary[nearest];
}

// Radiance that arrives at a place along `travel`.
vec3 radiance_along(vec3 travel, vec3 at_m) {
  const vec3 size = vec3(lattice.side, lattice.side, lattice.height);
  const vec3 from = light_cell_position(level, at_m);
  const vec3 per_m = -travel / vec3(vec2(lattice.levels[level].cell_m), lattice.layer_m);  // in cells
  const vec3 one = (vec3(0.0) - from) / per_m, other = (size - from) / per_m;
  const vec3 nearer = min(one, other), farther = max(one, other);
  const float begin_m = max(max(nearer.x, nearer.y), max(nearer.z, 0.0));
  const float end_m = min(farther.x, min(farther.y, farther.z));
  const float step_m = 0.5 / max(abs(per_m.x), max(abs(per_m.y), abs(per_m.z)));
  const float planes = float(textureSize(extinction, 0).z);
  const vec3 sun = sun_irradiance(at_m);
  vec3 radiance = vec3(0.0);
  float left = 1.0;
  for (float way_m = begin_m + 0.5 * step_m; way_m < end_m && left > kOpaque; way_m += step_m) {
    const vec3 at = from + way_m * per_m;
    const uint cell = cell_at(ivec3(floor(at)));
    if (cell == kNoCell) continue;
    const vec3 uvw = light_volume_coordinates(at, lattice.levels[level].extinction_plane, planes);
    const float depth = step_m * textureLod(extinction, uvw, 0.0).x;
    radiance += left * opacity_of(depth) * source_radiance(cell, travel, sun);
    left *= exp(-depth);
  }
  const vec4 outside = entering(travel);
  return radiance + left * (outside.x * sun + frame.light_unit * outside.yzw);
}

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  const vec3 at_m = places[i];
  uint own = 0u;
  while (own + 1u < lattice.level_count && max(abs(at_m.x), abs(at_m.y)) >= lattice.levels[own].reach_m) ++own;
  if (own != level) return;
  LightAt result;
  result.sun_transmittance = exp(-depth_to_sun(level, at_m));
  for (uint k = 0u; k < kLightMoments; ++k) result.harmonics[k] = vec3(0.0);
  for (uint d = gl_WorkGroupID.y; d < kDirections; d += gl_NumWorkGroups.y) {  // on a spiral, evenly
    const float z = 1.0 - (2.0 * float(d) + 1.0) / float(kDirections), across = sqrt(1.0 - z * z);
    const float azimuth = 2.3999632 * (float(d) + 0.5);
    const vec3 travel = vec3(across * cos(azimuth), across * sin(azimuth), z);
    const vec3 radiance = radiance_along(travel, at_m) / float(kDirections);
    const LightHarmonics h = light_harmonics(-travel);
    for (uint k = 0u; k < kLightMoments; ++k) result.harmonics[k] += h.y[k] * radiance;
  }
  light[gl_WorkGroupID.y * count + i] = result;
}
