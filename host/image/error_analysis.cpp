// The converged picture is estimated twice, from independent halves of its rounds: their difference tells its error
// without a third picture. "Short runs instead of one long": Celarek et al., "Quantifying the error of light transport
// algorithms", Computer Graphics Forum 38(4), 2019.
#include "image/error_analysis.h"

#include <algorithm>
#include <array>
#include <vector>

#include "base/stopwatch.h"
#include "scene/scene.h"

namespace turner {
namespace {

// A round has so many times the picture's samples along each side of the pixel's grid, where the sampler bears it.
constexpr int kFinerGrid = 4;

// The mean of pictures.
class MeanPicture {
 public:
  explicit MeanPicture(const Image& like) : mean_(like), sums_(like.rgb.size()) {}

  void add(const Image& image) {
    ++count_;
    for (size_t i = 0; i < sums_.size(); ++i) {
      sums_[i] += double(image.rgb[i]);
      mean_.rgb[i] = float(sums_[i] / count_);
    }
  }
  const Image& mean() const { return mean_; }

 private:
  Image mean_;
  std::vector<double> sums_;
  int count_ = 0;
};

}  // namespace

SamplingError measureSampling(const Image& picture, const RenderSettings& settings, const RenderPicture& render,
                              double threshold, const ConvergenceBounds& bounds) {
  const Stopwatch watch;
  RenderSettings finer = settings;
  finer.sampler = Sampler::jitter;
  finer.samples = std::min(kFinerGrid * settings.samples, kMaxSamples);

  MeanPicture all(picture);
  std::array<MeanPicture, 2> halves{MeanPicture(picture), MeanPicture(picture)};
  SamplingError error;
  for (int rounds = 2;; rounds += 2) {
    for (MeanPicture& half : halves) {
      ++finer.seed;
      const Image image = render(finer);
      half.add(image);
      all.add(image);
      error.samples += uint64_t(finer.samples) * uint64_t(finer.samples);
    }
    // The halves' difference has four times the variance of their mean.
    error.ownError = compareImages(halves[0].mean(), halves[1].mean(), threshold).rmse / 2;
    error.figures = compareImages(picture, all.mean(), threshold);
    double& rmse = error.figures.rmse;
    rmse = withoutOwnError(rmse, error.ownError);
    error.converged = error.ownError <= kConverged * rmse;
    if (error.converged || rounds + 2 > bounds.rounds || watch.seconds() > bounds.seconds) return error;
  }
}

}  // namespace turner
