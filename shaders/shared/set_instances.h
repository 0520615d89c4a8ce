// Particle sets in the world: which instances of them a camera sees, by which of their levels of detail, and what each
// of their particles becomes there. All instances of a set share its particles.
//
// Instances come from a list, or from a lattice over the ground whose every cell has one place for a cloud: the place,
// whether it is taken, by which set, turned and scaled how, follow from the cell's hash and the weather. Either kind
// stands still in the air, which drifts.
//
// A level stands for the cloud from the distance on at which its particles look as small as those of the level before
// do at theirs; over the last part before that distance one fades into the other, which keeps the sum of their matter.
#ifndef NEPHELE_SHARED_SET_INSTANCES_H
#define NEPHELE_SHARED_SET_INSTANCES_H

#include "ellipsoid.h"
#include "hash.h"
#include "listed_particles.h"
#include "types.h"
#include "weather.h"
#include "world.h"

NEPHELE_SHARED_BEGIN

NEPHELE_CONST(uint, kMostSetLevels, 7u);
NEPHELE_CONST(uint, kEntriesPerInstance, 2u);    // levels of an instance that may show at once
NEPHELE_CONST(float, kSetLevelFade, 0.15f);      // last part of the way to a level over which it comes in
NEPHELE_CONST(float, kSetViewFade, 0.2f);        // last part of the view distance, as of cells (ring_grid.h)
NEPHELE_CONST(float, kLeastSetWeight, 1.0e-3f);  // what is fainter is left out
NEPHELE_CONST(float, kTakenFade, 0.04f);         // of coverage, over which a place is taken

// A particle of a set as it lies on the device.
struct SetParticleRecord {
  vec3 center_m;
  EllipsoidShape shape;
  float extinction_per_m;
  float base_m;
  float top_m;
  uint seed;
};

struct SetKind {
  uint first[kMostSetLevels];  // of the level's particles among all records
  uint count[kMostSetLevels];
  float from_m[kMostSetLevels];  // distance from which on the level stands, for an instance of scale 1; rising, from 0
  uint levels;
  uint flags[kMostSetLevels];  // of the level's particles
  float share_below;           // of the kinds before it, of all shares
  float radius_m;              // of a ball about the set's origin that holds it
};

struct ListedInstance {
  SplitPlace place;  // in the air
  float cos_heading;
  float sin_heading;
  float scale;
  uint kind;
  uint id;
};

// What an instance is for this camera.
struct SetInstanceRecord {
  vec3 offset_m;  // of its origin from the camera, along the ground and in altitude
  float cos_heading;
  float sin_heading;
  float scale;
  uint kind;
  uint id;
  float altitude_m;  // of its origin
  // Its entries: first record, flags of the particles, and weight.
  uint first[kEntriesPerInstance];
  uint flags[kEntriesPerInstance];
  float weight[kEntriesPerInstance];
};

struct SetConstants {
  SplitPlace camera;
  // Of the lattice.
  WeatherPlacement weather;
  ivec2 origin_index;
  vec3 camera_grid_m;
  ivec2 first_cell;  // counted from the grid's origin
  uint lattice;      // cells a unit (world.h); 0: instances are listed
  uint side;         // cells of the lattice that are asked
  uint seed;
  float coverage;
  float altitude_m;
  vec2 scale;
  // Of both.
  uint candidates;  // instances that may show
  uint kinds;
  float view_distance_m;
  uint source;
  uint capacity;
};

// How far a level has come in at this distance: 0 .. 1.
NEPHELE_FN float set_level_in(float from_m, float distance_m) {
  if (from_m <= 0.0f) return 1.0f;
  return clamp((distance_m / from_m - (1.0f - kSetLevelFade)) / kSetLevelFade, 0.0f, 1.0f);
}

NEPHELE_FN SetInstanceRecord instance_at(ListedInstance listed, vec3 offset_m, float camera_altitude_m) {
  SetInstanceRecord instance;
  instance.offset_m = offset_m;
  instance.cos_heading = listed.cos_heading;
  instance.sin_heading = listed.sin_heading;
  instance.scale = listed.scale;
  instance.kind = listed.kind;
  instance.id = listed.id;
  instance.altitude_m = camera_altitude_m + offset_m.z;
  for (uint entry = 0u; entry < kEntriesPerInstance; ++entry) {
    instance.first[entry] = 0u;
    instance.flags[entry] = 0u;
    instance.weight[entry] = 0.0f;
  }
  return instance;
}

// The place of a lattice cell: jittered by at most 0.4 cells. taken_u: what coverage it takes (place_taken); kind_u:
// which set, by its share.
struct SetPlace {
  vec2 grid_m;
  float taken_u;
  float kind_u;
  float cos_heading;
  float sin_heading;
  float scale;
  uint id;
};

