// The one device that a test executable uses, and what tests of single passes make them with.
#pragma once

#include <functional>

#include "engine/device.h"
#include "engine/workshop.h"

namespace nephele::test {

// Made at the first call, with validation where NEPHELE_VALIDATION says so. No usable device fails the test.
Device& test_device();

// Its pipelines, kept for all tests of the executable.
Kernels& test_kernels();

// Destroys it and, before it, whatever was handed to release_before_device; called by main before it counts validation
// messages.
void release_test_device();
void release_before_device(std::function<void()> release);

}  // namespace nephele::test
