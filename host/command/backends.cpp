// Shader: rounded, packed, uploaded, dispatched, read back. Reference: traced on the host.
#include "command/backends.h"

#include <functional>
#include <utility>

#include "base/errors.h"
#include "base/interrupt.h"
#include "base/stopwatch.h"
#include "base/tell.h"
#include "base/text_file.h"
#include "command/data_folder.h"
#include "command/device_choice.h"
#include "command/overwriting.h"
#include "command/progress_line.h"
#include "geometry/round_scene.h"
#include "kernel/buffer_access.h"
#include "reference/reference.h"
#include "scene/scene_load.h"

namespace turner {

Scene loadAndPrint(const RenderOptions& options) {
  const std::string path = findScene(options.scene);
  Scene scene = loadScene(path);
  if (!options.quiet) {
    tell("scene: {} ({}, {} lights)\n", nameOfInput(path), toText(scene.primitiveCounts()), scene.lights.size());
    for (const std::string& note : scene.notes) tell("{}\n", note);
  }
  return scene;
}

double sampleCount(const RenderSettings& settings) {
  return double(settings.crop.area()) * settings.samples * settings.samples;
}

UploadedScene::UploadedScene(Scene scene, const RenderSettings& settings, const RenderOptions& options)
    : quiet_(options.quiet),
      session_(chooseDeviceFor(options.device), options.access,
               {.tile = options.tile, .workGroup = options.workGroup, .narrow = options.narrow}) {
  std::vector<ParameterSetting> set = scene.parameters;
  set.insert(set.end(), options.parameters.begin(), options.parameters.end());
  session_.prepare(std::move(scene), settings);
  const DeviceInfo& device = session_.device();
  if (!quiet_) {
    tell("device: {}: {} ({}, {}), fetching {}\n", device.index, device.name, device.type, device.driver,
         accessName(session_.access()));
  }
  throwIfInterrupted();
  kernel_ = session_.compile(readShaderSources(shaderFolder(options.shaders) + "/whitted.comp"), KernelForm::asNeeded);
  setParameters(kernel_.parameters, set);
  if (!quiet_) tell("{}", kernel_.warnings);
  throwIfInterrupted();
  session_.upload();
  session_.addFeaturesOf(kernel_);
  if (!quiet_ && !session_.note().empty()) tell("{}\n", session_.note());
}

Image UploadedScene::render(const RenderSettings& settings, const char* what) {
  ProgressLine progress(what, sampleCount(settings), quiet_);
  const RenderSettings all = RenderSession::withParameters(settings, kernel_.parameters);
  try {
    Image image = session_.render(kernel_, all, std::ref(progress)).image;
    tellFeatures(settings);
    return image;
  } catch (const UntrueKernel& untrue) {
    if (kernel_.edited) throw InputError(untrue.what());  // the user's, not the machine's
    throw;
  }
}

// Once: what an edited kernel has.
void UploadedScene::tellFeatures(const RenderSettings& settings) {
  if (!kernel_.edited || quiet_ || std::exchange(toldFeatures_, true)) return;
  for (const std::string& line : featureLines(session_.addedFeatures(), session_.features(), settings))
    tell("{}\n", line);
}

void UploadedScene::countRays(const RenderSettings& settings) {
  ProgressLine progress("counting rays", sampleCount(settings), quiet_);
  const RenderSettings all = RenderSession::withParameters(settings, kernel_.parameters);
  visits_ = session_.countVisits(kernel_, all, std::ref(progress));
}

Stats UploadedScene::stats() const {
  Stats stats;
  stats.backend = "shader";
  stats.geometry = "rounded";  // the kernel has no other
  stats.device = session_.device();
  stats.access = accessName(session_.access());
  stats.editedKernel = kernel_.edited;
  stats.parameters = kernel_.parameters;
  stats.addedFeatures = featureNames(session_.addedFeatures());
  const StepSeconds& seconds = session_.seconds();
  stats.seconds.build = seconds.build;
  stats.seconds.compile = seconds.compile;
  stats.seconds.upload = seconds.upload;
  stats.seconds.trace = seconds.trace;
  stats.seconds.readback = seconds.readback;
  stats.treeNodes = session_.tree().nodes;
  stats.treeDepth = session_.tree().depth;
  stats.geometryBytes = session_.tree().bytes;
  stats.visits = visits_;
  stats.rays = visits_.rays;
  return stats;
}

Rendered renderWithShader(Scene scene, const RenderSettings& settings, const RenderOptions& options,
                          const std::vector<std::string>& outputs) {
  UploadedScene uploaded(std::move(scene), settings, options);
  refuseOverwriting(outputs, uploaded.sourceFiles());
  Rendered result;
  result.image = uploaded.render(settings);
  if (!options.stats.empty()) uploaded.countRays(settings);
  result.stats = uploaded.stats();
  result.parameters = valuesText(uploaded.parameters());
  return result;
}

Scene geometryOf(const Scene& scene, const RenderOptions& options) {
  return options.geometry == Geometry::rounded ? roundScene(scene) : scene;
}

namespace {

// The reference has no shaders.
void refuseParameters(const Scene& scene, const RenderOptions& options) {
  if (options.backend != Backend::reference) return;  // beside the shader's picture
  if (!options.parameters.empty())
    throw InputError("--set: the reference has no parameters; they are those of edited shaders, --shaders DIR");
  if (!scene.parameters.empty() && !options.quiet)
    tell("note: the reference renders without the scene's params, which are for edited shaders\n");
}

}  // namespace

Rendered renderWithReference(const Scene& scene, const RenderSettings& settings, const RenderOptions& options) {
  refuseParameters(scene, options);
  Rendered result;
  Stats& stats = result.stats;
  stats.backend = "reference";
  stats.geometry = options.geometry == Geometry::rounded ? "rounded" : "exact";
  stats.device.name = "reference";
  stats.device.driver = "double precision";
  stats.device.type = "CPU";

  Stopwatch watch;
  ProgressLine progress("reference", sampleCount(settings), options.quiet);
  ReferencePicture picture = renderReference(geometryOf(scene, options), settings, std::ref(progress));
  stats.seconds.trace = watch.lap();
  stats.rays = picture.rays;
  result.image = std::move(picture.image);
  return result;
}

}  // namespace turner
