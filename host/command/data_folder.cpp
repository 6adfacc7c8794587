// Looks beside the program first, then in the source tree it was built from.
#include "command/data_folder.h"

#include <filesystem>

#include "base/descriptor_io.h"
#include "base/errors.h"

namespace turner {

namespace fs = std::filesystem;

std::string dataFolder() {
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
  const fs::path installed = (program.parent_path().parent_path() / TURNER_DATA_DIR).lexically_normal();
  const fs::path source = TURNER_SOURCE_DIR;
  for (const fs::path& folder : {installed, source})
    if (fs::is_directory(folder / "shaders", ignored)) return folder.string();
  throw RunError("the shaders are neither in " + (installed / "shaders").string() + " nor in " +
                 (source / "shaders").string() + "; install turner again, or name their folder with --shaders");
}

std::string shaderFolder(const std::string& wanted) {
  const std::string folder = wanted.empty() ? dataFolder() + "/shaders" : wanted;
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored))
    throw InputError("there is no folder " + folder + "; --shaders names the one with whitted.comp");
  return folder;
}

std::string findScene(const std::string& path) {
  std::error_code ignored;
  if (path == kStandardStream || fs::exists(path, ignored) || fs::path(path).is_absolute()) return path;
  try {
    const std::string found = dataFolder() + '/' + path;
    if (fs::exists(found, ignored)) return found;
  } catch (const RunError&) {
    // Without a data folder the path stands for itself; loading it will say what is wrong.
  }
  return path;
}

}  // namespace turner
