// A picture so well sampled that others are measured against it, and by how much it is itself still wrong.
#pragma once

#include <functional>
#include <string>

#include "image/image.h"
#include "image/settings.h"

namespace turner {

// The mean of two pictures that share nothing but the scene: other samplers, other seeds. Their difference tells the
// error of the mean without a third picture ("half-split"), and holds whatever one of the samplers has of its own.
struct Converged {
  Image mean;
  Image sobol;             // one of the halves
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

// Told of the samples in each pixel that an attempt renders, both halves together, before it begins.
using Attempt = std::function<void(double samples)>;

// Renders halves with more and more samples, from 2n x 2n on, until ownError is at most a quarter of the least error
// that is found against their mean, or 6n x 6n samples are reached, where n is what the pictures have that are to be
// measured: more would take longer than all of these. `leastErrorAgainst` gets the mean and its own error, and returns
// the least rmse of those pictures, without the mean's own error.
Converged converge(const RenderPicture& render, const RenderSettings& whole, int n,
                   const std::function<double(const Image&, double)>& leastErrorAgainst, const Attempt& attempt = {});

// Of the first attempt.
double firstConvergedSamples(int n);

// A picture is converged for others if its own error is at most this share of theirs: were it not subtracted, it would
// make that 3 % too large.
inline constexpr double kConverged = 0.25;

// `rmse` against a picture with an error of its own: without that.
double withoutOwnError(double rmse, double ownError);

// Keeps pictures in the user's cache folder under a key of all that they depend on: `key` and the settings.
RenderPicture cached(const RenderPicture& render, const std::string& key);

}  // namespace turner
