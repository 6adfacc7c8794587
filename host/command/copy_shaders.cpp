// `turner shaders --copy DIR`.
#include <filesystem>
#include <system_error>

#include "base/errors.h"
#include "base/file_identity.h"
#include "base/tell.h"
#include "base/temporary.h"
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

// A copy inside of what is copied would have no end, and a shader's folder is no place for one.
void refuseWithin(const fs::path& shaders, const fs::path& place, const std::string& folder) {
  for (fs::path above = place; above != above.parent_path(); above = above.parent_path()) {
    std::error_code missing;
    if (fs::equivalent(above, shaders, missing))
      throw InputError(folder + " is in the folder that is copied, " + shaders.string() + "; name a folder elsewhere");
  }
}

fs::path withoutLastSlash(const fs::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

}  // namespace

int copyShaders(const std::string& folder) {
  const fs::path shaders = shaderFolder("");
  // Copied beside, then renamed: the folder is there whole or not at all.
  try {
    // A link may lead to a folder that is yet to be made.
    const fs::path named = followLinks(withoutLastSlash(fs::absolute(folder)));
    const fs::path place = withoutLastSlash(fs::weakly_canonical(named));
    refuseWithin(shaders, place, folder);
    // What somebody has edited there must not be lost.
    if (fs::exists(place) && (!fs::is_directory(place) || !fs::is_empty(place)))
      throw InputError(folder + " is there already and not an empty folder; name a new one");
    fs::create_directories(place.parent_path());
    Temporary made(place, Temporary::Kind::folder);
    fs::copy(shaders, made.path(), fs::copy_options::recursive);
    makeWritable(made.path());
    made.moveIntoPlace();
  } catch (const std::system_error& error) {  // fs::filesystem_error is one
    throw RunError("cannot copy the shaders to " + folder + ": " + error.code().message());
  }
  tell("copied {} to {}; watch them with: turner watch SCENE --shaders {}\n", shaders.string(), folder, folder);
  return 0;
}

}  // namespace turner
