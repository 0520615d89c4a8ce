// From the cloud field to the particles of a grid cell (after [Yusov14] 5.2: several layers, smaller ones above, random
// rotation and displacement). A particle is a function of its world cell and the field alone; only its weight knows the
// camera.
//
// A cell looks at the field in four places, one a quadrant. A place of a coarse ring is one of the places that the next
// finer ring looks at, so that rings agree about where clouds stand. What stands on the places becomes, in order of
// slots:
//   base    one flattened ellipsoid, later cut off at the flat base;
//   levels  fill the column up to the height field, each the cloud's slice at its height. Deep inside a cloud
//   neighbouring cells take turns, so that levels
//           are packed like stacked balls and half of them are spared;
//   crown   domes on the surface, half sunk in, and smaller ones on their upper sides;
//   wisp    a thin one drifting off the edge (finest ring).
//
// Clouds grow, decay and drift under weather maps, so everything about a particle is a continuous function of the
// field's values at the four places: what would be a choice between two arrangements is a weight that fades from one to
// the other, and a particle appears and vanishes at density 0.
//
// Matter is as in a parcel that rises without mixing: its extinction grows with the height above the base
// (adiabatic()). Two gains in density, for the base and for what stands above it, give every cell the matter and the
// centre of mass that its columns of cloud have by themselves: they depend on the field alone, so rings of any cell
// size, and any number of levels, agree in mean optical depth and in altitude.
#ifndef NEPHELE_SHARED_CELL_PARTICLES_H
#define NEPHELE_SHARED_CELL_PARTICLES_H

#include "cloud_field.h"
#include "ellipsoid.h"
#include "types.h"

NEPHELE_SHARED_BEGIN

NEPHELE_CONST(uint, kMaxLevels, 15u);  // the base included
NEPHELE_CONST(uint, kMaxCrown, 16u);
NEPHELE_CONST(uint, kFirstCrown, kMaxLevels);
NEPHELE_CONST(uint, kWispSlot, kFirstCrown + kMaxCrown);
NEPHELE_CONST(uint, kFamily, 4u);          // crown particles that belong together: a dome and what stands on it
NEPHELE_CONST(uint, kSeedCell, 0xc000u);   // + ring
NEPHELE_CONST(uint, kSeedPlace, 0xd000u);  // + ring
NEPHELE_CONST(uint, kSlotSpread, 0x68bc21ebu);
NEPHELE_CONST(float, kCrownSteepest, 2.5f);  // slopes beyond it get no more crown particles
NEPHELE_CONST(float, kFinestM, 184.0f);      // the cell size that needs no correction for coarseness
NEPHELE_CONST(float, kPlaceFade, 0.06f);     // of CloudSample.d: up to there a place counts in part

// What a column of cloud holds, whatever the particles that stand for it.
NEPHELE_CONST(float, kColumnFill, 2.0f);  // particles of density 1 that overlap in it, on average
NEPHELE_CONST(float, kMeanFill, 0.43f);   // of a particle
NEPHELE_CONST(float, kMaxGain, 4.0f);

// Extinction of a parcel that has risen without mixing, over what CloudField.extinction_per_m says: liquid water grows
// in proportion to the height above the base and the drops' number stays, so extinction grows as height^(2/3). The
// field's value is that of 300 m. Bounded: cloud nearer to its base would be glass, and what has risen farther has
// mixed.
NEPHELE_CONST(float, kAdiabaticM, 300.0f);
NEPHELE_CONST(float, kAdiabaticLeast, 0.45f);
NEPHELE_CONST(float, kAdiabaticMost, 2.0f);
NEPHELE_FN float adiabatic(float above_base_m) {
  return clamp(pow(max(above_base_m, 0.0f) / kAdiabaticM, 2.0f / 3.0f), kAdiabaticLeast, kAdiabaticMost);
}

// Its integral over a column of this height (x), metres, and the first moment in altitude (y); the lower bound, which
// holds in the lowest 90 m, left aside.
NEPHELE_FN vec2 adiabatic_column(float height_m) {
  float grows_m = min(height_m, kAdiabaticM * 2.828427f);  // kAdiabaticMost^(3/2)
  float at_top = pow(grows_m / kAdiabaticM, 2.0f / 3.0f);
  float rest_m = height_m - grows_m;
  return vec2(0.6f * at_top * grows_m + kAdiabaticMost * rest_m,
              0.375f * at_top * grows_m * grows_m + kAdiabaticMost * rest_m * (grows_m + 0.5f * rest_m));
}

