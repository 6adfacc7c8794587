// In: names. Out: files, or the reason why not.
#include "command/outputs.h"

#include <filesystem>

#include "base/errors.h"
#include "base/output_file.h"
#include "base/text_file.h"
#include "image/png.h"

namespace turner {

namespace {

// The file that a name stands for, symbolic links followed.
std::filesystem::path realFile(const std::string& path) {
  std::error_code error;
  const std::filesystem::path real = std::filesystem::weakly_canonical(path, error);
  if (error) throw InputError("cannot find out where '" + path + "' is: " + error.message());
  return real;
}

}  // namespace

void checkOutput(const std::string& path, bool mayBePng) {
  const std::string extension = lowerExtension(path);
  if (extension != ".exr" && !(mayBePng && extension == ".png"))
    throw InputError("cannot write '" + path + "': its name must end in .exr" + (mayBePng ? " or .png" : ""));
  checkWritable(path);
}

void refuseRepeated(const std::vector<std::string>& outputs) {
  for (size_t i = 0; i < outputs.size(); ++i)
    for (size_t j = 0; j < i; ++j)
      if (realFile(outputs[i]) == realFile(outputs[j]))
        throw InputError("the output " + outputs[i] + " is named twice");
}

void refuseOverwriting(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs) {
  for (const std::string& output : outputs)
    for (const std::string& input : inputs)
      if (realFile(output) == realFile(input))
        throw InputError("the output " + output + " is an input; name another file");
}

void Deliveries::attempt(const std::function<void()>& write) {
  try {
    write();
  } catch (const RunError& error) {
    if (!faults_.empty()) faults_ += '\n';
    faults_ += error.what();
  }
}

void Deliveries::throwIfAnyFailed() const {
  if (!faults_.empty()) throw RunError(faults_);
}

void writePicture(const std::string& path, const Image& image, const Provenance& provenance) {
  writeWholeFile(path, lowerExtension(path) == ".png" ? encodePng(image) : encodeExr(image, provenance));
}

std::string defaultOutput(const std::string& scene) {
  return std::filesystem::path(scene).stem().string() + ".exr";
}

}  // namespace turner
