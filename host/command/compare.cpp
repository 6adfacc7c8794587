// `turner compare`: two files, or the shader's picture of a scene with the reference's.
#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <utility>

#include "base/errors.h"
#include "base/tell.h"
#include "base/text_file.h"
#include "command/backends.h"
#include "command/commands.h"
#include "command/comparison_text.h"
#include "command/data_folder.h"
#include "command/outputs.h"
#include "command/overwriting.h"
#include "command/progress_line.h"
#include "image/envelope.h"
#include "image/error_analysis.h"
#include "image/exr.h"
#include "reference/reference.h"
#include "scene/scene_load.h"

namespace turner {
namespace {

// The two pictures, and what else is known of their difference.
struct Compared {
  Image a, b;
  Provenance meaning;  // of the numbers in both
  std::optional<Decomposition> decomposition;
  std::optional<EnvelopeRule> envelope;
};

// The file of the error image, if one is wanted.
std::vector<std::string> errorImageOf(const CompareOptions& compare) {
  return compare.errorImage.empty() ? std::vector<std::string>() : filesNamed({compare.errorImage});
}

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
  const std::vector<std::string> outputs = errorImageOf(compare);
  refuseOverwriting(outputs, {findScene(options.scene)});
  refuseOverwriting(outputs, shaderFiles(options.shaders));
  const Scene scene = loadAndPrint(options);
  refuseOverwriting(outputs, filesOf(findScene(options.scene), scene.sources));
  const RenderSettings settings = settingsFor(scene, options);
  Compared result;
  SamplingError sampling;
  {
    UploadedScene uploaded(scene, settings, options);
    refuseOverwriting(outputs, uploaded.sourceFiles());
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

// The difference of numbers that do not mean the same is none of pictures.
void checkMeaning(const CompareOptions& compare, const ExrPicture& a, const ExrPicture& b) {
  const std::string nameA = nameOfInput(compare.files[0]), nameB = nameOfInput(compare.files[1]);
  if (!areSame(a.chromaticities, b.chromaticities))
    throw InputError(
        fmt::format("{} has the primaries of {}, {} those of {}: equal numbers are other colours; convert "
                    "one of them first",
                    nameA, nameOf(a.chromaticities), nameB, nameOf(b.chromaticities)));
  if (std::abs(a.pixelAspectRatio - b.pixelAspectRatio) > 1e-4f * std::abs(a.pixelAspectRatio))
    throw InputError(
        fmt::format("{} has pixels of the aspect ratio {}, {} of {}: they show other parts of a view; "
                    "resample one of them first",
                    nameA, a.pixelAspectRatio, nameB, b.pixelAspectRatio));
}

Compared compareFiles(const CompareOptions& compare, bool quiet) {
  refuseOverwriting(errorImageOf(compare), compare.files);
  refuseOverwriting(errorImageOf(compare), shaderFiles(""));
  refuseSharedPipes(compare.files);
  const auto read = [&](size_t i) {
    ExrPicture picture = readExrPicture(compare.files[i]);
    const std::string name = nameOfInput(compare.files[i]);
    if (quiet) return picture;
    if (picture.candidates > 1)
      tell("note: {} has R, G and B in {} parts; compared is the first of them, '{}'\n", name, picture.candidates,
           picture.part);
    if (picture.isCoarse) tell("note: {} is a coarse picture of turner watch, of every eighth pixel\n", name);
    return picture;
  };
  ExrPicture a = read(0), b = read(1);
  checkMeaning(compare, a, b);
  Compared result;
  result.a = std::move(a.image);
  result.b = std::move(b.image);
  result.meaning.chromaticities = a.chromaticities;
  result.meaning.pixelAspectRatio = a.pixelAspectRatio;
  return result;
}

}  // namespace

int runCompare(const CompareOptions& compare, const RenderOptions& render) {
  if (!compare.errorImage.empty()) checkOutput(compare.errorImage, false);
  const std::vector<std::string> outputs = errorImageOf(compare);
  leaveStdoutTo(outputs);
  if (compare.json && !isStdoutTold())
    throw InputError("--json and --error-image " + compare.errorImage +
                     " both want standard output; name a file for one of them");
  const bool isScene = compare.files.size() == 1;
  if (isScene && lowerExtension(compare.files[0]) == ".exr")
    throw InputError("name a second picture to compare " + compare.files[0] + " with");
  const Compared compared =
      isScene ? compareScene(compare, render) : compareFiles(compare, render.quiet || compare.json);
  const auto& [a, b, meaning, decomposition, envelope] = compared;

  const Comparison comparison = compareImages(a, b, compare.threshold);
  Deliveries deliveries;
  if (!compare.errorImage.empty())
    deliveries.attempt(outputs[0], [&] { writePicture(compare.errorImage, errorImage(a, b), compared.meaning); });
  deliveries.attempt("-", [&] {
    if (compare.json)
      printResult(comparisonJson(comparison, decomposition, envelope));
    else if (!render.quiet)
      printResult(figuresText(comparison, compare.threshold) +
                  (decomposition ? decompositionText(*decomposition) : "") + (envelope ? envelopeText(*envelope) : ""));
  });
  deliveries.throwIfAnyFailed();
  const std::vector<std::string> broken = brokenBounds(comparison, compare.bounds);
  for (const std::string& bound : broken) tellOnStderr("turner: error: {}\n", bound);
  return broken.empty() ? 0 : 1;
}

}  // namespace turner
