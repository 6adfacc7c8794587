// Between two points a curve is a power law: a straight line where both axes are logarithmic.
#include "report/figures.h"

#include <algorithm>
#include <cmath>

namespace turner::report {
namespace {

// Below this a slope is no way to reach anything.
constexpr double kLeastSlope = -0.1;
// Errors that differ by less than this share are one: the same picture by two devices must not be two on the front.
constexpr double kSame = 0.01;
// So many times the samples that were measured a slope may be believed, if it is through more than two points.
constexpr double kFarthest = 16;
constexpr size_t kLeastPoints = 4;
// Where an error is reached after more samples than a renderer takes, nobody wants to know when.
constexpr double kMostSamples = double(kMaxSamples) * kMaxSamples;

double samplesOf(const SweepPoint& point) {
  return double(point.setting.samples) * point.setting.samples;
}

// Where between two points (x, y) the power law through them comes to y; x1 where they are of one height.
double crossingAt(double y, double x0, double y0, double x1, double y1) {
  if (y0 == y1) return x1;
  return x0 * std::pow(x1 / x0, std::log(y / y0) / std::log(y1 / y0));
}

std::optional<Reach> reach(const SweptScene& scene, const Curve& curve, double target) {
  const auto at = [&](size_t i) -> const SweepPoint& { return scene.points[curve.points[i]]; };
  // A picture with less samples than one does not exist: the first point may be better than what was asked for.
  if (at(0).rmse <= target) return Reach{samplesOf(at(0)), at(0).medianSeconds(), false};
  for (size_t i = 1; i < curve.points.size(); ++i) {
    const SweepPoint &a = at(i - 1), &b = at(i);
    if (b.rmse > target) continue;
    const auto along = [&](double xa, double xb) { return crossingAt(target, xa, a.rmse, xb, b.rmse); };
    if (b.rmse <= 0) return Reach{samplesOf(b), b.medianSeconds(), false};
    return Reach{along(samplesOf(a), samplesOf(b)), along(a.medianSeconds(), b.medianSeconds()), false};
  }
  if (!curve.slope || *curve.slope > kLeastSlope || curve.points.size() < kLeastPoints) return std::nullopt;
  const SweepPoint& last = at(curve.points.size() - 1);
  const double factor = std::pow(target / last.rmse, 1 / *curve.slope);
  if (factor > kFarthest || samplesOf(last) * factor > kMostSamples) return std::nullopt;
  return Reach{samplesOf(last) * factor, last.medianSeconds() * factor, true};
}

}  // namespace

std::vector<std::pair<size_t, size_t>> sameSamples(const SweptScene& scene, const Curve& first, const Curve& second) {
  std::vector<std::pair<size_t, size_t>> pairs;
  for (const size_t i : first.points)
    for (const size_t j : second.points)
      if (scene.points[i].setting.samples == scene.points[j].setting.samples) pairs.emplace_back(i, j);
  return pairs;
}

std::optional<double> logSlope(const std::vector<double>& x, const std::vector<double>& y) {
  double count = 0, meanX = 0, meanY = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    if (!(x[i] > 0 && y[i] > 0)) continue;
    ++count;
    meanX += std::log(x[i]);
    meanY += std::log(y[i]);
  }
  meanX /= count;
  meanY /= count;
  double xx = 0, xy = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    if (!(x[i] > 0 && y[i] > 0)) continue;
    xx += (std::log(x[i]) - meanX) * (std::log(x[i]) - meanX);
    xy += (std::log(x[i]) - meanX) * (std::log(y[i]) - meanY);
  }
  if (count < 2 || !(xx > 0)) return std::nullopt;
  return xy / xx;
}

std::vector<Curve> curvesOf(const SweptScene& scene) {
  std::vector<Curve> curves;
  for (size_t renderer = 0; renderer < scene.renderers.size(); ++renderer)
    for (const Sampler sampler : {Sampler::grid, Sampler::jitter, Sampler::sobol}) {
      Curve curve{renderer, sampler, {}, {}, {}};
      std::vector<double> samples, errors;
      for (size_t i = 0; i < scene.points.size(); ++i) {
        const SweepPoint& point = scene.points[i];
        if (point.renderer != renderer || point.setting.sampler != sampler) continue;
        if (!std::isfinite(point.rmse)) continue;
        if (point.setting != uncut(point.setting, scene.whole)) continue;
        curve.points.push_back(i);
        if (point.setting.samples < 2) continue;
        samples.push_back(samplesOf(point));
        errors.push_back(point.rmse);
      }
      if (curve.points.empty()) continue;
      curve.slope = logSlope(samples, errors);
      for (const double target : kTargets) curve.targets.push_back(reach(scene, curve, target));
      curves.push_back(std::move(curve));
    }
  return curves;
}

std::vector<size_t> paretoFront(const SweptScene& scene) {
  std::vector<size_t> order;
  for (size_t i = 0; i < scene.points.size(); ++i)
    if (std::isfinite(scene.points[i].rmse)) order.push_back(i);
  const auto key = [&](size_t i) { return std::pair(scene.points[i].medianSeconds(), scene.points[i].rmse); };
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return key(a) < key(b); });
  std::vector<size_t> front;
  for (const size_t i : order)
    if (front.empty() || scene.points[i].rmse < (1 - kSame) * scene.points[front.back()].rmse) front.push_back(i);
  return front;
}

std::vector<bool> isOnFront(const SweptScene& scene) {
  std::vector<bool> found(scene.points.size());
  for (const size_t i : paretoFront(scene)) found[i] = true;
  return found;
}

const SweepPoint& uncutPoint(const SweptScene& scene, const SweepPoint& point) {
  const Setting whole = uncut(point.setting, scene.whole);
  return *std::find_if(scene.points.begin(), scene.points.end(), [&](const SweepPoint& other) {
    return other.renderer == point.renderer && other.setting == whole;
  });
}

std::vector<Lead> leadsOf(const SweptScene& scene, const Curve& first, const Curve& second, Figure figure) {
  std::vector<Lead> leads;
  bool goesOn = false;  // whether the last lead reached the point before
  for (const auto& [i, j] : sameSamples(scene, first, second)) {
    const SweepPoint &a = scene.points[i], &b = scene.points[j];
    const double x = figure == Figure::rmse ? a.rmse : a.medianSeconds();
    const double y = figure == Figure::rmse ? b.rmse : b.medianSeconds();
    const bool ofFirst = x < y;
    // Times must differ by more than they scatter, too.
    const auto [fast, slow] = ofFirst ? std::pair(&a, &b) : std::pair(&b, &a);
    const bool apart = figure == Figure::rmse || fast->slowest() < slow->fastest();
    if (!apart || !(std::min(x, y) < (1 - kAlike) * std::max(x, y))) {
      goesOn = false;
      continue;
    }
    if (!goesOn || leads.back().ofFirst != ofFirst) leads.push_back({ofFirst ? i : j, 0, ofFirst});
    leads.back().to = ofFirst ? i : j;
    goesOn = true;
  }
  return leads;
}

}  // namespace turner::report
