// What `turner watch` prints: for people a line as soon as a picture is there and aligned lines with what the change
// did, for programs one JSON object on a line for each event. Diagnoses go to stderr in both.
#pragma once

#include <memory>

#include "watch/listener.h"
#include "watch/plan.h"

namespace turner {

// Both print that watching begins. `plan` stays with the caller.
std::unique_ptr<watch::WatchListener> textListener(const watch::WatchPlan& plan, bool quiet);
std::unique_ptr<watch::WatchListener> jsonListener(const watch::WatchPlan& plan);

}  // namespace turner
