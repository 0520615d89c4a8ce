#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "light/occluders.glsl"

// Each texel: how much of the sunlight along one ray the clouds take away, and where along it. All but the first
// channel are multiplied by the first, so that bilinear filtering ignores texels without cloud.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint kTexelsPerTile = 2u;  // along a side; a power of 2, at most 8

layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
OCCLUDERS(1, occluders);
layout(scalar, set = 0, binding = 2) readonly buffer Ranges { uvec2 ranges[]; };
WORDS(3, list);
layout(set = 0, binding = 4, rgba32f) writeonly uniform image2D shadow;
layout(scalar, set = 0, binding = 5) readonly buffer ShadowTiles {
  uvec3 tile_groups;
  uint tile_count;
  uint shadow_tiles[];
};  // shadow_tiles.comp

const float kOpaqueTransmittance = 1.0e-3;  // the rest of the list changes less than this
const float kSlightOpacity = 1.0e-3;        // too little to count as the clouds' beginning or end

void main() {
  // Neighbouring threads share a tile, and so its list.
  const uint texels = kTexelsPerTile * kTexelsPerTile;
  const uint place = gl_GlobalInvocationID.x / texels;
  if (place >= tile_count) return;
  const uint tile_index = shadow_tiles[place];
  const uint texel_index = gl_GlobalInvocationID.x % texels;
  const uvec2 texel = uvec2(tile_index % kLightTiles, tile_index / kLightTiles) * kTexelsPerTile +
                      uvec2(texel_index % kTexelsPerTile, texel_index / kTexelsPerTile);
  const vec2 across_m = light_across((vec2(texel) + 0.5) / float(kLightTiles * kTexelsPerTile), frame.view_distance_m);

  const vec3 up = frame.light_from_render[2];
  const vec3 far_end = vec3(across_m, -1.0e30);
  const uvec2 range = ranges[tile_index];
  float transmittance = 1.0;
  float top_m = -1.0e30, bottom_m = 1.0e30, weighted_m = 0.0;
  for (uint i = range.x; i < range.y && transmittance > kOpaqueTransmittance; ++i) {
    const Occluder occluder = occluder_at(occluders, word_at(list, i));
    const SunChord chord = sun_chord(occluder, far_end, up);
    const float opacity = transmittance * (1.0 - exp(-chord_depth(occluder, chord)));
    transmittance -= opacity;
    const float begin_m = chord.middle_m + chord.begin * occluder.half_m;
    const float end_m = chord.middle_m + chord.end * occluder.half_m;
    weighted_m += opacity * 0.5 * (begin_m + end_m);
    if (opacity > kSlightOpacity) {
      top_m = max(top_m, end_m);
      bottom_m = min(bottom_m, begin_m);
    }
  }

  vec4 value = vec4(0.0);
  if (top_m > bottom_m) {
    const float opacity = 1.0 - transmittance;
    const float mean_m = clamp(weighted_m / opacity, bottom_m, top_m);
    value = opacity * vec4(1.0, light_warp(top_m), light_warp(mean_m), light_warp(bottom_m));
  }
  imageStore(shadow, ivec2(texel), value);
}
