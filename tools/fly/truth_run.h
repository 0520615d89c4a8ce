// The path-traced truth of a view, growing in the background: one thread of its own, so that the window goes on.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "engine/image_compare.h"
#include "engine/image_io.h"
#include "engine/scene.h"
#include "shared/types.h"

namespace nephele::fly {

class TruthRun {
 public:
  struct View {
    Scene scene;  // its camera is the view's
    double time_s = 0;
    std::vector<shared::Particle> particles;  // all of the renderer's (Renderer::read_particles)
    std::uint32_t particle_seed = 0;          // of the sky's tables
    std::uint32_t width = 0, height = 0;      // pixels
    // What the renderer shows of it: R G B before exposure, averaged to that size.
    ImageF rendered;
  };
  explicit TruthRun(View view);
  // Asks the thread to stop; it ends by itself after its present pass, and nothing waits for it.
  ~TruthRun();
  TruthRun(const TruthRun&) = delete;
  TruthRun& operator=(const TruthRun&) = delete;
  // Until no thread of any run is left; each ends with its present pass.
  static void wait_for_stopped();

  struct Progress {
    std::uint32_t samples = 0;       // a pixel
    double mean_relative_error = 1;  // of the truth itself
    // |rendered / truth - 1| over opaque tiles of 4 x 4 pixels, and rendered / truth - 1 over them; none without such.
    std::optional<double> tile_error, tile_error_p95, thick_bias;
    ImageF truth;  // R G B T SE
  };
  // What has been traced since the last call; none where that is nothing.
  std::optional<Progress> news();
  const View& view() const { return shared_->view; }

 private:
  struct Shared {
    View view;
    std::atomic<bool> stop{false};
    std::mutex mutex;
    std::optional<Progress> news;
  };
  static void trace(const std::shared_ptr<Shared>& shared);
  std::shared_ptr<Shared> shared_;
};

// How the truth is shown beside the rendered picture.
enum class TruthLook : std::uint8_t { truth, error };

// RGBA8, as the renderer's display image; error: blue where the rendered picture is too dark, red where it is too
// bright, white where it is right, full colour at a relative error of 50 %.
std::vector<std::uint8_t> truth_picture(const ImageF& truth, const ImageF& rendered, TruthLook look, float exposure_ev);

// Averages of k x k pixels of R G B A, as Renderer::read_hdr gives them; the last rows and columns may be left out.
ImageF averaged(const std::vector<float>& rgba, std::uint32_t width, std::uint32_t height, std::uint32_t k);

}  // namespace nephele::fly
