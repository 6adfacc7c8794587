// Pictures of a scene by either backend, with a progress line and Ctrl-C.
#pragma once

#include "command/command_line.h"
#include "command/stats.h"
#include "gpu/session.h"
#include "image/image.h"
#include "scene/scene.h"

namespace turner {

// Loads the scene of the options and prints what it has, unless they say quiet. Throws InputError.
Scene loadAndPrint(const RenderOptions& options);

// All samples of a picture.
double sampleCount(const RenderSettings& settings);

// What either backend hands to the writers.
struct Rendered {
  Image image;
  Stats stats;
  std::string parameters;  // of the shaders, as --set takes them; empty: none
};

// A scene and its kernel on the device of the options. All calls throw Interrupted after Ctrl-C.
class UploadedScene {
 public:
  // Opens the device, prepares the scene, compiles the kernel and uploads.
  UploadedScene(Scene scene, const RenderSettings& settings, const RenderOptions& options);

  // `what` names the work on the progress line.
  Image render(const RenderSettings& settings, const char* what = "tracing");
  // Of the kernel, with the values that it renders with.
  const std::vector<Parameter>& parameters() const { return kernel_.parameters; }
  void countRays(const RenderSettings& settings);
  Stats stats() const;
  // Of the kernel, as the compiler has found them.
  const std::vector<std::string>& sourceFiles() const { return kernel_.files; }

 private:
  void tellFeatures(const RenderSettings& settings);

  bool quiet_;
  RenderSession session_;
  Kernel kernel_;
  Visits visits_;
  bool toldFeatures_ = false;
};

// Counts rays if the options ask for figures. Throws InputError if one of the files that will be written is a source of
// the kernel.
Rendered renderWithShader(Scene scene, const RenderSettings& settings, const RenderOptions& options,
                          const std::vector<std::string>& outputs);
Rendered renderWithReference(const Scene& scene, const RenderSettings& settings, const RenderOptions& options);

// What the reference traces: the scene as it is or, by --geometry, rounded as the kernel has it.
Scene geometryOf(const Scene& scene, const RenderOptions& options);

}  // namespace turner
