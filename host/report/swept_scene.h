// What a sweep has measured of a scene.
#pragma once

#include <string>
#include <vector>

#include "image/compare.h"
#include "image/converged.h"
#include "report/renderers.h"
#include "report/sweep.h"

namespace turner::report {

// A setting on a renderer, measured. Errors are of the picture with seed 0 but for rmse.
struct SweepPoint {
  size_t renderer = 0;  // in SweptScene::renderers
  Setting setting;
  std::string name;  // "llvmpipe-sobol-4x4"

  std::vector<double> seconds;  // of tracing, one for each repeat
  std::vector<double> rmses;    // against the converged picture and without its error; repeat r has seed r
  double rmse = 0;              // their root mean square; NaN if a pixel of any is no number
  double relRmse = 0;           // relative, without the converged picture's error
  Comparison total;             // against the converged picture, whose error is in it

  // The picture minus the converged one is the sum of these, each at the same samples as far as both sides have any.
  Comparison sampling;      // the reference, not cut off, minus the converged picture; rmse without that one's error
  Comparison cutOff;        // the reference with the setting's depth and least weight minus the one without
  Comparison quantisation;  // the reference of the rounded scene minus the reference; none for the reference
  Comparison arithmetic;    // the picture minus the reference of the rounded scene; none for the reference

  double medianSeconds() const;
  double fastest() const;  // seconds
  double slowest() const;
  double efficiency() const;  // 1 / (MSE * s)
};

// How the converged picture was made.
struct ConvergedBy {
  size_t renderer = 0;
  double floatError = 0;  // rms difference of that renderer's and the reference's pictures at the same samples
};

struct SweptScene {
  Scene summary;     // without its geometry
  std::string path;  // as the render command takes it
  std::string stem;  // of the file's name
  PrimitiveCounts primitives;
  RenderSettings whole;
  std::vector<RendererInfo> renderers;  // the devices, then the reference
  std::vector<std::string> failures;    // of devices that could not render the scene, in words
  std::vector<SweepPoint> points;
  Converged converged;
  ConvergedBy convergedBy;
};

}  // namespace turner::report