// The field at a cell's four places, and what the cell's particles get from it.
struct CellCloud {
  uint slots;  // a bit for each particle that has any density
  vec4 core;   // of the places: CloudSample.d, 0 where nothing stands
  vec4 height_m;
  vec2 center_m;        // grid space: mean of the covered places
  float radius_m;       // of the cloud: the distance to its edge is d * radius_m
  float texture_scale;  // size of crown particles
  float base_gain;
  float upper_gain;
};

struct PackedCellCloud {
  uint slots;
  uint core01;  // unorm16 x 2
  uint core23;
  uint height01;  // unorm16 x 2, of the thickness
  uint height23;
  uint center;     // unorm16 x 2, of the cell
  uint character;  // halves: radius_m, texture_scale
  uint gains;      // halves: base, upper
};

NEPHELE_FN PackedCellCloud pack_cell(CellCloud cloud, GridCell cell, float thickness_m) {
  vec4 height = cloud.height_m / thickness_m;
  PackedCellCloud packed;
  packed.slots = cloud.slots;
  packed.core01 = packUnorm2x16(vec2(cloud.core.x, cloud.core.y));
  packed.core23 = packUnorm2x16(vec2(cloud.core.z, cloud.core.w));
  packed.height01 = packUnorm2x16(vec2(height.x, height.y));
  packed.height23 = packUnorm2x16(vec2(height.z, height.w));
  packed.center = packUnorm2x16((cloud.center_m - cell.corner_m) / cell.size_m);
  packed.character = packHalf2x16(vec2(cloud.radius_m, cloud.texture_scale));
  packed.gains = packHalf2x16(vec2(cloud.base_gain, cloud.upper_gain));
  return packed;
}

NEPHELE_FN CellCloud unpack_cell(PackedCellCloud packed, GridCell cell, float thickness_m) {
  vec2 core01 = unpackUnorm2x16(packed.core01);
  vec2 core23 = unpackUnorm2x16(packed.core23);
  vec2 height01 = unpackUnorm2x16(packed.height01);
  vec2 height23 = unpackUnorm2x16(packed.height23);
  vec2 character = unpackHalf2x16(packed.character);
  vec2 gains = unpackHalf2x16(packed.gains);
  CellCloud cloud;
  cloud.slots = packed.slots;
  cloud.core = vec4(core01.x, core01.y, core23.x, core23.y);
  cloud.height_m = vec4(height01.x, height01.y, height23.x, height23.y) * thickness_m;
  cloud.center_m = cell.corner_m + cell.size_m * unpackUnorm2x16(packed.center);
  cloud.radius_m = character.x;
  cloud.texture_scale = character.y;
  cloud.base_gain = gains.x;
  cloud.upper_gain = gains.y;
  return cloud;
}

NEPHELE_FN uint particle_count(CellCloud cloud) { return uint(bitCount(cloud.slots)); }

// The slot of the cell's n-th particle, n < particle_count.
NEPHELE_FN uint particle_slot(CellCloud cloud, uint n) {
  uint left = cloud.slots;
  for (uint i = 0u; i < n; ++i) left &= left - 1u;
  return uint(findLSB(left));
}

NEPHELE_FN uint cell_hash(CloudField field, CloudParams params, GridCell cell) {
  uint lattice = ring_lattice(field, cell.ring);
  return hash_uvec2(lattice_base(params.origin_index, lattice) + uvec2(cell.index),
                    params.seed + kSeedCell + cell.ring);
}

