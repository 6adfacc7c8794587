// The witness: a Whitted ray tracer as the paper tells it, recursive and in double precision.
//
// Comes in: a scene and settings. Goes out: the picture and the count of its rays. It must not know how the kernel
// does it: neither the packed scene nor the kernel's tree, and no formula here is taken from a shader.
//
// Symbols, all unit vectors, at a point x that a ray hits:
//   V  toward where the ray came from       Ng  normal of the surface, on V's side
//   L  toward a light                       Ns  normal that shades, reflects and refracts
//   H  halfway between L and V              R, T  directions of the reflected and the transmitted ray
// Of a material: k_d diffuse, k_s specular, n shininess, r reflect, t transmit, eta index of refraction, w_local the
// weight of what the lights send.
#include "reference/reference.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <future>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/errors.h"
#include "base/threads.h"
#include "geometry/nested_dielectrics.h"
#include "reference/reference_tree.h"

namespace turner {
namespace {

using glm::dvec2;
using glm::dvec3;
using wide3 = glm::tvec3<long double, glm::defaultp>;  // where the last bits of double matter: 64-bit mantissa or more

constexpr double kRounding = 0x1p-53;  // largest relative error of one operation
constexpr double kWideRounding = std::numeric_limits<long double>::epsilon() / 2;
constexpr double kFarAway = std::numeric_limits<double>::max();
constexpr uint32_t kNothing = UINT32_MAX;

double largest(const dvec3& v) {
  return std::max({v.x, v.y, v.z});
}
double largestSize(const dvec3& v) {
  return largest(glm::abs(v));
}

// ---- Sample positions ----

// pcg4d: Jarzynski and Olano, "Hash functions for GPU rendering", JCGT 9(3), 2020.
std::array<uint32_t, 2> hash(uint32_t x, uint32_t y, uint32_t z, uint32_t w) {
  const auto mix = [&] {
    x += y * w;
    y += z * x;
    z += x * y;
    w += y * z;
  };
  for (uint32_t* word : {&x, &y, &z, &w}) *word = *word * 1664525u + 1013904223u;
  mix();
  for (uint32_t* word : {&x, &y, &z, &w}) *word ^= *word >> 16;
  mix();
  return {x, y};
}

// "lowbias32", a hash of one word by C. Wellons (nullprogram.com/blog/2018/07/31).
uint32_t hash(uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352d;
  x ^= x >> 15;
  x *= 0x846ca68b;
  return x ^ (x >> 16);
}

// The radical inverse of a number below n, nested scrambling applied to its digits (Owen 1995, 2003): the last digit of
// the number becomes the first, and what shuffles it hangs on the digits that came before, of which `node` is the code.
// Digits are those of the prime factors of n, the smallest last.
uint32_t scrambledInverse(uint32_t number, uint32_t n, uint32_t seed, uint32_t node) {
  if (n == 1) return 0;
  uint32_t prime = 2;
  while (n % prime != 0) ++prime;
  const uint32_t digit = number % prime, rest = n / prime;
  const uint32_t random = hash(seed + node * 0x9e3779b9u);
  const uint32_t shift = (random >> 16) * prime / 65536, factor = 1 + (random & 65535) * (prime - 1) / 65536;
  const uint32_t shuffled = (digit * factor + shift) % prime;
  return shuffled * rest + scrambledInverse(number / prime, rest, seed, node * prime + digit);
}

// Where the sample of cell (i, j) of pixel (x, y) lies, in pixels from the top left of the picture. Both renderers
// compute it in integers, fractions of 2^-24, so that they look through the very same points.
dvec2 samplePosition(int x, int y, int i, int j, const RenderSettings& settings) {
  const uint32_t n = uint32_t(settings.samples);
  // Where in the cell: a fraction of `parts`.
  uint64_t u = 1u << 23, v = 1u << 23, parts = 1u << 24;
  if (settings.sampler != Sampler::grid) {
    const auto words = hash(uint32_t(x), uint32_t(y), uint32_t(j) * n + uint32_t(i), settings.seed);
    u = words[0] >> 8;
    v = words[1] >> 8;
  }
  if (settings.sampler == Sampler::sobol) {
    constexpr uint32_t kBeyondAllCells = 65536;
    const auto seeds = hash(uint32_t(x), uint32_t(y), kBeyondAllCells, settings.seed);
    u += uint64_t(scrambledInverse(uint32_t(j), n, seeds[0], 1)) << 24;
    v += uint64_t(scrambledInverse(uint32_t(i), n, seeds[1], 1)) << 24;
    parts *= n;
  }
  // The position counts in 2^-24 of a pixel.
  const uint64_t across = (uint64_t(i) * parts + u) / (parts >> 24) / n;
  const uint64_t down = (uint64_t(j) * parts + v) / (parts >> 24) / n;
  return {x + double(across) * 0x1p-24, y + double(down) * 0x1p-24};
}

// The image plane at distance 1 from the eye.
struct ImagePlane {
  dvec3 forward, right, up;  // right and up reach from the centre to the height of the upper edge
  double width, height;      // pixels

