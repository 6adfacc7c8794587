// The scene's arrays go into one buffer each.
#include "gpu/scene_on_device.h"

#include <span>
#include <string>
#include <vector>

#include "base/errors.h"

namespace turner {
namespace {

using gpu::uint;

static_assert(gpu::kBindCount - gpu::kBindNodes == kSceneArrays && sizeof(gpu::Word4) == kWordBytes);

template <class T>
std::span<const std::byte> bytesOf(const std::vector<T>& values) {
  return std::as_bytes(std::span<const T>(values));
}

// The way of fetching that suits a device.
BufferAccess chooseAccess(const Device& device, BufferAccess wanted) {
  if (wanted == BufferAccess::automatic)
    return device.isCpu() && device.canAccess(BufferAccess::texelBuffer)      ? BufferAccess::texelBuffer
           : !device.isCpu() && device.canAccess(BufferAccess::deviceAddress) ? BufferAccess::deviceAddress
                                                                              : BufferAccess::storageBuffer;
  if (!device.canAccess(wanted))
    throw InputError("the device " + device.info().name + " cannot fetch rows as " + accessName(wanted));
  return wanted;
}

}  // namespace

SceneOnDevice::SceneOnDevice(const DeviceInfo& info, BufferAccess wanted)
    : device(info), access(chooseAccess(device, wanted)) {
  const uint bindings = device.limits().maxPerStageDescriptorStorageBuffers;
  const uint needed = access == BufferAccess::storageBuffer ? gpu::kBindCount : gpu::kBindNodes;
  if (bindings < needed)
    throw RunError("the device " + info.name + " binds " + std::to_string(bindings) +
                   " storage buffers; turner needs " + std::to_string(needed));
}

void SceneOnDevice::upload(PackedScene scene) {
  features = scene.features;
  view = scene.view;
  const auto uploadWords = [&](uint binding, auto& values, const char* name) {
    Buffer& buffer = rows[binding - gpu::kBindNodes];
    buffer = {};  // the last scene's is no longer needed
    buffer = device.uploadWords(bytesOf(values), access, name);
    values.clear();  // memory for the next
    values.shrink_to_fit();
  };
  uploadWords(gpu::kBindNodes, scene.nodes, "nodes");
  uploadWords(gpu::kBindPrimitives, scene.primitives, "primitives");
  uploadWords(gpu::kBindVertexNormals, scene.vertexNormals, "vertex normals");
  uploadWords(gpu::kBindMaterials, scene.materials, "materials");
  uploadWords(gpu::kBindLights, scene.lights, "lights");
  uploadWords(gpu::kBindLightBuffers, scene.lightBuffers, "light buffers");
}

}  // namespace turner
