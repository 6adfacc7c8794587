// One loop that waits for three things: files that change, answers of the worker, and the time. What a version comes to
// is decided here; all work on it is done in processes that can be killed: the worker, which renders edited shaders,
// and one for the reference, which stands still while anything else works.
#include "watch/watch.h"

#include <malloc.h>
#include <poll.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>
#include <optional>
#include <utility>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "base/text_file.h"
#include "base/threads.h"
#include "image/provenance.h"
#include "kernel/source_names.h"
#include "watch/kept_versions.h"
#include "watch/reference_process.h"
#include "watch/renderer_process.h"
#include "watch/source_change.h"
#include "watch/watched_files.h"
#include "watch/worker.h"

namespace turner::watch {
namespace {

// Seconds. A coarse picture is not worth showing where the full one follows so soon after the quiet time.
constexpr double kSoon = 0.1;
// If no picture has appeared for kLongest because saves keep interrupting, a version may run this long before it is
// interrupted.
constexpr double kLifetime = 3;
// poll() overslept by more than this: the process was suspended (SIGSTOP).
constexpr double kOverslept = 0.5;

// A version whose picture is good.
struct Good {
  int version = 0;
  uint64_t sceneEpoch = 0;
  std::vector<ShaderSource> sources;
  std::vector<uint32_t> words;
  SceneReady scene;
  Image image;
  VersionReport report;
};

// A version on its way.
struct Attempt {
  int version = 0;
  uint64_t burst = 0, sceneEpoch = 0;
  double savedAt = 0, beganAt = 0;
  std::vector<ShaderSource> sources;
  std::vector<uint32_t> words;
  std::deque<Message> answers;          // of the worker, that are not yet looked at
  std::optional<double> pictureCameAt;  // the first, coarse one
  std::optional<Refused> refused;       // and its endless loop is being looked for
  std::optional<SourceLocation> loop;
  VersionReport report;
  bool isPastCoarse = false;  // the next picture is the full one
  bool hasPicture = false;    // it is the last good version now
};

bool haveSameSize(const Image& a, const Image& b) {
  return a.window == b.window && a.width == b.width && a.height == b.height;
}

std::string versionReportJson(const VersionReport& report) {
  JsonWriter json;
  json.object([&] { putVersionReport(json, report); });
  return json.text();
}

// The reason that the system has.
std::string cannotRead(const std::string& path) try {
  readRegularFile(path);
  return path + ": error: it changed while it was read";
} catch (const InputError& error) {
  return error.what();
}

class Watcher {
 public:
  Watcher(const WatchPlan& plan, WatchListener& listener)
      : plan_(plan), listener_(listener), files_(plan.scene, plan.shaders), renderer_(plan), reference_(plan) {
    if (!plan.keep.empty()) lastVersion_ = lastKeptVersion(plan.keep);
    begin();
  }

  [[noreturn]] void run() try {
    for (;;) {
      plan_.throwIfInterrupted();
      files_.check(now());
      if (files_.isDue(now())) takeUpChange();
      pollRenderer();
      if (attempt_ && isQuiet()) applyAnswers();
      superviseProcesses();
      waitForEvents();
    }
  } catch (const Interrupted&) {
    renderer_.end();
    reference_.end();
    if (attempt_ && attempt_->hasPicture) concludeEarly();
    if (good_) showGoodAgain();
    listener_.onStop(good_ ? std::optional(good_->version) : std::nullopt);
    throw Interrupted("interrupted; watching has ended");
  }

 private:
  double now() const { return clock_.seconds(); }

  // --- versions -------------------------------------------------------------------------------------------------

  // Files have changed: gives up what is in work for older ones, then begins.
  void takeUpChange() {
    if (attempt_ && attempt_->hasPicture) concludeEarly();
    if (attempt_) {
      if (isProtected()) return;
      if (attempt_->burst == files_.burst())
        repeatsVersion_ = true;  // nothing of it was seen
      else
        listener_.onSuperseded(attempt_->version);
      if (!unseenSince_) unseenSince_ = attempt_->beganAt;
      files_.forgetTaken();
      attempt_.reset();
    }
    if (!renderer_.isPreparing() || files_.isSceneStale()) renderer_.cancel(now(), !files_.isSceneStale());
    // What waits for the worker to give up may itself be overtaken.
    if (waitingBurst_ && *waitingBurst_ != files_.burst())
      listener_.onSuperseded(std::exchange(repeatsVersion_, false) ? lastVersion_ : ++lastVersion_);
    waitingBurst_ = files_.burst();
    if (!renderer_.isBusy()) begin();
  }

