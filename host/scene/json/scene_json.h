// Turner's own scene format, scenes/scene.schema.json. RapidJSON appears in json_tree.cpp only.
#pragma once

#include <string>
#include <string_view>

#include "scene/scene_load.h"

namespace turner {

// `path` is printed in faults; meshes are looked for beside it. Throws InputError with all faults.
ParsedScene parseJsonScene(const std::string& path, std::string_view bytes);

}  // namespace turner
