// Frame constants of a cloud scene without a renderer, for tests of the passes that make and use particles.
#pragma once

#include <glm/glm.hpp>

#include "engine/camera.h"
#include "shared/ring_grid.h"

namespace nephele::test {

// 104^2 cells in three rings, coverage 0.4, fair-weather heights; the camera looks as it stands in `camera`.
inline shared::FrameConstants cloud_frame(const CameraState& camera = {}) {
  shared::FrameConstants frame{};
  const CameraMatrices matrices = camera_matrices(camera, 16.0 / 9.0);
  frame.clip_from_render = matrices.clip_from_render;
  frame.render_from_clip = matrices.render_from_clip;
  frame.ground_enabled = 1;
  frame.culling_enabled = 1;
  frame.clouds_enabled = 1;
  frame.seed = 5;
  frame.coverage = 0.4f;
  frame.base_m = 1200.0f;
  frame.thickness_m = 1400.0f;
  frame.extinction_per_m = 0.04f;
  frame.view_distance_m = 80000.0f;
  frame.ring_count = 3;
  frame.ring_size_cells = 104;
  frame.layer_count = 5;
  frame.crown_per_cell = 2.5f;
  frame.inner_cell_m = 184.0f;
  shared::place_camera(frame, shared::grid_place(camera.position_m));
  frame.growth_turns = -1.0f;
  return frame;
}

}  // namespace nephele::test
