// For programs.
#include <optional>
#include <string>

#include "base/json_writer.h"
#include "base/tell.h"
#include "command/watch/listeners.h"
#include "command/watch/print.h"

namespace turner {
using namespace watch;
namespace {

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
      for (const PrimitiveCount& type : scene.primitives) json.put(type.name.c_str(), type.count);
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
    printResult(json.oneLine());
  }
};

}  // namespace

std::unique_ptr<WatchListener> jsonListener(const WatchPlan& plan) {
  return std::make_unique<JsonListener>(plan);
}

}  // namespace turner
