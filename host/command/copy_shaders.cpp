// `turner shaders --copy DIR`.
#include <fmt/format.h>

#include <filesystem>

#include "command/commands.h"
#include "command/data_folder.h"
#include "errors.h"

namespace turner {

namespace fs = std::filesystem;

int copyShaders(const std::string& folder) try {
  // What somebody has edited there must not be lost.
  if (fs::exists(folder) && (!fs::is_directory(folder) || !fs::is_empty(folder)))
    throw InputError(folder + " is there already and not an empty folder; name a new one");
  const fs::path shaders = shaderFolder("");
  fs::create_directories(folder);
  for (const fs::directory_entry& file : fs::directory_iterator(shaders)) {
    const fs::path copy = folder / file.path().filename();
    fs::copy_file(file.path(), copy);
    fs::permissions(copy, fs::perms::owner_write, fs::perm_options::add);  // an installed file may be read-only
  }
  fmt::print("copied {} to {}; watch them with: turner watch SCENE --shaders {}\n", shaders.string(), folder, folder);
  return 0;
} catch (const fs::filesystem_error& error) {
  throw InputError(fmt::format("cannot copy the shaders to {}: {}", folder, error.code().message()));
}

}  // namespace turner
