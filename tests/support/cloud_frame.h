// A cloud field without a scene, for tests of what finds its cells and makes its particles.
#pragma once

#include <glm/glm.hpp>

#include "engine/camera.h"
#include "shared/ring_grid.h"
#include "shared/types.h"

namespace nephele::test {

// 104^2 cells in three rings, coverage 0.4, fair-weather heights, around the camera's place.
inline shared::FieldFrame cloud_frame(const CameraState& camera = {}) {
  shared::FieldFrame frame{};
  frame.field.seed = 5;
  frame.field.coverage = 0.4f;
  frame.field.base_m = 1200.0f;
  frame.field.thickness_m = 1400.0f;
  frame.field.extinction_per_m = 0.04f;
  frame.field.view_distance_m = 80000.0f;
  frame.field.ring_count = 3;
  frame.field.ring_size_cells = 104;
  frame.field.layer_count = 5;
  frame.field.crown_per_cell = 2.5f;
  frame.field.inner_cell_m = 184.0f;
  frame.field.growth_turns = -1.0f;
  shared::place_camera(frame, shared::grid_place(camera.position_m));
  return frame;
}

inline shared::CloudField cloud_field(const CameraState& camera = {}) { return cloud_frame(camera).field; }

// What the rest of the frame knows of the camera.
inline shared::FrameConstants cloud_view(const CameraState& camera = {}) {
  shared::FrameConstants constants{};
  const CameraMatrices matrices = camera_matrices(camera, 16.0 / 9.0);
  constants.clip_from_render = matrices.clip_from_render;
  constants.render_from_clip = matrices.render_from_clip;
  constants.camera_grid_m = shared::grid_place(camera.position_m).grid_m;
  constants.ground_enabled = 1;
  constants.culling_enabled = 1;
  constants.view_distance_m = 80000.0f;
  return constants;
}

}  // namespace nephele::test
