// Hashes a file beside parsing it.
#include "scene/json/mesh_files.h"

#include <future>
#include <string_view>
#include <utility>

#include "base/errors.h"
#include "base/text_file.h"

namespace turner {

MeshFiles::File* MeshFiles::open(size_t at, const Field& field, const std::string& file, Scene& scene) {
  if (lowerExtension(file) != ".obj" || file.find('\0') != std::string::npos) {
    fields_.addFault(at, field, "the path of an .obj file");
    return nullptr;
  }

  const std::string path = pathOf(file);
  File& entry = files_[path];
  if (std::exchange(entry.isRead, true)) return &entry;

  std::string text;
  try {
    text = readTextFile(path);
  } catch (const InputError& error) {
    // It says "PATH: error: REASON"; the place here is that of the name in the scene.
    std::string reason = error.what();
    if (const std::string prefix = path + ": error: "; reason.starts_with(prefix)) reason.erase(0, prefix.size());
    fields_.addMessage(at, field, "found " + quote(file) + "; " + reason);
    return &entry;
  }
  std::future<std::string> hash = std::async(sha256Hex, std::string_view(text));  // beside the parser, on another core
  try {
    entry.mesh = parseObj(path, text);
  } catch (const InputError& error) {
    if (!faults_.empty()) faults_ += '\n';
    faults_ += error.what();
    return &entry;
  }
  scene.sources.push_back({file, hash.get()});
  std::vector<std::string>& notes = entry.mesh->notes;
  scene.notes.insert(scene.notes.end(), notes.begin(), notes.end());
  return &entry;
}

}  // namespace turner