  // Whoever saves without end shall see a picture now and then.
  bool isProtected() const {
    return unseenSince_ && now() > *unseenSince_ + kLongest && now() < attempt_->beganAt + kLifetime;
  }

  void begin() {
    Attempt& attempt = attempt_.emplace();
    waitingBurst_.reset();
    if (!std::exchange(repeatsVersion_, false)) ++lastVersion_;
    attempt.version = lastVersion_;
    attempt.burst = files_.burst();
    attempt.savedAt = files_.lastChange();
    attempt.beganAt = now();
    attempt.sources = files_.takeUp();
    attempt.sceneEpoch = files_.sceneEpoch();
    mayPrepare_ = true;
    VersionReport& report = attempt.report;
    report.version = attempt.version;
    if (good_) {
      report.lastGood = good_->version;
      report.changed = changedFiles(good_->sources, attempt.sources);
      report.sceneChanged = good_->sceneEpoch != attempt.sceneEpoch;
    }
    // A kernel that cannot be read never comes to the worker.
    if (!attempt.sources[0].text)
      return answer({.step = Step::compile, .wrongInput = true, .text = cannotRead(attempt.sources[0].path)});
    Job job;
    job.purpose = Purpose::render;
    job.sources = attempt.sources;
    if (good_) job.goodWords = good_->words;
    job.goodHasScene = good_ && good_->sceneEpoch == attempt.sceneEpoch;
    give(std::move(job));
  }

  void give(Job job) {
    job.sceneEpoch = files_.sceneEpoch();
    job.reloadScene = files_.isSceneStale();
    try {
      renderer_.give(std::move(job), now());
    } catch (const RunError& error) {
      answer({.text = error.what()});
    }
  }

  // What the worker would have said.
  void answer(const Refused& refused) {
    if (attempt_) attempt_->answers.push_back(encode(refused));
  }

  // Results are held until the burst of saves is over: they may be of half a change.
  double heldUntil() const { return attempt_->burst == files_.burst() ? files_.quietUntil() : 0; }
  bool isQuiet() const { return now() >= heldUntil(); }

  // --- processes ------------------------------------------------------------------------------------------------

  void pollRenderer() {
    while (std::optional<Message> message = renderer_.poll(now())) {
      if (message->kind == SceneReady::kind) {
        const SceneReady scene = decode<SceneReady>(*message);
        files_.sceneWasLoaded(scene.sceneEpoch, scene.summary.sources);
      }
      // Without an attempt it is of one that was given up, or of a worker that prepares itself.
      if (!attempt_ || renderer_.isPreparing()) continue;
      if (message->kind == Picture::kind && !attempt_->pictureCameAt) attempt_->pictureCameAt = now();
      attempt_->answers.push_back(std::move(*message));
    }
    if (attempt_) listener_.onProgress(attempt_->version, renderer_.step(), renderer_.share());
  }

  void superviseProcesses() {
    if (const std::optional<Refused> loss = renderer_.takeLoss(now())) answer(*loss);
    if (isIdle()) {
      if (std::exchange(hadAttempt_, false)) {
        if (renderer_.hasGrown()) renderer_.end();
        // Pictures come and go, and the heap keeps their room: of days of editing only the last version shall stay.
        ::malloc_trim(0);
      }
      if (!renderer_.isRunning() && std::exchange(mayPrepare_, false)) give({.purpose = Purpose::prepare});
    }
    hadAttempt_ |= attempt_.has_value();
    superviseReference();
  }

  bool isIdle() const { return !attempt_ && !renderer_.isBusy() && !files_.hasChange(); }

