// Events of watching a scene and its shaders, for whoever prints them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "watch/diagnosis/diagnosis.h"
#include "watch/process/messages.h"
#include "watch/version_report.h"

namespace turner::watch {

// A version that has no picture.
struct Refusal {
  int version = 0;
  std::optional<int> lastGood;  // none: there is no picture yet
  double seconds = 0;           // since the save
  Step step = Step::open;       // where it ended
  bool endless = false;         // a loop that does not end
  std::vector<Diagnosis> diagnoses;
};

class WatchListener {
 public:
  virtual ~WatchListener() = default;

  // A scene is on the device; before the first picture, and when it was loaded anew.
  virtual void onScene(const SceneReady& scene) = 0;
  // The pictures on disk are those of a version: every eighth pixel of it, or all.
  virtual void onCoarse(int version, double seconds) = 0;
  virtual void onPicture(int version, double seconds, const std::vector<std::string>& changed) = 0;
  // All that is to be known of it; in what was interrupted figures are missing.
  virtual void onVersion(const VersionReport& report) = 0;
  // The picture of the reference is there, for a version that was reported before.
  virtual void onReference(int version, const Comparison& comparison) = 0;
  virtual void onRefused(const Refusal& refusal) = 0;
  // A newer save has interrupted a version before it had a picture.
  virtual void onSuperseded(int version) = 0;
  // Something went wrong beside the picture: a file cannot be written, figures are missing.
  virtual void onTrouble(int version, const std::vector<Diagnosis>& diagnoses) = 0;
  // Ctrl-C. The pictures on disk are those of this version.
  virtual void onStop(std::optional<int> version) = 0;
  // How far the work is; called often.
  virtual void onProgress(int version, Step step, double share) = 0;
};

}  // namespace turner::watch
