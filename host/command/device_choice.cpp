// --device, TURNER_DEVICE, else the best one.
#include "command/device_choice.h"

#include <cstdlib>

namespace turner {

DeviceInfo chooseDeviceFor(const std::string& option) {
  const char* environment = std::getenv("TURNER_DEVICE");
  return chooseDevice(listDevices(), !option.empty() ? option : environment ? environment : "");
}

}  // namespace turner
