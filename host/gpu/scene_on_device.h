// A device, the scene in its memory, and what is kept from one render to the next.
#pragma once

#include <array>
#include <cstdint>
#include <future>
#include <optional>

#include "gpu/devices.h"
#include "gpu/pack_scene.h"
#include "gpu/pipeline.h"
#include "gpu/self_test.h"
#include "gpu/vulkan_device.h"
#include "kernel/buffer_access.h"

namespace turner {

struct SceneOnDevice {
  // Opens the device. Throws RunError when it cannot be opened, InputError when it cannot fetch in the wanted way.
  SceneOnDevice(const DeviceInfo& info, BufferAccess wanted);

  // Chooses how a scene will be fetched, and begins to hold the device to the self-test: beside what the caller does up
  // to upload(), which must leave the device alone. Throws RunError where the device binds too few buffers.
  void plan(const PackedScene& scene);

  // Replaces the scene. Throws InputError when it does not fit, RunError where the device has failed the self-test.
  void upload(PackedScene scene);

  Device device;
  BufferAccess wanted;
  BufferAccess access;     // how the scene is fetched; never automatic
  DeviceTrust trust;       // for kernels that fetch so; known after upload()
  Features sceneFeatures;  // what the scene needs
  Features features;       // what kernels get: these, and what edited ones need besides
  View view;
  std::array<Buffer, kSceneArrays> rows;  // from gpu::kBindNodes on
  KeptPipelines pipelines;
  // Work-groups in one dispatch: follows the measured times, from one tile to the next.
  uint32_t groupsPerDispatch = 64;

 private:
  std::optional<BufferAccess> tested_;  // in test, while test_ is valid
  std::future<DeviceTrust> test_;       // the last member: it uses the device
};

}  // namespace turner
