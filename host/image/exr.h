// OpenEXR in and out. OpenEXR appears in exr.cpp only.
#pragma once

#include <glm/mat4x4.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "image/image.h"

namespace turner {

// What an EXR says about its picture beside the pixels.
struct Provenance {
  std::vector<std::pair<std::string, std::string>> strings;  // attribute name, value
  // Standard attributes of OpenEXR, in the column-vector convention of GLM; exr.cpp transposes for Imath.
  std::optional<glm::dmat4> worldToCamera;
  std::optional<glm::dmat4> worldToNdc;
};

// Encodes float32 R, G, B with ZIP compression: display window = the full picture, data window = image.window,
// chromaticities of Rec. 709. Depends on its arguments alone: no dates, no thread count.
std::string encodeExr(const Image& image, const Provenance& provenance);

// Reads R, G, B (half or float, any compression; extra channels are ignored) of an EXR file.
// Throws InputError naming the file if it is missing, damaged, not an EXR, or lacks a channel.
Image readExr(const std::string& path);

}  // namespace turner
