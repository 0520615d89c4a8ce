#include "tools/path_tracer/reference_image.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <thread>

#include "engine/atomic_file.h"
#include "engine/camera.h"
#include "engine/check.h"

namespace nephele::truth {

namespace {

constexpr std::uint32_t kPixelsPerTask = 32;

struct StateHeader {
  char magic[8] = {'n', 'e', 'p', 'h', 'r', 'e', 'f', '1'};
  std::uint64_t key = 0, seed = 0;
  std::uint32_t width = 0, height = 0, samples = 0, bytes_per_pixel = 0;
};

double luminance(const glm::vec3& radiance) { return 0.2126 * radiance.r + 0.7152 * radiance.g + 0.0722 * radiance.b; }

}  // namespace

ReferenceImage::ReferenceImage(const CameraState& camera, std::uint32_t width, std::uint32_t height, std::uint64_t seed)
    : render_from_clip_(camera_matrices(camera, static_cast<double>(width) / height).render_from_clip),
      width_(width),
      height_(height),
      pixel_rad_(static_cast<float>(2 * std::tan(0.5 * camera.vertical_fov_rad) / height)),
      seed_(seed),
      sums_(std::size_t{width} * height) {}

glm::vec3 ReferenceImage::direction(std::uint32_t pixel, const glm::vec2& in_pixel) const {
  const std::uint32_t column = pixel % width_, row = pixel / width_;
  const glm::vec2 ndc = (glm::vec2(column, row) + in_pixel) / glm::vec2(width_, height_) * 2.0f - 1.0f;
  return glm::normalize(glm::vec3(render_from_clip_ * glm::vec4(ndc, 1.0f, 1.0f)));
}

void ReferenceImage::add_samples(const PathTracer& tracer, std::uint32_t samples, int threads,
                                 const std::function<void(double)>& progress) {
  const auto pixels = static_cast<std::uint32_t>(sums_.size());
  std::atomic<std::uint32_t> next{0};
  std::mutex showing;
  const auto work = [&] {
    for (std::uint32_t first = next.fetch_add(kPixelsPerTask); first < pixels; first = next.fetch_add(kPixelsPerTask)) {
      for (std::uint32_t pixel = first; pixel < std::min(first + kPixelsPerTask, pixels); ++pixel) {
        Sums& sums = sums_[pixel];
        for (std::uint32_t i = samples_; i < samples_ + samples; ++i) {
          Random random(seed_, pixel, i);
          const float across = random(), down = random();
          const PathSample sample = tracer.camera_ray(direction(pixel, {across, down}), pixel_rad_, random);
          for (int c = 0; c < 3; ++c) {
            sums.radiance[c] += sample.radiance[c];
            sums.cloud[c] += sample.cloud[c];
          }
          const double y = luminance(sample.radiance);
          sums.transmittance += sample.transmittance;
          sums.luminance += y;
          sums.luminance_squared += y * y;
        }
      }
      if (!progress) continue;
      const std::lock_guard lock(showing);
      progress(static_cast<double>(std::min(first + kPixelsPerTask, pixels)) / pixels);
    }
  };
  {
    std::vector<std::jthread> others;
    for (int i = 1; i < threads; ++i) others.emplace_back(work);
    work();
  }
  samples_ += samples;
}

double ReferenceImage::standard_error(const Sums& sums) const {
  if (samples_ < 2) return 0.0;
  const double n = samples_, mean = sums.luminance / n;
  return std::sqrt(std::max(0.0, sums.luminance_squared / n - mean * mean) / (n - 1));
}

double ReferenceImage::mean_relative_error() const {
  double sum = 0;
  for (const Sums& sums : sums_)
    if (sums.luminance > 0) sum += standard_error(sums) * samples_ / sums.luminance;
  return sum / static_cast<double>(sums_.size());
}

ImageF ReferenceImage::picture() const {
  ImageF image{width_, height_, {"R", "G", "B", "T", "SE"}, {}};
  const double n = std::max(1u, samples_);
  for (const Sums& sums : sums_) {
    for (const double channel : sums.radiance) image.data.push_back(static_cast<float>(channel / n));
    image.data.push_back(static_cast<float>(sums.transmittance / n));
    image.data.push_back(static_cast<float>(standard_error(sums)));
  }
  return image;
}

ImageF ReferenceImage::layers(const Medium& field, const Surroundings& surroundings) const {
  ImageF image{width_, height_, {"R", "G", "B", "T", "Z"}, {}};
  const double n = std::max(1u, samples_);
  for (std::uint32_t pixel = 0; pixel < sums_.size(); ++pixel) {
    const Sums& sums = sums_[pixel];
    const glm::vec3 eye(0.0f), ray = direction(pixel, glm::vec2(0.5f));
    for (const double channel : sums.cloud) image.data.push_back(static_cast<float>(channel / n));
    image.data.push_back(static_cast<float>(sums.transmittance / n));
    image.data.push_back(field.first_matter_m(eye, ray, surroundings.ground_m(eye, ray)));
  }
  return image;
}

Result<void> ReferenceImage::save(const std::string& path, std::uint64_t key) const {
  const StateHeader header{.key = key,
                           .seed = seed_,
                           .width = width_,
                           .height = height_,
                           .samples = samples_,
                           .bytes_per_pixel = sizeof(Sums)};
  std::vector<std::byte> bytes(sizeof header + sums_.size() * sizeof(Sums));
  std::memcpy(bytes.data(), &header, sizeof header);
  std::memcpy(bytes.data() + sizeof header, sums_.data(), sums_.size() * sizeof(Sums));
  return write_file_atomically(path, bytes);
}

Result<void> ReferenceImage::load(const std::string& path, std::uint64_t key) {
  std::ifstream file(path, std::ios::binary);
  const StateHeader expected;
  StateHeader header;
  std::vector<Sums> sums(sums_.size());
  const auto bytes = static_cast<std::streamsize>(sums.size() * sizeof(Sums));
  if (!file.read(reinterpret_cast<char*>(&header), sizeof header) ||
      std::memcmp(header.magic, expected.magic, sizeof header.magic) != 0)
    return Error{path + ": not the state of a reference; remove it to begin anew"};
  if (header.key != key || header.seed != seed_ || header.width != width_ || header.height != height_ ||
      header.bytes_per_pixel != sizeof(Sums))
    return Error{path + ": the state of another scene, size, quality, time or seed; remove it to begin anew"};
  if (!file.read(reinterpret_cast<char*>(sums.data()), bytes) || file.peek() != std::ifstream::traits_type::eof())
    return Error{path + ": damaged; remove it to begin anew"};
  samples_ = header.samples;
  sums_ = std::move(sums);
  return {};
}

}  // namespace nephele::truth
