// Free paths through a medium that is bounded cell by cell: a tentative collision at the bound's rate is a real one
// with the extinction's share of the bound (Woodcock 1965); for transmittance the shares are multiplied instead (ratio
// tracking, Novak et al. 2014). Optical depth that is left at a cell's end goes on in the next.
//
//   walk(visit)                        calls visit(cell, near_m, far_m) for the cells along the ray, until it returns
//   true bound(cell)                        no less than the extinction anywhere in the cell, above 0 extinction(cell,
//   at_m, enough)     at a distance along the ray; may stop adding up beyond `enough`
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "tools/path_tracer/medium.h"
#include "tools/path_tracer/random.h"

namespace nephele::truth {

// Distance to a collision, Medium::kNever without one.
template <class Walk, class Bound, class Extinction>
float track_collision(Random& random, const Walk& walk, const Bound& bound, const Extinction& extinction) {
  float depth = -std::log(1.0f - random()), found_m = Medium::kNever;
  walk([&](std::size_t cell, float near_m, float far_m) {
    const float most_per_m = bound(cell);
    for (float at_m = near_m;;) {
      at_m += depth / most_per_m;
      if (at_m >= far_m) {
        depth = (at_m - far_m) * most_per_m;
        return false;
      }
      const float chosen = random() * most_per_m;
      if (chosen < extinction(cell, at_m, chosen)) {
        found_m = at_m;
        return true;
      }
      depth = -std::log(1.0f - random());
    }
  });
  return found_m;
}

// Unbiased; transmittances below kRouletteBelow are kept at it, or dropped.
template <class Walk, class Bound, class Extinction>
float track_transmittance(Random& random, const Walk& walk, const Bound& bound, const Extinction& extinction) {
  constexpr float kRouletteBelow = 0.05f;
  float left = 1.0f, depth = -std::log(1.0f - random());
  walk([&](std::size_t cell, float near_m, float far_m) {
    const float most_per_m = bound(cell);
    for (float at_m = near_m;;) {
      at_m += depth / most_per_m;
      if (at_m >= far_m) {
        depth = (at_m - far_m) * most_per_m;
        return false;
      }
      left *= std::max(0.0f, 1.0f - extinction(cell, at_m, std::numeric_limits<float>::infinity()) / most_per_m);
      if (left < kRouletteBelow) {
        if (random() * kRouletteBelow >= left) {
          left = 0.0f;
          return true;
        }
        left = kRouletteBelow;
      }
      depth = -std::log(1.0f - random());
    }
  });
  return left;
}

}  // namespace nephele::truth
