// Structure of clouds below a particle's size: one noise of the air, the same for all particles, displaces their
// surfaces. A particle with structure is a ball in its reference space whose radius at a place p is displaced_radius()
// of the noise at p: neighbours bulge and recede together, so creases run across the seams between them. Everything
// that asks for the clouds' density, the shading of chords, the ray marcher and the path tracer, asks for this
// function; light and shadows ask for its mean over the noise (particle_profile in light.h).
//
// The noise is one tile with billows from 118 m down to 15 m, and near the eye the same tile again, sixteen times as
// small. Bodies of which 118 m is a small part, as there are in coarse rings, have its broad form as well, eight times
// as large. What is finer than the pixel that looks at it gives way to its mean. After: Schneider and Vos, The
// Real-Time Volumetric Cloudscapes of Horizon Zero Dawn (2015), in that billows are inverted Worley noise; Perlin and
// Hoffert, Hypertexture (1989), in that noise moves the boundary.
#ifndef NEPHELE_SHARED_STRUCTURE_H
#define NEPHELE_SHARED_STRUCTURE_H

#include "noise.h"
#include "types.h"
#include "world.h"

NEPHELE_SHARED_BEGIN

NEPHELE_CONST(uint, kStructureTexels, 128u);  // a side of the tile
NEPHELE_CONST(uint, kStructureCells, 4u);     // its largest billows along a side
NEPHELE_CONST(uint, kStructureOctaves, 2u);   // sizes of the tile in the noise
NEPHELE_CONST(uint, kStructureBroad, 2u);     // one more size, apart: the broad form's

NEPHELE_FN float billows(vec3 p, uint size, uint seed) {
  float f1 = worley_f1_periodic(p * float(size), kStructureCells * size, seed);
  return 1.0f - f1 * f1;
}

// The tile at p, 0 <= p < kStructureCells: round billows with sharp creases between them and smaller ones on top, in
// [0, 1] with mean 0.5 and standard deviation 0.15.
NEPHELE_CONST(float, kStructureBillowMean, 0.696f);  // of the sum below
NEPHELE_FN float structure_tile(vec3 p) {
  float sum = 0.4f * billows(p, 1u, 11u) + 0.3f * billows(p, 2u, 12u) + 0.19f * billows(p, 4u, 13u) +
              0.11f * billows(p, 8u, 14u);
  return clamp(0.5f + 1.45f * (sum - kStructureBillowMean), 0.0f, 1.0f);
}

// Tiles in kOriginUnitM of an octave: a whole number, so that the noise does not know where a grid's origin is.
NEPHELE_FN float structure_tiles(uint octave) {
  return octave == 0u ? 200.0f : (octave == kStructureBroad ? 25.0f : 3201.0f);
}
NEPHELE_FN float structure_tile_m(uint octave) { return kOriginUnitM / structure_tiles(octave); }

// Share of an octave in the noise.
NEPHELE_FN float structure_weight(uint octave) { return octave == 0u ? 1.4f : 0.15f; }

// What is left of an octave where a pixel is this wide.
NEPHELE_FN float structure_share(uint octave, float pixel_m) {
  float tile_m = structure_tile_m(octave);
  return 1.0f - smoothstep(tile_m / 26.0f, tile_m / 6.5f, pixel_m);
}

// Where an octave's tiles are looked up: the air of the scene, in tiles, the axes in another order each time.
// camera_grid_m: FrameConstants. The planet's curvature counts, arcs and chords are not told apart.
NEPHELE_FN vec3 structure_air_m(vec3 p_render_m, vec3 camera_grid_m) {
  float drop_m = (p_render_m.x * p_render_m.x + p_render_m.y * p_render_m.y) * (0.5f / kPlanetRadiusM);
  return camera_grid_m + p_render_m + vec3(0.0f, 0.0f, drop_m);
}
NEPHELE_FN vec3 structure_place(uint octave, vec3 air_m) {
  vec3 p = air_m;
  if (octave == 1u) p = vec3(air_m.y, air_m.z, air_m.x);
  if (octave == kStructureBroad) p = vec3(air_m.z, air_m.x, air_m.y);
  return p * (structure_tiles(octave) / kOriginUnitM);
}

