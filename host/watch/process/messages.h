// Messages between the watcher and its worker: one job goes down the line, its answers come up in the order of the
// structs below. Every answer names its job, so that one of a cancelled job is recognised.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/parameter_setting.h"
#include "image/image.h"
#include "image/settings.h"
#include "kernel/edits/parameters.h"
#include "kernel/shader_sources.h"
#include "scene/scene.h"
#include "watch/process/bytes.h"
#include "watch/process/channel.h"
#include "watch/process/steps.h"

namespace turner::watch {

// --- down -----------------------------------------------------------------------------------------------------------

enum class Purpose {
  prepare,    // open the device and load the scene, to be ready for what comes
  render,     // the picture, its times and counts
  findLoop,   // where a kernel that does not end loops
  reference,  // the picture of the reference; no shader
};

struct Job {
  static constexpr uint32_t kind = 1;
  uint64_t number = 0;
  Purpose purpose = Purpose::render;
  uint64_t sceneEpoch = 0;            // counts the changes of its files
  bool reloadScene = false;           // its files have changed since the last job
  bool hung = false;                  // the kernel was given up; else a driver has cut its loops or it left pixels out
  std::vector<ShaderSource> sources;  // the kernel, as it was read by the watcher
  // The words of the last good kernel, where there is one, whether its picture was of the same scene, and what its
  // kernel had beyond that scene's needs (gpu/kernel_features.h).
  std::vector<uint32_t> goodWords;
  bool goodHasScene = false;
  uint32_t goodAdded = 0;
  std::vector<ParameterSetting> parameters;  // of the command line and what is followed, the last ones count
  std::vector<Parameter> goodParameters;     // that the last good picture was rendered with
  double goodTrace = 0;                      // seconds that it took

  template <class Bytes>
  void fields(Bytes& b) {
    uint64_t count = sources.size();
    b(number, purpose, sceneEpoch, reloadScene, hung, goodWords, goodHasScene, goodAdded, parameters, goodParameters,
      goodTrace, count);
    sources.resize(count);
    for (ShaderSource& source : sources) b(source.name, source.path, source.text);
  }
};

struct Cancel {
  static constexpr uint32_t kind = 2;
  uint64_t job = 0;
};

// --- up -------------------------------------------------------------------------------------------------------------

// A step has begun, or has come further: the worker lives.
struct Advance {
  static constexpr uint32_t kind = 3;
  uint64_t job = 0;
  Step step = Step::open;
  double share = 0;
};

// Summary of a scene that is on the device.
struct SceneReady {
  static constexpr uint32_t kind = 4;
  uint64_t job = 0, sceneEpoch = 0;
  Scene summary;  // name, camera, sources and notes
  RenderSettings settings;
  PrimitiveCounts primitives;
  std::string device, driver, deviceType, access;
  double openSeconds = 0, loadSeconds = 0, buildSeconds = 0, uploadSeconds = 0;  // 0 where it was not done again
  std::string parameters;  // of the picture, as text; filled in where they are known

  template <class Bytes>
  void fields(Bytes& b) {
    uint64_t files = summary.sources.size();
    b(job, sceneEpoch, summary.name, summary.camera, summary.notes, files, settings, primitives, device, driver,
      deviceType, access);
    b(openSeconds, loadSeconds, buildSeconds, uploadSeconds);
    summary.sources.resize(files);
    for (SourceFile& file : summary.sources) b(file.path, file.sha256);
  }
};

struct Compiled {
  static constexpr uint32_t kind = 5;
  uint64_t job = 0;
  std::vector<uint32_t> words;
  std::vector<std::string> files;
  std::string warnings;               // the compiler's, a line for each
  std::vector<Parameter> parameters;  // with their values
  double glslangSeconds = 0, optimiserSeconds = 0, checkSeconds = 0;
  // The last good kernel's words, of the same scene and with the same values: no picture follows, it would be the same.
  bool sameAsGood = false;

  template <class Bytes>
  void fields(Bytes& b) {
    b(job, words, files, warnings, parameters, glslangSeconds, optimiserSeconds, checkSeconds, sameAsGood);
  }
};

struct Picture {
  static constexpr uint32_t kind = 6;
  uint64_t job = 0;
  bool coarse = false;
  Image image;
  double pipelineSeconds = 0;  // in which the driver compiled
  double traceSeconds = 0, readbackSeconds = 0;
  // Of the kernel that rendered it: what it has beyond the scene's needs, and what there is to tell of that.
  uint32_t added = 0;
  std::vector<std::string> features;

  template <class Bytes>
  void fields(Bytes& b) {
    b(job, coarse, image.width, image.height, image.window, image.rgb, pipelineSeconds, traceSeconds, readbackSeconds,
      added, features);
  }
};

// Of traces of both kernels, taken in turn: medians, and the spread of the pairs' ratios of edited to good.
struct Timing {
  static constexpr uint32_t kind = 7;
  uint64_t job = 0;
  int pairs = 0;
  double goodSeconds = 0, editedSeconds = 0;
  double ratio = 0, leastRatio = 0, mostRatio = 0;
  // Where the edited kernel was given features that the good one was without: the time of the good one with them over
  // that without; else 0.
  double featuresRatio = 0;
};

struct Counted {
  static constexpr uint32_t kind = 8;
  uint64_t job = 0;
  RayCounts rays;
};

// Where a loop is that made too many turns.
struct LoopFound {
  static constexpr uint32_t kind = 9;
  uint64_t job = 0;
  std::string path;
  int line = 0, column = 0;

  template <class Bytes>
  void fields(Bytes& b) {
    b(job, path, line, column);
  }
};

// The job is done: all of it, or it was given up as the watcher wished.
struct Finished {
  static constexpr uint32_t kind = 10;
  uint64_t job = 0;
};

// The job ended here.
struct Refused {
  static constexpr uint32_t kind = 11;
  uint64_t job = 0;
  Step step = Step::open;
  bool wrongInput = false;  // the user's mistake, else the machine's failure
  bool endless = false;     // the driver cut loops short, or the work made no progress
  bool hung = false;        // said by the watcher, of a worker that came to no end
  bool unfinished = false;  // pixels are missing: there may be an endless loop that the driver left out
  bool broken = false;      // the worker ends too: its device may be lost
  std::string text;         // one line for each fault, as errors have them

  template <class Bytes>
  void fields(Bytes& b) {
    b(job, step, wrongInput, endless, hung, unfinished, broken, text);
  }
};

// --- both -----------------------------------------------------------------------------------------------------------

template <class Value>
Message encode(const Value& value) {
  ByteWriter writer;
  writer(value);
  return {Value::kind, std::move(writer.bytes)};
}

// False: the other end is gone.
template <class Value>
bool send(Channel& line, const Value& value) {
  const Message message = encode(value);
  return line.send(message.kind, message.bytes);
}

// Without waiting for it.
template <class Value>
void post(Channel& line, const Value& value) {
  const Message message = encode(value);
  line.post(message.kind, message.bytes);
}

// Of an answer: each begins with it.
inline uint64_t jobOf(const Message& answer) {
  uint64_t job = 0;
  ByteReader reader(answer.bytes);
  reader(job);
  return job;
}

template <class Value>
Value decode(const Message& message) {
  Value value;
  ByteReader reader(message.bytes);
  reader(value);
  return value;
}

}  // namespace turner::watch