  ImagePlane(const Camera& camera, const RenderSettings& settings) : width(settings.width), height(settings.height) {
    const double halfHeight = std::tan(0.5 * glm::radians(camera.fov));
    forward = glm::normalize(camera.target - camera.eye);
    const dvec3 side = glm::normalize(glm::cross(forward, camera.up));
    right = halfHeight * side;
    up = halfHeight * glm::cross(side, forward);
  }

  dvec3 directionThrough(const dvec2& position) const {
    return glm::normalize(forward + (2 * position.x - width) / height * right +
                          (height - 2 * position.y) / height * up);
  }
};

// ---- Rays and surfaces ----

struct Ray {
  dvec3 origin;
  dvec3 direction;         // unit
  uint32_t from;           // the primitive that the ray starts on, or kNothing
  dvec3 across1, across2;  // with direction an orthonormal basis
};

// The basis is that of Duff et al., "Building an orthonormal basis, revisited", JCGT 6(1), 2017.
Ray makeRay(const dvec3& origin, const dvec3& d, uint32_t from) {
  const double sign = std::copysign(1.0, d.z);
  const double a = -1 / (sign + d.z);
  const double b = d.x * d.y * a;
  return {origin, d, from, {1 + sign * d.x * d.x * a, sign * b, -sign * d.x}, {b, sign + d.y * d.y * a, -d.y}};
}

// The smallest positive root of t^2 + 2 b t + c = 0 with b^2 - c = D, or kFarAway. The root without cancellation comes
// first, and the other one from their product c.
template <class Real>
double nearestRoot(Real b, Real c, Real D) {
  if (!(D >= 0)) return kFarAway;
  const Real q = b < 0 ? -b + std::sqrt(D) : -b - std::sqrt(D);
  const double t0 = double(b < 0 ? c / q : q), t1 = double(b < 0 ? q : c / q);
  return t0 > 0 ? t0 : t1 > 0 ? t1 : kFarAway;
}

// With all digits: the radius of a rounded scene's sphere may have more than a double holds.
long double wideRadius(const Sphere& sphere) {
  return (long double)(sphere.radius) + sphere.radiusRest;
}

// The distance at which the ray hits the sphere, or kFarAway.
double hitSphere(const Ray& ray, const Sphere& sphere, bool startsOnIt) {
  const dvec3 f = ray.origin - sphere.center;
  const double b = glm::dot(f, ray.direction);
  // A ray that starts on the sphere has c = 0: the roots are 0, which is the start, and -2 b.
  if (startsOnIt) return b < 0 ? -2 * b : kFarAway;

  const double squaredRadius = sphere.radius * sphere.radius;
  const double c = glm::dot(f, f) - squaredRadius;
  if (std::abs(c) > 0x1p-10 * squaredRadius) {
    if (c > 0 && b >= 0) return kFarAway;  // outside, and on the way away from it
    // The discriminant from the distance between centre and ray, which keeps its digits where the sphere is far away:
    // Haines et al., "Precision improvements for ray/sphere intersection", Ray Tracing Gems, chapter 7 (2019).
    const dvec3 perpendicular = f - b * ray.direction;
    return nearestRoot(b, c, squaredRadius - glm::dot(perpendicular, perpendicular));
  }
  // Close to the surface c is a small difference of large squares, so that all of it is done in the wider type.
  const wide3 wideF = wide3(ray.origin) - wide3(sphere.center), d(ray.direction);
  const long double dd = glm::dot(d, d);
  const long double wideB = glm::dot(wideF, d) / dd;
  const long double radius = wideRadius(sphere);
  const long double wideC = (glm::dot(wideF, wideF) - radius * radius) / dd;
  return nearestRoot(wideB, wideC, wideB * wideB - wideC);
}

// Twice the areas of the three triangles that the ray's point makes with the edges, seen along the ray: all of one sign
// if the point is inside, and then in the ratio of the barycentric coordinates.
// Without cracks: each vertex is projected without regard to the triangle it is in; neighbours get the same products
// for their common edge, with opposite signs; and as rounding is monotone, a difference of two rounded products is of
// the right sign or zero. A ray through an edge or a vertex is therefore inside at least one of the triangles around
// it.
dvec3 edgeAreas(const Ray& ray, const Triangle& triangle) {
  std::array<dvec2, 3> p;
  for (int k = 0; k < 3; ++k) {
    const dvec3 v = triangle.vertices[k] - ray.origin;
    p[k] = {glm::dot(v, ray.across1), glm::dot(v, ray.across2)};
  }
  return {p[1].x * p[2].y - p[1].y * p[2].x, p[2].x * p[0].y - p[2].y * p[0].x, p[0].x * p[1].y - p[0].y * p[1].x};
}

// The distance at which the ray hits the triangle, edges included, or kFarAway. `normal` is its unit normal.
double hitTriangle(const Ray& ray, const Triangle& triangle, const dvec3& normal) {
  const dvec3 area = edgeAreas(ray, triangle);
  const bool anyNegative = area.x < 0 || area.y < 0 || area.z<0, anyPositive = area.x> 0 || area.y > 0 || area.z > 0;
  if (anyNegative == anyPositive) return kFarAway;  // outside, or seen exactly edge-on
  const double cosine = glm::dot(normal, ray.direction);
  if (cosine == 0) return kFarAway;
  // The distance of the plane, which at a grazing angle must not leave the triangle's own depth.
  const dvec3 toVertex = triangle.vertices[0] - ray.origin;
  const double depth0 = glm::dot(toVertex, ray.direction);
  const double depth1 = glm::dot(triangle.vertices[1] - ray.origin, ray.direction);
  const double depth2 = glm::dot(triangle.vertices[2] - ray.origin, ray.direction);
  const double t = std::clamp(glm::dot(normal, toVertex) / cosine, std::min({depth0, depth1, depth2}),
                              std::max({depth0, depth1, depth2}));
  return t > 0 ? t : kFarAway;
}

dvec3 faceNormal(const Triangle& triangle) {
  const wide3 v0(triangle.vertices[0]);
  const wide3 normal = glm::cross(wide3(triangle.vertices[1]) - v0, wide3(triangle.vertices[2]) - v0);
  const long double length = glm::length(normal);
  return length > 0 ? dvec3(normal / length) : dvec3(0);  // without area: never hit
}

// All that a ray needs to know about the place where it hit.
struct Surface {
  dvec3 x;
  dvec3 Ng, Ns;
  bool front;  // hit on the side that the surface's own normal points to
  const Material* material;
  uint32_t id;
  double uncertainty;  // x is on the surface but for this distance

