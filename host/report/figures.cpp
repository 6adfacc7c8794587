// Between two points a curve is a power law: a straight line where both axes are logarithmic.
#include "report/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace turner {
namespace {

// Below this a slope is no way to reach anything.
constexpr double kLeastSlope = -0.1;
// Errors that differ by less than this share are called alike: times are measured, and errors are of some draws.
constexpr double kAlike = 0.1;
// So many times the samples that were measured a slope may be believed, if it is through more than two points.
constexpr double kFarthest = 16;
constexpr size_t kLeastPoints = 4;
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
  if (!curve.slope || *curve.slope > kLeastSlope || curve.points.size() < kLeastPoints) return std::nullopt;
  const Point& last = at(curve.points.size() - 1);
  const double factor = std::pow(target / last.rmse, 1 / *curve.slope);
  if (factor > kFarthest || samplesOf(last) * factor > kMostSamples) return std::nullopt;
  return Reach{samplesOf(last) * factor, last.medianSeconds() * factor, true};
}

std::string curveInWords(const SweptScene& scene, const Curve& curve) {
  return fmt::format("{} on {}", samplerName(curve.sampler), scene.renderers[curve.renderer].name);
}

std::string settingInWords(const SweptScene& scene, const Setting& setting) {
  std::string text = fmt::format("{} {}x{}", samplerName(setting.sampler), setting.samples, setting.samples);
  if (setting.depth != scene.whole.depth) text += fmt::format(", depth {}", setting.depth);
  if (setting.minWeight > 0) text += fmt::format(", least weight {}", setting.minWeight);
  return text;
}

// The steps of the front that are worth a word: each at least a tenth less wrong than the one before.
std::string frontInWords(const SweptScene& scene) {
  std::string text;
  double rmse = HUGE_VAL;
  for (const size_t i : paretoFront(scene)) {
    const Point& point = scene.points[i];
    if (point.rmse > (1 - kAlike) * rmse) continue;
    rmse = point.rmse;
    text += fmt::format("{}{} (RMSE {:.2g}) by {}", text.empty() ? "What time buys: " : "; ",
                        timeInWords(point.medianSeconds()), point.rmse, pointInWords(scene, point));
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
    sentences.push_back(fmt::format(
        "An RMSE of {:g} is reached first by {}: in {}, with {} {:.3g} samples in each pixel{}.", kTargets[t],
        curveInWords(scene, *best), timeInWords(found.seconds), found.samples > 1 ? "about" : "at most", found.samples,
        found.extrapolated ? " (extrapolated along its slope)" : ""));
  }
}

// Which of two curves leads in a figure, and from which point on; `better` is what the leader is, `same` what both do.
std::string pairInWords(const SweptScene& scene, const Curve& first, const Curve& second, Figure figure,
                        const std::string& better, const std::string& same) {
  const std::string a = curveInWords(scene, first), b = curveInWords(scene, second);
  std::string text;
  for (const Lead& lead : leadsOf(scene, first, second, figure)) {
    if (text.empty()) {
      text = fmt::format("{} is {} {}", lead.ofFirst ? a : b, better, lead.ofFirst ? b : a);
      continue;
    }
    const Point& from = scene.points[lead.point];
    text += fmt::format("; from {}x{} on ({}, RMSE {:.2g}) {} is", from.setting.samples, from.setting.samples,
                        timeInWords(from.medianSeconds()), from.rmse, lead.ofFirst ? a : b);
  }
  return (text.empty() ? fmt::format("{} and {} {}, within a tenth", a, b, same) : text) + ".";
}

// By how much faster, over the same settings.
std::string ratiosInWords(const SweptScene& scene, const Curve& first, const Curve& second) {
  double least = HUGE_VAL, most = 0;
  for (const size_t i : first.points)
    for (const size_t j : second.points) {
      const Point &a = scene.points[i], &b = scene.points[j];
      if (a.setting.samples != b.setting.samples) continue;
      least = std::min(least, a.medianSeconds() / b.medianSeconds());
      most = std::max(most, a.medianSeconds() / b.medianSeconds());
    }
  return fmt::format(" {} takes {:.2g} to {:.2g} of its time.", curveInWords(scene, first), least, most);
}

void addPairs(const SweptScene& scene, const std::vector<Curve>& curves, std::vector<std::string>& sentences) {
  for (const Curve& sobol : curves) {
    if (sobol.sampler != Sampler::sobol) continue;
    // Against the other samplers on this device, at the same samples, which take the same time; and against the devices
    // after this, which make the same picture.
    for (const Curve& other : curves) {
      if (other.renderer == sobol.renderer && other.sampler != Sampler::sobol)
        sentences.push_back(pairInWords(scene, sobol, other, Figure::rmse, "less wrong at the same samples than",
                                        "are as wrong at the same samples"));
      if (other.renderer > sobol.renderer && other.sampler == Sampler::sobol)
        sentences.push_back(pairInWords(scene, sobol, other, Figure::seconds, "faster with the same picture than",
                                        "take the same time for the same picture") +
                            ratiosInWords(scene, sobol, other));
    }
  }
}

