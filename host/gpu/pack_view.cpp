// Pixels as directions: exact ones for the kernel, clipped ones for the lists.
#include "gpu/pack_view.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "image/camera_basis.h"
#include "primitives/words.h"

namespace turner {

using gpu::uint;

std::array<FaceWindow, 6> viewWindows(const Camera& camera, const RenderSettings& settings) {
  const CameraBasis basis = cameraBasis(camera);
  const double pixel = 2 * basis.tanHalfFov / settings.height;
  const auto direction = [&](int x, int y) {
    return basis.forward + pixel * ((x - 0.5 * settings.width) * basis.right - (y - 0.5 * settings.height) * basis.up);
  };
  const Window& crop = settings.crop;
  std::array<FaceWindow, 6> windows;
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, a = (axis + 1) % 3, b = (axis + 2) % 3;
    const double sign = face % 2 ? -1 : 1;
    std::vector<glm::dvec3> polygon = {direction(crop.x0, crop.y0), direction(crop.x1, crop.y0),
                                       direction(crop.x1, crop.y1), direction(crop.x0, crop.y1)};
    // Keep what lies within |u| <= 1 and |v| <= 1, plane by plane (Sutherland, Hodgman 1974), with room for rounding.
    for (const auto& [component, side] : {std::pair{a, 1.0}, {a, -1.0}, {b, 1.0}, {b, -1.0}}) {
      const auto inside = [&, k = component, s = side](const glm::dvec3& d) {
        return (1 + 1e-6) * sign * d[axis] - s * d[k];
      };
      std::vector<glm::dvec3> kept;
      for (size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
        const double ip = inside(p), iq = inside(q);
        if (ip >= 0) kept.push_back(p);
        if ((ip < 0) != (iq < 0)) kept.push_back(p + (ip / (ip - iq)) * (q - p));
      }
      polygon = std::move(kept);
    }
    FaceWindow& window = windows[size_t(face)];
    window = {1, -1, 1, -1};
    for (const glm::dvec3& d : polygon) {
      const double u = d[a] / d[axis], v = d[b] / d[axis];
      window = {std::min(window.uLo, u), std::max(window.uHi, u), std::min(window.vLo, v), std::max(window.vHi, v)};
    }
  }
  return windows;
}

gpu::Frame packFrame(const View& view, const RenderSettings& settings, uint32_t deviceThreads) {
  const CameraBasis basis = cameraBasis(view.camera);
  const double pixel = 2 * basis.tanHalfFov / settings.height;
  const glm::dvec3 perRight = pixel * basis.right, perDown = -pixel * basis.up;

  gpu::Frame frame{};
  frame.centreHi = toVec3(basis.forward);
  frame.centreLo = toVec3Rest(basis.forward);
  frame.rightHi = toVec3(perRight);
  frame.rightLo = toVec3Rest(perRight);
  frame.downHi = toVec3(perDown);
  frame.downLo = toVec3Rest(perDown);
  frame.worldEyeHi = toVec3(view.frame.origin);
  frame.worldEyeLo = toVec3Rest(view.frame.origin);
  frame.worldScale = float(view.frame.scale);
  frame.background = toVec3(view.background);
  frame.media = view.media;
  frame.root = view.root;
  frame.width = uint(settings.width);
  frame.height = uint(settings.height);
  frame.seed = settings.seed;
  frame.minWeight = float(settings.weightLimit());
  frame.threads = deviceThreads;
  frame.canaryLength = gpu::kCanaryLength;
  static_assert(sizeof frame.parameters == sizeof settings.parameters);
  std::memcpy(frame.parameters, settings.parameters.data(), sizeof frame.parameters);
  return frame;
}

}  // namespace turner