  // Where a ray in this direction starts: off the surface by its uncertainty, on the side that the ray goes to, so that
  // surfaces in the same place (coplanar neighbours, copies) are left too.
  dvec3 startToward(const dvec3& direction) const {
    return x + std::copysign(uncertainty, glm::dot(Ng, direction)) * Ng;
  }
};

// The scene, and what answers the two questions about it: what is the first hit, and is there any.
class World {
 public:
  World(const Scene& itsScene, ReferenceSearch search)
      : scene(itsScene),
        dielectrics(findNestedDielectrics(itsScene)),
        bruteForce(search == ReferenceSearch::bruteForce) {
    double largestCoordinate = largestSize(scene.camera.eye);
    std::vector<reference::Box> boxes;
    boxes.reserve(primitiveCount());
    for (const Sphere& sphere : scene.spheres) {
      const double radius = std::abs(sphere.radius);
      boxes.push_back({sphere.center - radius, sphere.center + radius});
    }
    faceNormals.reserve(scene.triangles.size());
    for (const Triangle& triangle : scene.triangles) {
      faceNormals.push_back(faceNormal(triangle));
      boxes.emplace_back();
      for (const dvec3& vertex : triangle.vertices) boxes.back().include(vertex);
    }
    for (const reference::Box& box : boxes)
      largestCoordinate = std::max({largestCoordinate, largestSize(box.low), largestSize(box.high)});
    if (bruteForce) boxes.clear();
    // Rays start within these coordinates. The slack is 512 roundings of the largest: tests of primitives need few.
    tree = reference::BoxTree(boxes, 512 * kRounding * largestCoordinate);
  }

