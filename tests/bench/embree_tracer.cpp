// Symbols as in docs/light_transport.md: V toward where the ray came from, L toward a light, H halfway between both, Ng
// the geometric and Ns the shading normal on V's side, R and T the reflected and the transmitted direction.
#include "bench/embree_tracer.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#ifdef __SSE3__
#include <pmmintrin.h>
#endif

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <thread>
#include <type_traits>
#include <vector>

#include "base/errors.h"
#include "image/camera_basis.h"

namespace turner::test {
namespace {

using glm::vec3;
using Clock = std::chrono::steady_clock;

constexpr unsigned kTriangles = 0, kSpheres = 1, kCones = 2;  // the geometries' numbers in Embree's scene
constexpr int kBlock = 16;                                    // pixels to a side: what a thread takes at a time

float largest(const vec3& v) {
  return std::max({v.x, v.y, v.z});
}

// ---- Embree 3 and 4 differ in the arguments of their queries, and in nothing else that is used here ----

#if RTC_VERSION_MAJOR >= 4
void intersect(RTCScene scene, RTCRayHit& query) {
  rtcIntersect1(scene, &query, nullptr);
}
void occluded(RTCScene scene, RTCRay& query) {
  rtcOccluded1(scene, &query, nullptr);
}
#else
void intersect(RTCScene scene, RTCRayHit& query) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &query);
}
void occluded(RTCScene scene, RTCRay& query) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &query);
}
#endif

// ---- The scene ----

struct ReleaseDevice {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct ReleaseScene {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
struct ReleaseGeometry {
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
using DeviceHandle = std::unique_ptr<std::remove_pointer_t<RTCDevice>, ReleaseDevice>;
using SceneHandle = std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseScene>;
using GeometryHandle = std::unique_ptr<std::remove_pointer_t<RTCGeometry>, ReleaseGeometry>;

DeviceHandle openDevice() {
  DeviceHandle device(rtcNewDevice(nullptr));
  if (!device)
    throw RunError("Embree cannot start: rtcNewDevice failed with code " +
                   std::to_string(int(rtcGetDeviceError(nullptr))));
  return device;
}

void throwIfFailed(RTCDevice device, const char* call) {
  const RTCError error = rtcGetDeviceError(device);
  if (error != RTC_ERROR_NONE)
    throw RunError(std::string("Embree: ") + call + " failed with code " + std::to_string(int(error)));
}

template <class Element>
Element* newBuffer(RTCDevice device, RTCGeometry geometry, RTCBufferType type, RTCFormat format, size_t count) {
  void* buffer = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(Element), count);
  throwIfFailed(device, "rtcSetNewGeometryBuffer");
  return static_cast<Element*>(buffer);
}

void attach(RTCDevice device, RTCScene scene, RTCGeometry geometry, unsigned number) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, number);
  throwIfFailed(device, "rtcAttachGeometryByID");
}

// Three vertices for each triangle: Embree copies them into its leaves, so that sharing would make no ray faster.
void attachTriangles(RTCDevice device, RTCScene scene, const Scene& local) {
  const std::vector<Triangle>& triangles = local.triangles;
  if (triangles.empty()) return;
  const GeometryHandle geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
  using Corners = std::array<uint32_t, 3>;
  auto* vertex = newBuffer<std::array<float, 3>>(device, geometry.get(), RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3,
                                                 3 * triangles.size());
  auto* corners = newBuffer<Corners>(device, geometry.get(), RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, triangles.size());
  for (uint32_t i = 0; i < triangles.size(); ++i) {
    for (const glm::dvec3& v : local.cornersOf(i)) *vertex++ = {float(v.x), float(v.y), float(v.z)};
    corners[i] = {3 * i, 3 * i + 1, 3 * i + 2};
  }
  attach(device, scene, geometry.get(), kTriangles);
}

struct FloatMaterial {
  vec3 diffuse, specular;
  float shininess, reflect, transmit, eta, localWeight;
  bool shades;      // reflects light by itself, so that its lights are looked at
  bool highlights;  // k_s is not 0
};

struct FloatLight {
  vec3 position, color;
  bool inverseSquare;
};

struct FloatSphere {
  vec3 center;
  float radius;  // with its sign
  uint32_t material;
};

