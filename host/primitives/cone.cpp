// Axis and angles are computed in long double, from the rounded ends, and rounded once.
#include "primitives/cone.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <optional>
#include <utility>

#include "primitives/cube_face.h"
#include "primitives/features.h"
#include "primitives/words.h"

namespace turner {
namespace {

// A cone from its anchor, the end of the lesser radius, on.
struct Axis {
  wide3 anchor, direction;             // direction: unit
  long double length, radius, growth;  // radius at the anchor; by how much it is more at the other end
  long double slant() const { return std::sqrt(length * length + growth * growth); }
};

bool isAnchoredAtApex(const Cone& cone) {
  return std::abs(cone.baseRadius) > std::abs(cone.apexRadius);
}

Axis axisOf(const Cone& cone) {
  const bool swapped = isAnchoredAtApex(cone);
  const wide3 base(cone.base), apex(cone.apex), way = swapped ? base - apex : apex - base;
  const long double baseRadius = std::abs(cone.baseRadius), apexRadius = std::abs(cone.apexRadius);
  const long double length = glm::length(way);
  return {swapped ? apex : base, way / length, length, std::min(baseRadius, apexRadius),
          std::abs(apexRadius - baseRadius)};
}

double widest(const Cone& cone) {
  return std::max(std::abs(cone.baseRadius), std::abs(cone.apexRadius));
}

}  // namespace

bool isTooFlat(const Cone& cone) {
  const Axis axis = axisOf(cone);
  return axis.growth > kFlattestCone * axis.length;
}

Bounds boundsOf(const Cone& cone) {
  const glm::dvec3 way(axisOf(cone).direction);
  Bounds bounds;
  for (const auto& [center, radius] : {std::pair(cone.base, cone.baseRadius), {cone.apex, cone.apexRadius}}) {
    glm::dvec3 reach(0);
    // Of a circle: its radius times sqrt(1 - a_k^2), from the other two components, which do not cancel.
    for (int k = 0; k < 3; ++k) reach[k] = std::abs(radius) * std::hypot(way[(k + 1) % 3], way[(k + 2) % 3]);
    reach += 0x1p-50 * (glm::abs(center) + std::abs(radius));  // more than the roundings of all this
    bounds.include(Bounds{center - reach, center + reach});
  }
  return bounds;
}

Cone toLocal(const Cone& world, const LocalFrame& frame) {
  Cone local = world;
  local.baseRadius = rounded(world.baseRadius * frame.scale);
  local.apexRadius = rounded(world.apexRadius * frame.scale);
  local.base = toLocal(world.base, frame);
  local.apex = toLocal(world.apex, frame);
  glm::dvec3 way = (world.apex - world.base) * frame.scale;
  if (widest(local) <= glm::length(way) && local.base != local.apex) return local;
  // So short that a double beside the anchor would lose it: nobody sees how long it is, but it needs an axis.
  const glm::dvec3 reach = glm::abs(isAnchoredAtApex(local) ? local.apex : local.base);
  const double least = std::max({0x1p-44 * std::max({reach.x, reach.y, reach.z}), 0x1p-44 * widest(local), 1e-30});
  if (glm::length(way) < least)
    way = glm::dvec3(axisOf(world).direction * (long double)(least)) * (isAnchoredAtApex(world) ? -1.0 : 1.0);
  if (isAnchoredAtApex(local))
    local.base = local.apex - way;
  else
    local.apex = local.base + way;
  return local;
}

bool isWithinReach(const Cone& local) {
  return isWithin(local.base, kMostLocal) && isWithin(local.apex, kMostLocal) && widest(local) <= kMostLocal;
}

bool isFarFromEye(const Cone& local) {
  // As of a sphere.
  return std::max(glm::length(local.base), glm::length(local.apex)) > 1024 * widest(local);
}

double slopeOf(const Cone& local) {
  const Axis axis = axisOf(local);
  return double(axis.growth / axis.slant());
}

void addFeatures(const Cone& local, Features& features) {
  const double slope = slopeOf(local);
  features.cones = true;
  features.slopedCones |= slope != 0;
  features.steepCones |= slope > 0.7071;
  features.farCones |= isFarFromEye(local);
}

uint32_t referenceType(const Cone&) {
  return gpu::kRefCone;
}

gpu::Cone packed(const Cone& local, uint32_t rank) {
  const Axis axis = axisOf(local);
  const long double cosine = axis.length / axis.slant(), widest = axis.radius + axis.growth;
  const double reach = double(std::sqrt(axis.length * axis.length + widest * widest)) * (1 + 0x1p-20);
  const wide3 rest = axis.direction - wide3(glm::vec3(axis.direction));
  return {.anchor = toVec3(glm::dvec3(axis.anchor)),
          .base = float(axis.radius * cosine),
          .axis = toVec3(glm::vec3(axis.direction)),
          .span = float(axis.length),
          .rank = rank,
          .material =
              local.material | (isFarFromEye(local) ? gpu::kFarCone : 0) | (local.isInward() ? gpu::kConeInward : 0),
          .reach = float(reach),
          .slope = float(axis.growth / axis.slant()),
          .axisRest = toVec3(glm::dvec3(rest)),
          .squaredCosine = float(cosine * cosine)};
}

// --- the picture on a face ---
// All of a disc (center c, radius r, across a unit axis a) is where x u + y v + z >= 0 if N.c >= r |N x a|, with
// N = (x, y, z). For given x and y the z where both are equal is a root of a quadratic: the plane through the point
// that touches the disc. A cone lies in the hull of its two ends.
namespace {

struct Disc {
  glm::dvec3 center;  // seen from the point: along u, v and the face's axis
  double radius;
};

// The least z for which the disc is all on the positive side.
double touching(const Disc& disc, const glm::dvec3& a, double x, double y) {
  // (N.c)^2 = r^2 (|N|^2 - (N.a)^2), N.c >= 0
  const glm::dvec3& c = disc.center;
  const double squared = disc.radius * disc.radius, k = x * c.x + y * c.y, m = x * a.x + y * a.y, n = x * x + y * y;
  const double A = c.z * c.z - squared * (1 - a.z * a.z), B = k * c.z + squared * m * a.z,
               C = k * k - squared * (n - m * m);
  return (-B + std::sqrt(std::max(0.0, B * B - A * C))) / A;
}

// Both ends seen from a point, each as much wider as points of the cone may be off.
struct SeenCone {
  std::array<Disc, 2> ends;
  glm::dvec3 axis;              // unit
  double length, pad, nearest;  // nearest: along the face's axis, with the pad

