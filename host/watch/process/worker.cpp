// Each job reads as its data flow: scene -> packed -> uploaded; sources -> SPIR-V -> checked -> pipeline ->
// coarse picture -> picture -> times -> counts. Every step reports its beginning, so that the watcher knows where a
// silent worker is.
#include "watch/process/worker.h"

#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <memory>
#include <new>
#include <optional>
#include <utility>

#include "base/errors.h"
#include "base/spread.h"
#include "base/stopwatch.h"
#include "base/text_file.h"
#include "gpu/session.h"
#include "kernel/kernel_check.h"
#include "kernel/layout_text.h"
#include "reference/reference.h"
#include "scene/scene_load.h"
#include "watch/diagnosis/loop_probe.h"
#include "watch/process/messages.h"

namespace turner::watch {
namespace {

// Times are compared in turn if a trace is shorter than kShortTrace, for about kTimingSeconds.
constexpr double kShortTrace = 0.5, kTimingSeconds = 2;
constexpr size_t kFewestPairs = 3, kMostPairs = 15;
// Seconds after which the watcher hears of a step again.
constexpr double kHeartbeat = 0.05;

// The watcher has given the job up.
struct GivenUp {};
// The watcher is gone.
struct LineEnded {};

class Worker {
 public:
  Worker(Channel& line, const WatchPlan& plan) : line_(line), plan_(plan), dispatching_(plan.dispatching) {
    dispatching_.compiles = [this] { begin(Step::pipeline); };
  }

  // False: the worker must end.
  bool work(const Job& job) {
    job_ = job.number;
    cancelled_ = false;
    try {
      run(job);
      report(Finished{job_});
      return true;
    } catch (const GivenUp&) {
      report(Finished{job_});
      return true;
    } catch (const LoopsCut& error) {
      refuse(error.what(), {.endless = true});
      return true;
    } catch (const PixelsMissing& error) {
      refuse(error.what(), {.unfinished = true});
      return true;
    } catch (const UntrueKernel& error) {
      refuse(error.what(), {});
      return true;
    } catch (const InputError& error) {
      refuse(error.what(), {.wrongInput = true});
      return true;
    } catch (const RunError& error) {
      refuse(error.what(), {.broken = isOnDevice()});
      return !isOnDevice();
    } catch (const std::bad_alloc&) {
      refuse("out of memory", {.broken = true});
      return false;
    } catch (const std::exception& error) {  // of Vulkan's
      refuse(error.what(), {.broken = true});
      return false;
    }
  }

 private:
  void run(const Job& job) {
    switch (job.purpose) {
      case Purpose::prepare:
        return loadScene(job);
      case Purpose::render:
        loadScene(job);
        return render(job);
      case Purpose::findLoop:
        loadScene(job);
        return findLoop(job);
      case Purpose::reference:
        return renderReferencePicture();
    }
  }

  // --- the scene ---

  Scene loadSceneFile() const {
    Scene scene = turner::loadScene(plan_.scene);
    plan_.refuseOverwriting(filesOf(plan_.scene, scene.sources));
    return scene;
  }

  void loadScene(const Job& job) {
    SceneReady& ready = ready_;
    ready.job = job_;
    ready.sceneEpoch = job.sceneEpoch;
    ready.openSeconds = ready.loadSeconds = ready.buildSeconds = ready.uploadSeconds = 0;
    Stopwatch watch;
    if (!session_) {
      begin(Step::open);
      session_ = std::make_unique<RenderSession>(plan_.chooseDevice(), plan_.access, dispatching_);
      const DeviceInfo& device = session_->device();
      ready.device = device.name;
      ready.driver = device.driver;
      ready.deviceType = device.type;
      ready.openSeconds = watch.lap();
    }
    if (job.reloadScene || !hasScene_) {
      hasScene_ = false;
      begin(Step::scene);
      Scene scene = loadSceneFile();
      ready.settings = plan_.settingsOf(scene);
      ready.summary = {};
      ready.summary.name = scene.name;
      ready.summary.camera = scene.camera;
      ready.summary.sources = scene.sources;
      ready.summary.notes = scene.notes;
      sceneParameters_ = scene.parameters;
      ready.primitives = scene.primitiveCounts();
      ready.loadSeconds = watch.lap();
      session_->prepare(std::move(scene), ready.settings);
      ready.access = accessName(session_->access());
      session_->upload();
      if (!session_->note().empty()) ready.summary.notes.push_back(session_->note());
      ready.buildSeconds = session_->seconds().build;
      ready.uploadSeconds = session_->seconds().upload;
      hasScene_ = true;
    }
    report(ready);
  }

  // --- the kernel ---

