// Each command reads as its data flow: load, round, build, pack, dispatch, read back, write.
#include "command/commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "base/errors.h"
#include "base/output_file.h"
#include "base/stopwatch.h"
#include "base/text_file.h"
#include "command/data_folder.h"
#include "command/device_choice.h"
#include "command/interrupt.h"
#include "command/outputs.h"
#include "command/progress_line.h"
#include "command/stats.h"
#include "geometry/round_scene.h"
#include "gpu/session.h"
#include "image/envelope.h"
#include "image/error_analysis.h"
#include "image/exr.h"
#include "image/png.h"
#include "image/provenance.h"
#include "kernel/buffer_access.h"
#include "reference/reference.h"
#include "scene/scene_load.h"

namespace turner {
namespace {

Scene loadAndPrint(const RenderOptions& options) {
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

// Summary of a scene whose geometry has gone into the renderer.
Scene withoutGeometry(const Scene& scene) {
  Scene rest;
  rest.name = scene.name;
  rest.camera = scene.camera;
  rest.sources = scene.sources;
  return rest;
}

// A scene on its device, with progress lines and Ctrl-C.
class UploadedScene {
 public:
  UploadedScene(Scene scene, const RenderSettings& settings, const RenderOptions& options)
      : quiet_(options.quiet),
        session_(chooseDeviceFor(options.device), options.access,
                 {.tile = options.tile, .workGroup = options.workGroup}) {
    const DeviceInfo& device = session_.device();
    if (!quiet_)
      fmt::print("device: {}: {} ({}, {}), fetching {}\n", device.index, device.name, device.type, device.driver,
                 accessName(session_.access()));
    session_.prepare(std::move(scene), settings);
    throwIfInterrupted();
    kernel_ = session_.compile(shaderFolder(options.shaders) + "/whitted.comp");
    throwIfInterrupted();
    session_.upload();
  }

  // `what` names the work on the progress line.
  Image render(const RenderSettings& settings, const char* what = "tracing") {
    ProgressLine progress(what, sampleCount(settings), quiet_);
    return session_.render(kernel_, settings, std::ref(progress)).image;
  }

  void countRays(const RenderSettings& settings) {
    ProgressLine progress("counting rays", sampleCount(settings), quiet_);
    visits_ = session_.countVisits(kernel_, settings, std::ref(progress));
  }

  Stats stats() const {
    Stats stats;
    stats.backend = "shader";
    stats.geometry = "rounded";  // the kernel has no other
    stats.device = session_.device();
    stats.access = accessName(session_.access());
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

 private:
  bool quiet_;
  RenderSession session_;
  Spirv kernel_;
  Visits visits_;
};

Rendered renderWithShader(Scene scene, const RenderSettings& settings, const RenderOptions& options, bool countRays) {
  UploadedScene uploaded(std::move(scene), settings, options);
  Rendered result;
  result.image = uploaded.render(settings);
  if (countRays) uploaded.countRays(settings);
  result.stats = uploaded.stats();
  return result;
}

Scene geometryOf(const Scene& scene, const RenderOptions& options) {
  return options.geometry == Geometry::rounded ? roundScene(scene) : scene;
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
  ReferencePicture picture = renderReference(geometryOf(scene, options), settings, std::ref(progress));
  stats.seconds.trace = watch.lap();
  stats.rays = picture.rays;
  result.image = std::move(picture.image);
  return result;
}

void printFigures(const Comparison& c, double threshold) {
  fmt::print("size         {} x {}\n", c.width, c.height);
  fmt::print("rmse         {:.3e}   relative {:.3e}\n", c.rmse, c.relRmse);
  fmt::print("mean error   {:.3e}   signed {:+.3e}\n", c.mae, c.meanSigned);
  fmt::print("percentiles  50: {:.3e}   99: {:.3e}   99.9: {:.3e}   max: {:.3e}\n", c.p50, c.p99, c.p999, c.max);
  fmt::print("bad pixels   {:.4f} % off by more than {:g}\n", 100 * c.badPixels, threshold);
  fmt::print("nan, inf     {}, {}\n", c.nan, c.inf);
}

void printDecomposition(const Decomposition& decomposition) {
  fmt::print("{:<13}{:<11}{:<11}{:<11}{:<11}{:<11}{}\n", "", "rmse", "p50", "p99", "p99.9", "max", "signed");
  const auto print = [](const char* name, const Comparison& c) {
    fmt::print("{:<13}{:<11.3e}{:<11.3e}{:<11.3e}{:<11.3e}{:<11.3e}{:+.3e}\n", name, c.rmse, c.p50, c.p99, c.p999,
               c.max, c.meanSigned);
  };
  const SamplingError& sampling = decomposition.sampling;
  print("sampling", sampling.figures);
  print("arithmetic", decomposition.arithmetic);
  print("quantisation", decomposition.quantisation);
  fmt::print("own error    {:.3e} rms, of the {} samples that sampling is measured against{}\n", sampling.ownError,
             sampling.samples, sampling.converged ? "" : ": did not converge");
}

void printEnvelope(const EnvelopeRule& rule) {
  fmt::print("envelope     {:.4f} % off by more than {:g}, {:.4f} % excused, {} pixels outside\n", 100 * rule.needed,
             kEnvelopeTolerance, 100 * rule.excused, rule.outside);
  fmt::print("the rest     99: {:.3e}   99.9: {:.3e}\n", rule.p99, rule.p999);
}

// The two pictures, and what else is known of their difference.
struct Compared {
  Image a, b;
  std::optional<Decomposition> decomposition;
  std::optional<EnvelopeRule> envelope;
};

// `reference` is the picture with the options' geometry; the other geometry's is rendered here.
Decomposition decompose(const SamplingError& sampling, const Image& shader, const Image& reference, const Scene& scene,
                        const RenderSettings& settings, const RenderOptions& options, double threshold) {
  const bool isRounded = options.geometry == Geometry::rounded;
  RenderOptions otherwise = options;
  otherwise.geometry = isRounded ? Geometry::exact : Geometry::rounded;
  const Image other = renderWithReference(scene, settings, otherwise).image;
  const Image &rounded = isRounded ? reference : other, &exact = isRounded ? other : reference;
  return {sampling, compareImages(shader, rounded, threshold), compareImages(rounded, exact, threshold)};
}

EnvelopeRule measureEnvelope(const Image& shader, const Image& reference, const Scene& scene,
                             const RenderSettings& settings, const RenderOptions& options) {
  const Scene geometry = geometryOf(scene, options);
  return applyEnvelope(shader, reference, [&](std::span<const Pixel> pixels, int rays) {
    const double samples = double(pixels.size()) * settings.samples * settings.samples;
    ProgressLine progress("envelope", samples, options.quiet);
    return renderEnvelope(geometry, settings, pixels, rays, std::ref(progress));
  });
}

Compared compareScene(const CompareOptions& compare, RenderOptions options) {
  options.quiet |= compare.json;  // stdout belongs to the figures
  const Scene scene = loadAndPrint(options);
  const RenderSettings settings = settingsFor(scene, options);
  Compared result;
  SamplingError sampling;
  {
    UploadedScene uploaded(scene, settings, options);
    result.a = uploaded.render(settings);
    const auto more = [&](const RenderSettings& finer) { return uploaded.render(finer, "more samples"); };
    if (compare.decompose) sampling = measureSampling(result.a, settings, more, compare.threshold);
  }
  throwIfInvalid();
  result.b = renderWithReference(scene, settings, options).image;
  if (compare.decompose)
    result.decomposition = decompose(sampling, result.a, result.b, scene, settings, options, compare.threshold);
  if (compare.envelope) result.envelope = measureEnvelope(result.a, result.b, scene, settings, options);
  return result;
}

Compared compareFiles(const CompareOptions& compare) {
  if (!compare.errorImage.empty()) refuseOverwriting({compare.errorImage}, compare.files);
  return {.a = readExr(compare.files[0]), .b = readExr(compare.files[1]), .decomposition = {}, .envelope = {}};
}

}  // namespace

int runRender(const RenderOptions& options) {
  Stopwatch total, watch;
  if (options.scene.empty()) throw InputError("the name of the scene is empty");
  std::vector<std::string> outputs = options.outputs;
  if (outputs.empty()) outputs = {defaultOutput(options.scene)};
  for (const std::string& output : outputs) checkOutput(output, true);
  std::vector<std::string> files = outputs;
  if (!options.stats.empty()) {
    checkWritable(options.stats);
    files.push_back(options.stats);
  }
  refuseRepeated(files);

  Scene scene = loadAndPrint(options);
  refuseOverwriting(files, filesOf(findScene(options.scene), scene.sources));
  const RenderSettings settings = settingsFor(scene, options);
  const double loadSeconds = watch.lap();
  throwIfInterrupted();

  const Scene summary = withoutGeometry(scene);
  const size_t spheres = scene.spheres.size(), triangles = scene.triangles.size();
  Rendered rendered = options.backend == Backend::shader
                          ? renderWithShader(std::move(scene), settings, options, !options.stats.empty())
                          : renderWithReference(scene, settings, options);
  throwIfInvalid();
  Stats& stats = rendered.stats;
  const Provenance provenance =
      makeProvenance(summary, settings, "--backend " + stats.backend + " --geometry " + stats.geometry,
                     stats.device.name, stats.device.driver);
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
  const bool isScene = compare.files.size() == 1;
  if (isScene && lowerExtension(compare.files[0]) == ".exr")
    throw InputError("name a second picture to compare " + compare.files[0] + " with");
  const Compared compared = isScene ? compareScene(compare, render) : compareFiles(compare);
  const auto& [a, b, decomposition, envelope] = compared;

  const Comparison comparison = compareImages(a, b, compare.threshold);
  if (compare.json) {
    fmt::print("{}", comparisonJson(comparison, decomposition, envelope));
  } else if (!render.quiet) {
    printFigures(comparison, compare.threshold);
    if (decomposition) printDecomposition(*decomposition);
    if (envelope) printEnvelope(*envelope);
  }
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
