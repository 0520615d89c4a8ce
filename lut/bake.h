// What the two bakes are made of; the tests look inside through this header, everyone else uses tables.h.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "engine/npy.h"
#include "shared/reference_particle.h"

namespace nephele {

// A chord of the reference particle: mean density, and the fractions of its length at which matter begins and ends
// (1 and 0 when there is none).
struct ChordStatistics {
  float mean = 0, first = 1, last = 0;
};

// The reference particle's density tabulated on a grid fine enough for its billows (0.56 radii).
class ReferenceParticle {
 public:
  explicit ReferenceParticle(std::uint32_t seed, float billows_per_radius = shared::kBillowsPerRadius);
  float density(const shared::vec3& p) const;
  double mean_fill() const;
  ChordStatistics chord(const shared::vec3& entry, const shared::vec3& exit) const;

 private:
  static constexpr int kSize = 128;  // vertices along a side of [-1, 1]^3
  static constexpr float kStepsPerRadius = 40;
  std::vector<float> density_;
};

constexpr int kFirstMatterChords = 5;  // averaged for one vertex

// Values at the vertices of the optical depth table, [S][E], for which linear filtering between them errs least in the
// mean square: plain values are too high wherever the function is convex, by 1/12 of the second difference along each
// axis on average, so as much is taken off them. Across the edge of an octahedral map lies the vertex that it is glued
// to.
std::vector<float> least_squares_vertices(const std::vector<float>& values, int n);

// float16, [S][E.v][E.u][root of the mean, first], as shared/table_axes.h has them. progress(fraction) may be called
// from any thread.
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
