// One loop that waits for three things: files that change, answers of the worker, and the time. What a version comes to
// is decided here; all work on it is done in processes that can be killed: the worker, which renders edited shaders,
// and one for the reference, which stands still while the worker works.
#include "watch/watch.h"

#include <fmt/format.h>
#include <malloc.h>
#include <poll.h>

#include <algorithm>
#include <climits>
#include <cmath>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "cores.h"
#include "errors.h"
#include "picture/provenance.h"
#include "scene/text_file.h"
#include "stopwatch.h"
#include "watch/child.h"
#include "watch/file_watch.h"
#include "watch/kept_versions.h"
#include "watch/source_change.h"
#include "watch/worker.h"

namespace turner {
namespace {

namespace fs = std::filesystem;

// Seconds. Several saves within kQuiet of each other are one version; work on it begins before, after kBreath, which
// joins the steps of one save (delete, write, rename), and is shown when it has been quiet for long enough. Who saves
// without end is heard after kLongest.
constexpr double kBreath = 0.02, kQuiet = 0.2, kLongest = 2;
// A coarse picture is not worth showing where the full one follows so soon after that quiet time.
constexpr double kSoon = 0.1;
// A worker that was asked to give up gets this long, or as long as a new one needs to be as far with the scene.
constexpr double kPatience = 0.3, kMostPatience = 10;
// Compilers, glslang and the driver's, and the opening of a device may take longer than a piece of the picture.
constexpr double kCompilers = 60;
constexpr double kOverslept = 0.5;
constexpr double kNever = 1e18;
// Drivers and compilers keep a little of all that they have compiled (lavapipe 22.3: 0.2 MB of each kernel). A worker
// that has grown by this factor since its kSettled-th version, when its pipelines were all there, makes room for a new
// one.
constexpr double kMostGrowth = 1.02;
constexpr int kSettled = 8;

const char* stepWords(Step step) {
  switch (step) {
    case Step::open:
      return "opening the device";
    case Step::scene:
      return "loading the scene";
    case Step::compile:
      return "compiling";
    case Step::check:
      return "checking the SPIR-V";
    case Step::pipeline:
      return "compiling in the driver";
    case Step::coarse:
    case Step::picture:
      return "rendering";
    case Step::timing:
      return "timing";
    case Step::counting:
      return "counting rays";
    case Step::probe:
      return "looking for the loop";
  }
  return "";
}

// Whether the step runs the kernel that was edited.
bool runsKernel(Step step) {
  return step == Step::coarse || step == Step::picture || step == Step::timing || step == Step::counting ||
         step == Step::probe;
}

std::string placedError(const SourcePlace& place, const std::string& message) {
  return fmt::format("{}:{}:{}: error: {}", place.path, place.line, place.column, message);
}

// A version whose picture is good.
struct Good {
  int version = 0;
  uint64_t sceneEpoch = 0;
  std::vector<ShaderSource> sources;
  std::vector<uint32_t> words;
  SceneReady scene;
  Image image;
  Consequences told;
};

// A version on its way.
struct Attempt {
  int version = 0;
  uint64_t sceneEpoch = 0;
  bool reloadsScene = false;
  double savedAt = 0;
  std::vector<ShaderSource> sources;
  std::deque<Message> answers;     // of the worker, that are not yet looked at
  std::optional<Refused> refused;  // the loop is being looked for
  std::optional<SourcePlace> loop;
  Consequences told;
  std::vector<uint32_t> words;
  double coarseAt = kNever;  // when the coarse picture came
  bool hasPicture = false;   // it is the last good version now
};

class Watching {
 public:
  Watching(const WatchPlan& plan, WatchListener& listener) : plan_(plan), listener_(listener) {
    if (!plan.keep.empty()) lastVersion_ = lastKeptVersion(plan.keep);
    followFiles();
    startWorker();
    begin();
  }