// How far float32 is off, device by device.
void addArithmetic(const SweptScene& scene, std::vector<std::string>& sentences) {
  for (size_t renderer = 0; renderer + 1 < scene.renderers.size(); ++renderer) {
    double rmse = 0, bias = 0, bad = 0;
    uint64_t notFinite = 0;
    for (const Point& point : scene.points) {
      if (point.renderer != renderer) continue;
      const Comparison& arithmetic = point.arithmetic;
      rmse = std::max(rmse, arithmetic.rmse);
      bad = std::max(bad, arithmetic.badPixels);
      if (std::abs(arithmetic.meanSigned) > std::abs(bias)) bias = arithmetic.meanSigned;
      notFinite = std::max(notFinite, arithmetic.nan + arithmetic.inf);
    }
    const std::string& name = scene.renderers[renderer].name;
    sentences.push_back(
        fmt::format("Float32 arithmetic on {} costs an RMSE of at most {:.2g}, a bias of at most {:+.1g}, and puts at "
                    "most {:.2g} % "
                    "of a picture's pixels off by more than 0.001.",
                    name, rmse, bias, 100 * bad));
    if (notFinite > 0)
      sentences.push_back(fmt::format("A picture by {} has {} pixels with a NaN or an infinity.", name, notFinite));
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
    if (front.empty() || scene.points[i].rmse < scene.points[front.back()].rmse) front.push_back(i);
  return front;
}

std::vector<Lead> leadsOf(const SweptScene& scene, const Curve& first, const Curve& second, Figure figure) {
  std::vector<Lead> leads;
  for (const size_t i : first.points)
    for (const size_t j : second.points) {
      const Point &a = scene.points[i], &b = scene.points[j];
      if (a.setting.samples != b.setting.samples) continue;
      const double x = figure == Figure::rmse ? a.rmse : a.medianSeconds();
      const double y = figure == Figure::rmse ? b.rmse : b.medianSeconds();
      if (!(std::min(x, y) < (1 - kAlike) * std::max(x, y))) continue;
      const bool ofFirst = x < y;
      if (leads.empty() || leads.back().ofFirst != ofFirst) leads.push_back({ofFirst ? i : j, ofFirst});
    }
  return leads;
}

std::string timeInWords(double seconds) {
  return seconds < 1 ? fmt::format("{:.3g} ms", 1e3 * seconds) : fmt::format("{:.3g} s", seconds);
}

std::string pointInWords(const SweptScene& scene, const Point& point) {
  return fmt::format("{}, {}", scene.renderers[point.renderer].name, settingInWords(scene, point.setting));
}

std::vector<std::string> findings(const SweptScene& scene) {
  const std::vector<Curve> curves = curvesOf(scene);
  std::vector<std::string> sentences;
  if (!scene.converged.enough)
    sentences.push_back(fmt::format(
        "CAUTION: the converged picture's own error, {:.2g}, is more than a quarter of the least error found ({:.2g}): "
        "errors of its size cannot be told apart.",
        scene.converged.ownError, scene.converged.leastError));
  if (const std::string front = frontInWords(scene); !front.empty()) sentences.push_back(front);
  addTargets(scene, curves, sentences);
  addPairs(scene, curves, sentences);
  addArithmetic(scene, sentences);
  return sentences;
}

std::string renderCommand(const SweptScene& scene, const Point& point, const std::string& shaders) {
  const RenderSettings& whole = scene.whole;
  const Setting& setting = point.setting;
  const Window& crop = whole.crop;
  // A name that begins with a dash would be an option.
  const std::string path = scene.path.starts_with('-') ? "./" + scene.path : scene.path;
  std::string command = fmt::format("turner render {} -o {}-{}.exr --width {} --height {}", shellWord(path), scene.stem,
                                    point.name, whole.width, whole.height);
  if (!(crop == Window{0, 0, whole.width, whole.height}))
    command += fmt::format(" --crop {},{},{},{}", crop.x0, crop.y0, crop.x1, crop.y1);
  command += fmt::format(" --samples {} --sampler {} --seed 0 --depth {}", setting.samples,
                         samplerName(setting.sampler), setting.depth);
  if (setting.minWeight > 0) command += fmt::format(" --min-weight {}", setting.minWeight);
  command += ' ' + scene.renderers[point.renderer].options;
  if (!shaders.empty() && point.renderer + 1 < scene.renderers.size()) command += " --shaders " + shellWord(shaders);
  return command;
}

}  // namespace turner