  struct Hit {
    double t = kFarAway;
    uint32_t id = kNothing;
    std::vector<uint32_t> place;  // where solids touch: all of their walls in its place
  };

  // The nearest primitive on the ray; among those in the same place the one that comes first.
  Hit closest(const Ray& ray) const {
    Hit nearest;
    forCandidates(ray, nearest.t, [&](uint32_t id) {
      const double t = hitPrimitive(ray, id);
      if (t < nearest.t || (t == nearest.t && t < kFarAway && comesFirst(id, nearest.id))) nearest = {t, id, {}};
      return nearest.t;
    });
    if (solidOf(nearest.id) == kNoMedium) return nearest;
    // All that is in one place with it, no more than roundings away where it is no wall of a solid; the first is hit.
    const double apart = coincidenceDistance(ray, nearest.t, nearest.id);
    Hit hit = nearest;
    forCandidates(ray, nearest.t + apart, [&](uint32_t id) {
      const double t = hitPrimitive(ray, id);
      const bool isWall = solidOf(id) != kNoMedium;
      if (t > nearest.t + (isWall ? apart : 0.25 * apart)) return nearest.t + apart;
      if (isWall) hit.place.push_back(id);
      if (comesFirst(id, hit.id)) hit.t = t, hit.id = id;
      return nearest.t + apart;
    });
    return hit;
  }

  // Of the solids that overlap or touch, the one that a primitive is a wall of, or kNoMedium.
  uint32_t solidOf(uint32_t id) const {
    if (dielectrics.empty() || id == kNothing) return kNoMedium;
    return id < scene.spheres.size() ? dielectrics.ofSpheres[id] : dielectrics.ofTriangles[id - scene.spheres.size()];
  }

  // Whether anything lies on the ray nearer than `end`.
  bool blocked(const Ray& ray, double end) const {
    bool found = false;
    forCandidates(ray, end, [&](uint32_t id) {
      found = found || hitPrimitive(ray, id) < end;
      return found ? -1 : end;
    });
    return found;
  }

  Surface surfaceAt(const Ray& ray, const Hit& hit) const {
    Surface surface = hit.id < scene.spheres.size() ? sphereAt(ray, hit) : triangleAt(ray, hit);
    // A back hit flips both normals; Ns must look at V too.
    const dvec3 V = -ray.direction;
    surface.front = glm::dot(surface.Ng, V) > 0;
    if (!surface.front) {
      surface.Ng = -surface.Ng;
      surface.Ns = -surface.Ns;
    }
    if (glm::dot(surface.Ns, V) <= 0) surface.Ns = surface.Ng;
    return surface;
  }

  // Whether the ray that hits a wall of a solid there enters it. By the triangle as a whole, whose vertex normals may
  // look to both sides.
  bool entersSolid(const Ray& ray, double t, uint32_t id) const {
    if (id < scene.spheres.size()) return surfaceAt(ray, {t, id, {}}).front;
    const size_t index = id - scene.spheres.size();
    return facing(scene, scene.triangles[index]) * glm::dot(faceNormals[index], ray.direction) < 0;
  }

  const Scene& scene;
  const NestedDielectrics dielectrics;

 private:
  // How far along the ray another wall may be that is in one place with this one: 48 roundings of float32 to the side,
  // of its distance from the eye.
  double coincidenceDistance(const Ray& ray, double t, uint32_t id) const {
    const dvec3 x = ray.origin + t * ray.direction;
    const dvec3 normal = id < scene.spheres.size() ? (x - scene.spheres[id].center) / scene.spheres[id].radius
                                                   : faceNormals[id - scene.spheres.size()];
    const double cosine = std::abs(glm::dot(normal, ray.direction));
    return 48 * 0x1p-24 * glm::length(x - scene.camera.eye) / std::max(cosine, 0x1p-10);
  }

  // Of primitives in one place: what is opaque, then glass, of solids that overlap the one with priority; then by ids.
  bool comesFirst(uint32_t a, uint32_t b) const {
    const auto kind = [&](uint32_t id) {
      const uint32_t material =
          id < scene.spheres.size() ? scene.spheres[id].material : scene.triangles[id - scene.spheres.size()].material;
      if (scene.materials[material].transmit <= 0) return int64_t(-2);
      const uint32_t solid = solidOf(id);
      return solid == kNoMedium ? int64_t(-1) : int64_t(kNoMedium) - solid;
    };
    return std::pair(kind(a), a) < std::pair(kind(b), b);
  }

