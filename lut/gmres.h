// GMRES (Saad and Schultz 1986) for x - K x = b, matrix-free, single precision vectors and double precision sums.
#pragma once

#include <functional>
#include <vector>

namespace nephele {

struct GmresResult {
  std::vector<float> x;
  int applications = 0;  // of K
  double residual = 0;   // |b - x + K x| / |b|, as the recurrence estimates it
};

// apply(in, out): out = K in. Restarts after `restart` vectors; stops at relative residual `tolerance` or after
// max_applications.
GmresResult gmres(const std::function<void(const float*, float*)>& apply, const std::vector<float>& b, double tolerance,
                  int restart, int max_applications);

}  // namespace nephele
