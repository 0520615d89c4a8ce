// Optical depth of the noisy reference particle over all chords of the unit sphere ([Yusov14] 4.1, 5.1). Deviates from
// the paper's angles: chords are addressed by entry and exit point (shared/table_axes.h).
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <functional>

#include <Eigen/Dense>

#include "engine/parallel.h"
#include "lut/bake.h"
#include "shared/hash.h"
#include "shared/reference_particle.h"
#include "shared/table_axes.h"

namespace nephele {

using shared::vec2;
using shared::vec3;

ReferenceParticle::ReferenceParticle(std::uint32_t seed, float billows_per_radius)
    : density_(std::size_t{kSize} * kSize * kSize) {
  parallel_for(kSize, [&](int z) {
    const auto place = [](int i) { return 2.0f * static_cast<float>(i) / (kSize - 1) - 1.0f; };
    float* out = &density_[static_cast<std::size_t>(z) * kSize * kSize];
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x)
        *out++ = shared::billowy_density(vec3(place(x), place(y), place(z)), billows_per_radius, seed);
  });
}

float ReferenceParticle::density(const vec3& p) const {
  const auto split = [](float x, int& cell, float& f) {
    const float at = std::clamp((x * 0.5f + 0.5f) * (kSize - 1), 0.0f, kSize - 1.001f);
    cell = static_cast<int>(at);
    f = at - static_cast<float>(cell);
  };
  int x, y, z;
  float fx, fy, fz;
  split(p.x, x, fx);
  split(p.y, y, fy);
  split(p.z, z, fz);
  const float* d = &density_[(static_cast<std::size_t>(z) * kSize + y) * kSize + x];
  const auto row = [&](const float* r) { return r[0] + fx * (r[1] - r[0]); };
  const auto plane = [&](const float* s) { return row(s) + fy * (row(s + kSize) - row(s)); };
  return plane(d) + fz * (plane(d + kSize * kSize) - plane(d));
}

double ReferenceParticle::mean_fill() const {
  // Vertices inside the sphere, all of equal weight.
  double sum = 0;
  std::size_t inside = 0, i = 0;
  for (int z = 0; z < kSize; ++z)
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x, ++i) {
        const double px = 2.0 * x / (kSize - 1) - 1, py = 2.0 * y / (kSize - 1) - 1, pz = 2.0 * z / (kSize - 1) - 1;
        if (px * px + py * py + pz * pz >= 1) continue;
        sum += density_[i];
        ++inside;
      }
  return sum / static_cast<double>(inside);
}

ChordStatistics ReferenceParticle::chord(const vec3& entry, const vec3& exit) const {
  const vec3 span = exit - entry;
  const int steps = 4 + static_cast<int>(length(span) * kStepsPerRadius);
  ChordStatistics chord;
  float before = 0;
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    const float d = density(entry + span * ((static_cast<float>(i) + 0.5f) / static_cast<float>(steps)));
    sum += d;
    if (d > shared::kFirstMatterDensity) {
      const float crossing = (shared::kFirstMatterDensity - before) / std::max(d - before, 1e-6f);
      if (chord.first == 1.0f)
        chord.first =
            std::max(0.0f, static_cast<float>(i) - 0.5f + std::max(0.0f, crossing)) / static_cast<float>(steps);
      chord.last = std::min(1.0f, (static_cast<float>(i) + 1.0f) / static_cast<float>(steps));
    }
    before = d;
  }
  chord.mean = static_cast<float>(sum / steps);
  return chord;
}

std::vector<float> least_squares_vertices(const std::vector<float>& values, int n) {
  const int vertices = n * n;
  // Neighbours of each vertex of one map, along u and along v.
  std::vector<std::array<int, 4>> neighbours(vertices);
  const auto vertex = [&](int u, int v) {
    if (u < 0 || u >= n) return (n - 1 - v) * n + (u < 0 ? 1 : n - 2);
    if (v < 0 || v >= n) return (v < 0 ? 1 : n - 2) * n + (n - 1 - u);
    return v * n + u;
  };
  for (int v = 0; v < n; ++v)
    for (int u = 0; u < n; ++u)
      neighbours[v * n + u] = {vertex(u - 1, v), vertex(u + 1, v), vertex(u, v - 1), vertex(u, v + 1)};

  std::vector<float> fitted(values.size());
  parallel_for(vertices, [&](int s) {
    const auto value = [&](int entry, int exit) { return values[static_cast<std::size_t>(entry) * vertices + exit]; };
    for (int e = 0; e < vertices; ++e) {
      float differences = -8 * value(s, e);
      for (int k = 0; k < 4; ++k) differences += value(neighbours[s][k], e) + value(s, neighbours[e][k]);
      fitted[static_cast<std::size_t>(s) * vertices + e] = value(s, e) - differences / 12;
    }
  });
  return fitted;
}

