// The device that a test executable uses, with one tuning or another, and what tests of single passes make them with.
#pragma once

#include <functional>

#include "engine/device.h"
#include "engine/workshop.h"

namespace nephele::test {

// Made at the first call, with validation where NEPHELE_VALIDATION says so. No usable device fails the test.
Device& test_device();

// The pipelines of test_device() as it is now, kept for all tests of the executable.
Kernels& test_kernels();

// The tunings that every test device is tried with: the kernels for CPUs, the same reading storage buffers instead of
// texel buffers, the kernels for GPUs.
enum class TestTuning { cpu, cpu_storage, gpu };
inline constexpr TestTuning kTestTunings[] = {TestTuning::cpu, TestTuning::cpu_storage, TestTuning::gpu};
const char* test_tuning_name(TestTuning tuning);

// While it lives, test_device() is a second device with that tuning. What is made from it may not be used after.
class WithTuning {
 public:
  explicit WithTuning(TestTuning tuning);
  ~WithTuning();
  WithTuning(const WithTuning&) = delete;
  WithTuning& operator=(const WithTuning&) = delete;
};

// Destroys the devices and, before them, whatever was handed to release_before_device; called by main before it counts
// validation messages.
void release_test_device();
void release_before_device(std::function<void()> release);

}  // namespace nephele::test
