// The engine on a real device: transfers, chained dispatches with derived barriers, indirect dispatch, timings.
#include <doctest/doctest.h>

#include <numeric>
#include <random>

#include "engine/frame.h"
#include "nephele_test_shaders.h"
#include "shared/types.h"
#include "tests/support/test_device.h"

using namespace nephele;
using namespace nephele::test;

TEST_CASE("buffers start as zeros and keep what is written") {
  Buffer buffer(test_device(), "buffer", 64);
  CHECK(buffer.read_vector<std::uint32_t>(16) == std::vector<std::uint32_t>(16, 0));
  std::vector<std::uint32_t> values(16);
  std::iota(values.begin(), values.end(), 7u);
  buffer.write_vector(values);
  CHECK(buffer.read_vector<std::uint32_t>(16) == values);
}

TEST_CASE("images keep what is written, in 2D and 3D") {
  for (const ImageDesc& desc : {ImageDesc{VK_FORMAT_R32_SFLOAT, 5, 3}, ImageDesc{VK_FORMAT_R32_SFLOAT, 4, 3, 2}}) {
    Image image(test_device(), "image", desc);
    std::vector<float> texels(image.tight_bytes() / sizeof(float));
    std::iota(texels.begin(), texels.end(), 0.5f);
    image.write(std::as_bytes(std::span(texels)));
    std::vector<float> back(texels.size());
    image.read(std::as_writable_bytes(std::span(back)));
    CHECK(back == texels);
  }
}

TEST_CASE("steps run in order, direct and indirect, and are timed by name") {
  Device& device = test_device();
  const ComputeKernel twice(device, shaders::test_double_comp);
  constexpr std::uint32_t kCount = 1000;
  Buffer a(device, "a", kCount * 4), b(device, "b", kCount * 4), c(device, "c", kCount * 4),
      arguments(device, "arguments", 12);
  const Buffer back(device, "back", kCount * 4, Buffer::Memory::readback);
  std::vector<std::uint32_t> values(kCount);
  std::iota(values.begin(), values.end(), 1u);
  a.write_vector(values);
  arguments.write_vector(std::vector<std::uint32_t>{(kCount + 63) / 64, 1, 1});

  FrameBuilder frame(device);
  frame.compute({.name = "first",
                 .kernel = &twice,
                 .bindings = {{0, a, Access::storage_read}, {1, b, Access::storage_write}},
                 .push = as_push(kCount),
                 .groups = {(kCount + 63) / 64, 1, 1}});
  frame.compute({.name = "second",
                 .kernel = &twice,
                 .bindings = {{0, b, Access::storage_read}, {1, c, Access::storage_write}},
                 .push = as_push(kCount),
                 .indirect = {&arguments, 0}});
  frame.read_back("read", c, back, kCount * 4);
  FrameExecutor executor(device);
  for (int run = 0; run < 2; ++run) {
    executor.run(frame);
    const auto* result = static_cast<const std::uint32_t*>(back.mapped());
    bool right = true;
    for (std::uint32_t i = 0; i < kCount; ++i) right = right && result[i] == 4 * values[i];
    CHECK(right);
  }
  const auto times = executor.pass_times();
  REQUIRE(times.size() == 3);
  CHECK(times[0].name == "first");
  CHECK(times[1].name == "second");
  for (const PassTime& time : times) CHECK(time.gpu_ms >= 0.0);
}

TEST_CASE("records read as texels are what was written as structures, with each tuning") {
  for (const TestTuning tuning : kTestTunings) {
    CAPTURE(std::string(test_tuning_name(tuning)));
    const WithTuning with(tuning);
    Device& device = test_device();
    const ComputeKernel copy(device, shaders::test_texels_comp);
    constexpr std::uint32_t kCount = 100;
    std::mt19937 random(4);
    struct Kind {
      std::size_t words;
      Access access;
    };
    const Kind kinds[] = {{sizeof(shared::Particle) / 4, Access::texels},
                          {sizeof(shared::ParticleLight) / 4, Access::texels},
                          {sizeof(shared::DrawParticle) / 4, Access::texels},
                          {1, Access::words}};
    std::vector<std::vector<std::uint32_t>> written;
    std::vector<Buffer> from, to;
    for (const Kind& kind : kinds) {
      std::vector<std::uint32_t> words(kCount * kind.words);
      for (std::uint32_t& word : words)
        word = 0x3f000000u + random() % 0x01000000u;  // any float's bits, or an integer's
      written.push_back(words);
      from.emplace_back(device, "from", words.size() * 4);
      to.emplace_back(device, "to", words.size() * 4);
      from.back().write_vector(words);
    }
    FrameBuilder frame(device);
    ComputeStep step{.name = "copy", .kernel = &copy, .push = as_push(kCount), .groups = {(kCount + 63) / 64, 1, 1}};
    for (std::uint32_t i = 0; i < 4; ++i) step.bindings.emplace_back(i, from[i], kinds[i].access);
    for (std::uint32_t i = 0; i < 4; ++i) step.bindings.emplace_back(4 + i, to[i], Access::storage_write);
    frame.compute(std::move(step));
    FrameExecutor(device).run(frame);
    for (std::size_t i = 0; i < 4; ++i) {
      CAPTURE(i);
      CHECK(to[i].read_vector<std::uint32_t>(written[i].size()) == written[i]);
    }
  }
}
