// Diffusion of light in the homogeneous unit sphere, axisymmetric about the beam: finite volumes on the sphere solver's
// own (radius, theta) nodes, factorised once.
#pragma once

#include <memory>
#include <vector>

#include "lut/sphere_axes.h"

namespace nephele {

class SphereDiffusion {
 public:
  // extinction and transport extinction, per radius.
  SphereDiffusion(const RadialAxis& radial, int radii, int thetas, double sigma, double transport_sigma);
  ~SphereDiffusion();

  // Scalar flux (integral of radiance over all directions) that a source makes: - div(grad flux / (3 transport)) =
  // sigma * source, vacuum outside (Marshak: outward current = flux / 2). Both are indexed [radius][theta].
  std::vector<double> solve(const std::vector<double>& source) const;

 private:
  struct Factorization;
  std::unique_ptr<Factorization> factorization_;
  std::vector<double> volumes_;  // times sigma
};

}  // namespace nephele
