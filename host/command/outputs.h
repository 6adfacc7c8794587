// The files that a command writes, looked at before any work is done for them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "image/exr.h"
#include "image/image.h"

namespace turner {

// A picture's name ends in .exr or, if that is allowed, in .png, and it can be written. Throws InputError.
void checkOutput(const std::string& path, bool mayBePng);

// Two outputs of one name would leave only the last. Throws InputError.
void refuseRepeated(const std::vector<std::string>& outputs);

// An output in the place of an input would destroy it. Throws InputError.
void refuseOverwriting(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs);

// What is written where no output is named: the scene's name with .exr, in the current folder.
std::string defaultOutput(const std::string& scene);

// Writes of one command, each in its own right: one that fails does not keep the others from what took hours to make.
class Deliveries {
 public:
  // Runs a write; keeps its RunError.
  void attempt(const std::function<void()>& write);
  // Throws RunError with a line for each that failed.
  void throwIfAnyFailed() const;

 private:
  std::string faults_;
};

// As EXR or PNG, by the name. Throws RunError.
void writePicture(const std::string& path, const Image& image, const Provenance& provenance);

}  // namespace turner
