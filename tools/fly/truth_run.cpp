#include "tools/fly/truth_run.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/check.h"
#include "passes/kit/cloud_source.h"
#include "shared/tonemap.h"
#include "shared/world.h"
#include "tools/path_tracer/extinction_field.h"
#include "tools/path_tracer/reference_image.h"

namespace nephele::fly {
namespace {

constexpr std::uint32_t kMostSamples = 4096;
constexpr float kFullColor = 0.5f;  // relative error

std::atomic<int> threads_running{0};

float luminance(const ImageF& image, std::uint32_t x, std::uint32_t y) {
  return 0.2126f * image.at(x, y, 0) + 0.7152f * image.at(x, y, 1) + 0.0722f * image.at(x, y, 2);
}

// The rendered picture with the truth's transmittance, so that tiles are chosen by what the truth shows.
ImageF with_transmittance(const ImageF& rendered, const ImageF& truth) {
  ImageF image{rendered.width, rendered.height, {"R", "G", "B", "T"}, {}};
  for (std::uint32_t y = 0; y < rendered.height; ++y)
    for (std::uint32_t x = 0; x < rendered.width; ++x)
      image.data.insert(image.data.end(),
                        {rendered.at(x, y, 0), rendered.at(x, y, 1), rendered.at(x, y, 2), truth.at(x, y, 3)});
  return image;
}

float highest_m(const std::vector<shared::Particle>& particles, float camera_altitude_m) {
  float highest = 0.0f;
  for (const shared::Particle& p : particles)
    highest = std::max(
        highest, shared::altitude_m(p.center_m, camera_altitude_m) + shared::ellipsoid_extent(p.shape, {0, 0, 1}));
  return highest;
}

}  // namespace

TruthRun::TruthRun(View view) : shared_(std::make_shared<Shared>()) {
  shared_->view = std::move(view);
  ++threads_running;
  std::thread([shared = shared_]() mutable {
    trace(shared);
    shared.reset();
    --threads_running;
    threads_running.notify_all();
  }).detach();
}

TruthRun::~TruthRun() { shared_->stop = true; }

void TruthRun::wait_for_stopped() {
  for (int running = threads_running; running > 0; running = threads_running) threads_running.wait(running);
}

void TruthRun::trace(const std::shared_ptr<Shared>& shared) {
  const View& view = shared->view;
  const truth::Surroundings surroundings(view.scene, std::nullopt,
                                         highest_m(view.particles, static_cast<float>(view.scene.camera.position_m.z)));
  const truth::DensityLattice lattice(view.particle_seed);
  const glm::vec3 camera_grid_m =
      shared::grid_place(
          shared::cloud_from_world(view.scene.camera.position_m - glm::dvec3(view.scene.world_origin_m, 0.0),
                                   scene_wind_m_per_s(view.scene), view.time_s))
          .grid_m;
  const truth::ExtinctionField field(view.particles, camera_grid_m, surroundings.sun_direction(), lattice);
  const truth::Phase phase(view.scene.phase);
  const truth::PathTracer tracer(field, surroundings, phase);
  truth::ReferenceImage image(view.scene.camera, view.width, view.height, 1);
  while (!shared->stop && image.samples() < kMostSamples) {
    image.add_samples(tracer, 1, 1);
    Progress progress{.samples = image.samples(),
                      .mean_relative_error = image.samples() > 1 ? image.mean_relative_error() : 1.0,
                      .tile_error = {},
                      .tile_error_p95 = {},
                      .thick_bias = {},
                      .truth = image.picture()};
    if (const auto errors = compare_layers(with_transmittance(view.rendered, progress.truth), "rendered",
                                           progress.truth, "truth", nullptr, "")) {
      progress.tile_error = errors->tile_error;
      progress.tile_error_p95 = errors->tile_error_p95;
      progress.thick_bias = errors->thick_bias;
    }
    const std::lock_guard lock(shared->mutex);
    shared->news = std::move(progress);
  }
}

std::optional<TruthRun::Progress> TruthRun::news() {
  const std::lock_guard lock(shared_->mutex);
  return std::exchange(shared_->news, std::nullopt);
}

std::vector<std::uint8_t> truth_picture(const ImageF& truth, const ImageF& rendered, TruthLook look,
                                        float exposure_ev) {
  std::vector<std::uint8_t> rgba;
  rgba.reserve(std::size_t{4} * truth.width * truth.height);
  for (std::uint32_t y = 0; y < truth.height; ++y)
    for (std::uint32_t x = 0; x < truth.width; ++x) {
      glm::vec3 color;
      if (look == TruthLook::truth) {
        const glm::vec3 radiance(truth.at(x, y, 0), truth.at(x, y, 1), truth.at(x, y, 2));
        color = shared::display_color(radiance, std::exp2(exposure_ev), glm::uvec2(x, y));
      } else {
        const float there = luminance(truth, x, y), error = luminance(rendered, x, y) - there;
        const float share = std::clamp(error / std::max(1e-6f, kFullColor * there), -1.0f, 1.0f);
        color = {1.0f + std::min(0.0f, share), 1.0f - std::abs(share), 1.0f - std::max(0.0f, share)};
      }
      for (int c = 0; c < 3; ++c)
        rgba.push_back(static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(color[c], 0.0f, 1.0f))));
      rgba.push_back(255);
    }
  return rgba;
}

ImageF averaged(const std::vector<float>& rgba, std::uint32_t width, std::uint32_t height, std::uint32_t k) {
  NEPHELE_CHECK(k > 0 && rgba.size() == std::size_t{4} * width * height, width, "x", height, " by ", k);
  ImageF image{width / k, height / k, {"R", "G", "B"}, {}};
  image.data.resize(std::size_t{3} * image.width * image.height);
  for (std::uint32_t y = 0; y < image.height * k; ++y)
    for (std::uint32_t x = 0; x < image.width * k; ++x)
      for (std::uint32_t c = 0; c < 3; ++c)
        image.data[3 * (std::size_t{y / k} * image.width + x / k) + c] +=
            rgba[4 * (std::size_t{y} * width + x) + c] / static_cast<float>(k * k);
  return image;
}

}  // namespace nephele::fly
