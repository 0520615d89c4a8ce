// From the cloud field to the particles of a grid cell (after [Yusov14] 5.2: several layers, smaller ones above, random
// rotation and displacement). A particle is a function of its world cell alone; only its weight knows the camera.
//
// A cell's particles, in order of slots:
//   base    one flattened ellipsoid, later cut off at the flat base;
//   levels  fill the column up to the height field. Deep inside a cloud neighbouring cells take turns, so that levels
//           are packed like stacked balls and half of them are spared;
//   crown   small ones on the surface, half sunk in: the domes' relief;
//   wisp    a thin one drifting off the edge (finest ring).
#ifndef NEPHELE_SHARED_CLOUD_PARTICLES_H
#define NEPHELE_SHARED_CLOUD_PARTICLES_H

#include "cloud_field.h"
#include "ellipsoid.h"

NEPHELE_SHARED_BEGIN

NEPHELE_CONST(uint, kParticleRingShift, 8u);  // in Particle.flags
NEPHELE_CONST(uint, kMaxLevels, 15u);
NEPHELE_CONST(uint, kMaxCrown, 15u);
NEPHELE_CONST(uint, kSeedCell, 0xc000u);      // + ring
NEPHELE_CONST(uint, kSlotSpread, 0x68bc21ebu);
NEPHELE_CONST(float, kCrownSteepest, 2.5f);   // slopes beyond it get no more crown particles
NEPHELE_CONST(float, kFinestM, 184.0f);       // the cell size that needs no correction for coarseness

// What stands in a cell, packed in 15 bits.
struct CellParts {
  uint levels;   // heights to fill, the base included; 0: nothing here
  uint turn;     // 0: every level, 1: the odd ones, 2: the even ones above the base
  uint crown;
  uint wisps;
  uint depth;    // fifteenths of a cell from the base's place to the cloud's edge, at most 15
};

NEPHELE_FN uint pack_parts(CellParts parts) {
  return parts.levels | (parts.turn << 4u) | (parts.crown << 6u) | (parts.wisps << 10u) | (parts.depth << 11u);
}
NEPHELE_FN CellParts unpack_parts(uint bits) {
  CellParts parts;
  parts.levels = bits & 15u;
  parts.turn = (bits >> 4u) & 3u;
  parts.crown = (bits >> 6u) & 15u;
  parts.wisps = (bits >> 10u) & 1u;
  parts.depth = (bits >> 11u) & 15u;
  return parts;
}

// Particles of base and levels.
NEPHELE_FN uint column_count(CellParts parts) {
  if (parts.levels == 0u) return 0u;
  uint above = parts.levels - 1u;
  return 1u + (parts.turn == 0u ? above : (parts.turn == 1u ? (above + 1u) / 2u : above / 2u));
}
NEPHELE_FN uint particle_count(CellParts parts) { return column_count(parts) + parts.crown + parts.wisps; }

NEPHELE_FN uint cell_hash(CloudParams params, GridCell cell, uint lattice) {
  return hash_uvec2(lattice_base(params.origin_index, lattice) + uvec2(cell.index), params.seed + kSeedCell + cell.ring);
}

// Where the cell's base stands, and whether anything stands in it at all.
NEPHELE_FN vec2 base_place(GridCell cell, uint hash) {
  uint h = hash;
  float jx = uniform_float(h, 0.15f, 0.85f);
  float jy = uniform_float(h, 0.15f, 0.85f);
  return cell.corner_m + cell.size_m * vec2(jx, jy);
}

// Slope of the cloud's top.
NEPHELE_FN vec2 height_gradient(CloudParams params, vec2 p_m, float height_m) {
  const float kStepM = 40.0f;
  vec2 px = p_m + vec2(kStepM, 0.0f);
  vec2 py = p_m + vec2(0.0f, kStepM);
  return vec2(cloud_height_m(params, px, cloud_sample(params, px)) - height_m,
              cloud_height_m(params, py, cloud_sample(params, py)) - height_m) / kStepM;
}

