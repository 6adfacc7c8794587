// OpenEXR in and out. OpenEXR appears in exr.cpp only.
#pragma once

#include <glm/mat4x4.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "image/image.h"
#include "image/primaries.h"

namespace turner {

// What an EXR says about its picture beside the pixels.
struct Provenance {
  std::vector<std::pair<std::string, std::string>> strings;  // attribute name, value
  // Standard attributes of OpenEXR, in the column-vector convention of GLM; exr.cpp transposes for Imath.
  std::optional<glm::dmat4> worldToCamera;
  std::optional<glm::dmat4> worldToNdc;
  Chromaticities chromaticities = kRec709;
  float pixelAspectRatio = 1;
};

// Encodes float32 R, G, B with ZIP compression: display window = the full picture, data window = image.window. Depends
// on its arguments alone: no dates, no thread count.
std::string encodeExr(const Image& image, const Provenance& provenance);

// A file's picture, and what its numbers mean.
struct ExrPicture {
  Image image;
  Chromaticities chromaticities = kRec709;
  float pixelAspectRatio = 1;
  bool isCoarse = false;  // of turner watch: every eighth pixel
  std::string part;       // that was read, where several have R, G and B
  int candidates = 1;     // parts that have
};

// Reads R, G, B (half or float, any compression; extra channels are ignored) of an EXR file: of its first part that has
// them and is not deep. Throws InputError naming the file if it is missing, damaged, not an EXR, or has no such part.
ExrPicture readExrPicture(const std::string& path);
// The image alone.
Image readExr(const std::string& path);

}  // namespace turner
