// Files are written into a hidden folder, which is renamed in the end.
#include "watch/output/kept_versions.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "base/errors.h"
#include "base/number.h"
#include "base/output_file.h"
#include "base/temporary.h"

namespace turner::watch {

namespace fs = std::filesystem;

namespace {

constexpr long long kMostVersions = 1'000'000'000;

// 7 of "0007"; 0 where a name is not that of a version.
int versionOf(const std::string& name) {
  long long number = 0;
  if (name.size() < 4 || name.find_first_not_of("0123456789") != std::string::npos) return 0;
  return parseInteger(name, number) == NumberFault::none && number < kMostVersions ? int(number) : 0;
}

void writeInto(const fs::path& file, const std::string& bytes) {
  fs::create_directories(file.parent_path());
  writeWholeFile(file.string(), bytes);
}

// Where a source goes in the version's folder: as it lies in the shaders' own.
fs::path placeOf(const ShaderSource& source, size_t index) {
  const std::string name = index == 0 ? fs::path(source.path).filename().string() : source.name;
  const fs::path location = ("shaders" / fs::path(name)).lexically_normal();
  // What is included from far away cannot keep its place.
  return *location.begin() == ".." ? fs::path("outside") / std::to_string(index) / location.filename() : location;
}

}  // namespace

int lastKeptVersion(const std::string& folder) try {
  fs::create_directories(folder);
  int last = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    last = std::max(last, versionOf(entry.path().filename().string()));
  checkWritable(folder + "/figures.json");
  return last;
} catch (const fs::filesystem_error& error) {
  throw InputError(folder + ": error: cannot keep versions there: " + error.code().message());
}

std::string keepVersion(const std::string& folder, int number, const KeptVersion& version) {
  const fs::path target = fs::path(folder) / fmt::format("{:04}", number);
  try {
    fs::create_directories(folder);  // somebody may have deleted it
    Temporary made(target, Temporary::Kind::folder);
    const fs::path& temporary = made.path();
    for (size_t i = 0; i < version.sources.size(); ++i)
      if (version.sources[i].text) writeInto(temporary / placeOf(version.sources[i], i), *version.sources[i].text);
    if (!version.sceneName.empty()) writeInto(temporary / "scene" / version.sceneName, version.sceneText);
    writeInto(temporary / "picture.exr", version.picture);
    writeInto(temporary / "figures.json", version.figures);
    if (!version.parameters.empty()) writeInto(temporary / "params.json", version.parameters);
    made.moveIntoPlace();
  } catch (const std::system_error& error) {  // fs::filesystem_error is one
    throw RunError(target.string() + ": error: cannot keep the version: " + error.code().message());
  }
  return target.string();
}

void keepFigures(const std::string& versionFolder, const std::string& figures) {
  writeWholeFile((fs::path(versionFolder) / "figures.json").string(), figures);
}

}  // namespace turner::watch
