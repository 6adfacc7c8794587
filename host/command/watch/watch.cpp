// `turner watch`: from options to a plan and a listener.
#include "watch/watch.h"

#include <filesystem>
#include <memory>
#include <utility>

#include "base/descriptor_io.h"
#include "base/errors.h"
#include "base/interrupt.h"
#include "base/output_file.h"
#include "base/text_file.h"
#include "command/commands.h"
#include "command/data_folder.h"
#include "command/device_choice.h"
#include "command/outputs.h"
#include "command/overwriting.h"
#include "command/watch/listeners.h"
#include "geometry/round_scene.h"

namespace turner {
using namespace watch;

void runWatch(const WatchOptions& watch, const RenderOptions& render) {
  if (render.scene.empty()) throw InputError("the name of the scene is empty");
  WatchPlan plan;
  plan.scene = findScene(render.scene);
  if (plan.scene == kStandardStream) throw InputError("standard input cannot be watched for changes; name a file");
  if (!std::filesystem::exists(plan.scene)) throw InputError(plan.scene + ": error: there is no such file");
  refusePipe(plan.scene);
  plan.shaders = shaderFolder(render.shaders);
  plan.outputs = render.outputs;
  if (plan.outputs.empty()) plan.outputs = {defaultOutput(render.scene)};
  const std::vector<std::string> files = filesNamed(plan.outputs);
  for (size_t i = 0; i < files.size(); ++i) {
    if (openOutput(files[i]))
      throw InputError("each version's picture replaces the last, which " + nameOfOutput(files[i]) +
                       " cannot show; name a file");
    checkOutput(plan.outputs[i], true);
  }
  plan.keep = watch.keep;
  std::vector<std::string> places = files;
  if (!plan.keep.empty()) places.push_back(plan.keep);
  refuseRepeated(places);
  plan.refuseOverwriting = [=](const std::vector<std::string>& inputs) { refuseOverwriting(files, inputs); };
  plan.refuseOverwriting({plan.scene});
  if (!watch.params.empty() && watch.params != kStandardStream) plan.refuseOverwriting({watch.params});
  plan.refuseOverwriting(shaderFiles(render.shaders));
  plan.timeout = watch.timeout;
  plan.parameters = render.parameters;
  plan.params = watch.params;
  plan.settingsOf = [&](const Scene& scene) { return settingsFor(scene, render); };
  plan.referenceGeometry = [&](Scene scene) {
    return render.geometry == Geometry::rounded ? roundScene(std::move(scene)) : scene;
  };
  plan.chooseDevice = [&] { return chooseDeviceFor(render.device); };
  plan.throwIfInterrupted = throwIfInterrupted;
  plan.writePicture = writePicture;
  plan.access = render.access;
  plan.dispatching = {.tile = render.tile, .workGroup = render.workGroup, .narrow = render.narrow};

  const std::unique_ptr<WatchListener> listener = watch.json ? jsonListener(plan) : textListener(plan, render.quiet);
  watch::watch(plan, *listener);
}

}  // namespace turner
