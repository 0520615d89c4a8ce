// nephele devices: what Vulkan offers here, and which blending backend each device would use.
#include <cstdio>

#include "engine/device.h"
#include "passes/layer/cloud_layer.h"
#include "tools/command.h"

namespace nephele::tools {
namespace {

void print_device(const DeviceInfo& device) {
  std::printf("%u  %s\n", device.index, device.name.c_str());
  std::printf("   %s, Vulkan %u.%u.%u%s%s\n", device_type_name(device.type), VK_API_VERSION_MAJOR(device.api_version),
              VK_API_VERSION_MINOR(device.api_version), VK_API_VERSION_PATCH(device.api_version),
              device.driver.empty() ? "" : ", driver ", device.driver.c_str());
  if (!device.usable) {
    std::printf("   not usable: it lacks %s\n", device.missing.c_str());
    return;
  }
  std::printf("   fragment shader interlock: %s; rasterization-order attachments: %s; storage buffers up to %.0f MiB\n",
              device.fragment_shader_interlock ? "yes" : "no", device.ordered_attachment_access ? "yes" : "no",
              static_cast<double>(device.max_storage_buffer_bytes) / (1024.0 * 1024.0));
  const Tuning tuning = tuning_for(device);
  std::printf("   tuning: %s, records in %s buffers\n", tuning_kind_name(tuning.kind),
              tuning.texel_buffers ? "texel" : "storage");
  const BackendChoice choice = automatic_backend(device);
  std::printf("   backend: %s (%s)\n", backend_name(choice.backend), choice.reason);
}

Result<void> run_devices() {
  const Result<std::vector<DeviceInfo>> devices = Device::list();
  if (!devices) return devices.error();
  if (devices->empty())
    return Error{"no Vulkan device; Debian's package mesa-vulkan-drivers provides one that needs no GPU"};
  for (const DeviceInfo& device : *devices) print_device(device);
  return {};
}

}  // namespace

Command add_devices_command(CLI::App& program) {
  CLI::App* app = program.add_subcommand(
      "devices", "List Vulkan devices, the features that matter here and the backend each would use");
  return {app, run_devices};
}

}  // namespace nephele::tools
