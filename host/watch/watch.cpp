// One loop that waits for three things: files that change, answers of the worker, and the time. What becomes of a
// version is decided in versions.cpp; all work on it is done in processes that can be killed: the worker, which renders
// edited shaders, and one for the reference, which stands still while anything else works.
#include "watch/watch.h"

#include <malloc.h>
#include <poll.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "base/text_file.h"
#include "watch/files/followed_settings.h"
#include "watch/files/watched_files.h"
#include "watch/output/kept_versions.h"
#include "watch/output/pictures.h"
#include "watch/process/reference_process.h"
#include "watch/process/renderer_process.h"
#include "watch/versions.h"

namespace turner::watch {
namespace {

// Seconds. poll() overslept by more than this: the process was suspended (SIGSTOP).
constexpr double kOverslept = 0.5;

// In the number of a burst: it is of settings, not of saves.
constexpr uint64_t kOfSettings = uint64_t(1) << 63;

// The reason that the system has.
std::string cannotRead(const std::string& path) try {
  readRegularFile(path);
  return path + ": error: it changed while it was read";
} catch (const InputError& error) {
  return error.what();
}

class Watcher : VersionActions {
 public:
  Watcher(const WatchPlan& plan, WatchListener& listener)
      : plan_(plan),
        listener_(listener),
        files_(plan.scene, plan.shaders),
        renderer_(plan),
        reference_(plan),
        settings_(plan.params),
        versions_(*this, listener, plan.keep.empty() ? 0 : lastKeptVersion(plan.keep)) {
    begin();
  }

  [[noreturn]] void run() try {
    for (;;) {
      plan_.throwIfInterrupted();
      files_.check(now());
      if (files_.isDue(now())) applyChange();
      checkSettings();
      pollRenderer();
      versions_.applyAnswers();
      superviseProcesses();
      waitForEvents();
    }
  } catch (const Interrupted&) {
    renderer_.end();
    reference_.end();
    versions_.stop();
    throw Interrupted("");  // the listener has said it
  }

 private:
  // --- changes --------------------------------------------------------------------------------------------------

  // Cancels what is in work for older files, then begins a version.
  void applyChange() {
    if (!versions_.interrupt(files_.burst())) return;
    if (!renderer_.isPreparing() || files_.isSceneStale()) renderer_.cancel(now(), !files_.isSceneStale());
    versions_.waitForWorker(files_.burst());
    if (!renderer_.isBusy()) begin();
  }

  void begin() {
    Change change;
    change.burst = files_.burst();
    change.savedAt = files_.lastChange();
    change.beganAt = now();
    change.sources = files_.takeUp();
    change.sceneEpoch = files_.sceneEpoch();
    change.unreadable = change.sources[0].text ? overwritten(files_.shaderFiles()) : cannotRead(change.sources[0].path);
    begin(std::move(change));
  }

  void begin(Change change) {
    mayPrepare_ = true;
    settingsChanged_ = false;
    sources_ = change.sources;
    versions_.begin(std::move(change));
  }

  // Values of parameters need no compiler, and do not wait for the time in which saves are joined. A version without a
  // picture is not interrupted for them: whoever turns a value without end shall see what becomes of it.
  void checkSettings() {
    settingsChanged_ |= settings_.check(now());
    if (const std::string fault = settings_.takeFault(); !fault.empty())
      versions_.reportTrouble(versions_.good() ? versions_.good()->version : 0, fault);
    if (!settingsChanged_ || files_.hasChange() || (versions_.isWorking() && !versions_.hasPicture())) return;
    Change change;
    change.burst = kOfSettings | ++settingsBursts_;
    versions_.interrupt(change.burst);
    if (renderer_.isBusy()) {
      if (!renderer_.isPreparing()) renderer_.cancel(now(), true);
      return;
    }
    change.savedAt = settings_.changedAt();
    change.beganAt = now();
    change.sceneEpoch = files_.sceneEpoch();
    // Of sources that were refused the last good ones.
    change.sources = versions_.good() ? versions_.good()->sources : sources_;
    begin(std::move(change));
  }

  // Which output would be written over one of these inputs; empty: none.
  std::string overwritten(const std::vector<std::string>& inputs) const try {
    plan_.refuseOverwriting(inputs);
    return "";
  } catch (const InputError& error) {
    return error.what();
  }

  // --- processes ------------------------------------------------------------------------------------------------

  void pollRenderer() {
    while (std::optional<Message> message = renderer_.poll(now())) {
      if (message->kind == SceneReady::kind) {
        const SceneReady scene = decode<SceneReady>(*message);
        files_.sceneWasLoaded(scene.sceneEpoch, scene.summary.sources);
      }
      // Without a version in work it is of one that was given up, or of a worker that prepares itself.
      if (!renderer_.isPreparing()) versions_.receive(std::move(*message));
    }
    if (versions_.isWorking()) listener_.onProgress(versions_.version(), renderer_.step(), renderer_.share());
  }

