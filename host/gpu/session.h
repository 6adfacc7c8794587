// A device with a scene and kernels, from one end to the other: open, prepare, compile, upload, render. The seconds of
// each step are kept.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "gpu/devices.h"
#include "gpu/pack_scene.h"
#include "gpu/renderer.h"
#include "image/settings.h"
#include "kernel/buffer_access.h"
#include "kernel/edits/edited_kernel.h"
#include "kernel/shader_sources.h"
#include "scene/scene.h"

namespace turner {

// By the host's clock, but for trace and readback, see ShaderPicture.
struct StepSeconds {
  double build = 0, upload = 0;                 // of the last scene
  double compile = 0, trace = 0, readback = 0;  // sums over all kernels and pictures; the driver's compiler counts too
};

// The acceleration structure of the last scene that was prepared.
struct TreeSize {
  size_t nodes = 0;
  size_t bytes = 0;  // of geometry, tree and lists on the device
  int depth = 0;
};

class RenderSession {
 public:
  // Opens the device. Throws as ShaderRenderer does.
  explicit RenderSession(DeviceInfo device, BufferAccess access = BufferAccess::automatic,
                         Dispatching dispatching = {});

  const DeviceInfo& device() const { return device_; }
  // How kernels fetch the scene that was prepared last.
  BufferAccess access() const { return renderer_.access(); }
  // What the user should know of how the device is used, after upload(); mostly empty.
  const std::string& note() const { return renderer_.note(); }
  const StepSeconds& seconds() const { return seconds_; }
  const TreeSize& tree() const { return tree_; }

  // Scene -> rounded -> tree -> packed, for pictures of these settings. Throws InputError where the scene does not fit
  // float32 or the kernel.
  void prepare(Scene scene, const RenderSettings& settings);
  // Puts what was prepared into the device's memory, and frees it here. Throws InputError when it does not fit,
  // RunError where the device would render it wrongly (gpu/self_test.h).
  void upload();

  // A kernel for this device and the prepared scene's buffer access. Throws InputError with the compiler's first error.
  Kernel compile(const std::vector<ShaderSource>& sources, KernelForm form);
  // Has the kernel's features compiled in, whatever the scene needs; of an uploaded scene.
  void addFeaturesOf(const Kernel& kernel);
  // The settings with a kernel's parameters.
  static RenderSettings withParameters(RenderSettings settings, const std::vector<Parameter>& parameters);
  // What kernels of the uploaded scene have beyond its needs, and all they have.
  ConstantSet addedFeatures() const { return renderer_.addedFeatures(); }
  // Exactly these, for measuring what some of them cost.
  void setAddedFeatures(ConstantSet set) { renderer_.setAddedFeatures(set); }
  const Features& features() const { return renderer_.features(); }

  // Of the uploaded scene, see ShaderRenderer.
  ShaderPicture render(const Spirv& kernel, const RenderSettings& settings, const Progress& progress);
  // `budget` as in Dispatching; 0: the session's own.
  ShaderPicture renderCoarse(const Spirv& kernel, const RenderSettings& settings, int stride, const Progress& progress,
                             uint32_t budget = 0);
  Visits countVisits(const Spirv& kernel, const RenderSettings& settings, const Progress& progress);

 private:
  ShaderPicture timed(ShaderPicture picture);

  DeviceInfo device_;
  ShaderRenderer renderer_;
  Dispatching dispatching_;
  PackedScene packed_;  // between prepare() and upload()
  StepSeconds seconds_;
  TreeSize tree_;
};

}  // namespace turner