NEPHELE_FN SetPlace set_place(SetConstants constants, ivec2 cell) {
  uint h = hash_uvec2(lattice_base(constants.origin_index, constants.lattice) + uvec2(cell), constants.seed);
  SetPlace place;
  place.id = h;
  float jx = uniform_float(h, 0.1f, 0.9f);
  float jy = uniform_float(h, 0.1f, 0.9f);
  place.grid_m = (vec2(cell) + vec2(jx, jy)) * lattice_cell_m(constants.lattice);
  place.taken_u = uniform_float(h, 0.0f, 1.0f);
  place.kind_u = uniform_float(h, 0.0f, 1.0f);
  float heading_rad = uniform_float(h, 0.0f, 2.0f * kPi);
  place.cos_heading = cos(heading_rad);
  place.sin_heading = sin(heading_rad);
  place.scale = uniform_float(h, constants.scale.x, constants.scale.y);
  return place;
}

// Chooses the entries of an instance: at most two levels have a weight, because each begins more than twice as far out
// as the one before. weight: of the whole instance. Returns the counts of particles.
NEPHELE_FN uvec2 choose_set_levels(SetKind kind, float weight, NEPHELE_INOUT(SetInstanceRecord) instance) {
  vec3 o = instance.offset_m;
  float distance_m = max(length(o) - kind.radius_m * instance.scale, 0.0f) / instance.scale;
  uvec2 counts = uvec2(0u);
  uint entry = 0u;
  float in_here = 1.0f;
  for (uint level = 0u; level < kind.levels; ++level) {
    float in_next = level + 1u < kind.levels ? set_level_in(kind.from_m[level + 1u], distance_m) : 0.0f;
    float own = weight * (in_here - in_next);
    in_here = in_next;
    if (own < kLeastSetWeight || entry >= kEntriesPerInstance) continue;
    instance.first[entry] = kind.first[level];
    instance.flags[entry] = kind.flags[level];
    instance.weight[entry] = own;
    counts[int(entry)] = kind.count[level];
    ++entry;
  }
  return counts;
}

NEPHELE_FN float set_view_weight(vec3 offset_m, float view_distance_m) {
  float away_m = length(vec2(offset_m.x, offset_m.y));
  return clamp((view_distance_m - away_m) / (kSetViewFade * view_distance_m), 0.0f, 1.0f);
}

// How far a place is taken, where the weather has this coverage; u: of the place, 0 .. 1. Squared, because thick clouds
// stay opaque until little of them is left: so the clouds' matter is the coverage's share of all places' less 0.02.
NEPHELE_FN float place_taken(float coverage, float u) {
  float at = mix(0.5f * kTakenFade, 1.0f - 0.5f * kTakenFade, u);
  float taken = clamp((coverage - at) / kTakenFade + 0.5f, 0.0f, 1.0f);
  return taken * taken;
}

// v turned clockwise seen from above.
NEPHELE_FN vec3 turned_by_heading(vec3 v, float cos_heading, float sin_heading) {
  return vec3(cos_heading * v.x + sin_heading * v.y, cos_heading * v.y - sin_heading * v.x, v.z);
}

NEPHELE_FN EllipsoidShape turned_shape(EllipsoidShape shape, float c, float s, float scale) {
  vec3 d = shape.diagonal_m;
  vec3 o = shape.off_diagonal_m;
  EllipsoidShape turned;
  turned.diagonal_m =
      scale * vec3(c * c * d.x + 2.0f * c * s * o.x + s * s * d.y, s * s * d.x - 2.0f * c * s * o.x + c * c * d.y, d.z);
  turned.off_diagonal_m =
      scale * vec3((c * c - s * s) * o.x + c * s * (d.y - d.x), c * o.y + s * o.z, c * o.z - s * o.y);
  return turned;
}

NEPHELE_FN Particle set_particle(SetParticleRecord own, SetInstanceRecord instance, float weight, uint flags,
                                 float camera_altitude_m, uint source) {
  float c = instance.cos_heading;
  float s = instance.sin_heading;
  vec3 offset_m = instance.offset_m + instance.scale * turned_by_heading(own.center_m, c, s);
  uint h = hash_uint(own.seed);
  float u0 = unit_float(h);
  float u1 = unit_float(hash_next(h));
  float u2 = unit_float(hash_next(h));
  // Half the heading's angle, by which quaternions turn.
  float half_c = sqrt(max(0.5f + 0.5f * c, 0.0f));
  float half_s = (s < 0.0f ? -1.0f : 1.0f) * sqrt(max(0.5f - 0.5f * c, 0.0f));
  Particle particle;
  particle.center_m = render_from_offset(offset_m, camera_altitude_m);
  particle.extinction_per_m = weight * own.extinction_per_m / instance.scale;
  particle.shape = turned_shape(own.shape, c, s, instance.scale);
  particle.flags = flags | (source << kParticleSourceShift);
  particle.orientation =
      pack_orientation(quaternion_product(vec4(0.0f, 0.0f, -half_s, half_c), random_rotation(u0, u1, u2)));
  particle.base_m = instance.altitude_m + instance.scale * own.base_m;
  particle.top_m = instance.altitude_m + instance.scale * own.top_m;
  particle.id = hash_uint(own.seed ^ instance.id);
  particle.unused = 0u;
  particle.radiance_per_sr = vec3(0.0f);
  particle.unused2 = 0u;
  return particle;
}

NEPHELE_SHARED_END

#endif
