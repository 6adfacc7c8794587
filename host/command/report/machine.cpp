// uname, /proc/cpuinfo and the options.
#include "command/report/machine.h"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <string>
#include <thread>

#include "command/report/report_plan.h"
#include "report/findings.h"

namespace turner {
using namespace report;
namespace {

std::string processorName() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(std::min(line.size(), line.find(':') + 2));
  return "unknown processor";
}

}  // namespace

Machine thisMachine(const ReportOptions& options, int repeats) {
  Machine machine;
  machine.processor = processorName();
  machine.cores = std::max(1u, std::thread::hardware_concurrency());
  utsname system{};
  if (uname(&system) == 0) machine.system = fmt::format("{} {}", system.sysname, system.release);
  machine.version = TURNER_VERSION;
  const std::time_t now = std::time(nullptr);
  char date[32] = "";
  std::strftime(date, sizeof date, "%Y-%m-%d %H:%M UTC", std::gmtime(&now));
  machine.date = date;
  machine.shaders = options.shaders;
  machine.repeats = repeats;
  machine.command = "turner report";
  for (const std::string& scene : options.scenes) machine.command += ' ' + shellInput(scene);
  machine.command += " -o " + shellWord(options.output) + (options.full ? " --full" : " --quick");
  const auto add = [&](const char* name, const auto& value) {
    if (value) machine.command += fmt::format(" {} {}", name, *value);
  };
  add("--max-samples", options.maxSamples);
  add("--repeats", options.repeats);
  add("--width", options.width);
  add("--height", options.height);
  add("--depth", options.depth);
  if (options.noCutOffs) machine.command += " --no-cut-offs";
  if (!options.crop.empty()) machine.command += " --crop " + options.crop;
  if (!options.device.empty()) machine.command += " --device " + shellWord(options.device);
  if (!options.shaders.empty()) machine.command += " --shaders " + shellWord(options.shaders);
  if (options.keepExr) machine.command += " --exr";
  machine.command = validUtf8(machine.command);
  machine.shaders = validUtf8(machine.shaders);
  return machine;
}

}  // namespace turner
