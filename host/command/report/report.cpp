// turner report: scenes -> what to measure -> measured, as far as the journal does not have it -> page and tables.
#include <fmt/format.h>

#include <filesystem>

#include "base/errors.h"
#include "base/output_file.h"
#include "base/tell.h"
#include "base/text_file.h"
#include "command/commands.h"
#include "command/data_folder.h"
#include "command/overwriting.h"
#include "command/report/machine.h"
#include "command/report/report_plan.h"
#include "command/report/sweep_progress.h"
#include "image/exr.h"
#include "report/findings.h"
#include "report/measure.h"
#include "report/page.h"
#include "report/tables.h"
#include "scene/scene_load.h"

namespace turner {
using namespace report;
namespace {

namespace fs = std::filesystem;

void printPlan(const ReportPlan& plan, const Journal& journal, const std::string& output) {
  for (size_t i = 0; i < plan.sweeps.size(); ++i) {
    const SceneToSweep& sweep = plan.sweeps[i];
    tell("scene: {} ({} x {} pixels, {} settings", sweep.path, sweep.whole.crop.width(), sweep.whole.crop.height(),
         sweep.settings.size());
    for (const RendererInfo& renderer : plan.renderers) tell(", {}", renderer.device);
    tell(", {} times)\n", sweep.repeats);
    for (const std::string& note : sweep.scene.notes) tell("{}\n", note);
  }
  if (journal.size() > 0)
    tell("going on with {} measurements of an interrupted report in {}\n", journal.size(), output);
}

std::vector<SweptScene> measureAll(const ReportPlan& plan, Journal& journal, bool quiet) {
  SweepProgress progress(quiet);
  for (const SceneToSweep& sweep : plan.sweeps) expectSweep(sweep, plan.renderers, journal, progress);
  std::vector<SweptScene> scenes;
  for (size_t i = 0; i < plan.sweeps.size(); ++i)
    scenes.push_back(
        measure(plan.sweeps[i], openRenderers(plan.scenes[i], plan.devices, plan.shaders), journal, progress));
  return scenes;
}

void writePictures(const ReportPlan& plan, const std::vector<SweptScene>& scenes, const Journal& journal,
                   const fs::path& folder) {
  for (size_t i = 0; i < scenes.size(); ++i) {
    const std::string& tag = plan.sweeps[i].tag;
    for (const SweepPoint& point : scenes[i].points)
      writeWholeFile((folder / (tag + point.name + ".exr")).string(),
                     readTextFile(journal.picturePath(tag + point.name)));
    writeWholeFile((folder / (tag + "converged.exr")).string(), encodeExr(scenes[i].converged.mean, {}));
  }
}

void makeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError("cannot make the folder " + folder.string() + ": " + error.message());
}

// What --exr may write over.
std::vector<std::string> picturesIn(const fs::path& folder) {
  std::vector<std::string> pictures;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, none)) pictures.push_back(entry.path());
  return pictures;
}

std::vector<std::string> inputsOf(const ReportPlan& plan, const ReportOptions& options) {
  std::vector<std::string> inputs = shaderFiles(options.shaders);
  for (size_t i = 0; i < plan.scenes.size(); ++i) {
    const std::vector<std::string> files = filesOf(findScene(options.scenes[i]), plan.scenes[i].sources);
    inputs.insert(inputs.end(), files.begin(), files.end());
  }
  return inputs;
}

}  // namespace

int runReport(const ReportOptions& options) {
  const ReportPlan plan = planFor(options);
  const fs::path output = options.output, pictures = output / "pictures";
  const std::string page = (output / "report.html").string(), json = (output / "report.json").string(),
                    csv = (output / "report.csv").string();
  std::vector<std::string> writes = picturesIn(pictures);
  writes.insert(writes.end(), {page, json, csv});
  refuseOverwriting(writes, inputsOf(plan, options));
  makeFolder(options.keepExr ? pictures : output);
  for (const std::string& file : {page, json, csv}) checkWritable(file);
  if (options.keepExr) checkWritable((pictures / "picture.exr").string());

  const fs::path unfinished = output / "unfinished", folder = unfinished / fingerprint(plan).substr(0, 16);
  std::vector<SweptScene> scenes;
  {
    Journal journal(folder.string());
    if (!options.quiet) printPlan(plan, journal, options.output);
    try {
      scenes = measureAll(plan, journal, options.quiet);
    } catch (const Interrupted&) {
      throw Interrupted(
          fmt::format("interrupted after {} measurements; the same command goes on from there", journal.size()));
    }
    throwIfInvalid();

    const Machine machine = thisMachine(options, plan.repeats);
    const PictureOf pictureOf = [&](size_t scene, const SweepPoint& point) {
      return journal.picture(plan.sweeps[scene].tag + point.name);
    };
    writeWholeFile(json, reportJson(machine, scenes));
    writeWholeFile(csv, reportCsv(machine, scenes));
    if (options.keepExr) writePictures(plan, scenes, journal, pictures);
    writeWholeFile(page, reportPage(machine, scenes, pictureOf));
    journal.discard();
  }
  std::error_code inUse;  // by an interrupted report with other options
  fs::remove(unfinished, inUse);

  if (!options.quiet) {
    for (const SweptScene& scene : scenes) {
      tell("{}\n", scene.path);
      for (const std::string& sentence : findings(scene)) tell("  {}\n", sentence);
    }
    for (const std::string& file : {page, json, csv}) tell("wrote {}\n", file);
  }
  return 0;
}

}  // namespace turner
