// Signatures say that a file was saved, its text says whether that is a change.
#include "watch/files/watched_files.h"

#include <poll.h>

#include <algorithm>
#include <climits>
#include <filesystem>
#include <utility>

#include "base/errors.h"
#include "base/text_file.h"
#include "scene/scene_load.h"

namespace turner::watch {

namespace fs = std::filesystem;

namespace {

bool haveSameTexts(const std::vector<ShaderSource>& a, const std::vector<ShaderSource>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const ShaderSource& x, const ShaderSource& y) { return x.path == y.path && x.text == y.text; });
}

// To read a larger file would take longer than to load the scene once too often.
bool isSmall(const std::string& file) {
  constexpr uintmax_t kMostBytes = 16 << 20;
  std::error_code ignored;
  return fs::is_regular_file(file, ignored) && fs::file_size(file, ignored) <= kMostBytes;
}

// Whatever a scene's text calls a "file", whether the rest of it can be read or not.
std::vector<std::string> namedFiles(const std::string& text) {
  std::vector<std::string> names;
  constexpr std::string_view kKey = "\"file\"";
  for (size_t at = text.find(kKey); at != std::string::npos; at = text.find(kKey, at + 1)) {
    const size_t begin = text.find_first_not_of(" \t\r\n:", at + kKey.size());
    if (begin == std::string::npos || text[begin] != '"') continue;
    const size_t length = std::min(text.find('"', begin + 1), text.size()) - begin - 1;
    if (length < PATH_MAX) names.push_back(text.substr(begin + 1, length));
  }
  return names;
}

}  // namespace

WatchedFiles::WatchedFiles(std::string scene, const std::string& shaders)
    : scene_(std::move(scene)), kernel_(shaders + "/whitted.comp") {
  follow();
}

std::vector<ShaderSource> WatchedFiles::readSources() const try {
  return readShaderSources(kernel_);
} catch (const InputError&) {
  return {{"", kernel_, std::nullopt}};
}

std::vector<std::string> WatchedFiles::filesOfScene() const {
  std::vector<std::string> files = filesOf(scene_, loaded_);
  files.insert(files.end(), namedMeshes_.begin(), namedMeshes_.end());
  return files;
}

std::vector<std::string> WatchedFiles::shaderFiles() const {
  std::vector<std::string> files = {kernel_};
  for (const ShaderSource& source : seen_) files.push_back(source.path);
  files.insert(files.end(), read_.begin(), read_.end());
  return files;
}

std::vector<std::string> WatchedFiles::followed() const {
  std::vector<std::string> files = filesOfScene();
  const std::vector<std::string> shaders = shaderFiles();
  files.insert(files.end(), shaders.begin(), shaders.end());
  return files;
}

void WatchedFiles::follow() {
  watch_.follow(followed());
}

bool WatchedFiles::isAsLoaded(const std::string& file) const try {
  if (isSceneStale() || !isSmall(file)) return false;
  const std::vector<std::string> files = filesOf(scene_, loaded_);
  const size_t number = size_t(std::find(files.begin(), files.end(), file) - files.begin());
  return number < loaded_.size() && sha256Hex(readTextFile(file)) == loaded_[number].sha256;
} catch (const InputError&) {
  return false;
}

bool WatchedFiles::isKnownSource(const std::string& file) const {
  const auto isThis = [&](const ShaderSource& source) { return source.path == file; };
  return file == kernel_ || std::any_of(seen_.begin(), seen_.end(), isThis) ||
         std::any_of(taken_.begin(), taken_.end(), isThis);
}

bool WatchedFiles::isWorthChecking(double now) const {
  pollfd event{descriptor(), POLLIN, 0};
  return loadedOther_ || now >= lastCheck_ + pollMilliseconds() * 1e-3 || (event.fd >= 0 && ::poll(&event, 1, 0) > 0);
}

// A file that is followed for the first time may have changed after it was read.
void WatchedFiles::readAndFollow() {
  for (std::vector<ShaderSource> before; before.empty() || !haveSameTexts(before, seen_); follow()) {
    before = std::move(seen_);
    seen_ = readSources();
  }
}

void WatchedFiles::check(double now) {
  if (!isWorthChecking(now)) return;
  lastCheck_ = now;
  const std::vector<std::string> changes = watch_.takeChanges();
  if (changes.empty() && !loadedOther_) return;
  bool isChange = mistrusted_;
  if (std::exchange(loadedOther_, false)) {
    ++sceneEpoch_;
    isChange = true;
  }
  const std::vector<std::string> sceneFiles = filesOfScene();
  for (const std::string& file : changes) {
    if (std::find(sceneFiles.begin(), sceneFiles.end(), file) != sceneFiles.end()) {
      if (isAsLoaded(file)) continue;
      ++sceneEpoch_;
      isChange = true;
    } else if (!isKnownSource(file)) {
      otherChanged_ = isChange = true;
    }
  }
  const std::vector<ShaderSource> before = seen_;
  readAndFollow();
  isChange |= !haveSameTexts(before, seen_);
  if (!isChange) return;
  if (now >= quietUntil()) {
    ++burst_;
    firstChange_ = now;
  }
  lastChange_ = now;
  pending_ = true;
}

bool WatchedFiles::isDue(double now) {
  if (!pending_ || now < lastChange_ + kBreath) return false;
  pending_ = mistrusted_ || otherChanged_ || takenEpoch_ != sceneEpoch_ || !haveSameTexts(seen_, taken_);
  return pending_;
}

std::vector<ShaderSource> WatchedFiles::takeUp() {
  pending_ = mistrusted_ = otherChanged_ = false;
  takenEpoch_ = sceneEpoch_;
  readAndFollow();
  taken_ = seen_;
  return taken_;
}

double WatchedFiles::quietUntil() const {
  return std::min(lastChange_ + kQuiet, firstChange_ + kLongest);
}

void WatchedFiles::sceneWasLoaded(uint64_t epoch, const std::vector<SourceFile>& sources) {
  const std::vector<std::string> before = filesOfScene();
  loadedEpoch_ = epoch;
  loaded_ = sources;
  namedMeshes_.clear();
  follow();
  // A mesh that was not followed before may have changed since it was loaded.
  const std::vector<std::string> files = filesOf(scene_, loaded_);
  loadedOther_ = !isSceneStale() && std::any_of(files.begin() + 1, files.end(), [&](const std::string& file) {
    return std::find(before.begin(), before.end(), file) == before.end() && isSmall(file) && !isAsLoaded(file);
  });
}

void WatchedFiles::sceneWasRefused() try {
  namedMeshes_.clear();
  for (const std::string& name : namedFiles(readRegularFile(scene_)))
    namedMeshes_.push_back((fs::path(scene_).parent_path() / name).string());
  follow();
} catch (const InputError&) {
  follow();  // the scene's own return is what is waited for
}

void WatchedFiles::compilerRead(const std::vector<std::string>& files) {
  read_ = files;
  follow();
}

}  // namespace turner::watch