// Where a quadrant (0 .. 3) looks at the field: a jittered place of the finest ring's quadrants, reached by choosing
// one of four smaller cells from ring to ring.
NEPHELE_FN vec2 quadrant_place(CloudField field, CloudParams params, GridCell cell, uint quadrant) {
  ivec2 at = cell.index * 2 + ivec2(int(quadrant & 1u), int(quadrant >> 1u));
  uint lattice = 2u * ring_lattice(field, cell.ring);
  for (uint ring = cell.ring; ring > 0u; --ring) {
    uint h = hash_uvec2(lattice_base(params.origin_index, lattice) + uvec2(at), params.seed + kSeedPlace + ring);
    at = at * 2 + ivec2(int((h >> 30u) & 1u), int(h >> 31u));
    lattice *= 2u;
  }
  uint h = hash_uvec2(lattice_base(params.origin_index, lattice) + uvec2(at), params.seed + kSeedPlace);
  float jx = uniform_float(h, 0.12f, 0.88f);
  float jy = uniform_float(h, 0.12f, 0.88f);
  return vec2(float(at.x) + jx, float(at.y) + jy) * lattice_cell_m(lattice);
}

// How much of each place counts as covered: a cloud's edge passes over it gradually.
NEPHELE_FN vec4 places_covered(vec4 core) {
  vec4 covered = vec4(0.0f);
  for (int i = 0; i < 4; ++i) covered[i] = smooth_ramp(0.0f, kPlaceFade, core[i]);
  return covered;
}

NEPHELE_FN float covered_share(vec4 core) { return dot(places_covered(core), vec4(0.25f)); }

// What a particle stands for: one of the places, or something between two where the one is being uncovered.
struct CellColumn {
  vec2 p_m;
  float core;
  float height_m;
  float share;  // of the cell
};

NEPHELE_FN float column_density(float core) { return mix(0.4f, 1.0f, smooth_ramp(0.0f, 0.22f, core)); }

// How torn particles are: those near the edge, and all of a small cloud, evaporate.
NEPHELE_FN float torn_at(float edge_m) { return 0.5f * (1.0f - smooth_ramp(30.0f, 350.0f, edge_m)); }

// Bodies that stand on a small share of their cell are shreds, whatever cloud is around: in them densities fade.
NEPHELE_FN float torn_body(float share, float edge_m) {
  return max(torn_at(edge_m), 0.9f * (1.0f - smooth_ramp(0.0f, 0.6f, share)));
}

// Slope of the cloud's top across the quadrants.
NEPHELE_FN vec2 cell_slope(CellCloud cloud, GridCell cell) {
  vec4 h = cloud.height_m;
  return vec2(h.y - h.x + h.w - h.z, h.z - h.x + h.w - h.y) / cell.size_m;
}

// Radius at which one ellipsoid hides as much of what lies behind it as the covered share of the cell does. Its depth
// falls off from its middle about as 3 tau (1 - b^2)^2, tau the mean over the disc, so that of the disc's area
// 1 - sqrt(pi / (12 tau)) erf(sqrt(3 tau)) is hidden: x, in which tau in turn is that of the column times x.
NEPHELE_FN float closing_radius_m(CloudField field, GridCell cell, float share, float height_m) {
  float depth = kMeanFill * field.extinction_per_m * kColumnFill * height_m;
  float hidden = max(0.45f, 1.0f - 0.886f * inversesqrt(max(3.0f * depth, 1.0f)));
  return cell.size_m * sqrt(share / (kPi * hidden)) / 0.9f;
}

// What a cell's particles have in common.
struct CellShape {
  uint id;
  uint parity;      // of the cell's turn
  float covered;    // share of the cell
  float closing_m;  // closing_radius_m
  vec2 slope;       // of the cloud's top
  float steepness;
  float tallest_m;  // of the covered places
  float levels;     // to fill, the base included: a real number
  float spared;     // how far neighbours take turns
  float crown;      // crown particles: a real number
  float wisp;       // presence of the wisp
  float coarse;     // 0 at the finest cells, towards 1
};