// Spheres by a test of our own, with the discriminant from the distance between centre and ray: up to 14 % faster on
// balls than RTC_GEOMETRY_TYPE_SPHERE_POINT, which makes the same picture. The ray's direction has length 1.
bool hitSphere(const RTCRay& ray, const FloatSphere& sphere, float& t) {
  const vec3 d(ray.dir_x, ray.dir_y, ray.dir_z);
  const vec3 toRay = vec3(ray.org_x, ray.org_y, ray.org_z) - sphere.center;
  const float b = -glm::dot(toRay, d);
  const vec3 perpendicular = toRay + b * d;
  const float discriminant = sphere.radius * sphere.radius - glm::dot(perpendicular, perpendicular);
  if (discriminant < 0) return false;
  const float root = std::sqrt(discriminant);
  t = b - root > 0 ? b - root : b + root;
  return t > 0 && t < ray.tfar;
}

struct FloatCone {
  vec3 base, axis;               // axis: unit
  float length, radius, growth;  // radius at the base; growth by a unit of height
  bool inward;
  uint32_t material;
};

FloatCone floatCone(const Cone& cone) {
  const glm::dvec3 way = cone.apex - cone.base;
  const double length = glm::length(way), radius = std::abs(cone.baseRadius);
  return {vec3(cone.base),
          vec3(way / length),
          float(length),
          float(radius),
          float((std::abs(cone.apexRadius) - radius) / length),
          cone.isInward(),
          cone.material};
}

// The quadratic of the textbooks, from where the ray is nearest to the base.
bool hitCone(const RTCRay& ray, const FloatCone& cone, float& t) {
  const vec3 d(ray.dir_x, ray.dir_y, ray.dir_z), toRay = vec3(ray.org_x, ray.org_y, ray.org_z) - cone.base;
  const float foot = -glm::dot(toRay, d);
  const vec3 p = toRay + foot * d;
  const float height = glm::dot(p, cone.axis), climb = glm::dot(d, cone.axis);
  const vec3 across = p - height * cone.axis, drift = d - climb * cone.axis;
  const float radius = cone.radius + cone.growth * height, growing = cone.growth * climb;
  const float a = glm::dot(drift, drift) - growing * growing, b = glm::dot(across, drift) - radius * growing,
              c = glm::dot(across, across) - radius * radius;
  const float discriminant = b * b - a * c;
  if (discriminant < 0) return false;
  const float root = std::sqrt(discriminant);
  float roots[2] = {(-b - root) / a, (-b + root) / a};
  if (a < 0) std::swap(roots[0], roots[1]);
  for (const float fromFoot : roots) {
    const float s = height + fromFoot * climb;
    t = foot + fromFoot;
    if (t > 0 && t < ray.tfar && s >= 0 && s <= cone.length && cone.radius + cone.growth * s >= 0) return true;
  }
  return false;
}

bool hit(const RTCRay& ray, const FloatSphere& sphere, float& t) {
  return hitSphere(ray, sphere, t);
}
bool hit(const RTCRay& ray, const FloatCone& cone, float& t) {
  return hitCone(ray, cone, t);
}

void bound(const FloatSphere& sphere, RTCBounds& bounds) {
  const vec3 lo = sphere.center - std::abs(sphere.radius), hi = sphere.center + std::abs(sphere.radius);
  bounds = {lo.x, lo.y, lo.z, 0, hi.x, hi.y, hi.z, 0};
}
void bound(const FloatCone& cone, RTCBounds& bounds) {
  // Of a circle: its radius times sqrt(1 - a_k^2); and a few roundings.
  const vec3 reach = glm::sqrt(glm::max(vec3(0), 1.0f - cone.axis * cone.axis)),
             apex = cone.base + cone.length * cone.axis;
  const float apexRadius = cone.radius + cone.growth * cone.length;
  const vec3 slack = 0x1p-20f * (glm::abs(cone.base) + cone.length + cone.radius + apexRadius);
  const vec3 lo = glm::min(cone.base - cone.radius * reach, apex - apexRadius * reach) - slack;
  const vec3 hi = glm::max(cone.base + cone.radius * reach, apex + apexRadius * reach) + slack;
  bounds = {lo.x, lo.y, lo.z, 0, hi.x, hi.y, hi.z, 0};
}