namespace {

// As the packed table can hold it.
float whole_256ths(float x) { return std::round(std::clamp(x, 0.0f, 255.0f / 256.0f) * 256.0f) / 256.0f; }

// Values at n vertices of an axis from those at its coarse ones.
Eigen::MatrixXf coarse_interpolation(int n) {
  const auto coarse = static_cast<int>(shared::coarse_vertices(static_cast<std::uint32_t>(n)));
  Eigen::MatrixXf matrix = Eigen::MatrixXf::Zero(n, coarse);
  for (int i = 0; i < n; ++i) {
    const float place = shared::coarse_place(static_cast<float>(i), static_cast<std::uint32_t>(n));
    const int low = std::min(static_cast<int>(place), coarse - 2);
    matrix(i, low + 1) = place - static_cast<float>(low);
    matrix(i, low) = 1.0f - matrix(i, low + 1);
  }
  return matrix;
}

// Applies the matrix along the slowest axis, which becomes the fastest: four times are once along each axis of the
// table.
std::vector<float> along_first_axis(const Eigen::MatrixXf& matrix, const std::vector<float>& values) {
  const Eigen::Index rest = static_cast<Eigen::Index>(values.size()) / matrix.cols();
  const Eigen::Map<const Eigen::MatrixXf> in(values.data(), rest, matrix.cols());  // column by column
  const Eigen::MatrixXf out = matrix * in.transpose();
  return {out.data(), out.data() + out.size()};
}

}  // namespace

NpyArray bake_optical_depth_array(const ReferenceParticle& particle, int n,
                                  const std::function<void(double)>& progress) {
  NpyArray array;
  array.type = ElementType::float16;
  array.shape = {static_cast<std::size_t>(n) * n, static_cast<std::size_t>(n), static_cast<std::size_t>(n), 2};
  array.data.resize(2 * array.count());
  const int vertices = n * n;
  std::vector<vec3> points(vertices);
  for (int row = 0; row < n; ++row)
    for (int column = 0; column < n; ++column)
      points[row * n + column] = shared::octahedral_decode(vec2(static_cast<float>(column) / static_cast<float>(n - 1),
                                                                static_cast<float>(row) / static_cast<float>(n - 1)));
  // First matter jumps where a chord begins to miss a lobe. Averaged over the chords that a vertex stands for (both
  // ends moved within about half a cell) it varies smoothly from vertex to vertex.
  const float spread = 1.0f / static_cast<float>(n - 1);
  const auto moved = [&](const vec3& p, std::uint32_t hash) {
    std::uint32_t state = hash;
    const float x = shared::uniform_float(state, -1, 1), y = shared::uniform_float(state, -1, 1),
                z = shared::uniform_float(state, -1, 1);
    return normalize(p + spread * vec3(x, y, z));
  };
  const auto write = [&](std::size_t element, float x) {
    const std::uint16_t half = static_cast<std::uint16_t>(glm::packHalf2x16({x, 0}));
    array.data[2 * element] = static_cast<std::byte>(half & 255);
    array.data[2 * element + 1] = static_cast<std::byte>(half >> 8);
  };

  std::vector<float> roots(static_cast<std::size_t>(vertices) * vertices);
  std::vector<float> firsts(roots.size());
  std::atomic<int> done{0};
  parallel_for(vertices, [&](int task) {
    // Long and short rows alternate, so that the threads end together. A chord serves both directions.
    const int s = task % 2 == 0 ? task / 2 : vertices - 1 - task / 2;
    for (int e = 0; e <= s; ++e) {
      const ChordStatistics center = particle.chord(points[s], points[e]);
      float first = center.first, last = center.last;
      for (int k = 1; k < kFirstMatterChords; ++k) {
        const std::uint32_t h = shared::hash_uvec3(shared::uvec3(s, e, k), 0);
        const ChordStatistics near = particle.chord(moved(points[s], h), moved(points[e], h + 0x9e3779b9u));
        first += near.first;
        last += near.last;
      }
      const std::size_t there = static_cast<std::size_t>(s) * vertices + e,
                        back = static_cast<std::size_t>(e) * vertices + s;
      roots[there] = roots[back] = std::sqrt(center.mean);
      firsts[there] = first / kFirstMatterChords;
      firsts[back] = 1.0f - last / kFirstMatterChords;
    }
    const int count = done.fetch_add(1) + 1;
    if (progress && count % 16 == 0) progress(static_cast<double>(count) / vertices);
  });

  roots = least_squares_vertices(roots, n);
  const Eigen::MatrixXf interpolation = coarse_interpolation(n);
  const Eigen::MatrixXf fit = (interpolation.transpose() * interpolation).ldlt().solve(interpolation.transpose());
  for (int axis = 0; axis < 4; ++axis) firsts = along_first_axis(fit, firsts);
  for (float& first : firsts) first = whole_256ths(first);
  for (int axis = 0; axis < 4; ++axis) firsts = along_first_axis(interpolation, firsts);
  for (std::size_t at = 0; at < roots.size(); ++at) {
    write(2 * at, whole_256ths(roots[at]));
    write(2 * at + 1, firsts[at]);
  }
  return array;
}

}  // namespace nephele