NEPHELE_FN CellShape cell_shape(CloudField field, CloudParams params, GridCell cell, CellCloud cloud) {
  CellShape shape;
  float c = cell.size_m;
  vec4 covered = places_covered(cloud.core);
  float sum = max(dot(covered, vec4(1.0f)), 1e-6f);
  float height_m = dot(covered, cloud.height_m) / sum;
  float edge_m = dot(covered, cloud.core) / sum * cloud.radius_m;
  uvec2 world = lattice_base(params.origin_index, ring_lattice(field, cell.ring)) + uvec2(cell.index);
  shape.id = cell_hash(field, params, cell);
  shape.parity = (world.x ^ world.y) & 1u;
  shape.covered = 0.25f * sum;
  shape.closing_m = closing_radius_m(field, cell, shape.covered, height_m);
  shape.slope = cell_slope(cloud, cell);
  shape.steepness = length(shape.slope);
  shape.coarse = 1.0f - kFinestM / max(c, kFinestM);
  shape.tallest_m = 0.0f;
  for (int i = 0; i < 4; ++i) shape.tallest_m = max(shape.tallest_m, covered[i] * cloud.height_m[i]);
  shape.levels = clamp((shape.tallest_m - 0.5f * c) / (0.9f * c) + 1.0f, c > kFinestM ? 2.0f : 1.0f,
                       float(min(field.layer_count, kMaxLevels)));
  shape.spared = smooth_ramp(0.9f * c, 1.3f * c, edge_m);
  float area = min(kCrownSteepest, sqrt(1.0f + shape.steepness * shape.steepness));
  float dither = unit_float(hash_uint(shape.id ^ kSlotSpread)) - 0.5f;
  shape.crown = clamp(field.crown_per_cell * (area + shape.coarse) + dither, 0.0f, float(kMaxCrown));
  if (field.crown_per_cell <= 0.0f) shape.crown = 0.0f;
  shape.wisp = cell.ring == 0u ? 1.0f - smooth_ramp(0.24f * cloud.radius_m, 0.36f * cloud.radius_m, edge_m) : 0.0f;
  return shape;
}

struct CloudParticle {
  vec3 center_m;  // grid space
  vec3 radius_m;
  float yaw_rad;
  float density;
  float base_m;
  float top_m;
  uint id;
  float torn;  // 0 .. 1
};

// Each slot likes the four places in its own measure, mostly one of them much better than the others.
NEPHELE_FN CellColumn liked_column(CloudField field, CloudParams params, GridCell cell, CellCloud cloud, uint hash) {
  vec4 covered = places_covered(cloud.core);
  CellColumn column;
  column.p_m = vec2(0.0f);
  column.core = 0.0f;
  column.height_m = 0.0f;
  float sum = 0.0f;
  uint h = hash;
  for (uint i = 0u; i < 4u; ++i) {
    float liked = uniform_float(h, 0.25f, 1.0f);
    liked *= liked;
    liked *= liked;
    float w = liked * liked * liked * covered[int(i)] + 1e-12f;
    sum += w;
    column.p_m += w * quadrant_place(field, params, cell, i);
    column.core += w * cloud.core[int(i)];
    column.height_m += w * cloud.height_m[int(i)];
  }
  column.p_m /= sum;
  column.core /= sum;
  column.height_m /= sum;
  column.share = covered_share(cloud.core);
  return column;
}

// The places at which the cloud reaches above this height, as one column; a place fades out within fade_m.
NEPHELE_FN CellColumn cell_slice(CloudField field, CloudParams params, GridCell cell, CellCloud cloud, float height_m,
                                 float fade_m) {
  vec4 covered = places_covered(cloud.core);
  CellColumn slice;
  slice.p_m = vec2(0.0f);
  slice.core = 0.0f;
  slice.height_m = 0.0f;
  float sum = 1e-12f;
  for (uint i = 0u; i < 4u; ++i) {
    float w = covered[int(i)] * saturate((cloud.height_m[int(i)] - height_m) / fade_m);
    sum += w;
    slice.p_m += w * (quadrant_place(field, params, cell, i) - cell.corner_m);
    slice.core += w * cloud.core[int(i)];
    slice.height_m += w * cloud.height_m[int(i)];
  }
  slice.p_m = cell.corner_m + slice.p_m / sum;
  slice.core /= sum;
  slice.height_m /= sum;
  slice.share = 0.25f * sum;
  return slice;
}

// How far the level of this number, from 1 on, stands: a real number of levels fades the last one in, and deep inside a
// cloud every second one fades out.
NEPHELE_FN float level_presence(CellShape shape, uint level) {
  float present = saturate(shape.levels - float(level));
  return present * (((level ^ shape.parity) & 1u) == 0u ? 1.0f : 1.0f - shape.spared);
}