  void superviseProcesses() {
    if (const std::optional<Refused> loss = renderer_.takeLoss(now())) versions_.receive(encode(*loss));
    if (isIdle()) {
      if (std::exchange(hasWorked_, false)) {
        if (renderer_.hasGrown()) renderer_.end();
        // Pictures come and go, and the heap keeps their room: of days of editing only the last version shall stay.
        ::malloc_trim(0);
      }
      if (!renderer_.isRunning() && std::exchange(mayPrepare_, false)) submit({.purpose = Purpose::prepare});
    }
    hasWorked_ |= versions_.isWorking();
    superviseReference();
  }

  bool isIdle() const { return !versions_.isWorking() && !renderer_.isBusy() && !files_.hasChange(); }

  // It works while nothing else does.
  void superviseReference() {
    const GoodVersion* good = versions_.good();
    if (!isIdle() || !good || good->sceneEpoch != files_.sceneEpoch()) return reference_.pause();
    std::string fault;
    try {
      reference_.work(good->sceneEpoch);
      if (!reference_.poll(fault)) return;
    } catch (const RunError& error) {
      fault = error.what();
    }
    if (!fault.empty()) return versions_.reportTrouble(good->version, "no reference: " + fault);
    versions_.applyReference();
  }

  // --- for the versions -----------------------------------------------------------------------------------------

  double now() const override { return clock_.seconds(); }
  double quietUntil(uint64_t burst) const override { return burst == files_.burst() ? files_.quietUntil() : 0; }

  void submit(Job job) override {
    job.sceneEpoch = files_.sceneEpoch();
    job.reloadScene = files_.isSceneStale();
    job.parameters = plan_.parameters;
    job.parameters.insert(job.parameters.end(), settings_.settings().begin(), settings_.settings().end());
    try {
      renderer_.give(std::move(job), now());
    } catch (const RunError& error) {
      versions_.receive(encode(Refused{.text = error.what()}));
    }
  }

  std::vector<std::string> show(const Image& image, const SceneReady& scene, bool coarse) override {
    // The files may have changed since the version began.
    if (const std::string fault = overwritten(files_.followed()); !fault.empty()) return {fault};
    return writeOutputs(plan_, image, scene, coarse);
  }
  std::string keep(const GoodVersion& good, const VersionReport& report) override {
    return plan_.keep.empty() ? "" : keepGood(plan_, good, report);
  }
  void keepFigures(const VersionReport& report) override { watch::keepFigures(report.kept, versionReportJson(report)); }
  const Image* reference(uint64_t sceneEpoch) const override { return reference_.image(sceneEpoch); }

  void compilerRead(const std::vector<std::string>& files) override { files_.compilerRead(files); }
  void sceneWasRefused() override { files_.sceneWasRefused(); }
  void forgetTaken() override { files_.forgetTaken(); }

  // --- waiting --------------------------------------------------------------------------------------------------

  // Until something comes, or the next moment at which something is due.
  void waitForEvents() {
    if (versions_.hasAnswersDue()) return;
    double until = std::min(now() + files_.pollMilliseconds() * 1e-3, renderer_.nextDecision());
    const auto wakeAt = [&](double time) {
      if (time > now()) until = std::min(until, time);
    };
    if (files_.hasChange()) {
      wakeAt(files_.lastChange() + kBreath);
      if (versions_.isWorking()) wakeAt(versions_.protectedUntil());
    }
    wakeAt(versions_.nextDecision());
    wakeAt(settings_.nextLook());
    pollfd waits[4];
    nfds_t count = 0;
    const auto waitFor = [&](int descriptor, int events) {
      if (descriptor >= 0) waits[count++] = {descriptor, short(events), 0};
    };
    waitFor(files_.descriptor(), POLLIN);
    waitFor(settings_.descriptor(), POLLIN);
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
  FollowedSettings settings_;
  Versions versions_;
  std::vector<ShaderSource> sources_;  // of the version that began last
  bool settingsChanged_ = false;       // since a version began
  uint64_t settingsBursts_ = 0;
  bool mayPrepare_ = false;  // a worker, for want of one: once after each version
  bool hasWorked_ = false;   // on a version, since the last idle moment
};

}  // namespace

void watch(const WatchPlan& plan, WatchListener& listener) {
  // Whatever is as large as a kernel or a picture goes back to the system when it is freed: glibc begins with this
  // threshold, but would raise it by and by, take such blocks from its heap, and leave holes there.
  ::mallopt(M_MMAP_THRESHOLD, 128 << 10);
  Watcher(plan, listener).run();
}

}  // namespace turner::watch