  // z of an edge with x and y, all of the cone on its positive side. The ends' pad along the axis is in the margin, and
  // so is a float's rounding.
  double outermost(double x, double y) const {
    const double z = std::max(touching(ends[0], axis, x, y), touching(ends[1], axis, x, y));
    return z + 2 * pad / nearest * std::sqrt(x * x + y * y + z * z) +
           0x1p-20 * (std::abs(x) + std::abs(y) + std::abs(z));
  }
};

std::optional<SeenCone> seenFrom(const CubeFace& face, const Cone& cone, double pad) {
  SeenCone seen{{Disc{face.seen(cone.base), std::abs(cone.baseRadius) + pad},
                 Disc{face.seen(cone.apex), std::abs(cone.apexRadius) + pad}},
                {},
                0,
                pad,
                0};
  const glm::dvec3 way = seen.ends[1].center - seen.ends[0].center;
  seen.length = glm::length(way);
  seen.axis = way / seen.length;
  const double across = std::hypot(seen.axis.x, seen.axis.y);
  seen.nearest = std::min(seen.ends[0].center.z - seen.ends[0].radius * across,
                          seen.ends[1].center.z - seen.ends[1].radius * across) -
                 pad;
  if (!(seen.nearest > 0)) return {};
  return seen;
}

// Directions of the edges that bound the picture closest: x and y of each.
std::array<glm::dvec2, 4> edgeDirections(const SeenCone& seen) {
  const auto& [first, second] = seen.ends;
  const glm::dvec3& a = seen.axis;
  // The planes through the point that touch the whole cone have the normal slope a + n, with n across the axis and
  // n.c = the radius at the point's height: one on each side, unless the point is inside of the whole cone.
  const double slope = (second.radius - first.radius) / seen.length, height = glm::dot(first.center, a);
  const glm::dvec3 across = first.center - height * a;
  const double radius = first.radius - slope * height, distance = glm::length(across);
  // Seen along its axis, or from so near to the whole cone that rounding decides: diagonals cut the rectangle's
  // corners.
  if (!(distance > std::abs(radius) * (1 + 1e-6) && distance > 1e-9 * seen.length))
    return {glm::dvec2(1, 1), {1, -1}, {-1, 1}, {-1, -1}};
  const glm::dvec3 toAxis = across / distance, side = glm::cross(a, toAxis);
  const double cosine = radius / distance, sine = std::sqrt(std::max(0.0, (1 - cosine) * (1 + cosine)));
  const glm::dvec3 left = slope * a + (cosine * toAxis - sine * side),
                   right = slope * a + (cosine * toAxis + sine * side);
  // And two across the picture of the axis.
  const glm::dvec2 along = glm::dvec2(second.center) / second.center.z - glm::dvec2(first.center) / first.center.z;
  return {glm::dvec2(left), glm::dvec2(right), along, -along};
}

}  // namespace

void narrow(const Cone& local, const CubeFace& face, const Box& box, Projection& projection, OuterEdges& edges) {
  // Points may be off by as much as the box is padded, the largest pad on any axis.
  const Bounds bounds = boundsOf(local);
  const glm::dvec3 pad = glm::max(bounds.lo - glm::dvec3(box.lo), glm::dvec3(box.hi) - bounds.hi);
  const std::optional<SeenCone> seen = seenFrom(face, local, std::max({pad.x, pad.y, pad.z}));
  if (!seen) return;
  FaceRect& r = projection.rect;
  r = {std::max(r.uLo, float(-seen->outermost(1, 0))), std::min(r.uHi, float(seen->outermost(-1, 0))),
       std::max(r.vLo, float(-seen->outermost(0, 1))), std::min(r.vHi, float(seen->outermost(0, -1)))};
  const std::array<glm::dvec2, 4> directions = edgeDirections(*seen);
  for (size_t i = 0; i < edges.size(); ++i) {
    const double size = std::abs(directions[i].x) + std::abs(directions[i].y);
    if (!(size > 1e-6)) continue;
    const glm::dvec2 n = directions[i] / size;
    edges[i] = {float(n.x), float(n.y), float(seen->outermost(n.x, n.y))};
  }
}

}  // namespace turner
