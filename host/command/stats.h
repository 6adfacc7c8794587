// Figures as JSON, for --stats, compare --json and devices --json.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gpu/devices.h"
#include "gpu/renderer.h"
#include "image/compare.h"
#include "image/envelope.h"
#include "image/error_analysis.h"
#include "image/settings.h"
#include "kernel/edits/parameters.h"
#include "scene/scene.h"

namespace turner {

struct Seconds {
  double load = 0, build = 0, compile = 0, upload = 0, trace = 0, readback = 0, total = 0;
};

struct Stats {
  std::string scene;
  DeviceInfo device;
  RenderSettings settings;
  std::string backend, geometry, access;
  PrimitiveCounts primitives;
  bool editedKernel = false;
  std::vector<Parameter> parameters;       // of an edited kernel
  std::vector<std::string> addedFeatures;  // of an edited kernel, beyond what the scene needs
  RayCounts rays;
  Visits visits;  // of the shader: what its rays met
  Seconds seconds;
  size_t treeNodes = 0, geometryBytes = 0;  // on the device; 0 for the reference
  int treeDepth = 0;
};

std::string statsJson(const Stats& stats);
std::string comparisonJson(const Comparison& comparison, const std::optional<Decomposition>& decomposition,
                           const std::optional<EnvelopeRule>& envelope);
std::string devicesJson(const std::vector<DeviceInfo>& devices);

}  // namespace turner
