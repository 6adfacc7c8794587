// A device, the scene in its memory, and what is kept from one render to the next.
#pragma once

#include <array>
#include <cstdint>

#include "gpu/devices.h"
#include "gpu/pack_scene.h"
#include "gpu/pipeline.h"
#include "gpu/vulkan_device.h"
#include "kernel/buffer_access.h"

namespace turner {

struct SceneOnDevice {
  // Opens the device. Throws RunError when it cannot be opened or binds too few buffers, InputError when it cannot
  // fetch in the wanted way.
  SceneOnDevice(const DeviceInfo& info, BufferAccess wanted);

  // Replaces the scene. Throws InputError when it does not fit.
  void upload(PackedScene scene);

  Device device;
  BufferAccess access;  // never automatic
  Features features;
  View view;
  std::array<Buffer, kSceneArrays> rows;  // from gpu::kBindNodes on
  KeptPipelines pipelines;
  // Work-groups in one dispatch: follows the measured times, from one tile to the next.
  uint32_t groupsPerDispatch = 64;
};

}  // namespace turner