// Spheres and cones are geometry of ours. Embree hands a single ray over in the layout of RTCRayHit or RTCRay.
template <class Primitive>
const Primitive& primitiveOf(const void* primitives, unsigned number) {
  return static_cast<const Primitive*>(primitives)[number];
}

template <class Primitive>
void boundPrimitive(const RTCBoundsFunctionArguments* arguments) {
  bound(primitiveOf<Primitive>(arguments->geometryUserPtr, arguments->primID), *arguments->bounds_o);
}

template <class Primitive, unsigned kGeometry>
void intersectPrimitive(const RTCIntersectFunctionNArguments* arguments) {
  if (!arguments->valid[0]) return;
  auto& query = *reinterpret_cast<RTCRayHit*>(arguments->rayhit);
  float t;
  if (!hit(query.ray, primitiveOf<Primitive>(arguments->geometryUserPtr, arguments->primID), t)) return;
  query.ray.tfar = t;
  query.hit.geomID = kGeometry;
  query.hit.primID = arguments->primID;
}

template <class Primitive>
void occludeByPrimitive(const RTCOccludedFunctionNArguments* arguments) {
  if (!arguments->valid[0]) return;
  auto& ray = *reinterpret_cast<RTCRay*>(arguments->ray);
  float t;
  if (hit(ray, primitiveOf<Primitive>(arguments->geometryUserPtr, arguments->primID), t))
    ray.tfar = -std::numeric_limits<float>::infinity();
}

// `primitives` must outlive the scene.
template <class Primitive, unsigned kGeometry>
void attachPrimitives(RTCDevice device, RTCScene scene, std::vector<Primitive>& primitives) {
  if (primitives.empty()) return;
  const GeometryHandle geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER));
  rtcSetGeometryUserPrimitiveCount(geometry.get(), unsigned(primitives.size()));
  rtcSetGeometryUserData(geometry.get(), primitives.data());
  rtcSetGeometryBoundsFunction(geometry.get(), boundPrimitive<Primitive>, nullptr);
  rtcSetGeometryIntersectFunction(geometry.get(), intersectPrimitive<Primitive, kGeometry>);
  rtcSetGeometryOccludedFunction(geometry.get(), occludeByPrimitive<Primitive>);
  attach(device, scene, geometry.get(), kGeometry);
}

// What a triangle's number leads to besides its corners, which Embree has.
struct TriangleTags {
  uint32_t material, normals;
};

// What a ray's hit leads to, in float32.
struct Shading {
  explicit Shading(const Scene& local);

  vec3 background;
  std::vector<FloatMaterial> materials;
  std::vector<FloatLight> lights;
  std::vector<FloatSphere> spheres;
  std::vector<FloatCone> cones;
  std::vector<TriangleTags> triangles;
  std::vector<std::array<vec3, 3>> normals;
};

Shading::Shading(const Scene& local) : background(local.background) {
  for (const Material& m : local.materials) {
    FloatMaterial& material = materials.emplace_back();
    material = {vec3(m.diffuse),
                vec3(m.specular),
                float(m.shininess),
                float(m.reflect),
                float(m.transmit),
                float(m.eta),
                float(m.localWeight),
                false,
                false};
    material.highlights = largest(material.specular) > 0;
    material.shades = material.localWeight * std::max(largest(material.diffuse), largest(material.specular)) > 0;
  }
  for (const Light& light : local.lights)
    lights.push_back({vec3(light.position), vec3(light.color), light.falloff == Falloff::inverseSquare});
  spheres.reserve(local.spheres.size());
  for (const Sphere& sphere : local.spheres)
    spheres.push_back({vec3(sphere.center), float(sphere.radius), sphere.material});
  cones.reserve(local.cones.size());
  for (const Cone& cone : local.cones) cones.push_back(floatCone(cone));
  triangles.reserve(local.triangles.size());
  for (const Triangle& triangle : local.triangles) {
    triangles.push_back({triangle.material, triangle.isSmooth() ? uint32_t(normals.size()) : kNoNormals});
    if (!triangle.isSmooth()) continue;
    const auto [a, b, c] = local.normalsOf(triangle);
    normals.push_back({vec3(a), vec3(b), vec3(c)});
  }
}

// ---- One ray ----

