// What depends on the kind of device: kernels' sizes, which of two kernels is used, how shaders load records. This is
// the only place that asks what a device is. Pictures do not depend on the tuning (beyond the last bits of sums); tests
// run both kinds on one device and compare them.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <string>

#include "engine/result.h"

namespace nephele {

struct DeviceInfo;

enum class TuningKind : std::uint8_t { automatic, cpu, gpu };

const char* tuning_kind_name(TuningKind kind);               // "auto", "cpu", "gpu"
Result<TuningKind> parse_tuning_kind(const std::string& s);  // the same names; empty: automatic

struct Tuning {
  TuningKind kind;  // cpu or gpu: what the numbers below are meant for

  // Shaders read records through uniform texel buffers; otherwise through storage buffers (shaders/kit/texels.glsl).
  bool texel_buffers;

  // Tiled blending: a thread shades a column of eight pixels and reads the optical depth table packed to bytes;
  // otherwise a thread shades one pixel and samples the table as a texture.
  bool pixel_columns;

  // How often the loops of a shader may go round in one run, all of them together.
  std::uint32_t loop_rounds;

  // Exact blending: places of its tile's list that one thread goes through before it merges what it has.
  std::uint32_t exact_places;

  // Prefix sum: values that a thread adds up, threads of a workgroup.
  std::uint32_t sum_run, sum_local_size;

  // Radix sort: the fewest pairs worth a thread; most threads, unless loop_rounds asks for more; threads of a group.
  std::uint32_t sort_run, sort_max_threads, sort_local_size;
};

// The device's own tuning, or the one asked for. texel_buffers stays false where the device's texel buffers are too
// small for a frame, whatever was asked for.
Tuning tuning_for(const DeviceInfo& device, TuningKind wanted = TuningKind::automatic);

// For people: "discrete GPU", "CPU", …
const char* device_type_name(VkPhysicalDeviceType type);

// Which device is taken when none is named: the one with the highest preference, the first of several.
int device_preference(const DeviceInfo& device);

}  // namespace nephele
