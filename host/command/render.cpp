// `turner render`: load, render by either backend, write.
#include <fmt/format.h>

#include <utility>

#include "base/errors.h"
#include "base/interrupt.h"
#include "base/output_file.h"
#include "base/stopwatch.h"
#include "base/tell.h"
#include "command/backends.h"
#include "command/commands.h"
#include "command/data_folder.h"
#include "command/outputs.h"
#include "command/overwriting.h"
#include "image/provenance.h"
#include "scene/scene_load.h"

namespace turner {
namespace {

// Summary of a scene whose geometry has gone into the renderer.
Scene withoutGeometry(const Scene& scene) {
  Scene rest;
  rest.name = scene.name;
  rest.camera = scene.camera;
  rest.sources = scene.sources;
  return rest;
}

}  // namespace

int runRender(const RenderOptions& options) {
  Stopwatch total, watch;
  if (options.scene.empty()) throw InputError("the name of the scene is empty");
  std::vector<std::string> outputs = options.outputs;
  if (outputs.empty()) outputs = {defaultOutput(options.scene)};
  for (const std::string& output : outputs) checkOutput(output, true);
  std::vector<std::string> files = filesNamed(outputs);
  if (!options.stats.empty()) {
    checkWritable(options.stats);
    files.push_back(options.stats);
  }
  refuseRepeated(files);
  refuseOverwriting(files, {findScene(options.scene)});
  refuseOverwriting(files, shaderFiles(options.shaders));
  leaveStdoutTo(files);

  Scene scene = loadAndPrint(options);
  refuseOverwriting(files, filesOf(findScene(options.scene), scene.sources));
  const RenderSettings settings = settingsFor(scene, options);
  const double loadSeconds = watch.lap();
  throwIfInterrupted();

  const Scene summary = withoutGeometry(scene);
  const PrimitiveCounts primitives = scene.primitiveCounts();
  Rendered rendered = options.backend == Backend::shader ? renderWithShader(std::move(scene), settings, options, files)
                                                         : renderWithReference(scene, settings, options);
  throwIfInvalid();
  Stats& stats = rendered.stats;
  Provenance provenance =
      makeProvenance(summary, settings, "--backend " + stats.backend + " --geometry " + stats.geometry,
                     stats.device.name, stats.device.driver);
  if (!rendered.parameters.empty()) provenance.strings.emplace_back("turner:params", rendered.parameters);
  throwIfInterrupted();
  Deliveries deliveries;
  for (const std::string& output : outputs) {
    const std::string file = pictureNamed(output).file;
    deliveries.attempt(file, [&] {
      writePicture(output, rendered.image, provenance);
      if (!options.quiet) tell("wrote {}\n", nameOfOutput(file));
    });
  }

  stats.scene = options.scene;
  stats.settings = settings;
  stats.primitives = primitives;
  stats.seconds.load = loadSeconds;
  stats.seconds.total = total.lap();
  if (!options.stats.empty())
    deliveries.attempt(options.stats, [&] { writeWholeFile(options.stats, statsJson(stats)); });
  deliveries.throwIfAnyFailed();
  if (!options.quiet) {
    const std::string rays = stats.rays.total() == 0
                                 ? ""
                                 : fmt::format(": {} rays, {:.3g} Mray/s", stats.rays.total(),
                                               double(stats.rays.total()) / stats.seconds.trace * 1e-6);
    tell("traced in {:.3f} s, all in {:.3f} s{}\n", stats.seconds.trace, stats.seconds.total, rays);
  }
  return 0;
}

}  // namespace turner
