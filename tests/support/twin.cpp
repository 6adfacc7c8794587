#include "support/twin.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "image/camera_basis.h"

namespace turner::test {
namespace {

using glm::dvec2;
using glm::dvec3;

// Both roots, ascending.
std::optional<std::array<double, 2>> roots(const Sphere& sphere, const TwinRay& ray) {
  const dvec3 f = sphere.center - ray.origin;
  const double a = glm::dot(ray.direction, ray.direction), b = glm::dot(f, ray.direction) / a;
  const dvec3 perpendicular = f - b * ray.direction;
  const double r = std::abs(sphere.radius), d = r * r - glm::dot(perpendicular, perpendicular);
  if (d < 0) return std::nullopt;
  const double half = std::sqrt(d / a);
  return std::array{b - half, b + half};
}

std::optional<double> meet(const TriangleCorners& v, const TwinRay& ray) {
  const dvec3 e1 = v[1] - v[0], e2 = v[2] - v[0], p = glm::cross(ray.direction, e2), s = ray.origin - v[0];
  const double det = glm::dot(e1, p);
  if (det == 0) return std::nullopt;
  const dvec3 q = glm::cross(s, e1);
  const double u = glm::dot(s, p) / det, w = glm::dot(ray.direction, q) / det;
  if (u < 0 || w < 0 || u + w > 1) return std::nullopt;
  return glm::dot(e2, q) / det;
}

// Of a ray that starts on the surface of its primitive the root that is 0 is left out.
constexpr double kSelf = 1e-6;

}  // namespace

std::array<uint32_t, 4> twinHash(std::array<uint32_t, 4> v) {
  auto& [x, y, z, w] = v;
  const auto mix = [&] {
    x += y * w;
    y += z * x;
    z += x * y;
    w += y * z;
  };
  for (uint32_t& word : v) word = word * 1664525u + 1013904223u;
  mix();
  for (uint32_t& word : v) word ^= word >> 16;
  mix();
  return v;
}

dvec3 twinRandom(uint32_t x, uint32_t y, uint32_t z, uint32_t w) {
  const std::array<uint32_t, 4> hash = twinHash({x, y, z, w});
  return dvec3(hash[0] >> 8, hash[1] >> 8, hash[2] >> 8) / 16777216.0;
}

TwinRay Twin::cameraRay(const dvec2& point) const {
  const CameraBasis basis = cameraBasis(scene.camera);
  const double pixel = 2 * basis.tanHalfFov / settings_.height;
  return {dvec3(0), glm::normalize(basis.forward + pixel * ((point.x - 0.5 * settings_.width) * basis.right -
                                                            (point.y - 0.5 * settings_.height) * basis.up))};
}

std::optional<TwinHit> Twin::nearest(const TwinRay& ray) const {
  TwinHit hit;
  hit.t = std::numeric_limits<double>::infinity();
  const double self = kSelf / glm::length(ray.direction);
  for (size_t i = 0; i < scene.spheres.size(); ++i) {
    const auto both = roots(scene.spheres[i], ray);
    if (!both) continue;
    for (const double t : *both)
      if (t > (ray.leaving == i ? self : 0) && t < hit.t) hit.t = t, hit.primitive = i;
  }
  for (size_t i = 0; i < scene.triangles.size(); ++i) {
    const size_t id = scene.spheres.size() + i;
    if (ray.leaving == id) continue;
    const std::optional<double> t = meet(scene.cornersOf(i), ray);
    if (t && *t > 1e-9 && *t < hit.t) hit.t = *t, hit.primitive = id;
  }
  if (std::isinf(hit.t)) return std::nullopt;
  hit.point = ray.origin + hit.t * ray.direction;
  uint32_t material = 0;
  if (hit.primitive < scene.spheres.size()) {
    const Sphere& sphere = scene.spheres[hit.primitive];
    hit.Ng = hit.N = glm::normalize(hit.point - sphere.center) * (sphere.radius < 0 ? -1.0 : 1.0);
    material = sphere.material;
  } else {
    const Triangle& triangle = scene.triangles[hit.primitive - scene.spheres.size()];
    const TriangleCorners v = scene.cornersOf(triangle);
    hit.Ng = hit.N = glm::normalize(glm::cross(v[1] - v[0], v[2] - v[0]));
    material = triangle.material;
    if (triangle.isSmooth()) {
      const TriangleCorners n = scene.normalsOf(triangle);
      const double area = glm::length(glm::cross(v[1] - v[0], v[2] - v[0]));
      const auto weight = [&](size_t a, size_t b) {
        return glm::dot(glm::cross(v[a] - hit.point, v[b] - hit.point), hit.Ng) / area;
      };
      hit.N = glm::normalize(weight(1, 2) * n[0] + weight(2, 0) * n[1] + weight(0, 1) * n[2]);
      if (glm::dot(hit.Ng, hit.N) < 0) hit.Ng = -hit.Ng;
    }
  }
  const dvec3 V = -glm::normalize(ray.direction);
  hit.front = glm::dot(hit.Ng, V) > 0;
  if (!hit.front) hit.Ng = -hit.Ng, hit.N = -hit.N;
  if (glm::dot(hit.N, V) <= 0) hit.N = hit.Ng;
  hit.material = scene.materials[material];
  return hit;
}

bool Twin::isBlocked(const TwinRay& ray, double end) const {
  const std::optional<TwinHit> hit = nearest(ray);
  return hit && hit->t < end;
}

TwinRay Twin::eyeRay(const dvec2& point, const TwinPath&) const {
  return cameraRay(point);
}
Material Twin::materialOf(const TwinHit& hit, const TwinPath&) const {
  return hit.material;
}
std::vector<Light> Twin::lightsOf(const TwinHit&, const TwinPath&) const {
  return scene.lights;
}
double Twin::visibility(const TwinHit& hit, const Light& light, const TwinPath&) const {
  return isBlocked(leave(hit, light.position - hit.point), 1) ? 0 : 1;
}
dvec3 Twin::reflected(const TwinHit& hit, const dvec3& direction, const TwinPath&) const {
  const dvec3 R = direction - 2 * glm::dot(direction, hit.N) * hit.N;
  return glm::dot(R, hit.Ng) > 0 ? R : direction - 2 * glm::dot(direction, hit.Ng) * hit.Ng;
}
std::optional<TwinRay> Twin::passOn(const TwinHit&, const TwinRay&, const TwinPath&) const {
  return std::nullopt;
}

dvec3 Twin::lit(const TwinHit& hit, const dvec3& V, const Light& light) const {
  const dvec3 toward = light.position - hit.point, L = glm::normalize(toward), H = glm::normalize(L + V);
  dvec3 E = light.color;
  if (light.falloff != Falloff::none) E /= glm::dot(toward, toward);
  const Material& m = hit.material;
  return E * (m.diffuse + m.specular * std::pow(std::max(0.0, glm::dot(hit.N, H)), m.shininess)) *
         std::max(0.0, glm::dot(hit.N, L));
}

dvec3 Twin::radiance(const TwinRay& ray, TwinPath path) const {
  std::optional<TwinHit> hit = nearest(ray);
  if (!hit) return scene.background;
  if (const std::optional<TwinRay> other = passOn(*hit, ray, path)) return radiance(*other, path);
  hit->material = materialOf(*hit, path);
  const Material& m = hit->material;
  const dvec3 direction = glm::normalize(ray.direction);
  dvec3 sum(0);
  for (const Light& light : lightsOf(*hit, path)) {
    const dvec3 L = light.position - hit->point;
    if (glm::dot(hit->N, L) <= 0 || glm::dot(hit->Ng, L) <= 0 || m.localWeight <= 0) continue;
    sum += m.localWeight * visibility(*hit, light, path) * lit(*hit, -direction, light);
  }
  if (!goesDeeper(path.level)) return sum;
  double r = m.reflect;
  const double t = m.transmit;
  TwinPath next = path;
  ++next.level;
  if (t > 0) {
    const double eta = hit->front ? m.eta : 1 / m.eta, cosine = -glm::dot(direction, hit->N);
    const double squared = eta * eta - 1 + cosine * cosine;
    if (squared <= 0)
      r += t;
    else
      sum += t * radiance(leave(*hit, glm::normalize(direction + (cosine - std::sqrt(squared)) * hit->N)), next);
  }
  if (r > 0) sum += r * radiance(leave(*hit, reflected(*hit, direction, path)), next);
  return sum;
}

dvec3 Twin::at(int x, int y, const dvec2& point) const {
  const TwinPath path{uint32_t(x), uint32_t(y), 1};
  return radiance(eyeRay(point, path), path);
}

TwinComparison compareWithTwin(const Image& picture, const Twin& twin, double edge) {
  constexpr double kStep = 1.0 / 512;
  std::vector<double> errors;
  const size_t pixels = picture.window.area();
  for (int y = 0; y < picture.window.height(); ++y)
    for (int x = 0; x < picture.window.width(); ++x) {
      const dvec2 middle(x + 0.5, y + 0.5);
      const dvec3 truth = twin.at(x, y, middle);
      bool isEdge = false;
      for (const dvec2& step : {dvec2(kStep, 0), dvec2(-kStep, 0), dvec2(0, kStep), dvec2(0, -kStep)}) {
        const dvec3 change = glm::abs(twin.at(x, y, middle + step) - truth);
        isEdge |= std::max({change.x, change.y, change.z}) > edge;
      }
      if (isEdge) continue;
      const float* const rgb = &picture.rgb[3 * (size_t(y) * size_t(picture.window.width()) + size_t(x))];
      double error = 0;
      for (int c = 0; c < 3; ++c) {
        const double difference = std::abs(double(rgb[c]) - truth[c]);
        error = std::isfinite(difference) ? std::max(error, difference) : std::numeric_limits<double>::infinity();
      }
      errors.push_back(error);
    }
  std::sort(errors.begin(), errors.end());
  TwinComparison result;
  if (errors.empty()) return result;
  result.offEdges = double(errors.size()) / double(pixels);
  result.p99 = errors[size_t(0.99 * double(errors.size() - 1))];
  result.max = errors.back();
  return result;
}

}  // namespace turner::test
