// `turner compare`: two files, or the shader's picture of a scene with the reference's.
#include <functional>
#include <optional>
#include <span>
#include <utility>

#include "base/errors.h"
#include "base/output_file.h"
#include "base/tell.h"
#include "base/text_file.h"
#include "command/backends.h"
#include "command/commands.h"
#include "command/comparison_text.h"
#include "command/outputs.h"
#include "command/progress_line.h"
#include "image/envelope.h"
#include "image/error_analysis.h"
#include "image/exr.h"
#include "reference/reference.h"

namespace turner {
namespace {

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

int runCompare(const CompareOptions& compare, const RenderOptions& render) {
  if (!compare.errorImage.empty()) checkOutput(compare.errorImage, false);
  const bool isScene = compare.files.size() == 1;
  if (isScene && lowerExtension(compare.files[0]) == ".exr")
    throw InputError("name a second picture to compare " + compare.files[0] + " with");
  const Compared compared = isScene ? compareScene(compare, render) : compareFiles(compare);
  const auto& [a, b, decomposition, envelope] = compared;

  const Comparison comparison = compareImages(a, b, compare.threshold);
  Deliveries deliveries;
  if (!compare.errorImage.empty())
    deliveries.attempt([&] { writeWholeFile(compare.errorImage, encodeExr(errorImage(a, b), {})); });
  deliveries.attempt([&] {
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
