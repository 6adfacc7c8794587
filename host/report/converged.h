// A picture so well sampled that others are measured against it, and by how much it is itself still wrong.
#pragma once

#include <functional>
#include <string>

#include "picture/image.h"
#include "picture/settings.h"

namespace turner {

// The mean of two pictures that share nothing but the scene: other samplers, other seeds. Their difference tells the
// error of the mean without a third picture ("half-split"), and holds whatever one of the samplers has of its own.
struct Converged {
  Image mean;
  int samples = 0;         // n of the n x n samples in each pixel of either half
  double ownError = 0;     // rms error of the mean: half the rms difference of the halves
  double ownRelative = 0;  // the same of the relative error
  double leastError = 0;   // of the pictures measured against it, without ownError
  bool enough = true;      // whether ownError is at most a quarter of that
};

// Where a picture comes from: a renderer, or what was kept of it.
using RenderPicture = std::function<Image(const RenderSettings&)>;

// The seeds of the halves, jitter's and sobol's. Nobody else's.
inline constexpr uint32_t kConvergedSeeds[] = {UINT32_MAX, UINT32_MAX - 1};

// Renders halves with more and more samples, from `samples` on, until ownError is at most a quarter of the least error
// that is found against their mean, or 256 x 256 samples are reached. `leastErrorAgainst` gets the mean and its own
// error, and returns the least rmse of the pictures that are to be measured, without the mean's own error.
Converged converge(const RenderPicture& render, const RenderSettings& whole, int samples,
                   const std::function<double(const Image&, double)>& leastErrorAgainst);

// `rmse` against a picture with an error of its own: without that.
double withoutOwnError(double rmse, double ownError);

// Keeps pictures in the user's cache folder under a key of all that they depend on: `key` and the settings.
RenderPicture cached(const RenderPicture& render, const std::string& key);

}  // namespace turner
