// The volume blend of tiles with short lists on a CPU: eight threads, each with a column of pixels. There all lanes go
// through every branch and every loop's body, needed or not, so the loop that shades does nothing else: segments go to a
// stack, and once a column is through, all lanes fold theirs row by row. The picture is cloud_tiles.comp's.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/blend.h"
#include "shared/screen_bounds.h"
#include "shared/types.h"

layout(local_size_x = 8) in;

#include "cloud_tiles.glsl"

const uint kStack = kColumnPlaces;  // segments: those of one pixel always fit
BlendSegment stack[kStack];
uint row_begin[kScreenTilePx + 1u];  // of each row's segments in the stack

// The list's places whose particles may cover a pixel of this thread's column: words of 32 places, a row after the other in
// each. Made once, so that the next place is one look at a word; looking at the masks one place after the other took the
// eight threads half a million rounds a frame, a quarter of the time.
const uint kWordPlaces = 32u;
uint covering[kColumnPlaces / kWordPlaces * kScreenTilePx];

// A thread's pixel in a row: a knight's move on from row to row, so that threads share a cloud's edge whichever way it runs.
uint column_of(uint thread, uint row) { return (thread + 3u * row) % kScreenTilePx; }

void find_covering(uint thread, uvec2 range) {
  for (uint first = range.x; first < range.y; first += kWordPlaces) {
    uint words[kScreenTilePx];
    for (uint r = 0u; r < kScreenTilePx; ++r) words[r] = 0u;
    const uint count = min(kWordPlaces, range.y - first);
    for (uint k = 0u; k < count; ++k) {
      const uvec2 mask = two_words_at(masks, first + k);
      for (uint r = 0u; r < kScreenTilePx; ++r)
        words[r] |= (((r < 4u ? mask.x : mask.y) >> (kScreenTilePx * (r & 3u) + column_of(thread, r))) & 1u) << k;
    }
    for (uint r = 0u; r < kScreenTilePx; ++r) covering[(first - range.x) / kWordPlaces * kScreenTilePx + r] = words[r];
  }
}

// The first place from `at` on that may cover the row's pixel; the range's end when there is none.
uint next_covering(uint at, uvec2 range, uint row) {
  uint word = 0u;
  uint i = (at - range.x) / kWordPlaces;
  uint keep = 0xffffffffu << ((at - range.x) % kWordPlaces);
  while (word == 0u && range.x + i * kWordPlaces < range.y) {
    word = covering[i++ * kScreenTilePx + row] & keep;
    keep = 0xffffffffu;
  }
  return word == 0u ? range.y : range.x + (i - 1u) * kWordPlaces + uint(findLSB(word));
}

void main() {
  uvec2 tile, range;
  if (!find_tile(tile, range)) return;
  const float opaque_depth = -log(kOpaqueTransmittance);
  const uint thread = gl_LocalInvocationID.x;
  const uvec2 first_pixel = tile * kScreenTilePx;
  const uint rows = min(kScreenTilePx, frame.layer_size_px.y - first_pixel.y);
  uint shaded = 0u;
  find_covering(thread, range);
  for (uint from_row = 0u; from_row < rows;) {
    // Forward: up to the last row, or to the one whose segments find no room; that one is begun anew afterwards.
    uint row = from_row, place = range.x, count = 0u;
    float depth = 0.0, reach_m = 0.0;
    bool full = false;
    row_begin[row] = 0u;
    for (;;) {
      bool has_place = false;
      while (!has_place && row < rows && !full) {
        place = next_covering(place, range, row);
        // Where the pixel is opaque and a gap follows, the rest cannot change what is in front of it (cloud_tiles.comp).
        has_place = place < range.y && !(depth >= opaque_depth && float_at(begins_m, place) >= reach_m);
        if (!has_place) {
          row_begin[++row] = count;
          place = range.x;
          depth = reach_m = 0.0;
        }
      }
      if (!has_place) break;
      const uvec2 pixel = first_pixel + uvec2(column_of(thread, row), row);
      const vec3 direction = pixel_direction((vec2(pixel) + 0.5) * float(frame.scale), frame.image_size_px);
      const float limit_m = texelFetch(layer_scene, ivec2(pixel), 0).x;
      BlendSegment segment;
      if (shade_particle(draw_particle_at(draw_particles, word_at(list, place)), direction, limit_m, segment)) {
        ++shaded;
        reach_m = max(reach_m, segment.far_m);
        depth += segment.extinction_per_m * (segment.far_m - segment.near_m);
        full = count == kStack;
        if (!full) stack[count++] = segment;
      }
      ++place;
    }
    // Back: the stack's top is the last row's farthest segment.
    if (full) count = row_begin[row];
    const uint past_row = row;
    for (uint r = kScreenTilePx; r-- > 0u;) {
      if (r >= from_row && r < past_row) {
        BlendState state = blend_empty();
        while (count > row_begin[r]) blend_add(state, stack[--count]);
        blend_finish(state);
        const uvec2 pixel = first_pixel + uvec2(column_of(thread, r), r);
        if (pixel.x < frame.layer_size_px.x) {
          imageStore(layer_color, ivec2(pixel), vec4(state.committed, state.transmittance));
          imageStore(layer_depth, ivec2(pixel), first_matter(state.first_m));
        }
      }
    }
    from_row = past_row;
  }
  count_work(shaded);
}
