#include "lut/sphere_kernels.h"

#include <algorithm>
#include <cmath>

#include "engine/check.h"

// One binary for every x86-64: the loader picks the widest variant by CPU feature. Sanitizers cannot instrument that
// choice.
#if defined(__x86_64__) && defined(__GNUC__) && __GNUC__ >= 12 && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define NEPHELE_KERNEL __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define NEPHELE_KERNEL
#endif
#define NEPHELE_INLINE inline __attribute__((always_inline))

namespace nephele {

namespace {

// All modes of one place as a single vector, whatever the register width: the compiler splits it as it must.
template <int Modes>
struct Lanes {
  typedef float Vector __attribute__((vector_size(Modes * sizeof(float))));
  typedef float Memory __attribute__((vector_size(Modes * sizeof(float)), aligned(sizeof(float)), may_alias));
};

template <int Modes>
NEPHELE_INLINE void trace_rays_body(int rays, int points, const float* slice, int row_floats, const float* cosines,
                                    const RayPoint* point, float* values) {
  using Vector = typename Lanes<Modes>::Vector;
  using Memory = typename Lanes<Modes>::Memory;
  for (int b = 0; b < rays; ++b) {
    Vector sum{};
    for (int k = 0; k < points; ++k, ++point) {
      const float* corner = slice + point->offset;
      Vector value{};
      for (int i = 0; i < 4; ++i, corner += row_floats) {
        const Memory* row = reinterpret_cast<const Memory*>(corner);
        value += point->radius_weights[i] * (point->theta_weights[0] * row[0] + point->theta_weights[1] * row[1] +
                                             point->theta_weights[2] * row[2] + point->theta_weights[3] * row[3]);
      }
      const int place = static_cast<int>(point->cosine_at);
      const float f = point->cosine_at - static_cast<float>(place);
      const Memory* cosine = reinterpret_cast<const Memory*>(cosines + place * Modes);
      sum += value * (cosine[0] + f * (cosine[1] - cosine[0]));
    }
    float total = 0;
    for (int m = 0; m < Modes; ++m) total += sum[m];
    values[b] = total;
  }
}

template <int Modes>
NEPHELE_INLINE void multiply_opacity_body(int nodes, const float* lambda, const float* opacity, float* radiance) {
  using Vector = typename Lanes<Modes>::Vector;
  using Memory = typename Lanes<Modes>::Memory;
  for (int f = 0; f < nodes; ++f, lambda += Modes, opacity += 2 * Modes, radiance += Modes) {
    // cos(m b) cos(k b) = (cos((m + k) b) + cos((m - k) b)) / 2: even[] is the opacity's series mirrored around 0.
    float even[2 * Modes];
    for (int k = 1; k < Modes; ++k) even[Modes + k] = even[Modes - k] = opacity[k];
    even[Modes] = 2 * opacity[0];
    even[0] = 0;
    Vector product{};
    float mean = lambda[0] * opacity[0];
    for (int m = 1; m < Modes; ++m) mean += 0.5f * lambda[m] * opacity[m];
    for (int m = 0; m < Modes; ++m) {
      const Memory& down = *reinterpret_cast<const Memory*>(even + Modes - m);
      const Memory& up = *reinterpret_cast<const Memory*>(opacity + m);
      product += 0.5f * lambda[m] * (down + up);
    }
    *reinterpret_cast<Memory*>(radiance) = product;
    radiance[0] = mean;
  }
}

template <int Modes>
NEPHELE_INLINE void multiply_phase_body(int rows, int columns, const float* matrix, const float* radiance,
                                        float* result) {
  using Vector = typename Lanes<Modes>::Vector;
  using Memory = typename Lanes<Modes>::Memory;
  const Memory* from = reinterpret_cast<const Memory*>(radiance);
  const Memory* factor = reinterpret_cast<const Memory*>(matrix);
  for (int i = 0; i < rows; ++i) {
    Vector even{}, odd{};
    int j = 0;
    for (; j + 2 <= columns; j += 2) {
      even += factor[j] * from[j];
      odd += factor[j + 1] * from[j + 1];
    }
    if (j < columns) even += factor[j] * from[j];
    factor += columns;
    *reinterpret_cast<Memory*>(result + i * Modes) = even + odd;
  }
}

NEPHELE_KERNEL void trace_rays_8(int rays, int points, const float* slice, int row_floats, const float* cosines,
                                 const RayPoint* ray_points, float* values) {
  trace_rays_body<8>(rays, points, slice, row_floats, cosines, ray_points, values);
}
NEPHELE_KERNEL void trace_rays_16(int rays, int points, const float* slice, int row_floats, const float* cosines,
                                  const RayPoint* ray_points, float* values) {
  trace_rays_body<16>(rays, points, slice, row_floats, cosines, ray_points, values);
}
NEPHELE_KERNEL void multiply_opacity_8(int nodes, const float* lambda, const float* opacity, float* radiance) {
  multiply_opacity_body<8>(nodes, lambda, opacity, radiance);
}
NEPHELE_KERNEL void multiply_opacity_16(int nodes, const float* lambda, const float* opacity, float* radiance) {
  multiply_opacity_body<16>(nodes, lambda, opacity, radiance);
}
NEPHELE_KERNEL void multiply_phase_8(int rows, int columns, const float* matrix, const float* radiance, float* result) {
  multiply_phase_body<8>(rows, columns, matrix, radiance, result);
}
NEPHELE_KERNEL void multiply_phase_16(int rows, int columns, const float* matrix, const float* radiance,
                                      float* result) {
  multiply_phase_body<16>(rows, columns, matrix, radiance, result);
}

}  // namespace

CosineTable::CosineTable(int modes) {
  NEPHELE_CHECK(modes == 8 || modes == 16, modes);
  const double pi = std::acos(-1.0);
  for (int k = 0; k <= kIntervals + 1; ++k)
    for (int m = 0; m < modes; ++m) entries.push_back(static_cast<float>(std::cos(m * pi * k / kIntervals)));
  for (int b = 0; b < modes; ++b)
    for (int m = 0; m < modes; ++m) samples.push_back(static_cast<float>(std::cos(m * pi * (b + 0.5) / modes)));
}

float CosineTable::place(double psi) const {
  const double tau = 2 * std::acos(-1.0);
  psi = std::abs(std::remainder(psi, tau));
  return static_cast<float>(std::min(psi / tau * 2 * kIntervals, static_cast<double>(kIntervals)));
}

void trace_rays(int modes, int rays, int points, const float* slice, int row_floats, const float* cosines,
                const RayPoint* ray_points, float* values) {
  (modes == 16 ? trace_rays_16 : trace_rays_8)(rays, points, slice, row_floats, cosines, ray_points, values);
}

void multiply_opacity(int modes, int nodes, const float* lambda, const float* opacity, float* radiance) {
  (modes == 16 ? multiply_opacity_16 : multiply_opacity_8)(nodes, lambda, opacity, radiance);
}

void multiply_phase(int modes, int rows, int columns, const float* matrix, const float* radiance, float* result) {
  (modes == 16 ? multiply_phase_16 : multiply_phase_8)(rows, columns, matrix, radiance, result);
}

}  // namespace nephele