NEPHELE_FN CellParts cell_parts(FrameConstants frame, CloudParams params, GridCell cell) {
  CellParts parts;
  parts.levels = 0u;
  parts.turn = 0u;
  parts.crown = 0u;
  parts.wisps = 0u;
  parts.depth = 0u;
  uint lattice = ring_lattice(frame, cell.ring);
  uint h = cell_hash(params, cell, lattice);
  vec2 p = base_place(cell, h);
  CloudSample s = cloud_sample(params, p);
  if (s.d <= 0.0f) return parts;
  float height = cloud_height_m(params, p, s);
  float c = cell.size_m;
  float levels = ceil((height - 0.5f * c) / (0.9f * c)) + 1.0f;
  parts.levels = uint(clamp(levels, 1.0f, float(min(frame.layer_count, kMaxLevels))));
  parts.depth = uint(15.0f * saturate(s.edge_m / c));
  if (s.edge_m > 1.1f * c && parts.levels > 1u) {
    uvec2 world = lattice_base(params.origin_index, lattice) + uvec2(cell.index);
    parts.turn = 1u + ((world.x ^ world.y) & 1u);
  }
  vec2 slope = height_gradient(params, p, height);
  float steepness = min(kCrownSteepest, sqrt(1.0f + slope.x * slope.x + slope.y * slope.y));
  float coarse = 1.0f - kFinestM / max(c, kFinestM);
  float crown = frame.crown_per_cell * (steepness + coarse) + unit_float(hash_uint(h ^ kSlotSpread));
  parts.crown = uint(min(crown, float(kMaxCrown)));
  parts.wisps = cell.ring == 0u && s.d < 0.3f ? 1u : 0u;
  return parts;
}

struct CloudParticle {
  vec3 center_m;     // grid space
  vec3 radius_m;
  float yaw_rad;
  float density;     // 0: fell outside the cloud
  float base_m;
  float top_m;
  uint id;
};

