// Between two points a curve is a power law: a straight line where both axes are logarithmic.
#include "report/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace turner {
namespace {

// Below this a slope is no way to reach anything.
constexpr double kLeastSlope = -0.1;
// Where an error is reached after more samples than a renderer takes, nobody wants to know when.
constexpr double kMostSamples = double(kMaxSamples) * kMaxSamples;

double samplesOf(const Point& point) {
  return double(point.setting.samples) * point.setting.samples;
}

// Where between two points (x, y) the power law through them comes to y; x1 where they are of one height.
double crossingAt(double y, double x0, double y0, double x1, double y1) {
  if (y0 == y1) return x1;
  return x0 * std::pow(x1 / x0, std::log(y / y0) / std::log(y1 / y0));
}

std::optional<Reach> reach(const SweptScene& scene, const Curve& curve, double target) {
  const auto at = [&](size_t i) -> const Point& { return scene.points[curve.points[i]]; };
  // A picture with less samples than one does not exist: the first point may be better than what was asked for.
  if (at(0).rmse <= target) return Reach{samplesOf(at(0)), at(0).medianSeconds(), false};
  for (size_t i = 1; i < curve.points.size(); ++i) {
    const Point &a = at(i - 1), &b = at(i);
    if (b.rmse > target) continue;
    const auto along = [&](double xa, double xb) { return crossingAt(target, xa, a.rmse, xb, b.rmse); };
    if (b.rmse <= 0) return Reach{samplesOf(b), b.medianSeconds(), false};
    return Reach{along(samplesOf(a), samplesOf(b)), along(a.medianSeconds(), b.medianSeconds()), false};
  }
  if (!curve.slope || *curve.slope > kLeastSlope) return std::nullopt;
  const Point& last = at(curve.points.size() - 1);
  const double factor = std::pow(target / last.rmse, 1 / *curve.slope);
  if (samplesOf(last) * factor > kMostSamples) return std::nullopt;
  return Reach{samplesOf(last) * factor, last.medianSeconds() * factor, true};
}

// log rmse of a curve at a time within its measured range.
std::optional<double> logErrorAt(const SweptScene& scene, const Curve& curve, double logSeconds) {
  for (size_t i = 1; i < curve.points.size(); ++i) {
    const Point &a = scene.points[curve.points[i - 1]], &b = scene.points[curve.points[i]];
    const double x0 = std::log(a.medianSeconds()), x1 = std::log(b.medianSeconds());
    if (!(a.rmse > 0 && b.rmse > 0) || !(x0 < x1) || logSeconds < x0 || logSeconds > x1) continue;
    return std::log(a.rmse) + (logSeconds - x0) / (x1 - x0) * (std::log(b.rmse) - std::log(a.rmse));
  }
  return std::nullopt;
}

std::string curveInWords(const SweptScene& scene, const Curve& curve) {
  return fmt::format("{} on {}", samplerName(curve.sampler), scene.renderers[curve.renderer]->name);
}

// Which setting is on the front until when, those of one curve in one phrase.
std::string frontInWords(const SweptScene& scene) {
  const std::vector<size_t> front = paretoFront(scene);
  const auto group = [&](const Point& point) {
    std::string name =
        fmt::format("{} on {}", samplerName(point.setting.sampler), scene.renderers[point.renderer]->name);
    if (point.setting.depth != scene.whole.depth) name += fmt::format(" at depth {}", point.setting.depth);
    if (point.setting.minWeight > 0) name += fmt::format(" with --min-weight {}", point.setting.minWeight);
    return name;
  };
  std::string text;
  for (size_t i = 0; i < front.size();) {
    const Point& first = scene.points[front[i]];
    size_t end = i + 1;
    while (end < front.size() && group(scene.points[front[end]]) == group(first)) ++end;
    const Point& last = scene.points[front[end - 1]];
    text += text.empty() ? "The best that a given time buys is " : "; ";
    if (end - i == 1)
      text += fmt::format("{}, {}x{} ({}, RMSE {:.2g})", group(first), first.setting.samples, first.setting.samples,
                          timeInWords(first.medianSeconds()), first.rmse);
    else
      text += fmt::format("{}, {}x{} to {}x{} ({} to {}, RMSE {:.2g} to {:.2g})", group(first), first.setting.samples,
                          first.setting.samples, last.setting.samples, last.setting.samples,
                          timeInWords(first.medianSeconds()), timeInWords(last.medianSeconds()), first.rmse, last.rmse);
    i = end;
  }
  return text.empty() ? text : text + ".";
}

void addTargets(const SweptScene& scene, const std::vector<Curve>& curves, std::vector<std::string>& sentences) {
  for (size_t t = 0; t < std::size(kTargets); ++t) {
    const Curve* best = nullptr;
    for (const Curve& curve : curves)
      if (curve.targets[t] && (!best || curve.targets[t]->seconds < best->targets[t]->seconds)) best = &curve;
    if (!best) continue;
    const Reach& found = *best->targets[t];
    sentences.push_back(
        fmt::format("An RMSE of {:g} is reached first by {}: in {}, with about {:.2g} samples in each pixel{}.",
                    kTargets[t], curveInWords(scene, *best), timeInWords(found.seconds), found.samples,
                    found.extrapolated ? " (extrapolated along its slope)" : ""));
  }
}

void addCrossovers(const SweptScene& scene, const std::vector<Curve>& curves, std::vector<std::string>& sentences) {
  for (size_t i = 0; i < curves.size(); ++i)
    for (size_t j = i + 1; j < curves.size(); ++j) {
      const Curve &a = curves[i], &b = curves[j];
      // Of samplers on one device, and of devices with the best sampler.
      if (a.renderer != b.renderer && (a.sampler != Sampler::sobol || b.sampler != Sampler::sobol)) continue;
      for (const Crossover& crossover : crossovers(scene, a, b)) {
        const Curve &better = crossover.firstAfterwards ? a : b, &worse = crossover.firstAfterwards ? b : a;
        sentences.push_back(fmt::format("From {} on (RMSE {:.2g}), {} is less wrong than {}.",
                                        timeInWords(crossover.seconds), crossover.rmse, curveInWords(scene, better),
                                        curveInWords(scene, worse)));
      }
    }
}

}  // namespace

