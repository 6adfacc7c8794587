// In: a shader's path. Out: its files, found by their lines' look.
#include "kernel/shader_sources.h"

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "base/errors.h"
#include "base/text_file.h"

namespace turner {
namespace {

namespace fs = std::filesystem;

// A file that includes itself by ever longer names ("../shaders/a.glsl") ends here.
constexpr size_t kMostFiles = 256;

void skipBlanks(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
}

bool skipWord(std::string_view& line, std::string_view word) {
  if (!line.starts_with(word)) return false;
  line.remove_prefix(word.size());
  return true;
}

// The name in a line #include "name"; empty where the line is none.
std::string_view includedName(std::string_view line) {
  skipBlanks(line);
  if (!skipWord(line, "#")) return {};
  skipBlanks(line);
  if (!skipWord(line, "include")) return {};
  skipBlanks(line);
  if (!skipWord(line, "\"")) return {};
  const size_t end = line.find('"');
  return end == std::string_view::npos ? std::string_view() : line.substr(0, end);
}

std::vector<std::string> includedNames(std::string_view text) {
  std::vector<std::string> names;
  while (!text.empty()) {
    const size_t end = std::min(text.find_first_of("\r\n"), text.size());
    const std::string_view name = includedName(text.substr(0, end));
    if (!name.empty()) names.emplace_back(name);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return names;
}

std::optional<std::string> textIfReadable(const std::string& path) {
  try {
    return readRegularFile(path);
  } catch (const InputError&) {
    return std::nullopt;  // the compiler reads it again and has the place for the message
  }
}

}  // namespace

std::vector<ShaderSource> readShaderSources(const std::string& path) {
  std::vector<ShaderSource> sources = {{"", path, readRegularFile(path)}};
  const fs::path folder = fs::path(path).parent_path();
  for (size_t i = 0; i < sources.size(); ++i) {
    if (!sources[i].text) continue;
    const fs::path beside = fs::path(sources[i].name).parent_path();
    for (const std::string& included : includedNames(*sources[i].text)) {
      // An absolute path would give one and the same name different meanings in different folders.
      if (fs::path(included).is_absolute() || sources.size() == kMostFiles) continue;
      const std::string name = (beside / included).string();
      if (findSource(sources, name)) continue;
      const std::string file = (folder / name).string();
      sources.push_back({name, file, textIfReadable(file)});
    }
  }
  return sources;
}

const ShaderSource* findSource(const std::vector<ShaderSource>& sources, const std::string& name) {
  const auto found =
      std::find_if(sources.begin(), sources.end(), [&](const ShaderSource& source) { return source.name == name; });
  return found == sources.end() ? nullptr : &*found;
}

}  // namespace turner
