// What one procedural cloud field is in one frame.
//
// CloudField holds everything that the content of the field's cells depends on and nothing else: cells that were found
// under the same bytes still hold. Fill it from zeros, so that bytes between members are equal too.
#ifndef NEPHELE_SHARED_FIELD_CONSTANTS_H
#define NEPHELE_SHARED_FIELD_CONSTANTS_H

#include "prelude.h"

NEPHELE_SHARED_BEGIN

NEPHELE_CONST(uint, kMaxRings, 8u);
NEPHELE_CONST(uint, kCloudLattices, 3u);  // of features, in three spacings (cloud_features.h)

// Where a weather map lies in grid space. Whole texels are integers, so that a place 10 000 km out is as precise as one
// at home.
struct WeatherPlacement {
  ivec2 size;   // texels along x and y; 0: there is no map
  ivec2 base;   // the texel whose middle is south-west of the grid origin, or at it; rows counted from the south
  vec2 offset;  // of the grid origin from that middle, texels in [0, 1)
  vec2 per_m;   // texels a metre
};

struct CloudField {
  ivec2 origin_index;      // grid origin = origin_index * kOriginUnitM in the field's air (the world minus its wind)
  ivec2 camera_cell;       // the finest ring's cell that the camera is in (place_camera in ring_grid.h)
  float growth_turns;      // of the cycle of growth and decay since time 0, [0, 1); below 0: clouds keep their size
  uint seed;               // of everything random
  float coverage;          // share of the sky under clouds, 0 .. 1; beyond the weather map where there is one
  float base_m;            // altitude of the flat bases
  float thickness_m;       // height of the tallest clouds above the base
  float extinction_per_m;  // peak extinction of a particle of density 1
  float view_distance_m;   // clouds fade over its last fifth
  uint first_ring;         // the finest that has cells; 0 for what the camera sees
  uint ring_count;         // from there on; first_ring + ring_count <= kMaxRings
  uint ring_size_cells;    // cells along a ring's side, a multiple of 8
  uint layer_count;        // particles stacked in a cell, base included
  float inner_cell_m;      // cell size of ring 0, doubling per ring
  float crown_per_cell;    // crown particles of a level cloud top in one cell; about 2.5 at full quality
  WeatherPlacement weather;
};

struct FieldFrame {
  CloudField field;
  vec3 camera_grid_m;  // the camera in the field's grid space; z = altitude
};

// The part of a lattice that particles can ask for while the camera stays in its finest cell: a square around it.
struct FeatureWindow {
  ivec2 corner;  // lattice cell, counted from the grid origin
  int side;
  uint first;  // index of its first feature among all lattices'
};

// Binding 0 of the field's kernels. The windows are the CPU's, so that writer and readers of features agree.
struct FieldConstants {
  FieldFrame frame;
  FeatureWindow windows[kCloudLattices];
  FeatureWindow near_windows[kCloudLattices];  // where features_near says which features reach into a lattice cell
  uint source;                                 // index of the field among the scene's sources of clouds
  uint capacity;                               // particles that the field may have
};

// Counters and indirect arguments of one field.
struct FieldCounters {
  uint kept_distance_bins;   // cells in farther bins than these found no room
  uint cell_count;           // occupied cells
  uint cell_particle_count;  // their particles
  uint found_cell_count;     // cells that may get a weight
  uvec3 found_cell_groups;   // indirect dispatch: ceil(found_cell_count / 64), 1, 1
  uvec3 thin_groups;         // indirect dispatch over the cells: nothing when all find room
};

NEPHELE_SHARED_END

#ifdef __cplusplus
static_assert(sizeof(nephele::shared::WeatherPlacement) == 32);
static_assert(sizeof(nephele::shared::CloudField) == 100);
static_assert(sizeof(nephele::shared::FieldFrame) == 112);
static_assert(sizeof(nephele::shared::FeatureWindow) == 16);
static_assert(sizeof(nephele::shared::FieldConstants) == 216);
static_assert(sizeof(nephele::shared::FieldCounters) == 40);
#endif

#endif
