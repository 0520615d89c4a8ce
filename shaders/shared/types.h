// Structures that the CPU and every pass share: scalar block layout, so C++ and GLSL agree field by field.
// Spaces: *render space* has the world's axes (x east, y north, z up) and its origin at the camera, with the
// planet's curvature applied; *grid space* has xy in metres from a snapped origin in the air
// (world minus wind drift) and z = altitude. See world.h for both mappings.
#ifndef NEPHELE_SHARED_TYPES_H
#define NEPHELE_SHARED_TYPES_H

#include "ellipsoid.h"
#include "prelude.h"

NEPHELE_SHARED_BEGIN

// Binding 0 of every pass: what is constant over one frame.
struct FrameConstants {
  mat4 clip_from_render;  // projection * rotation; Vulkan clip space, y down, reverse-free depth unused
  mat4 render_from_clip;  // its inverse: direction of a pixel = normalize((M * vec4(ndc, 1, 1)).xyz)
  vec3 camera_grid_m;     // camera in the air that drifts with the wind of the scene; z = altitude
  vec3 sun_direction;     // unit, towards the sun, at the camera
  float sun_angular_radius_rad;
  vec3 sun_irradiance;  // top of the atmosphere
  float exposure;       // linear scale before tone mapping
  vec3 ground_albedo;
  uint atmosphere_enabled;
  uvec2 image_size_px;  // full resolution
  uvec2 layer_size_px;  // cloud layer: ceil(image / scale)
  uint scale;           // 1, 2 or 4
  uint ground_enabled;
  // What all clouds of the scene together are (passes/sources/cloud_source.h)
  float view_distance_m;  // of the source that reaches farthest
  float clouds_top_m;     // altitude above which there is none
  float phase_g;          // asymmetry of the phase function
  uint phase_function;    // 0 Henyey-Greenstein, 1 Cornette-Shanks
  // Light space: light_from_render * p_render = (u, v) across and w towards the sun, metres (light.h)
  mat3 light_from_render;
  uint host_scene;       // 1: a host has drawn what stands behind the clouds
  uint culling_enabled;  // 0: every particle counts as visible
  uint detail_enabled;   // 0: particles have smooth surfaces (structure.h)
  float light_unit;      // of radiance in the light field (light_field_unit())
};

// Particle.flags
NEPHELE_CONST(uint, kParticleHomogeneous, 1u);  // constant extinction inside the ellipsoid
NEPHELE_CONST(uint, kParticleEmissive, 2u);     // radiance_per_sr is the source colour; no lighting
NEPHELE_CONST(uint, kParticleDetail, 4u);       // surface displaced by the air's structure (structure.h)
NEPHELE_CONST(uint, kParticleSoft, 8u);         // falls off as particle_profile (light.h)
NEPHELE_CONST(uint, kParticleSoftShift, 4u);    // bits 4 .. 7: detail of a soft one, of kMostSoftDetail (structure.h)
NEPHELE_CONST(uint, kMostSoftDetail, 15u);
NEPHELE_CONST(uint, kParticleRingShift, 8u);   // bits 8 .. 10: the ring of a field's particle
NEPHELE_CONST(uint, kParticleTornShift, 11u);  // bits 11 .. 15: how torn its structure is, of kMostTorn (structure.h)
NEPHELE_CONST(uint, kMostTorn, 31u);
NEPHELE_CONST(uint, kParticleSourceShift, 16u);  // bits 16 .. 31: index of the source that made it

struct Particle {
  vec3 center_m;           // render space
  float extinction_per_m;  // peak, times density and level-of-detail weight; 0 is never listed
  EllipsoidShape shape;    // in render space
  uint flags;
  uint orientation;  // of the reference particle in its unit space: quaternion as snorm8x4 (packSnorm4x8, xyzw)
  float base_m;      // altitude of the flat base that cuts the particle off; kNoBaseM: none (flat_base.h)
  float top_m;       // altitude of the cloud's top above this particle, for sky light; own top if listed
  uint id;           // hash of its cell and slot: breaks ties, seeds noise
  uint unused;
  vec3 radiance_per_sr;  // source colour when kParticleEmissive
  uint unused2;
};

// Sunlight at one visible particle (same index as the visible list).
struct ParticleLight {
  vec3 sun_irradiance;      // after the atmosphere, before any cloud
  float tau_sun;            // optical depth towards the sun through the other particles, at the centre
  vec3 tau_gradient_per_m;  // of that depth, for a linear variation inside the particle (clamped when used)
  float own_depth;          // 1: the two above are known; 0: they are not, and the light field's depth counts
};

// Everything that shading one visible particle needs, in drawing order. *Reference space* is the unit space of the
// ellipsoid, turned into the frame of the reference particle inside: the ellipsoid is the unit sphere there.
struct DrawParticle {
  mat3 reference_from_render;
  vec3 center_m;         // render space
  vec3 light_direction;  // unit, reference space, the way sunlight travels
  float extinction_per_m;
  vec3 sun_irradiance;
  float optical_radius;     // of the homogeneous sphere that has this particle's mean density
  vec3 tau_gradient_per_m;  // render space
  float tau_sun;
  vec3 ambient_radiance;  // of sky and ground, where light comes from tables
  float base_m;
  vec3 radiance_per_sr;
  uint flags;
  vec3 field_place;       // of the centre in the light field's volume, unit coordinates
  float own_depth_share;  // of the depth towards the sun by tau_sun and the particle itself; the rest by the field
  vec2 field_per_m;       // unit coordinates a metre across and up
  float structure_depth;  // of its surface (structure.h), 0: none
  float soft_detail;      // how strongly the air's structure varies its density (structure.h), below 0: it is not soft
};

// What one source of clouds has put into the particle buffer, and what passes may assume about its clouds.
struct SourceRecord {
  uint first;              // slot of its first particle
  uint count;              // its particles, from there on
  uint demand;             // what it would have put there with room enough
  uvec3 groups;            // indirect dispatch: ceil(count / 64), 1, 1
  float extinction_per_m;  // of its clouds where they are dense
};

// Counters and indirect arguments that the passes of a frame fill. demand may exceed the capacity; count never does.
struct FrameCounters {
  uint particle_demand;
  uint particle_count;
  uint visible_demand;
  uint visible_count;
  uint tile_pair_demand;  // (light tile, particle) pairs
  uint tile_pair_count;
  uint pairs_shaded;        // (pixel, particle) pairs that the tiled backend shaded
  uvec3 particle_groups;    // indirect dispatch: ceil(particle_count / 64), y and z as the frame began
  uvec3 visible_groups;     // indirect dispatch: ceil(visible_count / 64), 1, 1
  uvec3 tile_pair_groups;   // indirect dispatch over tile_pair_count (kit/pair_dispatch.glsl)
  uvec4 draw;               // indirect draw: 6 * visible_count vertices, 1 instance
  uint screen_pair_demand;  // (screen tile, particle) pairs of the tiled backend
  uint screen_pair_count;
  uvec3 screen_pair_groups;  // indirect dispatch over screen_pair_count
  uint rays_cut_short;       // threads of the tiled backend whose loops the driver ended
};

NEPHELE_SHARED_END

#ifdef __cplusplus
static_assert(sizeof(nephele::shared::Particle) == 80);
static_assert(sizeof(nephele::shared::ParticleLight) == 32);
static_assert(sizeof(nephele::shared::DrawParticle) == 160);
static_assert(sizeof(nephele::shared::SourceRecord) == 28);
#endif

#endif
