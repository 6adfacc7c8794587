// turner report: scenes -> what to measure -> measured, as far as the journal does not have it -> page and tables.
#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <thread>

#include "base/errors.h"
#include "base/output_file.h"
#include "base/text_file.h"
#include "command/commands.h"
#include "command/data_folder.h"
#include "command/interrupt.h"
#include "command/progress_line.h"
#include "image/exr.h"
#include "kernel/buffer_access.h"
#include "kernel/compile.h"
#include "report/measure.h"
#include "report/page.h"
#include "report/tables.h"
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

std::vector<std::unique_ptr<Renderer>> openRenderers(const Scene& scene, const std::vector<DeviceInfo>& devices,
                                                     const std::string& shaders) {
  std::vector<std::unique_ptr<Renderer>> renderers;
  for (const DeviceInfo& device : devices) renderers.push_back(shaderRenderer(scene, device, shaders));
  nameApart(renderers);
  renderers.push_back(referenceRenderer(scene, ReferenceOf::scene));
  for (const auto& renderer : renderers) renderer->info.content += programHash();
  return renderers;
}

std::string processorName() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(std::min(line.size(), line.find(':') + 2));
  return "unknown processor";
}

// The scenes, loaded, what is to be done with each, and by whom.
struct Plan {
  std::vector<Scene> scenes;
  std::vector<SceneToSweep> sweeps;
  std::vector<DeviceInfo> devices;
  std::vector<RendererInfo> renderers;
  std::string shaders;
  int repeats = kQuickRepeats;
};

// A scene's name as a part of files' names and a word of the journal.
std::string wordOf(const std::string& name) {
  constexpr size_t kLongest = 40;
  std::string word = name.substr(0, kLongest);
  for (char& c : word)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '_' && c != '.') c = '_';
  return word;
}

// File names may be any bytes, JSON and HTML are UTF-8: bytes that are not become question marks.
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

Plan planFor(const ReportOptions& options) {
  Plan plan;
  for (const std::string& name : options.scenes) {
    if (name.empty()) throw InputError("the name of a scene is empty");
    plan.scenes.push_back(loadScene(findScene(name)));
  }
  const int maxSamples = options.maxSamples.value_or(options.full ? kFullSamples : kQuickSamples);
  plan.repeats = options.repeats.value_or(options.full ? kFullRepeats : kQuickRepeats);
  plan.devices = devicesFor(options);
  plan.shaders = shaderFolder(options.shaders);
  for (size_t i = 0; i < plan.scenes.size(); ++i) {
    const Scene& scene = plan.scenes[i];
    const RenderSettings whole = wholeOf(scene, options);
    const std::string stem = wordOf(fs::path(options.scenes[i]).stem().string());
    plan.sweeps.push_back({scene, validUtf8(options.scenes[i]), stem, fmt::format("{}-{}-", i + 1, stem), whole,
                           planSweep(scene, whole, maxSamples), plan.repeats});
  }
  // Who renders does not depend on what.
  for (const auto& renderer : openRenderers({}, plan.devices, plan.shaders)) plan.renderers.push_back(renderer->info);
  throwIfInterrupted();
  return plan;
}

