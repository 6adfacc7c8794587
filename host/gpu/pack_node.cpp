// Quantises the planes of two boxes and names the children.
#include "gpu/pack_node.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "primitives/words.h"

namespace turner {
namespace {

using gpu::uint;

// Trees are built within the builder's default limits; the kernel's numbers have room for no more.
static_assert(BvhLimits{}.maxLeafSize == gpu::kMaxLeafSize && BvhLimits{}.maxDepth == int(gpu::kMaxTreeDepth));

// The least power of two of which 255 reach over a distance, as the exponent byte of a float.
uint planeExponent(double distance) {
  const int exponent = distance > 0 ? std::ilogb(distance / 255) + 1 : -126;
  return uint(std::clamp(exponent, -126, 127) + 127);
}

}  // namespace

uint leafReference(const BvhChild& leaf, std::span<const uint> references) {
  return gpu::kRefLeaf | ((leaf.count - 1) << gpu::kRefCountShift) | references[leaf.first];
}

gpu::Node packNode(const Bvh::Node& node, std::span<const uint> references) {
  // A leaf comes first, so that the kernel finds an inner child next to its parent.
  const bool swapped = node.children[0].count == 0 && node.children[1].count > 0;
  const BvhChild& first = node.children[swapped ? 1 : 0];
  const BvhChild& second = node.children[swapped ? 0 : 1];
  const glm::dvec3 lo = glm::min(first.box.lo, second.box.lo), hi = glm::max(first.box.hi, second.box.hi);

  uint exponents = 0;
  uint planes[3];
  for (int k = 0; k < 3; ++k) {
    const uint exponent = planeExponent(hi[k] - lo[k]);
    const double scale = std::ldexp(1.0, int(exponent) - 127);
    const auto down = [&](float plane) { return uint(std::floor((double(plane) - lo[k]) / scale)); };
    const auto up = [&](float plane) { return uint(std::ceil((double(plane) - lo[k]) / scale)); };
    planes[k] =
        down(first.box.lo[k]) | up(first.box.hi[k]) << 8 | down(second.box.lo[k]) << 16 | up(second.box.hi[k]) << 24;
    exponents |= exponent << (8 * k);
  }

  uint reference = second.first, tags = 0;
  if (first.count > 0) {
    reference = leafReference(first, references);
    tags = 1;
  }
  if (second.count > 0) {
    const uint type = references[second.first];
    tags = 3 | (second.count - 1) << 2;
    if (type & gpu::kRefTriangle)
      tags |= 1u << 4;
    else if (type & gpu::kRefCone)
      tags |= 1u << 5;
  }
  return {.origin = toVec3(lo),
          .exponents = exponents | tags << 24,
          .planes = {planes[0], planes[1], planes[2]},
          .reference = reference};
}

}  // namespace turner
