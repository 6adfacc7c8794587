// What a report measures, and by whom.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "command/command_line.h"
#include "gpu/devices.h"
#include "report/measure.h"
#include "report/renderers.h"
#include "scene/scene.h"

namespace turner {

// The scenes, loaded, what is to be done with each, and by whom.
struct ReportPlan {
  std::vector<Scene> scenes;
  std::vector<report::SceneToSweep> sweeps;
  std::vector<DeviceInfo> devices;
  std::vector<report::RendererInfo> renderers;
  std::string shaders;
  int repeats = 1;
};

// Loads the scenes, chooses the devices and compiles the kernel for each. Throws InputError and RunError.
ReportPlan planFor(const ReportOptions& options);

// The devices' renderers and, last, the reference's, their names unique.
std::vector<std::unique_ptr<report::Renderer>> openRenderers(const Scene& scene, const std::vector<DeviceInfo>& devices,
                                                             const std::string& shaders);

// A hash of all that the measurements depend on.
std::string fingerprint(const ReportPlan& plan);

// File names may be any bytes, JSON and HTML are UTF-8: bytes that are not become question marks.
std::string validUtf8(const std::string& text);

}  // namespace turner
