#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// The particles' extinction, by their mean profile, averaged over the cells of one level, as a sum of vertical chords,
// which have a closed form. Chords are half a cell apart, a cell in particles of many cells, and a quarter of the
// particle's radius where that is smaller than a cell, so that no matter is lost between them. A particle's rows of
// chords are shared out to as many threads as keep each within the rounds of loops that a driver grants
// (layer/driver_limit.glsl).
#include "light/light_lattice_buffer.glsl"
#include "kit/texels.glsl"
#include "shared/flat_base.h"
#include "shared/light.h"
#include "shared/world.h"

layout(local_size_x = 64) in;
PARTICLES(1, particles);
layout(scalar, set = 0, binding = 2) readonly buffer Counters { FrameCounters counters; };
layout(scalar, set = 0, binding = 3) buffer Cells { uint cells[]; };
layout(push_constant, scalar) uniform Push {
  uint level;
  uint threads;  // a particle
};

#include "kit/light_lattice.glsl"

const float kManyCells = 12.0;

// Half the least width of the silhouette.
float narrowest_m(Occluder o) {
  const vec3 shape = o.shape_per_m2;
  return inversesqrt(0.5 * (shape.x + shape.z) + length(vec2(0.5 * (shape.x - shape.z), shape.y)));
}

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= counters.particle_count) return;
  const Particle p = particle_at(particles, i);
  LightBounds bounds;
  const Occluder upright = make_occluder(p, mat3(1.0), 0.0, bounds);  // as a sun in the zenith sees it
  const vec3 center_m = grid_from_render(p.center_m, vec3(0.0));
  const float cell_m = lattice.levels[level].cell_m, layer_m = lattice.layer_m;
  const vec2 middle_m = center_m.xy - lattice.levels[level].corner_m;
  const float across_m = max(bounds.extent_m.x, bounds.extent_m.y), narrow_m = narrowest_m(upright);
  const float side_m = float(lattice.side) * cell_m;
  if (any(lessThan(middle_m, vec2(-across_m))) || any(greaterThan(middle_m, vec2(side_m + across_m)))) return;

  const bool aligned = narrow_m >= cell_m;
  const float step_m = aligned ? (across_m > kManyCells * cell_m ? cell_m : 0.5 * cell_m) : 0.25 * narrow_m;
  const vec2 first_m = aligned ? floor((middle_m - across_m) / step_m) * step_m : middle_m - across_m;
  const int steps =
      int(ceil((middle_m.x + across_m - min(first_m.x, first_m.y + middle_m.x - middle_m.y)) / step_m)) + 1;
  const float unit =
      kLightFixedPoint * upright.extinction_per_m * upright.half_m * step_m * step_m / (cell_m * cell_m * layer_m);
  const float base_m = has_base(p.base_m) ? p.base_m - lattice.lowest_m : -1e9;
  for (int row = int(gl_GlobalInvocationID.y); row < steps; row += int(threads))
    for (int column = 0; column < steps; ++column) {
      const vec2 at_m = first_m + (vec2(column, row) + 0.5) * step_m;
      const vec2 aside_m = at_m - middle_m;
      const float h2 = silhouette(upright, aside_m.x, aside_m.y);
      const ivec2 place = ivec2(floor(at_m / cell_m));
      if (h2 <= 0.0 || any(lessThan(place, ivec2(0))) || any(greaterThanEqual(place, ivec2(lattice.side)))) continue;
      const float half_m = upright.half_m * sqrt(h2);
      const float height_m = center_m.z - lattice.lowest_m + dot(upright.slope, aside_m);  // of the chord's middle
      const float from_m = max(max(height_m - half_m, base_m), 0.0), to_m = height_m + half_m;
      float low_m = from_m;
      for (int z = int(floor(from_m / layer_m)); low_m < to_m && z < int(lattice.height); ++z) {
        const float high_m = min(to_m, float(z + 1) * layer_m);
        const float matter = profile_integral((high_m - height_m) / upright.half_m, h2, p.flags) -
                             profile_integral((low_m - height_m) / upright.half_m, h2, p.flags);
        const uint amount = uint(max(unit * matter * base_fade(0.5 * (low_m + high_m) - base_m), 0.0) + 0.5);
        if (amount > 0u) atomicAdd(cells[(z * int(lattice.side) + place.y) * int(lattice.side) + place.x], amount);
        low_m = high_m;
      }
    }
}
