// The device that a command runs on.
#pragma once

#include <string>

#include "gpu/devices.h"

namespace turner {

// That of --device, else that of the environment's TURNER_DEVICE, else the best one. Throws as chooseDevice does.
DeviceInfo chooseDeviceFor(const std::string& option);

}  // namespace turner
