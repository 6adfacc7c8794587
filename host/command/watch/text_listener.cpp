// For people.
#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>

#include "command/progress_line.h"
#include "command/watch/listeners.h"
#include "command/watch/print.h"

namespace turner {
using namespace watch;
namespace {

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

class TextListener : public WatchListener {
 public:
  TextListener(const WatchPlan& plan, bool quiet) : plan_(plan), quiet_(quiet) {
    print("watching {} and {}; Ctrl-C ends\n", plan.scene, plan.shaders + "/whitted.comp with its includes");
  }

  void onScene(const SceneReady& scene) override {
    print("scene: {} ({})\n", plan_.scene, toText(scene.primitives));
    for (const std::string& note : scene.summary.notes) print("{}\n", note);
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
    tellWatcher(fmt::format(format, values...));
  }

  const WatchPlan& plan_;
  bool quiet_, printedDevice_ = false;
  std::optional<double> coarse_;  // seconds until the version in work had a coarse picture
  std::unique_ptr<StatusLine> status_;
};

}  // namespace

std::unique_ptr<WatchListener> textListener(const WatchPlan& plan, bool quiet) {
  return std::make_unique<TextListener>(plan, quiet);
}

}  // namespace turner