  [[noreturn]] void run() try {
    for (;;) {
      plan_.throwIfInterrupted();
      noteChanges();
      if (changePending_ && now() >= lastChange_ + kBreath) takeUpChange();
      hearWorker();
      if (attempt_ && now() >= quietUntil()) lookAtAnswers();
      endIfStuck();
      careForReference();
      giveMemoryBack();
      rest();
    }
  } catch (const Interrupted&) {
    worker_.reset();
    reference_.reset();
    if (good_ && shown_ != good_->version) show(good_->image, good_->scene, good_->version, false);
    listener_.onStop(good_ ? std::optional(good_->version) : std::nullopt);
    throw Interrupted("interrupted; watching has ended");
  }

 private:
  double now() const { return clock_.seconds(); }

  // --- files ----------------------------------------------------------------------------------------------------

  std::string kernelPath() const { return plan_.shaders + "/whitted.comp"; }

  // The scene's file and its meshes, as far as they are known.
  std::vector<std::string> filesOfScene() const {
    std::vector<std::string> files = {plan_.scene};
    files.insert(files.end(), meshes_.begin(), meshes_.end());
    return files;
  }

  void followFiles() {
    std::vector<std::string> files = filesOfScene();
    files.push_back(kernelPath());
    for (const ShaderSource& source : lastSources_) files.push_back(source.path);
    files.insert(files.end(), lastFiles_.begin(), lastFiles_.end());
    files_.follow(files);
  }

  std::string besideScene(const std::string& file) const {
    return (fs::path(plan_.scene).parent_path() / file).string();
  }

  // Of a scene that cannot be loaded the meshes are not known, and one that is missing may be why: whatever its text
  // calls a "file" is taken for one.
  void followNamedMeshes() try {
    const std::string text = readSource(plan_.scene);
    constexpr std::string_view kKey = "\"file\"";
    for (size_t at = text.find(kKey); at != std::string::npos; at = text.find(kKey, at + 1)) {
      const size_t begin = text.find_first_not_of(" \t\r\n:", at + kKey.size());
      if (begin == std::string::npos || text[begin] != '"') continue;
      const std::string name =
          text.substr(begin + 1, std::min<size_t>(text.find('"', begin + 1) - begin - 1, PATH_MAX));
      const std::string mesh = besideScene(name);
      if (std::find(meshes_.begin(), meshes_.end(), mesh) == meshes_.end()) meshes_.push_back(mesh);
    }
    followFiles();
  } catch (const InputError&) {
    // Then its own return is what is waited for.
  }

  void noteChanges() {
    const std::vector<std::string> changes = files_.takeChanges();
    if (changes.empty()) return;
    lastChange_ = now();
    if (!changePending_) firstChange_ = lastChange_;
    changePending_ = true;
    const std::vector<std::string> sceneFiles = filesOfScene();
    for (const std::string& file : changes) {
      const bool isSource = std::any_of(lastSources_.begin(), lastSources_.end(),
                                        [&](const ShaderSource& source) { return source.path == file; });
      if (std::find(sceneFiles.begin(), sceneFiles.end(), file) != sceneFiles.end()) {
        if (!sceneStale_ && isAsLoaded(file)) continue;
        sceneStale_ = true;
        ++sceneEpoch_;
      } else if (!isSource) {
        sourcesStale_ = true;  // an include that only the compiler finds
      }
    }
  }

  // Whether a file of the scene was saved without a change. To read a larger one would take longer than to be wrong.
  bool isAsLoaded(const std::string& file) const try {
    constexpr uintmax_t kMostBytes = 16 << 20;
    std::error_code ignored;
    if (!fs::is_regular_file(file, ignored) || fs::file_size(file, ignored) > kMostBytes) return false;
    const std::string now = sha256Hex(readTextFile(file));
    for (size_t i = 0; i < sceneSources_.size(); ++i)
      if (file == (i == 0 ? plan_.scene : besideScene(sceneSources_[i].path))) return now == sceneSources_[i].sha256;
    return false;
  } catch (const InputError&) {
    return false;
  }

