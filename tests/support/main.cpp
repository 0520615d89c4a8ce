// Runs the tests of one executable; any validation message fails it.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <cstdio>

#include "engine/device.h"

int main(int argc, char** argv) {
  doctest::Context context(argc, argv);
  const int failed = context.run();
  const auto messages = nephele::Device::validation_messages();
  if (messages > 0) std::fprintf(stderr, "%llu validation messages\n", static_cast<unsigned long long>(messages));
  return failed != 0 || messages > 0 ? 1 : 0;
}
