// The tests' main: doctest's, and then any message of Vulkan's validation layers is a failure too.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <cstdio>

#include "engine/leak_check.h"
#include "tests/support/test_device.h"

int main(int argc, char** argv) {
  doctest::Context context(argc, argv);
  const int result = context.run();
  if (context.shouldExit()) return result;
  nephele::test::release_test_device();
  if (const auto messages = nephele::Device::validation_messages(); messages > 0) {
    std::fprintf(stderr, "%llu Vulkan validation messages: failed\n", static_cast<unsigned long long>(messages));
    return 1;
  }
  return result;
}
