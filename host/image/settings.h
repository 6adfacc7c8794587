// What a picture of a scene depends on besides the scene, and what comes back from either renderer (shader or
// reference): the picture and the count of its rays.
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "image/image.h"

namespace turner {

// Where the n x n samples of a pixel lie: at cell centres, hashed inside the cells, or so that they are spread evenly
// along each axis and in many boxes as well (camera.glsl tells how).
enum class Sampler { grid, jitter, sobol };

// As --sampler takes it.
inline const char* samplerName(Sampler sampler) {
  return sampler == Sampler::grid ? "grid" : sampler == Sampler::jitter ? "jitter" : "sobol";
}

// Words of the parameters of edited shaders, as the kernel reads them (Frame::parameters of layout.h).
using ParameterWords = std::array<std::array<uint32_t, 4>, 32>;

struct RenderSettings {
  int width = 512, height = 512;  // of the full picture, pixels
  Window crop{0, 0, 512, 512};    // the part to render
  int samples = 1;                // n of the n x n grid in each pixel
  Sampler sampler = Sampler::grid;
  uint32_t seed = 0;     // of the hashes of jitter and sobol
  int depth = 5;         // levels of the ray tree, the eye ray being level 1
  double minWeight = 0;  // rays whose product of r and t factors is below this are dropped
  ParameterWords parameters{};

  // What renderers compare that product with: a little less, so that 0.7 * 0.7 is not below 0.49, in double or in
  // float.
  double weightLimit() const { return minWeight * (1 - 0x1p-20); }
};

// Rays that were spawned, by kind; see "Counted is what is spawned" in docs/light_transport.md.
struct RayCounts {
  uint64_t eye = 0, reflected = 0, refracted = 0, shadow = 0;
  uint64_t total() const { return eye + reflected + refracted + shadow; }
  bool operator==(const RayCounts&) const = default;
};

// Called now and then from the thread that called the renderer, with the share of the work that is done, in [0, 1].
// May throw (Interrupted): the renderer then cleans up and lets it pass.
using Progress = std::function<void(double)>;

}  // namespace turner
