// From the cloud field to the particles of a grid cell (after [Yusov14] 5.2: several layers, smaller ones above, random
// rotation and displacement). A particle is a function of its world cell alone; only its weight knows the camera.
//
// A cell looks at the field in four places, one a quadrant. A place of a coarse ring is one of the places that the next
// finer ring looks at, so that rings agree about where clouds stand. What stands on the covered places becomes, in
// order of slots:
//   base    one flattened ellipsoid, later cut off at the flat base;
//   levels  fill the column up to the height field. Deep inside a cloud neighbouring cells take turns, so that levels
//           are packed like stacked balls and half of them are spared;
//   crown   small ones on the surface, half sunk in: the domes' relief;
//   wisp    a thin one drifting off the edge (finest ring).
//
// Two gains in density, for the base and for what stands above it, give every cell the matter and the centre of mass
// that its columns of cloud have by themselves: they depend on the field alone, so rings of any cell size, and any
// number of levels, agree in mean optical depth and in altitude.
#ifndef NEPHELE_SHARED_CELL_PARTICLES_H
#define NEPHELE_SHARED_CELL_PARTICLES_H

#include "cloud_field.h"
#include "ellipsoid.h"
#include "types.h"

NEPHELE_SHARED_BEGIN

NEPHELE_CONST(uint, kMaxLevels, 15u);
NEPHELE_CONST(uint, kMaxCrown, 15u);
NEPHELE_CONST(uint, kSeedCell, 0xc000u);   // + ring
NEPHELE_CONST(uint, kSeedPlace, 0xd000u);  // + ring
NEPHELE_CONST(uint, kSlotSpread, 0x68bc21ebu);
NEPHELE_CONST(float, kCrownSteepest, 2.5f);  // slopes beyond it get no more crown particles
NEPHELE_CONST(float, kFinestM, 184.0f);      // the cell size that needs no correction for coarseness

// What a column of cloud holds, whatever the particles that stand for it.
NEPHELE_CONST(float, kColumnFill, 2.0f);     // particles of density 1 that overlap in it, on average
NEPHELE_CONST(float, kColumnCenter, 0.45f);  // of its height: where the centre of mass lies
NEPHELE_CONST(float, kMeanFill, 0.3f);       // of the reference particle
NEPHELE_CONST(float, kMaxGain, 4.0f);

// How many particles of each kind stand in a cell.
struct CellParts {
  uint levels;  // heights to fill, the base included; 0: nothing here
  uint turn;    // 0: every level, 1: the odd ones, 2: the even ones above the base
  uint crown;
  uint wisps;
};

// The field at a cell's four places, and what the cell's particles get from it.
struct CellCloud {
  CellParts parts;
  vec4 core;  // of the places: CloudSample.d, 0 where nothing stands
  vec4 height_m;
  vec2 center_m;        // grid space: mean of the covered places
  float radius_m;       // of the cloud: the distance to its edge is d * radius_m
  float texture_scale;  // size of crown particles
  float base_gain;
  float upper_gain;
};

struct PackedCellCloud {
  uint parts;
  uint core;      // unorm8 x 4
  uint height01;  // unorm16 x 2, of the thickness
  uint height23;
  uint center;     // unorm16 x 2, of the cell
  uint character;  // halves: radius_m, texture_scale
  uint gains;      // halves: base, upper
};

NEPHELE_FN uint pack_parts(CellParts parts) {
  return parts.levels | (parts.turn << 4u) | (parts.crown << 6u) | (parts.wisps << 10u);
}
NEPHELE_FN CellParts unpack_parts(uint bits) {
  CellParts parts;
  parts.levels = bits & 15u;
  parts.turn = (bits >> 4u) & 3u;
  parts.crown = (bits >> 6u) & 15u;
  parts.wisps = (bits >> 10u) & 1u;
  return parts;
}

NEPHELE_FN PackedCellCloud pack_cell(CellCloud cloud, GridCell cell, float thickness_m) {
  vec4 height = cloud.height_m / thickness_m;
  PackedCellCloud packed;
  packed.parts = pack_parts(cloud.parts);
  packed.core = packUnorm4x8(cloud.core);
  packed.height01 = packUnorm2x16(vec2(height.x, height.y));
  packed.height23 = packUnorm2x16(vec2(height.z, height.w));
  packed.center = packUnorm2x16((cloud.center_m - cell.corner_m) / cell.size_m);
  packed.character = packHalf2x16(vec2(cloud.radius_m, cloud.texture_scale));
  packed.gains = packHalf2x16(vec2(cloud.base_gain, cloud.upper_gain));
  return packed;
}

