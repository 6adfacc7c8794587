// The Neutral File Format of Eric Haines' Standard Procedural Databases.
#pragma once

#include <string>
#include <string_view>

#include "scene_load.h"

namespace turner {

// Cones and cylinders become this many smooth quads around the axis: two triangles each, one where a radius is 0.
inline constexpr int kConeSegments = 32;

// Throws InputError with all faults, each at its line and column of `path`.
ParsedScene parseNffScene(const std::string& path, std::string_view text);

}  // namespace turner
