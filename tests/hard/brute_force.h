// An oracle: every primitive in double, spheres by the perpendicular and half the chord, triangles by signed volumes;
// cones in 113 bits, with all of their measures a hair more and less.
// Where float32 may decide either way it says so.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/geometric.hpp>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "hard/cone_oracle.h"
#include "hard/kernels.h"
#include "hard/vectors.h"
#include "scene/scene.h"

namespace turner::hard {

struct Meeting {
  double t;
  bool sure;  // false: so near to the edge that rounding the scene's numbers once more might decide
};

inline constexpr double kUnsure = 1e-6;     // of the distance: some roundings of the numbers that a test begins with
inline constexpr double kSameDepth = 1e-4;  // relative: which of two hits is the nearer is not asked

inline std::optional<Meeting> meet(const Sphere& sphere, const dvec3& origin, const dvec3& direction) {
  const dvec3 toCentre = sphere.center - origin;
  const double length = glm::length(direction), distance = glm::length(toCentre);
  const double middle = glm::dot(toCentre, direction) / (length * length);
  const double impact = glm::length(glm::cross(toCentre, direction)) / length;
  const double unsure = kUnsure * (distance + sphere.radius);
  if (impact > sphere.radius + unsure) return {};
  const double half = std::sqrt(std::max(0.0, sphere.radius * sphere.radius - impact * impact)) / length;
  const double t = middle - half > 0 ? middle - half : middle + half;
  if (t < -unsure / length) return {};
  const bool onSurface = std::abs(distance - sphere.radius) < unsure;
  return Meeting{std::max(t, 0.0), std::abs(impact - sphere.radius) > unsure && !onSurface};
}

inline std::optional<Meeting> meet(const TriangleCorners& corners, const dvec3& origin, const dvec3& direction) {
  const TriangleCorners v = {corners[0] - origin, corners[1] - origin, corners[2] - origin};
  int surelyLeft = 0, surelyRight = 0;
  for (size_t i = 0; i < 3; ++i) {
    const dvec3 &a = v[i], &b = v[(i + 1) % 3];
    const double volume = glm::dot(direction, glm::cross(a, b));
    const double unsure =
        kUnsure * glm::length(direction) * glm::length(b - a) * std::max(glm::length(a), glm::length(b));
    surelyLeft += volume > unsure;
    surelyRight += volume < -unsure;
  }
  if (surelyLeft > 0 && surelyRight > 0) return {};
  const dvec3 normal = glm::cross(v[1] - v[0], v[2] - v[0]);
  const double slope = glm::dot(normal, direction), t = glm::dot(normal, v[0]) / slope;
  const double unsure =
      kUnsure * std::max({glm::length(v[0]), glm::length(v[1]), glm::length(v[2])}) /
      (glm::length(direction) * std::abs(glm::dot(glm::normalize(normal), glm::normalize(direction))));
  if (t < -unsure) return {};
  return Meeting{t, surelyLeft + surelyRight == 3 && t > unsure};
}

inline std::optional<Meeting> meet(const Cone& cone, const dvec3& origin, const dvec3& direction) {
  // Most rays pass it far away.
  const dvec3 middle = 0.5 * (cone.base + cone.apex), unit = glm::normalize(direction);
  const double reach = glm::length(cone.apex - cone.base) + std::abs(cone.baseRadius) + std::abs(cone.apexRadius);
  if (glm::length(glm::cross(middle - origin, unit)) > reach) return {};
  const double unsure = kUnsure * ConeOracle(cone).scaleFrom(origin);
  // Its radii and its length more by so much, or less.
  const auto first = [&](double more) {
    const dvec3 axis = glm::normalize(cone.apex - cone.base);
    const double baseRadius = std::max(0.0, std::abs(cone.baseRadius) + more),
                 apexRadius = std::max(0.0, std::abs(cone.apexRadius) + more);
    const Cone other{cone.base - more * axis, baseRadius, cone.apex + more * axis, apexRadius, 0};
    const std::vector<ConeMeeting> meetings = ConeOracle(other).meetings(origin, direction);
    return meetings.empty() ? std::nullopt : std::optional(meetings.front());
  };
  const auto more = first(unsure), less = first(-unsure), itself = first(0);
  if (!more) return {};
  const bool sure = less && itself && more->fromOutside == itself->fromOutside &&
                    less->fromOutside == itself->fromOutside && itself->t * length(wide(direction)) > Wide(unsure);
  return Meeting{double(sure ? itself->t : more->t), sure};
}

struct Truth {
  uint32_t id = kNothing;
  bool sure = true;
};

// Of primitives in any order: which one is nearest. Equal ones give equal distances, and the lowest id wins.
class Nearest {
 public:
  void add(uint32_t id, const std::optional<Meeting>& meeting) {
    if (meeting && !(meeting->t > limit_)) take(id, *meeting);
  }
  Truth truth() const {
    Truth truth{id_, true};
    for (const auto& [id, other] : near_)
      if (id != id_ && other.t != meeting_.t && !(other.t > limit_)) truth.sure = false;
    if (id_ != kNothing && !meeting_.sure) truth.sure = false;
    return truth;
  }

 private:
  void take(uint32_t id, const Meeting& meeting) {
    near_.emplace_back(id, meeting);
    if (!(meeting.t < meeting_.t || (meeting.t == meeting_.t && id < id_))) return;
    id_ = id;
    meeting_ = meeting;
    limit_ = meeting.t * (1 + kSameDepth);
  }
  uint32_t id_ = kNothing;
  Meeting meeting_{INFINITY, true};
  double limit_ = INFINITY;
  std::vector<std::pair<uint32_t, Meeting>> near_;
};

// visit(sphere), visit(cone) or visit(triangle): that of the id.
template <class Itself, class Visit>
void visitPrimitive(Itself& scene, uint32_t id, const Visit& visit) {
  size_t first = 0;
  Scene::visitPrimitives(scene, [&](const char*, auto& primitives) {
    if (id >= first && id - first < primitives.size()) visit(primitives[id - first]);
    first += primitives.size();
  });
}

inline void addPrimitive(Nearest& nearest, const Scene& local, uint32_t id, const dvec3& origin,
                         const dvec3& direction) {
  local.visitPrimitive(id, [&](const auto& primitive, size_t) {
    if constexpr (std::is_same_v<std::decay_t<decltype(primitive)>, Triangle>)
      nearest.add(id, meet(local.cornersOf(primitive), origin, direction));
    else
      nearest.add(id, meet(primitive, origin, direction));
  });
}

inline Truth bruteForce(const Scene& local, const dvec3& origin, const dvec3& direction) {
  Nearest nearest;
  for (uint32_t id = 0; id < local.primitiveCount(); ++id) addPrimitive(nearest, local, id, origin, direction);
  return nearest.truth();
}

// The unit direction through the middle of a pixel of a square picture.
inline dvec3 pixelDirection(const Camera& camera, int size, double x, double y) {
  const dvec3 forward = glm::normalize(camera.target - camera.eye);
  const dvec3 right = glm::normalize(glm::cross(forward, camera.up)), up = glm::cross(right, forward);
  const double pixel = 2 * std::tan(camera.fov * std::numbers::pi / 360) / size;
  return glm::normalize(forward + pixel * ((x + 0.5 - 0.5 * size) * right - (y + 0.5 - 0.5 * size) * up));
}

}  // namespace turner::hard
