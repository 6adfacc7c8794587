// The files of a scene and its shaders: which saves of them are a change, and which changes are one. Times are seconds
// of the caller's clock, which begins at 0.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kernel/shader_sources.h"
#include "scene/scene.h"
#include "watch/files/file_watch.h"

namespace turner::watch {

// Seconds. Changes that follow within kQuiet of each other are a burst, which is one version; after kLongest it is over
// in any case. Work on a change may begin after kBreath, which joins the steps of one save: delete, write, rename.
inline constexpr double kBreath = 0.02, kQuiet = 0.2, kLongest = 2;

class WatchedFiles {
 public:
  WatchedFiles(std::string scene, const std::string& shaders);

  // Looks whether anything has changed, if it is worth to: the system says so, or the last look is long ago. Files that
  // were saved without a change have not.
  void check(double now);
  // Whether there is a change that takeUp() has not seen, and time to take it up. One that was taken back is none.
  bool isDue(double now);
  bool hasChange() const { return pending_; }
  // The kernel's sources as they are now, for a new version. Where the kernel itself cannot be read, one without text.
  std::vector<ShaderSource> takeUp();
  // The version of the last takeUp() came to no end of its own: the same files once more are a change.
  void forgetTaken() { mistrusted_ = true; }

  // The shader with what it includes, and these with the scene's files.
  std::vector<std::string> shaderFiles() const;
  std::vector<std::string> followed() const;

  double lastChange() const { return lastChange_; }
  uint64_t burst() const { return burst_; }
  // When the burst is over, unless another change comes.
  double quietUntil() const;

  // Grows with every change of the scene's files.
  uint64_t sceneEpoch() const { return sceneEpoch_; }
  // Whether they have changed since they were loaded last.
  bool isSceneStale() const { return loadedEpoch_ != sceneEpoch_; }
  // The scene was loaded, by a worker whose job had this epoch, from these files.
  void sceneWasLoaded(uint64_t epoch, const std::vector<SourceFile>& sources);
  // It cannot be loaded. A mesh that is missing may be why: what its text names is followed too.
  void sceneWasRefused();
  // What the compiler read; includes in an unusual spelling are found by it alone.
  void compilerRead(const std::vector<std::string>& files);

  // For poll(), and how long to wait at most.
  int descriptor() const { return watch_.descriptor(); }
  int pollMilliseconds() const { return watch_.pollMilliseconds(); }

 private:
  std::vector<ShaderSource> readSources() const;
  std::vector<std::string> filesOfScene() const;
  bool isAsLoaded(const std::string& file) const;
  bool isWorthChecking(double now) const;
  bool isKnownSource(const std::string& file) const;
  void readAndFollow();
  void follow();

  std::string scene_, kernel_;  // paths
  FileWatch watch_;
  std::vector<ShaderSource> seen_, taken_;  // when last looked at, and by the last takeUp()
  std::vector<std::string> read_;           // by the compiler
  std::vector<SourceFile> loaded_;          // the scene's files when it was last loaded
  std::vector<std::string> namedMeshes_;    // of a scene that cannot be loaded
  bool pending_ = false, mistrusted_ = false;
  bool loadedOther_ = false;   // a mesh has changed since it was loaded, before it was followed
  bool otherChanged_ = false;  // a file that is neither the scene's nor among the sources
  double lastCheck_ = 0, firstChange_ = -kLongest, lastChange_ = 0;
  uint64_t burst_ = 0, sceneEpoch_ = 1, takenEpoch_ = 0, loadedEpoch_ = 0;
};

}  // namespace turner::watch