  double quietUntil() const { return std::min(lastChange_ + kQuiet, firstChange_ + kLongest); }

  // --- versions -------------------------------------------------------------------------------------------------

  // The sources as they are now. Without the kernel itself there is one source without text.
  std::vector<ShaderSource> readSources() const try {
    return readShaderSources(kernelPath());
  } catch (const InputError&) {
    return {{"", kernelPath(), std::nullopt}};
  }

  static bool sameTexts(const std::vector<ShaderSource>& a, const std::vector<ShaderSource>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const ShaderSource& x, const ShaderSource& y) {
      return x.path == y.path && x.text == y.text;
    });
  }

  // Files have changed: gives up what is in work for older ones, then begins.
  void takeUpChange() {
    if (!sceneStale_ && !sourcesStale_ && sameTexts(readSources(), lastSources_)) {
      changePending_ = false;  // saved without a change
      return;
    }
    if (attempt_) {
      // Before its results could be seen it is the same version.
      if (now() < attemptQuietAt_ && !attempt_->hasPicture)
        repeatsVersion_ = true;
      else if (attempt_->hasPicture)
        conclude();
      else
        listener_.onSuperseded(attempt_->version);
      attempt_.reset();
    }
    if (busy_ && busyWith_ != Purpose::prepare && cancelledAt_ == kNever) {
      cancelledAt_ = now();
      post(worker_->line(), Cancel{job_});
    }
    if (!busy_) begin();
  }

  void begin() {
    changePending_ = false;
    if (!worker_) startWorker();
    Attempt& attempt = attempt_.emplace();
    if (!std::exchange(repeatsVersion_, false)) ++lastVersion_;
    attempt.version = lastVersion_;
    attempt.savedAt = lastChange_;
    attemptQuietAt_ = quietUntil();
    attempt.sceneEpoch = sceneEpoch_;
    attempt.reloadsScene = sceneStale_;
    sourcesStale_ = false;
    // Followed, then read: no change falls between.
    lastSources_ = readSources();
    followFiles();
    attempt.sources = lastSources_ = readSources();
    Consequences& told = attempt.told;
    told.version = attempt.version;
    if (good_) {
      told.lastGood = good_->version;
      told.changed = changedFiles(good_->sources, attempt.sources);
      told.sceneChanged = good_->sceneEpoch != sceneEpoch_;
    }
    // A kernel that cannot be read never comes to the worker.
    if (!attempt.sources[0].text) {
      Refused refused;
      refused.step = Step::compile;
      refused.wrongInput = true;
      refused.text = cannotRead(kernelPath());
      attempt.answers.push_back(encode(refused));
      return;
    }
    Job job;
    job.purpose = Purpose::render;
    job.reloadScene = sceneStale_;
    job.sources = attempt.sources;
    if (good_) job.goodWords = good_->words;
    job.goodHasScene = good_ && good_->sceneEpoch == sceneEpoch_;
    give(job);
  }

  // The reason that the system has.
  static std::string cannotRead(const std::string& path) try {
    readSource(path);
    return path + ": error: it changed while it was read";
  } catch (const InputError& error) {
    return error.what();
  }

  // --- the worker -----------------------------------------------------------------------------------------------

  void startWorker() {
    worker_ = std::make_unique<Child>([&plan = plan_](Channel& line) { workForWatcher(line, plan); });
    busy_ = false;
    workerVersions_ = 0;
  }

  void give(Job job) {
    job.number = ++job_;
    busy_ = true;
    busyWith_ = job.purpose;
    cancelledAt_ = kNever;
    step_ = Step::open;
    share_ = 0;
    lastAdvance_ = now();
    post(worker_->line(), job);
  }

