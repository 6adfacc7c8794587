// Answers are applied in the order in which they came, once the burst of saves is over: they may be of half a change.
#include "watch/versions.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "base/errors.h"
#include "image/compare.h"
#include "kernel/source_names.h"
#include "kernel/spirv_words.h"
#include "watch/diagnosis/source_change.h"
#include "watch/files/watched_files.h"

namespace turner::watch {
namespace {

bool haveSameSize(const Image& a, const Image& b) {
  return a.window == b.window && a.width == b.width && a.height == b.height;
}

}  // namespace

// --- from change to job ----------------------------------------------------------------------------------------------

bool Versions::interrupt(uint64_t burst) {
  if (attempt_ && attempt_->hasPicture) concludeEarly();
  if (!attempt_) return true;
  if (isProtected()) return false;
  if (attempt_->burst == burst)
    repeatsVersion_ = true;  // nothing of it was seen
  else
    listener_.onSuperseded(attempt_->version);
  if (!unseenSince_) unseenSince_ = attempt_->beganAt;
  actions_.forgetTaken();
  attempt_.reset();
  return true;
}

// Whoever saves without end shall see a picture now and then.
bool Versions::isProtected() const {
  return unseenSince_ && actions_.now() > *unseenSince_ + kLongest && actions_.now() < protectedUntil();
}

void Versions::waitForWorker(uint64_t burst) {
  // A change that waits may itself be overtaken.
  if (waitingBurst_ && *waitingBurst_ != burst)
    listener_.onSuperseded(std::exchange(repeatsVersion_, false) ? lastVersion_ : ++lastVersion_);
  waitingBurst_ = burst;
}

void Versions::begin(Change change) {
  attempt_ = Attempt();  // clang refuses emplace() of a nested structure with initialisers
  Attempt& attempt = *attempt_;
  waitingBurst_.reset();
  if (!std::exchange(repeatsVersion_, false)) ++lastVersion_;
  attempt.version = lastVersion_;
  attempt.burst = change.burst;
  attempt.savedAt = change.savedAt;
  attempt.beganAt = change.beganAt;
  attempt.sources = std::move(change.sources);
  attempt.sceneEpoch = change.sceneEpoch;
  VersionReport& report = attempt.report;
  report.version = attempt.version;
  if (good_) {
    report.lastGood = good_->version;
    report.changed = changedFiles(good_->sources, attempt.sources);
    report.sceneChanged = good_->sceneEpoch != attempt.sceneEpoch;
  }
  // A kernel that cannot be read never comes to the worker.
  if (!change.unreadable.empty())
    return receive(encode(Refused{.step = Step::compile, .wrongInput = true, .text = change.unreadable}));
  Job job;
  job.purpose = Purpose::render;
  job.sources = attempt.sources;
  if (good_) {
    job.goodWords = good_->words;
    job.goodAdded = good_->report.added;
    job.goodParameters = good_->report.parameters;
    job.goodTrace = good_->report.trace;
  }
  job.goodHasScene = good_ && good_->sceneEpoch == attempt.sceneEpoch;
  actions_.submit(std::move(job));
}

// --- answers ---------------------------------------------------------------------------------------------------------

void Versions::receive(Message answer) {
  if (!attempt_) return;
  if (answer.kind == Picture::kind && !attempt_->pictureCameAt) attempt_->pictureCameAt = actions_.now();
  attempt_->answers.push_back(std::move(answer));
}

bool Versions::hasAnswersDue() const {
  return attempt_ && isQuiet() && !attempt_->answers.empty() && !awaitsFullPicture();
}

double Versions::nextDecision() const {
  if (!attempt_) return HUGE_VAL;
  if (!isQuiet()) return heldUntil();
  return attempt_->answers.empty() ? HUGE_VAL : heldUntil() + kSoon;
}

void Versions::applyAnswers() {
  if (!attempt_ || !isQuiet()) return;
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

Message Versions::takeAnswer() {
  Message message = std::move(attempt_->answers.front());
  attempt_->answers.pop_front();
  return message;
}

bool Versions::hasPictureIn(const std::deque<Message>::const_iterator& from) const {
  return std::any_of(from, attempt_->answers.end(),
                     [](const Message& message) { return message.kind == Picture::kind; });
}

// Whether next is a coarse picture of a scene that renders in a blink.
bool Versions::awaitsFullPicture() const {
  const auto first = attempt_->answers.begin();
  const double soon = heldUntil() + kSoon;
  return good_ && first->kind == Picture::kind && !attempt_->isPastCoarse && actions_.now() < soon &&
         *attempt_->pictureCameAt + good_->report.trace < soon && !hasPictureIn(first + 1);
}

void Versions::apply(const SceneReady& scene) {
  if (attempt_->refused) return;  // only to look for its loop
  attempt_->report.scene = scene;
  if (!good_ || attempt_->report.sceneChanged) listener_.onScene(scene);
}

void Versions::apply(const Compiled& compiled) {
  VersionReport& report = attempt_->report;
  report.glslang = compiled.glslangSeconds;
  report.optimiser = compiled.optimiserSeconds;
  report.check = compiled.checkSeconds;
  report.code = compareInstructions(good_ ? good_->words : std::vector<uint32_t>(), compiled.words);
  report.warnings = compiled.warnings;
  report.parameters = compiled.parameters;
  report.scene.parameters = valuesText(compiled.parameters);
  if (good_) {
    const std::vector<Parameter>& before = good_->report.parameters;
    for (const Parameter& parameter : report.parameters)
      if (std::find(before.begin(), before.end(), parameter) == before.end()) report.changed.push_back(parameter.name);
  }
  attempt_->words = compiled.words;
  actions_.compilerRead(compiled.files);
  if (!compiled.sameAsGood) return;
  report.sameCode = true;
  report.rays = good_->report.rays;
  report.trace = good_->report.trace;
  report.added = good_->report.added;
  report.features = good_->report.features;
  takePicture(good_->image);
}

void Versions::apply(Picture picture) {
  VersionReport& report = attempt_->report;
  report.pipeline += picture.pipelineSeconds;
  attempt_->isPastCoarse = true;
  if (picture.coarse) {
    if (hasPictureIn(attempt_->answers.begin())) return;  // the full one
    show(picture.image, report.scene, attempt_->version, true);
    report.toCoarse = actions_.now() - attempt_->savedAt;
    listener_.onCoarse(attempt_->version, *report.toCoarse);
    return;
  }
  report.trace = picture.traceSeconds;
  report.readback = picture.readbackSeconds;
  report.added = picture.added;
  report.features = picture.features;
  for (const std::string& line : report.features) {
    const auto isKnown = [&](const std::vector<std::string>& known) {
      return std::find(known.begin(), known.end(), line) != known.end();
    };
    if (!good_ || !isKnown(good_->report.features)) report.news.push_back(line);
  }
  takePicture(std::move(picture.image));
}

// The attempt is the last good version from here on.
void Versions::takePicture(Image image) {
  Attempt& attempt = *attempt_;
  VersionReport& report = attempt.report;
  show(image, report.scene, attempt.version, false);
  report.toPicture = actions_.now() - attempt.savedAt;
  listener_.onPicture(attempt.version, report.toPicture, report.changed);
  if (good_) {
    if (haveSameSize(image, good_->image)) report.toLastGood = compareImages(image, good_->image, kChanged);
    if (good_->sceneEpoch == attempt.sceneEpoch) report.lastGoodTrace = good_->report.trace;
    report.lastGoodRays = good_->report.rays;
  }
  GoodVersion& good = good_.emplace();
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

void Versions::applyFigures(const Message& message) {
  if (message.kind == Timing::kind) attempt_->report.timing = decode<Timing>(message);
  if (message.kind == Counted::kind) attempt_->report.rays = decode<Counted>(message).rays;
}

void Versions::apply(const Refused& refused) {
  if (attempt_->refused) return refuse(*attempt_->refused);  // the search has found nothing
  if (refused.endless || refused.unfinished || (refused.hung && refused.step >= Step::pipeline)) {
    attempt_->refused = refused;
    Job job;
    job.purpose = Purpose::findLoop;
    job.hung = refused.hung;
    job.sources = attempt_->sources;
    return actions_.submit(std::move(job));
  }
  // What no edit can mend.
  if (!good_ && refused.step == Step::open) {
    if (refused.wrongInput) throw InputError(refused.text);
    throw RunError(refused.text);
  }
  refuse(refused);
}

// --- the reference ---------------------------------------------------------------------------------------------------

void Versions::compareWithReference(VersionReport& report) const {
  const Image* image = actions_.reference(good_->sceneEpoch);
  if (image && haveSameSize(*image, good_->image)) report.toReference = compareImages(good_->image, *image, kChanged);
}

void Versions::applyReference() {
  VersionReport& report = good_->report;
  compareWithReference(report);
  if (!report.toReference) return;
  try {
    if (!report.kept.empty()) actions_.keepFigures(report);
  } catch (const RunError& error) {
    reportTrouble(good_->version, error.what());
  }
  listener_.onReference(good_->version, *report.toReference);
}

// --- ends ------------------------------------------------------------------------------------------------------------

// All that there will be is known of the version.
void Versions::conclude() {
  VersionReport& report = attempt_->report;
  if (!report.toReference) compareWithReference(report);
  try {
    report.kept = actions_.keep(*good_, report);
  } catch (const std::runtime_error& error) {
    reportTrouble(report.version, error.what());
  }
  good_->report = report;
  listener_.onVersion(report);
  attempt_.reset();
}

// A version with a picture is given up: what has come is all.
void Versions::concludeEarly() {
  while (!attempt_->answers.empty()) applyFigures(takeAnswer());
  if (attempt_->refused)
    refuse(*attempt_->refused);
  else
    conclude();
}

// The message of a refusal, with the place of the fault where it can be found.
std::string Versions::reasonOf(const Refused& refused, bool isEndless) const {
  const Attempt& attempt = *attempt_;
  const std::string text = (isEndless ? "endless loop: " : "") + refused.text;
  if (refused.wrongInput) return text;
  if (attempt.loop) return faultAt(*attempt.loop) + text + "; this loop made too many turns";
  if (!good_ || attempt.hasPicture) return text;
  const std::optional<SourceLocation> location = likelyLocation(good_->sources, attempt.sources);
  return location ? faultAt(*location) + text + "; likely by what was changed here" : text;
}

// Ends the attempt without a picture; or without all figures, if it has one.
void Versions::refuse(const Refused& refused) {
  Attempt& attempt = *attempt_;
  const bool isEndless = attempt.loop || refused.endless || (refused.hung && runsKernel(refused.step));
  const std::string reason = reasonOf(refused, isEndless);
  if (refused.step == Step::scene) actions_.sceneWasRefused();
  if (!refused.wrongInput) actions_.forgetTaken();  // the machine may do better next time
  if (attempt.hasPicture) {
    reportTrouble(attempt.version, reason);
    return conclude();
  }
  Refusal refusal;
  refusal.version = attempt.version;
  if (good_) refusal.lastGood = good_->version;
  refusal.seconds = actions_.now() - attempt.savedAt;
  refusal.step = refused.step;
  refusal.endless = isEndless;
  refusal.diagnoses = readDiagnoses(reason, attempt.sources);
  attempt_.reset();
  unseenSince_.reset();
  if (good_) showGoodAgain();
  listener_.onRefused(refusal);
}

void Versions::reportTrouble(int version, const std::string& text) {
  listener_.onTrouble(version, readDiagnoses(text, {}));
}

void Versions::stop() {
  if (attempt_ && attempt_->hasPicture) concludeEarly();
  if (good_) showGoodAgain();
  listener_.onStop(good_ ? std::optional(good_->version) : std::nullopt);
}

// --- pictures --------------------------------------------------------------------------------------------------------

void Versions::show(const Image& image, const SceneReady& scene, int version, bool coarse) {
  const std::vector<std::string> faults = actions_.show(image, scene, coarse);
  showsGood_ = !coarse && faults.empty();
  if (coarse) return;
  for (const std::string& fault : faults) reportTrouble(version, fault);
}

// A coarse picture of what came to nothing does not stay.
void Versions::showGoodAgain() {
  if (!showsGood_) show(good_->image, good_->scene, good_->version, false);
}

}  // namespace turner::watch