struct Surface {
  vec3 point;
  vec3 Ng, Ns;   // unit, on V's side
  bool front;    // V is on the side that the surface's own normal points to
  float margin;  // how far along Ng a ray must start so as not to hit where it starts
  const FloatMaterial* material;
};

vec3 mirrored(const vec3& d, const vec3& N) {
  return d - 2 * glm::dot(d, N) * N;
}

// Snell's law; false on total internal reflection. `eta`: index on V's side over the other.
bool refracted(const vec3& d, const vec3& N, float eta, vec3& T) {
  const float cosV = -glm::dot(d, N);
  const float squaredCosT = 1 - eta * eta * (1 - cosV * cosV);
  if (squaredCosT <= 0) return false;
  T = glm::normalize(eta * d + (eta * cosV - std::sqrt(squaredCosT)) * N);
  return true;
}

// Traces the ray trees of one thread and counts their rays.
class Tracer {
 public:
  Tracer(RTCScene scene, const Shading& shading, int depth) : scene_(scene), shading_(shading), depth_(depth) {}

  // What comes back along a ray, which is of this level of its tree.
  vec3 radiance(const vec3& origin, const vec3& d, int level) {
    RTCRayHit query;
    query.ray.org_x = origin.x;
    query.ray.org_y = origin.y;
    query.ray.org_z = origin.z;
    query.ray.dir_x = d.x;
    query.ray.dir_y = d.y;
    query.ray.dir_z = d.z;
    query.ray.tnear = 0;
    query.ray.tfar = std::numeric_limits<float>::infinity();
    query.ray.time = 0;
    query.ray.mask = UINT32_MAX;
    query.ray.flags = 0;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    intersect(scene_, query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return shading_.background;

    const Surface surface = surfaceAt(query, origin, d);
    const FloatMaterial& material = *surface.material;
    vec3 sum(0);
    if (material.shades) sum = material.localWeight * localLight(surface, d);
    if (level >= depth_) return sum;

    // The share of T goes to R where nothing is transmitted.
    float r = material.reflect;
    if (material.transmit > 0) {
      vec3 T;
      const float eta = surface.front ? 1 / material.eta : material.eta;
      bool passes = refracted(d, surface.Ns, eta, T);
      if (passes && glm::dot(T, surface.Ng) >= 0) passes = refracted(d, surface.Ng, eta, T);
      if (passes) {
        ++counts.refracted;
        sum += material.transmit * radiance(surface.point - surface.margin * surface.Ng, T, level + 1);
      } else {
        r += material.transmit;
      }
    }
    if (r > 0) {
      vec3 R = mirrored(d, surface.Ns);
      if (glm::dot(R, surface.Ng) <= 0) R = mirrored(d, surface.Ng);
      ++counts.reflected;
      sum += r * radiance(surface.point + surface.margin * surface.Ng, R, level + 1);
    }
    return sum;
  }

  RayCounts counts;

 private:
  Surface surfaceAt(const RTCRayHit& query, const vec3& origin, const vec3& d) const {
    Surface surface;
    surface.point = origin + query.ray.tfar * d;
    if (query.hit.geomID == kSpheres) {
      const FloatSphere& sphere = shading_.spheres[query.hit.primID];
      const float radius = std::abs(sphere.radius);
      const vec3 outward = glm::normalize(surface.point - sphere.center);
      // Put the point back on the sphere: the error of o + t d grows with t.
      surface.point = sphere.center + radius * outward;
      surface.margin = 0x1p-20f * (largest(glm::abs(sphere.center)) + radius);
      surface.Ng = surface.Ns = sphere.radius < 0 ? -outward : outward;
      surface.material = &shading_.materials[sphere.material];
    } else if (query.hit.geomID == kCones) {
      const FloatCone& cone = shading_.cones[query.hit.primID];
      const vec3 p = surface.point - cone.base;
      const float height = glm::dot(p, cone.axis);
      const vec3 across = p - height * cone.axis;
      const float distance = glm::length(across);
      const vec3 outward = glm::normalize(across / distance - cone.growth * cone.axis);
      surface.point +=
          (cone.radius + cone.growth * height - distance) / std::sqrt(1 + cone.growth * cone.growth) * outward;
      surface.margin = 0x1p-20f * (largest(glm::abs(cone.base)) + cone.length + distance);
      surface.Ng = surface.Ns = cone.inward ? -outward : outward;
      surface.material = &shading_.materials[cone.material];
    } else {
      const TriangleTags& tags = shading_.triangles[query.hit.primID];
      surface.Ng = surface.Ns = glm::normalize(vec3(query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z));
      surface.margin = 0x1p-20f * (largest(glm::abs(surface.point)) + query.ray.tfar);
      surface.material = &shading_.materials[tags.material];
      if (tags.normals != kNoNormals) {
        const auto& [n0, n1, n2] = shading_.normals[tags.normals];
        const vec3 Ns = (1 - query.hit.u - query.hit.v) * n0 + query.hit.u * n1 + query.hit.v * n2;
        const float squared = glm::dot(Ns, Ns);
        if (squared > 0) surface.Ns = Ns / std::sqrt(squared);
        if (glm::dot(surface.Ng, surface.Ns) < 0) surface.Ng = -surface.Ng;
      }
    }
    surface.front = glm::dot(surface.Ng, d) < 0;
    if (!surface.front) {
      surface.Ng = -surface.Ng;
      surface.Ns = -surface.Ns;
    }
    if (glm::dot(surface.Ns, d) >= 0) surface.Ns = surface.Ng;
    return surface;
  }

  // The sum over the lights: E_i * vis_i * (k_d + k_s * max(0, N.H)^n) * N.L.
  vec3 localLight(const Surface& surface, const vec3& d) {
    const FloatMaterial& material = *surface.material;
    vec3 sum(0);
    for (const FloatLight& light : shading_.lights) {
      const vec3 toLight = light.position - surface.point;
      const float along = glm::dot(surface.Ns, toLight);
      if (along <= 0 || glm::dot(surface.Ng, toLight) <= 0) continue;
      ++counts.shadow;
      const float distance = glm::length(toLight), inverse = 1 / distance;
      const vec3 L = inverse * toLight;
      if (blocked(surface.point + surface.margin * surface.Ng, L, distance)) continue;

      vec3 brdf = material.diffuse;
      if (material.highlights) {
        const vec3 H = L - d;
        const float length = glm::length(H);
        if (length > 0)
          brdf += std::pow(std::max(0.0f, glm::dot(surface.Ns, H) / length), material.shininess) * material.specular;
      }
      const float E = light.inverseSquare ? inverse * inverse : 1;
      sum += (along * inverse * E) * light.color * brdf;
    }
    return sum;
  }

  // Whether anything lies on the way to a light, whose own end is open by a millionth.
  bool blocked(const vec3& start, const vec3& L, float distance) const {
    RTCRay query;
    query.org_x = start.x;
    query.org_y = start.y;
    query.org_z = start.z;
    query.dir_x = L.x;
    query.dir_y = L.y;
    query.dir_z = L.z;
    query.tnear = 0;
    query.tfar = distance * (1 - 0x1p-20f);
    query.time = 0;
    query.mask = UINT32_MAX;
    query.flags = 0;
    occluded(scene_, query);
    return query.tfar < 0;
  }

  RTCScene scene_;
  const Shading& shading_;
  int depth_;
};

// ---- All pixels ----

// The image plane at distance 1 from the eye, which is the origin.
struct ImagePlane {
  vec3 centre, perRight, perDown;  // the steps of one pixel
  float halfWidth, halfHeight;     // pixels

