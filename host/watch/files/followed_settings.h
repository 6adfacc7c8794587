// Values of parameters that change while a scene is watched: those of a file that is followed, or of lines from
// standard input. Times are seconds of the caller's clock.
#pragma once

#include <string>
#include <vector>

#include "base/parameter_setting.h"
#include "watch/files/file_watch.h"

namespace turner::watch {

class FollowedSettings {
 public:
  // A file with an object of settings (scene/json/settings_json.h); "-": each line of standard input has one, which
  // adds to those before; empty: there are none. Throws InputError where the file cannot be read, or is wrong.
  explicit FollowedSettings(const std::string& file);

  // Whether they have changed.
  bool check(double now);
  const std::vector<ParameterSetting>& settings() const { return settings_; }
  double changedAt() const { return changedAt_; }
  // What is wrong with the text that came last, once; empty: nothing. The settings are then as before.
  std::string takeFault();

  // For poll(): readable when it is worth to look, -1 where there is nothing to wait for; and when to look again.
  int descriptor() const;
  double nextLook() const;

 private:
  bool checkFile(double now);
  bool readLines(double now);
  bool takeText(const std::string& text, bool adds, double now);

  std::string file_;
  FileWatch watch_;
  std::vector<ParameterSetting> settings_;
  double changedAt_ = 0, lookAgainAt_ = 0;
  std::string fault_;
  std::string faultyText_;  // of a file, which may have been read in the middle of a save
  bool isFaulty_ = false;
  std::string line_;    // of standard input, not yet ended
  bool isOpen_ = true;  // standard input
};

}  // namespace turner::watch
