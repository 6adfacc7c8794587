// Renders a packed scene on a Vulkan device: uploads, dispatches tile by tile, reads back. No Vulkan in this header.
#pragma once

#include <memory>
#include <string>

#include "gpu/devices.h"
#include "gpu/dispatching.h"
#include "gpu/kernel_features.h"
#include "gpu/pack_scene.h"
#include "image/settings.h"
#include "kernel/buffer_access.h"
#include "kernel/compile.h"

namespace turner {

struct SceneOnDevice;

// What rays met on their way, by kind of ray.
struct Visits {
  RayCounts rays, nodes, primitives;
};

struct ShaderPicture {
  Image image;
  double compileSeconds = 0;   // pipeline and one empty dispatch: drivers compile there
  double traceSeconds = 0;     // of the dispatches, by the device's clock
  double readbackSeconds = 0;  // from the device into the image
};

class ShaderRenderer {
 public:
  // Opens the device. Throws RunError when it cannot be opened, InputError when it cannot fetch in the wanted way.
  explicit ShaderRenderer(const DeviceInfo& device, BufferAccess access = BufferAccess::automatic);
  ~ShaderRenderer();

  // Chooses how this scene will be fetched, by what fits, and begins to test the device (gpu/self_test.h), which takes
  // a tenth of a second beside what the caller does up to upload(). Throws RunError where the device binds too few
  // buffers.
  void plan(const PackedScene& scene);
  // How kernels are to fetch the scene that was planned last, see accessPreamble.
  BufferAccess access() const;
  // What the user should know of how the device is used, after upload(); mostly empty.
  const std::string& note() const;

  // Has kernels of the uploaded scene compile in more than it needs (gpu/kernel_features.h); an edited kernel that
  // lacks something is given it on its own. What has been added so far, and all that there is now.
  void addFeatures(ConstantSet set);
  void setAddedFeatures(ConstantSet set);
  ConstantSet addedFeatures() const;
  const Features& features() const;

  // Puts the scene into the device's memory, and frees it part by part. Throws InputError when it does not fit,
  // RunError when the device's pictures would be wrong, and as plan() does.
  void upload(PackedScene scene);

  // Renders the uploaded scene. Work is cut into dispatches well below a driver's watchdog; progress is called between
  // them. Throws LoopsCut if a driver's loop limiter has cut the work short, PixelsMissing if the kernel has,
  // InputError if an edited kernel needs what cannot be compiled in.
  ShaderPicture render(const Spirv& kernel, const RenderSettings& settings, const Progress& progress = {},
                       const Dispatching& dispatching = {});

  // The same of every stride-th pixel across and down, from the crop's first on: these have their values of the full
  // picture, and every other pixel of the image that of the nearest of them.
  ShaderPicture renderCoarse(const Spirv& kernel, const RenderSettings& settings, int stride,
                             const Progress& progress = {}, const Dispatching& dispatching = {});

  // Counts the rays of the same picture, and what they meet, by a kernel with counters compiled in.
  Visits countVisits(const Spirv& kernel, const RenderSettings& settings, const Progress& progress = {},
                     const Dispatching& dispatching = {});

 private:
  ShaderPicture trace(const Spirv& kernel, const RenderSettings& settings, int stride, const Progress& progress,
                      const Dispatching& dispatching);
  ShaderPicture traceOnce(const Spirv& kernel, const RenderSettings& settings, int stride, const Progress& progress,
                          const Dispatching& dispatching);
  Visits count(const Spirv& kernel, const RenderSettings& settings, const Progress& progress,
               const Dispatching& dispatching);
  template <class Work>
  auto withAllItNeeds(const RenderSettings& settings, const Dispatching& dispatching, const Work& work);
  std::unique_ptr<SceneOnDevice> scene_;
};

}  // namespace turner