  // It works while nothing else does.
  void superviseReference() {
    if (!isIdle() || !good_ || good_->sceneEpoch != files_.sceneEpoch()) return reference_.pause();
    std::string fault;
    try {
      reference_.work(good_->sceneEpoch);
      if (!reference_.poll(fault)) return;
    } catch (const RunError& error) {
      fault = error.what();
    }
    if (!fault.empty()) return trouble(good_->version, "no reference: " + fault);
    compareWithReference(good_->report);
    if (!good_->report.toReference) return;
    if (!good_->report.kept.empty()) updateKeptFigures();
    listener_.onReference(good_->version, *good_->report.toReference);
  }

  void updateKeptFigures() try {
    keepFigures(good_->report.kept, versionReportJson(good_->report));
  } catch (const RunError& error) {
    trouble(good_->version, error.what());
  }

  void compareWithReference(VersionReport& report) const {
    const Image* image = reference_.image(good_->sceneEpoch);
    if (image && haveSameSize(*image, good_->image)) report.toReference = compareImages(good_->image, *image, kChanged);
  }

  // --- answers --------------------------------------------------------------------------------------------------

  void applyAnswers() {
    while (attempt_ && !attempt_->answers.empty() && !awaitsFullPicture()) {
      const Message message = takeAnswer();
      switch (message.kind) {
        case SceneReady::kind:
          apply(decode<SceneReady>(message));
          break;
        case Compiled::kind:
          apply(decode<Compiled>(message));
          break;
        case Picture::kind:
          apply(decode<Picture>(message));
          break;
        case LoopFound::kind: {
          const LoopFound found = decode<LoopFound>(message);
          attempt_->loop = SourceLocation{found.path, found.line, found.column};
          break;
        }
        case Finished::kind:
          if (attempt_->refused)
            refuse(*attempt_->refused);
          else
            conclude();
          break;
        case Refused::kind:
          apply(decode<Refused>(message));
          break;
        default:
          applyFigures(message);
      }
    }
  }

  Message takeAnswer() {
    Message message = std::move(attempt_->answers.front());
    attempt_->answers.pop_front();
    return message;
  }

  bool hasPictureIn(std::deque<Message>::const_iterator from) const {
    return std::any_of(from, attempt_->answers.end(),
                       [](const Message& message) { return message.kind == Picture::kind; });
  }

  // Whether next is a coarse picture of a scene that renders in a blink.
  bool awaitsFullPicture() const {
    const auto first = attempt_->answers.begin();
    const double soon = heldUntil() + kSoon;
    return good_ && first->kind == Picture::kind && !attempt_->isPastCoarse && now() < soon &&
           *attempt_->pictureCameAt + good_->report.trace < soon && !hasPictureIn(first + 1);
  }

  void apply(const SceneReady& scene) {
    if (attempt_->refused) return;  // only to look for its loop
    attempt_->report.scene = scene;
    if (!good_ || attempt_->report.sceneChanged) listener_.onScene(scene);
  }

  void apply(const Compiled& compiled) {
    VersionReport& report = attempt_->report;
    report.glslang = compiled.glslangSeconds;
    report.optimiser = compiled.optimiserSeconds;
    report.check = compiled.checkSeconds;
    report.code = compareInstructions(good_ ? good_->words : std::vector<uint32_t>(), compiled.words);
    attempt_->words = compiled.words;
    files_.compilerRead(compiled.files);
    if (!compiled.sameAsGood) return;
    report.sameCode = true;
    report.rays = good_->report.rays;
    report.trace = good_->report.trace;
    takePicture(good_->image);
  }

  void apply(Picture picture) {
    VersionReport& report = attempt_->report;
    report.pipeline += picture.pipelineSeconds;
    attempt_->isPastCoarse = true;
    if (picture.coarse) {
      if (hasPictureIn(attempt_->answers.begin())) return;  // the full one
      show(picture.image, report.scene, attempt_->version, true);
      report.toCoarse = now() - attempt_->savedAt;
      listener_.onCoarse(attempt_->version, *report.toCoarse);
      return;
    }
    report.trace = picture.traceSeconds;
    report.readback = picture.readbackSeconds;
    takePicture(std::move(picture.image));
  }

