// `turner shaders --check DIR [SCENE]`: compile, validate and compare with the host's interface, for all ways in which
// a device may fetch the scene. No device, no picture.
#include <algorithm>
#include <string>
#include <vector>

#include "base/errors.h"
#include "base/json_writer.h"
#include "base/tell.h"
#include "command/commands.h"
#include "command/data_folder.h"
#include "command/watch/print.h"
#include "gpu/kernel_features.h"
#include "gpu/prepare.h"
#include "kernel/buffer_access.h"
#include "kernel/edits/edited_kernel.h"
#include "kernel/kernel_check.h"
#include "kernel/layout_text.h"
#include "scene/scene_load.h"
#include "watch/diagnosis/diagnosis.h"

namespace turner {
namespace {

struct CheckResult {
  std::vector<std::string> faults;  // lines
  std::string warnings;
  bool edited = false;
  std::vector<FeatureUse> uses;
  std::vector<Parameter> parameters;
  std::vector<std::string> notes;  // of the kernel for the scene
};

// A fault that all ways have in common is told once.
void addFaults(const std::string& text, std::vector<std::string>& faults) {
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find('\n', at), text.size());
    const std::string fault = text.substr(at, end - at);
    if (std::find(faults.begin(), faults.end(), fault) == faults.end()) faults.push_back(fault);
    at = end + 1;
  }
}

template <class Step>
bool attempt(std::vector<std::string>& faults, const Step& step) {
  try {
    step();
    return true;
  } catch (const InputError& error) {
    addFaults(error.what(), faults);
    return false;
  }
}

CheckResult check(const std::vector<ShaderSource>& sources) {
  CheckResult result;
  attempt(result.faults, [&] { checkLayout(sources); });
  for (const BufferAccess access :
       {BufferAccess::texelBuffer, BufferAccess::storageBuffer, BufferAccess::deviceAddress}) {
    Kernel kernel;
    if (!attempt(result.faults, [&] { kernel = compileKernel(sources, access, KernelForm::edited); })) continue;
    attempt(result.faults, [&] { checkKernel(kernel, sources, access); });
    result.warnings = kernel.warnings;
    result.uses = kernel.uses;
    result.parameters = kernel.parameters;
  }
  if (result.faults.empty())
    result.edited = compileKernel(sources, BufferAccess::storageBuffer, KernelForm::asNeeded).edited;
  return result;
}

// What of the kernel a scene would leave out.
std::vector<std::string> notesFor(const std::string& name, CheckResult& result) {
  Scene scene = loadScene(findScene(name));
  if (result.faults.empty()) attempt(result.faults, [&] { setParameters(result.parameters, scene.parameters); });
  RenderOptions options;
  const RenderSettings settings = settingsFor(scene, options);
  ConstantSet uses = 0;
  for (const FeatureUse& use : result.uses) uses |= ConstantSet(1) << use.constant;
  const Features needed = prepareScene(std::move(scene), settings).features, features = withFeatures(needed, uses);
  return featureLines(addedFeatures(needed, features), features, settings);
}

std::string nameOf(const FeatureUse& use) {
  return featureNames(ConstantSet(1) << use.constant).at(0);
}

std::string resultJson(const std::string& folder, const CheckResult& result,
                       const std::vector<watch::Diagnosis>& diagnoses) {
  JsonWriter json;
  json.object([&] {
    json.put("shaders", folder);
    json.put("sound", result.faults.empty());
    json.put("edited", result.edited);
    watch::putDiagnoses(json, diagnoses);
    json.put("warnings", result.warnings);
    json.array("uses", [&] {
      for (const FeatureUse& use : result.uses) {
        json.object([&] {
          json.put("feature", nameOf(use));
          json.put("file", use.location.path);
          json.put("line", use.location.line);
          json.put("column", use.location.column);
        });
      }
    });
    json.array("notes", [&] {
      for (const std::string& note : result.notes) json.put(note);
    });
  });
  return json.text();
}

}  // namespace

int checkShaders(const ShaderOptions& options) {
  const std::vector<ShaderSource> sources = readShaderSources(shaderFolder(options.check) + "/whitted.comp");
  CheckResult result = check(sources);
  if (!options.scene.empty()) result.notes = notesFor(options.scene, result);
  std::vector<watch::Diagnosis> diagnoses;
  for (const std::string& fault : result.faults) {
    const std::vector<watch::Diagnosis> read = watch::readDiagnoses(fault, sources);
    diagnoses.insert(diagnoses.end(), read.begin(), read.end());
  }
  printDiagnoses(diagnoses);
  if (options.json) {
    printResult(resultJson(options.check, result, diagnoses));
  } else {
    tell("{}", result.warnings);
    for (const FeatureUse& use : result.uses)
      tell("{}:{}:{}: note: the edit here has {} compiled in, whatever the scene\n", use.location.path,
           use.location.line, use.location.column, nameOf(use));
    for (const std::string& note : result.notes) tell("{}\n", note);
    if (result.faults.empty())
      tell("{}: sound; {}\n", options.check, result.edited ? "edited" : "compiles to the same as turner's own sources");
  }
  return result.faults.empty() ? 0 : 2;
}

}  // namespace turner
