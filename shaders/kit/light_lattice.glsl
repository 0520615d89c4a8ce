// The lattice as the passes of the light field read it, and its volumes. The including shader declares
// LightLattice lattice.
#ifndef NEPHELE_LIGHT_LATTICE_GLSL
#define NEPHELE_LIGHT_LATTICE_GLSL

#include "shared/light_lattice.h"

ivec3 light_cell_place(uint cell) {
  const uint row = cell / lattice.side;
  return ivec3(cell - row * lattice.side, row % lattice.side, row / lattice.side);
}

// Middle of a cell of a level, from the reference point; z = altitude.
vec3 light_cell_middle(uint level, ivec3 place) {
  const vec3 p = vec3(place) + 0.5;
  return vec3(lattice.levels[level].corner_m + p.xy * lattice.levels[level].cell_m,
              lattice.lowest_m + p.z * lattice.layer_m);
}

// A point in cells of a level.
vec3 light_cell_position(uint level, vec3 p_m) {
  return vec3((p_m.xy - lattice.levels[level].corner_m) / lattice.levels[level].cell_m,
              (p_m.z - lattice.lowest_m) / lattice.layer_m);
}

// The same as unit coordinates of a volume of so many planes, in which the window's lowest layer is `plane`.
vec3 light_volume_coordinates(vec3 position, uint plane, float planes) {
  return vec3(position.xy / float(lattice.side), (float(plane) + position.z) / planes);
}

#endif
