// What stays the same while a scene and its shaders are watched.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/parameter_setting.h"
#include "gpu/devices.h"
#include "gpu/renderer.h"
#include "image/exr.h"
#include "image/settings.h"
#include "kernel/buffer_access.h"
#include "scene/scene.h"

namespace turner::watch {

struct WatchPlan {
  std::string scene;                         // path
  std::string shaders;                       // folder of whitted.comp
  std::vector<std::string> outputs;          // .exr and .png; written anew at each version
  std::string keep;                          // folder of all versions; empty: none is kept
  double timeout = 10;                       // seconds that a piece of work may last
  std::vector<ParameterSetting> parameters;  // of the command line
  std::string params;                        // file of settings that is followed, "-": standard input; empty: none

  std::function<RenderSettings(const Scene&)> settingsOf;  // throws InputError
  std::function<Scene(Scene)> referenceGeometry;           // what the reference traces
  std::function<DeviceInfo()> chooseDevice;                // throws InputError and RunError
  std::function<void()> throwIfInterrupted;                // throws Interrupted
  // Throws InputError if one of the inputs is an output: edited files may name what was none before.
  std::function<void(const std::vector<std::string>& inputs)> refuseOverwriting;
  std::function<void(const std::string& path, const Image& image, const Provenance& provenance)> writePicture;
  BufferAccess access = BufferAccess::automatic;
  Dispatching dispatching;
};

}  // namespace turner::watch
