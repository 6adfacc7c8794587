// A line is whole or does not count: it is written by one call and ends with a newline.
#include "report/journal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "base/errors.h"
#include "base/output_file.h"
#include "base/text_file.h"

namespace turner::report {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& what, const std::string& path) {
  throw RunError(what + " " + path + ": " + std::strerror(errno));
}

int openIn(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw RunError("cannot make the folder " + folder + ": " + error.message());
  const std::string path = folder + "/journal";
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (file < 0) fail("cannot write", path);
  return file;
}

}  // namespace

Journal::Journal(const std::string& folder) : folder_(folder), file_(openIn(folder)) {
  const std::string path = folder + "/journal";
  if (::flock(file_.number, LOCK_EX | LOCK_NB) != 0)
    throw InputError("another turner report is measuring into " + folder + "; wait for it, or name another folder");

  std::string text = readTextFile(path);
  const size_t end = text.rfind('\n') + 1;  // 0 without any
  if (end < text.size() && ::ftruncate(file_.number, off_t(end)) != 0) fail("cannot shorten", path);
  text.resize(end);
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) read(line);
}

// What is no measurement, whoever wrote it, is none.
void Journal::read(const std::string& line) {
  std::istringstream words(line);
  std::string kind, name, value, seconds, meanSquare;
  int repeat = 0;
  words >> kind >> name;
  if (kind == "decided" && words >> value) decisions_[name] = value;
  if (kind != "measured" || !(words >> repeat >> seconds >> meanSquare)) return;
  // strtod takes "nan" too.
  const Measurement measurement{std::strtod(seconds.c_str(), nullptr), std::strtod(meanSquare.c_str(), nullptr)};
  const bool isTime = measurement.seconds > 0 && std::isfinite(measurement.seconds);
  if (isTime && repeat >= 0 && (repeat == 0) == (measurement.meanSquare < 0))
    measurements_[{name, repeat}] = measurement;
}

void Journal::append(const std::string& line) {
  if (::write(file_.number, line.data(), line.size()) != ssize_t(line.size())) fail("cannot write into", folder_);
}

std::optional<Measurement> Journal::find(const std::string& point, int repeat) const {
  const auto found = measurements_.find({point, repeat});
  if (found == measurements_.end()) return std::nullopt;
  return found->second;
}

void Journal::add(const std::string& point, int repeat, const Measurement& measurement) {
  append(fmt::format("measured {} {} {:.17g} {:.17g}\n", point, repeat, measurement.seconds, measurement.meanSquare));
  measurements_[{point, repeat}] = measurement;
}

std::optional<std::string> Journal::decision(const std::string& key) const {
  const auto found = decisions_.find(key);
  if (found == decisions_.end()) return std::nullopt;
  return found->second;
}

void Journal::decide(const std::string& key, const std::string& value) {
  append(fmt::format("decided {} {}\n", key, value));
  decisions_[key] = value;
}

void Journal::keep(const std::string& point, const Image& image, const Provenance& provenance) const {
  writeWholeFile(picturePath(point), encodeExr(image, provenance));
}

Image Journal::picture(const std::string& point) const {
  return readExr(picturePath(point));
}

bool Journal::hasPicture(const std::string& point, int width, int height, const Window& window) const {
  try {
    const Image image = picture(point);
    return image.width == width && image.height == height && image.window == window;
  } catch (const InputError&) {
    return false;  // to be rendered once more
  }
}

void Journal::discard() {
  std::error_code error;
  fs::remove(folder_ + "/journal", error);
  fs::remove_all(folder_, error);
  if (error) throw RunError("cannot delete " + folder_ + ": " + error.message());
}

}  // namespace turner::report
