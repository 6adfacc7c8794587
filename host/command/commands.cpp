// Each command is told as the way that data takes: load, round, build, pack, dispatch, read back, write.
#include "command/commands.h"

#include <fmt/format.h>

#include <algorithm>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include "command/data_folder.h"
#include "command/interrupt.h"
#include "command/progress_line.h"
#include "command/stats.h"
#include "errors.h"
#include "picture/exr.h"
#include "picture/output_file.h"
#include "picture/png.h"
#include "picture/provenance.h"
#include "reference/reference.h"
#include "scene/scene_load.h"
#include "scene/text_file.h"
#include "shader/bvh.h"
#include "shader/glsl.h"
#include "shader/pack.h"
#include "shader/render.h"
#include "shader/round_scene.h"

namespace turner {
namespace {

using Clock = std::chrono::steady_clock;

// The seconds since the last call, or since this stopwatch was made.
class Stopwatch {
 public:
  double lap() {
    const Clock::time_point now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return seconds;
  }

 private:
  Clock::time_point last_ = Clock::now();
};

// Looks at every output before any work is done for it.
void checkOutput(const std::string& path, bool mayBePng) {
  const std::string extension = lowerExtension(path);
  if (extension != ".exr" && !(mayBePng && extension == ".png"))
    throw InputError("cannot write '" + path + "': its name must end in .exr" + (mayBePng ? " or .png" : ""));
  checkWritable(path);
}

// The file that a name stands for, symbolic links followed.
std::filesystem::path realFile(const std::string& path) {
  std::error_code error;
  const std::filesystem::path real = std::filesystem::weakly_canonical(path, error);
  if (error) throw InputError("cannot find out where '" + path + "' is: " + error.message());
  return real;
}

// Two outputs of one name would leave only the last.
void refuseRepeated(const std::vector<std::string>& outputs) {
  for (size_t i = 0; i < outputs.size(); ++i)
    for (size_t j = 0; j < i; ++j)
      if (realFile(outputs[i]) == realFile(outputs[j]))
        throw InputError("the output " + outputs[i] + " is named twice");
}

// An output in the place of an input would destroy it.
void refuseOverwriting(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs) {
  for (const std::string& output : outputs)
    for (const std::string& input : inputs)
      if (realFile(output) == realFile(input))
        throw InputError("the output " + output + " is an input; name another file");
}

// The scene's file and its meshes, which stand beside it or below.
std::vector<std::string> filesOf(const Scene& scene, const std::string& path) {
  std::vector<std::string> files = {path};
  for (size_t i = 1; i < scene.sources.size(); ++i)
    files.push_back((std::filesystem::path(path).parent_path() / scene.sources[i].path).string());
  return files;
}

void writePicture(const std::string& path, const Image& image, const Provenance& provenance) {
  writeWholeFile(path, lowerExtension(path) == ".png" ? encodePng(image) : encodeExr(image, provenance));
}

Scene loadAndTell(const RenderOptions& options) {
  const std::string path = findScene(options.scene);
  Scene scene = loadScene(path);
  if (!options.quiet) {
    fmt::print("scene: {} ({} spheres, {} triangles, {} lights)\n", path, scene.spheres.size(), scene.triangles.size(),
               scene.lights.size());
    for (const std::string& note : scene.notes) fmt::print("note: {}\n", note);
  }
  return scene;
}

double sampleCount(const RenderSettings& settings) {
  return double(settings.crop.area()) * settings.samples * settings.samples;
}

// What either backend hands to the writers.
struct Rendered {
  Image image;
  Stats stats;
};

DeviceInfo chooseDeviceFor(const RenderOptions& options) {
  const char* environment = std::getenv("TURNER_DEVICE");
  const DeviceInfo device = chooseDevice(listDevices(), !options.device.empty() ? options.device
                                                        : environment           ? environment
                                                                                : "");
  return device;
}

// What is told of a scene when its geometry has gone into the renderer.
Scene withoutGeometry(const Scene& scene) {
  Scene rest;
  rest.name = scene.name;
  rest.camera = scene.camera;
  rest.sources = scene.sources;
  return rest;
}

// scene -> rounded -> tree -> packed -> device -> picture. Of a large scene no step's value is kept beyond the next.
Rendered renderWithShader(Scene scene, const RenderSettings& settings, const RenderOptions& options, bool countRays) {
  Rendered result;
  Stats& stats = result.stats;
  stats.backend = "shader";
  stats.geometry = "rounded";  // the kernel has no other
  stats.device = chooseDeviceFor(options);
  ShaderRenderer renderer(stats.device, options.fetch);
  stats.fetch = fetchName(renderer.fetch());
  if (!options.quiet)
    fmt::print("device: {}: {} ({}, {}), fetching {}\n", stats.device.index, stats.device.name, stats.device.type,
               stats.device.driver, stats.fetch);

  Stopwatch watch;
  PackedScene packed = [&] {
    Scene local = roundScene(std::move(scene));
    checkReach(local);
    const Shapes shapes = shapesOf(std::move(local));
    return packScene(shapes, buildBvh(shapes.boxes, shapes.firstPair()), settings);
  }();
  stats.treeNodes = packed.nodes.size();
  stats.treeDepth = packed.treeDepth;
  stats.geometryBytes = packed.bytes();
  stats.seconds.build = watch.lap();
  throwIfInterrupted();

  const Spirv kernel = compileGlsl(shaderFolder(options.shaders) + "/whitted.comp", fetchPreamble(renderer.fetch()));
  stats.seconds.compile = watch.lap();
  throwIfInterrupted();

  renderer.upload(packed);
  packed = {};
  stats.seconds.upload = watch.lap();

  Dispatching dispatching;
  dispatching.tile = options.tile;
  dispatching.workGroup = options.workGroup;
  ShaderPicture picture;
  {
    ProgressLine progress("tracing", sampleCount(settings), options.quiet);
    picture = renderer.render(kernel, settings, std::ref(progress), dispatching);
  }
  stats.seconds.compile += picture.compileSeconds;
  stats.seconds.trace = picture.traceSeconds;
  stats.seconds.readback = picture.readbackSeconds;
  result.image = std::move(picture.image);

  if (countRays) {
    ProgressLine progress("counting rays", sampleCount(settings), options.quiet);
    stats.visits = renderer.countVisits(kernel, settings, std::ref(progress), dispatching);
    stats.rays = stats.visits.rays;
  }
  return result;
}

Rendered renderWithReference(const Scene& scene, const RenderSettings& settings, const RenderOptions& options) {
  Rendered result;
  Stats& stats = result.stats;
  stats.backend = "reference";
  stats.geometry = options.geometry == Geometry::rounded ? "rounded" : "exact";
  stats.device.name = "reference";
  stats.device.driver = "double precision";
  stats.device.type = "CPU";

  Stopwatch watch;
  ProgressLine progress("reference", sampleCount(settings), options.quiet);
  ReferencePicture picture =
      renderReference(options.geometry == Geometry::rounded ? roundScene(scene) : scene, settings, std::ref(progress));
  stats.seconds.trace = watch.lap();
  stats.rays = picture.rays;
  result.image = std::move(picture.image);
  return result;
}

void tellFigures(const Comparison& c, double threshold) {
  fmt::print("size         {} x {}\n", c.width, c.height);
  fmt::print("rmse         {:.3e}   relative {:.3e}\n", c.rmse, c.relRmse);
  fmt::print("mean error   {:.3e}   signed {:+.3e}\n", c.mae, c.meanSigned);
  fmt::print("percentiles  50: {:.3e}   99: {:.3e}   99.9: {:.3e}   max: {:.3e}\n", c.p50, c.p99, c.p999, c.max);
  fmt::print("bad pixels   {:.4f} % off by more than {:g}\n", 100 * c.badPixels, threshold);
  fmt::print("nan, inf     {}, {}\n", c.nan, c.inf);
}

}  // namespace

int runRender(const RenderOptions& options) {
  Stopwatch total, watch;
  if (options.scene.empty()) throw InputError("the name of the scene is empty");
  std::vector<std::string> outputs = options.outputs;
  if (outputs.empty()) outputs = {std::filesystem::path(options.scene).stem().string() + ".exr"};
  for (const std::string& output : outputs) checkOutput(output, true);
  std::vector<std::string> files = outputs;
  if (!options.stats.empty()) {
    checkWritable(options.stats);
    files.push_back(options.stats);
  }
  refuseRepeated(files);

  Scene scene = loadAndTell(options);
  refuseOverwriting(files, filesOf(scene, findScene(options.scene)));
  const RenderSettings settings = settingsFor(scene, options);
  const double loadSeconds = watch.lap();
  throwIfInterrupted();

  const Scene told = withoutGeometry(scene);
  const size_t spheres = scene.spheres.size(), triangles = scene.triangles.size();
  Rendered rendered = options.backend == Backend::shader
                          ? renderWithShader(std::move(scene), settings, options, !options.stats.empty())
                          : renderWithReference(scene, settings, options);
  throwIfInvalid();
  Stats& stats = rendered.stats;
  const Provenance provenance =
      makeProvenance(told, settings, "--backend " + stats.backend + " --geometry " + stats.geometry, stats.device.name,
                     stats.device.driver);
  throwIfInterrupted();
  for (const std::string& output : outputs) {
    writePicture(output, rendered.image, provenance);
    if (!options.quiet) fmt::print("wrote {}\n", output);
  }

  stats.scene = options.scene;
  stats.settings = settings;
  stats.spheres = spheres;
  stats.triangles = triangles;
  stats.seconds.load = loadSeconds;
  stats.seconds.total = total.lap();
  if (!options.stats.empty()) writeWholeFile(options.stats, statsJson(stats));
  if (!options.quiet) {
    fmt::print("traced in {:.3f} s, all in {:.3f} s", stats.seconds.trace, stats.seconds.total);
    if (stats.rays.total() > 0)
      fmt::print(": {} rays, {:.3g} Mray/s", stats.rays.total(),
                 double(stats.rays.total()) / stats.seconds.trace * 1e-6);
    fmt::print("\n");
  }
  return 0;
}

int runCompare(const CompareOptions& compare, const RenderOptions& render) {
  if (!compare.errorImage.empty()) checkOutput(compare.errorImage, false);
  Image a, b;
  if (compare.files.size() == 2) {
    if (!compare.errorImage.empty()) refuseOverwriting({compare.errorImage}, compare.files);
    a = readExr(compare.files[0]);
    b = readExr(compare.files[1]);
  } else {
    if (lowerExtension(compare.files[0]) == ".exr")
      throw InputError("name a second picture to compare " + compare.files[0] + " with");
    RenderOptions options = render;
    options.quiet |= compare.json;  // stdout belongs to the figures
    const Scene scene = loadAndTell(options);
    const RenderSettings settings = settingsFor(scene, options);
    a = renderWithShader(scene, settings, options, false).image;
    throwIfInvalid();
    b = renderWithReference(scene, settings, options).image;
  }

  const Comparison comparison = compareImages(a, b, compare.threshold);
  if (compare.json)
    fmt::print("{}", comparisonJson(comparison));
  else if (!render.quiet)
    tellFigures(comparison, compare.threshold);
  if (!compare.errorImage.empty()) writeWholeFile(compare.errorImage, encodeExr(errorImage(a, b), {}));
  const std::vector<std::string> broken = brokenBounds(comparison, compare.bounds);
  for (const std::string& bound : broken) fmt::print(stderr, "turner: error: {}\n", bound);
  return broken.empty() ? 0 : 1;
}

int runDevices(bool asJson) {
  const std::vector<DeviceInfo> devices = listDevices();
  if (asJson) {
    fmt::print("{}", devicesJson(devices));
    return 0;
  }
  for (const DeviceInfo& device : devices)
    fmt::print("{}: {} ({}), Vulkan {}, {}{}\n", device.index, device.name, device.type, device.api, device.driver,
               device.usable ? "" : ": not usable, needs Vulkan 1.2 and a compute queue");
  return 0;
}

}  // namespace turner
