// The Neutral File Format of Eric Haines' Standard Procedural Databases.
#pragma once

#include <string>
#include <string_view>

#include "scene/scene_load.h"

namespace turner {

// Throws InputError with all faults, each at its line and column of `path`.
ParsedScene parseNffScene(const std::string& path, std::string_view bytes);

}  // namespace turner
