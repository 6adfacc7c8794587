// Three errors of the shader's picture, told apart: too few samples, float32 arithmetic, and the rounding of the scene.
#pragma once

#include <cstdint>

#include "image/compare.h"
#include "image/converged.h"
#include "image/settings.h"

namespace turner {

// The picture against a converged one, which is the mean of many.
struct SamplingError {
  Comparison figures;     // of the picture minus the converged one; the rmse without the converged picture's variance
  double ownError = 0;    // rms error of the converged picture
  bool converged = true;  // whether that is at most a quarter of the rmse
  uint64_t samples = 0;   // of the converged picture, in each pixel
};

struct Decomposition {
  SamplingError sampling;
  Comparison arithmetic;    // the picture minus the reference of the rounded scene
  Comparison quantisation;  // the reference of the rounded scene minus that of the scene itself
};

// When to give up: no two rounds are begun beyond these.
struct ConvergenceBounds {
  int rounds = 64;
  double seconds = 120;
};

// `picture` is the one with these settings, `render` is who made it. Renders rounds of jittered samples, of seeds other
// than the picture's, until their mean is converged.
SamplingError measureSampling(const Image& picture, const RenderSettings& settings, const RenderPicture& render,
                              double threshold, const ConvergenceBounds& bounds = {});

}  // namespace turner
