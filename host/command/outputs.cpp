// In: names. Out: files, or the reason why not.
#include "command/outputs.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>

#include "base/descriptor_io.h"
#include "base/errors.h"
#include "base/file_identity.h"
#include "base/output_file.h"
#include "base/tell.h"
#include "base/text_file.h"
#include "base/unique_fd.h"
#include "image/png.h"

namespace turner {

namespace {

bool isTerminal(const std::string& path) {
  if (const std::optional<int> open = openOutput(path)) return ::isatty(*open);
  struct stat found {};
  if (::stat(path.c_str(), &found) != 0 || !S_ISCHR(found.st_mode)) return false;
  const UniqueFd file(::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK));
  return file.number >= 0 && ::isatty(file.number);
}

bool isStandardOutput(const std::string& path) {
  if (openOutput(path) == STDOUT_FILENO) return true;
  const std::optional<FileIdentity> identity = identityOf(path);
  return identity && identity == identityOfOpen(STDOUT_FILENO);
}

}  // namespace

PictureName pictureNamed(const std::string& word) {
  if (word.starts_with("exr:")) return {PictureFormat::exr, word.substr(4)};
  if (word.starts_with("png:")) return {PictureFormat::png, word.substr(4)};
  const std::string extension = lowerExtension(word);
  if (extension == ".exr") return {PictureFormat::exr, word};
  if (extension == ".png") return {PictureFormat::png, word};
  if (openOutput(word) || isStream(word)) return {PictureFormat::exr, word};
  throw InputError("cannot write '" + word + "': its name must end in .exr or .png, or begin with exr: or png:");
}

std::vector<std::string> filesNamed(const std::vector<std::string>& words) {
  std::vector<std::string> files;
  std::transform(words.begin(), words.end(), std::back_inserter(files),
                 [](const std::string& word) { return pictureNamed(word).file; });
  return files;
}

void checkOutput(const std::string& word, bool mayBePng) {
  const PictureName picture = pictureNamed(word);
  if (picture.format == PictureFormat::png && !mayBePng)
    throw InputError("cannot write '" + word + "' as PNG, which has no such values: its name must end in .exr");
  checkWritable(picture.file);
  if (isTerminal(picture.file))
    throw InputError(nameOfOutput(picture.file) +
                     " is a terminal, on which a picture is not to be seen; name a file, or redirect it");
}

void writePicture(const std::string& word, const Image& image, const Provenance& provenance) {
  const PictureName picture = pictureNamed(word);
  writeWholeFile(picture.file, picture.format == PictureFormat::png ? encodePng(image) : encodeExr(image, provenance));
}

std::string defaultOutput(const std::string& scene) {
  const std::string extension = lowerExtension(scene);
  if (extension != ".json" && extension != ".nff" && isStream(scene))
    throw InputError("the scene has no file name that its picture could have; name the picture with -o");
  return std::filesystem::path(scene).stem().string() + ".exr";
}

void leaveStdoutTo(const std::vector<std::string>& outputs) {
  if (std::any_of(outputs.begin(), outputs.end(), isStandardOutput)) leaveStdoutToOutput();
}

void Deliveries::attempt(const std::string& output, const std::function<void()>& write) {
  try {
    write();
    written_ += (written_.empty() ? "" : ", ") + nameOfOutput(output);
  } catch (const RunError& error) {
    if (!faults_.empty()) faults_ += '\n';
    faults_ += error.what();
  } catch (const Interrupted&) {
    if (written_.empty()) throw;
    throw Interrupted("interrupted; written were " + written_);
  }
}

void Deliveries::throwIfAnyFailed() const {
  if (!faults_.empty()) throw RunError(faults_);
}

}  // namespace turner
