// A path-traced image, pass by pass: sums of every pixel, what they say about the mean, and a file to go on from.
//
// A pixel is the mean over its area, first matter aside, which is that of the ray through its middle. The sums
// depend on the seed and the number of samples alone: neither on the threads nor on where a run was interrupted.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "engine/image_io.h"
#include "engine/result.h"
#include "engine/scene.h"
#include "tools/path_tracer/path_tracer.h"

namespace nephele::truth {

class ReferenceImage {
 public:
  ReferenceImage(const CameraState& camera, std::uint32_t width, std::uint32_t height, std::uint64_t seed);

  // Adds samples to every pixel; progress (0 to 1) is called from one thread at a time.
  void add_samples(const PathTracer& tracer, std::uint32_t samples, int threads,
                   const std::function<void(double)>& progress = {});
  std::uint32_t samples() const { return samples_; }

  // Mean over the pixels of the standard error of the luminance over the luminance; black pixels count as exact.
  double mean_relative_error() const;

  // R G B T SE: radiance, the clouds' transmittance, standard error of the mean of the luminance.
  ImageF picture() const;
  // R G B T Z: the cloud layer alone, as the renderer writes it.
  ImageF layers(const Medium& field, const Surroundings& surroundings) const;

  // Everything needed to go on. key: what the samples are of; another one's state is refused.
  Result<void> save(const std::string& path, std::uint64_t key) const;
  Result<void> load(const std::string& path, std::uint64_t key);

 private:
  struct Sums {
    double radiance[3] = {}, cloud[3] = {}, transmittance = 0, luminance = 0, luminance_squared = 0;
  };
  // in_pixel: from its upper left corner, in pixels.
  glm::vec3 direction(std::uint32_t pixel, const glm::vec2& in_pixel) const;
  double standard_error(const Sums& sums) const;

  glm::mat4 render_from_clip_;
  std::uint32_t width_, height_;
  float pixel_rad_;
  std::uint64_t seed_;
  std::uint32_t samples_ = 0;
  std::vector<Sums> sums_;
};

}  // namespace nephele::truth
