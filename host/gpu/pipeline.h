// The kernel as a Vulkan pipeline, specialised to a scene and its settings. Knows nothing of tiles or buffers.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <vector>

#include "gpu/pack_scene.h"
#include "gpu/vulkan_device.h"
#include "image/settings.h"
#include "kernel/buffer_access.h"
#include "kernel/compile.h"
#include "layout.h"

namespace turner {

// The kernel, specialised to a scene and its settings.
struct Pipeline {
  std::vector<uint32_t> words;
  Constants constants;
  vk::raii::DescriptorSetLayout setLayout;
  vk::raii::PipelineLayout layout;
  vk::raii::Pipeline pipeline;
};

// How a binding of the kernel is described to Vulkan.
vk::DescriptorType bindingType(uint32_t binding, BufferAccess access);

// The constants of a kernel for this scene, these settings and this device. `budget`: iterations of an invocation's
// loops in one dispatch. `fresh`: it begins its pixels, else it resumes them. `loopsAtHead`: see DeviceTrust.
Constants specialise(const Features& features, const RenderSettings& settings, uint32_t workGroup, uint32_t budget,
                     bool counters, bool fresh, bool loopsAtHead);

// Pipelines that were used last, kept for later renders.
class KeptPipelines {
 public:
  // The pipeline of this kernel and these constants, kept or new; at most so many are kept. Throws RunError with the
  // complaints of the validation layers.
  std::shared_ptr<const Pipeline> find(const Device& device, const Spirv& kernel, const Constants& constants,
                                       BufferAccess access, size_t most);

 private:
  std::list<std::shared_ptr<const Pipeline>> pipelines_;  // latest first
};

}  // namespace turner
