// What a change did: to the times, the picture, the rays and the code. As lines for people and as JSON.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/json_writer.h"
#include "image/compare.h"
#include "image/settings.h"
#include "kernel/spirv_words.h"
#include "watch/process/messages.h"

namespace turner::watch {

// A channel that differs by more than this counts its pixel as changed from the last good picture: any difference does.
inline constexpr double kChanged = 0;

struct VersionReport {
  int version = 0;
  std::optional<int> lastGood;       // the version that this one is compared with
  std::vector<std::string> changed;  // names of the shaders' files that differ from it
  bool sceneChanged = false;
  bool sameCode = false;  // the compiler made of both the same: the picture was not rendered again

  // Seconds since the save, or since the start of the first version. No coarse picture is shown where the full one was
  // there as soon.
  std::optional<double> toCoarse;
  double toPicture = 0;
  SceneReady scene;                                                                     // its times
  double glslang = 0, optimiser = 0, check = 0, pipeline = 0, trace = 0, readback = 0;  // seconds
  std::optional<Timing> timing;                                                         // both kernels in turn
  std::optional<double> lastGoodTrace;  // of the same scene, when it was rendered

  std::optional<Comparison> toLastGood, toReference;  // none: there is none of this size; or it is not ready
  std::optional<RayCounts> rays, lastGoodRays;
  InstructionChange code;
  std::string warnings;               // the compiler's, a line for each
  std::vector<Parameter> parameters;  // with their values
  uint32_t added = 0;                 // what the kernel has beyond the scene's needs (gpu/kernel_features.h)
  std::vector<std::string> features;  // what there is to tell of that
  std::vector<std::string> news;      // of these lines, those that the last good version had not
  std::string kept;                   // folder

  // Of the trace's time to the last good version's.
  std::optional<double> ratio() const;
};

// Aligned lines, each with its end.
std::string versionReportText(const VersionReport& report);
// The line of the comparison with the reference alone, for one that comes later.
std::string referenceText(const Comparison& comparison);

// As JSON, an object.
std::string versionReportJson(const VersionReport& report);
// Into an object that is open.
void putComparison(JsonWriter& json, const char* key, const std::optional<Comparison>& comparison);
void putVersionReport(JsonWriter& json, const VersionReport& report);

}  // namespace turner::watch
