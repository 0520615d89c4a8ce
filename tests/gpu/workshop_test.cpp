// A renderer's buffers and images by name: handed out again while they fit, freed when no frame can use them any more.
#include <doctest/doctest.h>

#include <cstring>

#include "engine/workshop.h"
#include "nephele_test_shaders.h"
#include "tests/support/test_device.h"

using namespace nephele;
using nephele::test::test_device;
using nephele::test::test_kernels;

namespace {

std::vector<std::byte> bytes_of(const char* text) {
  const auto* data = reinterpret_cast<const std::byte*>(text);
  return {data, data + std::strlen(text)};
}

}  // namespace

TEST_CASE("what still fits is handed out again, and only what does not is made") {
  Workshop make(test_kernels());
  make.begin();
  const std::uint64_t buffer = make.buffer("buffer", 4 << 20).id();
  const std::uint64_t image = make.image("image", {.width = 8, .height = 8}).id();
  const std::uint64_t upload = make.uploaded("upload", bytes_of("words")).id();
  make.end(0);
  CHECK(make.made_count() == 3);

  make.begin();
  CHECK(make.buffer("buffer", 3 << 20).id() == buffer);  // smaller: the same
  CHECK(make.image("image", {.width = 8, .height = 8}).id() == image);
  CHECK(make.uploaded("upload", bytes_of("words")).id() == upload);
  make.end(0);
  CHECK(make.made_count() == 3);

  make.begin();
  CHECK(make.buffer("buffer", 5 << 20).id() != buffer);
  CHECK(make.image("image", {.width = 8, .height = 9}).id() != image);
  const Buffer& other = make.uploaded("upload", bytes_of("wards"));
  CHECK(other.id() != upload);
  CHECK(other.read_vector<char>(5) == std::vector<char>{'w', 'a', 'r', 'd', 's'});
  make.end(0);
  CHECK(make.made_count() == 6);

  make.begin();
  const Buffer& small = make.buffer("buffer", 1 << 10);  // far less than is kept: the large one is let go
  CHECK(small.bytes() == 1 << 10);
  make.end(0);
}

TEST_CASE("what is no longer asked for is freed once the frames that may use it have finished") {
  Workshop make(test_kernels());
  make.begin();
  make.buffer("old", 1 << 20);
  make.end(0);
  const VkDeviceSize with_old = test_device().allocated_bytes();
  const std::uint64_t frames = 10;  // 0 .. 9 recorded; 9 may be under way
  make.begin();
  make.end(frames);
  CHECK(test_device().allocated_bytes() == with_old);
  make.free_unused(frames);  // about to record frame 10: frame 8 has finished
  CHECK(test_device().allocated_bytes() == with_old);
  make.free_unused(frames + 1);  // about to record frame 11: frame 9 has finished
  CHECK(test_device().allocated_bytes() <= with_old - (1 << 20));
}

TEST_CASE("a pipeline is made once for a shader and its constants") {
  Kernels kernels(test_device());
  const SpecConstant one[] = {{0, 1}}, two[] = {{0, 2}};
  const ComputeKernel& first = kernels.compute(shaders::test_double_comp, one);
  CHECK(&kernels.compute(shaders::test_double_comp, one) == &first);
  CHECK(kernels.count() == 1);
  CHECK(&kernels.compute(shaders::test_double_comp, two) != &first);
  CHECK(kernels.count() == 2);
}
