// The image darker towards its corners, as a wide lens draws it.
//
// reads -> writes: HDR image -> HDR image
// cost: one load and one store a pixel.
#pragma once

#include "engine/workshop.h"

namespace nephele {

class Vignette {
 public:
  explicit Vignette(Workshop& make);
  void add(FrameBuilder& frame, const Image& hdr, float strength);

 private:
  const ComputeKernel& kernel_;
};

}  // namespace nephele
