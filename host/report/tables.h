// A report as data: report.json and report.csv.
#pragma once

#include <string>
#include <vector>

#include "report/swept_scene.h"

namespace turner::report {

// Of the whole report.
struct Machine {
  std::string processor;  // as the system names it
  unsigned cores = 0;
  std::string system;   // kernel's name and version
  std::string version;  // of Turner
  std::string date;     // UTC, of the end of the measurements
  std::string command;  // that makes this report
  std::string shaders;  // --shaders, if it was given
  int repeats = 1;
};

std::string reportJson(const Machine& machine, const std::vector<SweptScene>& scenes);
std::string reportCsv(const Machine& machine, const std::vector<SweptScene>& scenes);

}  // namespace turner::report