  // All versions alike, so that their times tell what an edit costs.
  Kernel compile(const std::vector<ShaderSource>& sources) {
    begin(Step::compile);
    return session_->compile(sources, KernelForm::edited);
  }

  // The kernel of a version, compiled and checked: of one whose values alone have changed, the one at hand.
  const Kernel& kernelOf(const Job& job, double& checkSeconds) {
    const bool isSame = compiledFor_ == session_->access() &&
                        std::equal(sources_.begin(), sources_.end(), job.sources.begin(), job.sources.end(),
                                   [](const ShaderSource& a, const ShaderSource& b) {
                                     return a.name == b.name && a.path == b.path && a.text == b.text;
                                   });
    if (isSame) {
      kernel_.glslangSeconds = kernel_.optimiserSeconds = 0;
      return kernel_;
    }
    compiledFor_.reset();
    kernel_ = compile(job.sources);
    stopIfCancelled();
    Stopwatch watch;
    begin(Step::check);
    checkLayout(job.sources);
    if (kernel_.words != job.goodWords) checkKernel(kernel_, job.sources, session_->access());
    checkSeconds = watch.lap();
    // What the compiler found elsewhere may change on its own.
    const bool hasAll = std::all_of(kernel_.files.begin(), kernel_.files.end(), [&](const std::string& file) {
      return std::any_of(job.sources.begin(), job.sources.end(),
                         [&](const ShaderSource& source) { return source.path == file; });
    });
    sources_ = job.sources;
    if (hasAll) compiledFor_ = session_->access();
    return kernel_;
  }

  void render(const Job& job) {
    Compiled compiled;
    compiled.job = job_;
    const Kernel& kernel = kernelOf(job, compiled.checkSeconds);
    begin(Step::check);
    std::vector<Parameter> parameters = kernel.parameters;
    std::vector<ParameterSetting> set = sceneParameters_;
    set.insert(set.end(), job.parameters.begin(), job.parameters.end());
    setParameters(parameters, set);
    compiled.parameters = parameters;
    compiled.words = kernel.words;
    compiled.files = kernel.files;
    compiled.warnings = kernel.warnings;
    compiled.glslangSeconds = kernel.glslangSeconds;
    compiled.optimiserSeconds = kernel.optimiserSeconds;
    const bool sameWords = job.goodHasScene && job.goodWords == kernel.words;
    compiled.sameAsGood = sameWords && job.goodParameters == compiled.parameters;
    report(compiled);
    if (compiled.sameAsGood) return;

    const RenderSettings settings = settings_ = RenderSession::withParameters(ready_.settings, parameters);
    session_->addFeaturesOf(kernel);
    // Of values that are turned by hand the full picture is there as soon.
    if (!sameWords || job.goodTrace > kShortTrace) {
      ShaderPicture coarse = session_->renderCoarse(kernel, settings, kCoarseStride, progressOf(Step::coarse));
      throwIfInvalid();
      reportPicture(true, std::move(coarse));
    }
    ShaderPicture picture = session_->render(kernel, settings, progressOf(Step::picture));
    throwIfInvalid();
    const bool isShort = picture.traceSeconds < kShortTrace;
    reportPicture(false, std::move(picture));

    // The picture is there; what follows is about it. Values come and go too fast for that.
    if (sameWords) return;
    if (job.goodHasScene && !job.goodWords.empty() && isShort)
      compareTimes({.words = job.goodWords, .edited = true}, kernel, job.goodAdded);
    const Visits visits = session_->countVisits(kernel, settings, progressOf(Step::counting));
    throwIfInvalid();
    report(Counted{job_, visits.rays});
  }

  void reportPicture(bool coarse, ShaderPicture picture) {
    const ConstantSet added = session_->addedFeatures();
    report(Picture{job_, coarse, std::move(picture.image), picture.compileSeconds, picture.traceSeconds,
                   picture.readbackSeconds, added, featureLines(added, session_->features(), ready_.settings)});
  }

  // A kernel with some of the features that were added.
  struct TimedKernel {
    const Spirv& spirv;
    ConstantSet added;
  };

  // Both kernels with what the edited one needs; what that costs the good one is measured by itself.
  void compareTimes(const Spirv& good, const Spirv& edited, ConstantSet goodAdded) {
    const ConstantSet added = session_->addedFeatures();
    Timing timing = timeInTurn({good, added}, {edited, added}, kTimingSeconds);
    if (added != goodAdded) timing.featuresRatio = timeInTurn({good, goodAdded}, {good, added}, 0).ratio;
    session_->setAddedFeatures(added);
    report(timing);
  }

