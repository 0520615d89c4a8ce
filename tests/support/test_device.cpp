#include "tests/support/test_device.h"

#include <doctest/doctest.h>

#include <memory>

namespace nephele::test {
namespace {

std::unique_ptr<Device>& device_slot() {
  static std::unique_ptr<Device> device;
  return device;
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

void release_test_device() { device_slot().reset(); }

}  // namespace nephele::test
