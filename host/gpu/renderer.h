// Renders a packed scene on a Vulkan device: uploads, dispatches tile by tile, reads back. Vulkan itself stays in
// render.cpp and gpu.
#pragma once

#include <functional>
#include <memory>

#include "base/errors.h"
#include "gpu/devices.h"
#include "gpu/pack_scene.h"
#include "image/settings.h"
#include "kernel/buffer_access.h"
#include "kernel/compile.h"

namespace turner {

// How the work is cut. Never changes the picture.
struct Dispatching {
  int tile = 0;        // pixels on a tile's side, rounded up to a multiple of 8; 0: what suits the device
  int workGroup = 64;  // invocations in a work-group, rounded up to whole subgroups of the device
  // Iterations of an invocation's loops in one dispatch, at least kLeastBudget; 0: what the device bears, see layout.h.
  // Tests set others.
  uint32_t budget = 0;
  // Called before the driver is given a pipeline to compile, which may take longer than any dispatch; the next call of
  // progress tells that it is done.
  std::function<void()> compiles;
};

// With fewer iterations an invocation might not get anywhere: one turn of each loop costs up to 8 + 4 + 3 + 1, see
// whitted.comp and traverse.glsl.
inline constexpr uint32_t kLeastBudget = 40;

// What rays met on their way, by kind of ray.
struct Visits {
  RayCounts rays, nodes, primitives;
};

struct ShaderPicture {
  Image image;
  double compileSeconds = 0;   // pipeline and one warm-up dispatch: drivers compile there
  double traceSeconds = 0;     // of the dispatches, by the device's clock
  double readbackSeconds = 0;  // from the device into the image
};

// The kernel ran, the device is well, and the picture is not to be trusted.
struct UntrueKernel : RunError {
  using RunError::RunError;
};
// A driver's loop limiter has ended loops of the kernel: it makes too many turns, or never ends.
struct LoopsCut : UntrueKernel {
  uint32_t count;  // Status::limiter of layout.h
  LoopsCut(const std::string& what, uint32_t limiter) : UntrueKernel(what), count(limiter) {}
};
// The kernel has ended without finishing its pixels.
struct PixelsMissing : UntrueKernel {
  using UntrueKernel::UntrueKernel;
};

class ShaderRenderer {
 public:
  // Opens the device. Throws RunError when it cannot be opened, InputError when it cannot fetch in the wanted way.
  explicit ShaderRenderer(const DeviceInfo& device, BufferAccess access = BufferAccess::automatic);
  ~ShaderRenderer();

  // How its kernels are to fetch, see accessPreamble.
  BufferAccess access() const;

  // Puts the scene into the device's memory. Throws InputError when it does not fit.
  void upload(const PackedScene& scene);

  // Renders the uploaded scene. Work is cut into dispatches well below a driver's watchdog; progress is called between
  // them. Throws LoopsCut if a driver's loop limiter has cut the work short, PixelsMissing if the kernel has.
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
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace turner