std::string shellWord(const std::string& text) {
  if (text.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-+=:,./@%") ==
          std::string::npos &&
      !text.empty())
    return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
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
        const Point& point = scene.points[i];
        if (point.renderer != renderer || point.setting.sampler != sampler) continue;
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
    if (scene.points[i].total.nan + scene.points[i].total.inf == 0) order.push_back(i);
  const auto key = [&](size_t i) { return std::pair(scene.points[i].medianSeconds(), scene.points[i].rmse); };
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return key(a) < key(b); });
  std::vector<size_t> front;
  for (const size_t i : order)
    if (front.empty() || scene.points[i].rmse < scene.points[front.back()].rmse) front.push_back(i);
  return front;
}

std::vector<Crossover> crossovers(const SweptScene& scene, const Curve& first, const Curve& second) {
  // Both are straight between the times at which either was measured: the difference changes its sign at most once
  // between two of these.
  std::vector<double> times;
  for (const Curve* curve : {&first, &second})
    for (const size_t i : curve->points) times.push_back(std::log(scene.points[i].medianSeconds()));
  std::sort(times.begin(), times.end());
  std::vector<Crossover> found;
  std::optional<std::pair<double, double>> before;  // time, first minus second
  for (const double time : times) {
    const std::optional<double> a = logErrorAt(scene, first, time), b = logErrorAt(scene, second, time);
    if (!a || !b) continue;
    const double difference = *a - *b;
    if (before && before->second * difference < 0) {
      const double share = before->second / (before->second - difference);
      const double at = before->first + share * (time - before->first);
      if (const std::optional<double> error = logErrorAt(scene, first, at))
        found.push_back({std::exp(at), std::exp(*error), difference < 0});
    }
    if (difference != 0) before = {time, difference};
  }
  return found;
}

std::string timeInWords(double seconds) {
  return seconds < 1 ? fmt::format("{:.3g} ms", 1e3 * seconds) : fmt::format("{:.3g} s", seconds);
}

std::string pointInWords(const SweptScene& scene, const Point& point) {
  const Setting& setting = point.setting;
  std::string text = fmt::format("{}, {} {}x{}", scene.renderers[point.renderer]->name, samplerName(setting.sampler),
                                 setting.samples, setting.samples);
  if (setting.depth != scene.whole.depth) text += fmt::format(", depth {}", setting.depth);
  if (setting.minWeight > 0) text += fmt::format(", least weight {}", setting.minWeight);
  return text;
}

std::vector<std::string> findings(const SweptScene& scene) {
  const std::vector<Curve> curves = curvesOf(scene);
  std::vector<std::string> sentences;
  if (const std::string front = frontInWords(scene); !front.empty()) sentences.push_back(front);
  addTargets(scene, curves, sentences);
  addCrossovers(scene, curves, sentences);
  for (const Point& point : scene.points) {
    if (point.arithmetic.nan + point.arithmetic.inf > 0)
      sentences.push_back(fmt::format("{} has {} pixels with a NaN or an infinity.", pointInWords(scene, point),
                                      point.total.nan + point.total.inf));
  }
  for (size_t renderer = 0; renderer + 1 < scene.renderers.size(); ++renderer) {
    double most = 0, bad = 0;
    for (const Point& point : scene.points) {
      if (point.renderer != renderer) continue;
      most = std::max(most, point.arithmetic.rmse);
      bad = std::max(bad, point.arithmetic.badPixels);
    }
    sentences.push_back(
        fmt::format("Float32 arithmetic on {} costs at most an RMSE of {:.2g}; at most {:.2g} % of pixels are off by "
                    "more than 0.001.",
                    scene.renderers[renderer]->name, most, 100 * bad));
  }
  return sentences;
}

std::string renderCommand(const SweptScene& scene, const Point& point, const std::string& shaders) {
  const RenderSettings& whole = scene.whole;
  const Setting& setting = point.setting;
  const Window& crop = whole.crop;
  std::string command = fmt::format("turner render {} -o {}.exr --width {} --height {}", shellWord(scene.path),
                                    point.name, whole.width, whole.height);
  if (!(crop == Window{0, 0, whole.width, whole.height}))
    command += fmt::format(" --crop {},{},{},{}", crop.x0, crop.y0, crop.x1, crop.y1);
  command += fmt::format(" --samples {} --sampler {} --seed 0 --depth {}", setting.samples,
                         samplerName(setting.sampler), setting.depth);
  if (setting.minWeight > 0) command += fmt::format(" --min-weight {}", setting.minWeight);
  command += ' ' + scene.renderers[point.renderer]->options;
  if (!shaders.empty() && point.renderer + 1 < scene.renderers.size()) command += " --shaders " + shellWord(shaders);
  return command;
}

}  // namespace turner