  // A new one, as far with the scene as the last.
  void replaceWorker() {
    worker_.reset();
    startWorker();
    Job job;
    job.purpose = Purpose::prepare;
    give(job);
  }

  void hearWorker() {
    if (!worker_) return;
    worker_->line().sendRest();
    while (std::optional<Message> message = worker_->line().receive()) {
      if (message->kind == Advance::kind) {
        hear(decode<Advance>(*message));
        continue;
      }
      lastAdvance_ = now();
      const uint64_t job = decode<uint64_t>(Message{0, message->bytes.substr(0, sizeof(uint64_t))});
      const bool ends = message->kind == Finished::kind || message->kind == Refused::kind;
      if (job != job_) continue;
      if (ends) busy_ = false;
      if (attempt_ && busyWith_ != Purpose::prepare) {
        if (message->kind == Picture::kind && attempt_->coarseAt == kNever) attempt_->coarseAt = now();
        attempt_->answers.push_back(std::move(*message));
      } else if (message->kind == Refused::kind && decode<Refused>(*message).broken)
        worker_.reset();
      if (!worker_) return;
    }
  }

  void hear(const Advance& advance) {
    if (advance.job != job_) return;
    if (advance.step != step_ || advance.share > share_) lastAdvance_ = now();
    step_ = advance.step;
    share_ = advance.share;
    if (attempt_) listener_.onProgress(attempt_->version, step_, share_);
  }

  // A worker that has died, hangs, or does not give up what is no longer wanted.
  void endIfStuck() {
    if (!worker_) return;
    if (worker_->line().isOver()) {
      if (attempt_ && now() < quietUntil()) return;
      const bool wasBusy = busy_;
      const std::string end = worker_->end();
      const Purpose purpose = busyWith_;
      worker_.reset();
      busy_ = false;
      if (!wasBusy || cancelledAt_ != kNever || purpose == Purpose::prepare) return;
      return workerDied("the renderer " + end);
    }
    if (!busy_) return;
    if (now() > cancelledAt_ + std::clamp(restartSeconds_, kPatience, kMostPatience)) return replaceWorker();
    const double limit = runsKernel(step_)      ? plan_.timeout
                         : step_ == Step::scene ? kNever
                                                : std::max(kCompilers, plan_.timeout);
    const auto isLate = [&] { return busy_ && now() >= lastAdvance_ + limit && cancelledAt_ == kNever; };
    if (!isLate()) return;
    hearWorker();  // it may be this process that was late
    if (!isLate()) return;
    worker_.reset();
    busy_ = false;
    workerDied("");
  }

  // `end` says how, empty: it was killed because it hung.
  void workerDied(const std::string& end) {
    if (!attempt_) return replaceWorker();
    lookAtAnswers();  // what it said before
    if (!attempt_) return replaceWorker();
    if (attempt_->refused) {
      // It was looking for the loop.
      replaceWorker();
      return refuse(attempt_->refused->step, attempt_->refused->text, true);
    }
    Refused refused;
    refused.step = step_;
    refused.endless = end.empty() && runsKernel(step_);
    refused.text = !end.empty() ? fmt::format("{} while {}", end, stepWords(step_))
                   : refused.endless
                       ? fmt::format("no piece of the work ended within {:g} s (--timeout)", plan_.timeout)
                       : fmt::format("{} took more than {:g} s", stepWords(step_), std::max(kCompilers, plan_.timeout));
    startWorker();
    if (refused.endless) return lookForLoop(refused, true);
    Job job;
    job.purpose = Purpose::prepare;
    give(job);
    refuse(refused.step, refused.text, true);
  }

  void lookForLoop(const Refused& refused, bool hung) {
    attempt_->refused = refused;
    Job job;
    job.hung = hung;
    job.purpose = Purpose::findLoop;
    job.sources = attempt_->sources;
    give(job);
  }

  // --- answers --------------------------------------------------------------------------------------------------