// Names all that the measurements depend on.
std::string fingerprint(const Plan& plan) {
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

Machine thisMachine(const ReportOptions& options, int repeats) {
  Machine machine;
  machine.processor = processorName();
  machine.cores = std::max(1u, std::thread::hardware_concurrency());
  utsname system{};
  if (uname(&system) == 0) machine.system = fmt::format("{} {}", system.sysname, system.release);
  machine.version = TURNER_VERSION;
  const std::time_t now = std::time(nullptr);
  char date[32] = "";
  std::strftime(date, sizeof date, "%Y-%m-%d %H:%M UTC", std::gmtime(&now));
  machine.date = date;
  machine.shaders = options.shaders;
  machine.repeats = repeats;
  machine.command = "turner report";
  for (const std::string& scene : options.scenes)
    machine.command += ' ' + shellWord((scene.starts_with('-') ? "./" : "") + scene);
  machine.command += " -o " + shellWord(options.output) + (options.full ? " --full" : " --quick");
  const auto add = [&](const char* name, const auto& value) {
    if (value) machine.command += fmt::format(" {} {}", name, *value);
  };
  add("--max-samples", options.maxSamples);
  add("--repeats", options.repeats);
  add("--width", options.width);
  add("--height", options.height);
  add("--depth", options.depth);
  if (!options.crop.empty()) machine.command += " --crop " + options.crop;
  if (!options.device.empty()) machine.command += " --device " + shellWord(options.device);
  if (!options.shaders.empty()) machine.command += " --shaders " + shellWord(options.shaders);
  if (options.keepExr) machine.command += " --exr";
  machine.command = validUtf8(machine.command);
  machine.shaders = validUtf8(machine.shaders);
  return machine;
}

void printPlan(const Plan& plan, const Journal& journal, const std::string& output) {
  for (size_t i = 0; i < plan.sweeps.size(); ++i) {
    const SceneToSweep& sweep = plan.sweeps[i];
    fmt::print("scene: {} ({} x {} pixels, {} settings", sweep.path, sweep.whole.crop.width(),
               sweep.whole.crop.height(), sweep.settings.size());
    for (const RendererInfo& renderer : plan.renderers) fmt::print(", {}", renderer.device);
    fmt::print(", {} times)\n", sweep.repeats);
    for (const std::string& note : sweep.scene.notes) fmt::print("note: {}\n", note);
  }
  if (journal.size() > 0)
    fmt::print("going on with {} measurements of an interrupted report in {}\n", journal.size(), output);
  std::fflush(stdout);
}

// Shows how far the sweep is. The time left follows from the speed of each renderer so far.
class SweepProgress : public SweepObserver {
 public:
  explicit SweepProgress(bool quiet) : line_(quiet) {}

  void expect(const std::string& renderer, double samples) override { loads_[renderer].left += samples; }

  void done(const std::string& renderer, double samples, const std::string& what) override {
    throwIfInterrupted();
    const double now = line_.secondsSinceStart();
    Load& load = loads_[renderer];
    load.left -= samples;
    load.samples += samples;
    load.seconds += now - last_;
    last_ = now;
    if (now < kFirst || !line_.isDue()) return;
    const double left = secondsLeft();
    line_.show(fmt::format("{:3.0f} %, {} left: {}", 100 * now / (now + left), inWords(left), what));
    if (!warned_ && now > kEarly && left > kLong) {
      warned_ = true;
      line_.note(
          fmt::format("note: this takes about {} more; fewer samples (--max-samples) or pixels (--width) take less",
                      inWords(left)));
    }
  }

 private:
  struct Load {
    double left = 0;                  // samples
    double samples = 0, seconds = 0;  // done
  };
  // When an estimate is one, when it is a good one, and when it should be told: seconds.
  static constexpr double kFirst = 3, kEarly = 10, kLong = 600;

  static std::string inWords(double seconds) {
    return seconds < 120    ? fmt::format("{:.0f} s", seconds)
           : seconds < 7200 ? fmt::format("{:.0f} min", seconds / 60)
                            : fmt::format("{:.1f} h", seconds / 3600);
  }

  double secondsLeft() const {
    Load all;
    for (const auto& [name, load] : loads_) {
      all.samples += load.samples;
      all.seconds += load.seconds;
    }
    double left = 0;
    for (const auto& [name, load] : loads_) {
      const Load& speed = load.samples > 0 ? load : all;
      if (speed.samples > 0) left += std::max(load.left, 0.0) * speed.seconds / speed.samples;
    }
    return left;
  }

  StatusLine line_;
  std::map<std::string, Load> loads_;
  double last_ = 0;
  bool warned_ = false;
};

std::vector<SweptScene> measureAll(const Plan& plan, Journal& journal, bool quiet) {
  SweepProgress progress(quiet);
  for (const SceneToSweep& sweep : plan.sweeps) expectSweep(sweep, plan.renderers, journal, progress);
  std::vector<SweptScene> scenes;
  for (size_t i = 0; i < plan.sweeps.size(); ++i)
    scenes.push_back(
        measure(plan.sweeps[i], openRenderers(plan.scenes[i], plan.devices, plan.shaders), journal, progress));
  return scenes;
}

void writePictures(const Plan& plan, const std::vector<SweptScene>& scenes, const Journal& journal,
                   const fs::path& folder) {
  for (size_t i = 0; i < scenes.size(); ++i) {
    const std::string& tag = plan.sweeps[i].tag;
    for (const SweepPoint& point : scenes[i].points)
      writeWholeFile((folder / (tag + point.name + ".exr")).string(),
                     readTextFile(journal.picturePath(tag + point.name)));
    writeWholeFile((folder / (tag + "converged.exr")).string(), encodeExr(scenes[i].converged.mean, {}));
  }
}

void makeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError("cannot make the folder " + folder.string() + ": " + error.message());
}

}  // namespace

int runReport(const ReportOptions& options) {
  const Plan plan = planFor(options);
  const fs::path output = options.output, pictures = output / "pictures";
  makeFolder(options.keepExr ? pictures : output);
  const std::string page = (output / "report.html").string(), json = (output / "report.json").string(),
                    csv = (output / "report.csv").string();
  for (const std::string& file : {page, json, csv}) checkWritable(file);
  if (options.keepExr) checkWritable((pictures / "picture.exr").string());

  const fs::path unfinished = output / "unfinished", folder = unfinished / fingerprint(plan).substr(0, 16);
  std::vector<SweptScene> scenes;
  {
    Journal journal(folder.string());
    if (!options.quiet) printPlan(plan, journal, options.output);
    try {
      scenes = measureAll(plan, journal, options.quiet);
    } catch (const Interrupted&) {
      throw Interrupted(
          fmt::format("interrupted after {} measurements; the same command goes on from there", journal.size()));
    }
    throwIfInvalid();

    const Machine machine = thisMachine(options, plan.repeats);
    const PictureOf pictureOf = [&](size_t scene, const SweepPoint& point) {
      return journal.picture(plan.sweeps[scene].tag + point.name);
    };
    writeWholeFile(json, reportJson(machine, scenes));
    writeWholeFile(csv, reportCsv(machine, scenes));
    if (options.keepExr) writePictures(plan, scenes, journal, pictures);
    writeWholeFile(page, reportPage(machine, scenes, pictureOf));
    journal.discard();
  }
  std::error_code inUse;  // by an interrupted report with other options
  fs::remove(unfinished, inUse);

  if (!options.quiet) {
    for (const SweptScene& scene : scenes) {
      fmt::print("{}\n", scene.path);
      for (const std::string& sentence : findings(scene)) fmt::print("  {}\n", sentence);
    }
    for (const std::string& file : {page, json, csv}) fmt::print("wrote {}\n", file);
  }
  return 0;
}

}  // namespace turner
