// `turner watch`: what it prints. For people a line as soon as a picture is there and aligned lines with what the
// change did, for programs one JSON object on a line for each thing that happens. Diagnoses go to stderr in both.
#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "base/errors.h"
#include "base/output_file.h"
#include "command/commands.h"
#include "command/data_folder.h"
#include "command/device_choice.h"
#include "command/interrupt.h"
#include "command/outputs.h"
#include "command/progress_line.h"
#include "geometry/round_scene.h"
#include "watch/watch.h"

namespace turner {
using namespace watch;
namespace {

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

void printDiagnoses(const std::vector<Diagnosis>& diagnoses) {
  for (const Diagnosis& diagnosis : diagnoses) fmt::print(stderr, "{}\n", gccText(diagnosis));
  std::fflush(stderr);
}

// What another process reads has to come at once; and without a reader there is nothing to watch for.
void flush() {
  if (std::fflush(stdout) != 0) throw RunError("cannot write to standard output");
}

class TextListener : public WatchListener {
 public:
  TextListener(const WatchPlan& plan, bool quiet) : plan_(plan), quiet_(quiet) {
    print("watching {} and {}; Ctrl-C ends\n", plan.scene, plan.shaders + "/whitted.comp with its includes");
  }

  void onScene(const SceneReady& scene) override {
    print("scene: {} ({} spheres, {} triangles)\n", plan_.scene, scene.spheres, scene.triangles);
    for (const std::string& note : scene.summary.notes) print("note: {}\n", note);
    if (std::exchange(printedDevice_, true)) return;
    print("device: {} ({}, {}), fetching {}\n", scene.device, scene.deviceType, scene.driver, scene.access);
  }
  void onCoarse(int, double seconds) override { coarse_ = seconds; }
  void onPicture(int version, double seconds, const std::vector<std::string>& changed) override {
    print("version {}{}: in {} after {:.2f} s{}\n", version, changed.empty() ? "" : ", " + joined(changed) + " changed",
          joined(plan_.outputs), seconds, coarse_ ? fmt::format(" (coarse after {:.2f} s)", *coarse_) : "");
    coarse_.reset();
  }
  void onVersion(const VersionReport& report) override { print("{}", versionReportText(report)); }
  void onReference(int version, const Comparison& comparison) override {
    print("version {}:\n{}", version, referenceText(comparison));
  }
  void onRefused(const Refusal& refusal) override {
    status_.reset();
    coarse_.reset();
    printDiagnoses(refusal.diagnoses);
    if (refusal.lastGood)
      print("version {}: refused after {:.2f} s; the picture stays that of version {}\n", refusal.version,
            refusal.seconds, *refusal.lastGood);
    else
      print("version {}: refused after {:.2f} s; there is no picture yet, waiting for a change\n", refusal.version,
            refusal.seconds);
  }
  void onSuperseded(int version) override {
    coarse_.reset();
    print("version {}: interrupted by a newer save\n", version);
  }
  void onTrouble(int, const std::vector<Diagnosis>& diagnoses) override {
    status_.reset();
    printDiagnoses(diagnoses);
  }
  void onStop(std::optional<int> version) override {
    status_.reset();
    if (version)
      print("stopped; {} shows version {}\n", joined(plan_.outputs), *version);
    else
      print("stopped; there is no picture\n");
  }
  void onProgress(int version, Step step, double share) override {
    if (!status_) status_ = std::make_unique<StatusLine>(quiet_);
    if (status_->isDue()) status_->show(fmt::format("version {}: {}, {:.0f} %", version, stepName(step), 100 * share));
  }

 private:
  template <class... Values>
  void print(fmt::format_string<const Values&...> format, const Values&... values) {
    status_.reset();
    if (quiet_) return;
    fmt::print(format, values...);
    flush();
  }

  const WatchPlan& plan_;
  bool quiet_, printedDevice_ = false;
  std::optional<double> coarse_;  // seconds until the version in work had a coarse picture
  std::unique_ptr<StatusLine> status_;
};

class JsonListener : public WatchListener {
 public:
  explicit JsonListener(const WatchPlan& plan) {
    print("watching", [&](JsonWriter& json) {
      json.put("scene", plan.scene);
      json.put("shaders", plan.shaders);
      json.array("outputs", [&] {
        for (const std::string& output : plan.outputs) json.put(output);
      });
    });
  }