  void lookAtAnswers() {
    while (attempt_ && !attempt_->answers.empty() && !awaitsFullPicture()) {
      const Message message = std::move(attempt_->answers.front());
      attempt_->answers.pop_front();
      switch (message.kind) {
        case SceneReady::kind:
          look(decode<SceneReady>(message));
          break;
        case Compiled::kind:
          look(decode<Compiled>(message));
          break;
        case Picture::kind:
          look(decode<Picture>(message));
          break;
        case Timing::kind:
          attempt_->told.timing = decode<Timing>(message);
          break;
        case Counted::kind:
          attempt_->told.rays = decode<Counted>(message).rays;
          break;
        case LoopFound::kind: {
          const LoopFound found = decode<LoopFound>(message);
          attempt_->loop = SourcePlace{found.path, found.line, found.column};
          break;
        }
        case Finished::kind:
          if (attempt_->refused)
            refuse(attempt_->refused->step, attempt_->refused->text, true);
          else
            conclude();
          break;
        case Refused::kind:
          look(decode<Refused>(message));
          break;
      }
    }
  }

  bool hasPictureIn(std::deque<Message>::const_iterator from) const {
    return std::any_of(from, attempt_->answers.end(),
                       [](const Message& answer) { return answer.kind == Picture::kind; });
  }

  // Whether next is a coarse picture of a scene that renders in a blink.
  bool awaitsFullPicture() const {
    const auto first = attempt_->answers.begin();
    const double soon = quietUntil() + kSoon;
    return good_ && first->kind == Picture::kind && now() < soon && attempt_->coarseAt + good_->told.trace < soon &&
           !hasPictureIn(first + 1);
  }

  void look(const SceneReady& scene) {
    if (attempt_->refused) return;  // only to look for its loop
    // Later changes keep it stale.
    if (attempt_->sceneEpoch == sceneEpoch_) sceneStale_ = false;
    attempt_->told.scene = scene;
    restartSeconds_ = std::max(restartSeconds_, scene.openSeconds + scene.loadSeconds + scene.buildSeconds);
    sceneSources_ = scene.told.sources;
    meshes_.clear();
    for (size_t i = 1; i < scene.told.sources.size(); ++i) meshes_.push_back(besideScene(scene.told.sources[i].path));
    followFiles();
    if (!good_ || attempt_->told.sceneChanged) listener_.onScene(scene);
  }

  void look(const Compiled& compiled) {
    Consequences& told = attempt_->told;
    told.glslang = compiled.glslangSeconds;
    told.optimiser = compiled.optimiserSeconds;
    told.check = compiled.checkSeconds;
    told.code = compareInstructions(good_ ? good_->words : std::vector<uint32_t>(), compiled.words);
    attempt_->words = compiled.words;
    lastFiles_ = compiled.files;
    followFiles();
    if (!compiled.sameAsGood) return;
    told.sameCode = true;
    told.rays = good_->told.rays;
    told.trace = good_->told.trace;
    takePicture(good_->image);
  }

  void look(Picture picture) {
    Consequences& told = attempt_->told;
    told.pipeline += picture.pipelineSeconds;
    if (picture.coarse) {
      if (hasPictureIn(attempt_->answers.begin())) return;  // the full one
      show(picture.image, told.scene, attempt_->version, true);
      told.toCoarse = now() - attempt_->savedAt;
      listener_.onCoarse(attempt_->version, *told.toCoarse);
      return;
    }
    told.trace = picture.traceSeconds;
    told.readback = picture.readbackSeconds;
    takePicture(std::move(picture.image));
  }

