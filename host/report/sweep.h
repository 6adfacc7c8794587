// What a report measures: which samplers, numbers of samples, depths and least weights, on every device alike.
#pragma once

#include <string>
#include <vector>

#include "image/settings.h"
#include "scene/scene.h"

namespace turner::report {

// One combination of render options.
struct Setting {
  Sampler sampler = Sampler::grid;
  int samples = 1;  // n of n x n
  int depth = 5;
  double minWeight = 0;
  bool operator==(const Setting&) const = default;
};

enum class CutOffs { measured, leftOut };

// The options that `whole` leaves open: every sampler with numbers of samples up to maxSamples, this one too, and,
// where a material of the scene reflects or transmits and cut-offs are measured, smaller depths and larger least
// weights at one number of samples. In the order of the number of samples, the cheapest first; each setting once.
std::vector<Setting> planSweep(const Scene& scene, const RenderSettings& whole, int maxSamples, CutOffs cutOffs);

// The setting that a cut-off is compared with: the same samples, at the whole depth and without a least weight.
Setting uncut(const Setting& setting, const RenderSettings& whole);

// The settings of a picture: `whole` with these options and this seed.
RenderSettings settingsWith(const RenderSettings& whole, const Setting& setting, uint32_t seed);

// "sobol-4x4", "sobol-4x4-depth3", "sobol-4x4-weight0.1": names the setting within a report, and its files. `whole`
// tells what goes without saying.
std::string settingName(const Setting& setting, const RenderSettings& whole);

}  // namespace turner::report