  size_t primitiveCount() const { return scene.spheres.size() + scene.triangles.size(); }

  template <class Visit>
  void forCandidates(const Ray& ray, double limit, Visit&& visit) const {
    if (!bruteForce) return tree.traverse(ray.origin, ray.direction, limit, visit);
    for (uint32_t id = 0; id < primitiveCount(); ++id) visit(id);
  }

  double hitPrimitive(const Ray& ray, uint32_t id) const {
    if (id < scene.spheres.size()) return hitSphere(ray, scene.spheres[id], id == ray.from);
    // A triangle is flat: a ray that starts on it never comes back to it.
    if (id == ray.from) return kFarAway;
    const size_t index = id - scene.spheres.size();
    return hitTriangle(ray, scene.triangles[index], faceNormals[index]);
  }

  Surface sphereAt(const Ray& ray, const Hit& hit) const {
    const Sphere& sphere = scene.spheres[hit.id];
    // Put x back on the sphere: one Newton step, in the wider type as the centre may be far away.
    wide3 x = wide3(ray.origin) + (long double)(hit.t) * wide3(ray.direction);
    wide3 f = x - wide3(sphere.center);
    const long double squaredRadius = wideRadius(sphere) * wideRadius(sphere);
    x -= f * ((glm::dot(f, f) - squaredRadius) / (2 * squaredRadius));

    Surface surface;
    surface.x = dvec3(x);
    surface.Ng = surface.Ns =
        dvec3(glm::normalize(x - wide3(sphere.center)) * std::copysign(1.0L, (long double)sphere.radius));
    surface.material = &scene.materials[sphere.material];
    surface.id = hit.id;
    // x errs by rounding it to double; the rest, here and in another sphere's test nearby, is done in the wider type.
    surface.uncertainty = 8 * (kRounding * largestSize(surface.x) +
                               kWideRounding * (largestSize(sphere.center) + std::abs(sphere.radius)));
    return surface;
  }

  Surface triangleAt(const Ray& ray, const Hit& hit) const {
    const size_t index = hit.id - scene.spheres.size();
    const Triangle& triangle = scene.triangles[index];
    Surface surface;
    surface.Ng = surface.Ns = faceNormals[index];
    // Put x back on the plane.
    surface.x = ray.origin + hit.t * ray.direction;
    surface.x -= glm::dot(surface.x - triangle.vertices[0], surface.Ng) * surface.Ng;
    surface.material = &scene.materials[triangle.material];
    surface.id = hit.id;
    // x, its difference to a vertex, the normal and the product with it: each errs by a few roundings of the
    // coordinates.
    double size = largestSize(surface.x);
    for (const dvec3& vertex : triangle.vertices) size = std::max(size, largestSize(vertex));
    surface.uncertainty = 16 * kRounding * size;

    if (triangle.normals != kNoNormals) {
      const auto& normals = scene.normals[triangle.normals];
      const dvec3 weight = edgeAreas(ray, triangle);
      dvec3 sum(0);
      for (int k = 0; k < 3; ++k) sum += weight[k] / (weight.x + weight.y + weight.z) * glm::normalize(normals[k]);
      if (glm::dot(sum, sum) > 0) surface.Ns = glm::normalize(sum);
      if (glm::dot(surface.Ng, surface.Ns) < 0) surface.Ng = -surface.Ng;
    }
    return surface;
  }

  bool bruteForce;
  std::vector<dvec3> faceNormals;
  reference::BoxTree tree{{}, 0};
};

// ---- Light transport ----

dvec3 reflect(const dvec3& V, const dvec3& N) {
  return glm::normalize(2 * glm::dot(N, V) * N - V);
}

// Snell's law. `ratio` is the index on V's side over that on the other side. False on total internal reflection.
bool refract(const dvec3& V, const dvec3& N, double ratio, dvec3& T) {
  const double cosV = glm::dot(N, V);
  const double squaredCosT = 1 - ratio * ratio * (1 - cosV * cosV);
  if (squaredCosT <= 0) return false;
  T = glm::normalize((ratio * cosV - std::sqrt(squaredCosT)) * N - ratio * V);
  return true;
}

// What an eye ray's direction may err by: the corners of a box of 4 ulp, and of smaller ones inside it, because at the
// rim of a curved mirror the extreme lies between the corners; then places all over the box (the additive recurrence
// of Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018, in three dimensions).
constexpr double kMostDirectionError = 4 * 0x1p-24;
dvec3 directionError(int k) {
  if (k < 8 * 4) {
    const double size = std::ldexp(kMostDirectionError, -(k >> 3));
    return {k & 1 ? size : -size, k & 2 ? size : -size, k & 4 ? size : -size};
  }
  constexpr double kRoot = 1.2207440846057596;  // of x^4 = x + 1
  const dvec3 step(1 / kRoot, 1 / (kRoot * kRoot), 1 / (kRoot * kRoot * kRoot));
  return kMostDirectionError * (2.0 * glm::fract(double(k) * step) - 1.0);
}

// Traces the ray trees of one thread and counts their rays.
class Tracer {
 public:
  Tracer(const World& itsWorld, const RenderSettings& itsSettings, std::stop_token itsStop)
      : world(itsWorld),
        scene(itsWorld.scene),
        settings(itsSettings),
        stop(std::move(itsStop)),
        plane(scene.camera, settings) {}

