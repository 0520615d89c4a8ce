// The interactive sky: window, swapchain and panel about a Viewer and the library's Renderer, frame by frame.
#pragma once

#include <optional>
#include <string>

#include "engine/device.h"
#include "engine/result.h"
#include "tools/fly/fly_script.h"
#include "tools/fly/sky_loader.h"
#include "tools/fly/viewer.h"

namespace nephele::fly {

struct FlyJob {
  Viewer::Start start;
  DeviceOptions device;
  SkyLoader::GetTables tables;
  std::optional<FlyScript> script;  // instead of a person; at its end the program ends
  std::string directory;            // for pictures, flights and scenes; "" for the present one
  std::string stats;                // file for the times; "" for none
};

// Until the window is closed. Errors are the user's: no window system, no device, bad files.
Result<void> run_fly(FlyJob job);

}  // namespace nephele::fly
