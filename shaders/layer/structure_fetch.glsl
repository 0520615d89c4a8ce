// The noise of shared/structure.h at places, sampled. The including shader declares FrameConstants frame and sampler3D
// structure_tile_volume.
#ifndef NEPHELE_STRUCTURE_FETCH_GLSL
#define NEPHELE_STRUCTURE_FETCH_GLSL

#include "shared/structure.h"

// Width of a layer's pixel, metres, at this distance.
float pixel_width_m(float distance_m) {
  return distance_m * 2.0 /
         (length(vec3(frame.clip_from_render[0][1], frame.clip_from_render[1][1], frame.clip_from_render[2][1])) *
          float(frame.layer_size_px.y));
}

// The noise along a stretch of a ray about middle_m, seen from near_m on: what all its places have in common is found
// once.
struct StructureRay {
  vec3 large, large_per_m, small, small_per_m;  // places of the two octaves at t metres: x + t * x_per_m
  vec3 broad, broad_per_m;                      // and of the broad form
  float large_weight, small_weight, broad_share;
  float pixel_m;
};

StructureRay structure_ray(vec3 direction, float middle_m, float near_m) {
  const float pixel_m = pixel_width_m(max(near_m, 0.0));
  const vec3 air_m = structure_air_m(direction * middle_m, frame.camera_grid_m) - middle_m * direction;
  return StructureRay(structure_place(0u, air_m), structure_place(0u, direction), structure_place(1u, air_m),
                      structure_place(1u, direction), structure_place(kStructureBroad, air_m),
                      structure_place(kStructureBroad, direction), structure_weight(0u) * structure_share(0u, pixel_m),
                      structure_weight(1u) * structure_share(1u, pixel_m), structure_share(kStructureBroad, pixel_m),
                      pixel_m);
}

float structure_on(StructureRay ray, float at_m) {
  float sum = ray.large_weight * (textureLod(structure_tile_volume, ray.large + at_m * ray.large_per_m, 0.0).x - 0.5);
  for (float left = ray.small_weight; left > 0.0; left = 0.0)
    sum += left * (textureLod(structure_tile_volume, ray.small + at_m * ray.small_per_m, 0.0).x - 0.5);
  return structure_noise(sum);
}

// The broad form, for a particle that it moves.
float broad_structure_on(StructureRay ray, float at_m, float broad_depth) {
  float broad = 0.0;
  for (float left = broad_depth; left > 0.0; left = 0.0)
    broad = ray.broad_share * (textureLod(structure_tile_volume, ray.broad + at_m * ray.broad_per_m, 0.0).x - 0.5);
  return broad;
}

#endif
