// Scenes of one source, and the particles that sources make for a camera.
#pragma once

#include <glm/glm.hpp>

#include "passes/nephele.h"
#include "tests/support/cloud_frame.h"
#include "tests/support/field_run.h"

namespace nephele::test {

inline const RenderSettings kSmall{.width = 64, .height = 36, .quality = Quality::low, .ring_size_cells = 40};

inline Scene only(const SceneSource& source) {
  Scene scene;
  scene.clouds.reset();
  scene.sources = {source};
  return scene;
}

inline ParticleRun run_scene(const Scene& scene, const glm::dvec3& camera_m = {0, 0, 1500}, double time_s = 0.0) {
  CameraState camera;
  camera.position_m = camera_m;
  SourcesRun sources([&](Workshop& make) { return make_sources(make, scene, kSmall); });
  return sources.run(cloud_view(camera), {camera_m - glm::dvec3(scene.world_origin_m, 0.0), time_s});
}

}  // namespace nephele::test