NEPHELE_FN CellCloud unpack_cell(PackedCellCloud packed, GridCell cell, float thickness_m) {
  vec2 height01 = unpackUnorm2x16(packed.height01);
  vec2 height23 = unpackUnorm2x16(packed.height23);
  vec2 character = unpackHalf2x16(packed.character);
  vec2 gains = unpackHalf2x16(packed.gains);
  CellCloud cloud;
  cloud.parts = unpack_parts(packed.parts);
  cloud.core = unpackUnorm4x8(packed.core);
  cloud.height_m = vec4(height01.x, height01.y, height23.x, height23.y) * thickness_m;
  cloud.center_m = cell.corner_m + cell.size_m * unpackUnorm2x16(packed.center);
  cloud.radius_m = character.x;
  cloud.texture_scale = character.y;
  cloud.base_gain = gains.x;
  cloud.upper_gain = gains.y;
  return cloud;
}

// Particles of base and levels.
NEPHELE_FN uint column_count(CellParts parts) {
  if (parts.levels == 0u) return 0u;
  uint above = parts.levels - 1u;
  return 1u + (parts.turn == 0u ? above : (parts.turn == 1u ? (above + 1u) / 2u : above / 2u));
}
NEPHELE_FN uint particle_count(CellParts parts) { return column_count(parts) + parts.crown + parts.wisps; }

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

// The n-th covered place, counted round and round.
NEPHELE_FN uint covered_quadrant(vec4 core, uint n) {
  uint covered = 0u;
  for (int i = 0; i < 4; ++i) covered += core[i] > 0.0f ? 1u : 0u;
  uint left = n % max(covered, 1u);
  for (int i = 0; i < 4; ++i) {
    if (core[i] <= 0.0f) continue;
    if (left == 0u) return uint(i);
    --left;
  }
  return 0u;
}

NEPHELE_FN float covered_share(vec4 core) {
  float covered = 0.0f;
  for (int i = 0; i < 4; ++i) covered += core[i] > 0.0f ? 0.25f : 0.0f;
  return covered;
}

NEPHELE_FN float column_density(float core) { return mix(0.4f, 1.0f, smooth_ramp(0.0f, 0.22f, core)); }

// Slope of the cloud's top across the quadrants.
NEPHELE_FN vec2 cell_slope(CellCloud cloud, GridCell cell) {
  vec4 h = cloud.height_m;
  return vec2(h.y - h.x + h.w - h.z, h.z - h.x + h.w - h.y) / cell.size_m;
}

// Radius at which one ellipsoid hides as much of what lies behind it as the covered places do. Its depth falls off from
// its middle about as 3 tau (1 - b^2)^2, tau the mean over the disc, so that of the disc's area
// 1 - sqrt(pi / (12 tau)) erf(sqrt(3 tau)) is hidden: x, in which tau in turn is that of the column times x.
NEPHELE_FN float closing_radius_m(CloudField field, GridCell cell, CellCloud cloud) {
  float share = covered_share(cloud.core);
  float height = dot(cloud.height_m, vec4(0.25f)) / share;
  float depth = kMeanFill * field.extinction_per_m * kColumnFill * height;
  float hidden = max(0.45f, 1.0f - 0.886f * inversesqrt(max(3.0f * depth, 1.0f)));
  return cell.size_m * sqrt(share / (kPi * hidden)) / 0.9f;
}

struct CloudParticle {
  vec3 center_m;  // grid space
  vec3 radius_m;
  float yaw_rad;
  float density;
  float base_m;
  float top_m;
  uint id;
};