  // The attempt is the last good version from here on.
  void takePicture(Image image) {
    Attempt& attempt = *attempt_;
    VersionReport& report = attempt.report;
    show(image, report.scene, attempt.version, false);
    report.toPicture = now() - attempt.savedAt;
    listener_.onPicture(attempt.version, report.toPicture, report.changed);
    if (good_) {
      if (haveSameSize(image, good_->image)) report.toLastGood = compareImages(image, good_->image, kChanged);
      if (good_->sceneEpoch == attempt.sceneEpoch) report.lastGoodTrace = good_->report.trace;
      report.lastGoodRays = good_->report.rays;
    }
    Good& good = good_.emplace();
    good.version = attempt.version;
    good.sceneEpoch = attempt.sceneEpoch;
    good.sources = attempt.sources;
    good.words = attempt.words;
    good.scene = report.scene;
    good.image = std::move(image);
    compareWithReference(report);
    good.report = report;
    attempt.hasPicture = true;
    unseenSince_.reset();
  }

  void applyFigures(const Message& message) {
    if (message.kind == Timing::kind) attempt_->report.timing = decode<Timing>(message);
    if (message.kind == Counted::kind) attempt_->report.rays = decode<Counted>(message).rays;
  }

  // All that there will be is known of the version.
  void conclude() {
    VersionReport& report = attempt_->report;
    if (!report.toReference) compareWithReference(report);
    if (!plan_.keep.empty()) keep(report);
    good_->report = report;
    listener_.onVersion(report);
    attempt_.reset();
  }

  // A version with a picture is given up: what has come is all.
  void concludeEarly() {
    while (!attempt_->answers.empty()) applyFigures(takeAnswer());
    if (attempt_->refused)
      refuse(*attempt_->refused);
    else
      conclude();
  }

  void apply(const Refused& refused) {
    if (attempt_->refused) return refuse(*attempt_->refused);  // the search has found nothing
    if (refused.endless || refused.unfinished || (refused.hung && refused.step >= Step::pipeline)) {
      attempt_->refused = refused;
      Job job;
      job.purpose = Purpose::findLoop;
      job.hung = refused.hung;
      job.sources = attempt_->sources;
      return give(std::move(job));
    }
    // What no edit can mend.
    if (!good_ && refused.step == Step::open) {
      if (refused.wrongInput) throw InputError(refused.text);
      throw RunError(refused.text);
    }
    refuse(refused);
  }

  // What to say of a refusal, with the place of the fault where it can be told.
  std::string reasonOf(const Refused& refused, bool isEndless) const {
    const Attempt& attempt = *attempt_;
    const std::string text = (isEndless ? "endless loop: " : "") + refused.text;
    if (refused.wrongInput) return text;
    if (attempt.loop) return faultAt(*attempt.loop) + text + "; this loop made too many turns";
    if (!good_ || attempt.hasPicture) return text;
    const std::optional<SourceLocation> location = likelyLocation(good_->sources, attempt.sources);
    return location ? faultAt(*location) + text + "; likely by what was changed here" : text;
  }

  // Ends the attempt without a picture; or without all figures, if it has one.
  void refuse(const Refused& refused) {
    Attempt& attempt = *attempt_;
    const bool isEndless = attempt.loop || refused.endless || (refused.hung && runsKernel(refused.step));
    const std::string reason = reasonOf(refused, isEndless);
    if (refused.step == Step::scene) files_.sceneWasRefused();
    if (!refused.wrongInput) files_.forgetTaken();  // the machine may do better next time
    if (attempt.hasPicture) {
      trouble(attempt.version, reason);
      return conclude();
    }
    Refusal refusal;
    refusal.version = attempt.version;
    if (good_) refusal.lastGood = good_->version;
    refusal.seconds = now() - attempt.savedAt;
    refusal.step = refused.step;
    refusal.endless = isEndless;
    refusal.diagnoses = readDiagnoses(reason, attempt.sources);
    attempt_.reset();
    unseenSince_.reset();
    if (good_) showGoodAgain();
    listener_.onRefused(refusal);
  }

  void trouble(int version, const std::string& text) { listener_.onTrouble(version, readDiagnoses(text, {})); }

  // --- pictures -------------------------------------------------------------------------------------------------

  Provenance provenanceOf(const SceneReady& scene) const {
    return makeProvenance(scene.summary, scene.settings, "--backend shader --geometry rounded", scene.device,
                          scene.driver);
  }

