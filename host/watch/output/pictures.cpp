// In: pictures and reports. Out: files.
#include "watch/output/pictures.h"

#include <filesystem>
#include <stdexcept>

#include "base/text_file.h"
#include "base/threads.h"
#include "image/provenance.h"
#include "watch/output/kept_versions.h"
#include "watch/process/worker.h"

namespace turner::watch {
namespace {

Provenance provenanceOf(const SceneReady& scene) {
  Provenance provenance =
      makeProvenance(scene.summary, scene.settings, "--backend shader --geometry rounded", scene.device, scene.driver);
  if (!scene.parameters.empty()) provenance.strings.emplace_back("turner:params", scene.parameters);
  return provenance;
}

}  // namespace

std::vector<std::string> writeOutputs(const WatchPlan& plan, const Image& image, const SceneReady& scene, bool coarse) {
  Provenance provenance = provenanceOf(scene);
  if (coarse) provenance.strings.emplace_back("turner:coarse", std::to_string(kCoarseStride));
  std::vector<std::string> faults(plan.outputs.size());
  parallelFor(plan.outputs.size(), [&](size_t i) {
    try {
      plan.writePicture(plan.outputs[i], image, provenance);
    } catch (const std::runtime_error& error) {
      faults[i] = error.what();
    }
  });
  std::erase(faults, "");
  return faults;
}

std::string keepGood(const WatchPlan& plan, const GoodVersion& good, const VersionReport& report) {
  KeptVersion version;
  version.sources = good.sources;
  version.picture = encodeExr(good.image, provenanceOf(good.scene));
  version.sceneText = readRegularFile(plan.scene);
  // What was changed since is no part of this version.
  if (sha256Hex(version.sceneText) == good.scene.summary.sources.at(0).sha256)
    version.sceneName = std::filesystem::path(plan.scene).filename().string();
  version.figures = versionReportJson(report);
  if (!report.parameters.empty()) version.parameters = parametersJson(report.parameters);
  return keepVersion(plan.keep, report.version, version);
}

}  // namespace turner::watch