  // The attempt is the last good version from here on.
  void takePicture(Image image) {
    Attempt& attempt = *attempt_;
    Consequences& told = attempt.told;
    show(image, told.scene, attempt.version, false);
    told.toPicture = now() - attempt.savedAt;
    listener_.onPicture(attempt.version, told.toPicture, told.changed);
    if (good_) {
      if (good_->image.window == image.window && good_->image.width == image.width &&
          good_->image.height == image.height)
        told.toLastGood = compareImages(image, good_->image, kChanged);
      if (good_->sceneEpoch == attempt.sceneEpoch) told.lastGoodTrace = good_->told.trace;
      told.lastGoodRays = good_->told.rays;
    }
    Good& good = good_.emplace();
    good.version = attempt.version;
    good.sceneEpoch = attempt.sceneEpoch;
    good.sources = attempt.sources;
    good.words = attempt.words;
    good.scene = told.scene;
    good.image = std::move(image);
    if (hasReference()) told.toReference = compareImages(good.image, *referenceImage_, kChanged);
    good.told = told;
    attempt.hasPicture = true;
  }

  // All that there will be is known of the version.
  void conclude() {
    Consequences& told = attempt_->told;
    if (hasReference() && !told.toReference) told.toReference = compareImages(good_->image, *referenceImage_, kChanged);
    if (!plan_.keep.empty()) keep(told);
    good_->told = told;
    listener_.onVersion(told);
    attempt_.reset();
    if (worker_ && !busy_) renewIfGrown();
  }

  void renewIfGrown() {
    const size_t bytes = worker_->residentBytes();
    if (++workerVersions_ == kSettled) settledBytes_ = bytes;
    if (workerVersions_ > kSettled && double(bytes) > kMostGrowth * double(settledBytes_)) replaceWorker();
  }

  void look(const Refused& refused) {
    if (attempt_->refused) return refuse(attempt_->refused->step, attempt_->refused->text, true);
    if (refused.broken) worker_.reset();
    if ((refused.endless || refused.unfinished) && worker_) return lookForLoop(refused, false);
    // What no edit can mend.
    if (!good_ && refused.step == Step::open) {
      if (refused.wrongInput) throw InputError(refused.text);
      throw RunError(refused.text);
    }
    refuse(refused.step, refused.text, !refused.wrongInput);
    if (!worker_) replaceWorker();
  }

  // Ends the attempt without a picture; or without all figures, if it has one. `needsPlace`: the text names none.
  void refuse(Step step, std::string text, bool needsPlace) {
    Attempt& attempt = *attempt_;
    const bool endless = attempt.loop || (attempt.refused && attempt.refused->endless);
    if (endless) text = "endless loop: " + text;
    if (needsPlace && text.find(": error: ") == std::string::npos) {
      std::optional<SourcePlace> place = attempt.loop;
      if (place)
        text += "; this loop made too many turns";
      else if (good_ && !attempt.hasPicture && (place = likelyPlace(good_->sources, attempt.sources)))
        text += "; likely by what was changed here";
      if (place) text = placedError(*place, text);
    }
    const std::vector<Diagnosis> diagnoses = readDiagnoses(text, attempt.sources);
    if (step == Step::scene) followNamedMeshes();
    if (attempt.hasPicture) {
      listener_.onTrouble(attempt.version, diagnoses);
      return conclude();
    }
    // A coarse picture of what is refused does not stay.
    if (good_ && shown_ != good_->version) show(good_->image, good_->scene, good_->version, false);
    Refusal refusal;
    refusal.version = attempt.version;
    if (good_) refusal.lastGood = good_->version;
    refusal.seconds = now() - attempt.savedAt;
    refusal.step = step;
    refusal.endless = endless;
    refusal.diagnoses = diagnoses;
    attempt_.reset();
    listener_.onRefused(refusal);
  }

  // --- pictures -------------------------------------------------------------------------------------------------

  Provenance provenanceOf(const SceneReady& scene) const {
    return makeProvenance(scene.told, scene.settings, "--backend shader --geometry rounded", scene.device,
                          scene.driver);
  }

