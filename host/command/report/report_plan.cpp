// Scenes -> sizes, samplers, depths and weights; devices -> renderers.
#include "command/report/report_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <optional>

#include "base/errors.h"
#include "base/interrupt.h"
#include "base/text_file.h"
#include "command/data_folder.h"
#include "command/overwriting.h"
#include "scene/scene_load.h"

namespace turner {
using namespace report;
namespace {

namespace fs = std::filesystem;

// Of --quick.
constexpr double kQuickPixels = 40000;
constexpr int kQuickSamples = 8, kQuickRepeats = 3;
constexpr int kFullSamples = 16, kFullRepeats = 10;

// A side that goes with the other, at the scene's shape.
int matching(int side, int sceneSide, int sceneOther) {
  return std::clamp(int(std::lround(double(side) * sceneOther / sceneSide)), 1, kMaxSize);
}

// What the sweep leaves the same.
RenderSettings wholeOf(const Scene& scene, const ReportOptions& options) {
  RenderOptions render;
  render.depth = options.depth;
  render.crop = options.crop;
  render.width = options.width    ? options.width
                 : options.height ? std::optional(matching(*options.height, scene.height, scene.width))
                                  : std::nullopt;
  render.height = options.height  ? options.height
                  : options.width ? std::optional(matching(*options.width, scene.width, scene.height))
                                  : std::nullopt;
  const double pixels = double(scene.width) * scene.height;
  if (!render.width && render.crop.empty() && !options.full && pixels > kQuickPixels) {
    const double scale = std::sqrt(kQuickPixels / pixels);
    render.width = std::max(1, int(scale * scene.width));
    render.height = std::max(1, int(scale * scene.height));
  }
  return settingsFor(scene, render);
}

std::vector<DeviceInfo> devicesFor(const ReportOptions& options) {
  const std::vector<DeviceInfo> all = listDevices();
  if (!options.device.empty()) return {chooseDevice(all, options.device)};
  std::vector<DeviceInfo> usable;
  std::copy_if(all.begin(), all.end(), std::back_inserter(usable), [](const DeviceInfo& d) { return d.usable; });
  if (usable.empty()) throw RunError("no Vulkan device has Vulkan 1.2 and a compute queue; turner devices lists them");
  return usable;
}

// Devices of one name are numbered.
void nameApart(std::vector<std::unique_ptr<Renderer>>& renderers) {
  std::map<std::string, int> count;
  for (const auto& renderer : renderers)
    if (const int number = ++count[renderer->info.name]; number > 1) renderer->info.name += fmt::format("-{}", number);
}

// Of the program itself: pictures of one build are not another's.
std::string programHash() {
  static const std::string hash = sha256Hex(readTextFile("/proc/self/exe"));
  return hash;
}

// A scene's name as a part of files' names and a word of the journal.
std::string wordOf(const std::string& name) {
  constexpr size_t kLongest = 40;
  std::string word = name.substr(0, kLongest);
  for (char& c : word)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '_' && c != '.') c = '_';
  return word;
}

}  // namespace

std::vector<std::unique_ptr<Renderer>> openRenderers(const Scene& scene, const std::vector<DeviceInfo>& devices,
                                                     const std::string& shaders) {
  std::vector<std::unique_ptr<Renderer>> renderers;
  for (const DeviceInfo& device : devices) renderers.push_back(shaderRenderer(scene, device, shaders));
  nameApart(renderers);
  renderers.push_back(referenceRenderer(scene, ReferenceOf::scene));
  for (const auto& renderer : renderers) renderer->info.content += programHash();
  return renderers;
}

std::string validUtf8(const std::string& text) {
  std::string valid;
  for (size_t i = 0; i < text.size();) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const size_t length = byte < 0x80                   ? 1
                          : byte >= 0xc2 && byte < 0xe0 ? 2
                          : byte >= 0xe0 && byte < 0xf0 ? 3
                          : byte >= 0xf0 && byte < 0xf5 ? 4
                                                        : 0;
    bool fits = length > 0 && i + length <= text.size();
    for (size_t k = 1; fits && k < length; ++k) fits = (static_cast<unsigned char>(text[i + k]) & 0xc0) == 0x80;
    // Neither overlong forms, nor surrogates, nor beyond U+10FFFF.
    const unsigned second = fits && length > 2 ? static_cast<unsigned char>(text[i + 1]) : 0x9fu;
    fits = fits && !(byte == 0xe0 && second < 0xa0) && !(byte == 0xed && second > 0x9f) &&
           !(byte == 0xf0 && second < 0x90) && !(byte == 0xf4 && second > 0x8f);
    valid += fits ? text.substr(i, length) : "?";
    i += fits ? length : 1;
  }
  return valid;
}

ReportPlan planFor(const ReportOptions& options) {
  ReportPlan plan;
  refuseSharedPipes(options.scenes);
  for (const std::string& name : options.scenes) {
    if (name.empty()) throw InputError("the name of a scene is empty");
    plan.scenes.push_back(loadScene(findScene(name)));
  }
  const CutOffs cutOffs = options.noCutOffs ? CutOffs::leftOut : CutOffs::measured;
  const int maxSamples = options.maxSamples.value_or(options.full ? kFullSamples : kQuickSamples);
  plan.repeats = options.repeats.value_or(options.full ? kFullRepeats : kQuickRepeats);
  plan.devices = devicesFor(options);
  plan.shaders = shaderFolder(options.shaders);
  for (size_t i = 0; i < plan.scenes.size(); ++i) {
    const Scene& scene = plan.scenes[i];
    const RenderSettings whole = wholeOf(scene, options);
    const std::string stem = wordOf(scene.name);
    plan.sweeps.push_back({scene, validUtf8(options.scenes[i]), stem, fmt::format("{}-{}-", i + 1, stem), whole,
                           planSweep(scene, whole, maxSamples, cutOffs), plan.repeats});
  }
  // Who renders does not depend on what.
  for (const auto& renderer : openRenderers({}, plan.devices, plan.shaders)) plan.renderers.push_back(renderer->info);
  throwIfInterrupted();
  return plan;
}

std::string fingerprint(const ReportPlan& plan) {
  std::string text;
  for (size_t i = 0; i < plan.sweeps.size(); ++i) {
    const SceneToSweep& sweep = plan.sweeps[i];
    const RenderSettings& whole = sweep.whole;
    text += fmt::format("{} {} {} {} {} {} {} {} {}\n", sweep.tag, whole.width, whole.height, whole.crop.x0,
                        whole.crop.y0, whole.crop.x1, whole.crop.y1, whole.depth, sweep.repeats);
    for (const Setting& setting : sweep.settings) text += settingName(setting, whole) + ' ';
    for (const SourceFile& source : sweep.scene.sources) text += source.sha256 + ' ';
  }
  for (const RendererInfo& renderer : plan.renderers) text += renderer.name + ' ' + renderer.content + ' ';
  return sha256Hex(text);
}

}  // namespace turner
