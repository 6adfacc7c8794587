// `turner watch`: from options to a plan and a listener.
#include "watch/watch.h"

#include <csignal>
#include <filesystem>
#include <memory>
#include <utility>

#include "base/errors.h"
#include "base/interrupt.h"
#include "command/commands.h"
#include "command/data_folder.h"
#include "command/device_choice.h"
#include "command/outputs.h"
#include "command/watch/listeners.h"
#include "geometry/round_scene.h"

namespace turner {
using namespace watch;

void runWatch(const WatchOptions& watch, const RenderOptions& render) {
  std::signal(SIGPIPE, SIG_IGN);  // nobody reads any more: a failed write like any other, see flushOutput()
  if (render.scene.empty()) throw InputError("the name of the scene is empty");
  WatchPlan plan;
  plan.scene = findScene(render.scene);
  if (!std::filesystem::exists(plan.scene)) throw InputError(plan.scene + ": error: there is no such file");
  plan.shaders = shaderFolder(render.shaders);
  plan.outputs = render.outputs;
  if (plan.outputs.empty()) plan.outputs = {defaultOutput(render.scene)};
  for (const std::string& output : plan.outputs) checkOutput(output, true);
  refuseRepeated(plan.outputs);
  refuseOverwriting(plan.outputs, {plan.scene});
  plan.keep = watch.keep;
  plan.timeout = watch.timeout;
  plan.settingsOf = [&](const Scene& scene) { return settingsFor(scene, render); };
  plan.referenceGeometry = [&](Scene scene) {
    return render.geometry == Geometry::rounded ? roundScene(std::move(scene)) : scene;
  };
  plan.chooseDevice = [&] { return chooseDeviceFor(render.device); };
  plan.throwIfInterrupted = throwIfInterrupted;
  plan.writePicture = writePicture;
  plan.access = render.access;
  plan.dispatching = {.tile = render.tile, .workGroup = render.workGroup};

  const std::unique_ptr<WatchListener> listener = watch.json ? jsonListener(plan) : textListener(plan, render.quiet);
  watch::watch(plan, *listener);
}

}  // namespace turner