  void show(const Image& image, const SceneReady& scene, int version, bool coarse) {
    Provenance provenance = provenanceOf(scene);
    if (coarse) provenance.strings.emplace_back("turner:coarse", std::to_string(kCoarseStride));
    std::vector<std::string> faults(plan_.outputs.size());
    onAllCores(plan_.outputs.size(), [&](size_t i) {
      try {
        plan_.writePicture(plan_.outputs[i], image, provenance);
      } catch (const std::runtime_error& error) {
        faults[i] = error.what();
      }
    });
    showsGood_ = !coarse;
    for (const std::string& fault : faults) {
      if (fault.empty()) continue;
      showsGood_ = false;
      if (!coarse) trouble(version, fault);
    }
  }

  // A coarse picture of what came to nothing does not stay.
  void showGoodAgain() {
    if (!showsGood_) show(good_->image, good_->scene, good_->version, false);
  }

  void keep(VersionReport& report) {
    KeptVersion version;
    version.sources = good_->sources;
    try {
      version.picture = encodeExr(good_->image, provenanceOf(good_->scene));
      version.sceneText = readRegularFile(plan_.scene);
      // What was changed since is no part of this version.
      if (sha256Hex(version.sceneText) == good_->scene.summary.sources.at(0).sha256)
        version.sceneName = std::filesystem::path(plan_.scene).filename().string();
      version.figures = versionReportJson(report);
      report.kept = keepVersion(plan_.keep, report.version, version);
    } catch (const std::runtime_error& error) {
      trouble(report.version, error.what());
    }
  }

  // --- waiting --------------------------------------------------------------------------------------------------

  // Until something comes, or the next moment at which something is due.
  void waitForEvents() {
    double until = std::min(now() + files_.pollMilliseconds() * 1e-3, renderer_.nextDecision());
    const auto wakeAt = [&](double time) {
      if (time > now()) until = std::min(until, time);
    };
    if (files_.hasChange()) {
      wakeAt(files_.lastChange() + kBreath);
      if (attempt_) wakeAt(attempt_->beganAt + kLifetime);
    }
    if (attempt_) {
      wakeAt(heldUntil());
      if (isQuiet() && !attempt_->answers.empty()) {
        if (!awaitsFullPicture()) return;
        wakeAt(heldUntil() + kSoon);
      }
    }
    pollfd waits[3];
    nfds_t count = 0;
    const auto waitFor = [&](int descriptor, int events) {
      if (descriptor >= 0) waits[count++] = {descriptor, short(events), 0};
    };
    waitFor(files_.descriptor(), POLLIN);
    waitFor(renderer_.descriptor(), renderer_.hasUnsent() ? POLLIN | POLLOUT : POLLIN);
    waitFor(reference_.descriptor(), POLLIN);
    const double begin = now(), wait = std::clamp(until - begin, 0.0, 1.0);
    ::poll(waits, count, int(std::ceil(wait * 1e3)));
    // Ctrl-Z has stopped the worker too.
    if (const double overslept = now() - begin - wait; overslept > kOverslept) renderer_.forgive(overslept);
  }

  const WatchPlan& plan_;
  WatchListener& listener_;
  const Stopwatch clock_;
  WatchedFiles files_;
  RendererProcess renderer_;
  ReferenceProcess reference_;
  bool mayPrepare_ = false;  // a worker, for want of one: once after each version

  int lastVersion_ = 0;
  std::optional<Attempt> attempt_;
  bool hadAttempt_ = false;
  bool repeatsVersion_ = false;           // the next attempt is of the same version
  std::optional<uint64_t> waitingBurst_;  // of the change that waits for the worker
  std::optional<double> unseenSince_;     // attempts have come to nothing, because of newer saves
  std::optional<Good> good_;
  bool showsGood_ = false;  // the pictures on disk are those of the last good version
};

}  // namespace

void watch(const WatchPlan& plan, WatchListener& listener) {
  // Whatever is as large as a kernel or a picture goes back to the system when it is freed: glibc begins with this
  // threshold, but would raise it by and by, take such blocks from its heap, and leave holes there.
  ::mallopt(M_MMAP_THRESHOLD, 128 << 10);
  Watcher(plan, listener).run();
}

}  // namespace turner::watch
