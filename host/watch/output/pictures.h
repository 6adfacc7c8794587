// Files of a version: its picture in every output, and the folder of a kept version.
#pragma once

#include <string>
#include <vector>

#include "watch/plan.h"
#include "watch/versions.h"

namespace turner::watch {

// Writes a picture to all outputs at once. Returns a message for each that cannot be written.
std::vector<std::string> writeOutputs(const WatchPlan& plan, const Image& image, const SceneReady& scene, bool coarse);

// Keeps sources, scene, picture and figures of a version in plan.keep. Returns its folder. Throws std::runtime_error.
std::string keepGood(const WatchPlan& plan, const GoodVersion& good, const VersionReport& report);

}  // namespace turner::watch
