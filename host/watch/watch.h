// Renders a scene again and again, whenever its files or the shaders' sources change.
#pragma once

#include "watch/listener.h"
#include "watch/plan.h"

namespace turner::watch {

// Goes on until plan.throwIfInterrupted throws, and lets that pass. Before the first picture it throws what no edit can
// mend: a device that is not there (InputError, RunError). Precondition: the process is single-threaded, because
// this forks.
[[noreturn]] void watch(const WatchPlan& plan, WatchListener& listener);

}  // namespace turner::watch
