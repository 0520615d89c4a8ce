// The fine noise that particles have at their edges: one periodic volume, made once for all renderers.
//
// writes -> R8 image of 64^3
// cost: once, at the start.
#pragma once

#include "engine/kernels.h"
#include "engine/resources.h"

namespace nephele {

class DetailNoise {
 public:
  // Made when this returns.
  explicit DetailNoise(Kernels& kernels);

  const Image& image() const { return image_; }

 private:
  Image image_;
};

}  // namespace nephele
