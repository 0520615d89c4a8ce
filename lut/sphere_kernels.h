// The hot loops of the sphere solver, compiled for several instruction sets and chosen at run time.
#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace nephele {

// Vectors of modes start on cache lines: a load then never touches two.
template <class T>
struct LineAllocator {
  using value_type = T;
  LineAllocator() = default;
  template <class U>
  LineAllocator(const LineAllocator<U>&) {}
  // clang-format off: its versions put a space before these parentheses or do not
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new (n * sizeof(T), std::align_val_t{64})); }
  void deallocate(T* p, std::size_t) { ::operator delete (p, std::align_val_t{64}); }
  // clang-format on
  bool operator==(const LineAllocator&) const { return true; }
};
using AlignedFloats = std::vector<float, LineAllocator<float>>;

// Where along a ray J is read: cubic stencil of 4 radii x 4 thetas inside one polar slice, and the azimuth.
struct RayPoint {
  int offset;               // of the stencil's corner, floats
  float radius_weights[4];  // times the quadrature weight
  float theta_weights[4];
  float cosine_at;  // place in the cosine table
};

// cos(m psi) for m < modes, tabulated over psi in [0, pi]; linear in between (error below 3e-4 for m = 15).
struct CosineTable {
  static constexpr int kIntervals = 1024;
  explicit CosineTable(int modes);
  float place(double psi) const;
  // Offset in `samples` of the cosines at psi = pi (b + 0.5) / azimuths, azimuths = modes.
  int exact(int azimuths, int b) const { return b * azimuths; }

  AlignedFloats entries;  // [place][mode]
  AlignedFloats samples;  // [azimuth][mode]
};

// values[b] = sum over the points of ray b of the interpolated J times the azimuth's cosines. modes: 8 or 16.
void trace_rays(int modes, int rays, int points, const float* slice, int row_floats, const float* cosines,
                const RayPoint* ray_points, float* values);

// Azimuth modes of the product Lambda * opacity on every fine polar node. opacity: 2 * modes coefficients a node.
void multiply_opacity(int modes, int nodes, const float* lambda, const float* opacity, float* radiance);

// result[i][m] = sum over j of matrix[i][j][m] * radiance[j][m].
void multiply_phase(int modes, int rows, int columns, const float* matrix, const float* radiance, float* result);

}  // namespace nephele
