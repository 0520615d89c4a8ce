#include "passes/sky/vignette.h"

#include "nephele_shaders.h"

namespace nephele {

Vignette::Vignette(Workshop& make) : kernel_(make.compute(shaders::vignette_comp)) {}

void Vignette::add(FrameBuilder& frame, const Image& hdr, float strength) {
  frame.compute({.name = "vignette",
                 .kernel = &kernel_,
                 .bindings = {{0, hdr, Access::storage_read_write}},
                 .push = as_push(strength),
                 .groups = {(hdr.extent().width + 7) / 8, (hdr.extent().height + 7) / 8, 1}});
}

}  // namespace nephele
