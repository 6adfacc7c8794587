// In: points and curves. Out: sentences.
#include "report/findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "image/provenance.h"
#include "report/figures.h"

namespace turner::report {
namespace {

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

std::string shellInput(const std::string& path) {
  return shellWord((path.starts_with('-') && path != "-" ? "./" : "") + path);
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
  std::string command = fmt::format("turner render {} -o {}-{}.exr --width {} --height {}", shellInput(scene.path),
                                    scene.stem, point.name, whole.width, whole.height);
  if (!(crop == Window{0, 0, whole.width, whole.height})) command += " --crop " + cropText(crop);
  command += fmt::format(" --samples {} --sampler {} --seed 0 --depth {}", setting.samples,
                         samplerName(setting.sampler), setting.depth);
  if (setting.minWeight > 0) command += fmt::format(" --min-weight {}", setting.minWeight);
  command += ' ' + scene.renderers[point.renderer].options;
  if (!shaders.empty() && point.renderer + 1 < scene.renderers.size()) command += " --shaders " + shellWord(shaders);
  return command;
}

}  // namespace turner::report
