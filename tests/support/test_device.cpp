#include "tests/support/test_device.h"

#include <doctest/doctest.h>

#include <map>
#include <memory>
#include <optional>
#include <vector>

namespace nephele::test {
namespace {

std::map<std::optional<TestTuning>, std::unique_ptr<Device>>& devices() {
  static std::map<std::optional<TestTuning>, std::unique_ptr<Device>> made;
  return made;
}

std::optional<TestTuning>& current() {
  static std::optional<TestTuning> tuning;
  return tuning;
}

std::vector<std::function<void()>>& releases() {
  static std::vector<std::function<void()>> functions;
  return functions;
}

}  // namespace

Device& test_device() {
  std::unique_ptr<Device>& device = devices()[current()];
  if (!device) {
    DeviceOptions options = DeviceOptions::from_environment();
    if (current()) options.tuning = *current() == TestTuning::gpu ? "gpu" : "cpu";
    Result<std::unique_ptr<Device>> made = Device::create(options);
    if (!made) FAIL("no Vulkan device: " << made.error().message);
    device = std::move(*made);
    if (current() == TestTuning::cpu_storage) {
      Tuning tuning = device->tuning();
      tuning.texel_buffers = false;
      device->set_tuning(tuning);
    }
  }
  return *device;
}

Kernels& test_kernels() {
  static std::map<Device*, std::unique_ptr<Kernels>> kernels;
  std::unique_ptr<Kernels>& of_device = kernels[&test_device()];
  if (!of_device) {
    if (kernels.size() == 1) release_before_device([] { kernels.clear(); });
    of_device = std::make_unique<Kernels>(test_device());
  }
  return *of_device;
}

void release_before_device(std::function<void()> release) { releases().push_back(std::move(release)); }

const char* test_tuning_name(TestTuning tuning) {
  switch (tuning) {
    case TestTuning::cpu:
      return "cpu";
    case TestTuning::cpu_storage:
      return "cpu, storage buffers";
    case TestTuning::gpu:
      return "gpu";
  }
  return "?";
}

WithTuning::WithTuning(TestTuning tuning) { current() = tuning; }
WithTuning::~WithTuning() { current().reset(); }

void release_test_device() {
  for (const auto& release : releases()) release();
  releases().clear();
  devices().clear();
}

}  // namespace nephele::test
