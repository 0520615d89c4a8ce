#include "tests/support/test_device.h"

#include "engine/check.h"

nephele::Device& test_device() {
  static const std::unique_ptr<nephele::Device> device = [] {
    auto created = nephele::Device::create(nephele::DeviceOptions::from_environment());
    NEPHELE_CHECK(created, created ? "" : created.error().message);
    return std::move(*created);
  }();
  return *device;
}
