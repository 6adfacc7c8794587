// How a render is cut into dispatches, and how a kernel shows that its picture is not to be trusted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "base/errors.h"

namespace turner {

// How the work is cut. Never changes the picture.
struct Dispatching {
  int tile = 0;        // pixels on a tile's side, rounded up to a multiple of 8; 0: what suits the device
  int workGroup = 64;  // invocations in a work-group, rounded up to whole subgroups of the device
  // Iterations of an invocation's loops in one dispatch, at least kLeastBudget; 0: what the device bears, see layout.h.
  // Tests set others.
  uint32_t budget = 0;
  bool narrow = false;       // an edited kernel has what the scene needs, and is refused if it needs more
  bool loopsAtHead = false;  // the kernel's loops end at their head, also where the device does not need it (tests)
  // Most pipelines that are kept for later renders: of the kernel in hand and of one to compare it with, each to begin
  // and to take up work, and those that count. Who renders many settings in turn keeps more.
  size_t keptPipelines = 8;
  // Called before the driver is given a pipeline to compile, which may take longer than any dispatch; the next call of
  // progress tells that it is done.
  std::function<void()> compiles;
};

// With fewer iterations an invocation might not get anywhere: one turn of each loop costs up to 8 + 4 + 3 + 1, see
// whitted.comp and traverse.glsl.
inline constexpr uint32_t kLeastBudget = 40;

// The kernel ran, the device is well, and the picture is not to be trusted.
struct UntrueKernel : RunError {
  using RunError::RunError;
};
// A driver's loop limiter has ended loops of the kernel: it makes too many turns, or never ends.
struct LoopsCut : UntrueKernel {
  uint32_t count;  // Status::limiter of layout.h
  LoopsCut(const std::string& what, uint32_t limiter) : UntrueKernel(what), count(limiter) {}
};
// An edited kernel lacks what was not compiled in, see Status::lacks of layout.h.
struct FeaturesLacking : RunError {
  uint32_t lacks;
  explicit FeaturesLacking(uint32_t lacking) : RunError("the kernel lacks what it needs"), lacks(lacking) {}
};
// The kernel has ended without finishing its pixels.
struct PixelsMissing : UntrueKernel {
  using UntrueKernel::UntrueKernel;
};

}  // namespace turner
