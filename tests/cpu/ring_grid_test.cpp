// The ring grid: nesting, numbering and weights.
#include <doctest/doctest.h>

#include <random>

#include "shared/ring_grid.h"
#include "tests/support/cloud_frame.h"

using namespace nephele::shared;
using nephele::test::cloud_frame;

namespace {

FieldFrame frame_at(float x, float y, uint rings = 4, uint size = 104) {
  FieldFrame frame = cloud_frame();
  place_camera(frame, {ivec2(0), vec3(x, y, 1500.0f)});
  frame.field.ring_count = rings;
  frame.field.ring_size_cells = size;
  return frame;
}

}  // namespace

TEST_CASE("the rings' weights sum to one up to the fade, and to it beyond") {
  for (const uint size : {8u, 104u, 136u, 184u})
    for (const uint rings : {1u, 2u, 4u, 8u})
      for (const float view_m : {1.0f, 100.0f, 5000.0f, 80000.0f, 1e6f}) {
        const FieldFrame frame = frame_at(0, 0, rings, size);
        FieldFrame limited = frame;
        limited.field.view_distance_m = view_m;
        const float reach = cloud_reach_m(limited.field);
        CHECK(reach <= view_m);
        float least = 1.0f, worst = 0.0f;
        for (int i = 0; i <= 2000; ++i) {
          const float distance = reach * 1.2f * static_cast<float>(i) / 2000.0f;
          float sum = 0;
          for (uint ring = 0; ring < rings; ++ring) {
            const float w = lod_weight(limited.field, ring, distance);
            least = min(least, w);
            sum += w;
          }
          worst = max(worst, abs(sum - clamp((reach - distance) / (0.2f * reach), 0.0f, 1.0f)));
        }
        CHECK(least >= 0.0f);
        CHECK(worst < 1e-6f);  // two terms, x and 1 - x
      }
}

TEST_CASE("weights are continuous in the distance") {
  const FieldFrame frame = frame_at(0, 0);
  for (uint ring = 0; ring < frame.field.ring_count; ++ring) {
    const float overlap = 104.0f / 16.0f * 184.0f;  // the narrowest fade of all
    float steepest = 0.0f;
    for (float distance = 0; distance < 90000.0f; distance += 7.0f)
      steepest =
          max(steepest,
              abs(lod_weight(frame.field, ring, distance + 7.0f) - lod_weight(frame.field, ring, distance)) / 7.0f);
    CHECK(steepest < 1.01f / overlap);
    CHECK(steepest > 0.0f);
  }
}

TEST_CASE("rings nest, hold the camera in their middle, and miss no cell that shows") {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> place(-47104.0f, 47104.0f);
  for (int i = 0; i < 300; ++i) {
    // The first ones stand exactly on corners.
    const FieldFrame frame = i < 20 ? frame_at(1472.0f * static_cast<float>(i - 10), 184.0f * static_cast<float>(i))
                                    : frame_at(place(random), place(random));
    const int side = static_cast<int>(frame.field.ring_size_cells);
    for (uint ring = 0; ring < frame.field.ring_count; ++ring) {
      const ivec2 corner = ring_corner(frame.field, ring);
      const float cell = ring_cell_m(frame.field, ring);
      CHECK((corner.x & 1) == 0);
      CHECK((corner.y & 1) == 0);
      const vec2 middle = vec2(corner + side / 2) * cell;
      CHECK(abs(middle.x - frame.camera_grid_m.x) <= cell * 1.0001f);
      CHECK(abs(middle.y - frame.camera_grid_m.y) <= cell * 1.0001f);
      // Cells just outside have no weight, corner to corner.
      uint showing = 0;
      for (int k = -1; k <= side; ++k)
        for (const ivec2 offset : {ivec2(k, -1), ivec2(k, side), ivec2(-1, k), ivec2(side, k)}) {
          GridCell outside;
          outside.ring = ring;
          outside.index = corner + offset;
          outside.size_m = cell;
          outside.corner_m = vec2(outside.index) * cell;
          FieldFrame endless = frame;
          endless.field.ring_count = ring + 2u;  // not the last ring: its own border counts, not the view distance
          showing += cell_weight(endless, outside) > 0.0f;
        }
      CHECK(showing == 0u);
      if (ring + 1u < frame.field.ring_count) {  // the next ring's hole is made of its whole cells
        const ivec2 next = ring_corner(frame.field, ring + 1u);
        CHECK(corner.x / 2 >= next.x);
        CHECK(corner.x / 2 + side / 2 <= next.x + side);
      }
    }
  }
}

TEST_CASE("cells are numbered by place and found again") {
  const FieldFrame frame = frame_at(-12345.0f, 30001.0f);
  CHECK(grid_cell_count(frame.field) == 4u * 104u * 104u);
  for (uint i = 0; i < grid_cell_count(frame.field); i += 37u) {
    const GridCell cell = grid_cell(frame.field, i);
    CHECK(grid_cell_at(frame.field, cell.ring, cell.corner_m + vec2(0.5f * cell.size_m)) == i);
  }
  CHECK(grid_cell_at(frame.field, 0u, vec2(-12345.0f + 20000.0f, 30001.0f)) == kNoCell);
  CHECK(grid_cell_at(frame.field, 0u, vec2(-12345.0f, 30001.0f - 9800.0f)) == kNoCell);
}

TEST_CASE("a view distance shorter than a cell leaves nothing but what stands on the camera") {
  FieldFrame frame = frame_at(500.0f, 500.0f);
  frame.field.view_distance_m = 1.0f;
  uint shown = 0;
  for (uint i = 0; i < grid_cell_count(frame.field); ++i)
    shown += cell_weight(frame, grid_cell(frame.field, i)) > 0.0f ? 1u : 0u;
  CHECK(shown == 0u);
}
