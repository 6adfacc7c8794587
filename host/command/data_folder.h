// Where shaders and scenes are.
#pragma once

#include <string>

namespace turner {

// The folder that holds shaders/ and scenes/: beside an installed program (../share/turner), else the source tree that
// the program was built from. Throws RunError naming both when neither is there.
std::string dataFolder();

// The folder of the kernel's sources: `wanted` if not empty, else the one in the data folder. Throws InputError if it
// is missing.
std::string shaderFolder(const std::string& wanted);

// A scene's path: as given if it exists, else the same path below the data folder if it exists there, so that
// "scenes/spheres.json" means something everywhere; else as given.
std::string findScene(const std::string& path);

}  // namespace turner
