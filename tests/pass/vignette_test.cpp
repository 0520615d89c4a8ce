// The image's corners: darker by the formula, and the middle as it was.
#include <doctest/doctest.h>

#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "passes/sky/vignette.h"
#include "tests/support/test_device.h"

using namespace nephele;

TEST_CASE("vignette: the middle stays, a corner loses half the strength") {
  Device& device = test::test_device();
  Image hdr(device, "hdr", {VK_FORMAT_R32G32B32A32_SFLOAT, 256, 256});
  std::vector<glm::vec4> pixels(256 * 256, glm::vec4(1.0f));
  hdr.write(std::as_bytes(std::span(pixels)));

  Workshop make(test::test_kernels());
  Vignette vignette(make);
  FrameExecutor executor(device);
  FrameBuilder frame(device);
  vignette.add(frame, hdr, 0.5f);
  executor.run(frame);

  hdr.read(std::as_writable_bytes(std::span(pixels)));
  CHECK(pixels[128 * 256 + 128].r == doctest::Approx(1.0).epsilon(1e-5));  // half a pixel from the middle
  // A corner's pixel is 0.5 - 1/512 from the middle in x and in y.
  CHECK(pixels[0].r == doctest::Approx(1.0 - 0.5 * 2 * 0.498046875 * 0.498046875).epsilon(1e-6));
}
