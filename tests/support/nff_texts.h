// Beginnings of NFF files, and what they become.
#pragma once

#include <string>

#include "scene/nff/scene_nff.h"

namespace turner::test {

inline const std::string kNffView = "v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 45\nhither 1\nresolution 320 200\n";
inline const std::string kNffMaterial = "f 1 0.5 0.25 0.8 0.5 3 0.25 1.5\n";

inline Scene parseNff(const std::string& text) {
  return parseNffScene("dir/test.nff", text).scene;
}

}  // namespace turner::test
