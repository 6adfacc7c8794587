// Chooses among the listed devices; no Vulkan here.
#include "gpu/devices.h"

#include <algorithm>
#include <cctype>
#include <map>

#include "base/errors.h"
#include "base/number.h"

namespace turner {
namespace {

std::string lowerCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return text;
}

std::string listed(const std::vector<DeviceInfo>& devices) {
  std::string text;
  for (const DeviceInfo& device : devices)
    text += "\n  " + std::to_string(device.index) + ": " + device.name + " (" + device.type + ")" +
            (device.usable ? "" : ", not usable: needs Vulkan 1.2 and a compute queue");
  return text;
}

}  // namespace

DeviceInfo chooseDevice(const std::vector<DeviceInfo>& devices, const std::string& wanted) {
  if (wanted.empty()) {
    // Software devices last, but welcome.
    static const std::map<std::string, int> kRank = {
        {"discrete GPU", 0}, {"integrated GPU", 1}, {"virtual GPU", 2}, {"CPU", 3}, {"other", 4}};
    const DeviceInfo* best = nullptr;
    for (const DeviceInfo& device : devices)
      if (device.usable && (!best || kRank.at(device.type) < kRank.at(best->type))) best = &device;
    if (!best) throw RunError("no Vulkan device has Vulkan 1.2 and a compute queue; there are:" + listed(devices));
    return *best;
  }

  long long index = 0;
  const bool isIndex = parseInteger(wanted, index) == NumberFault::none;
  std::vector<DeviceInfo> found;
  for (const DeviceInfo& device : devices) {
    const bool fits =
        isIndex ? device.index == index : lowerCase(device.name).find(lowerCase(wanted)) != std::string::npos;
    if (fits) found.push_back(device);
  }
  if (found.size() > 1)
    throw InputError("the device name '" + wanted + "' fits more than one device; use an index:" + listed(found));
  if (found.empty()) throw InputError("no device '" + wanted + "'; there are:" + listed(devices));
  if (!found[0].usable) throw InputError("the device '" + wanted + "' is not usable:" + listed(found));
  return found[0];
}

}  // namespace turner
