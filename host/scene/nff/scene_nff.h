// The Neutral File Format of Eric Haines' Standard Procedural Databases.
#pragma once

#include <string>
#include <string_view>

#include "scene/scene_load.h"

namespace turner {

// Cones and cylinders become this many smooth quads around the axis, and one or more along it: two triangles each, one
// where a radius is 0.
inline constexpr int kConeSegments = 32;

// How many pieces that is along the axis, for a cone of this length and larger radius.
int conePieces(double length, double radius);

// Throws InputError with all faults, each at its line and column of `path`.
ParsedScene parseNffScene(const std::string& path, std::string_view text);

}  // namespace turner
