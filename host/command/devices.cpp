// `turner devices`.
#include <fmt/format.h>

#include "base/tell.h"
#include "command/commands.h"
#include "command/stats.h"
#include "gpu/devices.h"

namespace turner {

int runDevices(bool asJson) {
  const std::vector<DeviceInfo> devices = listDevices();
  if (asJson) {
    printResult(devicesJson(devices));
    return 0;
  }
  for (const DeviceInfo& device : devices)
    printResult(fmt::format("{}: {} ({}), Vulkan {}, {}{}\n", device.index, device.name, device.type, device.api,
                            device.driver, device.usable ? "" : ": not usable, needs Vulkan 1.2 and a compute queue"));
  return 0;
}

}  // namespace turner