NEPHELE_CONST(float, kStructureMean, 0.6f);  // broad domes, narrow creases

// The noise from the sum over octaves of weight * share * (tile - 0.5).
NEPHELE_FN float structure_noise(float sum) { return clamp(kStructureMean + sum, 0.0f, 1.0f); }

// How far the noise moves the surface of a particle of this mean radius, in its radii; 0: it has no structure.
NEPHELE_CONST(float, kStructureDeepest, 0.6f);
NEPHELE_CONST(float, kStructureDepthM, 150.0f);
// Torn ones, edges that evaporate and wisps, are moved much farther, so that they fall into shreds.
NEPHELE_CONST(float, kTornDepth, 2.0f);
NEPHELE_FN float structure_depth(float radius_m, uint flags) {
  if ((flags & kParticleDetail) == 0u) return 0.0f;
  float torn = float((flags >> kParticleTornShift) & kMostTorn) / float(kMostTorn);
  float whole = min(kStructureDeepest, kStructureDepthM / radius_m);
  return mix(whole, kTornDepth, torn);
}

// How torn a particle of this depth is.
NEPHELE_FN float torn_of_depth(float depth) {
  return clamp((depth - kStructureDeepest) / (kTornDepth - kStructureDeepest), 0.0f, 1.0f);
}

// How far the broad form moves the surface, in radii, so that it is moved as far in all as that of a small particle, at
// each place of the air (standard deviations .21 of the noise, .15 of a tile).
NEPHELE_CONST(float, kBroadDepth, 0.84f);
NEPHELE_FN float structure_broad_depth(float depth) {
  float fine = min(depth / kStructureDeepest, 1.0f);
  return kBroadDepth * sqrt(1.0f - fine * fine);
}

// Radius of the displaced ball in its reference space: where the noise is at its mean the same for particles of all
// sizes, so that neither a pixel that is too wide for the noise nor a coarser ring sees other clouds. The bounds cut
// one place of twenty off; with a stronger noise they would show as arcs, but not in the torn, which are smaller and
// thin towards their bounds.
NEPHELE_CONST(float, kStructureMeanRadius, 0.8f);
NEPHELE_CONST(float, kTornMeanRadius, 0.66f);
NEPHELE_FN float mean_displaced_radius(float depth) {
  return mix(kStructureMeanRadius, kTornMeanRadius, torn_of_depth(depth));
}
// broad: the broad form, a tile less its mean.
NEPHELE_FN float displaced_radius(float depth, float noise, float broad) {
  float moved = depth * (noise - kStructureMean) + structure_broad_depth(depth) * broad;
  return clamp(mean_displaced_radius(depth) + moved, 0.05f, 1.0f);
}

// Density of the ball of this radius at a squared distance r2 from its centre: even inside, with a soft skin; the torn
// thin out from their middle on.
NEPHELE_CONST(float, kStructureSkin, 0.35f);  // of 1 - r^2 where the density is full
NEPHELE_CONST(float, kTornSkin, 0.95f);
NEPHELE_FN float structure_skin(float depth) { return mix(kStructureSkin, kTornSkin, torn_of_depth(depth)); }
NEPHELE_FN float structured_density(float r2, float radius, float skin) {
  float q = clamp((1.0f - r2 / (radius * radius)) / skin, 0.0f, 1.0f);
  return q * q * (3.0f - 2.0f * q);
}

// A soft particle has no surface to be displaced: many of them overlap where a volume has been made into particles, and
// their sum is the volume's density. The noise makes that density more and less, in proportion, so that its mean stays
// whatever the footprint of a pixel leaves of the noise. Below 0: the particle is not soft.
NEPHELE_CONST(float, kSoftDetail, 1.6f);  // at full detail; at 1 / kStructureMean the thinnest places are empty
NEPHELE_FN float soft_detail(uint flags) {
  float share = float((flags >> kParticleSoftShift) & kMostSoftDetail) / float(kMostSoftDetail);
  return (flags & kParticleSoft) != 0u ? kSoftDetail * share : -1.0f;
}
NEPHELE_FN float soft_variation(float detail, float noise) { return 1.0f + detail * (noise - kStructureMean); }

NEPHELE_SHARED_END

#endif
