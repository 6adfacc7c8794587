// Each step is one call; what is added here is its time.
#include "gpu/session.h"

#include <algorithm>
#include <utility>

#include "base/stopwatch.h"
#include "gpu/prepare.h"

namespace turner {

RenderSession::RenderSession(DeviceInfo device, BufferAccess access, Dispatching dispatching)
    : device_(std::move(device)), renderer_(device_, access), dispatching_(std::move(dispatching)) {}

void RenderSession::prepare(Scene scene, const RenderSettings& settings) {
  Stopwatch watch;
  packed_ = {};  // of a large scene no two are kept
  packed_ = prepareScene(std::move(scene), settings);
  tree_ = {.nodes = packed_.nodes.size(), .bytes = packed_.bytes(), .depth = packed_.treeDepth};
  renderer_.plan(packed_);
  seconds_.build = watch.lap();
}

void RenderSession::upload() {
  Stopwatch watch;
  renderer_.upload(std::exchange(packed_, {}));
  seconds_.upload = watch.lap();
}

Kernel RenderSession::compile(const std::vector<ShaderSource>& sources, KernelForm form) {
  Stopwatch watch;
  Kernel kernel = compileKernel(sources, access(), form);
  seconds_.compile += watch.lap();
  return kernel;
}

void RenderSession::addFeaturesOf(const Kernel& kernel) {
  if (dispatching_.narrow) return;
  ConstantSet set = 0;
  for (const FeatureUse& use : kernel.uses) set |= ConstantSet(1) << use.constant;
  renderer_.addFeatures(set);
}

RenderSettings RenderSession::withParameters(RenderSettings settings, const std::vector<Parameter>& parameters) {
  const auto words = packParameters(parameters);
  std::copy(words.begin(), words.end(), settings.parameters.begin());
  return settings;
}

ShaderPicture RenderSession::render(const Spirv& kernel, const RenderSettings& settings, const Progress& progress) {
  return timed(renderer_.render(kernel, settings, progress, dispatching_));
}

ShaderPicture RenderSession::renderCoarse(const Spirv& kernel, const RenderSettings& settings, int stride,
                                          const Progress& progress, uint32_t budget) {
  Dispatching dispatching = dispatching_;
  if (budget > 0) dispatching.budget = budget;
  return timed(renderer_.renderCoarse(kernel, settings, stride, progress, dispatching));
}

Visits RenderSession::countVisits(const Spirv& kernel, const RenderSettings& settings, const Progress& progress) {
  return renderer_.countVisits(kernel, settings, progress, dispatching_);
}

ShaderPicture RenderSession::timed(ShaderPicture picture) {
  seconds_.compile += picture.compileSeconds;
  seconds_.trace += picture.traceSeconds;
  seconds_.readback += picture.readbackSeconds;
  return picture;
}

}  // namespace turner