  void show(const Image& image, const SceneReady& scene, int version, bool coarse) {
    Provenance provenance = provenanceOf(scene);
    if (coarse) provenance.strings.emplace_back("turner:coarse", std::to_string(kCoarseStride));
    shown_ = coarse ? -version : version;
    std::vector<std::string> faults(plan_.outputs.size());
    onAllCores(plan_.outputs.size(), [&](size_t i) {
      try {
        plan_.writePicture(plan_.outputs[i], image, provenance);
      } catch (const std::runtime_error& error) {
        faults[i] = error.what();
      }
    });
    for (const std::string& fault : faults) {
      if (fault.empty()) continue;
      shown_ = 0;
      if (!coarse) listener_.onTrouble(version, readDiagnoses(fault, {}));
    }
  }

  void keep(Consequences& told) {
    KeptVersion version;
    version.sources = good_->sources;
    version.picture = encodeExr(good_->image, provenanceOf(good_->scene));
    try {
      version.sceneText = readTextFile(plan_.scene);
      // What was changed since is no part of this version.
      if (sha256Hex(version.sceneText) == good_->scene.told.sources.at(0).sha256)
        version.sceneName = fs::path(plan_.scene).filename().string();
      version.figures = figuresJson(told);
      told.kept = keepVersion(plan_.keep, told.version, version);
    } catch (const std::runtime_error& error) {
      listener_.onTrouble(told.version, readDiagnoses(error.what(), {}));
    }
  }

  static std::string figuresJson(const Consequences& told) {
    JsonText json;
    json.object([&] { putConsequences(json, told); });
    return json.text();
  }

  // --- the reference --------------------------------------------------------------------------------------------

  bool hasReference() const {
    return good_ && referenceImage_ && referenceEpoch_ == good_->sceneEpoch &&
           referenceImage_->window == good_->image.window && referenceImage_->width == good_->image.width &&
           referenceImage_->height == good_->image.height;
  }

  bool isIdle() const { return !busy_ && !attempt_ && !changePending_; }

  // It works while nothing else does, until the scene changes.
  void careForReference() {
    if (reference_ && referenceEpoch_ != sceneEpoch_) reference_.reset();
    const bool idle = isIdle();
    if (reference_) {
      if (!idle) return reference_->pause();
      reference_->goOn();
      return hearReference();
    }
    if (!idle || !good_ || good_->sceneEpoch != sceneEpoch_ || referenceEpoch_ == sceneEpoch_) return;
    referenceImage_.reset();
    referenceEpoch_ = sceneEpoch_;
    reference_ = std::make_unique<Child>([&plan = plan_](Channel& line) { workForWatcher(line, plan); });
    Job job;
    job.purpose = Purpose::reference;
    post(reference_->line(), job);
  }

  void hearReference() {
    while (const std::optional<Message> message = reference_->line().receive()) {
      if (message->kind == Refused::kind) {
        listener_.onTrouble(good_->version, readDiagnoses("no reference: " + decode<Refused>(*message).text, {}));
        return reference_.reset();
      }
      if (message->kind != Picture::kind) continue;
      referenceImage_ = decode<Picture>(*message).image;
      reference_.reset();
      if (!hasReference()) return;
      const Comparison comparison = compareImages(good_->image, *referenceImage_, kChanged);
      good_->told.toReference = comparison;
      listener_.onReference(good_->version, comparison);
      if (!good_->told.kept.empty()) try {
          keepFigures(good_->told.kept, figuresJson(good_->told));
        } catch (const RunError& error) {
          listener_.onTrouble(good_->version, readDiagnoses(error.what(), {}));
        }
      return;
    }
    if (!reference_->line().isOver()) return;
    listener_.onTrouble(good_->version, readDiagnoses("no reference: its process " + reference_->end(), {}));
    reference_.reset();
  }

  // Pictures come and go, and the heap keeps their room: of days of editing nothing shall stay but the last version.
  void giveMemoryBack() {
    if (attempt_.has_value() == std::exchange(hadAttempt_, attempt_.has_value()) || attempt_) return;
    ::malloc_trim(0);
  }