  ImagePlane(const Camera& camera, const RenderSettings& settings)
      : halfWidth(0.5f * float(settings.width)), halfHeight(0.5f * float(settings.height)) {
    const CameraBasis basis = cameraBasis(camera);
    const double pixel = 2 * basis.tanHalfFov / settings.height;
    centre = vec3(basis.forward);
    perRight = vec3(pixel * basis.right);
    perDown = vec3(-pixel * basis.up);
  }

  vec3 directionThroughCentre(int x, int y) const {
    return glm::normalize(centre + (float(x) + 0.5f - halfWidth) * perRight + (float(y) + 0.5f - halfHeight) * perDown);
  }
};

}  // namespace

struct EmbreeTracer::Parts {
  explicit Parts(const Scene& local) : camera(local.camera), shading(local), device(openDevice()) {
    // The monitor's sum right after the commit is what stays: buffers of the build are gone by then.
    rtcSetDeviceMemoryMonitorFunction(device.get(), countBytes, &bytes);
    scene.reset(rtcNewScene(device.get()));
    throwIfFailed(device.get(), "rtcNewScene");
    attachTriangles(device.get(), scene.get(), local);
    attachPrimitives<FloatSphere, kSpheres>(device.get(), scene.get(), shading.spheres);
    attachPrimitives<FloatCone, kCones>(device.get(), scene.get(), shading.cones);
    const Clock::time_point start = Clock::now();
    rtcCommitScene(scene.get());
    commitSeconds = std::chrono::duration<double>(Clock::now() - start).count();
    throwIfFailed(device.get(), "rtcCommitScene");
  }

