// Tiles with short lists on a CPU: eight threads, each with a column of pixels. A CPU driver executes every branch and
// every loop's body for all eight threads, whether or not one of them needs it. So the loop that shades does nothing
// else: it puts segments on a stack, and once a column is done, all threads blend their segments row by row. The
// picture is the one that cloud_tiles.comp makes.
// variants: volume=BLEND_VOLUME exact=BLEND_EXACT
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#define PACKED_TABLE 16
#define EXACT_SLOTS 8  // another stretch costs little here: the segments are on the stack
#include "shared/exact_blend.h"
#include "shared/screen_bounds.h"
#include "shared/types.h"

layout(local_size_x = 8) in;

#include "layer/packed_table_fetch.glsl"
#include "layer/cloud_tiles.glsl"

const uint kStack = kColumnPlaces;  // segments: those of one pixel always fit
BlendSegment stack[kStack];
// Segments that a pixel of the exact blend may go through, before it merges: two rounds each and those of events, times
// eight pixels, stay below the driver's limit (driver_limit.glsl).
const uint kColumnExactSegments = 2048u;

// A thread's pixel in a row: a knight's move on from row to row, so that threads share a cloud's edge whichever way it
// runs.
uint column_of(uint thread, uint row) { return (thread + 3u * row) % kScreenTilePx; }

// The list's places whose particles may cover a pixel of this thread, row by row in words of 32 places: made once, so
// that the next place is a bit of a word at hand.
const uint kWordPlaces = 32u,
           kRowWords = kColumnPlaces / kWordPlaces;  // 8: Cursor has a bit for each word of eight rows
uint covering[kScreenTilePx * kRowWords];

// The next place to shade is the lowest of `bits`, which are what is left of a word; `left` has a bit for each word
// after it that holds any, those of rows 0 to 3 in x. There is no loop in any step: on a CPU each round of the loop
// that shades pays for the body of every loop in it.
struct Cursor {
  uint word, bits;
  uvec2 left;
};

uint row_of(Cursor cursor) { return cursor.word / kRowWords; }
uint place_of(Cursor cursor, uvec2 range) {
  return range.x + cursor.word % kRowWords * kWordPlaces + uint(findLSB(cursor.bits));
}

uvec2 words_from_row(uint row) {
  return uvec2(row < 4u ? ~0u << (row * kRowWords) : 0u, row < 4u ? ~0u : ~0u << ((row - 4u) * kRowWords));
}

void next_word(inout Cursor cursor) {
  if (cursor.bits != 0u || cursor.left == uvec2(0u)) return;
  const bool upper = cursor.left.x != 0u;
  cursor.word = uint(findLSB(upper ? cursor.left.x : cursor.left.y)) + (upper ? 0u : 32u);
  if (upper)
    cursor.left.x &= cursor.left.x - 1u;
  else
    cursor.left.y &= cursor.left.y - 1u;
  cursor.bits = covering[cursor.word];
}

void next_row(inout Cursor cursor) {
  cursor.bits = 0u;
  const uint row = row_of(cursor);
  cursor.left &= row + 1u < kScreenTilePx ? words_from_row(row + 1u) : uvec2(0u);
  next_word(cursor);
}

// Fills `covering`; the words that hold any places.
uvec2 find_covering(uint thread, uvec2 range) {
  uvec2 held = uvec2(0u);
  for (uint first = range.x; first < range.y; first += kWordPlaces) {
    uint words[kScreenTilePx];
    for (uint r = 0u; r < kScreenTilePx; ++r) words[r] = 0u;
    const uint count = min(kWordPlaces, range.y - first);
    for (uint k = 0u; k < count; ++k) {
      const uvec2 mask = two_words_at(masks, first + k);
      for (uint r = 0u; r < kScreenTilePx; ++r)
        words[r] |= (((r < 4u ? mask.x : mask.y) >> (kScreenTilePx * (r & 3u) + column_of(thread, r))) & 1u) << k;
    }
    const uint word = (first - range.x) / kWordPlaces;
    for (uint r = 0u; r < kScreenTilePx; ++r) {
      covering[r * kRowWords + word] = words[r];
      if (words[r] != 0u) held[r / 4u] |= 1u << (r % 4u * kRowWords + word);
    }
  }
  return held;
}