// A dome of the crown, number `j` of the cell's (a multiple of kFamily).
NEPHELE_FN CloudParticle crown_dome(CloudField field, CloudParams params, GridCell cell, CellCloud cloud,
                                    CellShape shape, uint j) {
  CloudParticle particle;
  uint h = hash_uint(shape.id + (kFirstCrown + j + 1u) * kSlotSpread);
  particle.id = h;
  uint quadrant = (j / kFamily + shape.id) & 3u;
  vec2 p = quadrant_place(field, params, cell, quadrant);
  float core = cloud.core[int(quadrant)];
  float c = cell.size_m;
  particle.yaw_rad = uniform_float(h, 0.0f, 2.0f * kPi);
  float long_axis = uniform_float(h, 0.9f, 1.1f);
  // The R2 sequence (Roberts 2018) fills the quadrants evenly; near the edge particles stay close to the place, since
  // much of the quadrant lies outside.
  float spread = 0.5f * c * mix(0.8f, 1.1f, saturate(core * cloud.radius_m / c));
  float ux = unit_float(shape.id) + 0.7548776662f * float(j);
  float uy = unit_float(shape.id * 0x9e3779b9u) + 0.5698402910f * float(j);
  vec2 offset = spread * vec2(ux - floor(ux) - 0.5f, uy - floor(uy) - 0.5f);
  // What stands under the dome: between the four places, which are a quarter off the cell's sides or so.
  vec2 at = (p + offset - cell.corner_m) / c;
  float east = saturate(2.0f * at.x - 0.5f);
  float north = saturate(2.0f * at.y - 0.5f);
  vec4 near = vec4((1.0f - east) * (1.0f - north), east * (1.0f - north), (1.0f - east) * north, east * north);
  float surface = dot(near, cloud.height_m);
  float under = dot(near, cloud.core);
  // Sizes by a power law: domes larger than x are as many as x^-3, between 0.7 and 1.8.
  float size = min(0.7f * pow(max(unit_float(hash_next(h)), 0.01f), -1.0f / 3.0f), 1.8f);
  float radius = 0.45f * c * size * cloud.texture_scale * mix(0.6f, 1.0f, smooth_ramp(0.0f, 0.3f, under));
  float up = max(min(0.9f * radius, 0.45f * surface), 1.0f);
  radius = min(radius, mix(5.0f, 2.2f, shape.coarse) * up);  // large cells on low clouds: no wide flat discs
  float inward = 0.5f * up / sqrt(1.0f + shape.steepness * shape.steepness);
  // Slopes and edges are covered from top to foot.
  float wall = max(shape.steepness, 2.2f * (1.0f - shape.covered));
  float z = surface * (1.0f - 0.8f * unit_float(hash_next(h)) * saturate((wall - 0.7f) / 1.5f)) - inward;
  particle.radius_m = vec3(radius * long_axis, radius / long_axis, up);
  particle.center_m =
      vec3(p.x + offset.x + inward * shape.slope.x, p.y + offset.y + inward * shape.slope.y, max(z, 0.6f * up));
  particle.density = column_density(under) * smooth_ramp(0.0f, 2.0f * kPlaceFade, under);
  particle.base_m = 0.0f;
  particle.top_m = surface;
  particle.torn = torn_body(shape.covered, under * cloud.radius_m);
  return particle;
}

