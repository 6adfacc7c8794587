// The process that renders edited shaders. It may crash or hang as they please; the watcher kills it and starts
// another.
#pragma once

#include "watch/plan.h"
#include "watch/process/channel.h"

namespace turner::watch {

// Does the jobs that come down the line, one after the other, until the other end is gone or the device is lost.
void workForWatcher(Channel& line, const WatchPlan& plan);

// Stride of the first, coarse picture of a version.
inline constexpr int kCoarseStride = 8;

}  // namespace turner::watch