  static bool countBytes(void* sum, ssize_t change, bool) {
    *static_cast<std::atomic<std::ptrdiff_t>*>(sum) += change;
    return true;
  }

  Camera camera;
  std::atomic<std::ptrdiff_t> bytes{0};  // outlives the device, which counts to its end
  Shading shading;                       // Embree's scene reads its spheres and cones
  DeviceHandle device;
  SceneHandle scene;
  double commitSeconds = 0;
};

EmbreeTracer::EmbreeTracer(const Scene& local) : parts_(std::make_unique<Parts>(local)) {}
EmbreeTracer::~EmbreeTracer() = default;

double EmbreeTracer::commitSeconds() const {
  return parts_->commitSeconds;
}
size_t EmbreeTracer::bytes() const {
  return size_t(parts_->bytes.load()) + parts_->shading.spheres.size() * sizeof(FloatSphere) +
         parts_->shading.cones.size() * sizeof(FloatCone);
}

EmbreePicture EmbreeTracer::render(const RenderSettings& settings) const {
  if (settings.samples != 1 || settings.sampler != Sampler::grid || settings.minWeight != 0)
    throw InputError("the Embree tracer takes one sample in each pixel's centre and drops no ray by its weight");
  EmbreePicture picture;
  picture.image = Image(settings.width, settings.height, settings.crop);
  const Window& crop = settings.crop;
  const ImagePlane plane(parts_->camera, settings);
  const int across = (crop.width() + kBlock - 1) / kBlock, down = (crop.height() + kBlock - 1) / kBlock;
  std::atomic<int> next{0};

  const auto renderBlocks = [&](RayCounts& rays) {
#ifdef __SSE3__
    // As Embree's manual asks of every thread that traces.
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
#endif
    Tracer tracer(parts_->scene.get(), parts_->shading, settings.depth);
    for (int block = next++; block < across * down; block = next++) {
      const int x0 = crop.x0 + block % across * kBlock, y0 = crop.y0 + block / across * kBlock;
      for (int y = y0; y < std::min(y0 + kBlock, crop.y1); ++y)
        for (int x = x0; x < std::min(x0 + kBlock, crop.x1); ++x) {
          ++tracer.counts.eye;
          const vec3 color = tracer.radiance(vec3(0), plane.directionThroughCentre(x, y), 1);
          float* rgb = &picture.image.rgb[3 * (size_t(y - crop.y0) * size_t(crop.width()) + size_t(x - crop.x0))];
          for (int k = 0; k < 3; ++k) rgb[k] = color[k];
        }
    }
    rays = tracer.counts;
  };

  std::vector<RayCounts> raysOfThread(std::max(1u, std::thread::hardware_concurrency()));
  const Clock::time_point start = Clock::now();
  {
    std::vector<std::jthread> threads;
    for (RayCounts& rays : raysOfThread) threads.emplace_back(renderBlocks, std::ref(rays));
  }
  picture.traceSeconds = std::chrono::duration<double>(Clock::now() - start).count();
  for (const RayCounts& rays : raysOfThread) {
    picture.rays.eye += rays.eye;
    picture.rays.reflected += rays.reflected;
    picture.rays.refracted += rays.refracted;
    picture.rays.shadow += rays.shadow;
  }
  return picture;
}

std::string embreeVersion() {
  const auto version = long(rtcGetDeviceProperty(openDevice().get(), RTC_DEVICE_PROPERTY_VERSION));
  return std::to_string(version / 10000) + '.' + std::to_string(version / 100 % 100) + '.' +
         std::to_string(version % 100);
}

}  // namespace turner::test