// Crown particle j: a dome, or a smaller one on a dome's upper, outer side.
NEPHELE_FN CloudParticle crown_particle(CloudField field, CloudParams params, GridCell cell, CellCloud cloud,
                                        CellShape shape, uint j) {
  uint child = j % kFamily;
  CloudParticle particle = crown_dome(field, params, cell, cloud, shape, j - child);
  if (child > 0u) {
    float first_turn = unit_float(particle.id);
    uint h = hash_uint(shape.id + (kFirstCrown + j + 1u) * kSlotSpread);
    particle.id = h;
    float turn = 2.0f * kPi * (first_turn + 0.381966f * float(child)) + uniform_float(h, -0.6f, 0.6f);
    float up = uniform_float(h, 0.15f, 0.95f);
    float across = sqrt(1.0f - up * up);
    vec3 side = vec3(across * cos(turn) - 0.5f * shape.slope.x, across * sin(turn) - 0.5f * shape.slope.y, up);
    side = local_from_render(side / length(side), particle.yaw_rad) * particle.radius_m;
    particle.center_m += 0.85f * render_from_local(side, particle.yaw_rad);
    particle.radius_m = particle.radius_m * uniform_float(h, 0.35f, 0.6f);
    particle.radius_m.z = min(particle.radius_m.x, 1.3f * particle.radius_m.z);
    particle.center_m.z = max(particle.center_m.z, 0.4f * particle.radius_m.z);
    particle.yaw_rad = uniform_float(h, 0.0f, 2.0f * kPi);
  }
  float present = saturate(2.0f * (shape.crown - float(j)) - 1.0f);
  particle.radius_m = particle.radius_m * (0.7f + 0.3f * present);
  particle.density *= present;
  return particle;
}

// A particle of a cell before the gains, with altitudes counted from the flat base; density 0 where there is none.
NEPHELE_FN CloudParticle particle_over_base(CloudField field, CloudParams params, GridCell cell, CellCloud cloud,
                                            CellShape shape, uint slot) {
  if (slot >= kFirstCrown && slot < kWispSlot)
    return crown_particle(field, params, cell, cloud, shape, slot - kFirstCrown);
  uint h = hash_uint(shape.id + (slot + 1u) * kSlotSpread);
  float c = cell.size_m;
  CellColumn column = liked_column(field, params, cell, cloud, hash_uint(h ^ kSlotSpread));
  float height = column.height_m;
  CloudParticle particle;
  particle.id = h;
  particle.torn = slot == kWispSlot ? 1.0f : torn_body(shape.covered, column.core * cloud.radius_m);
  particle.base_m = 0.0f;
  particle.top_m = height;
  particle.yaw_rad = uniform_float(h, 0.0f, 2.0f * kPi);
  particle.density = column_density(column.core) * smooth_ramp(0.0f, 0.25f, shape.covered);
  float long_axis = uniform_float(h, 0.9f, 1.1f);

  // Shrinks towards the edge and keeps the extent as cells double; but it fills the area that the places stand for.
  // Nor is a tower narrower than two fifths of its height.
  float reach = clamp(column.core * cloud.radius_m + 60.0f, max(shape.closing_m, min(0.4f * height, 0.6f * c)), c);
  float filled = max(height, min(0.5f * reach, 92.0f));
  float base_up = min(0.55f * filled, mix(1.2f, 0.55f, shape.covered) * reach);
  if (slot == 0u) {
    float across = 0.9f * reach;
    vec2 at = mix(cloud.center_m, column.p_m, 0.5f);
    particle.radius_m = vec3(across * long_axis, across / long_axis, base_up);
    particle.center_m = vec3(at.x, at.y, 0.3f * base_up + uniform_float(h, -15.0f, 15.0f));
  } else if (slot < kFirstCrown) {
    // The cloud's slice at this height: what of the cell is taller.
    float intervals = max(shape.levels - 1.0f, 0.05f);
    float t = min(float(slot) / intervals, 1.0f);
    float rise = max(shape.tallest_m - base_up, 1.0f);
    float spacing = rise / max(intervals, 1.0f);
    CellColumn slice = cell_slice(field, params, cell, cloud, base_up + t * rise - spacing, spacing);
    // The few levels of a large cell stand for more than their slices, and apart, so that they cover what the cell
    // does.
    slice.p_m = mix(slice.p_m, column.p_m, shape.coarse);
    slice.share = mix(slice.share, shape.covered, shape.coarse);
    float across =
        clamp(slice.core * cloud.radius_m + 60.0f,
              max(closing_radius_m(field, cell, slice.share, slice.height_m), min(0.4f * slice.height_m, 0.5f * c)), c);
    across *=
        mix(1.0f, mix(0.75f, 0.965f, shape.coarse), t) * uniform_float(h, 0.9f, 1.17f) * mix(0.9f, 1.1f, shape.spared);
    // When fewer levels than the height asks for are allowed, they stretch so that the column stays closed.
    float up = max(min(0.9f * across, 0.5f * filled), min(0.85f * spacing, mix(1.6f, 4.0f, shape.spared) * across));
    float z = min(base_up + t * rise, slice.height_m) - 0.8f * up;
    float turn = uniform_float(h, 0.0f, 2.0f * kPi);
    float aside = 0.15f * c * sqrt(unit_float(hash_next(h)));
    particle.radius_m = vec3(across * long_axis, across / long_axis, up);
    particle.center_m = vec3(slice.p_m.x + aside * cos(turn), slice.p_m.y + aside * sin(turn), max(z, 0.3f * up));
    particle.top_m = slice.height_m;
    particle.torn = torn_body(slice.share, slice.core * cloud.radius_m);
    particle.density = column_density(slice.core) * smooth_ramp(0.0f, 0.25f, slice.share) *
                       level_presence(shape, slot) * smooth_ramp(1.4f, 1.8f, shape.tallest_m / base_up);
  } else {
    float radius = uniform_float(h, 60.0f, 140.0f);
    float outward = uniform_float(h, 18.0f, 129.0f) / max(shape.steepness, 0.05f);
    float z = uniform_float(h, 0.15f, 0.9f) * max(height, 180.0f);
    particle.radius_m = vec3(1.5f * radius, 0.6f * radius, 0.5f * radius);
    particle.center_m = vec3(column.p_m.x - outward * shape.slope.x, column.p_m.y - outward * shape.slope.y, z);
    particle.density *= shape.wisp * uniform_float(h, 0.06f, 0.2f);
  }
  return particle;
}

