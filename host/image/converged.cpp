// "Short runs instead of one long" (Celarek et al., Computer Graphics Forum 38(4), 2019) is for renderers whose error
// falls with the square root of the samples. Stratified samples gain more by being many in one run: at edges their
// error falls with the power 3/4.
#include "image/converged.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/cache_folder.h"
#include "base/errors.h"
#include "base/text_file.h"
#include "image/compare.h"
#include "image/exr.h"
#include "image/provenance.h"

namespace turner {
namespace {

// rms error over n, for n x n samples: the power 3/4 of the number.
constexpr double kPower = 1.5;

constexpr int kFirst = 2, kMost = 6;

constexpr size_t kMostCached = 64;
constexpr const char* kSuffix = "-converged.exr";

Image meanOf(const Image& a, const Image& b) {
  Image mean = a;
  for (size_t i = 0; i < mean.rgb.size(); ++i) mean.rgb[i] = float((double(a.rgb[i]) + double(b.rgb[i])) / 2);
  return mean;
}

// The next number whose prime factors are 2 and 3, with which sobol is at its best, up to the most that there are.
int smooth(int n) {
  for (; n < kMaxSamples; ++n) {
    int rest = n;
    while (rest % 2 == 0) rest /= 2;
    while (rest % 3 == 0) rest /= 3;
    if (rest == 1) return n;
  }
  return kMaxSamples;
}

double samplesOfBoth(int n) {
  return 2.0 * n * n;
}

}  // namespace

double withoutOwnError(double rmse, double ownError) {
  if (std::isnan(rmse)) return rmse;
  return std::sqrt(std::max(0.0, rmse * rmse - ownError * ownError));
}

double firstConvergedSamples(int n) {
  return samplesOfBoth(smooth(kFirst * n));
}

Converged converge(const RenderPicture& render, const RenderSettings& whole, int n,
                   const std::function<double(const Image&, double)>& leastErrorAgainst, const Attempt& attempt) {
  Converged result;
  const int most = smooth(kMost * n);
  for (result.samples = smooth(kFirst * n);;) {
    if (attempt) attempt(samplesOfBoth(result.samples));
    RenderSettings settings = whole;
    settings.minWeight = 0;
    settings.samples = result.samples;
    settings.sampler = Sampler::jitter;
    settings.seed = kConvergedSeeds[0];
    const Image jittered = render(settings);
    settings.sampler = Sampler::sobol;
    settings.seed = kConvergedSeeds[1];
    result.sobol = render(settings);

    result.mean = meanOf(jittered, result.sobol);
    const Comparison halves = compareImages(jittered, result.sobol, 0);
    result.ownError = halves.rmse / 2;
    result.ownRelative = halves.relRmse / 2;
    result.leastError = leastErrorAgainst(result.mean, result.ownError);
    const double wanted = kConverged * result.leastError;
    result.enough = std::isfinite(wanted) && result.ownError <= wanted;
    // More samples do not mend what is no number.
    if (halves.nan + halves.inf > 0) {
      result.enough = false;
      return result;
    }
    if (result.enough || result.samples >= most) return result;
    // As many more as the error asks for, and a little more than that.
    const double factor = wanted > 0 ? std::pow(result.ownError / wanted, 1 / kPower) * 1.05 : 2.0;
    result.samples = std::min(smooth(int(std::ceil(result.samples * std::clamp(factor, 1.2, double(kMost))))), most);
  }
}

RenderPicture cached(const RenderPicture& render, const std::string& key) {
  const std::string root = cacheFolder();
  if (root.empty()) return render;
  return [=](const RenderSettings& settings) {
    const Window& crop = settings.crop;
    const std::string path = root + '/' + sha256Hex(key + '\n' + optionsText(settings, cropText(crop))) + kSuffix;
    std::error_code ignored;
    if (std::filesystem::exists(path, ignored)) {
      try {
        Image image = readExr(path);
        std::filesystem::last_write_time(path, std::filesystem::file_time_type::clock::now(), ignored);
        if (image.width == settings.width && image.height == settings.height && image.window == crop) return image;
      } catch (const InputError&) {
        // A damaged file costs the time to render again, and is replaced below.
      }
    }
    Image image = render(settings);
    keepInCache(path, kSuffix, encodeExr(image, {}), kMostCached);
    return image;
  };
}

}  // namespace turner
