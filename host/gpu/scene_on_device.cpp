// The scene's arrays go into one buffer each.
#include "gpu/scene_on_device.h"

#include <span>
#include <string>
#include <utility>
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

// The way of fetching that suits a device best, of those in which it can read an array of this size.
BufferAccess chooseAccess(const Device& device, BufferAccess wanted, size_t largestArray) {
  if (wanted != BufferAccess::automatic) {
    if (!device.canAccess(wanted))
      throw InputError("the device " + device.info().name + " cannot fetch rows as " + accessName(wanted));
    return wanted;
  }
  using Ways = std::array<BufferAccess, 3>;
  const Ways ways = device.isCpu()
                        ? Ways{BufferAccess::texelBuffer, BufferAccess::storageBuffer, BufferAccess::deviceAddress}
                        : Ways{BufferAccess::deviceAddress, BufferAccess::storageBuffer, BufferAccess::texelBuffer};
  std::optional<BufferAccess> widest;
  for (const BufferAccess way : ways) {
    if (!device.canAccess(way)) continue;
    if (device.mostBytes(way) >= largestArray) return way;
    if (!widest || device.mostBytes(way) > device.mostBytes(*widest)) widest = way;
  }
  return *widest;  // the upload will say by how much it is too small
}

void checkBindings(const Device& device, BufferAccess access) {
  const uint bindings = device.limits().maxPerStageDescriptorStorageBuffers;
  const uint needed = access == BufferAccess::storageBuffer ? gpu::kBindCount : gpu::kBindNodes;
  if (bindings < needed)
    throw RunError("the device " + device.info().name + " binds " + std::to_string(bindings) +
                   " storage buffers; turner needs " + std::to_string(needed));
}

}  // namespace

SceneOnDevice::SceneOnDevice(const DeviceInfo& info, BufferAccess wantedAccess)
    : device(info), wanted(wantedAccess), access(chooseAccess(device, wanted, 0)) {}

void SceneOnDevice::plan(const PackedScene& scene) {
  access = chooseAccess(device, wanted, scene.largestArray());
  checkBindings(device, access);
  if (tested_ == access) return;
  if (test_.valid()) test_.wait();  // of the scene before, which was not uploaded
  tested_ = access;
  test_ = std::async([this, way = access] { return testDevice(device, way, selfTestSources()); });
}

void SceneOnDevice::upload(PackedScene scene) {
  plan(scene);
  if (test_.valid()) {
    tested_.reset();  // unless it passes
    trust = test_.get();
    tested_ = access;
  }
  features = sceneFeatures = scene.features;
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
