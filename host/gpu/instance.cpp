// Loader, layers and their complaints, and the list of devices.
#include "gpu/instance.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <mutex>
#include <string>
#include <utility>

#include "base/errors.h"
#include "base/memory_limit.h"

namespace turner {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

constexpr const char* kNoVulkan =
    "no Vulkan device: install a driver, for example the software driver lavapipe "
    "(apt-get install libvulkan1 mesa-vulkan-drivers)";

bool wantsValidation() {
  const char* wish = std::getenv("TURNER_VALIDATION");
  return wish ? std::strcmp(wish, "0") != 0 : bool(TURNER_VALIDATION_DEFAULT);
}

// lavapipe computes in 8 lanes unless its environment asks for more, which it reads when the instance is made. With
// AVX-512 the kernel is 1.1 to 1.4 times faster in 16 lanes (docs/performance.md). What the user has set stays.
void askForWideLanes() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl"))
    setenv("LP_NATIVE_VECTOR_WIDTH", "512", 0);
#endif
}

// What the layers complained about. The callback runs on the driver's threads too.
std::mutex complaintsMutex;
std::string complaints;

VKAPI_ATTR VkBool32 VKAPI_CALL onValidationMessage(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                   VkDebugUtilsMessageTypeFlagsEXT,
                                                   const VkDebugUtilsMessengerCallbackDataEXT* data, void*) {
  const std::scoped_lock lock(complaintsMutex);
  if (complaints.size() < 10'000)
    complaints += (severity >= VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT ? "error: " : "warning: ") +
                  std::string(data->pMessage) + '\n';
  return VK_FALSE;
}

bool hasExtension(const std::vector<vk::ExtensionProperties>& extensions, const char* name) {
  return std::any_of(extensions.begin(), extensions.end(),
                     [&](const vk::ExtensionProperties& e) { return std::strcmp(e.extensionName, name) == 0; });
}

std::string typeName(vk::PhysicalDeviceType type) {
  switch (type) {
    case vk::PhysicalDeviceType::eDiscreteGpu:
      return "discrete GPU";
    case vk::PhysicalDeviceType::eIntegratedGpu:
      return "integrated GPU";
    case vk::PhysicalDeviceType::eVirtualGpu:
      return "virtual GPU";
    case vk::PhysicalDeviceType::eCpu:
      return "CPU";
    default:
      return "other";
  }
}

std::string versionName(uint32_t version) {
  return std::to_string(VK_API_VERSION_MAJOR(version)) + '.' + std::to_string(VK_API_VERSION_MINOR(version)) + '.' +
         std::to_string(VK_API_VERSION_PATCH(version));
}

DeviceInfo describeDevice(const vk::raii::PhysicalDevice& device, int index) {
  const vk::PhysicalDeviceProperties properties = device.getProperties();
  DeviceInfo info;
  info.index = index;
  info.name = properties.deviceName.data();
  info.type = typeName(properties.deviceType);
  info.api = versionName(properties.apiVersion);
  info.usable = properties.apiVersion >= VK_API_VERSION_1_2 && computeFamily(device).has_value();
  if (properties.apiVersion >= VK_API_VERSION_1_2) {
    const auto chain = device.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceDriverProperties>();
    const auto& driver = chain.get<vk::PhysicalDeviceDriverProperties>();
    info.driver = std::string(driver.driverName.data()) + ' ' + driver.driverInfo.data();
  }
  return info;
}

}  // namespace

std::optional<uint32_t> computeFamily(const vk::raii::PhysicalDevice& device) {
  const std::vector<vk::QueueFamilyProperties> families = device.getQueueFamilyProperties();
  std::optional<uint32_t> found;
  for (uint32_t i = 0; i < families.size(); ++i) {
    if (!(families[i].queueFlags & vk::QueueFlagBits::eCompute)) continue;
    if (!(families[i].queueFlags & vk::QueueFlagBits::eGraphics)) return i;
    if (!found) found = i;
  }
  return found;
}

Instance::Instance() try {
  askForWideLanes();
  const vk::ApplicationInfo application("turner", 0, nullptr, 0, VK_API_VERSION_1_2);
  vk::InstanceCreateInfo create({}, &application);

  std::vector<const char*> layers, extensions;
  debugNames_ = hasExtension(context_.enumerateInstanceExtensionProperties(), VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
  // As C has it: Vulkan-Hpp's constructor takes a C callback, newer ones (1.4.309) deprecate that.
  const vk::DebugUtilsMessengerCreateInfoEXT messenger(VkDebugUtilsMessengerCreateInfoEXT{
      .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
      .messageSeverity =
          VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
      .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
      .pfnUserCallback = onValidationMessage});
  constexpr vk::ValidationFeatureEnableEXT kFeatures[] = {vk::ValidationFeatureEnableEXT::eSynchronizationValidation};
  const vk::ValidationFeaturesEXT features(kFeatures, {}, &messenger);
  const bool validation = wantsValidation();
  if (validation) {
    const auto available = context_.enumerateInstanceLayerProperties();
    if (std::none_of(available.begin(), available.end(),
                     [](const auto& layer) { return std::strcmp(layer.layerName, kValidationLayer) == 0; }))
      throw RunError(
          "TURNER_VALIDATION is set, but the validation layers are missing "
          "(apt-get install vulkan-validationlayers)");
    layers.push_back(kValidationLayer);
    debugNames_ = true;  // the layer brings the extension
    create.setPNext(&features);
  }
  if (debugNames_) extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
  create.setPEnabledLayerNames(layers).setPEnabledExtensionNames(extensions);
  instance_.emplace(context_, create);
  if (validation) messenger_.emplace(*instance_, messenger);
} catch (const vk::IncompatibleDriverError&) {
  throw RunError(kNoVulkan + memoryLimitHint());
}

std::vector<vk::raii::PhysicalDevice> Instance::physicalDevices() const {
  try {
    vk::raii::PhysicalDevices devices(*instance_);
    return {std::make_move_iterator(devices.begin()), std::make_move_iterator(devices.end())};
  } catch (const vk::InitializationFailedError&) {
    return {};  // how the loader says that no driver has a device
  }
}

void throwIfInvalid() {
  const std::scoped_lock lock(complaintsMutex);
  if (complaints.empty()) return;
  throw RunError("the Vulkan validation layers complain:\n" + std::exchange(complaints, {}));
}

std::vector<DeviceInfo> listDevices() {
  const auto instance = std::make_shared<const Instance>();
  std::vector<DeviceInfo> devices;
  for (const vk::raii::PhysicalDevice& device : instance->physicalDevices()) {
    devices.push_back(describeDevice(device, int(devices.size())));
    devices.back().instance = instance;
  }
  if (devices.empty()) throw RunError(kNoVulkan + memoryLimitHint());
  return devices;
}

}  // namespace turner