// Counts of eight rows, 16 bits each.
void add_to_row(inout uvec4 counts, uint row, uint more) {
  for (uint k = 0u; k < 4u; ++k) counts[k] += row / 2u == k ? more << (16u * (row % 2u)) : 0u;
}
uint count_of_row(uvec4 counts, uint row) {
  uint two = counts.x;
  for (uint k = 1u; k < 4u; ++k) two = row / 2u == k ? counts[k] : two;
  return (two >> (16u * (row % 2u))) & 0xffffu;
}

#ifdef BLEND_VOLUME

// Blends a pixel's segments on the stack.
vec4 blend_row(uint first, uint past, out float first_m) {
  BlendState state = blend_empty();
  for (uint k = past; k > first; --k) blend_add(state, stack[k - 1u]);
  blend_finish(state);
  first_m = state.first_m;
  return vec4(state.committed, state.transmittance);
}

#else

float begins_here_m[kStack];  // of a segment and all after it

vec4 blend_row(uint first, uint past, out float first_m) {
  float begin_m = kNoMatterM;
  for (uint k = past; k > first; --k) {
    begin_m = min(begin_m, stack[k - 1u].near_m);
    begins_here_m[k - 1u] = begin_m;
  }
  ExactState state = exact_empty();
  uint k = first, passed = 0u;
  for (bool more = past > first; more;) {
    const bool ends = k == past;
    exact_advance(state, ends ? kNoMatterM : begins_here_m[k]);
    if (ends || begins_here_m[k] >= state.horizon_m || state.transmittance < kOpaqueTransmittance) {
      more = exact_next_stretch(state);
      passed += k - first;
      state.merges = passed + 2u * (past - first) > kColumnExactSegments;
      k = first;
    } else {
      exact_add(state, stack[k++]);
    }
  }
  first_m = state.first_m;
  return vec4(state.radiance, state.transmittance);
}

#endif

void main() {
  uvec2 tile, range;
  if (!find_tile(tile, range)) return;
  const uint thread = gl_LocalInvocationID.x;
  const uvec2 first_pixel = tile * kScreenTilePx;
  const uint rows = min(kScreenTilePx, frame.layer_size_px.y - first_pixel.y);
  uint shaded = 0u;
  const uvec2 held = find_covering(thread, range);
  for (uint from_row = 0u; from_row < rows;) {
    // Forward: up to the last row, or to the one whose segments find no room; that one is begun anew afterwards.
    Cursor cursor = Cursor(0u, 0u, held & words_from_row(from_row));
    uint row = from_row, count = 0u;
    uvec4 row_counts = uvec4(0u);
    OpaqueFront front = opaque_front_empty();
    bool full = false;
    next_word(cursor);
    while (cursor.bits != 0u && !full) {
      const uint place = place_of(cursor, range);
      cursor.bits &= cursor.bits - 1u;
      if (row_of(cursor) != row) front = opaque_front_empty();
      row = row_of(cursor);
      const uvec2 pixel = first_pixel + uvec2(column_of(thread, row), row);
      const vec3 direction = pixel_direction((vec2(pixel) + 0.5) * float(frame.scale), frame.image_size_px);
      const float limit_m = texelFetch(layer_scene, ivec2(pixel), 0).x;
      BlendSegment segment;
      if (shade_particle(draw_particle_at(draw_particles, word_at(list, place)), direction, limit_m, segment)) {
        ++shaded;
        opaque_front_add(front, segment);
        full = count == kStack;
        if (!full) {
          stack[count++] = segment;
          add_to_row(row_counts, row, 1u);
        }
      }
      next_word(cursor);
      if (cursor.bits != 0u && row_of(cursor) == row &&
          opaque_front_hides(front, float_at(begins_m, place_of(cursor, range))))
        next_row(cursor);
    }
    // Back: the stack's top is the last row's farthest segment.
    const uint past_row = full ? row : rows;
    if (full) count -= count_of_row(row_counts, row);
    for (uint r = kScreenTilePx; r-- > 0u;) {
      if (r >= from_row && r < past_row) {
        const uint past = count;
        count -= count_of_row(row_counts, r);
        float first_m;
        const vec4 color = blend_row(count, past, first_m);
        const uvec2 pixel = first_pixel + uvec2(column_of(thread, r), r);
        if (pixel.x < frame.layer_size_px.x) {
          imageStore(layer_color, ivec2(pixel), color);
          imageStore(layer_depth, ivec2(pixel), first_matter(first_m));
        }
      }
    }
    from_row = past_row;
  }
  count_work(shaded);
}
