// Between two points a curve is a power law: a straight line where both axes are logarithmic.
#include "report/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "image/provenance.h"

namespace turner::report {
namespace {

// Below this a slope is no way to reach anything.
constexpr double kLeastSlope = -0.1;
// Errors that differ by less than this share are one: the same picture by two devices must not be two on the front.
constexpr double kSame = 0.01;
// Errors that differ by less than this share are called alike: times are measured, and errors are of some draws.
constexpr double kAlike = 0.1;
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

// The points of two curves that have the same numbers of samples.
std::vector<std::pair<size_t, size_t>> sameSamples(const SweptScene& scene, const Curve& first, const Curve& second) {
  std::vector<std::pair<size_t, size_t>> pairs;
  for (const size_t i : first.points)
    for (const size_t j : second.points)
      if (scene.points[i].setting.samples == scene.points[j].setting.samples) pairs.emplace_back(i, j);
  return pairs;
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
    const SweepPoint& point = scene.points[i];
    if (point.rmse > (1 - kAlike) * rmse) continue;
    rmse = point.rmse;
    text += fmt::format("{}{} (RMSE {:.2g}) by {}", text.empty() ? "What time buys: " : "; ",
                        timeInWords(point.medianSeconds()), point.rmse, pointInWords(scene, point));
  }
  return text.empty() ? text : text + ".";
}

// The fastest setting that comes down to an error, and those that are as fast; where none does, the curve that would.
void addTargets(const SweptScene& scene, const std::vector<Curve>& curves, std::vector<std::string>& sentences) {
  for (size_t t = 0; t < std::size(kTargets); ++t) {
    const SweepPoint* best = nullptr;
    for (const SweepPoint& point : scene.points)
      if (point.rmse <= kTargets[t] && (!best || point.medianSeconds() < best->medianSeconds())) best = &point;
    if (best) {
      std::string others;
      for (const SweepPoint& point : scene.points)
        if (&point != best && point.rmse <= kTargets[t] && point.medianSeconds() * (1 - kAlike) < best->medianSeconds())
          others += (others.empty() ? "; within a tenth of that: " : "; ") + pointInWords(scene, point);
      sentences.push_back(fmt::format("The first setting below an RMSE of {:g} is {}: {}, RMSE {:.2g}{}.", kTargets[t],
                                      pointInWords(scene, *best), timeInWords(best->medianSeconds()), best->rmse,
                                      others));
      continue;
    }
    const Curve* first = nullptr;
    for (const Curve& curve : curves)
      if (curve.targets[t] && (!first || curve.targets[t]->seconds < first->targets[t]->seconds)) first = &curve;
    if (first)
      sentences.push_back(fmt::format(
          "No setting comes down to an RMSE of {:g}. Along its slope {} would, with about {:.3g} samples in "
          "each pixel, in {}.",
          kTargets[t], curveInWords(scene, *first), first->targets[t]->samples,
          timeInWords(first->targets[t]->seconds)));
  }
}

std::string gridInWords(const SweepPoint& point) {
  return fmt::format("{}x{}", point.setting.samples, point.setting.samples);
}

// Where each of two curves is ahead; `what` the leader then is.
std::string pairInWords(const SweptScene& scene, const Curve& first, const Curve& second, Figure figure,
                        const std::string& what) {
  const std::string a = curveInWords(scene, first), b = curveInWords(scene, second);
  std::string text;
  for (const Lead& lead : leadsOf(scene, first, second, figure)) {
    const std::string from = gridInWords(scene.points[lead.from]), to = gridInWords(scene.points[lead.to]);
    text += fmt::format("{}{} is {} {} {}", text.empty() ? "" : "; ", lead.ofFirst ? a : b, what, lead.ofFirst ? b : a,
                        from == to ? "at " + from : fmt::format("from {} to {}", from, to));
  }
  return text.empty() ? "" : text + ".";
}

// The times of two devices for the same pictures.
std::string ratiosInWords(const SweptScene& scene, const Curve& first, const Curve& second) {
  double least = HUGE_VAL, most = 0;
  for (const auto& [i, j] : sameSamples(scene, first, second)) {
    const double ratio = scene.points[i].medianSeconds() / scene.points[j].medianSeconds();
    least = std::min(least, ratio);
    most = std::max(most, ratio);
  }
  if (most == 0) return "";
  const std::string range =
      most - least < 0.05 * most ? fmt::format("{:.2g}", most) : fmt::format("{:.2g} to {:.2g}", least, most);
  return fmt::format("For the same pictures {} takes {} times as long as {}.", scene.renderers[first.renderer].name,
                     range, scene.renderers[second.renderer].name);
}

void addPairs(const SweptScene& scene, const std::vector<Curve>& curves, std::vector<std::string>& sentences) {
  const auto add = [&](const std::string& sentence) {
    if (!sentence.empty()) sentences.push_back(sentence);
  };
  for (const Curve& sobol : curves) {
    if (sobol.sampler != Sampler::sobol) continue;
    // Against the other samplers on this device, at the same samples, which take the same time; and against the devices
    // after this, which make the same picture.
    for (const Curve& other : curves) {
      if (other.renderer == sobol.renderer && other.sampler != Sampler::sobol)
        add(pairInWords(scene, sobol, other, Figure::rmse, "less wrong than"));
      if (other.renderer > sobol.renderer && other.sampler == Sampler::sobol) {
        add(ratiosInWords(scene, sobol, other));
        add(pairInWords(scene, sobol, other, Figure::seconds, "faster than"));
      }
    }
  }
}

// Which cut-offs are cheap: those that lose at most half as much as sampling does, the furthest of depth and of weight.
void addCutOffs(const SweptScene& scene, std::vector<std::string>& sentences) {
  for (const bool depths : {true, false}) {
    const SweepPoint* best = nullptr;
    bool any = false;
    for (const SweepPoint& point : scene.points) {
      const bool isDepth = point.setting.depth != scene.whole.depth, isWeight = point.setting.minWeight > 0;
      if (point.renderer != 0 || !(depths ? isDepth : isWeight)) continue;
      any = true;
      if (!(point.cutOff.rmse <= point.sampling.rmse / 2)) continue;
      const auto further = [&](const Setting& a, const Setting& b) {
        return depths ? a.depth < b.depth : a.minWeight > b.minWeight;
      };
      if (!best || further(point.setting, best->setting)) best = &point;
    }
    if (!any) continue;
    if (!best) {
      sentences.push_back(fmt::format("Every {} measured loses more than half as much as sampling does.",
                                      depths ? "smaller depth" : "least weight"));
      continue;
    }
    const Setting& setting = best->setting;
    sentences.push_back(fmt::format(
        "{} loses {:.2g} rms (at {}x{} samples sampling loses {:.2g}) and takes {:.2g} of the time on {}.",
        depths ? fmt::format("A depth of {}", setting.depth) : fmt::format("A least weight of {}", setting.minWeight),
        best->cutOff.rmse, setting.samples, setting.samples, best->sampling.rmse,
        best->medianSeconds() / uncutPoint(scene, *best).medianSeconds(), scene.renderers[0].name));
  }
}

// How far float32 is off, device by device.
void addArithmetic(const SweptScene& scene, std::vector<std::string>& sentences) {
  for (size_t renderer = 0; renderer + 1 < scene.renderers.size(); ++renderer) {
    double rmse = 0, bias = 0, bad = 0;
    uint64_t notFinite = 0;
    for (const SweepPoint& point : scene.points) {
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
                    "most {:.2g} % of a picture's pixels off by more than 0.001.",
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

std::string timeInWords(double seconds) {
  return seconds < 1 ? fmt::format("{:.3g} ms", 1e3 * seconds) : fmt::format("{:.3g} s", seconds);
}

std::string pointInWords(const SweptScene& scene, const SweepPoint& point) {
  return fmt::format("{}, {}", scene.renderers[point.renderer].name, settingInWords(scene, point.setting));
}

std::vector<std::string> findings(const SweptScene& scene) {
  const std::vector<Curve> curves = curvesOf(scene);
  std::vector<std::string> sentences = scene.failures;
  if (!scene.converged.enough)
    sentences.push_back(fmt::format(
        "CAUTION: the converged picture's own error, {:.2g}, is more than a quarter of the least error found ({:.2g}): "
        "errors of its size cannot be told apart.",
        scene.converged.ownError, scene.converged.leastError));
  if (const std::string front = frontInWords(scene); !front.empty()) sentences.push_back(front);
  addTargets(scene, curves, sentences);
  addPairs(scene, curves, sentences);
  addCutOffs(scene, sentences);
  addArithmetic(scene, sentences);
  return sentences;
}

std::string renderCommand(const SweptScene& scene, const SweepPoint& point, const std::string& shaders) {
  const RenderSettings& whole = scene.whole;
  const Setting& setting = point.setting;
  const Window& crop = whole.crop;
  // A name that begins with a dash would be an option.
  const std::string path = scene.path.starts_with('-') ? "./" + scene.path : scene.path;
  std::string command = fmt::format("turner render {} -o {}-{}.exr --width {} --height {}", shellWord(path), scene.stem,
                                    point.name, whole.width, whole.height);
  if (!(crop == Window{0, 0, whole.width, whole.height})) command += " --crop " + cropText(crop);
  command += fmt::format(" --samples {} --sampler {} --seed 0 --depth {}", setting.samples,
                         samplerName(setting.sampler), setting.depth);
  if (setting.minWeight > 0) command += fmt::format(" --min-weight {}", setting.minWeight);
  command += ' ' + scene.renderers[point.renderer].options;
  if (!shaders.empty() && point.renderer + 1 < scene.renderers.size()) command += " --shaders " + shellWord(shaders);
  return command;
}

}  // namespace turner::report