  // The mean of the pixel's samples, cell after cell.
  dvec3 pixel(int x, int y) {
    const int n = settings.samples;
    dvec3 sum(0), lost(0);  // Kahan's compensated sum
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        ++counts.eye;
        const dvec3 term = seenAlong(plane.directionThrough(samplePosition(x, y, i, j, settings))) - lost;
        const dvec3 next = sum + term;
        lost = (next - sum) - term;
        sum = next;
      }
    return sum / double(n * n);
  }

  // The means of the samples' least and largest values.
  PixelBounds pixelBounds(int x, int y, int rays) {
    const int n = settings.samples;
    PixelBounds sum;
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const dvec3 d = plane.directionThrough(samplePosition(x, y, i, j, settings));
        dvec3 least = seenAlong(d), most = least;
        for (int k = 0; k + 1 < rays; ++k) {
          const dvec3 color = seenAlong(glm::normalize(d + directionError(k)));
          least = glm::min(least, color);
          most = glm::max(most, color);
        }
        sum.least += least;
        sum.most += most;
      }
    return {sum.least / double(n * n), sum.most / double(n * n)};
  }

  RayCounts counts;

 private:
  // The overlapping solids that a ray is in, ascending: the last one is seen.
  using Inside = std::vector<uint32_t>;

  // Through the walls in one place: what the ray is in behind them, and the index of refraction before over behind.
  struct Crossing {
    Inside behind;
    double ratio;
    bool hidden = false;  // there is no wall to be seen: the same glass before and behind
  };

  static void enterOrLeave(Inside& inside, uint32_t solid, bool enters) {
    const auto at = std::lower_bound(inside.begin(), inside.end(), solid);
    const bool there = at != inside.end() && *at == solid;
    if (enters && !there) inside.insert(at, solid);
    if (!enters && there) inside.erase(at);
  }

  double indexIn(const Inside& inside) const {
    return inside.empty() ? 1 : scene.materials[world.dielectrics.materials[inside.back()]].eta;
  }

  bool sameGlass(const Inside& a, const Inside& b) const {
    if (a.empty() || b.empty()) return a.empty() == b.empty();
    return world.dielectrics.glasses[a.back()] == world.dielectrics.glasses[b.back()];
  }

  Crossing crossing(const Ray& ray, const World::Hit& hit, const Surface& surface, const Inside& inside) const {
    Crossing result{inside, 1};
    for (const bool enters : {true, false})
      for (const uint32_t id : hit.place)
        if (world.entersSolid(ray, hit.t, id) == enters) enterOrLeave(result.behind, world.solidOf(id), enters);
    const double own = surface.material->eta;
    if (world.solidOf(surface.id) != kNoMedium) {
      result.ratio = indexIn(inside) / indexIn(result.behind);
      result.hidden = sameGlass(inside, result.behind);
    } else {
      result.ratio = surface.front ? indexIn(inside) / own : own / indexIn(result.behind);
    }
    return result;
  }

  dvec3 seenAlong(const dvec3& direction) {
    return radiance(makeRay(scene.camera.eye, direction, kNothing), world.dielectrics.aroundEye, 1, 1);
  }

  // What comes back along the ray, which is of this level of its tree and counts in the pixel with this weight.
  dvec3 radiance(Ray ray, Inside inside, int level, double weight) {
    for (int walls = 0; walls < kMostHiddenInterfaces; ++walls) {
      if (stop.stop_requested()) return dvec3(0);
      const World::Hit hit = world.closest(ray);
      if (hit.id == kNothing) return scene.background;
      const Surface surface = world.surfaceAt(ray, hit);
      const Crossing through = crossing(ray, hit, surface, inside);
      if (!through.hidden) return sentBack(ray, surface, inside, through, level, weight);
      ray = makeRay(surface.startToward(ray.direction), ray.direction, surface.id);
      inside = through.behind;
    }
    throw RunError("a ray passed more than " + std::to_string(kMostHiddenInterfaces) + " walls hidden in other glass");
  }
  static constexpr int kMostHiddenInterfaces = 65536;