// Matter above the flat base (x) and its first moment in altitude (y) of a particle whose density falls off as 1 - r^2:
// slices at height t of the unit sphere then hold (1 - t^2)^2. The noise in it keeps close to that.
NEPHELE_FN vec2 matter_over_base(CloudParticle particle) {
  float up = particle.radius_m.z;
  float t = clamp(-particle.center_m.z / up, -1.0f, 1.0f);
  float above = (8.0f / 15.0f - t + t * t * t * (2.0f / 3.0f - 0.2f * t * t)) * (15.0f / 16.0f);
  float rim = 1.0f - t * t;
  float moment = rim * rim * rim * (15.0f / 96.0f);
  float volume = (4.0f / 3.0f) * kPi * particle.radius_m.x * particle.radius_m.y * up * particle.density;
  return volume * vec2(above, above * particle.center_m.z + moment * up);
}

// The gains that give base and upper particles together the matter and centre of mass that the columns have, and the
// slots that have any density.
NEPHELE_FN void find_gains(CloudField field, CloudParams params, GridCell cell, NEPHELE_INOUT(CellCloud) cloud) {
  CellShape shape = cell_shape(field, params, cell, cloud);
  vec4 covered = places_covered(cloud.core);
  vec2 wanted = vec2(0.0f);
  for (int i = 0; i < 4; ++i)
    wanted += covered[i] * column_density(cloud.core[i]) * adiabatic_column(cloud.height_m[i]);
  wanted *= kColumnFill * 0.25f * cell.size_m * cell.size_m;
  vec2 base = vec2(0.0f);
  vec2 upper = vec2(0.0f);
  uint levels = uint(ceil(shape.levels));
  uint crown_end = kFirstCrown + uint(ceil(max(shape.crown - 0.5f, 0.0f)));
  cloud.slots = 0u;
  for (uint slot = 0u; slot <= kWispSlot; ++slot) {
    bool possible = slot < kFirstCrown ? slot < levels : (slot < kWispSlot ? slot < crown_end : shape.wisp > 0.0f);
    if (!possible) continue;
    CloudParticle particle = particle_over_base(field, params, cell, cloud, shape, slot);
    if (particle.density <= 0.0f) continue;
    cloud.slots |= 1u << slot;
    particle.density *= adiabatic(particle.center_m.z);
    if (slot == 0u)
      base += matter_over_base(particle);
    else if (slot < kWispSlot)
      upper += matter_over_base(particle);
  }
  float base_z = base.y / max(base.x, 1e-6f);
  float upper_z = upper.y / max(upper.x, 1e-6f);
  float wanted_z = wanted.y / max(wanted.x, 1e-6f);
  // Where there is next to nothing above the base, the base has all the matter.
  float share = clamp((upper_z - wanted_z) / max(upper_z - base_z, 10.0f), 0.1f, 0.9f);
  share = mix(1.0f, share, saturate(5.0f * upper.x / max(base.x + upper.x, 1e-6f)));
  cloud.base_gain = min(kMaxGain, share * wanted.x / max(base.x, 1e-6f));
  cloud.upper_gain = min(kMaxGain, (1.0f - share) * wanted.x / max(upper.x, 1e-6f));
}

