// Particles that a scene or a file lists: kept on the device in a form that loses nothing however far out they lie, and
// turned into render space every frame. A source that drifts with the wind is left alone here: its camera moves the
// other way.
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

struct PlacedParticle {
  SplitPlace place;
  EllipsoidShape shape;
  float extinction_per_m;  // times density
  uint orientation;        // as in Particle
  uint flags;
  float base_m;
  float top_m;
  vec3 radiance_per_sr;
  uint id;
};

// index: of the source among the scene's sources of clouds.
NEPHELE_FN Particle listed_particle(PlacedParticle source, vec3 offset_m, float camera_altitude_m, uint index) {
  Particle particle;
  particle.center_m = render_from_offset(offset_m, camera_altitude_m);
  particle.extinction_per_m = source.extinction_per_m;
  particle.shape = source.shape;
  particle.orientation = source.orientation;
  particle.flags = source.flags | (index << kParticleSourceShift);
  particle.base_m = source.base_m;
  particle.top_m = source.top_m;
  particle.radiance_per_sr = source.radiance_per_sr;
  particle.id = source.id;
  particle.unused = 0u;
  particle.unused2 = 0u;
  return particle;
}

#ifdef __cplusplus
static_assert(sizeof(SplitPlace) == 32);
static_assert(sizeof(PlacedParticle) == 92);

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