  // What a surface sends back along the ray that hit it.
  dvec3 sentBack(const Ray& ray, const Surface& surface, const Inside& inside, const Crossing& through, int level,
                 double weight) {
    const Material& material = *surface.material;
    const dvec3 V = -ray.direction;
    dvec3 sum = material.localWeight * localLight(surface, V);
    if (material.reflect <= 0 && material.transmit <= 0) return sum;

    // The reflected ray: about Ns, or about Ng if it would go into the surface.
    dvec3 R = reflect(V, surface.Ns);
    if (glm::dot(R, surface.Ng) <= 0) R = reflect(V, surface.Ng);
    // The transmitted ray likewise.
    dvec3 T;
    bool passes = material.transmit > 0 && refract(V, surface.Ns, through.ratio, T);
    if (passes && glm::dot(T, surface.Ng) >= 0) passes = refract(V, surface.Ng, through.ratio, T);

    // On total internal reflection all goes into R.
    const double r = passes ? material.reflect : material.reflect + material.transmit;
    sum += r * child(surface, R, inside, level + 1, weight * r, counts.reflected);
    if (passes)
      sum += material.transmit *
             child(surface, T, through.behind, level + 1, weight * material.transmit, counts.refracted);
    return sum;
  }

  // Spawns a ray unless it is too deep in its tree or counts too little.
  dvec3 child(const Surface& surface, const dvec3& direction, const Inside& inside, int level, double weight,
              uint64_t& count) {
    if (level > settings.depth || weight <= 0 || weight < settings.weightLimit()) return dvec3(0);
    ++count;
    return radiance(makeRay(surface.startToward(direction), direction, surface.id), inside, level, weight);
  }

  // The sum over the lights: E_i * vis_i * (k_d + k_s * max(0, N.H)^n) * max(0, N.L).
  dvec3 localLight(const Surface& surface, const dvec3& V) {
    const Material& material = *surface.material;
    dvec3 sum(0);
    if (material.localWeight * std::max(largest(material.diffuse), largest(material.specular)) <= 0) return sum;
    for (const Light& light : scene.lights) {
      // A light that is no higher than the start of the shadow ray lies on the surface or behind it.
      const dvec3 start = surface.x + surface.uncertainty * surface.Ng;
      const dvec3 toLight = light.position - start;
      const double squaredDistance = glm::dot(toLight, toLight);
      if (!(squaredDistance > 0) || glm::dot(surface.Ng, toLight) <= 0) continue;
      const double distance = std::sqrt(squaredDistance);
      const dvec3 L = toLight / distance;
      const double cosL = glm::dot(surface.Ns, L);
      if (cosL <= 0) continue;

      // A surface that the light lies on does not block it: hence less by 512 roundings, which is what its distance may
      // err by even where the ray meets it at a grazing angle.
      ++counts.shadow;
      const double end = distance - 512 * kRounding * std::max(largestSize(start), largestSize(light.position));
      if (world.blocked(makeRay(start, L, surface.id), end)) continue;

      dvec3 reflectance = material.diffuse;
      if (largest(material.specular) > 0) {
        const dvec3 halfway = L + V;
        const double length = glm::length(halfway);
        const double cosH = length > 0 ? std::max(0.0, glm::dot(surface.Ns, halfway) / length) : 0;
        if (length > 0) reflectance += std::pow(cosH, material.shininess) * material.specular;
      }
      const dvec3 E = light.falloff == Falloff::inverseSquare ? light.color / squaredDistance : light.color;
      sum += cosL * E * reflectance;
    }
    return sum;
  }

  const World& world;
  const Scene& scene;
  const RenderSettings& settings;
  std::stop_token stop;
  ImagePlane plane;
};

// ---- All cores ----

constexpr int kBlock = 16;  // pixels to a side: what a thread takes at a time