  // In turn, so that whatever else the machine does meets both; and each is first in turn.
  Timing timeInTurn(const TimedKernel& a, const TimedKernel& b, double seconds) {
    const Stopwatch watch;
    std::vector<double> before, after, ratios;
    const auto trace = [&](const TimedKernel& kernel, std::vector<double>& times) {
      session_->setAddedFeatures(kernel.added);
      times.push_back(session_->render(kernel.spirv, settings_, progressOf(Step::timing)).traceSeconds);
    };
    // An odd number, so that one of the pairs is the median.
    while (ratios.size() < kFewestPairs || ratios.size() % 2 == 0 ||
           (ratios.size() < kMostPairs && watch.seconds() < seconds)) {
      const bool aFirst = ratios.size() % 2 == 0;
      trace(aFirst ? a : b, aFirst ? before : after);
      trace(aFirst ? b : a, aFirst ? after : before);
      ratios.push_back(after.back() / before.back());
    }
    const Spread ratio = spreadOf(ratios);
    return {job_,        int(ratios.size()), spreadOf(before).median, spreadOf(after).median, ratio.median,
            ratio.least, ratio.most};
  }

  // A kernel that counts its loops' turns ends, and reports which of them had too many.
  void findLoop(const Job& job) {
    const LoopProbe probe = probeLoops(job.sources);
    const Kernel kernel = compile(probe.sources);
    session_->addFeaturesOf(kernel);
    const uint32_t budget = job.hung ? kLongProbeBudget : kProbeBudget;
    try {
      session_->renderCoarse(kernel, ready_.settings, kCoarseStride, progressOf(Step::probe), budget);
    } catch (const PixelsMissing&) {
      // No loop made too many turns.
    } catch (const LoopsCut& cut) {
      if (const std::optional<SourceLocation> location = endlessLoop(probe, cut.count))
        report(LoopFound{job_, location->path, location->line, location->column});
    }
  }

  // --- the reference ---

  void renderReferencePicture() {
    ::setpriority(PRIO_PROCESS, 0, 19);  // whoever edits comes first
    begin(Step::scene);
    const Scene scene = loadSceneFile();
    const RenderSettings settings = plan_.settingsOf(scene);
    ReferencePicture picture = renderReference(plan_.referenceGeometry(scene), settings, progressOf(Step::picture));
    report(Picture{job_, false, std::move(picture.image), 0, picture.traceSeconds, 0, 0, {}});
  }

  // --- the line ---

  template <class Value>
  void report(const Value& value) {
    if (!send(line_, value)) throw LineEnded();
  }

  void begin(Step step) {
    stopIfCancelled();
    step_ = step;
    report(Advance{job_, step, 0});
  }

  void refuse(const std::string& text, Refused refused) {
    refused.job = job_;
    refused.step = step_;
    refused.text = text;
    report(refused);
  }

  // What a failure now says of the device.
  bool isOnDevice() const { return step_ != Step::open && step_ != Step::compile && step_ != Step::check; }

  void stopIfCancelled() {
    while (const std::optional<Message> message = line_.receive())
      if (message->kind == Cancel::kind) cancelled_ = decode<Cancel>(*message).job == job_;
    if (line_.isFinished()) throw LineEnded();
    if (cancelled_) throw GivenUp();
  }

  Progress progressOf(Step step) {
    return [this, step, sinceReport = Stopwatch()](double share) mutable {
      stopIfCancelled();
      if (step_ == step && sinceReport.seconds() < kHeartbeat) return;
      step_ = step;
      sinceReport.lap();
      report(Advance{job_, step, share});
    };
  }

  Channel& line_;
  const WatchPlan& plan_;
  Dispatching dispatching_;
  std::unique_ptr<RenderSession> session_;
  SceneReady ready_;
  std::vector<ParameterSetting> sceneParameters_;
  RenderSettings settings_;  // of the version in work, with its parameters
  // The kernel that was compiled last, of what, and for which way of fetching: none if it may not serve again.
  Kernel kernel_;
  std::vector<ShaderSource> sources_;
  std::optional<BufferAccess> compiledFor_;
  bool hasScene_ = false;  // on the device
  uint64_t job_ = 0;
  Step step_ = Step::open;
  bool cancelled_ = false;
};

}  // namespace

void workForWatcher(Channel& line, const WatchPlan& plan) {
  // Unlike the watcher's, its heap keeps what it has once got, as glibc has it by default: compilers
  // take and free large blocks all the time.
  ::mallopt(M_MMAP_THRESHOLD, 32 << 20);
  ::mallopt(M_TRIM_THRESHOLD, 64 << 20);
  refusePipes();  // at which it would wait without an end
  Worker worker(line, plan);
  try {
    while (const std::optional<Message> message = line.wait())
      if (message->kind == Job::kind && !worker.work(decode<Job>(*message))) return;
  } catch (const LineEnded&) {
    // The watcher has ended; so does this.
  }
}

}  // namespace turner::watch