// Particle `slot` < particle_count(parts) of a cell.
NEPHELE_FN CloudParticle cell_particle(FrameConstants frame, CloudParams params, GridCell cell, CellParts parts, uint slot) {
  uint cell_id = cell_hash(params, cell, ring_lattice(frame, cell.ring));
  uint h = hash_uint(cell_id + (slot + 1u) * kSlotSpread);
  CloudParticle particle;
  particle.id = h;
  float c = cell.size_m;
  uint column = column_count(parts);
  bool in_column = slot < column;
  bool in_crown = !in_column && slot < column + parts.crown;

  // The base stands where the cell was tested. The others fill the cell evenly (the R2 sequence, Roberts 2018), but
  // near the cloud's edge they gather around the base, since much of the cell lies outside.
  vec2 p = base_place(cell, cell_id);
  if (slot > 0u) {
    float inside = float(parts.depth) * (1.0f / 15.0f);
    float spread = mix(0.5f, in_column ? 0.7f : 1.1f, inside);
    vec2 center = p + inside * (cell.corner_m + vec2(0.5f * c) - p);
    float ux = unit_float(cell_id) + 0.7548776662f * float(slot);
    float uy = unit_float(cell_id * 0x9e3779b9u) + 0.5698402910f * float(slot);
    p = center + spread * c * vec2(ux - floor(ux) - 0.5f, uy - floor(uy) - 0.5f);
  }
  CloudSample s = cloud_sample(params, p);
  float height = cloud_height_m(params, p, s);
  vec2 slope = height_gradient(params, p, height);
  float steepness = sqrt(slope.x * slope.x + slope.y * slope.y);
  float base = cloud_base_m(params, p);
  particle.base_m = base;
  particle.top_m = base + height;
  particle.yaw_rad = uniform_float(h, 0.0f, 2.0f * kPi);
  particle.density = s.d > 0.0f ? mix(0.4f, 1.0f, smooth_ramp(0.0f, 0.22f, s.d)) : 0.0f;
  float long_axis = uniform_float(h, 0.9f, 1.1f);

  // Shrinks towards the edge and keeps the extent as cells double; but cells larger than the clouds have to fill the
  // area they stand for, and make up in density what they lack in overlap.
  float coarse = 1.0f - kFinestM / max(c, kFinestM);
  float reach = clamp(s.edge_m + 60.0f, mix(0.45f, 0.62f, coarse) * c, c);
  float gather = mix(1.0f, min(3.0f, c * c / (reach * reach)), coarse);
  float filled = max(height, min(0.5f * reach, 92.0f));
  float base_up = 0.55f * min(reach, filled);
  if (in_column) {
    particle.density *= gather;
    if (slot == 0u) {
      float across = 0.9f * reach;
      particle.radius_m = vec3(across * long_axis, across / long_axis, base_up);
      particle.center_m = vec3(p.x, p.y, base + 0.3f * base_up + uniform_float(h, -15.0f, 15.0f));
    } else {
      uint level = parts.turn == 0u ? slot : 2u * slot - (parts.turn == 1u ? 1u : 0u);
      float intervals = float(parts.levels - 1u);
      float t = float(level) / intervals;
      float across = reach * mix(1.0f, 0.7f, t) * uniform_float(h, 0.85f, 1.15f) * (parts.turn == 0u ? 0.9f : 1.1f);
      // When fewer levels than the height asks for are allowed, they stretch so that the column stays closed.
      float up = max(min(0.9f * across, 0.5f * filled), min(0.6f * (filled - base_up) / intervals, (parts.turn == 0u ? 1.6f : 4.0f) * across));
      float z = min(mix(base_up, filled - 0.8f * up, t), height - 0.8f * up);
      particle.radius_m = vec3(across * long_axis, across / long_axis, up);
      particle.center_m = vec3(p.x, p.y, base + max(z, 0.0f));
      if (filled < 1.6f * base_up) particle.density = 0.0f;
    }
  } else if (in_crown) {
    // Regions of the sky differ in texture: smooth domes here, crisp small ones there.
    float texture_scale = clamp(1.0f + s.warp_m.x * (1.2f / kWarpM), 0.6f, 1.6f);
    float u = unit_float(hash_next(h));
    float radius = 0.45f * c * mix(0.45f, 1.7f, u * u * u) * texture_scale * mix(0.6f, 1.0f, smooth_ramp(0.0f, 0.3f, s.d));
    float up = min(0.9f * radius, 0.45f * filled);
    radius = min(radius, mix(5.0f, 2.2f, coarse) * up);  // large cells on low clouds: no wide flat discs
    float inward = 0.5f * up / sqrt(1.0f + steepness * steepness);
    float z = height * (1.0f - 0.8f * unit_float(hash_next(h)) * saturate((steepness - 0.7f) / 1.5f)) - inward;
    particle.radius_m = vec3(radius * long_axis, radius / long_axis, up);
    particle.center_m = vec3(p.x + inward * slope.x, p.y + inward * slope.y, base + max(z, 0.6f * up));
  } else {
    float radius = uniform_float(h, 92.0f, 184.0f);
    float outward = uniform_float(h, 18.0f, 129.0f) / max(steepness, 1e-3f);
    float z = uniform_float(h, 0.15f, 0.9f) * max(height, 180.0f);
    particle.radius_m = vec3(radius * long_axis, radius / long_axis, 0.45f * radius);
    particle.center_m = vec3(p.x - outward * slope.x, p.y - outward * slope.y, base + z);
    particle.density *= uniform_float(h, 0.04f, 0.14f);
  }
  return particle;
}

// As the renderer keeps it: in render space, faded by the cell's level-of-detail weight.
NEPHELE_FN Particle render_particle(FrameConstants frame, GridCell cell, CloudParticle made) {
  uint h = hash_uint(made.id);
  float u0 = unit_float(h);
  float u1 = unit_float(hash_next(h));
  float u2 = unit_float(hash_next(h));
  Particle particle;
  particle.center_m = render_from_grid(made.center_m, frame.camera_grid_m);
  particle.extinction_per_m = frame.extinction_per_m * made.density * cell_weight(frame, cell);
  particle.radius_m = made.radius_m;
  particle.yaw_rad = made.yaw_rad;
  particle.orientation = pack_orientation(random_rotation(u0, u1, u2));
  particle.flags = kParticleDetail | (cell.ring << kParticleRingShift);
  particle.base_m = made.base_m;
  particle.top_m = made.top_m;
  particle.radiance_per_sr = vec3(0.0f);
  particle.id = made.id;
  return particle;
}

NEPHELE_SHARED_END

#endif
