// The one device that a test executable uses. No device is a failure, not a skip.
#pragma once

#include "engine/device.h"

// Made at first use; NEPHELE_VALIDATION=1 turns validation on. Ends the program when there is none.
nephele::Device& test_device();