// Particle `slot` < particle_count(parts) of a cell, before the gains, with altitudes counted from the flat base.
NEPHELE_FN CloudParticle particle_over_base(CloudField field, CloudParams params, GridCell cell, CellCloud cloud,
                                            uint slot) {
  uint cell_id = cell_hash(field, params, cell);
  uint h = hash_uint(cell_id + (slot + 1u) * kSlotSpread);
  CellParts parts = cloud.parts;
  uint quadrant = covered_quadrant(cloud.core, slot + (cell_id & 3u));
  vec2 p = quadrant_place(field, params, cell, quadrant);
  float core = cloud.core[int(quadrant)];
  float height = cloud.height_m[int(quadrant)];
  float edge_m = core * cloud.radius_m;
  float c = cell.size_m;
  vec2 slope = cell_slope(cloud, cell);
  float steepness = length(slope);

  CloudParticle particle;
  particle.id = h;
  particle.base_m = 0.0f;
  particle.top_m = height;
  particle.yaw_rad = uniform_float(h, 0.0f, 2.0f * kPi);
  particle.density = column_density(core);
  float long_axis = uniform_float(h, 0.9f, 1.1f);

  // Shrinks towards the edge and keeps the extent as cells double; but it fills the area that the places stand for.
  // Nor is a tower narrower than two fifths of its height.
  float reach = clamp(edge_m + 60.0f, max(closing_radius_m(field, cell, cloud), min(0.4f * height, 0.6f * c)), c);
  float filled = max(height, min(0.5f * reach, 92.0f));
  float base_up = min(0.55f * filled, mix(1.2f, 0.55f, covered_share(cloud.core)) * reach);
  float coarse = 1.0f - kFinestM / max(c, kFinestM);
  uint column = column_count(parts);
  if (slot == 0u) {
    float across = 0.9f * reach;
    vec2 at = mix(cloud.center_m, p, 0.5f);
    particle.radius_m = vec3(across * long_axis, across / long_axis, base_up);
    particle.center_m = vec3(at.x, at.y, 0.3f * base_up + uniform_float(h, -15.0f, 15.0f));
  } else if (slot < column) {
    uint level = parts.turn == 0u ? slot : 2u * slot - (parts.turn == 1u ? 1u : 0u);
    float intervals = float(parts.levels - 1u);
    float t = float(level) / intervals;
    float across = reach * mix(1.0f, mix(0.7f, 0.85f, coarse), t) * uniform_float(h, 0.85f, 1.15f) *
                   (parts.turn == 0u ? 0.9f : 1.1f);
    // When fewer levels than the height asks for are allowed, they stretch so that the column stays closed.
    float up = max(min(0.9f * across, 0.5f * filled),
                   min(0.6f * (filled - base_up) / intervals, (parts.turn == 0u ? 1.6f : 4.0f) * across));
    float z = min(mix(base_up, filled - 0.8f * up, t), height - 0.8f * up);
    particle.radius_m = vec3(across * long_axis, across / long_axis, up);
    particle.center_m = vec3(p.x, p.y, max(z, 0.0f));
    if (filled < 1.6f * base_up) particle.density = 0.0f;
  } else if (slot < column + parts.crown) {
    // The R2 sequence (Roberts 2018) fills the quadrants evenly; near the edge particles stay close to the place, since
    // much of the quadrant lies outside.
    float spread = 0.5f * c * mix(0.8f, 1.1f, saturate(edge_m / c));
    float ux = unit_float(cell_id) + 0.7548776662f * float(slot);
    float uy = unit_float(cell_id * 0x9e3779b9u) + 0.5698402910f * float(slot);
    vec2 offset = spread * vec2(ux - floor(ux) - 0.5f, uy - floor(uy) - 0.5f);
    float u = unit_float(hash_next(h));
    float radius =
        0.45f * c * mix(0.45f, 1.7f, u * u * u) * cloud.texture_scale * mix(0.6f, 1.0f, smooth_ramp(0.0f, 0.3f, core));
    float up = min(0.9f * radius, 0.45f * filled);
    radius = min(radius, mix(5.0f, 2.2f, coarse) * up);  // large cells on low clouds: no wide flat discs
    float inward = 0.5f * up / sqrt(1.0f + steepness * steepness);
    vec4 h4 = cloud.height_m;
    float surface = clamp(height + dot(slope, offset), 0.5f * height, max(max(h4.x, h4.y), max(h4.z, h4.w)));
    particle.top_m = max(height, surface);
    float wall =
        max(steepness, 2.2f * (1.0f - covered_share(cloud.core)));  // slopes and edges are covered from top to foot
    float z = surface * (1.0f - 0.8f * unit_float(hash_next(h)) * saturate((wall - 0.7f) / 1.5f)) - inward;
    particle.radius_m = vec3(radius * long_axis, radius / long_axis, up);
    particle.center_m = vec3(p.x + offset.x + inward * slope.x, p.y + offset.y + inward * slope.y, max(z, 0.6f * up));
  } else {
    float radius = uniform_float(h, 92.0f, 184.0f);
    float outward = uniform_float(h, 18.0f, 129.0f) / max(steepness, 1e-3f);
    float z = uniform_float(h, 0.15f, 0.9f) * max(height, 180.0f);
    particle.radius_m = vec3(radius * long_axis, radius / long_axis, 0.45f * radius);
    particle.center_m = vec3(p.x - outward * slope.x, p.y - outward * slope.y, z);
    particle.density *= uniform_float(h, 0.04f, 0.14f);
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

// The gains that give base and upper particles together the matter and centre of mass that the columns have.
NEPHELE_FN void find_gains(CloudField field, CloudParams params, GridCell cell, NEPHELE_INOUT(CellCloud) cloud) {
  vec2 wanted = vec2(0.0f);
  for (int i = 0; i < 4; ++i) {
    float matter = cloud.core[i] > 0.0f ? column_density(cloud.core[i]) * cloud.height_m[i] : 0.0f;
    wanted += matter * vec2(1.0f, kColumnCenter * cloud.height_m[i]);
  }
  wanted *= kColumnFill * 0.25f * cell.size_m * cell.size_m;
  vec2 base = matter_over_base(particle_over_base(field, params, cell, cloud, 0u));
  vec2 upper = vec2(0.0f);
  uint bound = column_count(cloud.parts) + cloud.parts.crown;
  for (uint slot = 1u; slot < bound; ++slot)
    upper += matter_over_base(particle_over_base(field, params, cell, cloud, slot));

  float base_z = base.y / base.x;
  float upper_z = upper.y / max(upper.x, 1e-6f);
  float wanted_z = wanted.y / max(wanted.x, 1e-6f);
  float share = base.x / (base.x + upper.x);  // of the base in the cell's matter
  if (upper.x > 0.0f && upper_z > base_z) share = clamp((upper_z - wanted_z) / (upper_z - base_z), 0.1f, 0.9f);
  cloud.base_gain = min(kMaxGain, share * wanted.x / base.x);
  cloud.upper_gain = upper.x > 0.0f ? min(kMaxGain, (1.0f - share) * wanted.x / upper.x) : 0.0f;
}

NEPHELE_FN CellCloud cell_cloud(CloudField field, CloudParams params, GridCell cell) {
  CellCloud cloud;
  cloud.parts.levels = 0u;
  cloud.parts.turn = 0u;
  cloud.parts.crown = 0u;
  cloud.parts.wisps = 0u;
  cloud.core = vec4(0.0f);
  cloud.height_m = vec4(0.0f);
  cloud.center_m = vec2(0.0f);
  cloud.radius_m = 0.0f;
  cloud.texture_scale = 0.0f;
  cloud.base_gain = 1.0f;
  cloud.upper_gain = 1.0f;
  float covered = 0.0f;
  float edge_m = 0.0f;
  for (uint i = 0u; i < 4u; ++i) {
    vec2 p = quadrant_place(field, params, cell, i);
    CloudSample s = cloud_sample(params, p);
    if (s.d <= 0.0f) continue;
    cloud.core[int(i)] = max(s.d, 1.0f / 255.0f);
    cloud.height_m[int(i)] = cloud_height_m(params, p, s);
    cloud.center_m += p;
    cloud.radius_m += s.edge_m / s.d;
    edge_m += s.edge_m;
    // Regions of the sky differ in texture: smooth domes here, crisp small ones there.
    cloud.texture_scale += clamp(1.0f + s.warp_m.x * (1.2f / kWarpM), 0.6f, 1.6f);
    covered += 1.0f;
  }
  if (covered == 0.0f) return cloud;
  cloud.center_m /= covered;
  cloud.radius_m /= covered;
  cloud.texture_scale /= covered;
  edge_m /= covered;
  float height = dot(cloud.height_m, vec4(1.0f)) / covered;

  float c = cell.size_m;
  float levels = ceil((height - 0.5f * c) / (0.9f * c)) + 1.0f;
  cloud.parts.levels = uint(clamp(levels, 1.0f, float(min(field.layer_count, kMaxLevels))));
  if (c > kFinestM) cloud.parts.levels = max(cloud.parts.levels, 2u);
  uint lattice = ring_lattice(field, cell.ring);
  if (edge_m > 1.1f * c && cloud.parts.levels > 1u) {
    uvec2 world = lattice_base(params.origin_index, lattice) + uvec2(cell.index);
    cloud.parts.turn = 1u + ((world.x ^ world.y) & 1u);
  }
  vec2 slope = cell_slope(cloud, cell);
  float steepness = min(kCrownSteepest, sqrt(1.0f + dot(slope, slope)));
  float coarse = 1.0f - kFinestM / max(c, kFinestM);
  uint h = cell_hash(field, params, cell);
  float crown = field.crown_per_cell * (steepness + coarse) * 0.25f * covered + unit_float(hash_uint(h ^ kSlotSpread));
  cloud.parts.crown = uint(min(crown, float(kMaxCrown)));
  cloud.parts.wisps = cell.ring == 0u && edge_m < 0.3f * cloud.radius_m ? 1u : 0u;
  find_gains(field, params, cell, cloud);
  return cloud;
}

NEPHELE_FN CloudParticle cell_particle(CloudField field, CloudParams params, GridCell cell, CellCloud cloud,
                                       uint slot) {
  CloudParticle particle = particle_over_base(field, params, cell, cloud, slot);
  if (slot == 0u)
    particle.density *= cloud.base_gain;
  else if (slot < column_count(cloud.parts) + cloud.parts.crown)
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
  particle.radius_m = made.radius_m;
  particle.yaw_rad = made.yaw_rad;
  particle.orientation = pack_orientation(random_rotation(u0, u1, u2));
  particle.flags = kParticleDetail | (cell.ring << kParticleRingShift) | (source << kParticleSourceShift);
  particle.base_m = made.base_m;
  particle.top_m = made.top_m;
  particle.radiance_per_sr = vec3(0.0f);
  particle.id = made.id;
  return particle;
}

NEPHELE_SHARED_END

#endif
