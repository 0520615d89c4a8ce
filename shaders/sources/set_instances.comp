#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

// The instances of sets that may show: where they are from the camera, by which levels they are drawn, and how many
// particles that makes. One thread an instance.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 3) readonly buffer WeatherMap { uint weather_texels[]; };
#define NEPHELE_WEATHER_TEXEL(weather, i) weather_texels[i]
#include "shared/set_instances.h"
layout(scalar, set = 0, binding = 0) readonly buffer Constants { SetConstants constants; };
layout(scalar, set = 0, binding = 1) readonly buffer Kinds { SetKind kinds[]; };
layout(scalar, set = 0, binding = 2) readonly buffer Listed { ListedInstance listed[]; };
layout(scalar, set = 0, binding = 4) writeonly buffer Instances { SetInstanceRecord instances[]; };
layout(scalar, set = 0, binding = 5) writeonly buffer Counts { uint counts[]; };  // of particles, an entry each

vec3 offset_of(SplitPlace place) {
  // Exact order of operations: the high parts cancel first.
  precise const vec3 high = place.high_m - constants.camera.high_m;
  precise const vec3 low = place.low_m - constants.camera.low_m;
  precise const vec3 offset = high + low;
  return offset + vec3(vec2(place.unit - constants.camera.unit) * kOriginUnitM, 0.0);
}

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= constants.candidates) return;
  SetInstanceRecord instance;
  float weight = 1.0;
  if (constants.lattice == 0u) {
    const ListedInstance own = listed[i];
    instance = instance_at(own, offset_of(own.place), constants.camera_grid_m.z);
  } else {
    const SetPlace place =
        set_place(constants, constants.first_cell + ivec2(int(i % constants.side), int(i / constants.side)));
    const Weather weather = Weather(constants.weather, constants.coverage);
    const float coverage = has_weather_map(weather) ? weather_at(weather, place.grid_m).x : constants.coverage;
    weight = place_taken(coverage, place.taken_u);
    uint kind = 0u;
    for (uint k = 1u; k < constants.kinds; ++k) kind = kinds[k].share_below <= place.kind_u ? k : kind;
    ListedInstance own;
    own.cos_heading = place.cos_heading;
    own.sin_heading = place.sin_heading;
    own.scale = place.scale;
    own.kind = kind;
    own.id = place.id;
    instance =
        instance_at(own, vec3(place.grid_m, constants.altitude_m) - constants.camera_grid_m, constants.camera_grid_m.z);
  }
  weight *= set_view_weight(instance.offset_m, constants.view_distance_m);
  const uvec2 count = choose_set_levels(kinds[instance.kind], weight, instance);
  instances[i] = instance;
  counts[2u * i] = count.x;
  counts[2u * i + 1u] = count.y;
  if (i == 0u) counts[2u * constants.candidates] = 0u;
}