// The crop in blocks, and how far the threads are with it.
struct Work {
  const World& world;
  const RenderSettings& settings;
  Image& image;
  int blocksAcross, blocks;
  std::atomic<int> next{0}, done{0};
  std::stop_source stop;
  // The rest is under the mutex; `change` tells the calling thread about it.
  std::mutex mutex;
  std::condition_variable change;
  unsigned running = 0;
  RayCounts rays;
  std::exception_ptr failure;
};

void renderBlock(Work& work, Tracer& tracer, int block) {
  const Window& crop = work.settings.crop;
  const int x0 = crop.x0 + block % work.blocksAcross * kBlock, y0 = crop.y0 + block / work.blocksAcross * kBlock;
  for (int y = y0; y < std::min(y0 + kBlock, crop.y1); ++y)
    for (int x = x0; x < std::min(x0 + kBlock, crop.x1); ++x) {
      if (work.stop.stop_requested()) return;
      const dvec3 color = tracer.pixel(x, y);
      float* rgb = &work.image.rgb[3 * (size_t(y - crop.y0) * size_t(crop.width()) + size_t(x - crop.x0))];
      for (int k = 0; k < 3; ++k) rgb[k] = float(color[k]);
    }
}

// What each thread does: take blocks until there are none, then add its counts.
void renderBlocks(Work& work) {
  std::exception_ptr failure;
  RayCounts rays;
  try {
    Tracer tracer(work.world, work.settings, work.stop.get_token());
    for (int block = work.next++; block < work.blocks && !work.stop.stop_requested(); block = work.next++) {
      renderBlock(work, tracer, block);
      ++work.done;
    }
    rays = tracer.counts;
  } catch (...) {
    failure = std::current_exception();
    work.stop.request_stop();
  }
  const std::lock_guard lock(work.mutex);
  if (failure && !work.failure) work.failure = failure;
  work.rays.eye += rays.eye;
  work.rays.reflected += rays.reflected;
  work.rays.refracted += rays.refracted;
  work.rays.shadow += rays.shadow;
  --work.running;
  work.change.notify_one();
}

}  // namespace

ReferencePicture renderReference(const Scene& scene, const RenderSettings& settings, const Progress& progress,
                                 ReferenceSearch search) {
  if (progress) progress(0);
  const World world(scene, search);
  const auto start = std::chrono::steady_clock::now();
  ReferencePicture picture;
  picture.image = Image(settings.width, settings.height, settings.crop);

  const int across = (settings.crop.width() + kBlock - 1) / kBlock,
            down = (settings.crop.height() + kBlock - 1) / kBlock;
  Work work{
      .world = world, .settings = settings, .image = picture.image, .blocksAcross = across, .blocks = across * down};
  std::vector<std::jthread> threads;
  try {
    const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
    for (unsigned core = 0; core < cores; ++core) {
      {
        const std::lock_guard lock(work.mutex);
        ++work.running;
      }
      threads.emplace_back(renderBlocks, std::ref(work));
    }
    // This thread reports ten times a second until the others are through.
    std::unique_lock lock(work.mutex);
    while (!work.change.wait_for(lock, std::chrono::milliseconds(100), [&] { return work.running == 0; })) {
      lock.unlock();
      if (progress) progress(double(work.done) / work.blocks);
      lock.lock();
    }
  } catch (...) {
    work.stop.request_stop();
    threads.clear();  // joins them
    throw;
  }
  threads.clear();
  if (work.failure) std::rethrow_exception(work.failure);
  if (progress) progress(1);
  picture.rays = work.rays;
  picture.traceSeconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return picture;
}

std::vector<PixelBounds> renderEnvelope(const Scene& scene, const RenderSettings& settings,
                                        std::span<const Pixel> pixels, int rays, const Progress& progress) {
  const World world(scene, ReferenceSearch::tree);
  std::vector<PixelBounds> bounds(pixels.size());
  std::stop_source stop;
  std::atomic<size_t> done = 0;
  std::future<void> work = std::async(std::launch::async, [&] {
    onAllCores(pixels.size(), [&](size_t i) {
      if (stop.stop_requested()) return;
      bounds[i] = Tracer(world, settings, stop.get_token()).pixelBounds(pixels[i].x, pixels[i].y, rays);
      ++done;
    });
  });
  // This thread reports ten times a second until the others are through; leaving early, it waits for them.
  try {
    while (work.wait_for(std::chrono::milliseconds(100)) != std::future_status::ready)
      if (progress) progress(double(done) / double(pixels.size()));
  } catch (...) {
    stop.request_stop();
    throw;
  }
  work.get();
  if (progress) progress(1);
  return bounds;
}

}  // namespace turner
