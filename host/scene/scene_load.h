// From a scene file to a Scene that may be rendered: everything in it has been checked.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"

namespace turner {

// What a parser makes of a file. scene_load adds what the file left out.
struct ParsedScene {
  Scene scene;
  bool hasCamera = false;
};

// Reads a .json or .nff scene with its meshes; "-" is standard input, and what a pipe has is told by its beginning.
// Throws InputError with every fault it finds. A scene without lights, objects or camera is complete here too (no
// lights, no primitives, a camera fitted to the bounds) and says so in Scene::notes. Triangles without area are
// dropped, which is noted too.
Scene loadScene(const std::string& path);

// The scene's file and its meshes, which stand beside it or below, as the sources of a loaded scene name them.
std::vector<std::string> filesOf(const std::string& path, const std::vector<SourceFile>& sources);

}  // namespace turner