NEPHELE_FN CellCloud cell_cloud(CloudField field, CloudParams params, GridCell cell) {
  CellCloud cloud;
  cloud.slots = 0u;
  cloud.core = vec4(0.0f);
  cloud.height_m = vec4(0.0f);
  cloud.center_m = vec2(0.0f);
  cloud.radius_m = 0.0f;
  cloud.texture_scale = 0.0f;
  cloud.base_gain = 1.0f;
  cloud.upper_gain = 1.0f;
  float covered = 0.0f;
  for (uint i = 0u; i < 4u; ++i) {
    vec2 p = quadrant_place(field, params, cell, i);
    CloudSample s = cloud_sample(params, p);
    float w = smooth_ramp(0.0f, kPlaceFade, s.d);
    if (w <= 0.0f) continue;
    cloud.core[int(i)] = s.d;
    cloud.height_m[int(i)] = cloud_height_m(params, p, s);
    cloud.center_m += w * p;
    cloud.radius_m += w * s.edge_m / s.d;
    // Regions of the sky differ in texture: smooth domes here, crisp small ones there.
    cloud.texture_scale += w * clamp(1.0f + s.warp_m.x * (1.2f / kWarpM), 0.6f, 1.6f);
    covered += w;
  }
  if (covered < 1e-3f) {
    cloud.core = vec4(0.0f);
    return cloud;
  }
  cloud.center_m /= covered;
  cloud.radius_m /= covered;
  cloud.texture_scale /= covered;
  find_gains(field, params, cell, cloud);
  return cloud;
}

// Number n < particle_count of a cell.
NEPHELE_FN CloudParticle cell_particle(CloudField field, CloudParams params, GridCell cell, CellCloud cloud, uint n) {
  uint slot = particle_slot(cloud, n);
  CellShape shape = cell_shape(field, params, cell, cloud);
  CloudParticle particle = particle_over_base(field, params, cell, cloud, shape, slot);
  particle.density *= adiabatic(particle.center_m.z);
  if (slot == 0u)
    particle.density *= cloud.base_gain;
  else if (slot < kWispSlot)
    particle.density *= cloud.upper_gain;
  float base = cloud_base_m(params, vec2(particle.center_m.x, particle.center_m.y));
  particle.base_m = base;
  particle.top_m += base;
  particle.center_m.z += base;
  return particle;
}

// As the renderer keeps it: in render space, faded by the cell's level-of-detail weight. source: the field's place
// among the scene's sources of clouds.
NEPHELE_FN Particle render_particle(FieldFrame frame, GridCell cell, CloudParticle made, uint source) {
  uint h = hash_uint(made.id);
  float u0 = unit_float(h);
  float u1 = unit_float(hash_next(h));
  float u2 = unit_float(hash_next(h));
  Particle particle;
  particle.center_m = render_from_grid(made.center_m, frame.camera_grid_m);
  particle.extinction_per_m = frame.field.extinction_per_m * made.density * cell_weight(frame, cell);
  particle.shape = upright_shape(made.radius_m, made.yaw_rad);
  particle.orientation = pack_orientation(random_rotation(u0, u1, u2));
  particle.flags = kParticleDetail | (uint(saturate(made.torn) * float(kMostTorn) + 0.5f) << kParticleTornShift) |
                   (cell.ring << kParticleRingShift) | (source << kParticleSourceShift);
  particle.base_m = made.base_m;
  particle.top_m = made.top_m;
  particle.radiance_per_sr = vec3(0.0f);
  particle.id = made.id;
  particle.unused = 0u;
  particle.unused2 = 0u;
  return particle;
}

NEPHELE_SHARED_END

#endif
