// The one device that a test executable uses.
#pragma once

#include "engine/device.h"

namespace nephele::test {

// Made at the first call, with validation where NEPHELE_VALIDATION says so. No usable device fails the test.
Device& test_device();

// Destroys it; called by main before it counts validation messages.
void release_test_device();

}  // namespace nephele::test
