#include "tests/support/test_device.h"

#include <doctest/doctest.h>

#include <memory>
#include <vector>

namespace nephele::test {
namespace {

std::unique_ptr<Device>& device_slot() {
  static std::unique_ptr<Device> device;
  return device;
}

std::vector<std::function<void()>>& releases() {
  static std::vector<std::function<void()>> functions;
  return functions;
}

}  // namespace

Device& test_device() {
  std::unique_ptr<Device>& device = device_slot();
  if (!device) {
    Result<std::unique_ptr<Device>> made = Device::create(DeviceOptions::from_environment());
    if (!made) FAIL("no Vulkan device: " << made.error().message);
    device = std::move(*made);
  }
  return *device;
}

Kernels& test_kernels() {
  static std::unique_ptr<Kernels> kernels;
  if (!kernels) {
    kernels = std::make_unique<Kernels>(test_device());
    release_before_device([] { kernels.reset(); });
  }
  return *kernels;
}

void release_before_device(std::function<void()> release) { releases().push_back(std::move(release)); }

void release_test_device() {
  for (const auto& release : releases()) release();
  releases().clear();
  device_slot().reset();
}

}  // namespace nephele::test
