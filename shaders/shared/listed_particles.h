// Particles given by the scene file: kept on the device in a form that loses nothing however far out they lie, and
// turned into render space every frame. They stand still in the world; the wind moves only the cloud field.
#ifndef NEPHELE_SHARED_LISTED_PARTICLES_H
#define NEPHELE_SHARED_LISTED_PARTICLES_H

#include "flat_base.h"
#include "hash.h"
#include "types.h"
#include "world.h"

NEPHELE_SHARED_BEGIN

NEPHELE_CONST(uint, kIdentityOrientation, 0x7f000000u);  // pack_orientation((0, 0, 0, 1))

// A world position: units of kOriginUnitM in x and y, and the rest as the sum of two floats.
struct SplitPlace {
  vec3 high_m;
  vec3 low_m;
  ivec2 unit;
};

struct ListedSource {
  SplitPlace place;
  vec3 radius_m;
  float yaw_rad;
  float extinction_per_m;  // times density
  uint flags;
  vec3 radiance_per_sr;
  uint id;
};

NEPHELE_FN Particle listed_particle(ListedSource source, vec3 offset_m, float camera_altitude_m) {
  Particle particle;
  particle.center_m = render_from_offset(offset_m, camera_altitude_m);
  particle.extinction_per_m = source.extinction_per_m;
  particle.radius_m = source.radius_m;
  particle.yaw_rad = source.yaw_rad;
  particle.orientation = kIdentityOrientation;
  particle.flags = source.flags;
  particle.base_m = kNoBaseM;
  particle.top_m = camera_altitude_m + offset_m.z + source.radius_m.z;
  particle.radiance_per_sr = source.radiance_per_sr;
  particle.id = source.id;
  return particle;
}

#ifdef __cplusplus
static_assert(sizeof(SplitPlace) == 32);
static_assert(sizeof(ListedSource) == 72);

inline SplitPlace split_place(dvec3 world_m) {
  const GridPlace place = grid_place(world_m);
  const double unit = static_cast<double>(kOriginUnitM);
  const dvec3 rest(world_m.x - std::round(world_m.x / unit) * unit, world_m.y - std::round(world_m.y / unit) * unit,
                   world_m.z);
  return {place.grid_m, vec3(rest - dvec3(place.grid_m)), place.origin_index};
}
#endif

NEPHELE_SHARED_END

#endif
