// The files that a command writes, looked at before any work is done for them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "image/exr.h"
#include "image/image.h"

namespace turner {

// --- pictures -------------------------------------------------------------------------------------------------------

enum class PictureFormat { exr, png };

// Where a picture goes, and as what.
struct PictureName {
  PictureFormat format = PictureFormat::exr;
  std::string file;  // "-": standard output
};

// Of a word of the command line: NAME.exr, NAME.png, exr:NAME, png:NAME, or the name of a pipe or "-", which get an
// EXR. Throws InputError.
PictureName pictureNamed(const std::string& word);
// The files of such words.
std::vector<std::string> filesNamed(const std::vector<std::string>& words);

// The picture can be written, as far as one sees before. Throws InputError.
void checkOutput(const std::string& word, bool mayBePng);

// As EXR or PNG, by the name. Throws RunError.
void writePicture(const std::string& word, const Image& image, const Provenance& provenance);

// What is written where no output is named: the scene's name with .exr, in the current folder. Throws InputError for a
// scene that comes through a pipe without a name.
std::string defaultOutput(const std::string& scene);

// --- all outputs ----------------------------------------------------------------------------------------------------

// If one of them is standard output, what is told goes to stderr from here on.
void leaveStdoutTo(const std::vector<std::string>& outputs);

// Writes of one command, each in its own right: one that fails does not keep the others from what took hours to make.
class Deliveries {
 public:
  // Runs a write; keeps its RunError. Throws Interrupted, which says what was written before.
  void attempt(const std::string& output, const std::function<void()>& write);
  // Throws RunError with a line for each that failed.
  void throwIfAnyFailed() const;

 private:
  std::string faults_, written_;
};

}  // namespace turner
