// What the two bakes are made of; the tests look inside through this header, everyone else uses tables.h.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "lut/npy.h"
#include "shared/prelude.h"

namespace nephele {

// A chord of the reference particle: mean density, and the fractions of its length at which matter begins and ends
// (1 and 0 when there is none).
struct ChordStatistics {
  float mean = 0, first = 1, last = 0;
};

// The reference particle's density tabulated on a grid fine enough for its smallest features (0.2 radii).
class ReferenceParticle {
 public:
  explicit ReferenceParticle(std::uint32_t seed);
  float density(const shared::vec3& p) const;
  double mean_fill() const;
  ChordStatistics chord(const shared::vec3& entry, const shared::vec3& exit) const;

 private:
  static constexpr int kSize = 128;  // vertices along a side of [-1, 1]^3
  static constexpr float kStepsPerRadius = 40;
  std::vector<float> density_;
};

constexpr int kFirstMatterChords = 5;  // averaged for one texel

// uint8, [S][E.v][E.u][mean, first]. progress(fraction) may be called from any thread.
NpyArray bake_optical_depth_array(const ReferenceParticle& particle, int n,
                                  const std::function<void(double)>& progress);

struct ScatteringBake {
  std::uint32_t phase_function = 0;
  double g = 0.85;
  int cosines = 48, chords = 24, densities = 16;
  bool coarse_solver = false;
  double residual = 3e-5;
};

// The optical radii solved for, one per slice but the last, whose limit needs two.
std::vector<double> slice_optical_radii(const ScatteringBake& bake);

// float16, [density][h][c][a0..a3]. progress(fraction) from the calling thread.
NpyArray bake_multiple_scattering_array(const ScatteringBake& bake, const std::function<void(double)>& progress);

}  // namespace nephele