  void onScene(const SceneReady& scene) override {
    print("scene", [&](JsonWriter& json) {
      json.put("spheres", scene.spheres);
      json.put("triangles", scene.triangles);
      json.put("width", scene.settings.width);
      json.put("height", scene.settings.height);
      json.object("device", [&] {
        json.put("name", scene.device);
        json.put("driver", scene.driver);
        json.put("type", scene.deviceType);
      });
      json.array("notes", [&] {
        for (const std::string& note : scene.summary.notes) json.put(note);
      });
    });
  }
  void onCoarse(int version, double seconds) override {
    print("coarse", [&](JsonWriter& json) {
      json.put("version", version);
      json.put("seconds", seconds);
    });
  }
  void onPicture(int version, double seconds, const std::vector<std::string>&) override {
    print("picture", [&](JsonWriter& json) {
      json.put("version", version);
      json.put("seconds", seconds);
    });
  }
  void onVersion(const VersionReport& report) override {
    print("version", [&](JsonWriter& json) { putVersionReport(json, report); });
  }
  void onReference(int version, const Comparison& comparison) override {
    print("reference", [&](JsonWriter& json) {
      json.put("version", version);
      putComparison(json, "to_reference", comparison);
    });
  }
  void onRefused(const Refusal& refusal) override {
    printDiagnoses(refusal.diagnoses);
    print("refused", [&](JsonWriter& json) {
      json.put("version", refusal.version);
      json.put("last_good", refusal.lastGood);
      json.put("seconds", refusal.seconds);
      json.put("step", stepName(refusal.step));
      json.put("endless", refusal.endless);
      putDiagnoses(json, refusal.diagnoses);
    });
  }
  void onSuperseded(int version) override {
    print("superseded", [&](JsonWriter& json) { json.put("version", version); });
  }
  void onTrouble(int version, const std::vector<Diagnosis>& diagnoses) override {
    printDiagnoses(diagnoses);
    print("trouble", [&](JsonWriter& json) {
      json.put("version", version);
      putDiagnoses(json, diagnoses);
    });
  }
  void onStop(std::optional<int> version) override {
    print("stopped", [&](JsonWriter& json) { json.put("version", version); });
  }
  void onProgress(int, Step, double) override {}

 private:
  template <class Fill>
  static void print(const char* event, const Fill& fill) {
    JsonWriter json;
    json.object([&] {
      json.put("event", event);
      fill(json);
    });
    fmt::print("{}", json.oneLine());
    flush();
  }

  static void putDiagnoses(JsonWriter& json, const std::vector<Diagnosis>& diagnoses) {
    json.array("diagnoses", [&] {
      for (const Diagnosis& diagnosis : diagnoses) {
        json.object([&] {
          json.put("file", diagnosis.file);
          json.put("line", diagnosis.line);
          json.put("column", diagnosis.column);
          json.put("message", diagnosis.message);
          json.put("source", diagnosis.source);
        });
      }
    });
  }
};

}  // namespace

void runWatch(const WatchOptions& watch, const RenderOptions& render) {
  std::signal(SIGPIPE, SIG_IGN);  // nobody reads any more: a failed write like any other, see flush()
  if (render.scene.empty()) throw InputError("the name of the scene is empty");
  WatchPlan plan;
  plan.scene = findScene(render.scene);
  if (!std::filesystem::exists(plan.scene)) throw InputError(plan.scene + ": error: there is no such file");
  plan.shaders = shaderFolder(render.shaders);
  plan.outputs = render.outputs;
  if (plan.outputs.empty()) plan.outputs = {defaultOutput(render.scene)};
  for (const std::string& output : plan.outputs) checkOutput(output, true);
  refuseRepeated(plan.outputs);
  refuseOverwriting(plan.outputs, {plan.scene});
  plan.keep = watch.keep;
  plan.timeout = watch.timeout;
  plan.settingsOf = [&](const Scene& scene) { return settingsFor(scene, render); };
  plan.referenceGeometry = [&](Scene scene) {
    return render.geometry == Geometry::rounded ? roundScene(std::move(scene)) : scene;
  };
  plan.chooseDevice = [&] { return chooseDeviceFor(render.device); };
  plan.throwIfInterrupted = throwIfInterrupted;
  plan.writePicture = writePicture;
  plan.access = render.access;
  plan.dispatching = {.tile = render.tile, .workGroup = render.workGroup};

  const std::unique_ptr<WatchListener> listener = watch.json ? std::unique_ptr<WatchListener>(new JsonListener(plan))
                                                             : std::make_unique<TextListener>(plan, render.quiet);
  watch::watch(plan, *listener);
}

}  // namespace turner
