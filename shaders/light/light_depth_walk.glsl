// Optical depth along a direction through the lattice's own extinction: half a cell a step, in a level's window as long
// as the way lies in it, and in the next coarser one from there on. The including shader declares LightLattice lattice
// and sampler3D extinction (1/m, all levels).
#ifndef NEPHELE_LIGHT_DEPTH_WALK_GLSL
#define NEPHELE_LIGHT_DEPTH_WALK_GLSL

#include "kit/light_lattice.glsl"

const float kOpaqueDepth = 40.0;

float depth_along(vec3 d, uint level, vec3 from_m) {
  const float top_m = lattice.lowest_m + float(lattice.height) * lattice.layer_m;
  const float out_m = (d.z > 0.0 ? top_m - from_m.z : from_m.z - lattice.lowest_m) / max(abs(d.z), 1e-6);
  // From below or above the lattice the way begins where it comes in; volumes hold other windows there.
  const float in_m = (d.z > 0.0 ? lattice.lowest_m - from_m.z : from_m.z - top_m) / max(abs(d.z), 1e-6);
  float depth = 0.0, at_m = max(in_m, 0.0);
  const float planes = float(textureSize(extinction, 0).z);
  for (; level < lattice.level_count; ++level) {
    const uint plane = lattice.levels[level].extinction_plane;
    const float cell_m = lattice.levels[level].cell_m;
    const vec2 low_m = lattice.levels[level].corner_m - from_m.xy;
    const vec2 high_m = low_m + float(lattice.side) * cell_m;
    const vec2 ways_m = vec2(abs(d.x) > 1e-6 ? (d.x > 0.0 ? high_m.x : low_m.x) / d.x : 1e9,
                             abs(d.y) > 1e-6 ? (d.y > 0.0 ? high_m.y : low_m.y) / d.y : 1e9);
    const float end_m = min(out_m, min(ways_m.x, ways_m.y));
    if (any(greaterThan(abs(low_m + high_m), high_m - low_m))) continue;  // it begins beside the window
    const float step_m = 0.5 / max(max(abs(d.x), abs(d.y)) / cell_m, abs(d.z) / lattice.layer_m);
    while (at_m < end_m && depth < kOpaqueDepth) {
      const float length_m = min(step_m, end_m - at_m);
      const vec3 p_m = from_m + (at_m + 0.5 * length_m) * d;
      const vec3 uvw = light_volume_coordinates(light_cell_position(level, p_m), plane, planes);
      depth += length_m * textureLod(extinction, uvw, 0.0).x;
      at_m += length_m;
    }
    if (at_m >= out_m || depth >= kOpaqueDepth) break;
  }
  return depth;
}

float depth_to_sun(uint level, vec3 from_m) { return depth_along(lattice.sun_direction, level, from_m); }

#endif
