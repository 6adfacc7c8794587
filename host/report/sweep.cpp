// Numbers of samples, depths and weights that are tried, each some steps apart.
#include "report/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace turner::report {
namespace {

constexpr int kSamples[] = {1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256};
constexpr int kDepths[] = {1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 24, 32, 48};
constexpr double kMinWeights[] = {0.3, 0.1, 0.03, 0.01};
// Cut-offs are compared at the same samples, so that few are enough; with fewer they would hardly be on the Pareto
// front.
constexpr int kSamplesOfCutOffs = 4;

}  // namespace

std::vector<Setting> planSweep(const Scene& scene, const RenderSettings& whole, int maxSamples, CutOffs cutOffs) {
  std::vector<Setting> settings;
  std::vector<int> numbers;
  std::copy_if(std::begin(kSamples), std::end(kSamples), std::back_inserter(numbers),
               [&](int samples) { return samples < maxSamples; });
  numbers.push_back(maxSamples);
  for (const int samples : numbers)
    for (const Sampler sampler : {Sampler::grid, Sampler::jitter, Sampler::sobol})
      settings.push_back({sampler, samples, whole.depth, 0});
  const bool spawns = std::any_of(scene.materials.begin(), scene.materials.end(),
                                  [](const Material& m) { return m.reflect > 0 || m.transmit > 0; });
  if (cutOffs == CutOffs::measured && spawns && whole.depth > 1) {
    const int samples = std::min(kSamplesOfCutOffs, maxSamples);
    for (const int depth : kDepths)
      if (depth < whole.depth) settings.push_back({Sampler::sobol, samples, depth, 0});
    for (const double weight : kMinWeights) settings.push_back({Sampler::sobol, samples, whole.depth, weight});
  }
  std::stable_sort(settings.begin(), settings.end(),
                   [](const Setting& a, const Setting& b) { return a.samples < b.samples; });
  return settings;
}

Setting uncut(const Setting& setting, const RenderSettings& whole) {
  return {setting.sampler, setting.samples, whole.depth, 0};
}

RenderSettings settingsWith(const RenderSettings& whole, const Setting& setting, uint32_t seed) {
  RenderSettings settings = whole;
  settings.sampler = setting.sampler;
  settings.samples = setting.samples;
  settings.depth = setting.depth;
  settings.minWeight = setting.minWeight;
  settings.seed = seed;
  return settings;
}

std::string settingName(const Setting& setting, const RenderSettings& whole) {
  std::string name = fmt::format("{}-{}x{}", samplerName(setting.sampler), setting.samples, setting.samples);
  if (setting.depth != whole.depth) name += fmt::format("-depth{}", setting.depth);
  if (setting.minWeight > 0) name += fmt::format("-weight{}", setting.minWeight);
  return name;
}

}  // namespace turner::report
