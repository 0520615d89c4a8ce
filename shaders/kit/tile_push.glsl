// What the steps of tile_pairs.h are pushed: where in the counters, as an array of uint, their numbers stand.
#ifndef NEPHELE_TILE_PUSH_GLSL
#define NEPHELE_TILE_PUSH_GLSL

layout(push_constant, scalar) uniform Push {
  uint item_count_at, pair_demand_at, pair_count_at, pair_groups_at;
  uint item_capacity, pair_capacity;
  uint tile_columns;
};

#endif
