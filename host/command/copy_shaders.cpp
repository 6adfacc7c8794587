// `turner shaders --copy DIR`.
#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>

#include "base/errors.h"
#include "command/commands.h"
#include "command/data_folder.h"

namespace turner {

namespace fs = std::filesystem;

namespace {

// An installed file may be read-only.
void makeWritable(const fs::path& folder) {
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
    fs::permissions(entry, fs::perms::owner_write, fs::perm_options::add);
}

}  // namespace

int copyShaders(const std::string& folder) {
  const fs::path shaders = shaderFolder("");
  // Copied beside, then renamed: the folder is there whole or not at all.
  const fs::path target = fs::absolute(folder).lexically_normal();
  const fs::path place = target.has_filename() ? target : target.parent_path();
  fs::path temporary = place;
  temporary += fmt::format(".turner-{}", ::getpid());
  try {
    // What somebody has edited there must not be lost.
    if (fs::exists(place) && (!fs::is_directory(place) || !fs::is_empty(place)))
      throw InputError(folder + " is there already and not an empty folder; name a new one");
    fs::create_directories(place.parent_path());
    fs::copy(shaders, temporary, fs::copy_options::recursive);
    makeWritable(temporary);
    fs::rename(temporary, place);
  } catch (const fs::filesystem_error& error) {
    std::error_code ignored;
    fs::remove_all(temporary, ignored);
    throw RunError(fmt::format("cannot copy the shaders to {}: {}", folder, error.code().message()));
  }
  fmt::print("copied {} to {}; watch them with: turner watch SCENE --shaders {}\n", shaders.string(), folder, folder);
  return 0;
}

}  // namespace turner
