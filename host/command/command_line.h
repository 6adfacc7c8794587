// The command line as plain data. CLI11 appears in command_line.cpp only.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/parameter_setting.h"
#include "image/compare.h"
#include "image/settings.h"
#include "kernel/buffer_access.h"
#include "scene/scene.h"

namespace turner {

enum class CommandKind { render, compare, watch, report, devices, shaders, printed };
enum class Backend { shader, reference };
enum class Geometry { exact, rounded };

// What `render` takes, and `compare SCENE` and `watch` too. Empty: the scene's value.
struct RenderOptions {
  std::string scene;
  std::vector<std::string> outputs;
  std::optional<int> width, height, depth;
  int samples = 1;
  Sampler sampler = Sampler::grid;
  uint32_t seed = 0;
  double minWeight = 0;
  Backend backend = Backend::shader;
  Geometry geometry = Geometry::exact;
  std::string device, crop, shaders, stats;
  std::vector<ParameterSetting> parameters;  // --set
  bool quiet = false;
  BufferAccess access = BufferAccess::automatic;  // how the kernel fetches the scene; never changes the picture
  bool narrow = false;                            // an edited kernel gets no more than the scene needs
  int tile = 0;                                   // how the work is cut; never changes the picture
  int workGroup = 64;
};

struct CompareOptions {
  std::vector<std::string> files;  // two EXR files, or one scene
  ErrorBounds bounds;
  double threshold = 1e-3;
  std::string errorImage;
  bool json = false;
  bool decompose = false, envelope = false;  // of a scene only
};

// What `watch` takes beside what `render` does.
struct WatchOptions {
  std::string keep;     // a folder; empty: versions are not kept
  std::string params;   // a file of settings, or - for standard input; empty: none
  double timeout = 10;  // seconds
  bool json = false;
};

struct ReportOptions {
  std::vector<std::string> scenes;
  std::string output = "report";  // a folder
  bool quick = false, full = false, noCutOffs = false;
  std::optional<int> maxSamples, repeats;
  std::optional<int> width, height, depth;
  std::string device, crop, shaders;
  bool keepExr = false, quiet = false;
};

// What `shaders` takes: one of both folders.
struct ShaderOptions {
  std::string copyTo, check;
  std::string scene;  // to check for; empty: none
  bool json = false;
};

struct CommandLine {
  CommandKind kind = CommandKind::printed;  // printed: help or version, already shown
  RenderOptions render;
  CompareOptions compare;
  WatchOptions watch;
  ReportOptions report;
  bool devicesAsJson = false;
  ShaderOptions shaders;
};

// Throws InputError with one clear message; prints help and version itself.
CommandLine parseCommandLine(int argc, char** argv);

// What a scene's picture depends on: the scene's own size and depth, overridden by the options. Throws InputError when
// crop and size do not fit each other or memory.
RenderSettings settingsFor(const Scene& scene, const RenderOptions& options);

}  // namespace turner
