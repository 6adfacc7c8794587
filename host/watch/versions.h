// The versions of a watched scene and its kernel: which one is in work, which is the last good one, and what becomes of
// each. A state machine without files, processes or a clock. In: changes and the worker's answers. Out: events for the
// listener, and actions.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "image/image.h"
#include "kernel/shader_sources.h"
#include "watch/listener.h"
#include "watch/process/messages.h"
#include "watch/version_report.h"

namespace turner::watch {

// Times are seconds of the caller's clock.

// A coarse picture is not worth showing where the full one follows so soon after the quiet time.
inline constexpr double kSoon = 0.1;
// If no picture has appeared for kLongest (watched_files.h) because saves keep interrupting, a version may run this
// long before it is interrupted.
inline constexpr double kLifetime = 3;

// The files at the moment when a version begins.
struct Change {
  uint64_t burst = 0, sceneEpoch = 0;  // see WatchedFiles
  double savedAt = 0, beganAt = 0;
  std::vector<ShaderSource> sources;  // the kernel first
  std::string unreadable;             // why the kernel itself cannot be read or rendered; empty where it can
};

// A version whose picture is good.
struct GoodVersion {
  int version = 0;
  uint64_t sceneEpoch = 0;
  std::vector<ShaderSource> sources;
  std::vector<uint32_t> words;
  SceneReady scene;
  Image image;
  VersionReport report;
};

// What the versions need of the world; a fake in tests.
class VersionActions {
 public:
  virtual ~VersionActions() = default;

  virtual double now() const = 0;
  // When the burst of saves that a version began with is over; 0 if another one has begun.
  virtual double quietUntil(uint64_t burst) const = 0;

  // Gives the worker a job for the scene's files as they are now; a failure comes back as an answer.
  virtual void submit(Job job) = 0;
  // Writes a picture to all outputs. Returns what went wrong, a message for each output.
  virtual std::vector<std::string> show(const Image& image, const SceneReady& scene, bool coarse) = 0;
  // Keeps a version, if versions are kept, and returns its folder, else an empty path. Throws std::runtime_error.
  virtual std::string keep(const GoodVersion& good, const VersionReport& report) = 0;
  // The same of figures that came later. Throws RunError.
  virtual void keepFigures(const VersionReport& report) = 0;
  // The reference's picture of a scene, if it is done.
  virtual const Image* reference(uint64_t sceneEpoch) const = 0;

  // For the files that are followed, see WatchedFiles.
  virtual void compilerRead(const std::vector<std::string>& files) = 0;
  virtual void sceneWasRefused() = 0;
  virtual void forgetTaken() = 0;
};

class Versions {
 public:
  // Numbers go on from the last one that is known.
  Versions(VersionActions& actions, WatchListener& listener, int lastVersion)
      : actions_(actions), listener_(listener), lastVersion_(lastVersion) {}

  bool isWorking() const { return attempt_.has_value(); }
  int version() const { return attempt_->version; }  // in work
  // Its picture is shown; what follows are figures.
  bool hasPicture() const { return attempt_ && attempt_->hasPicture; }
  const GoodVersion* good() const { return good_ ? &*good_ : nullptr; }
  // When the version in work may be interrupted at the latest.
  double protectedUntil() const { return attempt_->beganAt + kLifetime; }

  // Files have changed: ends the version in work. False: it is protected and goes on.
  bool interrupt(uint64_t burst);
  // The change waits until the worker has given up older work.
  void waitForWorker(uint64_t burst);
  // Begins a version and submits its job.
  void begin(Change change);

  // An answer of the worker to the version's job, kept until it may be applied.
  void receive(Message answer);
  // Applies the answers that are due. Throws InputError and RunError for what no edit can mend.
  void applyAnswers();
  bool hasAnswersDue() const;
  // When answers become due that are held back.
  double nextDecision() const;

  // The reference's picture for the last good version has come.
  void applyReference();
  void reportTrouble(int version, const std::string& text);
  // Ctrl-C: the outputs are those of the last good version afterwards.
  void stop();

 private:
  // A version in work.
  struct Attempt {
    int version = 0;
    uint64_t burst = 0, sceneEpoch = 0;
    double savedAt = 0, beganAt = 0;
    std::vector<ShaderSource> sources;
    std::vector<uint32_t> words;
    std::deque<Message> answers;          // not yet applied
    std::optional<double> pictureCameAt;  // the first, coarse one
    std::optional<Refused> refused;       // and its endless loop is being looked for
    std::optional<SourceLocation> loop;
    VersionReport report;
    bool isPastCoarse = false;  // the next picture is the full one
    bool hasPicture = false;    // it is the last good version now
  };

  bool isProtected() const;
  double heldUntil() const { return actions_.quietUntil(attempt_->burst); }
  bool isQuiet() const { return actions_.now() >= heldUntil(); }
  Message takeAnswer();
  bool hasPictureIn(const std::deque<Message>::const_iterator& from) const;
  bool awaitsFullPicture() const;

  void apply(const SceneReady& scene);
  void apply(const Compiled& compiled);
  void apply(Picture picture);
  void apply(const Refused& refused);
  void applyFigures(const Message& message);
  void takePicture(Image image);
  void compareWithReference(VersionReport& report) const;

  void conclude();
  void concludeEarly();
  std::string reasonOf(const Refused& refused, bool isEndless) const;
  void refuse(const Refused& refused);
  void show(const Image& image, const SceneReady& scene, int version, bool coarse);
  void showGoodAgain();

  VersionActions& actions_;
  WatchListener& listener_;
  int lastVersion_ = 0;
  std::optional<Attempt> attempt_;
  bool repeatsVersion_ = false;           // the next attempt is of the same version
  std::optional<uint64_t> waitingBurst_;  // of the change that waits for the worker
  std::optional<double> unseenSince_;     // attempts have come to nothing, because of newer saves
  std::optional<GoodVersion> good_;
  bool showsGood_ = false;  // the outputs are those of the last good version
};

}  // namespace turner::watch