  // --- waiting --------------------------------------------------------------------------------------------------

  // Until something comes, or the next moment at which something is due.
  void rest() {
    double until = now() + files_.pollMilliseconds() * 1e-3;
    const auto wakeAt = [&](double time) {
      if (time > now()) until = std::min(until, time);
    };
    if (changePending_) wakeAt(lastChange_ + kBreath);
    if (changePending_ && !busy_) until = std::min(until, lastChange_ + kBreath);
    const bool holds = attempt_ && now() < quietUntil();
    if (holds) wakeAt(quietUntil());
    if (attempt_ && !holds && !attempt_->answers.empty()) {
      if (!awaitsFullPicture()) return;
      wakeAt(quietUntil() + kSoon);
    }
    if (busy_) {
      until = std::min(until, now() + 0.25);  // whether it is stuck
      wakeAt(cancelledAt_ + std::clamp(restartSeconds_, kPatience, kMostPatience));
    }
    pollfd waits[3];
    nfds_t count = 0;
    if (files_.descriptor() >= 0) waits[count++] = {files_.descriptor(), POLLIN, 0};
    if (worker_ && !worker_->line().isOver())
      waits[count++] = {worker_->line().descriptor(), short(worker_->line().hasRest() ? POLLIN | POLLOUT : POLLIN), 0};
    if (reference_ && isIdle()) waits[count++] = {reference_->line().descriptor(), POLLIN, 0};
    const double wait = std::clamp(until - now(), 0.0, 1.0), begin = now();
    ::poll(waits, count, int(std::ceil(wait * 1e3)));
    // Ctrl-Z has stopped the worker too.
    const double overslept = now() - begin - wait;
    if (overslept > kOverslept) lastAdvance_ += overslept;
  }

  const WatchPlan& plan_;
  WatchListener& listener_;
  const Stopwatch clock_;

  FileWatch files_;
  std::vector<SourceFile> sceneSources_;  // of the scene that was loaded last
  std::vector<std::string> meshes_;
  std::vector<ShaderSource> lastSources_;  // of the last attempt
  std::vector<std::string> lastFiles_;     // that its compiler read
  bool changePending_ = false;             // files have changed, and no attempt has begun with them
  double firstChange_ = -kLongest, lastChange_ = 0;
  bool sceneStale_ = true;     // its files have changed since a worker loaded them
  bool sourcesStale_ = false;  // a file has changed that is not among the last sources
  uint64_t sceneEpoch_ = 1;

  std::unique_ptr<Child> worker_;
  int workerVersions_ = 0;   // that it has rendered
  size_t settledBytes_ = 0;  // its memory after kSettled of them
  bool busy_ = false;
  Purpose busyWith_ = Purpose::prepare;
  uint64_t job_ = 0;
  Step step_ = Step::open;
  double share_ = 0, lastAdvance_ = 0, cancelledAt_ = kNever, restartSeconds_ = 0;

  std::optional<Attempt> attempt_;
  bool hadAttempt_ = false;
  double attemptQuietAt_ = 0;
  bool repeatsVersion_ = false;
  int lastVersion_ = 0;
  std::optional<Good> good_;
  int shown_ = 0;  // version whose picture is on disk; negative: a coarse one; 0: not known

  std::unique_ptr<Child> reference_;
  uint64_t referenceEpoch_ = 0;  // of the picture, or of the one in work
  std::optional<Image> referenceImage_;
};

}  // namespace

void watch(const WatchPlan& plan, WatchListener& listener) {
  // Whatever is as large as a kernel or a picture goes back to the system when it is freed, from the first on: glibc
  // would by and by take such blocks from its heap, and leave holes there.
  ::mallopt(M_MMAP_THRESHOLD, 64 << 10);
  Watching(plan, listener).run();
}

}  // namespace turner
